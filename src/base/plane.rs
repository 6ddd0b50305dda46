//! Starts and parameters of a plane.

use nalgebra::{Point3, Unit, Vector3};

use super::model::Model;
use super::samples::{Samples, covariance};
use super::surface::any_perpendicular;
use super::{BaseSurface, Plane};
use crate::rng::Rng;

/// Plane through the mean, across the direction of least variance, then planes through random
/// triples.
pub(super) fn starts(samples: &Samples, random: usize, rng: &mut Rng) -> Vec<BaseSurface> {
    let mean = samples.mean();
    let centered = samples.points.iter().zip(&samples.weights);
    let [normal, ..] = covariance(centered.map(|(p, w)| (p - mean, *w)));
    let mut starts: Vec<_> = plane(mean, normal).into_iter().collect();
    for _ in 0..random {
        let [a, b, c] = [(); 3].map(|()| samples.points[rng.index(samples.points.len())]);
        starts.extend(plane(a, (b - a).cross(&(c - a))));
    }
    starts
}

fn plane(point: Point3<f64>, normal: Vector3<f64>) -> Option<BaseSurface> {
    let normal = Unit::try_new(normal, 0.0)?;
    Some(BaseSurface::Plane(Plane { point, normal }))
}

/// Tilt of the normal in two directions, and distance from the origin.
#[derive(Debug)]
pub(super) struct PlaneModel {
    u: Vector3<f64>,
    v: Vector3<f64>,
    w: Vector3<f64>,
    params: [f64; 3],
    normal: Vector3<f64>,
    length: f64,
}

impl PlaneModel {
    pub(super) fn new(start: &Plane) -> Self {
        let w = start.normal.into_inner();
        let u = any_perpendicular(&start.normal);
        Self {
            u,
            v: w.cross(&u),
            w,
            params: [0.0, 0.0, start.point.coords.dot(&w)],
            normal: w,
            length: 1.0,
        }
    }
}

impl Model for PlaneModel {
    fn params(&self) -> &[f64] {
        &self.params
    }

    fn set_params(&mut self, params: &[f64]) {
        self.params.copy_from_slice(params);
        let tilted = self.w + self.u * params[0] + self.v * params[1];
        self.length = tilted.norm();
        self.normal = tilted / self.length;
    }

    fn height(&self, p: &Point3<f64>) -> f64 {
        self.normal.dot(&p.coords) - self.params[2]
    }

    fn gradient(&self, p: &Point3<f64>, gradient: &mut [f64]) {
        let across = p.coords - self.normal * self.normal.dot(&p.coords);
        gradient[0] = across.dot(&self.u) / self.length;
        gradient[1] = across.dot(&self.v) / self.length;
        gradient[2] = -1.0;
    }

    fn surface(&self) -> BaseSurface {
        BaseSurface::Plane(Plane {
            point: Point3::from(self.normal * self.params[2]),
            normal: Unit::new_unchecked(self.normal),
        })
    }
}
