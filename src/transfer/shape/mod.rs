//! What a surface's shape says of each of its vertices, so that places of two surfaces can be compared.

mod affinities;
mod eigenpairs;
mod geodesics;
mod heat_kernel;
mod krylov;
mod pieces;
#[cfg(test)]
pub(super) mod test_shapes;

pub use affinities::affinities;
pub use eigenpairs::{Eigenpairs, eigenpairs};
pub use geodesics::Geodesics;
pub use heat_kernel::heat_kernel_signatures;

use nalgebra::Vector3;

use crate::mesh::{TriMesh, surface_area, vertex_areas, vertex_normals};

use super::ground::single;
use super::hierarchy::Hierarchy;
use super::ready::Ready;
use super::{Pair, Shape, TransferParams};

/// Numbers that describe each vertex of a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Features {
    /// How many numbers a vertex has.
    pub count: usize,
    /// #V by `count`, row by row.
    pub values: Vec<f32>,
}

/// Features are found on the finest level of at most this many vertices: the solvers' time and memory grow faster than
/// their number, and shape changes slowly.
const MOST_VERTICES: usize = 70_000;

/// Heat that varies less than this share of its mean at all times says nothing of a shape: a sphere's varies by a thousandth,
/// with its triangles.
const LEAST_VARIATION: f32 = 0.01;

/// A level of a mesh whose shape is described.
#[derive(Debug)]
pub(super) struct Shaped<'a> {
    /// The level.
    pub(super) level: usize,
    mesh: &'a TriMesh,
    /// By vertex of the given mesh: which of the level's stands for it, or is nearest to it.
    standing: Vec<u32>,
}

impl<'a> Shaped<'a> {
    pub(super) fn new(ready: &Ready, hierarchy: &'a Hierarchy, standing: &[u32]) -> Self {
        let is_small = |mesh: &TriMesh| mesh.positions.len() <= MOST_VERTICES;
        let last = hierarchy.levels.len() - 1;
        let level = hierarchy.levels.iter().position(is_small).unwrap_or(last);
        let on_level = |v: &u32| {
            let finest = standing[*v as usize];
            (hierarchy.parents[..level].iter()).fold(finest, |v, parents| parents[v as usize])
        };
        Self {
            level,
            mesh: &hierarchy.levels[level],
            standing: ready.nearest().iter().map(on_level).collect(),
        }
    }
}

/// Features of source and target, as `params` ask for.
pub(super) fn features(shaped: &[Shaped; 2], params: &TransferParams) -> [Features; 2] {
    let meshes = shaped.each_ref().map(|shaped| shaped.mesh);
    let [source, target] = match &params.shape {
        Shape::HeatKernel => by_heat(meshes, params.seed),
        Shape::Affinities(pairs) => affinities(meshes[0], meshes[1], &on_levels(pairs, shaped)),
        Shape::Position => meshes.map(positions),
        Shape::None => meshes.map(|_| Features::default()),
    };
    let [of_source, of_target] = [0, 1].map(|i| upward(meshes[i], params.up[i]));
    // What is known of one side only cannot be compared.
    if of_source.count != of_target.count {
        return [source, target];
    }
    [joined(source, of_source), joined(target, of_target)]
}

/// Heat kernel signatures as ranks; nothing if one of the shapes is the same everywhere.
fn by_heat(meshes: [&TriMesh; 2], seed: u32) -> [Features; 2] {
    let of = |i: usize| heat_kernel_signatures(meshes[i], seed);
    let (source, target) = rayon::join(|| of(0), || of(1));
    let says_nothing = |features: &Features| {
        // The mean is 1 at every time.
        let largest = |k| features.values.iter().skip(k).step_by(features.count);
        (0..features.count).all(|k| {
            let deviation = largest(k).map(|h| f64::from(h - 1.0).powi(2)).sum::<f64>();
            let count = features.values.len() / features.count;
            deviation < f64::from(LEAST_VARIATION).powi(2) * count as f64
        })
    };
    if says_nothing(&source) || says_nothing(&target) {
        return [Features::default(), Features::default()];
    }
    [ranked(&source, meshes[0]), ranked(&target, meshes[1])]
}

/// The pairs, of vertices of the levels.
fn on_levels(pairs: &[Pair], [source, target]: &[Shaped; 2]) -> Vec<Pair> {
    let on_levels = |pair: &Pair| {
        let mut targets: Vec<u32> = (pair.targets.iter())
            .map(|t| target.standing[*t as usize])
            .collect();
        targets.sort_unstable();
        targets.dedup();
        Pair {
            source: source.standing[pair.source as usize],
            targets,
        }
    };
    pairs.iter().map(on_levels).collect()
}

/// Places in the box around the mesh's middle, in units of its size.
fn positions(mesh: &TriMesh) -> Features {
    let (center, size) = (mesh.centroid(), surface_area(mesh).sqrt());
    let places = mesh.positions.iter().map(|p| (p - center) / size);
    Features {
        count: 3,
        values: places.flat_map(|p| [p.x, p.y, p.z].map(single)).collect(),
    }
}

/// How far up each vertex looks.
fn upward(mesh: &TriMesh, up: Option<Vector3<f64>>) -> Features {
    let Some(up) = up.and_then(|up| up.try_normalize(0.0)) else {
        return Features::default();
    };
    Features {
        count: 1,
        values: (vertex_normals(mesh).iter())
            .map(|n| single(n.dot(&up)))
            .collect(),
    }
}

/// For each number the share of the surface where it is smaller: shapes that are alike but not the same have other numbers
/// in the same order.
fn ranked(features: &Features, mesh: &TriMesh) -> Features {
    let areas = vertex_areas(mesh);
    let total: f64 = areas.iter().sum();
    let count = features.count;
    let mut ranks = features.clone();
    let mut order: Vec<usize> = (0..areas.len()).collect();
    for k in 0..count {
        let value = |v: usize| features.values[v * count + k];
        order.sort_by(|a, b| value(*a).total_cmp(&value(*b)).then(a.cmp(b)));
        let mut below = 0.0;
        for v in &order {
            ranks.values[*v * count + k] = single((below + 0.5 * areas[*v]) / total);
            below += areas[*v];
        }
    }
    ranks
}

/// Both together.
fn joined(one: Features, other: Features) -> Features {
    if one.count == 0 {
        return other;
    }
    if other.count == 0 {
        return one;
    }
    let rows = (one.values.chunks_exact(one.count)).zip(other.values.chunks_exact(other.count));
    Features {
        count: one.count + other.count,
        values: rows.flat_map(|(a, b)| a.iter().chain(b).copied()).collect(),
    }
}

#[cfg(test)]
mod tests;
