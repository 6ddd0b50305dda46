//! Directions: from where a scan is looked at, and what is up.

use nalgebra::{Point3, Vector3};

use crate::mesh::{TriMesh, triangle_normal};

use super::params::{Up, View};

/// The camera's axes in the scan's coordinates: orthonormal, right-handed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) right: Vector3<f64>,
    pub(super) up: Vector3<f64>,
    /// From the scan to the camera.
    pub(super) toward: Vector3<f64>,
}

impl Frame {
    /// A direction or difference in the camera's axes.
    pub(super) fn seen(&self, v: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(self.right.dot(v), self.up.dot(v), self.toward.dot(v))
    }
}

/// Length of the sum of the triangles' normals over the sum of their lengths from which on a surface counts
/// as seen from one side: 0 for a closed surface, 1/2 for half a sphere, 1 for a plane.
const ONE_SIDED: f64 = 0.4;

/// How much longer along z than along x and y a scan is that stands on z.
const UPRIGHT: f64 = 1.2;

/// Angles of [`View::Iso`], in degrees.
const ISO: [f64; 2] = [35.0, 25.0];

/// Cosine of the angle between the view and the up axis from which on another axis is up on the picture.
const ALONG_UP: f64 = 0.94;

/// The camera's axes for a view of a mesh that reaches over `extent` along x, y and z; `completed` (#V) tells
/// which of its vertices were.
pub(super) fn frame(
    mesh: &TriMesh,
    completed: Option<&[bool]>,
    extent: &Vector3<f64>,
    view: View,
    up: Up,
) -> Frame {
    // Up, front (from the scan to somebody in front of it) and what is up where one looks along up.
    let (up, front) = match up {
        Up::X => (Vector3::x(), -Vector3::z()),
        Up::Z => (Vector3::z(), -Vector3::y()),
        Up::Y => (Vector3::y(), Vector3::z()),
        Up::Auto if extent.z > UPRIGHT * extent.x.max(extent.y) => (Vector3::z(), -Vector3::y()),
        Up::Auto => (Vector3::y(), Vector3::z()),
    };
    let right = up.cross(&front);
    let by_angles = |[azimuth, elevation]: [f64; 2]| {
        (front * azimuth.cos() + right * azimuth.sin()) * elevation.cos() + up * elevation.sin()
    };
    let [azimuth, elevation] = ISO.map(f64::to_radians);
    let iso = || by_angles([azimuth, elevation]);
    // From where the completed part is seen: not straight, so that what is around it shows, too.
    let completion = || {
        let marks = completed?;
        let is_new = |t: &[u32; 3]| t.iter().any(|v| marks[*v as usize]);
        let normal = mean_normal(mesh, is_new)?;
        let around = normal.dot(&right).atan2(normal.dot(&front));
        Some(by_angles([around + azimuth, elevation]))
    };
    let toward = match view {
        View::Auto => mean_normal(mesh, |_| true)
            .or_else(completion)
            .unwrap_or_else(iso),
        View::Front => front,
        View::Back => -front,
        View::Left => -right,
        View::Right => right,
        View::Top => up,
        View::Bottom => -up,
        View::Iso => iso(),
        View::Angles { azimuth, elevation } => by_angles([azimuth, elevation]),
    };
    // From above, what is in front is at the bottom of the picture; from below, at its top.
    let upwards = if toward.dot(&up).abs() < ALONG_UP {
        up
    } else {
        front * -toward.dot(&up).signum()
    };
    let right = upwards.cross(&toward).normalize();
    Frame {
        right,
        up: toward.cross(&right),
        toward,
    }
}

/// The direction that most of a part of a surface faces; `None` if it faces all ways.
fn mean_normal(mesh: &TriMesh, is_part: impl Fn(&[u32; 3]) -> bool) -> Option<Vector3<f64>> {
    let mut sum = Vector3::zeros();
    let mut total = 0.0;
    for f in (0..mesh.triangles.len()).filter(|f| is_part(&mesh.triangles[*f])) {
        let normal = triangle_normal(mesh.corners(f));
        sum += normal;
        total += normal.norm();
    }
    let length = sum.norm();
    (length > ONE_SIDED * total).then(|| sum / length)
}

/// The corners of the box around the points that are not NaN or infinite; `None` without any.
pub(super) fn bounds<'a>(
    points: impl Iterator<Item = &'a Point3<f64>>,
) -> Option<[Point3<f64>; 2]> {
    let finite = points.filter(|p| p.iter().all(|x| x.is_finite()));
    finite.fold(None, |bounds, p| match bounds {
        None => Some([*p, *p]),
        Some([low, high]) => Some([low.inf(p), high.sup(p)]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(view: View, up: Up) -> Frame {
        frame(&TriMesh::default(), None, &Vector3::repeat(1.0), view, up)
    }

    fn assert_close(a: Vector3<f64>, b: Vector3<f64>) {
        assert!((a - b).norm() < 1e-12, "{a} {b}");
    }

    #[test]
    fn frames_are_right_handed_and_orthonormal() {
        let mut views = vec![
            View::Front,
            View::Back,
            View::Left,
            View::Right,
            View::Top,
            View::Bottom,
            View::Iso,
        ];
        for k in 0..40 {
            views.push(View::Angles {
                azimuth: f64::from(k) * 0.7,
                elevation: f64::from(k) * 0.31 - 5.0,
            });
        }
        for up in [Up::X, Up::Y, Up::Z] {
            for view in &views {
                let frame = of(*view, up);
                assert_close(frame.right.cross(&frame.up), frame.toward);
                assert!((frame.right.norm() - 1.0).abs() < 1e-12);
                assert!(frame.right.dot(&frame.up).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn named_views_are_where_their_names_say() {
        let front = of(View::Front, Up::Z);
        assert_close(front.toward, -Vector3::y());
        assert_close(front.right, Vector3::x());
        assert_close(front.up, Vector3::z());
        let top = of(View::Top, Up::Z);
        assert_close(top.toward, Vector3::z());
        assert_close(top.up, Vector3::y());
        assert_close(of(View::Front, Up::Y).toward, Vector3::z());
        assert_close(of(View::Right, Up::Y).toward, Vector3::x());
        assert_close(of(View::Top, Up::Y).up, -Vector3::z());
        let quarter = View::Angles {
            azimuth: std::f64::consts::FRAC_PI_2,
            elevation: 0.0,
        };
        assert_close(of(quarter, Up::Y).toward, of(View::Right, Up::Y).toward);
    }

    #[test]
    fn a_sheet_is_seen_from_the_side_it_faces() {
        let sheet = TriMesh {
            positions: vec![
                Point3::new(0.0, 0.0, 0.0),
                Point3::new(0.0, 1.0, 0.0),
                Point3::new(1.0, 0.0, 0.0),
            ],
            triangles: vec![[0, 1, 2]],
        };
        let frame = frame(
            &sheet,
            None,
            &Vector3::new(1.0, 1.0, 0.0),
            View::Auto,
            Up::Auto,
        );
        assert_close(frame.toward, -Vector3::z());
        assert_close(frame.up, Vector3::y());
    }
}
