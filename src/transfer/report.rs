//! What was done.

use serde::Serialize;

use crate::progress::StageTime;

/// What a transfer did.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct TransferReport {
    /// Levels, from the finest to the coarsest.
    pub levels: Vec<LevelReport>,
    /// Seconds of the stages.
    pub stages: Vec<StageTime>,
}

/// How good matches are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct AuditReport {
    /// Vertices whose matches were compared.
    pub vertices: usize,
    /// Mean cost of their matches.
    pub mean_cost: f64,
    /// Mean cost of the best matches that there are.
    pub least_cost: f64,
}

/// What was done on a level.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct LevelReport {
    /// Vertices of the target.
    pub vertices: usize,
    /// Vertices of the source.
    pub source_vertices: usize,
    /// Share that colors or heights had in the comparison; the rest is the shape's.
    pub value_weight: f32,
    /// Mean cost of the matches after the last round: 1 is what vertices that have nothing to do with each other differ by.
    pub mean_cost: f64,
    /// Matches compared with the best of all, if that was asked for, on the finest level.
    pub audit: Option<AuditReport>,
    /// Share of the edges along which the source was copied in one piece.
    pub coherent_edges: f64,
}
