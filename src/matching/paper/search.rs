//! The paper's metric over every sample and every rotation.

use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::base::BaseSurface;

use super::query::{Neighbor, Query};
use super::samples::{SampleId, Samples, Site};

/// Samples that one task searches: enough to be worth a task, few enough to share a late best match.
const CHUNK: usize = 512;

/// How to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Number R of rotations about the normal, at multiples of 2π/R.
    pub rotations: u32,
    /// μ: share of colour in the cost, from 0 (shape alone) to 1 (colour alone).
    pub mu: f64,
    /// Matches that cost at most (1 + tolerance) times the best are returned.
    pub tolerance: f64,
}

/// A place to copy from: where, turned by how much, at what cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// The sample.
    pub sample: SampleId,
    /// Multiple of 2π/R by which the target's neighborhood is turned about the normal.
    pub rotation: u32,
    /// Normalised sum of squared differences, in [0, 1].
    pub cost: f64,
}

/// All matches within the tolerance of the best one, in the order of samples and rotations; empty if
/// no sample has all the neighbors that the target has.
///
/// The result does not depend on `likely` (samples to look at first, so that bad ones are dropped
/// earlier) nor on the number of threads: a candidate is dropped only once its partial sum exceeds
/// the tolerance of the best one so far, which the final best can only be below.
///
/// # Panics
/// If there are 2³² samples or more.
///
/// # Reference
/// [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), §3 and Appendix A.
#[must_use]
pub fn best_matches(
    samples: &Samples,
    query: &Query,
    search: &Search,
    likely: &[SampleId],
) -> Vec<Match> {
    let turned = TurnedQuery::new(samples, query, search);
    if query.neighbors().is_empty() {
        return Vec::new();
    }
    let budget = Budget::new(search.tolerance);
    for sample in likely {
        for rotation in 0..turned.rotations.len() {
            budget.offer(turned.cost(*sample, rotation, budget.get()));
        }
    }
    let mut matches: Vec<Match> = (samples.sites.par_chunks(CHUNK).enumerate())
        .flat_map_iter(|(chunk, members)| {
            let first = chunk * CHUNK;
            let mut found = Vec::new();
            for number in first..first + members.len() {
                let sample = SampleId(u32::try_from(number).expect("samples are u32"));
                for rotation in 0..search.rotations {
                    let limit = budget.get();
                    let cost = turned.cost(sample, rotation as usize, limit);
                    if let Some(cost) = cost {
                        budget.offer(Some(cost));
                        found.push(Match {
                            sample,
                            rotation,
                            cost,
                        });
                    }
                }
            }
            found
        })
        .collect();
    let limit = budget.get();
    matches.retain(|found| found.cost <= limit);
    for found in &mut matches {
        found.cost = found.cost.min(1.0);
    }
    matches
}

/// Cost of one candidate; `None` if a neighbor's partner there is missing or no sample surrounded by
/// samples.
#[must_use]
pub fn match_cost(
    samples: &Samples,
    query: &Query,
    search: &Search,
    sample: SampleId,
    rotation: u32,
) -> Option<f64> {
    let turned = TurnedQuery::new(samples, query, search);
    turned.cost(sample, rotation as usize, f64::INFINITY)
}

/// `v` turned about the normal (the third axis) by `rotation` of `rotations` equal parts of a turn.
pub(super) fn turned(v: &Vector3<f64>, rotation: u32, rotations: u32) -> Vector3<f64> {
    let angle = std::f64::consts::TAU * f64::from(rotation) / f64::from(rotations);
    let (sin, cos) = angle.sin_cos();
    Vector3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z)
}

/// Highest cost that still matters: (1 + tolerance) × the best so far.
struct Budget {
    /// The bits of a nonnegative double, which are ordered as it is.
    bits: AtomicU64,
    slack: f64,
}

impl Budget {
    fn new(tolerance: f64) -> Self {
        Self {
            bits: AtomicU64::new(f64::INFINITY.to_bits()),
            slack: 1.0 + tolerance,
        }
    }

