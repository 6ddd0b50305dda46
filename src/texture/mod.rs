//! A sample of texture and a mesh to a mesh with that texture all over it, without seams and without a global
//! parameterization.
//!
//! The mesh is [`retile`]d: its vertices stand for texels, on levels of a quarter of the vertices each. The sample, an
//! image or a scanned surface, becomes levels of half the resolution each. Every vertex gets a direction for the
//! texture's first axis. From the coarsest level on, the neighborhood of each vertex is compared with those of the
//! sample, and the vertex copies the texel whose neighborhood is most alike.
//!
//! # Reference
//! [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001).

mod canvas;
mod coherent;
mod descriptors;
mod directions;
mod error;
mod level;
mod orientation;
mod paint;
mod params;
mod pyramid;
mod report;
mod retile;
mod sample;
mod sites;
mod textured;
mod waves;
mod wei_levoy;
#[cfg(test)]
mod tests;

pub use error::TextureError;
pub use params::{Density, MOST_VERTICES, Method, Orientation, Search, TextureParams};
pub use report::{LevelReport, OrientationReport, Singularity, TextureReport};
pub use retile::{OnTriangle, RetileReport, Retiled, retile};
pub use sample::Sample;
pub use textured::{DIRECTION, Lookup, Textured};

use nalgebra::{Point3, Vector3};

use crate::mesh::{TriMesh, surface_area};
use crate::progress::{Clock, Progress};
use crate::rng::{Rng, Stage};

use canvas::CanvasLevel;
use directions::directions;
use paint::paint;
use pyramid::Pyramid;

/// Puts the texture of a sample all over a mesh of any topology.
///
/// The result's mesh is of the same surface, with vertices spread evenly; a mesh that has the wanted number of vertices
/// and is even already stays as it is. The same seed gives the same result for any number of threads. `progress` is
/// told the levels.
///
/// # Errors
/// [`TextureError`] if a parameter is out of its range, the mesh has no area, or the sample is too small or too large.
///
/// # Reference
/// [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001), §3.
pub fn synthesize(
    mesh: &TriMesh,
    sample: &Sample,
    params: &TextureParams,
    progress: &mut dyn FnMut(Progress),
) -> Result<Textured, TextureError> {
    params.check()?;
    if mesh.triangles.is_empty() {
        return Err(TextureError::NoFaces);
    }
    let mut clock = Clock::new(progress);
    let given = mesh;
    let (mesh, origin) = given.clone().centered();
    let area = surface_area(&mesh);
    if !(area > 0.0 && area.is_finite()) {
        return Err(TextureError::NoArea);
    }
    let used = mesh.used_vertices().iter().filter(|used| **used).count();
    let vertices = params.vertices(used, area, sample.texel())?;
    let mut rng = Rng::new(params.seed, Stage::Texture, 0);
    clock.begin("sample");
    let pyramid = Pyramid::new(
        sample,
        params.method,
        levels(params, sample, vertices),
        &mut rng,
    )?;
    clock.end("sample");
    clock.begin("retiling");
    let counts: Vec<usize> = (0..pyramid.levels.len())
        .map(|k| vertices >> (2 * k))
        .collect();
    let retiled = tiles(&mesh, &counts);
    clock.end("retiling");
    clock.begin("directions");
    let meshes: Vec<&TriMesh> = retiled.iter().map(|level| &level.mesh).collect();
    let orientation = params.orientation.around(&origin);
    let (directions, mut orientation) =
        directions(&meshes, &orientation, params.symmetry, &mut rng);
    clock.end("directions");
    let finest = retiled[0].mesh.clone();
    let canvas: Vec<CanvasLevel> = (retiled.into_iter().zip(directions))
        .map(|(level, directions)| CanvasLevel::new(level, directions))
        .collect();
    let (painted, levels) = paint(&pyramid, &canvas, params, &mut rng, &mut clock);
    for singularity in &mut orientation.singularities {
        let moved = Point3::from(singularity.position) + origin;
        singularity.position = moved.coords.into();
    }
    let report = TextureReport {
        levels,
        orientation,
        stages: clock.stages,
    };
    let directions = canvas.into_iter().next().map(|level| level.directions);
    // What stays as it is does so to the last bit.
    let mesh = if finest == mesh {
        given.clone()
    } else {
        moved(finest, &origin)
    };
    let level = &pyramid.levels[0];
    Ok(Textured {
        mesh,
        colors: sample.colors_of(&painted.values),
        heights: sample.heights_of(&painted.values, report.levels[0].texel),
        sources: (painted.sources.iter())
            .map(|place| level.origins[level.nearest(place) as usize])
            .collect(),
        costs: painted.costs,
        directions: directions.unwrap_or_default(),
        report,
    })
}

/// The most levels to try.
fn levels(params: &TextureParams, sample: &Sample, vertices: usize) -> usize {
    /// A level of fewer vertices is no surface any more.
    const LEAST_VERTICES: usize = 48;
    let of_mesh = (0..)
        .take_while(|k| vertices >> (2 * k) >= LEAST_VERTICES)
        .count();
    let wanted = params.levels.unwrap_or(match params.method {
        Method::WeiLevoy => 4,
        Method::Coherent => sample.levels(),
    });
    wanted.clamp(1, of_mesh.max(1))
}

/// The meshes of all levels: of the finest one the mesh itself if it is as wanted.
fn tiles(mesh: &TriMesh, counts: &[usize]) -> Vec<Retiled> {
    if mesh.positions.len() == counts[0]
        && let Some(same) = Retiled::unchanged(mesh)
    {
        let mut all = vec![same];
        if counts.len() > 1 {
            all.extend(retile(mesh, &counts[1..]));
        }
        return all;
    }
    retile(mesh, counts)
}

fn moved(mut mesh: TriMesh, by: &Vector3<f64>) -> TriMesh {
    for p in &mut mesh.positions {
        *p += by;
    }
    mesh
}
