//! Appendix A: relief and colour grown over the targets, from the front inwards.

use std::collections::VecDeque;

use nalgebra::Point3;

use crate::mesh::Adjacency;
use crate::neighborhood::Window;
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
    /// Scanned and new triangles.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Neighbors over them.
    pub(super) adjacency: Adjacency,
    /// Whether a vertex may be looked at: scanned and on the base, or completed.
    pub(super) known: Vec<bool>,
    /// Index of the first target.
    pub(super) first_target: usize,
}

/// A target to be matched.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// Its number among the targets.
    pub(super) target: usize,
    /// Radius of its window, in edges.
    pub(super) window: usize,
}

/// What a matcher found for a target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Copied<S> {
    pub(super) height: f64,
    pub(super) color: Option<[f64; 3]>,
    /// The scanned vertex that the copy goes back to.
    pub(super) vertex: u32,
    /// Normalised, in [0, 1].
    pub(super) cost: f64,
    /// Where the matcher found it.
    pub(super) source: S,
}

/// Finds what to copy to targets.
pub(super) trait Matcher {
    /// A place to copy from.
    type Source: Copy;

    /// Whether targets that are not in each other's windows are handed over together.
    const BATCHES: bool;

    /// What to copy to each of the targets; `None` where no sample has what the target has.
    fn find(&mut self, canvas: &Canvas, wanted: &[Wanted]) -> Vec<Option<Copied<Self::Source>>>;

    /// Hears that a target was completed.
    fn completed(&mut self, canvas: &Canvas, target: usize, copied: &Copied<Self::Source>);

    /// Hears that a front is done.
    fn front_ended(&mut self, canvas: &Canvas);
}

/// The growing completion.
pub(super) struct Growth<'a> {
    canvas: &'a mut Canvas,
    window: usize,
    /// By target: radius of its window, which shrinks when it is skipped.
    windows: Vec<usize>,
    grown: Grown,
    threshold: f64,
    collector: Window,
}

/// What became of the targets.
#[derive(Debug)]
pub(super) struct Grown {
    /// By target: cost of its match; `None` where nothing matched.
    pub(super) costs: Vec<Option<f64>>,
    /// By target: the scanned vertex that it was copied from.
    pub(super) sources: Vec<u32>,
}

impl Grown {
    pub(super) fn new(targets: usize) -> Self {
        Self {
            costs: vec![None; targets],
            sources: vec![0; targets],
        }
    }
}

/// What became of a front.
#[derive(Debug, Default)]
struct Progress {
    accepted: usize,
    /// Whether a best match was above the threshold.
    too_costly: bool,
    /// Whether a window shrank for lack of any match.
    shrunk: bool,
}

impl<'a> Growth<'a> {
    pub(super) fn new(canvas: &'a mut Canvas, window: usize, error_threshold: f64) -> Self {
        let targets = canvas.points.len() - canvas.first_target;
        Self {
            window,
            windows: vec![window; targets],
            grown: Grown::new(targets),
            threshold: error_threshold.max(LEAST_THRESHOLD),
            collector: Window::new(canvas.points.len()),
            canvas,
        }
    }

    /// Grows until every target is completed or no further one can be; `progress` hears how many
    /// targets are done.
    pub(super) fn run<M: Matcher>(
        mut self,
        matcher: &mut M,
        rng: &mut Rng,
        mut progress: impl FnMut(usize),
    ) -> Grown {
        let mut done = 0;
        // Targets next to what is known, completed ones among them.
        let mut reached: Vec<usize> = (0..self.windows.len())
            .filter(|target| self.is_reached(*target))
            .collect();
        loop {
            reached.retain(|target| !self.is_known(*target));
            if reached.is_empty() {
                break;
            }
            let mut front = self.by_constraint(&reached, rng);
            let mut outcome = Progress::default();
            while !front.is_empty() {
                let batch = self.independent(&mut front, M::BATCHES);
                let found = matcher.find(self.canvas, &batch);
                for (wanted, found) in batch.into_iter().zip(found) {
                    self.settle(wanted.target, found, matcher, &mut outcome);
                }
                progress(done + outcome.accepted);
            }
            done += outcome.accepted;
            if outcome.accepted > 0 {
                matcher.front_ended(self.canvas);
                self.add_reached(&mut reached);
            } else if outcome.too_costly {
                // Costs are at most 1, so this ends: the threshold gets there, windows get to 1.
                self.threshold *= THRESHOLD_RISE;
            } else if !outcome.shrunk {
                break;
            }
        }
        self.grown
    }

