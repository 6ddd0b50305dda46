//! The space between two parallel planes that holds a piece of surface: a cheap lower bound of the
//! distance to it.

use nalgebra::{Point3, Vector3};

/// low ≤ normal · x ≤ high for every point x of the piece, rounded outwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slab {
    normal: [f32; 3],
    low: f32,
    high: f32,
}

impl Slab {
    /// Around triangles with the given corners, across their mean normal; `None` for no triangle.
    pub(super) fn around(
        triangles: impl Iterator<Item = [Point3<f64>; 3]> + Clone,
    ) -> Option<Self> {
        let sum: Vector3<f64> = (triangles.clone())
            .map(|[a, b, c]| (b - a).cross(&(c - a)))
            .sum();
        let unit = sum.try_normalize(0.0).unwrap_or_else(Vector3::z);
        // A little shorter than 1, so that a gap along it is never longer than the distance.
        #[expect(clippy::cast_possible_truncation, reason = "any direction will do")]
        let normal = [0, 1, 2].map(|i| (unit[i] * (1.0 - 1e-6)) as f32);
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for corner in triangles.flatten() {
            let along = along(&normal, &corner);
            range = [range[0].min(along), range[1].max(along)];
        }
        #[expect(clippy::cast_possible_truncation, reason = "rounded outwards")]
        let [low, high] = [(range[0] as f32).next_down(), (range[1] as f32).next_up()];
        (low <= high).then_some(Self { normal, low, high })
    }

    /// At most the squared distance of `p` to any point of the piece.
    #[inline]
    pub(super) fn least_distance_sq(&self, p: &Point3<f64>) -> f64 {
        let along = along(&self.normal, p);
        let above = along - f64::from(self.high);
        let below = f64::from(self.low) - along;
        let gap = above.max(below).max(0.0);
        gap * gap
    }
}

#[inline]
fn along(normal: &[f32; 3], p: &Point3<f64>) -> f64 {
    f64::from(normal[0]) * p.x + f64::from(normal[1]) * p.y + f64::from(normal[2]) * p.z
}

#[cfg(test)]
mod tests {
    use super::super::tests::point;
    use super::*;
    use crate::mesh::PreparedTriangle;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_bound_is_never_above_the_distance(
            corners in prop::collection::vec([point(), point(), point()], 1..8),
            p in point(),
        ) {
            let slab = Slab::around(corners.iter().copied()).unwrap();
            let nearest = (corners.iter())
                .map(|t| PreparedTriangle::new(*t).distance_sq(&p))
                .fold(f64::INFINITY, f64::min);
            prop_assert!(slab.least_distance_sq(&p) <= nearest + 1e-12);
        }
    }

    #[test]
    fn for_a_flat_piece_the_bound_is_the_height() {
        let flat = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]].map(Point3::from);
        let slab = Slab::around(std::iter::once(flat)).unwrap();
        let bound = slab.least_distance_sq(&Point3::new(0.2, 0.2, 3.0)).sqrt();
        assert!((bound - 2.0).abs() < 1e-5);
    }
}
