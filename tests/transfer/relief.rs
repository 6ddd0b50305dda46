//! Relief of one mesh on another.

use std::f64::consts::TAU;

use relievo::mesh::vertex_normals;
use relievo::scan::Column;

use crate::common::place::Place;
use crate::common::samples::{colors, together};
use crate::common::{to_scan, values};
use crate::shapes::{ball, body, colored, hues, plate};
use crate::told;

/// Root mean square.
fn size(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Waves, 0.02 high and a tenth of the plate long.
fn waves(x: f64, y: f64) -> f64 {
    0.02 * (10.0 * TAU * x).sin() * (10.0 * TAU * y).sin()
}

const RELIEF: &str = "transfer --source source.ply --target target.ply --channel height --form-wavelength 0.3 --up none";

#[test]
fn relief_is_as_high_on_the_target_against_its_size() {
    let place = Place::with("source.ply", &to_scan(&plate(40, waves)));
    let of_source = size(&values(&place.scan("source.ply"), "z"));
    for (what, target, factor) in [
        ("a plate of the same size", plate(40, |_, _| 0.0), 1.0),
        ("a ball", ball(20), TAU.sqrt() * 2f64.sqrt()),
    ] {
        place.put("target.ply", &to_scan(&target));
        let json = told(&place, &format!("{RELIEF} -o out.ply"));
        assert_eq!(json["displaced"], 1.0);
        assert_eq!(json["form_wavelength"], 0.3);
        let out = place.scan("out.ply");
        let heights = values(&out, "height");
        let share = size(&heights) / (factor * of_source);
        assert!((0.7..=1.3).contains(&share), "{what}: {share}");
        // The target's own vertices have moved along their normals by as much.
        place.done(&format!("{RELIEF} --displace 0 -o flat.ply"));
        let flat = place.scan("flat.ply");
        let normals = vertex_normals(&flat.mesh());
        for (v, (from, to)) in flat.positions().iter().zip(out.positions()).enumerate() {
            let expected = normals[v] * heights[v];
            assert!((to - from - expected).norm() < 1e-9, "{what}: vertex {v}");
        }
        assert!(out.colors().is_none(), "{what}");
    }
}

#[test]
fn a_target_that_is_kept_gets_relief_at_its_own_vertices() {
    let place = Place::with("source.ply", &to_scan(&plate(40, waves)));
    let target = ball(12);
    place.put("target.ply", &to_scan(&target));
    place.done(&format!("{RELIEF} --keep-mesh --displace -2 -o out.ply"));
    let out = place.scan("out.ply");
    assert_eq!(out.vertices.rows, target.positions.len());
    let (normals, heights) = (vertex_normals(&target), values(&out, "height"));
    for (v, (from, to)) in target.positions.iter().zip(out.positions()).enumerate() {
        let expected = normals[v] * (-2.0 * heights[v]);
        assert!((to - from - expected).norm() < 1e-9, "vertex {v}");
    }
}

#[test]
fn relief_does_not_open_seams() {
    let place = Place::with("source.ply", &to_scan(&plate(40, waves)));
    // Each half has its own vertices along the cut.
    let whole = ball(10);
    let halves = [-1.0, 1.0].map(|side| {
        let is_there = |triangle: &&[u32; 3]| {
            let sum: f64 = (triangle.iter())
                .map(|v| whole.positions[*v as usize].x)
                .sum();
            sum * side > 0.0
        };
        relievo::mesh::TriMesh {
            positions: whole.positions.clone(),
            triangles: whole.triangles.iter().filter(is_there).copied().collect(),
        }
    });
    let target = together(&halves);
    place.put("target.ply", &to_scan(&target));
    for options in ["--keep-mesh", ""] {
        place.done(&format!("{RELIEF} {options} -o out.ply"));
        let out = place.scan("out.ply");
        let positions = out.positions();
        let count = whole.positions.len();
        let mut moved = 0;
        for v in 0..count {
            let apart = (positions[v] - positions[v + count]).norm();
            assert!(apart <= 0.0, "vertex {v} is {apart} from its twin");
            moved += usize::from((positions[v] - whole.positions[v]).norm() > 0.0);
        }
        assert!(moved * 2 > count, "{moved} of {count}");
    }
}

#[test]
fn colors_and_relief_are_of_the_same_places() {
    let source = colored(&plate(60, waves), |p| [0.5 + p.x, 0.5 + p.y, 0.2]);
    let place = Place::with("source.ply", &source);
    place.put("target.ply", &to_scan(&ball(24)));
    place.done(&format!("{RELIEF} -o heights.ply").replace("height ", "both "));
    let out = place.scan("heights.ply");
    let (of_source, found) = (colors(&source), colors(&out));
    let z = values(&source, "z");
    let heights = values(&out, "height");
    let mut pairs = Vec::new();
    for (v, source) in values(&out, "source").iter().enumerate() {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of a vertex"
        )]
        let source = *source as usize;
        assert_eq!(found[v], of_source[source], "vertex {v}");
        pairs.push((heights[v], z[source]));
    }
    // The form is not exactly flat near the rim.
    let correlation = correlation(&pairs);
    assert!(correlation > 0.95, "{correlation}");
}

fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let count = pairs.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>() / count;
    let (a, b) = (mean(|p| p.0), mean(|p| p.1));
    let sum =
        |f: &dyn Fn(f64, f64) -> f64| -> f64 { pairs.iter().map(|(x, y)| f(x - a, y - b)).sum() };
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
}

#[test]
fn relief_that_is_painted_spreads_and_what_is_painted_does_not_move() {
    let is_painted = |x: f64| x < 0.1;
    let mesh = plate(40, |x, y| if is_painted(x) { waves(x, y) } else { 0.0 });
    let mut source = to_scan(&mesh);
    let painted = mesh.positions.iter().map(|p| u8::from(is_painted(p.x)));
    source
        .vertices
        .set_channel("painted", Column::U8(painted.collect()));
    let place = Place::with("source.ply", &source);
    place.done(
        "transfer --source source.ply --mask painted --channel height --form-wavelength 0.3 --up none -o out.ply",
    );
    let out = place.scan("out.ply");
    let mut risen = Vec::new();
    for (before, after) in mesh.positions.iter().zip(out.positions()) {
        if is_painted(before.x) {
            assert!((after - before).norm() <= 0.0, "{before} moved to {after}");
        } else if before.x > 0.2 {
            risen.push(after.z - before.z);
        }
    }
    let share = size(&risen) / 0.01;
    assert!((0.6..=1.4).contains(&share), "{share} of the waves' size");
}

#[test]
fn options_of_relief_without_relief_are_usage_errors() {
    let place = Place::with("source.ply", &colored(&body(4, 0.0), hues));
    place.put("target.ply", &to_scan(&ball(4)));
    let line = "transfer --source source.ply --target target.ply -o out.ply";
    for (options, words) in [
        ("--displace 2", ["--displace", "--channel height"]),
        (
            "--form-wavelength 2",
            ["--form-wavelength", "--channel height"],
        ),
        ("--channel height --displace nan", ["--displace", "NaN"]),
        (
            "--channel height --image-size 64",
            ["--image-size", "--channel both"],
        ),
    ] {
        place.refused(2, &format!("{line} {options}"), &words);
    }
}
