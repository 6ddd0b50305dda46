//! How far a piece of surface strays from a plane: a lower bound of the distance to it from points
//! near its middle, tighter than between parallel planes around all of it.

use nalgebra::{Point3, Vector3};

use crate::mesh::PreparedTriangle;

/// Slopes tried for an envelope. Steeper ones leave the middle thinner, but count a gap for less.
const SLOPES: [f64; 4] = [0.1, 0.2, 0.4, 0.8];

/// Every point x of the piece is at most half + slope · d from the plane normal · x = middle, d being
/// how far x is from the disc that the envelope was made for, seen along the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Envelope {
    /// Unit normal.
    pub(super) normal: Vector3<f64>,
    pub(super) middle: f64,
    pub(super) half: f64,
    pub(super) slope: f64,
}

/// A triangle seen from the middle of the disc along the normal.
struct Seen {
    /// Greatest distance from the plane.
    most: f64,
    /// The plane of the triangle: its distance from the envelope's over the middle, and its slope.
    rise: f64,
    slope: f64,
    /// Distance from the disc.
    away: f64,
}

impl Envelope {
    /// Around `triangles`, for the disc (across the normal) with the given center and radius; that
    /// slope is taken which bounds the distance of points `gap` off the plane best. `None` for no
    /// triangle or only degenerate ones.
    pub(super) fn around(
        triangles: &[&PreparedTriangle],
        center: &Point3<f64>,
        radius: f64,
        gap: f64,
    ) -> Option<Self> {
        let (normal, above) = plane_near(triangles, center, radius)?;
        let seen: Vec<Seen> = (triangles.iter())
            .map(|t| Seen::new(t, &normal, &(center + normal * above), radius))
            .collect();
        let score = |half: f64, slope: f64| (gap - half).max(0.0).powi(2) / (1.0 + slope * slope);
        SLOPES
            .map(|slope| {
                let halves = seen.iter().map(|t| t.half(slope, radius));
                (halves.fold(0.0, f64::max), slope)
            })
            .into_iter()
            .max_by(|a, b| score(a.0, a.1).total_cmp(&score(b.0, b.1)))
            .map(|(half, slope)| Self {
                normal,
                middle: normal.dot(&center.coords) + above,
                half,
                slope,
            })
    }
}

impl Seen {
    /// `middle`: the disc's center, moved onto the plane.
    fn new(
        triangle: &PreparedTriangle,
        normal: &Vector3<f64>,
        middle: &Point3<f64>,
        radius: f64,
    ) -> Self {
        let offsets = triangle.corners().map(|corner| corner - middle);
        let heights = offsets.map(|offset| offset.dot(normal));
        let across = triangle.normal();
        let along = across.dot(normal).abs();
        let (rise, slope) = if along > 1e-3 {
            // A needle's normal is uncertain: by as much as its corners are off.
            let off = offsets.map(|offset| across.dot(&(offset - offsets[0])).abs());
            let off = off[1].max(off[2]);
            let sin = across.cross(normal).norm();
            ((across.dot(&offsets[0]).abs() + off) / along, sin / along)
        } else {
            (f64::INFINITY, f64::INFINITY)
        };
        let flat = [0, 1, 2].map(|i| offsets[i] - normal * heights[i]);
        Self {
            most: heights.iter().fold(0.0, |most, h| h.abs().max(most)),
            rise,
            slope,
            away: (least_length(&flat, normal) - radius).max(0.0),
        }
    }

    /// Least half thickness in the disc with which an envelope of this slope holds the triangle:
    /// either its farthest corner were as near to the disc as its nearest point, or, its plane being
    /// less steep than the envelope, only what the plane does over the disc matters.
    fn half(&self, slope: f64, radius: f64) -> f64 {
        let by_corners = (self.most - slope * self.away).max(0.0);
        if self.slope <= slope {
            by_corners.min(self.rise + self.slope * radius)
        } else {
            by_corners
        }
    }
}

/// At most the distance from the origin to the triangle with these corners across `normal`: how far it
/// is on the other side of some lines.
fn least_length(corners: &[Vector3<f64>; 3], normal: &Vector3<f64>) -> f64 {
    let towards = |direction: Vector3<f64>| {
        let unit = direction.try_normalize(0.0).unwrap_or_default();
        let along = corners.map(|corner| corner.dot(&unit));
        let near = along[0].min(along[1]).min(along[2]);
        let far = along[0].max(along[1]).max(along[2]);
        near.max(-far) * (1.0 - 1e-6)
    };
    (0..3)
        .map(|i| towards((corners[(i + 1) % 3] - corners[i]).cross(normal)))
        .fold(towards(corners.iter().sum()), f64::max)
}

/// A plane close to the triangles near `center`: its unit normal, and how far above the center it is.
fn plane_near(
    triangles: &[&PreparedTriangle],
    center: &Point3<f64>,
    radius: f64,
) -> Option<(Vector3<f64>, f64)> {
    let (mut normal, mut above, mut total) = (Vector3::zeros(), 0.0, 0.0);
    for triangle in triangles {
        let height = triangle.normal().dot(&(triangle.corners()[0] - center));
        let over = center + triangle.normal() * height;
        let near = triangle.distance_sq(&over) / (radius * radius);
        let weight = 1.0 / (0.05 + near * near);
        normal += triangle.normal() * weight;
        above += height * weight;
        total += weight;
    }
    Some((normal.try_normalize(1e-6 * total)?, above / total))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point(size: f64) -> impl Strategy<Value = Point3<f64>> {
        [-1.0..1.0f64, -1.0..1.0, -1.0..1.0].prop_map(move |p| Point3::from(p) * size)
    }

    proptest! {
        #[test]
        fn the_surface_is_never_outside(
            corners in prop::collection::vec([point(2.0), point(2.0), point(2.0)], 1..8),
            flat in 0.01..1.0f64,
            radius in 0.05..1.0f64,
            places in prop::collection::vec([0.0..1.0f64, 0.0..1.0], 20),
        ) {
            let flatten = |p: Point3<f64>| Point3::new(p.x, p.y, p.z * flat);
            let triangles: Vec<PreparedTriangle> = (corners.iter())
                .map(|t| PreparedTriangle::new(t.map(flatten)))
                .collect();
            let triangles: Vec<&PreparedTriangle> = triangles.iter().collect();
            let center = Point3::origin();
            let Some(envelope) = Envelope::around(&triangles, &center, radius, 0.3) else {
                return Ok(());
            };
            for (triangle, [s, t]) in
                triangles.iter().flat_map(|triangle| places.iter().map(move |p| (triangle, *p)))
            {
                let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                let [a, b, c] = triangle.corners();
                let on = a + (b - a) * s + (c - a) * t;
                let height = envelope.normal.dot(&on.coords);
                let lateral = (on.coords - envelope.normal * height).norm();
                let away = (lateral - radius).max(0.0);
                let strays = (height - envelope.middle).abs();
                prop_assert!(strays <= envelope.half + envelope.slope * away + 1e-9);
            }
        }
    }
}
