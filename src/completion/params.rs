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

/// How to find what a new vertex is copied from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Breckon & Fisher 2005, step by step: squared distances to the surface, over every sample of
    /// the oversampled surface and every rotation, one new vertex after the other.
    Paper,
    /// Differences of height and colour on a stencil, over every sample of the oversampled surface
    /// and every rotation (as many as the memory holds).
    Exhaustive,
    /// The same differences; what continues the neighbors' sources anywhere on the surface is
    /// preferred to the best of evenly spread sites.
    #[default]
    Coherent,
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
    /// How matches are found. Default: coherent search.
    pub method: Method,
    /// κ of coherent search: what continues a neighbor's source is taken unless another place costs
    /// less than 1/(1 + κ) of it (and at once, where it fits better than good matches do). Default 0.3.
    pub coherence: f64,
    /// Most sites at which coherent search looks all over the surface; beyond them, an even choice.
    /// Default 8192.
    pub sites: usize,
    /// Share of the new vertices that are also searched for exhaustively, so that the report can say how
    /// good the matches of coherent search are. Changes nothing else.
    /// Without `bootstrap` only. Default 0.
    pub audit: f64,
    /// Bytes that the tables of neighborhoods may take (exhaustive and coherent search): sites are
    /// thinned until they do not take more. Default 2 GiB.
    pub memory: usize,
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
            method: Method::default(),
            coherence: 0.3,
            sites: 8192,
            audit: 0.0,
            memory: 2 << 30,
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
        let rules = [
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
                "0 or more, at most 100",
                self.tolerance,
                (0.0..=100.0).contains(&self.tolerance),
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
                "--coherence",
                "0 or more",
                self.coherence,
                self.coherence >= 0.0 && self.coherence.is_finite(),
            ),
            (
                "--audit",
                "from 0 to 1",
                self.audit,
                (0.0..=1.0).contains(&self.audit),
            ),
            ("--sites", "1 or more", self.sites as f64, self.sites >= 1),
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
