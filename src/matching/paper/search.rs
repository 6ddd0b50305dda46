//! The paper's metric over every sample and every rotation.

use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::base::BaseSurface;

use super::lower_bounds::{LANES, Probe};
use super::query::{Neighbor, Query};
use super::samples::{SampleId, Samples, Site};

/// Blocks of samples, or candidates, of one task: enough to be worth a task, few enough to share a
/// late best match.
const CHUNK: usize = 256;

/// Every how many blocks of samples there is one that is looked at first, and how many candidates from
/// these.
const PILOT: usize = 16;

/// Candidates whose costs are added up side by side.
const BATCH: usize = 32;

/// Bounds are in single precision: those above the budget by less than this factor do not count.
const ROUNDING: f64 = 1.0 + 1e-4;

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
            budget.offer(turned.cost(*sample, rotation));
        }
    }
    let probes = turned.probes();
    let blocks: Vec<usize> = (0..samples.len().div_ceil(LANES)).collect();
    if probes.iter().flatten().any(Option::is_some) {
        // A few spread over the surface first, for a good budget.
        let spread: Vec<usize> = blocks.iter().copied().step_by(PILOT).collect();
        let first = turned.candidates(&spread, &probes, budget.get());
        turned.matches(&promising(first), &probes, &budget);
    }
    let candidates: Vec<Candidate> = (blocks.par_chunks(CHUNK))
        .flat_map_iter(|blocks| turned.candidates(blocks, &probes, budget.get()))
        .collect();
    turned.matches(&promising(candidates.clone()), &probes, &budget);
    let mut matches: Vec<Match> = (candidates.par_chunks(CHUNK))
        .flat_map_iter(|candidates| turned.matches(candidates, &probes, &budget))
        .collect();
    matches.sort_unstable_by_key(|found| (found.sample, found.rotation));
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
    turned.cost(sample, rotation as usize)
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

/// A candidate whose cost is being added up, neighbor by neighbor.
#[derive(Debug, Clone, Copy)]
struct Lane {
    sample: usize,
    /// So far.
    cost: f64,
    /// What the neighbors that were not yet looked at cost at least.
    rest: f64,
    /// Where the present neighbor gets to.
    foot: Point3<f64>,
    point: Point3<f64>,
    list: u32,
    partner: u32,
}

impl Lane {
    fn new(sample: usize, bound: f64) -> Self {
        Self {
            sample,
            cost: 0.0,
            rest: bound,
            foot: Point3::origin(),
            point: Point3::origin(),
            list: 0,
            partner: 0,
        }
    }

    /// Whether it can be within `budget` although its present neighbor costs at least `more`.
    #[inline]
    fn within(&self, more: f64, budget: f64) -> bool {
        let least = self.cost + more;
        // The rest is not a number where its bounds were infinite.
        let too_much = least + self.rest > budget * ROUNDING;
        least <= budget && !too_much
    }
}

/// Moves the lanes that are to stay to the front, in their order; how many these are.
#[inline]
fn retain(lanes: &mut [Lane], mut stays: impl FnMut(&mut Lane) -> bool) -> usize {
    let mut live = 0;
    for at in 0..lanes.len() {
        if stays(&mut lanes[at]) {
            if live != at {
                lanes[live] = lanes[at];
            }
            live += 1;
        }
    }
    live
}

/// A budget in the precision of bounds: one that no bound exceeds whose cost does not exceed it.
#[expect(clippy::cast_possible_truncation, reason = "rounded up")]
fn single(budget: f64) -> f32 {
    (budget * ROUNDING) as f32 + f32::MIN_POSITIVE
}

/// A sample and rotation that may match.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// At most its cost, but for rounding.
    bound: f32,
    sample: SampleId,
    rotation: u32,
}

