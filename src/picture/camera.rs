//! From the scan's coordinates to the picture's.

use nalgebra::{Point3, Vector3};

use super::params::{LARGEST_ZOOM, Projection};
use super::view::Frame;

/// Half the angle of view of the perspective, over the longer side of the picture, in degrees.
const HALF_ANGLE: f64 = 12.5;

/// Share of the drawing area that stays free on each side.
const MARGIN: f64 = 0.03;

/// A rectangle of the picture, in pixels from its left upper corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// A point on the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    /// Pixels from the left edge.
    pub(super) x: f64,
    /// Pixels from the upper edge.
    pub(super) y: f64,
    /// Larger is nearer, and linear on the picture over a plane.
    pub(super) depth: f64,
}

/// A camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Camera {
    frame: Frame,
    /// From the coordinates' origin to the camera along its axes; `None` for an orthographic one.
    eye: Option<Vector3<f64>>,
    /// Pixels a unit; perspective: at distance 1.
    scale: f64,
    /// Pixel of the optical axis.
    middle: [f64; 2],
    /// How many times larger the picture is than the one that shows all points.
    enlargement: f64,
}

impl Camera {
    /// A camera whose picture of `points` (all of them finite) fills `area`.
    pub(super) fn fitted(
        frame: Frame,
        points: &[Point3<f64>],
        projection: Projection,
        area: &Area,
    ) -> Self {
        let inner = 1.0 - 2.0 * MARGIN;
        let [width, height] = [area.width * inner, area.height * inner];
        let middle = [area.left + 0.5 * area.width, area.top + 0.5 * area.height];
        let seen = || points.iter().map(|p| frame.seen(&p.coords));
        let reach = seen().map(|q| q.amax()).fold(0.0, f64::max);
        // A scan that is a point is drawn as one of size 1.
        let reach = if reach > 0.0 { reach } else { 1.0 };
        let slope = HALF_ANGLE.to_radians().tan() / width.max(height);
        // Half the width and the height of what is seen, at distance 1.
        let [tx, ty] = match projection {
            Projection::Perspective => [slope * width, slope * height],
            Projection::Orthographic => [0.0, 0.0],
        };
        // How far the sides of the pyramid (or box) must be moved outwards to hold all points.
        let far = |side: &dyn Fn(&Vector3<f64>) -> f64| {
            seen().map(|q| side(&q)).fold(f64::NEG_INFINITY, f64::max)
        };
        let right = far(&|q| q.x + tx * q.z);
        let left = far(&|q| -q.x + tx * q.z);
        let top = far(&|q| q.y + ty * q.z);
        let bottom = far(&|q| -q.y + ty * q.z);
        let [x, y] = [0.5 * (right - left), 0.5 * (top - bottom)];
        let [half_width, half_height] = [0.5 * (right + left), 0.5 * (top + bottom)];
        if projection == Projection::Orthographic {
            let fit = |pixels: f64, half: f64| 0.5 * pixels / half.max(1e-9 * reach);
            let scale = fit(width, half_width).min(fit(height, half_height));
            return Self {
                frame,
                eye: None,
                scale,
                middle: [middle[0] - scale * x, middle[1] + scale * y],
                enlargement: 1.0,
            };
        }
        // Never nearer than twice the scan's size, so that no point comes near the camera.
        let distance = (half_width / tx).max(half_height / ty).max(2.0 * reach);
        Self {
            frame,
            eye: Some(Vector3::new(x, y, distance)),
            scale: 0.5 * width / tx,
            middle,
            enlargement: 1.0,
        }
    }

    /// Where a point of the scan is on the picture.
    pub(super) fn seen(&self, p: &Point3<f64>) -> Seen {
        let q = self.frame.seen(&p.coords);
        let [u, v, depth] = match &self.eye {
            None => [q.x, q.y, q.z],
            Some(eye) => {
                let nearness = 1.0 / (eye.z - q.z);
                [(q.x - eye.x) * nearness, (q.y - eye.y) * nearness, nearness]
            }
        };
        Seen {
            x: self.middle[0] + self.scale * u,
            y: self.middle[1] - self.scale * v,
            depth,
        }
    }

    /// The point at a depth behind a pixel, in the camera's axes (orthographic: from the scan's origin;
    /// perspective: from the camera).
    pub(super) fn behind(&self, x: f64, y: f64, depth: f64) -> Vector3<f64> {
        let u = (x - self.middle[0]) / self.scale;
        let v = (self.middle[1] - y) / self.scale;
        match &self.eye {
            None => Vector3::new(u, v, depth),
            Some(_) => Vector3::new(u, v, -1.0) / depth,
        }
    }

