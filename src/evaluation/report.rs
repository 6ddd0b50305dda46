//! What an evaluation found.

use serde::Serialize;

use crate::likeness::{ArealFigures, CopyIndex, Judgement, MeasureSummary, Scores, Summary};

use super::AgainstTruth;

/// How well a scan is completed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    /// The scan's median edge, in its unit: what distances are measured in.
    pub median_edge: f64,
    /// The largest of the measures of each hole, calibrated like a measure of its own.
    pub overall: Summary,
    /// Each measure over all holes.
    pub measures: Vec<MeasureSummary>,
    /// Hole by hole.
    pub repeats: Vec<Repeat>,
    /// Why other holes could not be filled.
    pub failed: Vec<String>,
}

/// What was cut out of the scan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HoleReport {
    /// Mean of the vertices that were cut out, in the scan's coordinates.
    pub center: [f64; 3],
    /// Number of vertices that were cut out.
    pub vertices: usize,
    /// Area of the faces that were cut out, in square units.
    pub area: f64,
}

/// What the judged heights are over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HeightsOver {
    /// The base surface of the completed scan.
    Completed,
    /// Completion has no heights over one base for all of the scan: over the base surface that comes
    /// nearest to the uncut scan, so that heights hold form as well as relief.
    Uncut,
}

/// One hole, completed and judged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Repeat {
    /// What was cut out.
    pub hole: HoleReport,
    /// Number of vertices that were added and judged.
    pub completed_vertices: usize,
    /// What the heights are over.
    pub heights_over: HeightsOver,
    /// Number of vertices that have no height over it and were left out.
    pub left_out: usize,
    /// Number of true pieces that figures were calibrated with.
    pub calibration_pieces: usize,
    /// Scores.
    pub judgement: Judgement,
    /// Figures of the known part.
    pub original: Option<ArealFigures>,
    /// Figures of the fill.
    pub completed: Option<ArealFigures>,
    /// Against what was cut out; nothing is ranked by it.
    pub against_truth: Option<AgainstTruth>,
    /// Correlation of the histograms of red, green and blue, original and completed.
    pub color_correlation: Option<[f64; 3]>,
    /// What was copied from where.
    pub copies: Option<CopyIndex>,
    /// Wall-clock seconds that completion took.
    pub seconds: f64,
}

impl Repeat {
    /// Sq of the fill over that of the known part.
    #[must_use]
    pub fn sq_ratio(&self) -> Option<f64> {
        Some(self.completed?.sq / self.original?.sq)
    }

    /// Sdq of the fill over that of the known part.
    #[must_use]
    pub fn sdq_ratio(&self) -> Option<f64> {
        Some(self.completed?.sdq / self.original?.sdq)
    }

    /// Distance from the truth over the known part's Sq.
    #[must_use]
    pub fn rmse_over_sq(&self) -> Option<f64> {
        Some(self.against_truth?.rmse / self.original?.sq)
    }
}

impl Evaluation {
    pub(super) fn new(median_edge: f64, repeats: Vec<Repeat>, failed: Vec<String>) -> Self {
        let judgements: Vec<&Judgement> = repeats.iter().map(|r| &r.judgement).collect();
        let Scores { overall, measures } = Scores::of(&judgements);
        Self {
            median_edge,
            overall,
            measures,
            repeats,
            failed,
        }
    }
}
