//! Searches against a plain triple loop.
#![expect(clippy::cast_possible_truncation, reason = "test data is small")]

use proptest::prelude::*;

use super::*;
use crate::rng::{Rng, Stage};

/// A table, what it was made of, and a query.
struct Case {
    weights: Vec<f32>,
    channels: usize,
    candidates: Vec<Descriptor>,
    query: Descriptor,
}

/// Sizes and shares that a case is drawn with.
#[derive(Debug, Clone)]
struct Shape {
    seed: u32,
    offsets: usize,
    channels: usize,
    candidates: usize,
    /// Shares of offsets known in the query, and of candidates that know all offsets.
    known: f64,
    complete: f64,
    /// Distinct values: few of them make many equal costs.
    levels: usize,
}

impl Shape {
    fn any() -> impl Strategy<Value = Self> {
        // Now and then more than a tile.
        let candidates = prop_oneof![9 => 0..90usize, 1 => 1000..1100usize];
        let sizes = (1..150usize, 1..5usize, candidates);
        let levels = prop_oneof![Just(2usize), Just(5), Just(1_000_000)];
        (any::<u32>(), sizes, 0.0..1.0f64, 0.0..1.0f64, levels).prop_map(
            |(seed, (offsets, channels, candidates), known, complete, levels)| Self {
                seed,
                offsets,
                channels,
                candidates,
                known,
                complete,
                levels,
            },
        )
    }

    fn draw(&self) -> Case {
        let mut rng = Rng::new(self.seed, Stage::Synth, 0);
        let weights = (0..self.offsets)
            .map(|_| 0.01 + rng.uniform() as f32)
            .collect();
        let query = self.descriptor(&mut rng, self.known);
        let candidates = (0..self.candidates)
            .map(|_| {
                let share = match rng.uniform() < self.complete {
                    true => 1.0,
                    false => 0.97,
                };
                self.descriptor(&mut rng, share)
            })
            .collect();
        Case {
            weights,
            channels: self.channels,
            candidates,
            query,
        }
    }

    /// Garbage at unknown offsets.
    fn descriptor(&self, rng: &mut Rng, known: f64) -> Descriptor {
        let mut descriptor = Descriptor::new(self.offsets, self.channels);
        for j in 0..self.offsets {
            let known = rng.uniform() < known;
            if known {
                descriptor.known.set(j);
            }
            for c in 0..self.channels {
                let garbage = [f32::NAN, f32::INFINITY, -1e38, 0.0][rng.index(4)];
                let value = rng.index(self.levels) as f32 / self.levels as f32 - 0.4;
                descriptor.values[j * self.channels + c] = if known { value } else { garbage };
            }
        }
        descriptor
    }
}

impl Case {
    fn table(&self) -> Table {
        Table::build(
            self.candidates.len(),
            self.channels,
            &self.weights,
            |i, d| d.clone_from(&self.candidates[i]),
        )
    }

    /// Costs of all candidates, the plain way; `None` where not viable.
    fn costs(&self) -> Vec<Option<f32>> {
        let known: Vec<usize> = self.query.known.iter().collect();
        (self.candidates.iter())
            .map(|candidate| {
                if known.is_empty() || known.iter().any(|j| !candidate.known.get(*j)) {
                    return None;
                }
                let (mut sum, mut total) = (0.0, 0.0);
                for j in &known {
                    let weight = self.weights[*j];
                    total += weight;
                    for i in j * self.channels..(j + 1) * self.channels {
                        let difference = self.query.values[i] - candidate.values[i];
                        sum += weight * (difference * difference);
                    }
                }
                Some(sum / total)
            })
            .collect()
    }

    fn found(&self) -> Vec<Found> {
        (self.costs().into_iter().enumerate())
            .filter_map(|(i, cost)| {
                Some(Found {
                    candidate: i as u32,
                    cost: cost?,
                })
            })
            .collect()
    }

    fn best_matches(&self, tolerance: f32, budget: f32) -> Vec<Found> {
        let mut found = self.found();
        let best = (found.iter()).fold(f32::INFINITY, |best, f| best.min(f.cost));
        found.retain(|f| f.cost <= budget && f.cost <= (1.0 + tolerance) * best);
        found
    }
}

