//! Source mesh and target mesh to the target with the source's texture or relief, following its shape.
//!
//! Both meshes get a [`Hierarchy`] of levels of half the vertices each. From the coarsest level on, every vertex of
//! the target is matched with a vertex of the source and a rotation, by what is on the geodesic fans around them and by
//! what the shape is there; then every vertex of the target takes the mean of what the patches around it say.
//!
//! # Reference
//! [MeshMatch 2012](crate::bibliography#meshmatch-2012).

mod collapse;
mod correspondences;
mod descriptors;
mod error;
mod field;
mod ground;
mod hierarchy;
mod levels;
mod masked;
mod params;
mod ready;
mod report;
pub mod shape;
mod stack;
mod start;
#[cfg(test)]
mod test_stacks;
mod transferred;
mod up;
mod values;
mod vote;

pub use correspondences::{CorrespondenceError, Correspondences, Pair, Side};
pub use error::TransferError;
pub use hierarchy::Hierarchy;
pub use params::{Last, MOST_VERTICES, Rotations, Shape, TransferParams};
pub use report::{AuditReport, LevelReport, TransferReport};
pub use transferred::Transferred;

use crate::mesh::TriMesh;
use crate::progress::{Clock, Progress};

use hierarchy::counts;
use levels::Levels;
use masked::Masks;
use ready::{Ready, checked};
use stack::Stack;
use start::Start;
use values::Values;

/// Levels end at about this many vertices.
const COARSEST: usize = 128;

/// What is on the source.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// The mesh.
    pub mesh: &'a TriMesh,
    /// #V intensities from 0 to 1, if colors are to be transferred.
    pub colors: Option<&'a [[f64; 3]]>,
    /// #V heights, in the mesh's unit, if relief is to be transferred.
    pub heights: Option<&'a [f64]>,
}

/// Puts what is on the source onto the target.
///
/// `map` may give for each vertex of the target the vertex of the source to start from. The same seed gives the same
/// result for any number of threads. `progress` is told the stages and levels.
///
/// # Errors
/// [`TransferError`] if a parameter is out of its range, a mesh has no area, there is nothing to be transferred, or the map
/// does not fit.
///
/// # Panics
/// If colors or heights are not one a vertex, or correspondences name vertices that are not there.
///
/// # Reference
/// [MeshMatch 2012](crate::bibliography#meshmatch-2012).
pub fn transfer(
    source: &Source,
    target: &TriMesh,
    map: Option<&[Option<u32>]>,
    params: &TransferParams,
    progress: &mut dyn FnMut(Progress),
) -> Result<Transferred, TransferError> {
    transferred(source, target, map, None, params, progress)
}

/// Spreads what is on the painted vertices (`painted`: #V) of a mesh over the others: what was painted stays. The texture keeps
/// its size, whatever `params.scale` says.
///
/// # Errors
/// As [`transfer`], and if nothing is painted, or everything.
///
/// # Panics
/// If colors, heights or marks are not one a vertex.
///
/// # Reference
/// [MeshMatch 2012](crate::bibliography#meshmatch-2012): texture by example.
pub fn spread(
    source: &Source,
    painted: &[bool],
    params: &TransferParams,
    progress: &mut dyn FnMut(Progress),
) -> Result<Transferred, TransferError> {
    let used = source.mesh.used_vertices();
    assert_marks(painted, &used);
    if !used
        .iter()
        .zip(painted)
        .any(|(used, painted)| *used && *painted)
    {
        return Err(TransferError::NothingPainted);
    }
    if !used
        .iter()
        .zip(painted)
        .any(|(used, painted)| *used && !painted)
    {
        return Err(TransferError::AllPainted);
    }
    let params = TransferParams {
        scale: 1.0,
        ..params.clone()
    };
    transferred(source, source.mesh, None, Some(painted), &params, progress)
}

fn assert_marks(painted: &[bool], used: &[bool]) {
    assert_eq!(painted.len(), used.len(), "one mark a vertex");
}

fn transferred(
    source: &Source,
    target: &TriMesh,
    map: Option<&[Option<u32>]>,
    painted: Option<&[bool]>,
    params: &TransferParams,
    progress: &mut dyn FnMut(Progress),
) -> Result<Transferred, TransferError> {
    values::assert_complete(source);
    params.check()?;
    values::check(source)?;
    start::check(map, source.mesh, target)?;
    let [of_source, of_target] =
        params.counts(checked(source.mesh, true)?, checked(target, false)?)?;
    let mut clock = Clock::new(progress);
    clock.begin("hierarchy");
    let target_counts = counts(of_target, COARSEST);
    let source_counts: Vec<usize> = (0..target_counts.len()).map(|k| of_source >> k).collect();
    let layered = |mesh: &TriMesh, counts: &[usize]| {
        let ready = Ready::new(mesh, counts[0]);
        let hierarchy = Hierarchy::new(&ready.surface, counts);
        (ready, hierarchy)
    };
    let ((source_ready, (mut from, source_standing)), (target_ready, (mut onto, target_standing))) =
        rayon::join(
            || layered(source.mesh, &source_counts),
            || layered(target, &target_counts),
        );
    let levels = from.levels.len().min(onto.levels.len());
    from.truncate(levels);
    onto.truncate(levels);
    clock.end("hierarchy");
    clock.begin("shape");
    let shapes = [
        shape::Shaped::new(&source_ready, &from, &source_standing),
        shape::Shaped::new(&target_ready, &onto, &target_standing),
    ];
    let levels = shapes.each_ref().map(|shaped| shaped.level);
    let [of_source, of_target] = shape::features(&shapes, params);
    clock.end("shape");
    clock.begin("fans");
    let (sources, targets) = rayon::join(
        || Stack::new(from, levels[0], of_source),
        || Stack::new(onto, levels[1], of_target),
    );
    let values = Values::new(source, &source_ready, &source_standing, &sources);
    let masks = painted.map(|painted| {
        Masks::new(
            painted,
            &source_ready,
            &source_standing,
            [&sources, &targets],
            &values,
        )
    });
    clock.end("fans");
    let start = Start::new(map, [&source_ready, &target_ready], &source_standing);
    let done = Levels {
        sources: &sources,
        targets: &targets,
        values: &values,
        masks: masks.as_ref(),
        params,
    }
    .run(&start, &mut clock);
    Ok(transferred::result(
        [&source_ready, &target_ready],
        &source_standing,
        [&sources, &targets],
        &values,
        done,
        params,
        clock.stages,
    ))
}

#[cfg(test)]
mod tests;
