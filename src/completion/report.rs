//! What a completion did.

use serde::Serialize;

use crate::base::{BaseSurface, FitReport};
use crate::sampling::EdgeSpacing;

/// What [`super::complete`] did. Lengths are in the scan's unit.
#[derive(Debug, Clone, Serialize)]
pub struct CompletionReport {
    /// The base surface of the whole scan.
    pub fit: FitReport,
    /// Whether it fits the whole scan; if not, each hole has a base surface of its own, and the
    /// heights of original vertices are not known (NaN).
    pub base_fits: bool,
    /// Edge lengths and the spacing of new vertices.
    pub spacing: EdgeSpacing,
    /// Loops filled, in the order of their numbers.
    pub filled: Vec<FilledHole>,
    /// Loops that were chosen but could not be filled.
    pub skipped: Vec<SkippedHole>,
    /// Vertices and faces before and after, samples searched, and the like.
    pub counts: Counts,
    /// Wall-clock seconds by stage, in order.
    pub seconds: Vec<StageTime>,
}

/// Sizes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Vertices of the input.
    pub original_vertices: usize,
    /// Faces of the input.
    pub original_faces: usize,
    /// Vertices added.
    pub completed_vertices: usize,
    /// Faces added.
    pub completed_faces: usize,
    /// Sample vertices searched, after subdivision (of the scan's own base surface).
    pub samples: usize,
    /// Boundary loops of the input.
    pub loops: usize,
    /// Outer rims among them that were not chosen.
    pub rims_left: usize,
}

/// A gap that was filled.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FilledHole {
    /// Numbers of the boundary loops around it.
    pub loops: Vec<usize>,
    /// New vertices.
    pub vertices: usize,
    /// New faces.
    pub faces: usize,
    /// Mean normalised cost of the matches, in [0, 1]; 0 where no vertex was needed.
    pub mean_cost: f64,
    /// Largest.
    pub worst_cost: f64,
    /// Its own base surface, where it does not lie on the scan's.
    pub own_base: Option<BaseSurface>,
}

/// A gap that was not filled.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SkippedHole {
    /// Numbers of the boundary loops around it.
    pub loops: Vec<usize>,
    /// Why, in words.
    pub reason: String,
}

/// Time of a stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageTime {
    /// Name of the stage.
    pub stage: &'static str,
    /// Wall-clock seconds.
    pub seconds: f64,
}
