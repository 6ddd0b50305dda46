//! What to copy by the paper's metric: every sample, every rotation, one target after the other.

use crate::base::BaseSurface;
use crate::matching::paper::{Match, Neighbor, Query, SampleId, Samples, Search, best_matches};
use crate::neighborhood::{Frame, Window, gaussian_weight, local_frames, window_sigma};
use crate::rng::{Rng, Stage};

use super::growth::{Canvas, Copied, Matcher, Wanted};

/// The paper's matcher.
pub(super) struct ByPaper<'a> {
    samples: Samples,
    /// Makes samples of all that is known, if completed vertices become samples.
    renew: Option<&'a dyn Fn(&Canvas) -> Samples>,
    search: Search,
    spacing: f64,
    /// Seed, and number of the patch: what the random picks follow from.
    seed: [u32; 2],
    frames: Vec<Frame>,
    /// By target: where it was copied from.
    matches: Vec<Option<Match>>,
    collector: Window,
}

impl<'a> ByPaper<'a> {
    pub(super) fn new(
        canvas: &Canvas,
        base: &BaseSurface,
        samples: Samples,
        renew: Option<&'a dyn Fn(&Canvas) -> Samples>,
        search: Search,
        spacing: f64,
        seed: [u32; 2],
    ) -> Self {
        Self {
            samples,
            renew,
            search,
            spacing,
            seed,
            frames: local_frames(base, &canvas.relief.normals),
            matches: vec![None; canvas.points.len() - canvas.first_target],
            collector: Window::new(canvas.points.len()),
        }
    }

    /// What is known within the target's window.
    fn query(&mut self, canvas: &Canvas, wanted: &Wanted) -> Query {
        let v = canvas.first_target + wanted.target;
        let sigma = window_sigma(wanted.window, self.spacing);
        let (foot, frame) = (canvas.relief.feet[v], &self.frames[v]);
        let window =
            (self.collector).around(&canvas.adjacency.neighbors, super::index(v), wanted.window);
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
    fn likely(&self, canvas: &Canvas, target: usize) -> Vec<SampleId> {
        let v = canvas.first_target + target;
        let mut likely: Vec<SampleId> = (canvas.adjacency.neighbors.row(v).iter())
            .filter_map(|n| (*n as usize).checked_sub(canvas.first_target))
            .filter_map(|n| Some((n, self.matches[n]?)))
            .filter_map(|(n, found)| {
                let n = canvas.first_target + n;
                let offset =
                    self.frames[n].to_local(&(canvas.relief.feet[v] - canvas.relief.feet[n]));
                (self.samples).continuation(&found, self.search.rotations, &offset)
            })
            .collect();
        likely.sort_unstable();
        likely.dedup();
        likely
    }
}

impl Matcher for ByPaper<'_> {
    type Source = Match;
    const BATCHES: bool = false;

    fn find(&mut self, canvas: &Canvas, wanted: &[Wanted]) -> Vec<Option<Copied<Match>>> {
        let find = |wanted: &Wanted| {
            let query = self.query(canvas, wanted);
            let likely = self.likely(canvas, wanted.target);
            let matches = best_matches(&self.samples, &query, &self.search, &likely);
            let [seed, patch] = self.seed;
            let part = super::index(wanted.target);
            let mut rng = Rng::of_part(seed, Stage::Matching, patch, part);
            let pick = rng.pick(&matches)?;
            Some(Copied {
                height: self.samples.height(pick.sample),
                color: self.samples.color(pick.sample),
                vertex: self.samples.scanned_vertex(pick.sample),
                cost: pick.cost,
                source: pick,
            })
        };
        wanted.iter().map(find).collect()
    }

    fn completed(&mut self, _: &Canvas, target: usize, copied: &Copied<Match>) {
        self.matches[target] = Some(copied.source);
    }

    fn front_ended(&mut self, canvas: &Canvas) {
        if let Some(renew) = self.renew {
            self.samples = renew(canvas);
            // Numbers of samples have another meaning from here on.
            self.matches.fill(None);
        }
    }
}
