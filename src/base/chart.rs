//! Conformal charts: a base surface flattened to the plane without angles changed, so that one
//! plane Delaunay triangulation serves every kind of base surface and every kind of gap.
//!
//! | base | chart | a loop around … |
//! |---|---|---|
//! | plane | identity | |
//! | sphere | stereographic, the pole opposite the middle of the gap | |
//! | cylinder | exp((z + iRθ)/R) | … the axis is a loop around the origin |
//! | cone | (s/s₀)^(1/sin α)·e^(iθ), the power map of the unrolled sector | … the axis, too |
//!
//! No chart has a seam. Sizes are measured on the surface, by [`Chart::scale`], not in the chart.

use nalgebra::{Point2, Point3, Vector2, Vector3};

use super::surface::perpendicular_frame;
use super::{BaseSurface, Cone, Cylinder, Plane, Sphere};

/// A conformal map between a base surface and the plane.
///
/// As seen from the side that the scan's triangles face, it keeps the sense of rotation: what runs
/// counterclockwise on the surface does so in the chart.
#[derive(Debug, Clone)]
pub struct Chart {
    map: Map,
    /// First and second axis of the chart's own frame; the third is the axis or pole direction.
    frame: [Vector3<f64>; 3],
    /// ±1: second chart coordinate mirrored if −1.
    mirror: f64,
}

#[derive(Debug, Clone)]
enum Map {
    Plane(Plane),
    Sphere(Sphere),
    /// With the height along the axis that maps to the unit circle.
    Cylinder(Cylinder, f64),
    /// With the slant length s₀ that maps to the unit circle.
    Cone(Cone, f64),
}

impl Chart {
    /// A chart of `base` for the surroundings of `middle` (a point near the middle of the gap, on or
    /// off the surface), as seen from the outside (`side` = 1) or inside (−1).
    #[must_use]
    pub fn new(base: &BaseSurface, side: f64, middle: &Point3<f64>) -> Self {
        let foot = base.foot(middle);
        let (map, pole, flips) = match *base {
            BaseSurface::Plane(plane) => {
                let map = Map::Plane(Plane {
                    point: foot.point,
                    ..plane
                });
                (map, plane.normal, false)
            }
            BaseSurface::Sphere(sphere) => {
                let pole = nalgebra::Unit::new_unchecked(foot.normal);
                (Map::Sphere(sphere), pole, false)
            }
            // The unrolled wall (Rθ, z) keeps the sense of rotation; exp turns z into the radius and
            // θ into the angle, which swaps the two and so mirrors.
            BaseSurface::Cylinder(cylinder) => {
                let height = (foot.point - cylinder.point).dot(&cylinder.axis);
                (Map::Cylinder(cylinder, height), cylinder.axis, true)
            }
            // Seen from outside, away from the apex is like down the axis: mirrored again.
            BaseSurface::Cone(cone) => {
                let slant = (foot.point - cone.apex).norm();
                (Map::Cone(cone, slant), cone.axis, true)
            }
        };
        let [first, second] = perpendicular_frame(&pole);
        Self {
            map,
            frame: [first, second, pole.into_inner()],
            mirror: if flips { -side } else { side },
        }
    }

    /// Chart position of a point of the base surface.
    #[must_use]
    pub fn to_plane(&self, p: &Point3<f64>) -> Point2<f64> {
        let q = match &self.map {
            Map::Plane(plane) => self.in_frame(p - plane.point).xy(),
            Map::Sphere(sphere) => {
                let local = self.in_frame(p - sphere.center) / sphere.radius;
                // From the pole opposite: q = 2R tan(polar angle / 2).
                local.xy() * (2.0 * sphere.radius / (1.0 + local.z).max(f64::MIN_POSITIVE))
            }
            Map::Cylinder(cylinder, z0) => {
                let local = self.in_frame(p - cylinder.point);
                local.xy().normalize() * ((local.z - z0) / cylinder.radius).exp()
            }
            Map::Cone(cone, s0) => {
                let from_apex = p - cone.apex;
                let power = 1.0 / cone.half_angle.sin();
                let local = self.in_frame(from_apex);
                local.xy().normalize() * (from_apex.norm() / s0).powf(power)
            }
        };
        Point2::new(q.x, q.y * self.mirror)
    }

