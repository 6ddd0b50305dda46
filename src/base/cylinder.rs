//! Starts and parameters of a cylinder.

use nalgebra::{Matrix3, Point3, Unit, Vector2, Vector3};

use super::axis::{Axis, foot_of_origin, half_sphere};
use super::model::Model;
use super::samples::{Samples, covariance};
use super::surface::any_perpendicular;
use super::{BaseSurface, Cylinder};
use crate::rng::Rng;

/// Axes of the coarse search, about 18 degrees apart.
const DIRECTIONS: u32 = 64;

/// Random circles for each of the axes.
const CIRCLES: usize = 4;

/// Axes: the direction that the normals avoid, the principal axes, a coarse half sphere; for each
/// the circle of linear least squares through the projected points and a few circles through
/// random triples. Then axes across random pairs of normals, which meet on the cylinder's axis.
pub(super) fn starts(samples: &Samples, random: usize, rng: &mut Rng) -> Vec<BaseSurface> {
    let mean = samples.mean();
    let normals = samples.normals.iter().zip(&samples.weights);
    let [avoided, ..] = covariance(normals.map(|(n, w)| (*n, *w)));
    let points = samples.points.iter().zip(&samples.weights);
    let principal = covariance(points.map(|(p, w)| (p - mean, *w)));
    let named = [avoided, principal[2], principal[1], principal[0]];
    let axes = named.map(Unit::new_normalize).into_iter();
    let mut starts = Vec::new();
    for axis in axes.chain(half_sphere(DIRECTIONS)) {
        let plane = Projection::new(&axis);
        let projected: Vec<_> = samples.points.iter().map(|p| plane.to_plane(p)).collect();
        let weighted = projected.iter().zip(&samples.weights);
        starts.extend(circle(weighted.map(|(q, w)| (*q, *w))).map(|c| plane.cylinder(c)));
        for _ in 0..CIRCLES {
            let corners = [(); 3].map(|()| (projected[rng.index(projected.len())], 1.0));
            starts.extend(circle(corners.into_iter()).map(|c| plane.cylinder(c)));
        }
    }
    for _ in 0..random {
        let [i, j] = [(); 2].map(|()| rng.index(samples.points.len()));
        starts.extend(through_pair(samples, i, j));
    }
    starts
}

/// The plane across an axis.
struct Projection {
    axis: Unit<Vector3<f64>>,
    u: Vector3<f64>,
    v: Vector3<f64>,
}

impl Projection {
    fn new(axis: &Unit<Vector3<f64>>) -> Self {
        let u = any_perpendicular(axis);
        Self {
            axis: *axis,
            u,
            v: axis.cross(&u),
        }
    }

    fn to_plane(&self, p: &Point3<f64>) -> Vector2<f64> {
        Vector2::new(p.coords.dot(&self.u), p.coords.dot(&self.v))
    }

    fn cylinder(&self, (center, radius): (Vector2<f64>, f64)) -> BaseSurface {
        BaseSurface::Cylinder(Cylinder {
            point: Point3::from(self.u * center.x + self.v * center.y),
            axis: self.axis,
            radius,
        })
    }
}

/// Circle by linear least squares, |q|² = 2 c·q + (R² − |c|²).
fn circle(points: impl Iterator<Item = (Vector2<f64>, f64)>) -> Option<(Vector2<f64>, f64)> {
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (q, w) in points {
        let row = Vector3::new(2.0 * q.x, 2.0 * q.y, 1.0);
        matrix += row * row.transpose() * w;
        right += row * (w * q.norm_squared());
    }
    let x = matrix.lu().solve(&right)?;
    let center = Vector2::new(x.x, x.y);
    let radius = (x.z + center.norm_squared()).sqrt();
    (radius.is_finite() && radius > 0.0).then_some((center, radius))
}

/// The cylinder that has two points with their normals, or nearly so.
fn through_pair(samples: &Samples, i: usize, j: usize) -> Option<BaseSurface> {
    let (a, b) = (samples.normals[i], samples.normals[j]);
    // Normals less than 3 degrees apart say nothing about the axis.
    let axis = Unit::try_new(a.cross(&b), 0.05)?;
    let plane = Projection::new(&axis);
    let [p, q] = [i, j].map(|k| plane.to_plane(&samples.points[k]));
    let [a, b] = [a, b].map(|n| plane.to_plane(&Point3::from(n)));
    // p − s a = q − t b
    let cross = a.perp(&b);
    let s = (p - q).perp(&b) / cross;
    let center = p - a * s;
    let radius = 0.5 * ((p - center).norm() + (q - center).norm());
    (radius.is_finite() && radius > 0.0).then(|| plane.cylinder((center, radius)))
}

/// Axis (four parameters, see [`Axis`]) and radius.
#[derive(Debug)]
pub(super) struct CylinderModel {
    axis: Axis,
    params: [f64; 5],
}

impl CylinderModel {
    pub(super) fn new(start: &Cylinder) -> Self {
        Self {
            axis: Axis::new(&start.point, &start.axis),
            params: [0.0, 0.0, 0.0, 0.0, start.radius],
        }
    }
}

impl Model for CylinderModel {
    fn params(&self) -> &[f64] {
        &self.params
    }

    fn set_params(&mut self, params: &[f64]) {
        self.params.copy_from_slice(params);
        self.axis.set(params);
    }

    fn height(&self, p: &Point3<f64>) -> f64 {
        self.axis.polar(p).distance - self.params[4]
    }

    fn gradient(&self, p: &Point3<f64>, gradient: &mut [f64]) {
        gradient[..4].copy_from_slice(&self.axis.gradient(p).0);
        gradient[4] = -1.0;
    }

    fn surface(&self) -> BaseSurface {
        let mut direction = self.axis.direction();
        // The axis has no sign of its own: its largest component shall be positive.
        if direction[direction.iamax()] < 0.0 {
            direction = -direction;
        }
        BaseSurface::Cylinder(Cylinder {
            point: foot_of_origin(&self.axis.point(), &direction),
            axis: Unit::new_unchecked(direction),
            radius: self.params[4].abs(),
        })
    }
}
