//! Texture by example: from the painted part of a mesh to the rest.

use super::super::shape::test_shapes::icosphere;
use super::super::test_stacks::blob;
use super::*;

/// Colors that cannot be taken for painted ones.
const UNPAINTED: [f64; 3] = [0.0, 1.0, 0.0];

/// Colors without green where it is painted.
fn example(
    mesh: &TriMesh,
    is_painted: impl Fn(&Point3<f64>) -> bool,
) -> (Vec<[f64; 3]>, Vec<bool>) {
    let mask: Vec<bool> = mesh.positions.iter().map(is_painted).collect();
    let waves = painted(mesh, 4.0);
    let color = |(color, is): (&[f64; 3], &bool)| match is {
        true => [color[0], 0.0, color[2]],
        false => UNPAINTED,
    };
    (waves.iter().zip(&mask).map(color).collect(), mask)
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "colors are worked on in single"
)]
fn single(color: &[f64; 3]) -> [u64; 3] {
    color.map(|x| f64::from(x as f32).to_bits())
}

/// What was painted must be there bit by bit, and the rest must be of it.
fn assert_spread(colors: &[[f64; 3]], mask: &[bool], found: &[[f64; 3]]) {
    let mut known: Vec<[u64; 3]> = (colors.iter().zip(mask))
        .filter(|(_, painted)| **painted)
        .map(|(color, _)| single(color))
        .collect();
    known.sort_unstable();
    let mut leaks = 0;
    for ((color, own), painted) in found.iter().zip(colors).zip(mask) {
        if *painted {
            assert_eq!(color.map(f64::to_bits), single(own));
        } else {
            leaks += usize::from(known.binary_search(&color.map(f64::to_bits)).is_err());
        }
    }
    assert_eq!(leaks, 0, "colors that are not of the painted part");
}

#[test]
fn what_is_painted_stays_and_the_rest_is_of_it() {
    for mesh in [icosphere(3), blob(3)] {
        let (colors, mask) = example(&mesh, |p| p.x > 0.1);
        let params = TransferParams {
            rounds: 2,
            shape: Shape::Position,
            ..TransferParams::default()
        };
        let done = spread(&colored(&mesh, &colors), &mask, &params, &mut |_| {});
        let done = done.unwrap();
        assert_whole(&done, &mesh, &mesh);
        assert_spread(&colors, &mask, done.colors.as_ref().unwrap());
    }
}

#[test]
fn a_narrow_band_a_spot_and_single_vertices_are_enough() {
    let mesh = blob(3);
    let bands: [fn(&Point3<f64>) -> bool; 4] = [
        |p| p.x.abs() < 0.12,
        |p| p.z.abs() < 0.35,
        |p| (p - Point3::new(1.3, 0.0, 0.0)).norm() < 0.5,
        |p| (40.0 * p.x).sin() + (37.0 * p.y).cos() > 1.8,
    ];
    for is_painted in bands {
        let (colors, mask) = example(&mesh, is_painted);
        let params = TransferParams {
            rounds: 1,
            shape: Shape::Position,
            ..TransferParams::default()
        };
        let done = spread(&colored(&mesh, &colors), &mask, &params, &mut |_| {});
        assert_spread(&colors, &mask, done.unwrap().colors.as_ref().unwrap());
    }
}

#[test]
fn votes_leave_what_is_painted_as_it_is() {
    let mesh = icosphere(2);
    let (colors, mask) = example(&mesh, |p| p.y > -0.2);
    let params = TransferParams {
        last: Last::Vote,
        shape: Shape::Position,
        ..TransferParams::default()
    };
    let done = spread(&colored(&mesh, &colors), &mask, &params, &mut |_| {}).unwrap();
    for ((color, own), painted) in (done.colors.unwrap().iter().zip(&colors)).zip(&mask) {
        if *painted {
            assert_eq!(color.map(f64::to_bits), single(own));
        }
    }
}

#[test]
fn nothing_or_all_painted_is_told() {
    let mut mesh = icosphere(1);
    mesh.positions.push(Point3::new(4.0, 0.0, 0.0));
    let colors = painted(&mesh, 1.0);
    let params = TransferParams::default();
    let error =
        |mask: &[bool]| spread(&colored(&mesh, &colors), mask, &params, &mut |_| {}).unwrap_err();
    // Vertices without faces do not count.
    let mut mask = vec![false; 43];
    mask[42] = true;
    assert_eq!(error(&mask), TransferError::NothingPainted);
    let mut mask = vec![true; 43];
    mask[42] = false;
    assert_eq!(error(&mask), TransferError::AllPainted);
}

#[test]
fn what_is_painted_stays_at_every_scale_and_number_of_vertices() {
    let mesh = blob(2);
    let (colors, mask) = example(&mesh, |p| p.x > 0.0);
    for (scale, vertices) in [(2.0, None), (0.5, None), (1.0, Some(400))] {
        let params = TransferParams {
            scale,
            vertices,
            rounds: 1,
            shape: Shape::Position,
            ..TransferParams::default()
        };
        let done = spread(&colored(&mesh, &colors), &mask, &params, &mut |_| {});
        let found = done.unwrap().colors.unwrap();
        for ((color, own), painted) in found.iter().zip(&colors).zip(&mask) {
            if *painted {
                assert_eq!(color.map(f64::to_bits), single(own), "scale {scale}");
            }
        }
    }
}
