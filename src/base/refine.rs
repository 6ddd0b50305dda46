//! From a start to the minimum of the loss.

use rayon::prelude::*;

use super::model::{Model, least_squares, model};
use super::params::Loss;
use super::robust::{spread, tukey_weight};
use super::samples::Samples;
use super::{BaseSurface, StopReason};

/// Heights below this, in half diagonals, are rounding.
const ROUNDING: f64 = 1e-13;

/// Most reweightings while the scale is still being estimated.
const MAX_RESCALINGS: usize = 20;

/// The scale counts as found when a reweighting changes it by less than this share.
const SCALE_TOLERANCE: f64 = 1e-3;

/// Scale, in half widths of the shortest interval with [`super::robust::LEAST_SHARE`], at which not
/// much more than that share counts: the concentration steps of Rousseeuw & Van Driessen 1999. They
/// walk away from surroundings that cross the surface at a slant.
const CONCENTRATION: f64 = 0.4;

/// Least-squares steps between two reweightings; one is nearly enough near the minimum.
const INNER_STEPS: usize = 5;

/// Heights that are worth a task of their own.
const LEAST_TASK: usize = 10_000;

/// How far to go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Most reweightings or least-squares steps.
    pub(super) iterations: usize,
    /// Largest change of any height, in half diagonals, that counts as none.
    pub(super) tolerance: f64,
    /// Reweightings at the beginning in which only a core of the heights counts, whether or not it
    /// stands out yet.
    pub(super) concentrations: usize,
}

/// A surface at (or near) the minimum of the loss.
#[derive(Debug, Clone)]
pub(super) struct Refined {
    pub(super) surface: BaseSurface,
    /// Robust standard deviation of the heights.
    pub(super) sigma: f64,
    pub(super) iterations: usize,
    pub(super) reason: StopReason,
}

/// Minimises the loss of the heights from `start`.
pub(super) fn refine(
    start: &BaseSurface,
    samples: &Samples,
    loss: Loss,
    fixed_sigma: Option<f64>,
    effort: Effort,
) -> Refined {
    let mut model = model(start);
    match loss {
        Loss::LeastSquares => plain(model.as_mut(), samples, effort),
        Loss::Tukey => Reweighting {
            model: model.as_mut(),
            samples,
            heights: Vec::new(),
            weights: Vec::new(),
            sigma: f64::INFINITY,
        }
        .run(fixed_sigma, effort),
    }
}

fn plain(model: &mut dyn Model, samples: &Samples, effort: Effort) -> Refined {
    // The sum of squares is flat at its minimum: its tolerance is finer than that of the heights.
    let tolerance = (1e-3 * effort.tolerance).max(4.0 * f64::EPSILON);
    let weights = &samples.weights;
    let (iterations, reason) = least_squares(model, samples, weights, tolerance, effort.iterations);
    let surface = model.surface();
    Refined {
        sigma: spread(&samples.heights(&surface), weights).sigma,
        surface,
        iterations,
        reason,
    }
}

/// Iteratively reweighted least squares (Holland & Welsch 1977).
struct Reweighting<'a> {
    model: &'a mut dyn Model,
    samples: &'a Samples,
    heights: Vec<f64>,
    weights: Vec<f64>,
    sigma: f64,
}

impl Reweighting<'_> {
    /// First the scale is estimated anew from the heights each time, about the place where most of
    /// them are (a start may lie beside the surface by many times its noise). Then it stays, so
    /// that the rest minimises one function.
    fn run(mut self, fixed_sigma: Option<f64>, effort: Effort) -> Refined {
        self.measure();
        let mut iterations = 0;
        let mut reason = StopReason::IterationLimit;
        while iterations < effort.iterations.min(MAX_RESCALINGS) {
            let before = self.sigma;
            let found = spread(&self.heights, &self.samples.weights);
            self.sigma = found.sigma.max(fixed_sigma.unwrap_or(0.0)).max(ROUNDING);
            let settled = iterations >= effort.concentrations;
            if settled && (self.sigma - before).abs() <= SCALE_TOLERANCE * self.sigma {
                break;
            }
            if found.minority || iterations < effort.concentrations {
                self.step(found.core.0, (CONCENTRATION * found.core.1).max(ROUNDING));
            } else {
                self.step(found.center, self.sigma);
            }
            iterations += 1;
        }
        if let Some(sigma) = fixed_sigma {
            self.sigma = sigma.max(ROUNDING);
        }
        while iterations < effort.iterations {
            iterations += 1;
            let (change, step) = self.step(0.0, self.sigma);
            if step == StopReason::Numerical {
                reason = step;
                break;
            }
            if change <= effort.tolerance {
                reason = StopReason::Converged;
                break;
            }
        }
        Refined {
            surface: self.model.surface(),
            sigma: self.sigma,
            iterations,
            reason,
        }
    }

    /// Heights over the present surface; returns the largest change.
    fn measure(&mut self) -> f64 {
        let model = &*self.model;
        let new = self.samples.points.par_iter().with_min_len(LEAST_TASK);
        let new: Vec<f64> = new.map(|p| model.height(p)).collect();
        let change = (new.iter().zip(&self.heights)).fold(0.0, |m, (a, b)| (a - b).abs().max(m));
        self.heights = new;
        change
    }

    /// One reweighting about `center` with scale `sigma`; returns the largest change of a height.
    fn step(&mut self, center: f64, sigma: f64) -> (f64, StopReason) {
        self.weights.clear();
        let pairs = self.heights.iter().zip(&self.samples.weights);
        self.weights
            .extend(pairs.map(|(h, w)| w * tukey_weight(h - center, sigma)));
        let (_, reason) = least_squares(self.model, self.samples, &self.weights, 1e-6, INNER_STEPS);
        (self.measure(), reason)
    }
}
