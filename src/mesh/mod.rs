//! Shared ground: a triangle mesh, its adjacency, boundary loops, normals, components and the
//! check of its invariants.
//!
//! A mesh may be dirty (open, non-manifold, inconsistently oriented): everything here copes with
//! that and says what it met; nothing here repairs.

mod adjacency;
mod bisected;
mod boundary;
mod check;
mod closest;
mod disjoint_sets;
mod geometry;
mod joined;
mod laplacian;
mod lookup;
mod nearest;
mod point_triangle;
mod spatial;

pub use adjacency::{Adjacency, Csr};
pub use bisected::{Bisected, bisected};
pub use boundary::{BoundaryLoop, LoopKind, boundary_loops, smoothed_positions, vector_area};
pub use check::{MeshDefect, check};
pub use closest::ClosestPoints;
pub(crate) use disjoint_sets::DisjointSets;
pub use geometry::{
    bounding_diagonal, edge_lengths, edges, euler_characteristic, gradients, median_edge,
    seam_normals, surface_area, triangle_area, triangle_normal, turned_tangent, vertex_areas,
    vertex_normals,
};
pub(crate) use joined::{ALONE, opposite_half_edges};
pub use laplacian::{Factor, IntrinsicTriangle, Laplacian};
pub use lookup::{SurfaceLookup, SurfacePlace};
pub use nearest::{Nearest, PointTree};
pub(crate) use point_triangle::PreparedTriangle;
pub(crate) use spatial::first_at_place;
pub use spatial::spatial_order;

use nalgebra::{Point3, Vector3};

/// A triangle mesh: positions (#V by 3, in the scan's unit) and triangles (#F by 3, indices of
/// vertices, counterclockwise as seen from outside).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriMesh {
    /// #V points.
    pub positions: Vec<Point3<f64>>,
    /// #F triples of vertex indices.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// The corners of triangle `f`.
    #[must_use]
    pub fn corners(&self, f: usize) -> [Point3<f64>; 3] {
        self.triangles[f].map(|v| self.positions[v as usize])
    }

    /// Centroid of all positions that a triangle uses; the origin if there is none.
    #[must_use]
    pub fn centroid(&self) -> Point3<f64> {
        let used = self.used_vertices();
        let mut sum = Vector3::zeros();
        let mut count = 0.0;
        for (p, _) in self.positions.iter().zip(&used).filter(|(_, used)| **used) {
            sum += p.coords;
            count += 1.0;
        }
        if count == 0.0 {
            Point3::origin()
        } else {
            Point3::from(sum / count)
        }
    }

    /// The same mesh around its centroid, and the centroid: large offsets (national grids) would cost
    /// precision.
    #[must_use]
    pub fn centered(mut self) -> (Self, Vector3<f64>) {
        let origin = self.centroid().coords;
        for p in &mut self.positions {
            *p -= origin;
        }
        (self, origin)
    }

    /// For each vertex, whether a triangle uses it.
    #[must_use]
    pub fn used_vertices(&self) -> Vec<bool> {
        let mut used = vec![false; self.positions.len()];
        for v in self.triangles.iter().flatten() {
            used[*v as usize] = true;
        }
        used
    }
}
