//! Starts and parameters of a cone.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

use super::axis::Axis;
use super::model::Model;
use super::samples::{Samples, covariance};
use super::{BaseSurface, Cone, Cylinder};
use crate::rng::Rng;

/// Half angle, in radians, of the slim cones started from each cylinder.
const SLIM: f64 = 0.1;

/// Half angle, in radians, of the wide cones started from the plane of least squares.
const WIDE: f64 = 1.4;

/// Least half angle, in radians, that is given back: the tip of a slimmer cone is so far away that
/// its rounding would be seen in the heights.
const MIN_HALF_ANGLE: f64 = 1e-6;

/// From the normals (their tips lie in a plane across the axis, and their tangent planes meet in the
/// apex); slim cones both ways about `cylinder`; wide
/// ones both ways on the plane of least variance; then the cones with random triples of tangent
/// planes.
pub(super) fn starts(
    samples: &Samples,
    cylinder: Option<&Cylinder>,
    random: usize,
    rng: &mut Rng,
) -> Vec<BaseSurface> {
    let mut starts: Vec<_> = from_normals(samples).into_iter().collect();
    if let Some(cylinder) = cylinder {
        for axis in [cylinder.axis, -cylinder.axis] {
            starts.push(BaseSurface::Cone(Cone {
                apex: cylinder.point - axis.scale(cylinder.radius / SLIM.tan()),
                axis,
                half_angle: SLIM,
            }));
        }
    }
    let mean = samples.mean();
    let points = samples.points.iter().zip(&samples.weights);
    let [normal, ..] = covariance(points.map(|(p, w)| (p - mean, *w)));
    for axis in [normal, -normal] {
        starts.push(BaseSurface::Cone(Cone {
            apex: mean,
            axis: Unit::new_normalize(axis),
            half_angle: WIDE,
        }));
    }
    for _ in 0..random {
        let picks = [(); 3].map(|()| rng.index(samples.points.len()));
        starts.extend(through_triple(samples, picks));
    }
    starts
}

fn from_normals(samples: &Samples) -> Option<BaseSurface> {
    let total: f64 = samples.weights.iter().sum();
    let weighted = || samples.normals.iter().zip(&samples.weights);
    let mean = weighted().map(|(n, w)| n * *w).sum::<Vector3<f64>>() / total;
    let [axis, ..] = covariance(weighted().map(|(n, w)| (n - mean, *w)));
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for ((n, w), p) in weighted().zip(&samples.points) {
        matrix += n * n.transpose() * *w;
        right += n * (*w * n.dot(&p.coords));
    }
    let apex = Point3::from(matrix.lu().solve(&right)?);
    about(apex, axis, samples.points.iter())
}

/// The cone that touches three planes, each given by a point and a normal.
fn through_triple(samples: &Samples, picks: [usize; 3]) -> Option<BaseSurface> {
    let normals = picks.map(|i| samples.normals[i]);
    let points = picks.map(|i| samples.points[i]);
    let matrix = Matrix3::from_columns(&normals).transpose();
    let right = Vector3::from_fn(|i, _| normals[i].dot(&points[i].coords));
    let apex = Point3::from(matrix.lu().solve(&right)?);
    let [a, b, c] = points.map(|p| (p - apex).try_normalize(0.0));
    let (a, b, c) = (a?, b?, c?);
    about(apex, (b - a).cross(&(c - a)), points.iter())
}

/// The cone with this apex and this axis (up to sign) and the mean half angle of the points.
fn about<'a>(
    apex: Point3<f64>,
    axis: Vector3<f64>,
    points: impl Iterator<Item = &'a Point3<f64>>,
) -> Option<BaseSurface> {
    let mut axis = Unit::try_new(axis, 0.0)?;
    let (mut along, mut across) = (0.0, 0.0);
    for p in points {
        let from_apex = p - apex;
        let t = from_apex.dot(&axis);
        along += t;
        across += (from_apex - axis.scale(t)).norm();
    }
    if along < 0.0 {
        axis = -axis;
        along = -along;
    }
    let half_angle = across.atan2(along);
    (half_angle.is_finite() && half_angle > 0.0).then_some(BaseSurface::Cone(Cone {
        apex,
        axis,
        half_angle,
    }))
}

/// Axis (four parameters, see [`Axis`]), radius at the axis's point, half angle. In place of the
/// apex, so that a cone can become a cylinder and taper the other way: height = cos φ (ρ − R) −
/// sin φ · t at distance ρ from the axis and t along it.
#[derive(Debug)]
pub(super) struct ConeModel {
    axis: Axis,
    params: [f64; 6],
    sin: f64,
    cos: f64,
}

impl ConeModel {
    pub(super) fn new(start: &Cone) -> Self {
        let axis = Axis::new(&start.apex, &start.axis);
        let from_apex = (axis.point() - start.apex).dot(&start.axis);
        let (sin, cos) = start.half_angle.sin_cos();
        let radius = from_apex * start.half_angle.tan();
        Self {
            axis,
            params: [0.0, 0.0, 0.0, 0.0, radius, start.half_angle],
            sin,
            cos,
        }
    }
}

impl Model for ConeModel {
    fn params(&self) -> &[f64] {
        &self.params
    }

    fn set_params(&mut self, params: &[f64]) {
        self.params.copy_from_slice(params);
        self.axis.set(params);
        (self.sin, self.cos) = params[5].sin_cos();
    }

    fn height(&self, p: &Point3<f64>) -> f64 {
        let polar = self.axis.polar(p);
        self.cos * (polar.distance - self.params[4]) - self.sin * polar.along
    }

    fn gradient(&self, p: &Point3<f64>, gradient: &mut [f64]) {
        let polar = self.axis.polar(p);
        let (distance, along) = self.axis.gradient(p);
        for i in 0..4 {
            gradient[i] = self.cos * distance[i] - self.sin * along[i];
        }
        gradient[4] = -self.cos;
        gradient[5] = -self.sin * (polar.distance - self.params[4]) - self.cos * polar.along;
    }

    fn surface(&self) -> BaseSurface {
        // The same line of points for angles beyond a quarter turn and for negative ones: fold them
        // into (0, π/2), the sign into the axis.
        let (mut sin, mut cos) = (self.sin, self.cos);
        if cos < 0.0 {
            (sin, cos) = (-sin, -cos);
        }
        let mut axis = self.axis.direction();
        if sin < 0.0 {
            axis = -axis;
        }
        let half_angle = sin
            .abs()
            .atan2(cos)
            .clamp(MIN_HALF_ANGLE, std::f64::consts::FRAC_PI_2 - MIN_HALF_ANGLE);
        let from_apex = self.params[4] / half_angle.tan();
        BaseSurface::Cone(Cone {
            apex: self.axis.point() - axis * from_apex,
            axis: Unit::new_unchecked(axis),
            half_angle,
        })
    }
}
