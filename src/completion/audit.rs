//! How good fast matches are: some targets are searched for exhaustively as well.

use crate::matching::coherent::{self, Task};
use crate::matching::exemplar::{Exemplar, ExemplarParams};
use crate::matching::exhaustive;
use crate::neighborhood::{Place, View, Walker};
use crate::rng::Rng;

use super::report::Recall;

/// A match is as good as the best if it costs at most this many times as much.
const AS_GOOD: f32 = 1.1;

/// All places at all rotations, to compare what the fast searches find with.
pub(super) struct Audit {
    exemplar: Exemplar,
    /// Share of the targets that are compared.
    share: f64,
}

/// Which searches found a match as good as the best.
#[derive(Debug, Clone, Copy)]
pub(super) struct Verdict {
    by_continuing: bool,
    by_coherence: bool,
    by_all: bool,
}

impl Audit {
    /// A share of the targets against `sites`, as many as so many bytes hold.
    pub(super) fn new(
        view: &View,
        sites: Vec<Place>,
        share: f64,
        memory: usize,
        params: &ExemplarParams,
    ) -> Option<Self> {
        let exhaustive = ExemplarParams {
            most_sites: usize::MAX,
            similar: 0,
            memory,
            ..*params
        };
        Some(Self {
            exemplar: Exemplar::new(view, sites, &exhaustive)?,
            share,
        })
    }

    /// Searches for a target by every way, if it is one of those drawn for it.
    pub(super) fn verdict(
        &self,
        task: &Task,
        rng: &mut Rng,
        walker: &mut Walker,
    ) -> Option<Verdict> {
        let mut own = rng.clone();
        if own.uniform() >= self.share {
            return None;
        }
        let best = exhaustive::nearest(self.exemplar.table(), task.query.descriptor(), 1);
        let best = best.first()?.cost;
        let is_as_good = |cost: Option<f32>| cost.is_some_and(|cost| cost <= AS_GOOD * best);
        let costs = (task.continued.iter())
            .filter_map(|place| (task.query).cost(walker, task.view, place, f32::INFINITY));
        let continuing = costs.reduce(f32::min);
        let coherent = coherent::coherent_match(task, walker);
        let any = coherent::cheapest(task, rng, walker);
        Some(Verdict {
            by_continuing: is_as_good(continuing),
            by_coherence: is_as_good(coherent.map(|found| found.cost)),
            by_all: is_as_good(any.map(|found| found.cost)),
        })
    }

    /// The recall before anything is completed.
    pub(super) fn nothing_yet(&self) -> Recall {
        Recall {
            compared: self.exemplar.table().len(),
            ..Recall::default()
        }
    }
}

impl Recall {
    /// Adds what was found for one more new vertex.
    pub(super) fn count(&mut self, verdict: Verdict) {
        self.add(&Self {
            audited: 1,
            compared: 0,
            continuing: f64::from(u8::from(verdict.by_continuing)),
            coherent: f64::from(u8::from(verdict.by_coherence)),
            all: f64::from(u8::from(verdict.by_all)),
        });
    }
}
