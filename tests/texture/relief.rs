//! Texture as relief.

use relievo::base::{BaseSurface, FitParams, fit};
use relievo::mesh::{TriMesh, triangle_area, vertex_normals};
use relievo::relief;
use relievo::scan::{Column, Scan};
use relievo::synth::{Kind, Part};
use serde_json::Value;

use crate::common::place::Place;
use crate::common::samples::{colors, sources, sphere, square, torus, waves};
use crate::common::{synthetic, to_scan, values};
use crate::{TEXTURE, assert_kept, place, told};

#[test]
fn relief_moves_vertices_along_their_normals() {
    let place = place(&sphere(), &waves());
    place.done(&format!("{TEXTURE} -o flat.ply"));
    for scale in [0.3, -0.1] {
        place.done(&format!("{TEXTURE} --displace {scale} -o out.ply"));
        let (flat, out) = (place.scan("flat.ply"), place.scan("out.ply"));
        assert!(colors(&flat) == colors(&out));
        let heights = values(&out, "height");
        let normals = vertex_normals(&flat.mesh());
        let pairs = flat.positions().into_iter().zip(out.positions());
        for (v, (from, to)) in pairs.enumerate() {
            let expected = normals[v] * (scale * heights[v]);
            assert!((to - from - expected).norm() < 1e-9, "vertex {v}");
        }
        // Luminance about its mean.
        let mean = heights.iter().sum::<f64>() / heights.len() as f64;
        let most = heights.iter().copied().fold(0.0, f64::max);
        assert!(
            mean.abs() < 1e-9 && most > 0.2 && most < 1.0,
            "{mean}, {most}"
        );
    }
    place.done(&format!("{TEXTURE} --keep-mesh --displace 0.3 -o out.ply"));
    let out = place.scan("out.ply");
    assert_kept(&to_scan(&sphere()), &out, &["x", "y", "z"]);
    let heights = values(&out, "height");
    for (v, (from, to)) in sphere().positions.iter().zip(out.positions()).enumerate() {
        let along = (to - from).norm();
        assert!(
            (along - (0.3 * heights[v]).abs()).abs() < 1e-9,
            "vertex {v}"
        );
    }
}

/// Root mean square about the mean.
fn deviation(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// The length of a texel of a sample scan: the side of a square of two triangles' area, on the base surface.
fn texel(sample: &Scan, base: &BaseSurface) -> f64 {
    let mesh = TriMesh {
        positions: relief::extract(&sample.mesh(), base).feet,
        triangles: sample.mesh().triangles,
    };
    let faces = 0..mesh.triangles.len();
    let area: f64 = faces.map(|f| triangle_area(mesh.corners(f))).sum();
    (2.0 * area / mesh.triangles.len() as f64).sqrt()
}

/// That of what came out, as the JSON tells it.
fn texel_of(json: &Value) -> f64 {
    json["levels"][0]["texel"].as_f64().expect("a length")
}

#[test]
fn relief_of_a_scan_keeps_its_proportions() {
    for kind in [Kind::Bark, Kind::Bricks] {
        let sample = synthetic(kind, Part::default());
        let report = fit(&sample.mesh(), &FitParams::default()).expect("it has a base");
        let place = Place::with("mesh.ply", &to_scan(&torus()));
        place.put("sample.ply", &sample);
        let line = "texture mesh.ply -e sample.ply --vertices 1000 -o out.ply";
        let json = told(&place, line);
        let out = place.scan("out.ply");
        let rms = deviation(&values(&out, "height"));
        // As much smaller as the texels are.
        let scale = texel_of(&json) / texel(&sample, &report.base);
        let share = rms / (scale * report.inlier_rms);
        assert!(
            (0.85..=1.15).contains(&share),
            "{kind:?}: {rms}, {}",
            report.inlier_rms
        );
        // All colors are as frequent as well.
        let correlation = json["histogram_correlation"]
            .as_array()
            .expect("it has colors");
        assert!(
            correlation.iter().all(|c| c.as_f64() > Some(0.8)),
            "{correlation:?}"
        );
        // Each height is the one over the vertex that it was copied from.
        let heights = values(&out, "height");
        let sources = sources(&out);
        let mut by_source: Vec<(usize, f64)> = sources.into_iter().zip(heights).collect();
        by_source.sort_by_key(|(source, _)| *source);
        for pair in by_source.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            assert!((pair[0].1 - pair[1].1).abs() < 1e-12);
        }
        assert!(by_source.iter().all(|(s, _)| *s < sample.vertices.rows));
    }
}

#[test]
fn a_colored_scan_gives_relief_and_colors_of_the_same_vertices() {
    let mut sample = synthetic(Kind::Waves, Part::default());
    let rows = sample.vertices.rows;
    let paint = |v: usize, factor: usize| u8::try_from(v * factor % 251).expect("below 251");
    for (factor, name) in [(1, "red"), (7, "green"), (83, "blue")] {
        let values = (0..rows).map(|v| paint(v, factor)).collect();
        sample.vertices.set_channel(name, Column::U8(values));
    }
    let place = Place::with("mesh.ply", &to_scan(&square()));
    place.put("sample.ply", &sample);
    let json = told(
        &place,
        "texture mesh.ply -e sample.ply --vertices 600 -o out.ply",
    );
    let out = place.scan("out.ply");
    let report = fit(&sample.mesh(), &FitParams::default()).expect("it has a base");
    let scale = texel_of(&json) / texel(&sample, &report.base);
    let of_sample: Vec<f64> = values(&sample, "z").iter().map(|z| scale * z).collect();
    let (heights, sources) = (values(&out, "height"), sources(&out));
    let (low, high) = (of_sample.iter()).fold((0f64, 0f64), |(l, h), z| (l.min(*z), h.max(*z)));
    for (v, color) in colors(&out).into_iter().enumerate() {
        let source = sources[v];
        assert_eq!(
            color,
            [1, 7, 83].map(|factor| paint(source, factor)),
            "vertex {v}"
        );
        // The waves are over the plane z = 0, which the fit finds but for a little.
        let apart = (heights[v] - of_sample[source]).abs();
        assert!(apart < 0.05 * (high - low), "vertex {v}: {apart}");
    }
}
