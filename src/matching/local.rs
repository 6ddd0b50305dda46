//! Search around a match: at random, and down the slope of its cost. Matches are moved, not turned: the
//! rotations that a search tries are for its caller to say, and relief with a direction would be bent.
//!
//! # Reference
//! [PatchMatch 2009](crate::bibliography#patchmatch-2009), §3.2, for random search in shrinking radii;
//! [Lucas & Kanade 1981](crate::bibliography#lucas--kanade-1981) for the way down by least squares.

use std::ops::Range;

use nalgebra::{Matrix2, Vector2};

use crate::neighborhood::{View, Walker};
use crate::rng::Rng;

use super::query::{Found, Linearized, Query};

/// Matches are moved by multiples of this share of the stencil's spacing.
const GRID: f64 = 1.0 / 32.0;
/// Share of the mean curvature that is added to each: keeps flat directions from being overstepped.
const DAMPING: f64 = 1e-3;
/// Of several matches this many are followed down, those that promise most.
const FOLLOWED: usize = 3;
/// More steps hardly ever find anything cheaper.
const MOST_STEPS: usize = 3;
/// A step that gains a smaller share of the cost is the last.
const LEAST_GAIN: f32 = 0.02;

/// Random search: `tries` places within a radius, then within half of it, and so on, for radii from
/// `radii.start` down to above `radii.end`. The match moves to every place that is cheaper.
pub fn look_around(
    view: &View,
    query: &Query,
    found: &mut Found,
    radii: &Range<f64>,
    tries: u32,
    rng: &mut Rng,
    walker: &mut Walker,
) {
    let halves = std::iter::successors(Some(radii.start), |radius| Some(0.5 * radius));
    for radius in halves.take_while(|radius| *radius > radii.end) {
        for _ in 0..tries {
            let (length, angle) = (
                radius * rng.uniform().sqrt(),
                std::f64::consts::TAU * rng.uniform(),
            );
            let way = Vector2::new(length * angle.cos(), length * angle.sin());
            let place = moved(view, found, &way);
            if let Some(place) = place
                && let Some(cost) = query.cost(walker, view, &place.place, found.cost)
                && cost < found.cost
            {
                *found = Found { cost, ..place };
            }
        }
    }
}

/// Moves a match to the least of its cost nearby, by Gauss–Newton steps.
pub fn polish(view: &View, query: &Query, found: &mut Found, walker: &mut Walker) {
    if let Some(slope) = Slope::at(view, query, *found, f32::INFINITY, walker) {
        *found = slope.follow(view, query, walker);
    }
}

/// The same for the few of the matches that promise most; the others are dropped.
pub fn polish_best(view: &View, query: &Query, matches: &mut Vec<Found>, walker: &mut Walker) {
    let mut slopes: Vec<Slope> = (matches.drain(..))
        .filter_map(|found| Slope::at(view, query, found, f32::INFINITY, walker))
        .collect();
    slopes.sort_by(|a, b| a.promise.total_cmp(&b.promise));
    slopes.truncate(FOLLOWED);
    matches.extend((slopes.into_iter()).map(|slope| slope.follow(view, query, walker)));
}

/// A match and the step that makes it cheapest, as far as its linearisation tells.
struct Slope {
    found: Found,
    /// Along the two axes of the frame.
    step: Vector2<f64>,
    /// Cost after the step, if the linearisation holds.
    promise: f64,
}

impl Slope {
    fn at(
        view: &View,
        query: &Query,
        found: Found,
        budget: f32,
        walker: &mut Walker,
    ) -> Option<Self> {
        let here = query.linearized(walker, view, &found.place, budget)?;
        let step = least_squares_step(&here, view.stencil.spacing()).unwrap_or_default();
        let change = 2.0 * here.gradient.dot(&step) + step.dot(&(here.curvature * step));
        Some(Self {
            found: Found {
                cost: here.cost,
                ..found
            },
            step,
            promise: f64::from(here.cost) + change,
        })
    }

    /// The match at the end of the way down, on a grid about where it began: rounding in the last digits
    /// of the input shall not show in the result.
    fn follow(mut self, view: &View, query: &Query, walker: &mut Walker) -> Found {
        let start = self.found;
        let mut way = Vector2::zeros();
        for _ in 0..MOST_STEPS {
            let next = moved(view, &self.found, &self.step)
                .and_then(|next| Self::at(view, query, next, self.found.cost, walker));
            let Some(next) = next else { break };
            let gain = self.found.cost - next.found.cost;
            way += self.step;
            self = next;
            if gain <= LEAST_GAIN * self.found.cost {
                break;
            }
        }
        let grid = GRID * view.stencil.spacing();
        let way = way.map(|x| (x / grid).round() * grid);
        let end = moved(view, &start, &way).and_then(|end| {
            let cost = query.cost(walker, view, &end.place, start.cost)?;
            Some(Found { cost, ..end })
        });
        end.unwrap_or(start)
    }
}

/// The step to the least of the linearised cost, at most a stencil spacing long; `None` where the cost
/// does not change.
fn least_squares_step(here: &Linearized, spacing: f64) -> Option<Vector2<f64>> {
    let damping = Matrix2::from_diagonal_element(DAMPING * here.curvature.trace() / 2.0);
    let step = -((here.curvature + damping).cholesky()?).solve(&here.gradient);
    Some(step / (step.norm() / spacing).max(1.0))
}

/// The match moved along the axes of its frame, in the scan's unit; its cost is not changed. `None` where
/// the surface ends.
fn moved(view: &View, found: &Found, step: &Vector2<f64>) -> Option<Found> {
    #[expect(clippy::cast_possible_truncation, reason = "places are single")]
    let place = (view.surface).walk(&found.place, [step.x as f32, step.y as f32])?;
    Some(Found { place, ..*found })
}
