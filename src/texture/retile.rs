//! A mesh to meshes of the same surface whose vertices are spread evenly, each level with fewer.
//!
//! The input's own triangles are split where they are coarse; then edges are split, collapsed and flipped
//! and vertices relaxed (Botsch & Kobbelt, *A remeshing approach to multiresolution modeling*, 2004) until
//! as many vertices are left as asked for. A vertex never leaves the surface: it walks over the input's
//! triangles, so that it cannot come to the other side of a thin part, as the closest point would. Each
//! coarser level begins with the one before it.

mod ground;
mod half_edges;
mod level;
mod net;
mod passes;
mod rim;
mod start;
#[cfg(test)]
mod tests;

use crate::mesh::{TriMesh, edge_lengths, spatial_order};
use ground::Ground;
use half_edges::HalfEdges;
use level::wanted_length;
use net::Net;
use rim::Rim;
use start::Start;

/// A point of a mesh: a triangle and the barycentric coordinates in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnTriangle {
    /// The triangle.
    pub triangle: u32,
    /// Shares of its corners, at least 0, sum 1.
    pub weights: [f64; 3],
}

/// A mesh whose vertices are spread evenly over the surface of another.
#[derive(Debug, Clone)]
pub struct Retiled {
    /// The mesh; every vertex is on the surface that was retiled.
    pub mesh: TriMesh,
    /// #V: where on the mesh that was retiled each vertex is.
    pub places: Vec<OnTriangle>,
    /// How even it has become.
    pub report: RetileReport,
}

/// What came of retiling.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct RetileReport {
    /// Number of vertices.
    pub vertices: usize,
    /// Mean length of the edges, in the scan's unit.
    pub mean_edge: f64,
    /// Standard deviation of the edges' lengths over their mean.
    pub edge_variation: f64,
}

/// Most that the edges' lengths of a mesh may vary, in shares of their mean, to be taken as even.
const EVEN: f64 = 0.2;

/// … and share of the mean below which an edge is a needle's.
const SHORT: f64 = 0.25;

impl Retiled {
    /// The mesh itself, if its vertices are spread evenly and no retiling is needed to walk around each: `None` if not.
    pub(super) fn unchanged(mesh: &TriMesh) -> Option<Self> {
        let report = report(mesh);
        let shortest = edge_lengths(mesh).into_iter().fold(f64::INFINITY, f64::min);
        let is_even = report.edge_variation <= EVEN && shortest > SHORT * report.mean_edge;
        if !is_even || crate::mesh::check(mesh).is_err() {
            return None;
        }
        let mut places = vec![None; mesh.positions.len()];
        for (f, t) in (0u32..).zip(&mesh.triangles) {
            for (corner, v) in t.iter().enumerate() {
                let mut weights = [0.0; 3];
                weights[corner] = 1.0;
                places[*v as usize] = Some(OnTriangle {
                    triangle: f,
                    weights,
                });
            }
        }
        Some(Self {
            mesh: mesh.clone(),
            places: places.into_iter().collect::<Option<_>>()?,
            report,
        })
    }
}

/// How far an edge of the first mesh may be longer than wanted.
const START_LENGTH: f64 = 4.0 / 3.0;

/// One mesh for each number of vertices (descending), each of the same topology as `mesh`.
///
/// Every fan of triangles gets a vertex of its own where several meet in one; edges with more than two
/// triangles, or with two that are oriented against each other, are boundary. A component that cannot have
/// so few vertices without losing its topology, or turning a triangle over, keeps more; the report says how
/// many there are. The levels hold no more sharp edges than their vertices happen to lie on: what is thinner
/// than an edge is cut at its rim by up to about half of one.
///
/// # Panics
/// If there are 2³⁰ triangles or more, or a coordinate is not finite.
#[must_use]
pub fn retile(mesh: &TriMesh, vertices: &[usize]) -> Vec<Retiled> {
    let mut ground = Ground::new(mesh);
    let (edges, _) = HalfEdges::new(&ground.mesh().triangles);
    let (rims, on) = Rim::all(ground.mesh(), &edges);
    ground.rims = rims;
    let finest = vertices.first().copied().unwrap_or_default();
    let length = wanted_length(ground.area(), finest);
    let start = Start::new(&ground, edges, &on);
    let mut net = start.refined(START_LENGTH * length, finest);
    (vertices.iter())
        .map(|vertices| {
            net.bring_to(*vertices);
            retiled(&net)
        })
        .collect()
}

/// What has become of the input: vertices that are close to each other on the surface are close on the list.
fn retiled(net: &Net<'_>) -> Retiled {
    let mesh = net.mesh();
    let count = u32::try_from(mesh.positions.len()).expect("vertices are u32");
    let order = spatial_order(&mesh.positions, (0..count).collect());
    let mut numbers = vec![0; order.len()];
    for (number, v) in (0..count).zip(&order) {
        numbers[*v as usize] = number;
    }
    let place = |v: &u32| net.ground.on_input(&net.sites[*v as usize].place);
    let mesh = TriMesh {
        positions: order.iter().map(|v| mesh.positions[*v as usize]).collect(),
        triangles: (mesh.triangles.iter())
            .map(|t| t.map(|v| numbers[v as usize]))
            .collect(),
    };
    Retiled {
        places: order.iter().map(place).collect(),
        report: report(&mesh),
        mesh,
    }
}

fn report(mesh: &TriMesh) -> RetileReport {
    let lengths = edge_lengths(mesh);
    #[expect(clippy::cast_precision_loss, reason = "edges are below 2^32")]
    let count = lengths.len().max(1) as f64;
    let mean = lengths.iter().sum::<f64>() / count;
    let squares: f64 = lengths.iter().map(|l| (l - mean) * (l - mean)).sum();
    let edge_variation = if mean > 0.0 {
        (squares / count).sqrt() / mean
    } else {
        0.0
    };
    RetileReport {
        vertices: mesh.positions.len(),
        mean_edge: mean,
        edge_variation,
    }
}
