//! A straight axis as parameters, shared by cylinder and cone.

use nalgebra::{Point3, Unit, Vector3};

use super::surface::any_perpendicular;

/// A line near a start: its point is moved by the first two parameters and its direction tilted by
/// the next two, all perpendicular to the start.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    origin: Point3<f64>,
    u: Vector3<f64>,
    v: Vector3<f64>,
    w: Vector3<f64>,
    point: Point3<f64>,
    direction: Vector3<f64>,
    /// Length of the tilted direction before it was normalised.
    length: f64,
}

/// A point as seen from an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polar {
    /// Coordinate along the axis, from its point.
    pub(super) along: f64,
    /// Distance from the axis.
    pub(super) distance: f64,
}

impl Axis {
    /// Starts at the point of the axis next to the origin, which is the samples' centroid.
    pub(super) fn new(point: &Point3<f64>, direction: &Unit<Vector3<f64>>) -> Self {
        let w = direction.into_inner();
        let origin = foot_of_origin(point, &w);
        let u = any_perpendicular(direction);
        Self {
            origin,
            u,
            v: w.cross(&u),
            w,
            point: origin,
            direction: w,
            length: 1.0,
        }
    }

    /// Sets the four parameters.
    pub(super) fn set(&mut self, x: &[f64]) {
        self.point = self.origin + self.u * x[0] + self.v * x[1];
        let tilted = self.w + self.u * x[2] + self.v * x[3];
        self.length = tilted.norm();
        self.direction = tilted / self.length;
    }

    pub(super) fn point(&self) -> Point3<f64> {
        self.point
    }

    pub(super) fn direction(&self) -> Vector3<f64> {
        self.direction
    }

    pub(super) fn polar(&self, p: &Point3<f64>) -> Polar {
        let from_point = p - self.point;
        let along = from_point.dot(&self.direction);
        Polar {
            along,
            distance: (from_point - self.direction * along).norm(),
        }
    }

    /// Derivatives of `distance` and of `along` by the four parameters.
    pub(super) fn gradient(&self, p: &Point3<f64>) -> ([f64; 4], [f64; 4]) {
        let from_point = p - self.point;
        let along = from_point.dot(&self.direction);
        let radial = from_point - self.direction * along;
        let radial = radial.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let (ru, rv) = (radial.dot(&self.u), radial.dot(&self.v));
        let (nu, nv) = (self.direction.dot(&self.u), self.direction.dot(&self.v));
        // Turning the direction by δ (perpendicular to it) moves the foot by (p − point)·δ along
        // the axis and by along · δ across.
        let lever = along / self.length;
        let tilt = |side: &Vector3<f64>, n: f64| (from_point.dot(side) - along * n) / self.length;
        (
            [-ru, -rv, -lever * ru, -lever * rv],
            [-nu, -nv, tilt(&self.u, nu), tilt(&self.v, nv)],
        )
    }
}

/// Point of a line next to the origin.
pub(super) fn foot_of_origin(point: &Point3<f64>, direction: &Vector3<f64>) -> Point3<f64> {
    point - direction * point.coords.dot(direction)
}

/// `count` directions spread evenly over a half sphere (Fibonacci lattice): as axes, whose sign
/// does not matter, they lie about √(2π/count) apart.
pub(super) fn half_sphere(count: u32) -> impl Iterator<Item = Unit<Vector3<f64>>> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |i| {
        let z = (f64::from(i) + 0.5) / f64::from(count);
        let r = (1.0 - z * z).sqrt();
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        Unit::new_normalize(Vector3::new(r * cos, r * sin, z))
    })
}
