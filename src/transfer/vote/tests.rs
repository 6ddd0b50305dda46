use super::super::shape::test_shapes::{grid, icosphere};
use super::super::test_stacks::{identity, noise, pairing, stack};
use super::*;

#[test]
fn a_field_that_is_the_identity_votes_for_what_is_there() {
    let stack = stack(&icosphere(3));
    let pairing = pairing(&stack, &stack, 0);
    #[expect(clippy::cast_possible_truncation, reason = "values are single")]
    let values: Vec<f32> = (pairing.source.surface.positions().iter())
        .flat_map(|p| [(2.0 * p.x).sin() as f32, p.z as f32])
        .collect();
    let voted = voted(&pairing, &identity(642), &values, 2, &[]);
    let largest = (voted.iter().zip(&values)).map(|(a, b)| (a - b).abs());
    let largest = largest.fold(0.0, f32::max);
    assert!(largest < 0.01, "{largest}");
}

#[test]
fn in_a_plane_the_identity_votes_for_exactly_what_is_there() {
    let stack = stack(&grid(14, 14, |x, y| [x, y, 0.0]));
    let pairing = pairing(&stack, &stack, 0);
    // Patches end on vertices: where all agree, nothing is mixed, be values as rough as they like.
    let values = noise(2, 196);
    let voted = voted(&pairing, &identity(196), &values, 1, &[]);
    for (v, (a, b)) in voted.iter().zip(&values).enumerate() {
        assert!((a - b).abs() < 1e-3, "{v}: {a}, {b}");
    }
}

#[test]
fn a_constant_stays_constant_wherever_it_comes_from() {
    let flat = grid(14, 14, |x, y| [x, y, 0.0]);
    for (mesh, count) in [(icosphere(2), 162), (flat, 196)] {
        let stack = stack(&mesh);
        let pairing = pairing(&stack, &stack, 0);
        let values = [0.25, 0.75].repeat(count);
        let random = noise(4, 3 * count);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to what there is"
        )]
        let field: Vec<Match> = (random.as_chunks::<3>().0.iter())
            .map(|[s, turn, cost]| {
                Match::new((s * count as f32) as u32, (turn * 18.0) as usize, *cost)
            })
            .collect();
        for row in voted(&pairing, &field, &values, 2, &[]).as_chunks::<2>().0 {
            assert!(
                (row[0] - 0.25).abs() < 1e-5 && (row[1] - 0.75).abs() < 1e-5,
                "{row:?}"
            );
        }
    }
}

#[test]
fn matches_on_a_rim_that_look_off_the_surface_still_have_a_vote() {
    let stack = stack(&grid(14, 14, |x, y| [x, y, 0.0]));
    let pairing = pairing(&stack, &stack, 0);
    let values = noise(6, 196);
    let corners = [0, 13, 182, 195];
    for source in corners {
        for turn in 0..18 {
            let field = vec![Match::new(source, turn, 1.0); 196];
            let voted = voted(&pairing, &field, &values, 1, &[]);
            assert!(
                voted.iter().all(|x| (0.0..=1.0).contains(x)),
                "{source}, {turn}"
            );
        }
    }
}

#[test]
fn what_is_pinned_keeps_what_is_known_of_it() {
    let stack = stack(&icosphere(2));
    let pinned: Vec<bool> = (0..162).map(|v| v % 3 == 0).collect();
    let pairing = Pairing {
        pinned: &pinned,
        ..pairing(&stack, &stack, 0)
    };
    let (values, known) = (vec![0.5; 162], noise(1, 162));
    let voted = voted(&pairing, &identity(162), &values, 1, &known);
    for v in 0..162 {
        if pinned[v] {
            assert_eq!(voted[v].to_bits(), known[v].to_bits());
        } else {
            assert!((voted[v] - 0.5).abs() < 1e-5);
        }
    }
}

#[test]
fn what_fits_well_outvotes_what_does_not() {
    let stack = stack(&icosphere(2));
    let pairing = pairing(&stack, &stack, 0);
    let mut values = vec![1.0; 162];
    let source = u32::from(40u8);
    // What fits badly leads to a place where all is 0.
    let place = pairing.source.position(source);
    for (value, p) in values.iter_mut().zip(pairing.source.surface.positions()) {
        if (p - place).norm() < 1.0 {
            *value = 0.0;
        }
    }
    let far = (0u32..162)
        .find(|v| (pairing.source.position(*v) - place).norm() > 1.9)
        .unwrap();
    let mut field = vec![Match::new(source, 0, 1.0); 162];
    field[20] = Match::new(far, 0, 0.0);
    let by_cost = voted(&pairing, &field, &values, 1, &[]);
    assert!(by_cost[20] > 0.75, "{}", by_cost[20]);
    field[20].cost = 1.0;
    let alike = voted(&pairing, &field, &values, 1, &[]);
    assert!(alike[20] < 0.3, "one of many: {}", alike[20]);
}
