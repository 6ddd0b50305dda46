//! Meshes from elsewhere with texture coordinates, to texture images and back.

#![cfg(feature = "image")]

mod common;

use std::path::Path;

use common::say_skipped;
use relievo::mesh::TriMesh;
use relievo::scan::{
    self, Baked, ReadOptions, Scan, TexturedOutput, WriteOptions, bake, image_size,
};

/// Part of the diagonal that a pixel may take on the surface.
const TEXEL: f64 = 1.0 / 1000.0;

/// Positions within their bounds, from 0 to 1 along the longest side.
fn as_colors(mesh: &TriMesh) -> Vec<[f64; 3]> {
    let ends = |k: usize| {
        let values = mesh.positions.iter().map(|p| p[k]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
            [low.min(v), high.max(v)]
        })
    };
    let ends = [0, 1, 2].map(ends);
    let longest = ends
        .iter()
        .map(|[low, high]| high - low)
        .fold(0.0, f64::max);
    let color = |p: &nalgebra::Point3<f64>| [0, 1, 2].map(|k| (p[k] - ends[k][0]) / longest);
    mesh.positions.iter().map(color).collect()
}

fn baked(scan: &Scan) -> (Vec<[f64; 3]>, Baked) {
    let mesh = scan.mesh();
    let colors = as_colors(&mesh);
    let uv = scan
        .texture_coordinates()
        .expect("it has texture coordinates");
    assert_eq!(uv.len(), mesh.triangles.len());
    let diagonal = relievo::mesh::bounding_diagonal(&mesh.positions);
    let [width, height] = image_size(&uv, &mesh, TEXEL * diagonal);
    let baked = bake(width, height, &uv, |triangle, weights| {
        let corners = mesh.triangles[triangle].map(|v| colors[v as usize]);
        [0, 1, 2].map(|k| (0..3).map(|c| weights[c] * corners[c][k]).sum())
    });
    (colors, baked)
}

/// Writes a mesh with its positions as a texture, reads it back with the colors that its vertices have in the
/// image, and compares.
fn check(file: &str, largest_error: f64) {
    let path = Path::new("../shared/data/transfer").join(file);
    if !path.exists() {
        say_skipped(&format!("{} is not there", path.display()));
        return;
    }
    let scan = scan::read(&path, &ReadOptions::default()).expect("it can be read");
    let (colors, baked) = baked(&scan);
    assert!(baked.report.covered_pixels > 0);
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["a.obj", "b.glb", "c.ply"] {
        let path = folder.path().join(name);
        let output = TexturedOutput::create(&path, &[]).expect("it can be written");
        output
            .write(&scan, &baked.image, &WriteOptions::default())
            .expect("it is written");
        let back = scan::read(&path, &ReadOptions::default()).expect("it can be read back");
        assert_eq!(
            back.mesh().triangles.len(),
            scan.mesh().triangles.len(),
            "{name}"
        );
        if name == "c.ply" {
            continue;
        }
        let found = back.colors().expect("colors of the image");
        let mut used = back.mesh().used_vertices();
        used.truncate(colors.len());
        let errors = (colors.iter().zip(&found).zip(&used))
            .filter(|(_, used)| **used)
            .map(|((a, b), _)| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max));
        let worst = errors.fold(0.0, f64::max);
        assert!(worst < largest_error, "{file} as {name}: {worst}");
    }
}

#[test]
fn spot_shows_where_it_is() {
    check("spot_triangulated.obj", 0.015);
}

#[test]
fn the_zebra_shows_where_it_is() {
    check("zebra.obj", 0.02);
}