    fn get(&self) -> f64 {
        f64::from_bits(self.bits.load(Ordering::Relaxed))
    }

    fn offer(&self, cost: Option<f64>) {
        if let Some(cost) = cost {
            let limit = (cost * self.slack).to_bits();
            self.bits.fetch_min(limit, Ordering::Relaxed);
        }
    }
}

/// The query at every rotation, with the factors that make its sums costs.
struct TurnedQuery<'a> {
    samples: &'a Samples,
    /// Neighbors with their feet and points turned, by rotation.
    rotations: Vec<Vec<Neighbor>>,
    /// (1 − μ) over the sum of weights and the square of the height range: no two points of the
    /// relief over one foot are farther apart than the range, so the shape's part is at most 1 − μ
    /// but for what tilting adds (clamped at the end).
    shape_factor: f64,
    /// μ over the sum of weights and 3, the largest squared distance of two colours in [0, 1]³.
    color_factor: f64,
    /// Whether moving a neighborhood over the base keeps its feet on it and its heights.
    rigid: bool,
}

impl<'a> TurnedQuery<'a> {
    fn new(samples: &'a Samples, query: &Query, search: &Search) -> Self {
        let total: f64 = query.neighbors().iter().map(|n| n.weight).sum();
        let mu = if samples.colors.is_some() {
            search.mu
        } else {
            0.0
        };
        let ratio = |part: f64, bound: f64| {
            if total > 0.0 && bound > 0.0 {
                part / (total * bound)
            } else {
                0.0
            }
        };
        let rotations = (0..search.rotations)
            .map(|r| {
                let turn = |v: &Vector3<f64>| turned(v, r, search.rotations);
                (query.neighbors().iter())
                    .map(|n| Neighbor {
                        foot: turn(&n.foot),
                        point: turn(&n.point),
                        ..*n
                    })
                    .collect()
            })
            .collect();
        Self {
            samples,
            rotations,
            shape_factor: ratio(1.0 - mu, samples.height_range.powi(2)),
            color_factor: ratio(mu, 3.0),
            rigid: matches!(samples.base, BaseSurface::Plane(_) | BaseSurface::Sphere(_)),
        }
    }

    /// Cost at `sample`; `None` if it is not viable, or above `budget`.
    fn cost(&self, sample: SampleId, rotation: usize, budget: f64) -> Option<f64> {
        let samples = self.samples;
        let Site { foot, frame } = &samples.sites[sample.index()];
        let mut cost = 0.0;
        for neighbor in &self.rotations[rotation] {
            let moved = foot + frame.to_world(&neighbor.foot);
            let projected = if self.rigid {
                moved
            } else {
                samples.base.foot(&moved).point
            };
            let partner = samples.grid.nearest(&projected)?;
            let slab = samples.partners[partner as usize].slab?;
            if let (Some(ours), Some(colors)) = (neighbor.color, &samples.colors) {
                let theirs = colors[partner as usize];
                let differences = ours.iter().zip(theirs).map(|(a, b)| (a - b) * (a - b));
                cost += self.color_factor * neighbor.weight * differences.sum::<f64>();
            }
            let point = foot + frame.to_world(&neighbor.point);
            let shape = self.shape_factor * neighbor.weight;
            if cost + shape * slab.least_distance_sq(&point) > budget {
                return None;
            }
            cost += shape * self.distance_sq(partner, &point);
            if cost > budget {
                return None;
            }
        }
        Some(cost)
    }

    /// Squared distance to the nearest triangle around `partner`.
    fn distance_sq(&self, partner: u32, point: &Point3<f64>) -> f64 {
        let mut nearest = f64::INFINITY;
        for triangle in self.samples.fan(partner) {
            if triangle.plane_distance_sq(point) < nearest {
                nearest = nearest.min(triangle.distance_sq(point));
            }
        }
        nearest
    }
}
