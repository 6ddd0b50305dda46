//! What a fit is asked for.

use serde::{Deserialize, Serialize};

use super::BaseKind;

/// Which base surface to fit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BaseChoice {
    /// Every kind is fitted and the one with the best criterion is kept; see [`super::Candidate`].
    #[default]
    Auto,
    /// This kind, whatever the others would give.
    Kind(BaseKind),
    /// Free form, see [`super::smooth_form`]: the kinds are fitted for comparison only, as with `Auto`.
    FreeForm,
}

/// What is minimised over the heights of the vertices.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Loss {
    /// Tukey's biweight, (1 − (1 − u²)³)/6 of u = height / (4.685 · scale), constant for |u| ≥ 1:
    /// what is far off the surface does not count, however far. The constant gives 95 % efficiency
    /// for normal noise (Holland & Welsch 1977).
    #[default]
    Tukey,
    /// Plain sum of squared heights. Every stray piece pulls.
    LeastSquares,
}

/// How much each vertex counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Weighting {
    /// A third of the area of its triangles, so that the fit belongs to the surface and not to the
    /// scanner's sampling (a range grid is denser where the surface faces the scanner, a decimated
    /// mesh where the surface is curved). At most eight times the median: the stretched triangles
    /// across a depth jump are no surface.
    #[default]
    Area,
    /// All the same.
    Uniform,
}

/// Parameters of [`super::fit`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FitParams {
    /// Kind of surface. Default: chosen by the criterion.
    pub base: BaseChoice,
    /// What is minimised. Default: Tukey's biweight, because scans have stray pieces.
    pub loss: Loss,
    /// How much each vertex counts. Default: its area.
    pub weighting: Weighting,
    /// Scale of [`Loss::Tukey`]: standard deviation of the relief, in the scan's unit. Default
    /// `None`: estimated from the heights, 1.4826 times their median absolute deviation from their
    /// median, or a narrower estimate where only a minority of the vertices lies on the surface.
    pub scale: Option<f64>,
    /// Most reweightings (Tukey) or least-squares steps (`LeastSquares`) of the final fit to all
    /// vertices. Default 100; 5 to 30 is usual.
    pub max_iterations: usize,
    /// Number of random minimal subsets tried as starting values of each kind (RANSAC, Fischler &
    /// Bolles 1981). Default 400: with 45 % of the vertices on the surface, one subset of four in 25
    /// is free of others.
    pub starts: usize,
    /// Seed of these subsets. Default 0.
    pub seed: u32,
}

impl Default for FitParams {
    fn default() -> Self {
        Self {
            base: BaseChoice::default(),
            loss: Loss::default(),
            weighting: Weighting::default(),
            scale: None,
            max_iterations: 100,
            starts: 400,
            seed: 0,
        }
    }
}
