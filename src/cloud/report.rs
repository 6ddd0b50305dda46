//! What was made of a cloud.

use serde::Serialize;

use crate::base::BaseKind;
use crate::mesh::{Adjacency, BoundaryLoop, LoopKind, TriMesh, boundary_loops};

/// By what the sides of the normals were told, in points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Orientation {
    /// Towards the sensor that saw them.
    pub sensor: usize,
    /// As the file's own normals.
    pub file: usize,
    /// As their neighbors: closed forms outwards, sheets to the positive side of an axis.
    pub propagated: usize,
}

/// How the points were joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(tag = "by", content = "base", rename_all = "lowercase")]
pub enum Joined {
    /// In the chart of a fitted base surface of this kind.
    Chart(BaseKind),
    /// By local stars.
    Local,
}

/// What [`super::triangulate`] did. Lengths are in the scan's unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CloudReport {
    /// Points of the scan.
    pub points: usize,
    /// Points at exactly the place of an earlier one.
    pub duplicates: usize,
    /// Stray points.
    pub outliers: usize,
    /// Median distance to the nearest neighbor, duplicates aside.
    pub spacing: f64,
    /// By what the sides of the normals were told.
    pub orientation: Orientation,
    /// How the points were joined.
    pub joined: Joined,
    /// Triangles made.
    pub triangles: usize,
    /// Pieces that hang together.
    pub pieces: usize,
    /// Boundary loops around gaps in the surface.
    pub holes: usize,
    /// Boundary loops where the surface ends.
    pub rims: usize,
    /// Points without a triangle that are neither duplicates nor stray.
    pub left_over: usize,
}

/// Holes, rims and pieces of a mesh.
pub(super) fn outline(mesh: &TriMesh) -> [usize; 3] {
    let adjacency = Adjacency::new(mesh);
    let loops = boundary_loops(mesh, &adjacency);
    let is_hole = |l: &&BoundaryLoop| l.kind == LoopKind::Hole;
    let holes = loops.iter().filter(is_hole).count();
    let unused = mesh.used_vertices().iter().filter(|used| !**used).count();
    let (_, components) = adjacency.components();
    [holes, loops.len() - holes, components - unused]
}
