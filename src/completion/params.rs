//! What a completion is asked for.

use serde::Serialize;

use crate::base::FitParams;
use crate::sampling::SpacingRule;

use super::CompletionError;

/// Which boundary loops to fill. Numbers are those of [`crate::mesh::boundary_loops`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HoleChoice {
    /// All gaps in the surface; outer rims stay open.
    #[default]
    Interior,
    /// Outer rims, too, where the base surface closes behind them (a sphere does, a plane does
    /// not).
    All,
    /// The hole with the largest estimated area.
    Largest,
    /// These, holes or rims.
    Ids(Vec<usize>),
}

/// Parameters of [`super::complete`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompleteParams {
    /// Base surface and how it is fitted. Default: kind chosen by the fit's criterion.
    pub fit: FitParams,
    /// Which holes to fill. Default: interior ones.
    pub holes: HoleChoice,
    /// Continue the scan over the rest of the base surface: of the sphere, of the cylinder's or
    /// cone's wall between the scan's ends, of the plane's bounding rectangle. Default: no.
    pub extend: bool,
    /// Window W: radius of a neighborhood in edges. Default 5, of the paper's experiments.
    pub window: usize,
    /// Number R of rotations about the normal. Default 4, of the paper's experiments.
    pub rotations: u32,
    /// Matches within (1 + tolerance) of the best are drawn from at random. Default 0.1
    /// (Efros & Leung 1999).
    pub tolerance: f64,
    /// Normalised cost above which a match is not accepted at first. Default 0.3
    /// (Efros & Leung 1999).
    pub error_threshold: f64,
    /// μ in (1 − μ)·shape + μ·colour, in [0, 1]. Default `None`: 0.5 for a scan with colours, else
    /// 0.
    pub mu: Option<f64>,
    /// Distance of new vertices. Default: robust Nyquist.
    pub spacing: SpacingRule,
    /// Completed vertices become samples after each front. Default: no.
    pub bootstrap: bool,
    /// Seed of the random picks. Default 0.
    pub seed: u32,
}

impl Default for CompleteParams {
    fn default() -> Self {
        Self {
            fit: FitParams::default(),
            holes: HoleChoice::default(),
            extend: false,
            window: 5,
            rotations: 4,
            tolerance: 0.1,
            error_threshold: 0.3,
            mu: None,
            spacing: SpacingRule::default(),
            bootstrap: false,
            seed: 0,
        }
    }
}

impl CompleteParams {
    /// Whether every parameter is in its range.
    ///
    /// # Errors
    /// [`CompletionError::Parameter`] for the first that is not.
    pub fn check(&self) -> Result<(), CompletionError> {
        let spacing = match self.spacing {
            SpacingRule::Length(length) => length,
            _ => 1.0,
        };
        let rules: [(&'static str, &'static str, f64, bool); 6] = [
            (
                "--window",
                "from 1 to 50",
                self.window as f64,
                (1..=50).contains(&self.window),
            ),
            (
                "--rotations",
                "from 1 to 360",
                f64::from(self.rotations),
                (1..=360).contains(&self.rotations),
            ),
            (
                "--tolerance",
                "0 or more",
                self.tolerance,
                self.tolerance >= 0.0,
            ),
            (
                "--error-threshold",
                "above 0",
                self.error_threshold,
                self.error_threshold > 0.0,
            ),
            (
                "--shape-weight",
                "from 0 to 1",
                self.mu.unwrap_or(0.0),
                self.mu.is_none_or(|mu| (0.0..=1.0).contains(&mu)),
            ),
            (
                "--spacing",
                "a positive length",
                spacing,
                spacing > 0.0 && spacing.is_finite(),
            ),
        ];
        match rules.into_iter().find(|rule| !rule.3) {
            Some((name, range, value, _)) => Err(CompletionError::Parameter { name, range, value }),
            None => Ok(()),
        }
    }
}
