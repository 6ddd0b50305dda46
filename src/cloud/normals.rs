//! Normals, their side not yet told: planes through the nearest neighbors.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use rayon::prelude::*;

use super::points::{Neighbors, Points};

/// Neighbors whose spread across is below this share of that along (squared) are nearly on a line, as
/// along one line of a scanner; more are asked then.
const NEARLY_A_LINE: f64 = 0.01;

/// How many times more.
const MORE: usize = 4;

/// Rounds in which neighbors off the plane count less, so that the plane beside a crease or a step is
/// that of the point's own side.
const REWEIGHTINGS: usize = 2;

/// #V unit normals of either sign, of least-squares planes (Hoppe et al. 1992, section 3.1) reweighted
/// by distance from the plane.
pub(super) fn planes(points: &Points, neighbors: &Neighbors) -> (Vec<Vector3<f64>>, Vec<f64>) {
    let normal = |i: usize| {
        let row = neighbors.of(i);
        let found = plane(points, i, row);
        let found = if found.flat {
            found
        } else {
            plane(points, i, &neighbors.more(points, i, MORE * row.len()))
        };
        (found.normal, found.roughness)
    };
    (0..points.len()).into_par_iter().map(normal).unzip()
}

/// The plane through a point's surroundings.
fn plane(points: &Points, i: usize, neighbors: &[u32]) -> Plane {
    let origin = points.positions[i];
    let around: Vec<Point3<f64>> = (neighbors.iter())
        .map(|j| Point3::from(points.positions[*j as usize] - origin))
        .chain([Point3::origin()])
        .collect();
    let reach = around.iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
    let mut weights = vec![1.0; around.len()];
    let mut found = weighted_plane(&around, &weights);
    let roughness = found.roughness;
    for _ in 0..REWEIGHTINGS {
        let offset = |p: &Point3<f64>| (p - found.middle).dot(&found.normal).abs();
        let mut offsets: Vec<f64> = around.iter().map(offset).collect();
        let typical = super::points::median(&mut offsets.clone());
        if typical <= 1e-9 * reach {
            break;
        }
        // Cauchy's weights: they fall slowly, so that no neighborhood loses its plane.
        for (weight, offset) in weights.iter_mut().zip(&mut offsets) {
            *weight = 1.0 / (1.0 + (*offset / (2.0 * typical)).powi(2));
        }
        found = weighted_plane(&around, &weights);
    }
    Plane { roughness, ..found }
}

struct Plane {
    middle: Point3<f64>,
    normal: Vector3<f64>,
    flat: bool,
    /// Share of the spread that is across the plane, 0 to 1/3, before any point counted less.
    roughness: f64,
}

fn weighted_plane(around: &[Point3<f64>], weights: &[f64]) -> Plane {
    let total: f64 = weights.iter().sum();
    let sum: Vector3<f64> = (around.iter().zip(weights))
        .map(|(p, w)| p.coords * *w)
        .sum();
    let middle = Point3::from(sum / total);
    let mut matrix = Matrix3::zeros();
    for (p, w) in around.iter().zip(weights) {
        let d = p - middle;
        matrix += d * d.transpose() * *w;
    }
    let largest = matrix.amax();
    if largest > 0.0 {
        matrix /= largest;
    }
    let eigen = SymmetricEigen::new(matrix);
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let normal = eigen.eigenvectors.column(order[0]).into_owned();
    let total: f64 = eigen.eigenvalues.iter().sum();
    Plane {
        middle,
        roughness: (eigen.eigenvalues[order[0]] / total).max(0.0),
        normal: normal.try_normalize(0.0).unwrap_or_else(Vector3::z),
        flat: eigen.eigenvalues[order[1]] > NEARLY_A_LINE * eigen.eigenvalues[order[2]],
    }
}
