//! Meshes onto themselves and onto copies of themselves.

use nalgebra::{Rotation3, Vector3};

use super::super::test_stacks::blob;
use super::*;
use crate::mesh::{bisected, vertex_normals};
use crate::rng::{Rng, Stage};

/// Turned about the axis that is up, and three times as large, elsewhere.
fn moved(mesh: &TriMesh) -> TriMesh {
    let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), 0.8);
    let mut mesh = mesh.clone();
    for p in &mut mesh.positions {
        *p = turn * *p * 3.0 + Vector3::new(10.0, -4.0, 2.0);
    }
    mesh
}

/// Where the vertices were before they were moved.
fn moved_back(mesh: &TriMesh) -> TriMesh {
    let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), -0.8);
    let mut mesh = mesh.clone();
    for p in &mut mesh.positions {
        *p = turn * Point3::from((*p - Vector3::new(10.0, -4.0, 2.0)).coords / 3.0);
    }
    mesh
}

/// A mesh's colors come to where they belong on another mesh of its surface, moved.
#[track_caller]
fn assert_same_colors(mesh: &TriMesh, target: &TriMesh) {
    let colors = painted(mesh, 2.0);
    let done = run(&colored(mesh, &colors), target, &TransferParams::default());
    assert_whole(&done, mesh, target);
    let truth = painted(&moved_back(target), 2.0);
    let difference = mean_difference(done.colors.as_ref().unwrap(), &truth);
    assert!(difference < 6.0, "{difference} of 255");
}

/// The same surface, but for its curvature, with its vertices elsewhere on it.
fn jittered(mesh: &TriMesh) -> TriMesh {
    let normals = vertex_normals(mesh);
    let mut rng = Rng::new(1, Stage::Transfer, 0);
    let mut jittered = mesh.clone();
    let edge = crate::mesh::median_edge(mesh).unwrap();
    for (p, normal) in jittered.positions.iter_mut().zip(&normals) {
        let by = Vector3::from([0, 1, 2].map(|_| 0.5 * edge * (rng.uniform() - 0.5)));
        *p += by - normal * normal.dot(&by);
    }
    jittered
}

#[test]
fn a_mesh_gets_its_own_colors_back() {
    let mesh = blob(3);
    let colors = painted(&mesh, 5.0);
    let done = run(&colored(&mesh, &colors), &mesh, &TransferParams::default());
    assert_whole(&done, &mesh, &mesh);
    let difference = mean_difference(done.colors.as_ref().unwrap(), &colors);
    assert!(difference < 2.0, "{difference} of 255");
    assert!(done.report.levels[0].coherent_edges > 0.9);
}

#[test]
fn votes_give_a_mesh_its_own_colors_back_too() {
    let mesh = blob(3);
    let colors = painted(&mesh, 3.0);
    let params = TransferParams {
        last: Last::Vote,
        shape: Shape::Position,
        ..TransferParams::default()
    };
    let done = run(&colored(&mesh, &colors), &mesh, &params);
    let difference = mean_difference(done.colors.as_ref().unwrap(), &colors);
    assert!(difference < 2.0, "{difference} of 255");
}

#[test]
fn a_copy_that_was_turned_enlarged_and_jittered_gets_the_same_colors() {
    let mesh = blob(3);
    let target = moved(&jittered(&mesh));
    assert_same_colors(&mesh, &target);
}

#[test]
fn a_copy_with_other_triangles_gets_the_same_colors() {
    let target = moved(&bisected(&blob(2), 700).mesh);
    assert_same_colors(&blob(3), &target);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mesh = blob(2);
    let colors = painted(&mesh, 4.0);
    let target = moved(&jittered(&mesh));
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let params = TransferParams {
            vertices: Some(300),
            ..TransferParams::default()
        };
        pool.unwrap()
            .install(|| run(&colored(&mesh, &colors), &target, &params))
    });
    assert_eq!(one.colors, three.colors);
    assert_eq!(one.sources, three.sources);
    assert_eq!(one.rotations, three.rotations);
    assert_eq!(one.costs, three.costs);
}

#[test]
fn a_closed_mesh_that_is_inside_out_gets_what_the_right_one_gets() {
    let mesh = blob(2);
    let mut inside_out = mesh.clone();
    for triangle in &mut inside_out.triangles {
        triangle.swap(1, 2);
    }
    let colors = painted(&mesh, 4.0);
    let params = TransferParams::default();
    let right = run(&colored(&mesh, &colors), &mesh, &params);
    let of_source = run(&colored(&inside_out, &colors), &mesh, &params);
    let of_target = run(&colored(&mesh, &colors), &inside_out, &params);
    assert_eq!(right.colors, of_source.colors);
    assert_eq!(right.colors, of_target.colors);
    assert_eq!(of_target.finer.mesh.triangles, inside_out.triangles);
}
