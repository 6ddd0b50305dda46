//! What a completion is asked for.

use serde::Serialize;

use crate::base::{BaseChoice, FitParams};
use crate::sampling::SpacingRule;

use super::{CompletionError, HoleChoice, HoleLimits, Paint};

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
    /// Wavelength that tells form from relief where the base is free form, in the scan's unit. Default
    /// `None`: chosen from the relief, see [`crate::base::choose_wavelength`].
    pub form_wavelength: Option<f64>,
    /// Which holes to fill. Default: interior ones.
    pub holes: HoleChoice,
    /// How large they may be, if they are not chosen by number. Default: no limit.
    pub limits: HoleLimits,
    /// Where they are painted, if they are not chosen by number. Default: anywhere.
    pub paint: Option<Paint>,
    /// Pieces of surface with fewer vertices than this share of the largest piece's are strays: they are kept
    /// but nothing is fitted to them or copied from them. Default 0.01.
    pub stray: f64,
    /// Continue the scan over the rest of the base surface: of the sphere, of the cylinder's or
    /// cone's wall between the scan's ends, of the plane's bounding rectangle. Default: no.
    pub extend: bool,
    /// Window W: radius of a neighborhood in edges. Default `None`: chosen from the relief, see
    /// [`super::Chosen`]; by the paper's method 5, as in its experiments.
    pub window: Option<usize>,
    /// Number R of rotations about the normal. Default `None`: chosen from the relief; by the paper's
    /// method 4, as in its experiments.
    pub rotations: Option<u32>,
    /// Matches within (1 + tolerance) of the best are drawn from at random. Default 0.1
    /// (Efros & Leung 1999).
    pub tolerance: f64,
    /// Normalised cost above which a match is not accepted at first. Default `None`: chosen from the
    /// relief; by the paper's method 0.3 (Efros & Leung 1999).
    pub error_threshold: Option<f64>,
    /// μ in (1 − μ)·shape + μ·colour, in [0, 1]. Default `None`: chosen from the relief and its colours;
    /// by the paper's method 0.5. Always 0 for a scan without colours.
    pub mu: Option<f64>,
    /// Distance of new vertices. Default `None`: robust Nyquist.
    pub spacing: Option<SpacingRule>,
    /// Completed vertices become samples after each front. Default: no.
    pub bootstrap: bool,
    /// How matches are found. Default: coherent search.
    pub method: Method,
    /// Patches copied from different places are fitted together, and to the scan: heights give way, so
    /// that each new vertex keeps the shape of its source. Not by the paper's method. Default `None`: on relief
    /// that hardly changes from vertex to vertex, where seams would show; rough relief would become higher.
    pub blend: Option<bool>,
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
            form_wavelength: None,
            holes: HoleChoice::default(),
            limits: HoleLimits::default(),
            paint: None,
            stray: 0.01,
            extend: false,
            window: None,
            rotations: None,
            tolerance: 0.1,
            error_threshold: None,
            mu: None,
            spacing: None,
            bootstrap: false,
            method: Method::default(),
            blend: None,
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
            Some(SpacingRule::Length(length)) => length,
            _ => 1.0,
        };
        let rules = [
            (
                "--window",
                "from 1 to 50",
                self.window.unwrap_or(1) as f64,
                self.window.is_none_or(|window| (1..=50).contains(&window)),
            ),
            (
                "--rotations",
                "from 1 to 360",
                f64::from(self.rotations.unwrap_or(1)),
                (self.rotations).is_none_or(|rotations| (1..=360).contains(&rotations)),
            ),
            (
                "--form-wavelength",
                "a positive length",
                self.form_wavelength.unwrap_or(1.0),
                (self.form_wavelength).is_none_or(|length| length > 0.0 && length.is_finite()),
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
                self.error_threshold.unwrap_or(1.0),
                self.error_threshold.is_none_or(|threshold| threshold > 0.0),
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
            (
                "--stray",
                "from 0 to 1",
                self.stray,
                (0.0..=1.0).contains(&self.stray),
            ),
            ("--sites", "1 or more", self.sites as f64, self.sites >= 1),
            (
                "--spacing",
                "a positive length",
                spacing,
                spacing > 0.0 && spacing.is_finite(),
            ),
        ];
        if self.fit.base == BaseChoice::FreeForm && self.method == Method::Paper {
            return Err(CompletionError::FreeFormByPaper);
        }
        if self.fit.base == BaseChoice::FreeForm && self.extend {
            return Err(CompletionError::FreeFormHasNoEnd);
        }
        if matches!(self.holes, HoleChoice::Ids(_)) && !self.holes_are_anywhere() {
            return Err(CompletionError::NumbersAndLimits);
        }
        match rules.into_iter().find(|rule| !rule.3) {
            Some((name, range, value, _)) => Err(CompletionError::Parameter { name, range, value }),
            None => Ok(()),
        }
    }

    /// Whether neither size nor paint limits which holes are filled.
    fn holes_are_anywhere(&self) -> bool {
        self.limits == HoleLimits::default() && self.paint.is_none()
    }
}