    /// Length on the surface per length in the chart, at chart position `q`.
    #[must_use]
    pub fn scale(&self, q: &Point2<f64>) -> f64 {
        let radius_sq = q.coords.norm_squared();
        match &self.map {
            Map::Plane(_) => 1.0,
            Map::Sphere(sphere) => {
                let r = 2.0 * sphere.radius;
                1.0 / (1.0 + radius_sq / (r * r))
            }
            Map::Cylinder(cylinder, _) => cylinder.radius / radius_sq.sqrt(),
            Map::Cone(cone, s0) => {
                let sin = cone.half_angle.sin();
                let radius = radius_sq.sqrt();
                s0 * radius.powf(sin) * sin / radius
            }
        }
    }

    /// Whether the chart has the end of the surface (z → −∞, or the apex) at its origin, so that a
    /// loop around the origin encloses no bounded piece of wall.
    #[must_use]
    pub fn origin_is_an_end(&self) -> bool {
        matches!(self.map, Map::Cylinder(..) | Map::Cone(..))
    }

    fn in_frame(&self, v: Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            v.dot(&self.frame[0]),
            v.dot(&self.frame[1]),
            v.dot(&self.frame[2]),
        )
    }

    /// The point of the base surface at chart position `q`.
    #[must_use]
    pub fn to_surface(&self, q: &Point2<f64>) -> Point3<f64> {
        let q = Vector2::new(q.x, q.y * self.mirror);
        let [first, second, third] = &self.frame;
        let radius = q.norm();
        let direction = || {
            if radius > 0.0 {
                (first * q.x + second * q.y) / radius
            } else {
                *first
            }
        };
        match &self.map {
            Map::Plane(plane) => plane.point + first * q.x + second * q.y,
            Map::Sphere(sphere) => {
                let (sin, cos) = (2.0 * (radius / (2.0 * sphere.radius)).atan()).sin_cos();
                sphere.center + (direction() * sin + third * cos) * sphere.radius
            }
            Map::Cylinder(cylinder, z0) => {
                let z = z0 + cylinder.radius * radius.ln();
                cylinder.point + direction() * cylinder.radius + third * z
            }
            Map::Cone(cone, s0) => {
                let (sin, cos) = cone.half_angle.sin_cos();
                cone.apex + (direction() * sin + third * cos) * (s0 * radius.powf(sin))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Unit;

    fn surfaces() -> [BaseSurface; 4] {
        let axis = Unit::new_normalize(Vector3::new(0.4, -1.0, 0.7));
        let point = Point3::new(-0.2, 0.5, 0.1);
        [
            BaseSurface::Plane(Plane {
                point,
                normal: axis,
            }),
            BaseSurface::Sphere(Sphere {
                center: point,
                radius: 2.0,
            }),
            BaseSurface::Cylinder(Cylinder {
                point,
                axis,
                radius: 1.5,
            }),
            BaseSurface::Cone(Cone {
                apex: point,
                axis,
                half_angle: 0.5,
            }),
        ]
    }

    /// Points of the surface around a point beside it.
    fn samples(base: &BaseSurface) -> Vec<Point3<f64>> {
        let axis = Vector3::new(0.4, -1.0, 0.7).normalize();
        (0..40)
            .map(|i| {
                let t = f64::from(i);
                let around = Vector3::new((1.3 * t).sin(), (0.7 * t).cos(), (2.1 * t).sin());
                base.foot(&(Point3::new(-0.2, 0.5, 0.1) + axis * 4.0 + around * 1.7))
                    .point
            })
            .collect()
    }

    #[test]
    fn there_and_back_is_the_same_point() {
        for base in surfaces() {
            let points = samples(&base);
            let chart = Chart::new(&base, 1.0, &points[0]);
            for p in &points {
                assert_relative_eq!(chart.to_surface(&chart.to_plane(p)), p, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn charts_are_conformal_with_the_stated_scale_and_keep_the_sense_of_rotation() {
        let h = 1e-6;
        for base in surfaces() {
            for side in [1.0, -1.0] {
                let points = samples(&base);
                let chart = Chart::new(&base, side, &points[0]);
                for p in &points {
                    let q = chart.to_plane(p);
                    let slope = |step: Vector2<f64>| {
                        (chart.to_surface(&(q + step * h)) - chart.to_surface(&(q - step * h)))
                            / (2.0 * h)
                    };
                    let (x, y) = (slope(Vector2::x()), slope(Vector2::y()));
                    assert_relative_eq!(x.norm(), chart.scale(&q), max_relative = 1e-6);
                    assert_relative_eq!(y.norm(), chart.scale(&q), max_relative = 1e-6);
                    assert_relative_eq!(x.angle(&y), std::f64::consts::FRAC_PI_2, epsilon = 1e-6);
                    let seen_from = base.foot(p).normal * side;
                    assert!(x.cross(&y).dot(&seen_from) > 0.0, "{base:?} {side}");
                }
            }
        }
    }
}
