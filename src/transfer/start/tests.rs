use nalgebra::{Point3, Rotation3, Vector3};

use super::super::shape::test_shapes::icosphere;
use super::super::test_stacks::{nearest, pairing, stack, turned_angle};
use super::*;

fn sentence(map: &[Option<u32>]) -> String {
    let [source, target] = [icosphere(0), icosphere(1)];
    check(Some(map), &source, &target).unwrap_err().to_string()
}

#[test]
fn maps_that_do_not_fit_are_told_so() {
    assert_eq!(
        sentence(&[Some(0); 12]),
        "the map has 12 entries for the target's 42 vertices: it must have one a vertex"
    );
    let mut map = [Some(3); 42];
    map[7] = Some(12);
    assert_eq!(
        sentence(&map),
        "the map sends vertex 7 of the target to vertex 12 of the source, which has 12 vertices, numbered from 0"
    );
    assert_eq!(
        sentence(&[None; 42]),
        "the map has no entry that is a vertex"
    );
    map[7] = None;
    assert_eq!(check(Some(&map), &icosphere(0), &icosphere(1)), Ok(()));
    assert_eq!(check(None, &icosphere(0), &icosphere(1)), Ok(()));
}

/// The coarsest field of a sphere onto itself, by a map of all its vertices.
fn started(map: &[Option<u32>]) -> (super::super::stack::Stack, Vec<Match>) {
    let mesh = icosphere(3);
    let ready = Ready::new(&mesh, 642);
    let stack = stack(&ready.surface);
    let standing: Vec<u32> = (0..642).collect();
    let start = Start::new(Some(map), [&ready, &ready], &standing);
    assert!(start.is_given());
    let level = stack.levels() - 1;
    let field = start.field(&pairing(&stack, &stack, level), &stack.hierarchy, 1);
    (stack, field)
}

#[test]
fn the_identity_is_the_identity_of_the_coarsest_level() {
    let map: Vec<Option<u32>> = (0..642).map(Some).collect();
    let (_, field) = started(&map);
    assert_eq!(field.len(), 160);
    for (v, found) in (0u32..).zip(&field) {
        assert_eq!((found.source, found.turn), (v, 0));
    }
}

#[test]
fn the_rotation_of_a_map_is_found() {
    let turn = Rotation3::new(Vector3::new(0.2, -0.9, 1.3));
    let positions = icosphere(3).positions;
    let image = |p: &Point3<f64>| Some(nearest(&positions, &(turn * p)));
    let map: Vec<Option<u32>> = positions.iter().map(image).collect();
    let (stack, field) = started(&map);
    let pairing = pairing(&stack, &stack, stack.levels() - 1);
    let mut otherwise = 0;
    for (v, found) in (0u32..).zip(&field) {
        let place = turn * pairing.target.position(v);
        let distance = (pairing.source.position(found.source) - place).norm();
        assert!(
            distance < 2.0 * f64::from(pairing.source.spacing),
            "{distance}"
        );
        let angle = turned_angle(&pairing, v, found.source, |d| turn * d);
        let (sin, cos) = (angle - found.angle()).sin_cos();
        otherwise += usize::from(sin.atan2(cos).abs() > 30f32.to_radians());
    }
    assert!(otherwise < 8, "{otherwise} of 160");
}

#[test]
fn what_the_map_leaves_open_is_at_random() {
    let map: Vec<Option<u32>> = (0..642).map(|v| (v == 5).then_some(v)).collect();
    let (_, field) = started(&map);
    let same = (0u32..).zip(&field).filter(|(v, found)| found.source == *v);
    assert!((1..8).contains(&same.count()));
    let mut sources: Vec<u32> = field.iter().map(|m| m.source).collect();
    sources.sort_unstable();
    sources.dedup();
    assert!(sources.len() > 80, "{}", sources.len());
}
