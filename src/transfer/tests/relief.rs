//! Heights.

use super::super::shape::test_shapes::icosphere;
use super::super::test_stacks::blob;
use super::*;

fn deviation(heights: &[f64]) -> f64 {
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    let squares = heights.iter().map(|h| (h - mean).powi(2)).sum::<f64>();
    (squares / heights.len() as f64).sqrt()
}

/// Bumps 0.03 high.
fn bumps(mesh: &TriMesh) -> Vec<f64> {
    let bump = |p: &Point3<f64>| 0.03 * (5.0 * p.x).sin() * (5.0 * p.y + 3.0 * p.z).cos();
    mesh.positions.iter().map(bump).collect()
}

fn lifted(mesh: &TriMesh, target: &TriMesh, params: &TransferParams) -> Transferred {
    let heights = bumps(mesh);
    let source = Source {
        mesh,
        colors: None,
        heights: Some(&heights),
    };
    let done = run(&source, target, params);
    assert_whole(&done, mesh, target);
    assert!(done.colors.is_none());
    done
}

#[test]
fn heights_are_scaled_with_the_target() {
    let mesh = blob(3);
    let own = deviation(&bumps(&mesh));
    for size in [1.0, 0.25, 3.0] {
        let mut target = icosphere(3);
        target.positions.iter_mut().for_each(|p| p.coords *= size);
        let ratio = (crate::mesh::surface_area(&target) / crate::mesh::surface_area(&mesh)).sqrt();
        let done = lifted(&mesh, &target, &TransferParams::default());
        let found = deviation(done.heights.as_ref().unwrap()) / ratio;
        assert!((found / own - 1.0).abs() < 0.1, "{found} instead of {own}");
    }
}

#[test]
fn heights_and_colors_come_from_the_same_vertices() {
    let mesh = blob(2);
    let (colors, heights) = (painted(&mesh, 4.0), bumps(&mesh));
    let source = Source {
        mesh: &mesh,
        colors: Some(&colors),
        heights: Some(&heights),
    };
    let mut target = mesh.clone();
    target.positions.iter_mut().for_each(|p| p.coords *= 2.0);
    let done = run(&source, &target, &TransferParams::default());
    assert_whole(&done, &mesh, &target);
    let found = (done.colors.iter().flatten()).zip(done.heights.iter().flatten());
    for ((color, height), s) in found.zip(&done.sources) {
        let s = *s as usize;
        assert!((0..3).all(|k| (color[k] - colors[s][k]).abs() < 1e-6));
        assert!((height - 2.0 * heights[s]).abs() < 1e-6);
    }
}