proptest! {
    #[test]
    fn best_matches_are_those_of_a_triple_loop(
        shape in Shape::any(),
        tolerance in prop_oneof![Just(0.0f32), 0.0..2.0f32],
        likely in prop::collection::vec(any::<u32>(), 0..4),
    ) {
        let case = shape.draw();
        let table = case.table();
        let expected = case.best_matches(tolerance, f32::INFINITY);
        let count = case.candidates.len() as u32;
        let likely: Vec<u32> = likely.iter().filter_map(|i| i.checked_rem(count)).collect();
        for parallel in [false, true] {
            let search = Search { tolerance, parallel, ..Search::default() };
            prop_assert_eq!(&best_matches(&table, &case.query, &search, &[]), &expected);
            prop_assert_eq!(&best_matches(&table, &case.query, &search, &likely), &expected);
        }
    }

    #[test]
    fn a_budget_cuts_off_what_costs_more_and_nothing_else(
        shape in Shape::any(),
        tolerance in 0.0..2.0f32,
        picked in any::<prop::sample::Index>(),
        step in -1..2,
    ) {
        let case = shape.draw();
        let viable = case.found();
        prop_assume!(!viable.is_empty());
        let budget = viable[picked.index(viable.len())].cost;
        let budget = match step {
            0 => budget,
            1 => budget.next_up(),
            _ => budget.next_down(),
        };
        for parallel in [false, true] {
            let search = Search { tolerance, budget, parallel };
            let found = best_matches(&case.table(), &case.query, &search, &[]);
            prop_assert_eq!(found, case.best_matches(tolerance, budget));
        }
    }

    #[test]
    fn queries_do_not_mind_each_other(
        shape in Shape::any(),
        count in 0..150usize,
        tolerance in 0.0..2.0f32,
        parallel in any::<bool>(),
    ) {
        let mut case = shape.draw();
        let mut rng = Rng::new(shape.seed, Stage::Synth, 1);
        let asked: Vec<Descriptor> = (0..count)
            .map(|_| shape.descriptor(&mut rng, shape.known))
            .collect();
        let queries: Vec<Query<'_>> = (asked.iter())
            .map(|descriptor| Query { descriptor, likely: &[] })
            .collect();
        let search = Search { tolerance, parallel, ..Search::default() };
        let found = best_matches_of_all(&case.table(), &queries, &search);
        prop_assert_eq!(found.len(), count);
        for (found, query) in found.into_iter().zip(&asked).step_by(17) {
            case.query.clone_from(query);
            prop_assert_eq!(found, case.best_matches(tolerance, f32::INFINITY));
        }
    }

    #[test]
    fn nearest_are_the_first_of_all_sorted(shape in Shape::any(), k in 0..20usize) {
        let case = shape.draw();
        let mut expected = case.found();
        expected.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.candidate.cmp(&b.candidate)));
        expected.truncate(k);
        prop_assert_eq!(nearest(&case.table(), &case.query, k), expected);
    }

    #[test]
    fn the_cost_of_one_candidate_is_that_of_a_search(shape in Shape::any()) {
        let case = shape.draw();
        let table = case.table();
        for (i, expected) in case.costs().into_iter().enumerate() {
            prop_assert_eq!(cost(&table, &case.query, i as u32), expected);
        }
    }

    #[test]
    fn a_known_offset_more_than_a_perfect_match_has_keeps_it_from_winning(
        shape in Shape::any(),
        lacking in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
    ) {
        let shape = Shape { candidates: shape.candidates.max(1), known: 0.5, ..shape };
        let mut case = shape.draw();
        prop_assume!(case.query.known.count() > 0);
        let at = at.index(case.candidates.len());
        let lacking = lacking.index(case.query.known.count());
        let mut perfect = case.query.clone();
        perfect.known.clear();
        for (i, j) in case.query.known.iter().enumerate() {
            if i != lacking {
                perfect.known.set(j);
            }
        }
        case.candidates[at] = perfect;
        let search = Search { tolerance: 10.0, ..Search::default() };
        let found = best_matches(&case.table(), &case.query, &search, &[at as u32]);
        prop_assert!(found.iter().all(|f| f.candidate != at as u32));
        prop_assert_eq!(found, case.best_matches(10.0, f32::INFINITY));
    }
}

/// Of many blocks, so that tasks really run side by side.
fn large() -> Case {
    let shape = Shape {
        seed: 7,
        offsets: 12,
        channels: 1,
        candidates: 20_000,
        known: 0.5,
        complete: 0.8,
        levels: 3,
    };
    shape.draw()
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let case = large();
    let expected = case.best_matches(0.5, f32::INFINITY);
    assert!(expected.len() > 1);
    for threads in [1, 2, 8] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let found = pool.install(|| {
            let search = Search {
                tolerance: 0.5,
                parallel: true,
                ..Search::default()
            };
            best_matches(&case.table(), &case.query, &search, &[])
        });
        assert_eq!(found, expected);
    }
}

#[test]
fn an_empty_query_finds_nothing() {
    let mut case = large();
    case.query.clear();
    let table = case.table();
    assert!(best_matches(&table, &case.query, &Search::default(), &[3]).is_empty());
    assert!(nearest(&table, &case.query, 5).is_empty());
    assert_eq!(cost(&table, &case.query, 0), None);
}

#[test]
fn costs_too_large_for_a_float_are_never_found() {
    let mut query = Descriptor::new(1, 1);
    query.known.set(0);
    let table = Table::build(3, 1, &[1.0], |i, d| {
        d.known.set(0);
        d.values[0] = [1e30, f32::NAN, 2.0][i];
    });
    let search = Search {
        tolerance: f32::INFINITY,
        ..Search::default()
    };
    let found = best_matches(&table, &query, &search, &[]);
    assert_eq!(found.iter().map(|f| f.candidate).collect::<Vec<_>>(), [2]);
}
