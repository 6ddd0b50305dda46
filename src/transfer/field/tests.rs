use super::super::shape::test_shapes::icosphere;
use super::super::stack::Stack;
use super::super::test_stacks::{noise, of_values, pairing, stack};
use super::*;
use crate::rng::{Rng, Stage};

/// A sphere with random values on it, to be found again on itself.
struct Found {
    stack: Stack,
    own: Descriptors,
}

impl Found {
    fn new() -> Self {
        let stack = stack(&icosphere(3));
        let own = of_values(&stack, 0, &noise(1, stack.grounds[0].len()));
        Self { stack, own }
    }

    fn pairing(&self) -> Pairing<'_> {
        pairing(&self.stack, &self.stack, 0)
    }

    fn search(&self, rotations: Rotations) -> Search<'_> {
        Search {
            of_target: &self.own,
            of_source: &self.own,
            rotations,
            coherence: 0.0,
            overuse: 0.0,
            seed: 5,
        }
    }

    /// Matches at random, with their costs.
    fn random(&self, pairing: &Pairing) -> Vec<Match> {
        let mut rng = Rng::new(3, Stage::Transfer, 1);
        let count = self.stack.grounds[0].len();
        let allowed: Vec<u32> = numbers(count).filter(|s| pairing.is_allowed(*s)).collect();
        let mut field: Vec<Match> = (0..count)
            .map(|_| Match::new(allowed[rng.index(allowed.len())], rng.index(SPOKES), 0.0))
            .collect();
        rated(pairing, &self.own, &self.own, &mut field);
        field
    }

    /// The fields after each of so many rounds, beginning with random ones.
    fn rounds(&self, pairing: &Pairing, search: &Search, rounds: u32) -> Vec<Vec<Match>> {
        let order = Order::new(pairing.target);
        let mut fields = vec![self.random(pairing)];
        for round in 0..rounds {
            let last = &fields[fields.len() - 1];
            fields.push(improved(pairing, &order, last, search, round));
        }
        fields
    }
}

fn mean(field: &[Match]) -> f32 {
    field.iter().map(|m| m.cost).sum::<f32>() / field.len() as f32
}

/// Share of the vertices that are matched with themselves, as they lie.
fn identical(field: &[Match]) -> f64 {
    let own = (0u32..)
        .zip(field)
        .filter(|(v, m)| (m.source, m.turn) == (*v, 0));
    own.count() as f64 / field.len() as f64
}

#[test]
fn the_order_has_every_vertex_once() {
    let found = Found::new();
    let order = Order::new(&found.stack.grounds[0]);
    let mut sorted = order.vertices.clone();
    sorted.sort_unstable();
    assert!((0u32..642).eq(sorted));
    for (i, v) in (0u32..).zip(&order.vertices) {
        assert_eq!(order.place[*v as usize], i);
    }
}

#[test]
fn noise_on_a_sphere_is_found_where_it_is() {
    let found = Found::new();
    let pairing = found.pairing();
    let fields = found.rounds(&pairing, &found.search(Rotations::All), 4);
    let last = &fields[4];
    assert!(identical(&fields[0]) < 0.02);
    assert!(identical(last) > 0.98, "{}", identical(last));
    assert!(mean(last) < 0.02 * mean(&fields[0]));
    assert!(coherent_edges(&pairing, last) > 0.97);
}

#[test]
fn rotations_that_are_searched_for_find_as_much() {
    let found = Found::new();
    let fields = found.rounds(&found.pairing(), &found.search(Rotations::Search), 10);
    assert!(identical(&fields[10]) > 0.95, "{}", identical(&fields[10]));
}