/// Those with the lowest bounds.
fn promising(mut candidates: Vec<Candidate>) -> Vec<Candidate> {
    if candidates.len() > PILOT {
        candidates.select_nth_unstable_by(PILOT, |a, b| a.bound.total_cmp(&b.bound));
        candidates.truncate(PILOT);
    }
    candidates
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

    /// By rotation, the neighbors with bounds.
    fn probes(&self) -> Vec<Vec<Option<Probe>>> {
        let bounds = &self.samples.lower_bounds;
        if !bounds.wanted() {
            let none = |neighbors: &Vec<Neighbor>| neighbors.iter().map(|_| None).collect();
            return self.rotations.iter().map(none).collect();
        }
        (self.rotations.iter())
            .map(|neighbors| bounds.probes(self.samples, neighbors, self.shape_factor))
            .collect()
    }

    /// The candidates in the given blocks of samples whose bound is within `budget`.
    fn candidates(
        &self,
        blocks: &[usize],
        probes: &[Vec<Option<Probe>>],
        budget: f64,
    ) -> Vec<Candidate> {
        let limit = single(budget);
        let mut candidates = Vec::new();
        for (rotation, probes) in (0u32..).zip(probes) {
            let mut live: Vec<(usize, [f32; LANES])> =
                blocks.iter().map(|block| (*block, [0.0; LANES])).collect();
            for few in probes.chunks(4) {
                for probe in few.iter().flatten() {
                    for (block, sums) in &mut live {
                        probe.add(*block, sums);
                    }
                }
                live.retain(|(_, sums)| sums.iter().any(|bound| *bound <= limit));
            }
            let lanes = live.iter().flat_map(|(block, sums)| {
                (block * LANES..self.samples.len()).zip(sums.iter().copied())
            });
            candidates.extend(
                lanes
                    .filter(|(_, bound)| *bound <= limit)
                    .map(|(sample, bound)| Candidate {
                        bound,
                        sample: SampleId(u32::try_from(sample).expect("samples are u32")),
                        rotation,
                    }),
            );
        }
        candidates
    }

    /// Exact costs of those candidates that cost at most the budget when they are looked at, which
    /// they may lower.
    fn matches(
        &self,
        candidates: &[Candidate],
        probes: &[Vec<Option<Probe>>],
        budget: &Budget,
    ) -> Vec<Match> {
        let (mut found, mut lanes) = (Vec::new(), Vec::with_capacity(BATCH));
        for same in candidates.chunk_by(|a, b| a.rotation == b.rotation) {
            let rotation = same[0].rotation;
            for batch in same.chunks(BATCH) {
                let limit = budget.get();
                let single = single(limit);
                lanes.clear();
                lanes.extend(
                    (batch.iter())
                        .filter(|candidate| candidate.bound <= single)
                        .map(|c| Lane::new(c.sample.index(), f64::from(c.bound))),
                );
                let probes = &probes[rotation as usize];
                let live = self.run(&mut lanes, rotation as usize, probes, limit);
                for lane in &lanes[..live] {
                    budget.offer(Some(lane.cost));
                    found.push(Match {
                        sample: SampleId(u32::try_from(lane.sample).expect("samples are u32")),
                        rotation,
                        cost: lane.cost,
                    });
                }
            }
        }
        found
    }

    /// Cost at `sample`; `None` if it is not viable.
    fn cost(&self, sample: SampleId, rotation: usize) -> Option<f64> {
        let mut lane = [Lane::new(sample.index(), 0.0)];
        let live = self.run(&mut lane, rotation, &[], f64::INFINITY);
        (live == 1).then_some(lane[0].cost)
    }

    /// Adds up the costs of some candidates at the same rotation side by side, so that waiting for
    /// memory overlaps. How many are viable and within `budget`: these are first then.
    fn run(
        &self,
        lanes: &mut [Lane],
        rotation: usize,
        probes: &[Option<Probe>],
        budget: f64,
    ) -> usize {
        let mut live = lanes.len();
        for (rank, neighbor) in self.rotations[rotation].iter().enumerate() {
            let probe = probes.get(rank).and_then(Option::as_ref);
            live = retain(&mut lanes[..live], |lane| self.land(lane, neighbor));
            live = retain(&mut lanes[..live], |lane| {
                lane.partner = self.samples.grid.nearest_in(lane.list, &lane.foot);
                true
            });
            live = retain(&mut lanes[..live], |lane| {
                self.add_least(lane, neighbor, probe, budget)
            });
            live = retain(&mut lanes[..live], |lane| {
                let distance_sq = self.distance_sq(lane.partner, &lane.point);
                lane.cost += self.shape_factor * neighbor.weight * distance_sq;
                lane.within(0.0, budget)
            });
            if live == 0 {
                break;
            }
        }
        live
    }

    /// Moves a neighbor there; whether there is something.
    #[inline]
    fn land(&self, lane: &mut Lane, neighbor: &Neighbor) -> bool {
        let Site { foot, frame } = &self.samples.sites[lane.sample];
        let moved = foot + frame.to_world(&neighbor.foot);
        lane.foot = if self.rigid {
            moved
        } else {
            self.samples.base.foot(&moved).point
        };
        lane.point = foot + frame.to_world(&neighbor.point);
        match self.samples.grid.list(&lane.foot) {
            Some(list) => lane.list = list,
            None => return false,
        }
        true
    }

    /// Adds what the partner's colour costs; whether with the least that its shape can cost the
    /// candidate is still viable and within `budget`.
    #[inline]
    fn add_least(
        &self,
        lane: &mut Lane,
        neighbor: &Neighbor,
        probe: Option<&Probe>,
        budget: f64,
    ) -> bool {
        let partner = lane.partner as usize;
        let Some(slab) = &self.samples.partners[partner].slab else {
            return false;
        };
        if let (Some(ours), Some(colors)) = (neighbor.color, &self.samples.colors) {
            let differences = ours.iter().zip(colors[partner]);
            let differences = differences.map(|(a, b)| (a - b) * (a - b));
            lane.cost += self.color_factor * neighbor.weight * differences.sum::<f64>();
        }
        if let Some(probe) = probe {
            lane.rest -= f64::from(probe.bound(lane.sample));
        }
        let shape = self.shape_factor * neighbor.weight;
        lane.within(shape * slab.least_distance_sq(&lane.point), budget)
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
