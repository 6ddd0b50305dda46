//! What an evaluation is asked for.

use serde::Serialize;

use crate::completion::CompleteParams;

use super::EvaluationError;

/// What the holes are filled with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FillKind {
    /// The completion.
    #[default]
    Completed,
    /// The base surface alone, in colours blended from the rim: what a completion must beat.
    Smooth,
}

/// Parameters of [`super::evaluate`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EvaluationParams {
    /// Share of the scan's area that each hole takes. Default 0.04.
    pub hole: f64,
    /// Number of holes, each cut out of the whole scan. Default 3.
    pub repeat: usize,
    /// Number of true pieces that figures are calibrated with; more of them leave fewer
    /// chances unseen. Default 128.
    pub pieces: usize,
    /// What the holes are filled with. Default: the completion.
    pub fill: FillKind,
    /// How they are completed; which holes is not looked at.
    pub complete: CompleteParams,
    /// Seed of the places of holes and pieces. Default 0.
    pub seed: u32,
}

impl Default for EvaluationParams {
    fn default() -> Self {
        Self {
            hole: 0.04,
            repeat: 3,
            pieces: 128,
            fill: FillKind::default(),
            complete: CompleteParams::default(),
            seed: 0,
        }
    }
}

impl EvaluationParams {
    /// Checks the ranges; those of the completion are checked there.
    ///
    /// # Errors
    /// [`EvaluationError::Parameter`] or [`EvaluationError::Completion`].
    pub fn check(&self) -> Result<(), EvaluationError> {
        let parameter = |name, range, value| EvaluationError::Parameter { name, range, value };
        if !(self.hole > 0.0 && self.hole <= 0.25) {
            let range = "above 0 and at most 0.25";
            return Err(parameter("--hole", range, self.hole));
        }
        if self.repeat == 0 {
            return Err(parameter("--repeat", "at least 1", 0.0));
        }
        if self.pieces < 60 {
            let range = "at least 60: a 95 % quantile of fewer says little";
            return Err(parameter("--pieces", range, self.pieces as f64));
        }
        Ok(self.complete.check()?)
    }
}