    fn is_known(&self, target: usize) -> bool {
        self.canvas.known[self.canvas.first_target + target]
    }

    /// Whether a target has a known neighbor.
    fn is_reached(&self, target: usize) -> bool {
        let direct = (self.canvas.adjacency.neighbors).row(self.canvas.first_target + target);
        direct.iter().any(|n| self.canvas.known[*n as usize])
    }

    /// Adds the targets next to those that were completed.
    fn add_reached(&self, reached: &mut Vec<usize>) {
        let completed: Vec<usize> = (reached.iter().copied())
            .filter(|target| self.is_known(*target))
            .collect();
        for target in completed {
            let direct = (self.canvas.adjacency.neighbors).row(self.canvas.first_target + target);
            let targets = (direct.iter())
                .filter_map(|n| (*n as usize).checked_sub(self.canvas.first_target))
                .filter(|n| !self.is_known(*n));
            reached.extend(targets);
        }
        reached.sort_unstable();
        reached.dedup();
    }

    /// The front: those with the most known vertices in their window first, equal ones in random
    /// order.
    fn by_constraint(&mut self, reached: &[usize], rng: &mut Rng) -> VecDeque<usize> {
        let canvas = &*self.canvas;
        let mut front: Vec<(std::cmp::Reverse<usize>, u32, usize)> = (reached.iter())
            .map(|target| {
                let v = index(canvas.first_target + target);
                let window =
                    (self.collector).around(&canvas.adjacency.neighbors, v, self.windows[*target]);
                let known = window.iter().filter(|n| canvas.known[**n as usize]).count();
                (std::cmp::Reverse(known), rng.word(), *target)
            })
            .collect();
        front.sort_unstable();
        front.into_iter().map(|(_, _, target)| target).collect()
    }

    /// Takes from the front what is matched next: the first target, and if asked for in batches all later
    /// ones that are in the window of none of the batch, so that they can be matched at the same time.
    fn independent(&mut self, front: &mut VecDeque<usize>, in_batches: bool) -> Vec<Wanted> {
        if !in_batches {
            let first: Vec<usize> = front.pop_front().into_iter().collect();
            return self.wanted(&first);
        }
        let mut batch = Vec::new();
        self.collector.begin_union();
        front.retain(|target| {
            let v = index(self.canvas.first_target + target);
            if self.collector.holds(v) {
                return true;
            }
            let neighbors = &self.canvas.adjacency.neighbors;
            self.collector.unite(neighbors, v, self.window);
            batch.push(*target);
            false
        });
        self.wanted(&batch)
    }

    fn wanted(&self, targets: &[usize]) -> Vec<Wanted> {
        (targets.iter())
            .map(|target| Wanted {
                target: *target,
                window: self.windows[*target],
            })
            .collect()
    }

    /// Copies what was found for a target, if it is good enough; else its window shrinks.
    fn settle<M: Matcher>(
        &mut self,
        target: usize,
        found: Option<Copied<M::Source>>,
        matcher: &mut M,
        outcome: &mut Progress,
    ) {
        match found {
            Some(copied) if copied.cost <= self.threshold.min(1.0) => {
                self.copy(target, &copied);
                matcher.completed(self.canvas, target, &copied);
                outcome.accepted += 1;
            }
            Some(_) => {
                outcome.too_costly = true;
                self.shrink_window(target);
            }
            None => outcome.shrunk |= self.shrink_window(target),
        }
    }

    fn copy<S>(&mut self, target: usize, copied: &Copied<S>) {
        let canvas = &mut *self.canvas;
        let v = canvas.first_target + target;
        canvas.relief.heights[v] = copied.height;
        canvas.points[v] = canvas.relief.point(v, copied.height);
        if let (Some(colors), Some(color)) = (&mut canvas.colors, copied.color) {
            colors[v] = color;
        }
        canvas.known[v] = true;
        self.grown.sources[target] = match (copied.vertex as usize).checked_sub(canvas.first_target)
        {
            None => copied.vertex,
            Some(earlier) => self.grown.sources[earlier],
        };
        self.grown.costs[target] = Some(copied.cost);
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
