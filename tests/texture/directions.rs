//! Where the texture's first axis points.

use nalgebra::Vector3;
use relievo::scan::Scan;

use crate::common::samples::{checks, sphere, square, torus, waves};
use crate::common::values;
use crate::{TEXTURE, place, told};

/// The directions of a textured PLY.
fn directions(scan: &Scan) -> Vec<Vector3<f64>> {
    let columns = ["tx", "ty", "tz"].map(|name| values(scan, name));
    (0..scan.vertices.rows)
        .map(|v| Vector3::from([0, 1, 2].map(|k| columns[k][v])))
        .collect()
}

#[test]
fn directions_are_as_asked_for() {
    let flat = place(&square(), &waves());
    for (asked, expected) in [
        ("x", Vector3::x()),
        ("y", Vector3::y()),
        ("-3,4,0", Vector3::new(-0.6, 0.8, 0.0)),
        // Upright on the square is the z axis alone.
        ("0,2,9", Vector3::y()),
    ] {
        let json = told(
            &flat,
            &format!("{TEXTURE} --orientation {asked} -o out.ply"),
        );
        for direction in directions(&flat.scan("out.ply")) {
            assert!((direction - expected).norm() < 1e-3, "{asked}: {direction}");
        }
        assert!(
            json["orientation"]["error"].as_f64() < Some(1e-6),
            "{asked}"
        );
    }
    let json = told(&flat, &format!("{TEXTURE} --orientation random -o out.ply"));
    assert!(json["orientation"]["error"].as_f64() > Some(0.4));
    let directions = directions(&flat.scan("out.ply"));
    let mean = directions.iter().sum::<Vector3<f64>>() / directions.len() as f64;
    assert!(mean.norm() < 0.15, "{mean}");
}

#[test]
fn directions_of_a_textured_mesh_can_be_given_back() {
    let place = place(&sphere(), &waves());
    place.done(&format!("{TEXTURE} -o first.ply"));
    let first = place.scan("first.ply");
    for direction in directions(&first) {
        assert!((direction.norm() - 1.0).abs() < 1e-6);
    }
    let line = "texture first.ply -e sample.png --vertices 300 --orientation first.ply --seed 9";
    place.done(&format!("{line} -o second.ply"));
    let second = place.scan("second.ply");
    assert!(first.faces == second.faces, "it was even already");
    for (a, b) in first.positions().iter().zip(second.positions()) {
        assert!((a - b).norm() < 1e-12, "{a} and {b}");
    }
    for (a, b) in directions(&first).iter().zip(directions(&second)) {
        assert!((a - b).norm() < 1e-5, "{a} and {b}");
    }
}

#[test]
fn turns_around_singularities_sum_to_the_euler_characteristic() {
    for (mesh, characteristic) in [(sphere(), 2.0), (torus(), 0.0)] {
        let place = place(&mesh, &checks());
        for options in [
            "--symmetry 1",
            "--symmetry 2",
            "--symmetry 4",
            "--orientation z",
        ] {
            let json = told(&place, &format!("{TEXTURE} {options} -o out.ply"));
            let found = json["orientation"]["singularities"]
                .as_array()
                .expect("a list");
            let turns = found.iter().map(|s| s["turns"].as_f64().expect("a number"));
            let sum: f64 = turns.sum();
            assert!((sum - characteristic).abs() < 1e-9, "{options}: {found:?}");
        }
    }
}
