//! Appendix A: relief and colour grown over the targets, from the front inwards.

use nalgebra::Point3;

use crate::base::BaseSurface;
use crate::matching::paper::{Match, Neighbor, Query, SampleId, Samples, Search, best_matches};
use crate::mesh::Adjacency;
use crate::neighborhood::{Frame, Window, gaussian_weight, local_frames, window_sigma};
use crate::relief::Relief;
use crate::rng::Rng;

/// Factor by which the error threshold rises when a whole front makes no progress.
const THRESHOLD_RISE: f64 = 1.1;

/// The threshold starts no lower: from 1e-300 it would take thousands of fronts to rise to any cost.
const LEAST_THRESHOLD: f64 = 1e-6;

/// Scan and targets as one surface, what is known of it and what is not.
#[derive(Debug)]
pub(super) struct Canvas {
    /// Relief of the scanned vertices and the targets after them; heights of targets are set as
    /// they are completed.
    pub(super) relief: Relief,
    /// Points on the relief (targets: on the base until completed).
    pub(super) points: Vec<Point3<f64>>,
    /// Colours in [0, 1], where the scan has any.
    pub(super) colors: Option<Vec<[f64; 3]>>,
    /// Neighbors over scanned and new triangles.
    pub(super) adjacency: Adjacency,
    /// Whether a vertex may be looked at: scanned and on the base, or completed.
    pub(super) known: Vec<bool>,
    /// Index of the first target.
    pub(super) first_target: usize,
}

/// Parameters of the growth.
#[derive(Debug, Clone, Copy)]
pub(super) struct GrowthParams {
    pub(super) window: usize,
    pub(super) spacing: f64,
    pub(super) error_threshold: f64,
    pub(super) search: Search,
}

/// The growing completion.
pub(super) struct Growth<'a> {
    canvas: &'a mut Canvas,
    params: GrowthParams,
    frames: Vec<Frame>,
    /// By target: radius of its window, which shrinks when it is skipped.
    windows: Vec<usize>,
    /// By target: where it was copied from.
    matches: Vec<Option<Match>>,
    /// By target: the scanned vertex that the copy goes back to.
    sources: Vec<u32>,
    threshold: f64,
    collector: Window,
}

/// What became of the targets.
#[derive(Debug)]
pub(super) struct Grown {
    /// By target: where it was copied from; `None` where nothing matched.
    pub(super) matches: Vec<Option<Match>>,
    /// By target: the scanned vertex that it was copied from.
    pub(super) sources: Vec<u32>,
}

/// What happened to one vertex of the front.
enum Outcome {
    Accepted,
    /// The best match is above the threshold.
    TooCostly,
    /// No sample has the neighbors that the target has.
    NoMatch,
}

impl<'a> Growth<'a> {
    pub(super) fn new(canvas: &'a mut Canvas, base: &BaseSurface, params: GrowthParams) -> Self {
        let targets = canvas.points.len() - canvas.first_target;
        Self {
            frames: local_frames(base, &canvas.relief.normals),
            windows: vec![params.window; targets],
            matches: vec![None; targets],
            sources: vec![0; targets],
            threshold: params.error_threshold.max(LEAST_THRESHOLD),
            collector: Window::new(canvas.points.len()),
            params,
            canvas,
        }
    }

    /// Grows until every target is completed or no further one can be. After each front,
    /// `renewed_samples` may give samples to use from then on; `progress` hears how many targets
    /// are done.
    pub(super) fn run(
        mut self,
        samples: Samples,
        rng: &mut Rng,
        mut renewed_samples: impl FnMut(&Canvas) -> Option<Samples>,
        mut progress: impl FnMut(usize),
    ) -> Grown {
        let mut samples = samples;
        let mut done = 0;
        loop {
            let front = self.front(rng);
            if front.is_empty() {
                break;
            }
            let (mut accepted, mut too_costly, mut shrunk) = (0, false, false);
            for target in front {
                match self.complete(target, &samples, rng) {
                    Outcome::Accepted => {
                        accepted += 1;
                        progress(done + accepted);
                    }
                    Outcome::TooCostly => {
                        too_costly = true;
                        self.shrink_window(target);
                    }
                    Outcome::NoMatch => shrunk |= self.shrink_window(target),
                }
            }
            done += accepted;
            if accepted == 0 {
                // Costs are at most 1, so this ends: the threshold gets there, windows get to 1.
                if too_costly {
                    self.threshold *= THRESHOLD_RISE;
                } else if !shrunk {
                    break;
                }
            } else if let Some(renewed) = renewed_samples(self.canvas) {
                samples = renewed;
            }
        }
        Grown {
            matches: self.matches,
            sources: self.sources,
        }
    }

