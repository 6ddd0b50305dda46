//! Relief put on a surface: its points are moved along their normals.

use nalgebra::{Point3, Vector3};

use crate::scan::{Column, Scan};

/// Points (#V) moved along their normals (#V) by `scale` times their heights (#V).
#[must_use]
pub fn displaced(
    positions: &[Point3<f64>],
    normals: &[Vector3<f64>],
    heights: &[f64],
    scale: f64,
) -> Vec<Point3<f64>> {
    (positions.iter().zip(normals).zip(heights))
        .map(|((p, normal), height)| p + normal * (scale * height))
        .collect()
}

/// Puts heights (#V, property `height`) on a scan, whose vertices are moved by `scale` times these along their normals
/// (#V) if it is given: coordinates are `double` then. All else stays, bit by bit.
///
/// # Panics
/// If there are not as many heights as vertices.
pub fn put_on(scan: &mut Scan, normals: &[Vector3<f64>], heights: Vec<f64>, scale: Option<f64>) {
    if let Some(scale) = scale {
        let moved = displaced(&scan.positions(), normals, &heights, scale);
        for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
            let values = moved.iter().map(|p| p[k]).collect();
            scan.vertices.set_channel(name, Column::F64(values));
        }
    }
    scan.vertices.set_channel("height", Column::F64(heights));
}
