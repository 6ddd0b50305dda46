//! The way from the coarsest level to the finest.

use crate::progress::{Clock, Progress};

use super::TransferParams;
use super::descriptors::{Descriptors, Factors};
use super::field::{self, Match, Order, Pairing, Search};
use super::ground::{numbers, single};
use super::masked::Masks;
use super::report::LevelReport;
use super::stack::{Stack, factors};
use super::start::Start;
use super::up::refined;
use super::values::Values;
use super::vote::voted;

/// What is gone through.
pub(super) struct Levels<'a> {
    pub(super) sources: &'a Stack,
    pub(super) targets: &'a Stack,
    pub(super) values: &'a Values,
    pub(super) masks: Option<&'a Masks>,
    pub(super) params: &'a TransferParams,
}

/// What is known on the finest level in the end.
pub(super) struct Done {
    pub(super) field: Vec<Match>,
    /// What the votes say (n by the number of channels).
    pub(super) voted: Vec<f32>,
    pub(super) levels: Vec<LevelReport>,
}

impl Levels<'_> {
    pub(super) fn run(&self, start: &Start, clock: &mut Clock) -> Done {
        let coarsest = self.sources.levels() - 1;
        clock.begin("search");
        let mut field = self.started(start, coarsest);
        clock.end("search");
        let mut levels = Vec::new();
        let mut last = Vec::new();
        for level in (0..=coarsest).rev() {
            if level < coarsest {
                let [coarse, fine] = [level + 1, level].map(|level| self.pairing(level));
                field = refined(&coarse, &fine, &self.targets.hierarchy, level, &field);
                clock.end("up-sampling");
            }
            let (done, total) = (coarsest - level, coarsest + 1);
            (clock.progress)(Progress {
                stage: "levels",
                done,
                total,
            });
            let (improved, voted, report) = self.level(level, field, clock);
            (field, last) = (improved, voted);
            levels.push(report);
        }
        levels.reverse();
        Done {
            field,
            voted: last,
            levels,
        }
    }

    fn pairing(&self, level: usize) -> Pairing<'_> {
        let (source, target) = (&self.sources.grounds[level], &self.targets.grounds[level]);
        Pairing {
            target,
            source,
            hierarchy: &self.sources.hierarchy,
            level,
            ratio: source.spacing / target.spacing,
            allowed: self.masks.map_or(&[], |masks| &masks.allowed[level]),
            pinned: self.masks.map_or(&[], |masks| &masks.pinned[level]),
        }
    }

    /// Share of colors and heights in the comparison: as much as can be seen of them.
    fn value_weight(&self, level: usize) -> f32 {
        single((1.0 - self.params.shape_weight) * self.values.seen[level])
    }

    fn factors(&self, level: usize, value_weight: f32) -> Factors {
        let variances = self.values.variances(level);
        factors(
            self.sources,
            level,
            &self.values.groups,
            &variances,
            value_weight,
        )
    }

    fn described(&self, stack: &Stack, level: usize, values: &[f32], by: &Factors) -> Descriptors {
        let (ground, shape) = (&stack.grounds[level], &stack.shape[level]);
        Descriptors::new(ground, values, shape, &stack.gradients[level], by)
    }

    /// The field of the coarsest level: what is alike in shape.
    fn started(&self, start: &Start, level: usize) -> Vec<Match> {
        let own = self.pairing(level);
        let mut field = start.field(&own, &self.targets.hierarchy, self.params.seed);
        for (v, found) in (0u32..).zip(&mut field) {
            if own.is_pinned(v) {
                *found = Match::new(v, 0, 0.0);
            }
        }
        if start.is_given() {
            return field;
        }
        let by = self.factors(level, 0.0);
        let nothing = vec![0.0; self.values.count() * own.target.len()];
        let of_source = self.described(self.sources, level, &self.values.levels[level], &by);
        let of_target = self.described(self.targets, level, &nothing, &by);
        let free: Vec<u32> = numbers(field.len())
            .filter(|v| !own.is_pinned(*v))
            .collect();
        let found = field::exhaustive(&own, &of_target, &of_source, &field, &free);
        for (v, found) in free.into_iter().zip(found) {
            field[v as usize] = found;
        }
        field
    }

    fn level(
        &self,
        level: usize,
        mut field: Vec<Match>,
        clock: &mut Clock,
    ) -> (Vec<Match>, Vec<f32>, LevelReport) {
        let own = self.pairing(level);
        let (values, count) = (&self.values.levels[level], self.values.count());
        for (v, found) in (0u32..).zip(&mut field) {
            if own.is_pinned(v) {
                (found.source, found.turn) = (v, 0);
            }
        }
        let known: &[f32] = self.masks.map_or(&[], |masks| &masks.known[level]);
        let value_weight = self.value_weight(level);
        let by = self.factors(level, value_weight);
        let of_source = self.described(self.sources, level, values, &by);
        let order = Order::new(own.target);
        clock.end("descriptors");
        let mut painted = voted(&own, &field, values, count, known);
        clock.end("votes");
        let mut of_target = self.described(self.targets, level, &painted, &by);
        for round in 0..self.params.rounds {
            if round > 0 {
                of_target.set_values(own.target, &painted, &by);
            }
            clock.end("descriptors");
            field::rated(&own, &of_target, &of_source, &mut field);
            let search = Search {
                of_target: &of_target,
                of_source: &of_source,
                rotations: self.params.rotations,
                coherence: single(self.params.coherence),
                overuse: single(self.params.overuse),
                seed: self.params.seed,
            };
            field = field::improved(&own, &order, &field, &search, round);
            clock.end("search");
            painted = voted(&own, &field, values, count, known);
            clock.end("votes");
        }
        clock.begin("audit");
        let audit = (level == 0 && self.params.audit > 0)
            .then(|| field::audited(&own, &of_target, &of_source, &field, self.params.audit));
        clock.end("audit");
        let free = (0u32..).zip(&field).filter(|(v, _)| !own.is_pinned(*v));
        let costs: f64 = free.clone().map(|(_, m)| f64::from(m.cost)).sum();
        let report = LevelReport {
            vertices: own.target.len(),
            source_vertices: own.source.len(),
            value_weight,
            mean_cost: costs / free.count().max(1) as f64,
            audit,
            coherent_edges: field::coherent_edges(&own, &field),
        };
        clock.end("report");
        (field, painted, report)
    }
}