#[test]
fn no_match_becomes_worse_and_costs_are_those_of_the_matches() {
    let found = Found::new();
    let pairing = found.pairing();
    for rotations in [Rotations::All, Rotations::Search] {
        let fields = found.rounds(&pairing, &found.search(rotations), 2);
        for pair in fields.windows(2) {
            for (before, after) in pair[0].iter().zip(&pair[1]) {
                assert!(after.cost <= before.cost);
            }
            let mut again = pair[1].clone();
            rated(&pairing, &found.own, &found.own, &mut again);
            for (told, true_one) in pair[1].iter().zip(&again) {
                assert!((told.cost - true_one.cost).abs() < 1e-5 * (1.0 + told.cost));
            }
        }
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let found = Found::new();
    let pairing = found.pairing();
    let search = Search {
        coherence: 0.3,
        overuse: 0.02,
        ..found.search(Rotations::All)
    };
    let [one, two, five] = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| found.rounds(&pairing, &search, 2))
    });
    assert_eq!(one, two);
    assert_eq!(one, five);
    assert_ne!(one[1], one[0], "something was found");
}

#[test]
fn nothing_costs_less_than_the_best_of_all() {
    let found = Found::new();
    let pairing = found.pairing();
    let fields = found.rounds(&pairing, &found.search(Rotations::All), 1);
    let some: Vec<u32> = (0..642).step_by(40).collect();
    // From matches that are worth nothing, so that it has to find all by itself.
    let nothing = vec![Match::new(0, 0, f32::INFINITY); 642];
    let best = exhaustive(&pairing, &found.own, &found.own, &nothing, &some);
    for (v, best) in some.iter().zip(&best) {
        assert_eq!((best.source, best.turn), (*v, 0));
        for field in &fields {
            assert!(best.cost <= field[*v as usize].cost);
        }
    }
    let audit = audited(&pairing, &found.own, &found.own, &fields[0], 16);
    assert!(audit.vertices >= 16 && audit.least_cost < 1e-5 && audit.mean_cost > 0.01);
}

#[test]
fn only_what_is_allowed_is_taken_and_what_is_pinned_stays() {
    let found = Found::new();
    let positions = found.stack.grounds[0].surface.positions();
    let allowed: Vec<bool> = positions.iter().map(|p| p.x > 0.0).collect();
    let pinned: Vec<bool> = positions.iter().map(|p| p.y > 0.5).collect();
    let pairing = Pairing {
        allowed: &allowed,
        pinned: &pinned,
        ..found.pairing()
    };
    let fields = found.rounds(&pairing, &found.search(Rotations::All), 2);
    let mut others = 0;
    for (v, m) in fields[2].iter().enumerate() {
        assert!(allowed[m.source as usize]);
        if pinned[v] {
            assert_eq!(*m, fields[0][v]);
            assert!(m.cost.abs() < f32::EPSILON, "what is pinned costs nothing");
        } else {
            others += usize::from(m.source != fields[0][v].source);
        }
    }
    assert!(others > 200);
    let nothing = vec![Match::new(0, 0, f32::INFINITY); 642];
    let some: Vec<u32> = (0..642).step_by(80).collect();
    let best = exhaustive(&pairing, &found.own, &found.own, &nothing, &some);
    assert!(best.iter().all(|m| allowed[m.source as usize]));
}

#[test]
fn what_is_used_much_is_penalized() {
    let found = Found::new();
    let pairing = found.pairing();
    // One vertex for all: 642 times as much as is its due, together with its family.
    let field = vec![Match::new(7, 0, 1.0); 642];
    let own = penalties(&pairing, &field, 0.5);
    let family: Vec<usize> = (0..642).filter(|s| own[*s] > 0.0).collect();
    assert!(family.contains(&7) && family.len() < 40, "{family:?}");
    let expected = 0.5 * (642.0 / family.len() as f32 - 1.0);
    assert!((own[7] - expected).abs() < 1e-3 * expected);
    let even = super::super::test_stacks::identity(642);
    assert!(
        penalties(&pairing, &even, 0.5)
            .iter()
            .all(|p| p.abs() < 1e-6)
    );
    assert!(penalties(&pairing, &field, 0.0).is_empty());
}
