//! The base surfaces as geometry: foot points, normals and signed heights.

use nalgebra::{Point3, Unit, Vector3};
use serde::{Deserialize, Serialize};

/// Kind of a base surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BaseKind {
    /// See [`Plane`].
    Plane,
    /// See [`Sphere`].
    Sphere,
    /// See [`Cylinder`].
    Cylinder,
    /// See [`Cone`].
    Cone,
}

impl std::fmt::Display for BaseKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Plane => "plane",
            Self::Sphere => "sphere",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
        })
    }
}

/// A plane; its normal is its outside.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// A point of the plane (the foot of the scan's centroid).
    pub point: Point3<f64>,
    /// Unit normal.
    pub normal: Unit<Vector3<f64>>,
}

/// A sphere; outside is away from its center.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sphere {
    /// Center.
    pub center: Point3<f64>,
    /// Radius, in the scan's unit.
    pub radius: f64,
}

/// A circular cylinder without ends; outside is away from its axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cylinder {
    /// A point of the axis (the foot of the scan's centroid).
    pub point: Point3<f64>,
    /// Unit direction of the axis.
    pub axis: Unit<Vector3<f64>>,
    /// Radius, in the scan's unit.
    pub radius: f64,
}

/// One nappe of a circular cone; outside is away from its axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cone {
    /// Tip.
    pub apex: Point3<f64>,
    /// Unit direction of the axis, from the apex into the cone.
    pub axis: Unit<Vector3<f64>>,
    /// Angle between the axis and the surface, in radians, in (0, π/2).
    pub half_angle: f64,
}

/// The smooth shape underneath the relief.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum BaseSurface {
    /// A plane.
    Plane(Plane),
    /// A sphere.
    Sphere(Sphere),
    /// A cylinder.
    Cylinder(Cylinder),
    /// A cone.
    Cone(Cone),
}

/// The nearest point of the base surface to a given point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// The point on the base surface, s'.
    pub point: Point3<f64>,
    /// Outward unit normal of the base surface there.
    pub normal: Vector3<f64>,
    /// Signed distance of the given point along that normal: `given = point + height · normal`.
    pub height: f64,
}

impl BaseSurface {
    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> BaseKind {
        match self {
            Self::Plane(_) => BaseKind::Plane,
            Self::Sphere(_) => BaseKind::Sphere,
            Self::Cylinder(_) => BaseKind::Cylinder,
            Self::Cone(_) => BaseKind::Cone,
        }
    }

    /// Foot point of `p`. Where it is not unique (center of the sphere, axis of the cylinder or
    /// cone), one is picked, always the same.
    #[must_use]
    pub fn foot(&self, p: &Point3<f64>) -> Foot {
        match self {
            Self::Plane(plane) => plane.foot(p),
            Self::Sphere(sphere) => sphere.foot(p),
            Self::Cylinder(cylinder) => cylinder.foot(p),
            Self::Cone(cone) => cone.foot(p),
        }
    }

    /// Height of `p`, the same as [`foot`](Self::foot)'s, in fewer steps.
    pub(super) fn height(&self, p: &Point3<f64>) -> f64 {
        let about = |axis: &Unit<Vector3<f64>>, from: Vector3<f64>| {
            let along = from.dot(axis);
            (along, (from - axis.scale(along)).norm())
        };
        match self {
            Self::Plane(plane) => (p - plane.point).dot(&plane.normal),
            Self::Sphere(sphere) => (p - sphere.center).norm() - sphere.radius,
            Self::Cylinder(cylinder) => {
                about(&cylinder.axis, p - cylinder.point).1 - cylinder.radius
            }
            Self::Cone(cone) => {
                let (sin, cos) = cone.half_angle.sin_cos();
                let (along, distance) = about(&cone.axis, p - cone.apex);
                distance * cos - along * sin
            }
        }
    }

    /// The same surface moved by `offset`.
    #[must_use]
    pub fn translated(mut self, offset: Vector3<f64>) -> Self {
        match &mut self {
            Self::Plane(plane) => plane.point += offset,
            Self::Sphere(sphere) => sphere.center += offset,
            Self::Cylinder(cylinder) => cylinder.point += offset,
            Self::Cone(cone) => cone.apex += offset,
        }
        self
    }
}

impl Plane {
    fn foot(&self, p: &Point3<f64>) -> Foot {
        let height = (p - self.point).dot(&self.normal);
        Foot {
            point: p - self.normal.scale(height),
            normal: self.normal.into_inner(),
            height,
        }
    }
}

