//! The tangent frame of a vertex.

use nalgebra::{Rotation3, Vector3};

use crate::base::{BaseSurface, perpendicular_frame};

/// Orthonormal axes at a vertex: two tangents and the corrected normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// First and second tangent, then the normal; right-handed.
    pub axes: [Vector3<f64>; 3],
}

impl Frame {
    /// Components of `v` along the axes.
    #[must_use]
    pub fn to_local(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let [x, y, z] = &self.axes;
        Vector3::new(v.dot(x), v.dot(y), v.dot(z))
    }

    /// The vector with these components along the axes.
    #[must_use]
    pub fn to_world(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let [x, y, z] = &self.axes;
        x * v.x + y * v.y + z * v.z
    }
}

/// Frames for corrected unit normals (#V) by the paper's rule: the coordinate axis along which the
/// normal is smallest, crossed with it, is the normal's partner.
///
/// The rule depends on the coordinate system. It is applied in the base surface's own (its axis or
/// normal along z), so that turning the scan does not change the result, and so that on a cylinder
/// all frames follow the axis.
///
/// # Reference
/// [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), §3.
#[must_use]
pub fn local_frames(base: &BaseSurface, normals: &[Vector3<f64>]) -> Vec<Frame> {
    let axis = match base {
        BaseSurface::Plane(plane) => plane.normal,
        BaseSurface::Sphere(_) => Vector3::z_axis(),
        BaseSurface::Cylinder(cylinder) => cylinder.axis,
        BaseSurface::Cone(cone) => cone.axis,
    };
    let [x, y] = perpendicular_frame(&axis);
    let to_base = Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_rows(&[
        x.transpose(),
        y.transpose(),
        axis.transpose(),
    ]));
    let from_base = to_base.inverse();
    (normals.iter())
        .map(|normal| {
            let local = to_base * normal;
            let mut smallest = Vector3::zeros();
            smallest[smallest_component(&local)] = 1.0;
            let u = smallest.cross(&-local).normalize();
            Frame {
                axes: [from_base * u, from_base * local.cross(&u), *normal],
            }
        })
        .collect()
}

/// Index of the smallest component; of equal ones (but for rounding) the last, so that on a cylinder
/// it is always the axis.
fn smallest_component(v: &Vector3<f64>) -> usize {
    let smaller = |i: usize, j: usize| {
        if v[j].abs() <= v[i].abs() + 1e-9 {
            j
        } else {
            i
        }
    };
    smaller(smaller(0, 1), 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Cylinder, Plane};
    use approx::assert_relative_eq;
    use nalgebra::{Point3, Unit};

    #[test]
    fn frames_are_orthonormal_and_right_handed_and_go_there_and_back() {
        let base = BaseSurface::Plane(Plane {
            point: Point3::origin(),
            normal: Unit::new_normalize(Vector3::new(1.0, 2.0, 3.0)),
        });
        let normals = [
            Vector3::x(),
            -Vector3::z(),
            Vector3::new(1.0, 1.0, 1.0).normalize(),
        ];
        for (frame, normal) in local_frames(&base, &normals).iter().zip(normals) {
            let [u, v, n] = frame.axes;
            assert_relative_eq!(n, normal);
            assert_relative_eq!(u.cross(&v), n, epsilon = 1e-12);
            let w = Vector3::new(0.3, -2.0, 0.7);
            assert_relative_eq!(frame.to_world(&frame.to_local(&w)), w, epsilon = 1e-12);
        }
    }

    #[test]
    fn on_a_cylinder_every_frame_has_the_axis_for_a_tangent() {
        let axis = Unit::new_normalize(Vector3::new(1.0, -0.3, 2.0));
        let base = BaseSurface::Cylinder(Cylinder {
            point: Point3::origin(),
            axis,
            radius: 1.0,
        });
        let [x, y] = perpendicular_frame(&axis);
        let normals: Vec<_> = (0..50)
            .map(|i| x * f64::from(i).cos() + y * f64::from(i).sin())
            .collect();
        for frame in local_frames(&base, &normals) {
            assert_relative_eq!(frame.axes[1].dot(&axis).abs(), 1.0, epsilon = 1e-12);
        }
    }
}
