use nalgebra::{Rotation3, Vector3};

use super::super::descriptors::angle_of;
use super::super::shape::test_shapes::{grid, icosphere};
use super::super::test_stacks::{identity, nearest, pairing, stack, turned_angle};
use super::*;

#[test]
fn the_identity_stays_the_identity() {
    for (mesh, share) in [
        (icosphere(3), 0.98),
        (grid(24, 24, |x, y| [x, y, (0.3 * x).sin()]), 0.9),
    ] {
        let stack = stack(&mesh);
        let [coarse, fine] = [1, 0].map(|level| pairing(&stack, &stack, level));
        let field = identity(coarse.target.len());
        let field = refined(&coarse, &fine, &stack.hierarchy, 0, &field);
        let mut same = 0;
        for (v, found) in (0u32..).zip(&field) {
            let distance = (fine.target.position(v) - fine.source.position(found.source)).norm();
            assert!(
                distance < 2.5 * f64::from(fine.source.spacing),
                "{distance}"
            );
            same += usize::from(found.source == v);
            assert!(found.source != v || found.turn == 0);
        }
        let found = same as f64 / field.len() as f64;
        assert!(found > share, "{found}");
    }
}

#[test]
fn a_turned_sphere_is_still_turned_on_the_next_level() {
    let stack = stack(&icosphere(3));
    let [coarse, fine] = [1, 0].map(|level| pairing(&stack, &stack, level));
    let turn = Rotation3::new(Vector3::new(0.3, 1.1, -0.4));
    let field: Vec<Match> = numbers(coarse.target.len())
        .map(|v| {
            let place = turn * coarse.target.position(v);
            let source = nearest(coarse.source.surface.positions(), &place);
            let angle = turned_angle(&coarse, v, source, |d| turn * d);
            Match::new(source, turn_of(angle), 0.0)
        })
        .collect();
    let field = refined(&coarse, &fine, &stack.hierarchy, 0, &field);
    let mut turned_otherwise = 0;
    for (v, found) in (0u32..).zip(&field) {
        let place = turn * fine.target.position(v);
        let distance = (fine.source.position(found.source) - place).norm();
        // A vertex of the coarser level is up to two spacings from where it should be.
        assert!(
            distance < 3.0 * f64::from(fine.source.spacing),
            "{distance}"
        );
        let angle = turned_angle(&fine, v, found.source, |d| turn * d);
        let (sin, cos) = (angle - angle_of(usize::from(found.turn))).sin_cos();
        // Rounded twice to whole rotations of 20 degrees.
        turned_otherwise += usize::from(sin.atan2(cos).abs() > 25f32.to_radians());
    }
    assert!(turned_otherwise < 7, "{turned_otherwise} of 642");
}

#[test]
fn only_what_is_allowed_is_found() {
    let stack = stack(&icosphere(3));
    let allowed: Vec<Vec<bool>> = (stack.grounds.iter())
        .map(|ground| {
            ground
                .surface
                .positions()
                .iter()
                .map(|p| p.x > 0.0)
                .collect()
        })
        .collect();
    let [coarse, fine] = [1, 0].map(|level| Pairing {
        allowed: &allowed[level],
        ..pairing(&stack, &stack, level)
    });
    let sources: Vec<u32> = numbers(coarse.source.len())
        .filter(|s| coarse.is_allowed(*s))
        .collect();
    let field: Vec<Match> = (0..coarse.target.len())
        .map(|v| Match::new(sources[v % sources.len()], v % 18, 0.0))
        .collect();
    let field = refined(&coarse, &fine, &stack.hierarchy, 0, &field);
    let not_allowed = field.iter().filter(|m| !fine.is_allowed(m.source)).count();
    assert_eq!(not_allowed, 0);
}