    /// Targets with a known neighbor, those with the most known vertices in their window first,
    /// equal ones in random order.
    fn front(&mut self, rng: &mut Rng) -> Vec<usize> {
        let canvas = &*self.canvas;
        let mut front: Vec<(std::cmp::Reverse<usize>, u32, usize)> = Vec::new();
        for target in 0..self.matches.len() {
            let v = index(canvas.first_target + target);
            let direct = canvas.adjacency.neighbors.row(v as usize);
            if canvas.known[v as usize] || !direct.iter().any(|n| canvas.known[*n as usize]) {
                continue;
            }
            let window =
                (self.collector).around(&canvas.adjacency.neighbors, v, self.windows[target]);
            let known = window.iter().filter(|n| canvas.known[**n as usize]).count();
            front.push((std::cmp::Reverse(known), rng.word(), target));
        }
        front.sort_unstable();
        front.into_iter().map(|(_, _, target)| target).collect()
    }

    /// Matches one target and copies the pick if it is good enough.
    fn complete(&mut self, target: usize, samples: &Samples, rng: &mut Rng) -> Outcome {
        let query = self.query(target);
        let likely = self.likely(target, samples);
        let matches = best_matches(samples, &query, &self.params.search, &likely);
        if matches.is_empty() {
            return Outcome::NoMatch;
        }
        let pick = matches[rng.index(matches.len())];
        if pick.cost > self.threshold.min(1.0) {
            return Outcome::TooCostly;
        }
        self.copy(target, pick, samples);
        Outcome::Accepted
    }

    /// What is known within the target's window.
    fn query(&mut self, target: usize) -> Query {
        let canvas = &*self.canvas;
        let v = canvas.first_target + target;
        let radius = self.windows[target];
        let sigma = window_sigma(radius, self.params.spacing);
        let (foot, frame) = (canvas.relief.feet[v], &self.frames[v]);
        let window = self
            .collector
            .around(&canvas.adjacency.neighbors, index(v), radius);
        let known = || {
            let window = window.iter().map(|n| *n as usize);
            window.filter(|n| canvas.known[*n])
        };
        // Only ratios of weights count; relative to the nearest neighbor they cannot all vanish.
        let nearest_sq = known()
            .map(|n| (canvas.relief.feet[n] - foot).norm_squared())
            .fold(f64::INFINITY, f64::min);
        let neighbors = known()
            .map(|n| {
                Neighbor::new(
                    &foot,
                    frame,
                    &canvas.relief.feet[n],
                    &canvas.points[n],
                    canvas.colors.as_ref().map(|colors| colors[n]),
                    |distance_sq| gaussian_weight(distance_sq - nearest_sq, sigma),
                )
            })
            .collect();
        Query::new(neighbors)
    }

    /// Samples that continue what the completed neighbors were copied from: looked at first, they
    /// make the search faster and change nothing else.
    fn likely(&self, target: usize, samples: &Samples) -> Vec<SampleId> {
        let canvas = &*self.canvas;
        let v = canvas.first_target + target;
        let mut likely: Vec<SampleId> = (canvas.adjacency.neighbors.row(v).iter())
            .filter_map(|n| (*n as usize).checked_sub(canvas.first_target))
            .filter_map(|n| Some((n, self.matches[n]?)))
            .filter_map(|(n, found)| {
                let n = canvas.first_target + n;
                let offset =
                    self.frames[n].to_local(&(canvas.relief.feet[v] - canvas.relief.feet[n]));
                samples.continuation(&found, self.params.search.rotations, &offset)
            })
            .collect();
        likely.sort_unstable();
        likely.dedup();
        likely
    }

    fn copy(&mut self, target: usize, pick: Match, samples: &Samples) {
        let canvas = &mut *self.canvas;
        let v = canvas.first_target + target;
        let height = samples.height(pick.sample);
        canvas.relief.heights[v] = height;
        canvas.points[v] = canvas.relief.point(v, height);
        if let (Some(colors), Some(color)) = (&mut canvas.colors, samples.color(pick.sample)) {
            colors[v] = color;
        }
        canvas.known[v] = true;
        let source = samples.scanned_vertex(pick.sample);
        self.sources[target] = match (source as usize).checked_sub(canvas.first_target) {
            None => source,
            Some(earlier) => self.sources[earlier],
        };
        self.matches[target] = Some(pick);
    }

    /// One edge less for a skipped vertex; whether there was one to take.
    fn shrink_window(&mut self, target: usize) -> bool {
        let window = &mut self.windows[target];
        let shrinks = *window > 1;
        *window -= usize::from(shrinks);
        shrinks
    }
}

fn index(v: usize) -> u32 {
    u32::try_from(v).expect("vertex indices are u32")
}
