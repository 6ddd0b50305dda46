use nalgebra::Complex;

use super::*;
use crate::mesh::{euler_characteristic, vertex_normals};
use crate::rng::Stage;
use crate::texture::tests::{plane, slab};

fn connection(mesh: &TriMesh) -> Connection {
    Connection::new(mesh, &vertex_normals(mesh))
}

fn rng() -> Rng {
    Rng::new(3, Stage::Texture, 0)
}

fn sum(found: &[Singularity]) -> f64 {
    found.iter().map(|s| s.turns).sum()
}

#[test]
fn one_direction_is_spread_over_a_plane_without_error() {
    let mesh = plane(12);
    let connection = connection(&mesh);
    for symmetry in [1, 2, 4] {
        let mut field = vec![Complex::default(); mesh.positions.len()];
        let mut pinned = vec![false; field.len()];
        let direction = Vector3::new(0.6, 0.8, 0.0);
        field[40] = connection.to_complex(40, &direction).powu(symmetry);
        pinned[40] = true;
        connection.relax(&mut field, symmetry, &pinned, false);
        assert!(connection.error(&field, symmetry) < 1e-12, "{symmetry}");
        assert!(connection.singularities(&mesh, &field, symmetry).is_empty());
        // One of n directions each, and all of them the same one.
        let branches = connection.branches(&field, symmetry, None);
        let vectors: Vec<_> = (0..field.len())
            .map(|v| connection.to_vector(v, branches[v]))
            .collect();
        for vector in &vectors {
            assert!((vector - vectors[40]).norm() < 1e-5, "{symmetry}: {vector}");
        }
        let angle = vectors[40].angle(&direction) * f64::from(symmetry) / std::f64::consts::TAU;
        assert!((angle - angle.round()).abs() < 1e-9, "{symmetry}: {angle}");
    }
}

#[test]
fn singularities_sum_to_the_euler_characteristic() {
    for holes in [0, 1, 2] {
        let mesh = slab(holes);
        let connection = connection(&mesh);
        let expected = euler_characteristic(&mesh) as f64;
        let pinned = vec![false; mesh.positions.len()];
        for symmetry in [1, 2, 4] {
            let mut field = random(mesh.positions.len(), &mut rng());
            let at_first = connection.singularities(&mesh, &field, symmetry);
            assert!(
                (sum(&at_first) - expected).abs() < 1e-9,
                "random, {holes}, {symmetry}"
            );
            let before = connection.error(&field, symmetry);
            connection.relax(&mut field, symmetry, &pinned, false);
            let after = connection.error(&field, symmetry);
            assert!(
                after < 0.2 * before,
                "{holes}, {symmetry}: {before} to {after}"
            );
            let found = connection.singularities(&mesh, &field, symmetry);
            assert!(
                (sum(&found) - expected).abs() < 1e-9,
                "{holes}, {symmetry}: {found:?}"
            );
            assert!(
                found.len() < at_first.len() / 4,
                "{holes}, {symmetry}: {}",
                found.len()
            );
        }
    }
}

#[test]
fn each_round_of_relaxation_leaves_less_error() {
    let mesh = slab(1);
    let connection = connection(&mesh);
    let pinned = vec![false; mesh.positions.len()];
    let field = random(pinned.len(), &mut rng());
    // Of one vertex after the other: each takes the direction that is best for it.
    let mut all = field.clone();
    let error_of = |field: &[Complex<f64>]| connection.error(field, 2);
    let mut last = error_of(&all);
    for v in (0..pinned.len()).step_by(7) {
        let mut others = vec![true; pinned.len()];
        others[v] = false;
        connection.relax(&mut all, 2, &others, false);
        let error = error_of(&all);
        assert!(error <= last + 1e-12, "{v}: {last} to {error}");
        // No turn of that vertex does better.
        for turn in 1..12 {
            let mut other = all.clone();
            other[v] *= Complex::from_polar(1.0, f64::from(turn) * std::f64::consts::TAU / 12.0);
            assert!(error_of(&other) >= error - 1e-12, "{v}");
        }
        last = error;
    }
}

#[test]
fn branches_follow_what_is_given() {
    let mesh = slab(0);
    let connection = connection(&mesh);
    let given = random(mesh.positions.len(), &mut rng());
    for symmetry in [1, 2, 3, 4] {
        let field: Vec<_> = given.iter().map(|z| z.powu(symmetry)).collect();
        let branches = connection.branches(&field, symmetry, Some(&given));
        for (branch, given) in branches.iter().zip(&given) {
            assert!(
                (branch - given).norm() < 1e-9,
                "{symmetry}: {branch} for {given}"
            );
        }
    }
}
