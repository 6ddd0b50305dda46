//! What came of texturing.

use serde::Serialize;

/// What was done, and how well it fits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TextureReport {
    /// The levels, the finest first.
    pub levels: Vec<LevelReport>,
    /// Directions of the finest level.
    pub orientation: OrientationReport,
    /// Seconds that each stage took.
    pub stages: Vec<crate::progress::StageTime>,
}

/// What was done on a level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LevelReport {
    /// Number of vertices of the mesh.
    pub vertices: usize,
    /// Length of a texel on the mesh, in the scan's unit.
    pub texel: f64,
    /// Standard deviation of the edges' lengths over their mean.
    pub edge_variation: f64,
    /// Number of vertices or pixels of the sample that could be copied.
    pub sites: usize,
    /// Side of a neighborhood, in texels.
    pub window: usize,
    /// Side of its part on the next coarser level, in texels of that; 0 on the coarsest.
    pub coarse_window: usize,
    /// Mean cost of the matches: mean squared difference of two neighborhoods' values (colors from 0 to 1).
    pub mean_cost: f64,
    /// Share of the edges whose ends were copied from places as far from each other, in the same direction.
    pub coherent_edges: f64,
}

/// What came of the directions.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct OrientationReport {
    /// Rounds of relaxation.
    pub rounds: usize,
    /// Mean over the edges of sin²(n/2 · angle between their ends' directions), 0 where all agree, 1/2 where none do.
    pub error: f64,
    /// Where the directions turn around a point, as they must on all closed surfaces but the torus.
    pub singularities: Vec<Singularity>,
}

/// A point that the directions turn around.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Singularity {
    /// The triangle of the textured mesh that it is in.
    pub triangle: u32,
    /// Its centre, in the scan's coordinates.
    pub position: [f64; 3],
    /// Turns counterclockwise on a way around it. On a closed mesh the sum of all is the Euler characteristic.
    pub turns: f64,
}
