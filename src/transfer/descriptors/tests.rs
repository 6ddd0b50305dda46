use super::super::shape::test_shapes::{grid, icosphere};
use super::super::test_stacks::noise;
use super::*;

/// Random values and features with random factors, on a sphere.
fn described(seed: u32, values: usize, features: usize) -> Descriptors {
    let ground = Ground::new(icosphere(2));
    let count = ground.len();
    let positive = |seed: u32, count: usize| noise(seed, count).iter().map(|x| x + 0.2).collect();
    let factors = Factors {
        values: positive(7, values),
        features: positive(8, features),
        gradients: positive(9, features),
    };
    let gradients: Vec<[f32; 2]> = (noise(seed + 2, 2 * count * features).as_chunks::<2>().0)
        .iter()
        .map(|g| g.map(|x| x - 0.5))
        .collect();
    Descriptors::new(
        &ground,
        &noise(seed, count * values),
        &noise(seed + 1, count * features),
        &gradients,
        &factors,
    )
}

/// The cost by its definition: the target's direction θ is the source's θ + 2π `turn` / 18.
fn by_definition(target: &[f32], source: &[f32], [c, k]: [usize; 2], turn: usize) -> f64 {
    let sq = |a: f32, b: f32| f64::from(a - b).powi(2);
    let mut cost: f64 = (0..c).map(|i| sq(target[i], source[i])).sum();
    for ring in 0..RINGS {
        for spoke in 0..SPOKES {
            let at = |spoke: usize| c + (ring * SPOKES + spoke % SPOKES) * c;
            let (t, s) = (at(spoke), at(spoke + turn));
            cost += (0..c)
                .map(|i| sq(target[t + i], source[s + i]))
                .sum::<f64>();
        }
    }
    let shape = c * (1 + RINGS * SPOKES);
    cost += (shape..shape + k)
        .map(|i| sq(target[i], source[i]))
        .sum::<f64>();
    let (sin, cos) = (std::f32::consts::TAU * turn as f32 / SPOKES as f32).sin_cos();
    for i in (shape + k..shape + 3 * k).step_by(2) {
        let [x, y] = [target[i], target[i + 1]];
        cost += sq(cos * x - sin * y, source[i]) + sq(sin * x + cos * y, source[i + 1]);
    }
    cost
}

/// Of some pairs of vertices the costs in all rotations.
fn some_costs(sizes: [usize; 2], mut look: impl FnMut(&Query, &Descriptors, u32, [f64; SPOKES])) {
    let [of_target, of_source] = [10, 20].map(|seed| described(seed, sizes[0], sizes[1]));
    let mut query = Query::default();
    for v in (0..160u32).step_by(7) {
        query.set(&of_target, v);
        for s in (0..160u32).step_by(11) {
            let rows = (of_target.row(v), of_source.row(s));
            let truth = std::array::from_fn(|turn| by_definition(rows.0, rows.1, sizes, turn));
            look(&query, &of_source, s, truth);
        }
    }
}

fn least(costs: [f64; SPOKES]) -> f64 {
    costs.into_iter().fold(f64::INFINITY, f64::min)
}

const SIZES: [[usize; 2]; 5] = [[1, 0], [3, 0], [4, 9], [0, 2], [3, 1]];

#[test]
fn costs_in_all_rotations_are_those_of_the_definition() {
    for sizes in SIZES {
        some_costs(sizes, |query, of_source, s, truth| {
            for (turn, truth) in truth.into_iter().enumerate() {
                let cost = f64::from(query.cost(of_source, s, turn, f32::INFINITY));
                assert!(
                    (cost - truth).abs() < 1e-4 * (1.0 + truth),
                    "{cost}, {truth}"
                );
            }
        });
    }
}

#[test]
fn the_best_rotation_is_that_of_the_least_cost() {
    for sizes in SIZES {
        some_costs(sizes, |query, of_source, s, truth| {
            let (turn, cost) = query.best(of_source, s, f32::INFINITY);
            let tolerance = 1e-4 * (1.0 + least(truth));
            assert!((f64::from(cost) - least(truth)).abs() < tolerance);
            assert!((truth[turn] - least(truth)).abs() < tolerance);
            let again = query.cost(of_source, s, turn, f32::INFINITY);
            assert!((again - cost).abs() <= f32::EPSILON * cost);
        });
    }
}

