//! Starts and parameters of a sphere.

use nalgebra::{Matrix4, Point3, Vector3, Vector4};

use super::model::Model;
use super::samples::{Samples, covariance};
use super::{BaseSurface, Sphere};
use crate::rng::Rng;

/// Radius of the nearly flat spheres that are tried on both sides, in half diagonals.
const FLAT_START: f64 = 20.0;

/// Linear least squares |p|² = 2 c·p + (R² − |c|²), two flat spheres, then spheres through random
/// quadruples.
pub(super) fn starts(samples: &Samples, random: usize, rng: &mut Rng) -> Vec<BaseSurface> {
    let mean = samples.mean();
    let mut matrix = Matrix4::zeros();
    let mut right = Vector4::zeros();
    for (p, w) in samples.points.iter().zip(&samples.weights) {
        let (row, value) = equation(&(p - mean));
        matrix += row * row.transpose() * *w;
        right += row * value * *w;
    }
    let mut starts: Vec<_> = solve(&matrix, &right, &mean).into_iter().collect();
    let centered = samples.points.iter().zip(&samples.weights);
    let [normal, ..] = covariance(centered.map(|(p, w)| (p - mean, *w)));
    for side in [FLAT_START, -FLAT_START] {
        starts.push(BaseSurface::Sphere(Sphere {
            center: mean + normal * side,
            radius: FLAT_START,
        }));
    }
    for _ in 0..random {
        let corners = [(); 4].map(|()| samples.points[rng.index(samples.points.len())]);
        let equations = corners.map(|p| equation(&(p - mean)));
        let matrix = Matrix4::from_columns(&equations.map(|e| e.0)).transpose();
        starts.extend(solve(
            &matrix,
            &Vector4::from(equations.map(|e| e.1)),
            &mean,
        ));
    }
    starts
}

fn equation(p: &Vector3<f64>) -> (Vector4<f64>, f64) {
    (
        Vector4::new(2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0),
        p.norm_squared(),
    )
}

fn solve(matrix: &Matrix4<f64>, right: &Vector4<f64>, mean: &Point3<f64>) -> Option<BaseSurface> {
    let x = matrix.lu().solve(right)?;
    let radius = (x.w + x.xyz().norm_squared()).sqrt();
    (x.iter().all(|x| x.is_finite()) && radius > 0.0).then(|| {
        BaseSurface::Sphere(Sphere {
            center: mean + x.xyz(),
            radius,
        })
    })
}

/// Center and radius.
#[derive(Debug)]
pub(super) struct SphereModel {
    params: [f64; 4],
    center: Point3<f64>,
}

impl SphereModel {
    pub(super) fn new(start: &Sphere) -> Self {
        let c = start.center;
        Self {
            params: [c.x, c.y, c.z, start.radius],
            center: c,
        }
    }
}

impl Model for SphereModel {
    fn params(&self) -> &[f64] {
        &self.params
    }

    fn set_params(&mut self, params: &[f64]) {
        self.params.copy_from_slice(params);
        self.center = Point3::new(params[0], params[1], params[2]);
    }

    fn height(&self, p: &Point3<f64>) -> f64 {
        (p - self.center).norm() - self.params[3]
    }

    fn gradient(&self, p: &Point3<f64>, gradient: &mut [f64]) {
        let out = (p - self.center)
            .try_normalize(0.0)
            .unwrap_or_else(Vector3::zeros);
        gradient[..3].copy_from_slice((-out).as_slice());
        gradient[3] = -1.0;
    }

    fn surface(&self) -> BaseSurface {
        BaseSurface::Sphere(Sphere {
            center: self.center,
            radius: self.params[3].abs(),
        })
    }
}