    /// The scan's unit on the picture at a depth, in pixels.
    pub(super) fn pixels_a_unit(&self, depth: f64) -> f64 {
        match &self.eye {
            None => self.scale,
            Some(_) => self.scale * depth,
        }
    }

    /// Whether depths are those of a perspective: inverse distances.
    pub(super) fn is_perspective(&self) -> bool {
        self.eye.is_some()
    }

    /// Unit vectors of the camera's axes.
    pub(super) fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The same camera, its picture enlarged around a pixel that comes into the middle of `area`; in all at
    /// most [`LARGEST_ZOOM`] times.
    pub(super) fn enlarged(&self, factor: f64, [x, y]: [f64; 2], area: &Area) -> Self {
        let factor = factor.min(LARGEST_ZOOM / self.enlargement);
        let middle = [
            area.left + 0.5 * area.width + factor * (self.middle[0] - x),
            area.top + 0.5 * area.height + factor * (self.middle[1] - y),
        ];
        Self {
            scale: self.scale * factor,
            middle,
            enlargement: self.enlargement * factor,
            ..*self
        }
    }

    /// The same camera, looking at the part of its picture with these points only, so that they take the
    /// given share of `area`.
    pub(super) fn looking_at(&self, points: &[Point3<f64>], share: f64, area: &Area) -> Self {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for p in points {
            let seen = self.seen(p);
            for (k, value) in [seen.x, seen.y].into_iter().enumerate() {
                low[k] = low[k].min(value);
                high[k] = high[k].max(value);
            }
        }
        let fit = |k: usize, side: f64| share * side / (high[k] - low[k]).max(1e-9 * side);
        let factor = fit(0, area.width).min(fit(1, area.height));
        let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
        self.enlarged(factor, middle, area)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;
    use crate::picture::params::{Up, View};
    use crate::picture::view;

    const AREA: Area = Area {
        left: 10.0,
        top: 20.0,
        width: 400.0,
        height: 300.0,
    };

    fn points() -> Vec<Point3<f64>> {
        (0..200)
            .map(|k| {
                let t = f64::from(k);
                Point3::new(
                    (t * 1.3).sin() * 5.0,
                    (t * 0.7).cos() * 2.0,
                    (t * 2.1).sin(),
                )
            })
            .collect()
    }

    fn cameras() -> Vec<Camera> {
        let unit = Vector3::repeat(1.0);
        let mut cameras = Vec::new();
        for view in [View::Front, View::Iso, View::Top, View::Left] {
            let frame = view::frame(&TriMesh::default(), None, &unit, view, Up::Y);
            for projection in [Projection::Perspective, Projection::Orthographic] {
                cameras.push(Camera::fitted(frame, &points(), projection, &AREA));
            }
        }
        cameras
    }

    #[test]
    fn the_scan_fills_the_area_and_stays_in_it() {
        for camera in cameras() {
            let seen: Vec<Seen> = points().iter().map(|p| camera.seen(p)).collect();
            let range = |values: &dyn Fn(&Seen) -> f64| {
                let low = seen.iter().map(values).fold(f64::INFINITY, f64::min);
                let high = seen.iter().map(values).fold(f64::NEG_INFINITY, f64::max);
                (low, high)
            };
            let (left, right) = range(&|s| s.x);
            let (top, bottom) = range(&|s| s.y);
            let inner = 1.0 - 2.0 * MARGIN;
            let within = 1e-9;
            assert!(
                left >= 10.0 + 400.0 * MARGIN - within && right <= 410.0 - 400.0 * MARGIN + within
            );
            assert!(
                top >= 20.0 + 300.0 * MARGIN - within && bottom <= 320.0 - 300.0 * MARGIN + within
            );
            let [wide, high] = [(right - left) / 400.0, (bottom - top) / 300.0];
            // Seen in perspective the two sides of a scan need not touch at the same distance.
            assert!(wide.max(high) > 0.85 * inner, "{wide} {high}");
        }
    }

    #[test]
    fn what_is_seen_at_a_pixel_is_behind_it() {
        for camera in cameras() {
            for p in &points() {
                let seen = camera.seen(p);
                let q = camera.behind(seen.x, seen.y, seen.depth);
                let mut expected = camera.frame.seen(&p.coords);
                if let Some(eye) = &camera.eye {
                    expected -= eye;
                }
                assert!((q - expected).norm() < 1e-9, "{q} {expected}");
            }
        }
    }

    #[test]
    fn nearer_points_have_larger_depths() {
        for camera in cameras() {
            let near = Point3::from(camera.frame.toward * 0.5);
            let far = Point3::from(camera.frame.toward * -0.5);
            assert!(camera.seen(&near).depth > camera.seen(&far).depth);
        }
    }
}