impl Sphere {
    fn foot(&self, p: &Point3<f64>) -> Foot {
        let (normal, distance) = direction_and_length(p - self.center, Vector3::x());
        Foot {
            point: self.center + normal * self.radius,
            normal,
            height: distance - self.radius,
        }
    }
}

impl Cylinder {
    fn foot(&self, p: &Point3<f64>) -> Foot {
        let from_point = p - self.point;
        let along = self.axis.scale(from_point.dot(&self.axis));
        let (normal, distance) =
            direction_and_length(from_point - along, any_perpendicular(&self.axis));
        Foot {
            point: self.point + along + normal * self.radius,
            normal,
            height: distance - self.radius,
        }
    }
}

impl Cone {
    /// Feet of points behind the apex lie on the nappe's extension through the apex (so that the
    /// height stays the distance to the line of the generator, smooth for least squares).
    fn foot(&self, p: &Point3<f64>) -> Foot {
        let (sin, cos) = self.half_angle.sin_cos();
        let from_apex = p - self.apex;
        let along = from_apex.dot(&self.axis);
        let (radial, distance) = direction_and_length(
            from_apex - self.axis.scale(along),
            any_perpendicular(&self.axis),
        );
        let slant = along * cos + distance * sin;
        Foot {
            point: self.apex + (self.axis.scale(cos) + radial * sin) * slant,
            normal: radial * cos - self.axis.scale(sin),
            height: distance * cos - along * sin,
        }
    }
}

/// Unit vector and length of `v`; `fallback` where the length is zero.
fn direction_and_length(v: Vector3<f64>, fallback: Vector3<f64>) -> (Vector3<f64>, f64) {
    let length = v.norm();
    if length > 0.0 {
        (v / length, length)
    } else {
        (fallback, 0.0)
    }
}

/// A unit vector perpendicular to `axis`: the coordinate axis along which it is smallest, crossed
/// with it.
pub(super) fn any_perpendicular(axis: &Unit<Vector3<f64>>) -> Vector3<f64> {
    let mut smallest = Vector3::zeros();
    smallest[axis.iamin()] = 1.0;
    axis.cross(&smallest).normalize()
}

/// Two unit vectors that make a right-handed frame with `axis` as the third, always the same for
/// the same axis.
#[must_use]
pub fn perpendicular_frame(axis: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
    let first = any_perpendicular(axis);
    [first, axis.cross(&first)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn surfaces() -> [BaseSurface; 4] {
        let axis = Unit::new_normalize(Vector3::new(1.0, -2.0, 0.5));
        let point = Point3::new(0.3, 0.2, -0.7);
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
                half_angle: 0.4,
            }),
        ]
    }

    #[test]
    fn point_is_foot_plus_height_along_the_normal_and_the_foot_is_on_the_surface() {
        for surface in surfaces() {
            for p in [
                Point3::new(3.0, -4.0, 2.0),
                Point3::new(1.0, -1.5, 0.4),
                Point3::new(0.31, 0.2, -0.7),
            ] {
                let foot = surface.foot(&p);
                assert_relative_eq!(foot.point + foot.normal * foot.height, p, epsilon = 1e-12);
                assert_relative_eq!(foot.normal.norm(), 1.0, epsilon = 1e-12);
                assert_eq!(surface.height(&p).to_bits(), foot.height.to_bits());
                assert_relative_eq!(surface.foot(&foot.point).height, 0.0, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn the_normal_is_the_gradient_of_the_height() {
        let h = 1e-6;
        let p = Point3::new(1.4, -3.0, 0.9);
        for surface in surfaces() {
            let gradient = Vector3::from_fn(|i, _| {
                let mut step = Vector3::zeros();
                step[i] = h;
                (surface.foot(&(p + step)).height - surface.foot(&(p - step)).height) / (2.0 * h)
            });
            assert_relative_eq!(gradient, surface.foot(&p).normal, epsilon = 1e-8);
        }
    }

    #[test]
    fn a_foot_exists_where_it_is_not_unique() {
        for surface in surfaces() {
            let center = Point3::new(0.3, 0.2, -0.7);
            let foot = surface.foot(&center);
            assert!(foot.point.iter().all(|x| x.is_finite()));
            assert_relative_eq!(foot.normal.norm(), 1.0, epsilon = 1e-12);
        }
    }
}
