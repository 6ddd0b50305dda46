//! Meshes that are not one closed surface of some hundred vertices, and what cannot be asked for.

use super::super::shape::test_shapes::{grid, icosphere, together};
use super::super::test_stacks::blob;
use super::*;

/// Every color that arrives must be one of the source's, if that has vertices enough.
fn assert_of_source(done: &Transferred, colors: &[[f64; 3]]) {
    for (color, s) in done.colors.as_ref().unwrap().iter().zip(&done.sources) {
        let own = colors[*s as usize];
        assert!((0..3).all(|k| (color[k] - own[k]).abs() < 1e-6));
    }
}

#[test]
fn a_shape_that_is_the_same_everywhere_is_no_obstacle() {
    let mesh = icosphere(2);
    let colors = painted(&mesh, 3.0);
    for up in [[Some(nalgebra::Vector3::y()); 2], [None; 2]] {
        let params = TransferParams {
            up,
            ..TransferParams::default()
        };
        let done = run(&colored(&mesh, &colors), &mesh, &params);
        assert_whole(&done, &mesh, &mesh);
        assert_of_source(&done, &colors);
    }
}

#[test]
fn pieces_holes_and_loose_vertices_are_no_obstacle() {
    let mesh = blob(2);
    let colors = painted(&mesh, 3.0);
    let mut other = icosphere(2);
    other.positions.iter_mut().for_each(|p| p.z += 4.0);
    let mut target = together(mesh.clone(), &other);
    target.triangles.drain(20..26);
    target.positions.push(Point3::new(0.0, 9.0, 0.0));
    let params = TransferParams::default();
    let done = run(&colored(&mesh, &colors), &target, &params);
    assert_whole(&done, &mesh, &target);
    // And the other way round.
    let colors = painted(&target, 3.0);
    let done = run(&colored(&target, &colors), &mesh, &params);
    assert_whole(&done, &target, &mesh);
    assert_of_source(&done, &colors);
}

#[test]
fn three_faces_and_one_are_enough() {
    let mesh = blob(2);
    let colors = painted(&mesh, 3.0);
    let mut cap = icosphere(0);
    cap.triangles.truncate(3);
    let mut one = grid(2, 2, |x, y| [x, y, 0.0]);
    one.triangles.truncate(1);
    for target in [cap, one] {
        for vertices in [None, Some(3)] {
            let params = TransferParams {
                vertices,
                ..TransferParams::default()
            };
            let done = run(&colored(&mesh, &colors), &target, &params);
            assert_whole(&done, &mesh, &target);
            let own = painted(&target, 3.0);
            let back = run(&colored(&target, &own), &mesh, &params);
            assert_whole(&back, &target, &mesh);
        }
    }
}

#[test]
fn edges_of_three_triangles_and_triangles_without_area_are_no_obstacle() {
    let mesh = blob(2);
    let colors = painted(&mesh, 3.0);
    let mut target = grid(14, 14, |x, y| [x, y, 0.2 * x.sin()]);
    let fin = u32::try_from(target.positions.len()).unwrap();
    target.positions.push(Point3::new(6.5, 6.0, 3.0));
    target.triangles.extend([[90, 91, fin], [0, 1, 2]]);
    let done = run(
        &colored(&mesh, &colors),
        &target,
        &TransferParams::default(),
    );
    assert_whole(&done, &mesh, &target);
}

#[test]
fn every_scale_that_may_be_asked_for_can_be_done() {
    let mesh = blob(2);
    let colors = painted(&mesh, 3.0);
    for scale in [1.0 / 16.0, 0.5, 2.0] {
        let params = TransferParams {
            scale,
            vertices: Some(170),
            rounds: 1,
            shape: Shape::Position,
            ..TransferParams::default()
        };
        let done = run(&colored(&mesh, &colors), &mesh, &params);
        assert_whole(&done, &mesh, &mesh);
    }
}

#[test]
fn a_map_is_where_the_search_begins() {
    let mesh = blob(2);
    let colors = painted(&mesh, 3.0);
    let map: Vec<Option<u32>> = (0..162).map(Some).collect();
    let params = TransferParams {
        rounds: 1,
        ..TransferParams::default()
    };
    let source = colored(&mesh, &colors);
    let done = transfer(&source, &mesh, Some(&map), &params, &mut |_| {}).unwrap();
    let same = (0u32..).zip(&done.sources).filter(|(v, s)| v == *s).count();
    assert!(same > 155, "{same} of 162");
    let long = transfer(&source, &mesh, Some(&map[1..]), &params, &mut |_| {});
    let error = TransferError::MapLength {
        given: 161,
        vertices: 162,
    };
    assert_eq!(long.unwrap_err(), error);
}

#[test]
fn what_cannot_be_done_is_told() {
    let mesh = icosphere(1);
    let colors = painted(&mesh, 3.0);
    let points = TriMesh {
        positions: mesh.positions.clone(),
        triangles: Vec::new(),
    };
    let params = TransferParams::default();
    let error = |source: &Source, target: &TriMesh| {
        transfer(source, target, None, &params, &mut |_| {}).unwrap_err()
    };
    let whole = colored(&mesh, &colors);
    assert_eq!(
        error(&whole, &points),
        TransferError::NoFaces { of_source: false }
    );
    assert_eq!(
        error(&colored(&points, &colors), &mesh),
        TransferError::NoFaces { of_source: true }
    );
    let bare = Source {
        mesh: &mesh,
        colors: None,
        heights: None,
    };
    assert_eq!(error(&bare, &mesh), TransferError::NoValues);
    let mut gaps = colors.clone();
    gaps[4][1] = f64::NAN;
    assert_eq!(
        error(&colored(&mesh, &gaps), &mesh),
        TransferError::NotFinite
    );
}
