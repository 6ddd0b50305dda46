//! Ranges and colours of a few values.

use super::*;

fn mesh(vertices: u32) -> TriMesh {
    TriMesh {
        positions: (0..vertices)
            .map(|k| Point3::new(f64::from(k), 0.0, 0.0))
            .collect(),
        triangles: (2..vertices).map(|k| [k - 2, k - 1, k]).collect(),
    }
}

#[test]
fn ranges_leave_out_two_percent_at_either_end_and_what_is_not_finite() {
    let mut values: Vec<f64> = (0..=100).map(f64::from).collect();
    values.extend([f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
    let range = |values: &[f64], map| robust_range(&mesh(104), values, map);
    assert_eq!(range(&values, ColorMap::Sequential), Some([2.0, 98.0]));
    assert_eq!(range(&values, ColorMap::Diverging), Some([-98.0, 98.0]));
    assert_eq!(range(&[f64::NAN; 104], ColorMap::Sequential), None);
    assert_eq!(range(&[4.0; 104], ColorMap::Sequential), Some([2.0, 6.0]));
    assert_eq!(range(&[0.0; 104], ColorMap::Diverging), Some([-1.0, 1.0]));
}

#[test]
fn values_are_mixed_by_the_weights_of_corners_that_have_one() {
    let table: Vec<[f32; 3]> = (0..=10u8).map(|k| [f32::from(k), 0.0, 0.0]).collect();
    let paint = Paint::Values {
        values: vec![0.0, 4.0, 8.0, f64::NAN],
        range: [0.0, 10.0],
        table,
    };
    let color = paint.color([0, 1, 2], [0.25, 0.25, 0.5]);
    assert!((color[0] - 5.0).abs() < 1e-9);
    let color = paint.color([0, 1, 3], [0.25, 0.5, 0.25]);
    assert!(
        (color[0] - 3.0).abs() < 1e-9,
        "8/3, on a table of whole numbers"
    );
    let color = paint.color([3, 3, 3], [0.5, 0.25, 0.25]);
    assert!((color[0] - PLAIN[0]).abs() < 1e-9);
}

#[test]
fn one_completed_vertex_makes_a_face_completed() {
    let paint = Paint::Marks(vec![false, false, false, true]);
    let third = [1.0 / 3.0; 3];
    let [old, new] = [[0, 1, 2], [1, 2, 3]].map(|corners| paint.color(corners, third));
    assert!(old[2] > old[0] && new[0] > new[2]);
}