#[test]
fn below_the_limit_costs_are_exact_and_else_not_below_it() {
    for sizes in SIZES {
        some_costs(sizes, |query, of_source, s, truth| {
            let (best_turn, best) = query.best(of_source, s, f32::INFINITY);
            for share in [0.5, 0.9, 0.99, 1.01, 1.5] {
                let limit = best * share;
                let (turn, cost) = query.best(of_source, s, limit);
                if share > 1.0 {
                    assert_eq!((turn, cost.to_bits()), (best_turn, best.to_bits()));
                } else {
                    assert!(cost >= limit, "{cost} below {limit}");
                }
                for (turn, truth) in truth.into_iter().enumerate() {
                    let whole = query.cost(of_source, s, turn, f32::INFINITY);
                    let cost = query.cost(of_source, s, turn, limit);
                    if whole < limit {
                        assert_eq!(cost.to_bits(), whole.to_bits());
                    } else {
                        assert!(cost >= limit && cost <= whole);
                    }
                    assert!(f64::from(cost) <= truth * 1.0001 + 1e-4);
                }
            }
        });
    }
}

#[test]
fn a_vertex_costs_nothing_against_itself() {
    let own = described(5, 3, 4);
    let mut query = Query::default();
    for v in 0..162 {
        query.set(&own, v);
        assert!(query.cost(&own, v, 0, f32::INFINITY) < 1e-4);
        assert!(query.best(&own, v, f32::INFINITY).1 < 1e-4);
    }
}

#[test]
fn independent_values_of_variance_1_differ_by_2() {
    assert!((ring_weights().iter().sum::<f32>() - 1.0).abs() < 1e-6);
    let ground = Ground::new(icosphere(2));
    let factors = Factors {
        values: vec![1.0],
        features: Vec::new(),
        gradients: Vec::new(),
    };
    // Constants: nothing is lost by reading between the vertices.
    let of = |value: f32| {
        let values = vec![value; ground.len()];
        Descriptors::new(&ground, &values, &[], &[], &factors)
    };
    let (zero, three) = (of(0.0), of(3.0));
    let mut query = Query::default();
    query.set(&zero, 17);
    assert!((query.cost(&three, 50, 4, f32::INFINITY) - 9.0).abs() < 1e-4);
}

#[test]
fn rotations_and_angles_are_the_same_thing() {
    for turn in 0..SPOKES {
        let angle = angle_of(turn);
        for by in [-0.17f32, 0.0, 0.17] {
            for turns in [-1.0, 0.0, 2.0] {
                let angle = angle + by + turns * std::f32::consts::TAU;
                assert_eq!(turn_of(angle), turn);
            }
        }
    }
}

#[test]
fn gradients_of_a_linear_function_are_its_slope_per_spacing() {
    let ground = Ground::new(grid(20, 20, |x, y| [0.1 * x, 0.1 * y, 0.0]));
    let slopes = [
        nalgebra::Vector3::new(3.0, -2.0, 0.0),
        nalgebra::Vector3::y(),
    ];
    #[expect(clippy::cast_possible_truncation, reason = "features are single")]
    let features: Vec<f32> = (ground.surface.positions().iter())
        .flat_map(|p| slopes.map(|slope| slope.dot(&p.coords) as f32))
        .collect();
    let all = gradients(&ground, &features, 2);
    let mut inner = 0;
    for (v, found) in (0u32..).zip(all.as_chunks::<2>().0) {
        let p = ground.position(v);
        if [p.x, p.y].iter().any(|x| !(0.35..1.55).contains(x)) {
            continue;
        }
        inner += 1;
        for (slope, [x, y]) in slopes.iter().zip(found) {
            let (angle, length) = ground.polar(v, slope);
            let (sin, cos) = angle.sin_cos();
            let size = length * ground.spacing;
            assert!((x - size * cos).abs() < 1e-4 && (y - size * sin).abs() < 1e-4);
        }
    }
    assert!(inner > 100);
}
