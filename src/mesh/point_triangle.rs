//! Distance from a point to a triangle, the triangle's share computed once.

use nalgebra::{Point3, Vector3};

/// A triangle, prepared for distance queries.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PreparedTriangle {
    a: Point3<f64>,
    ab: Vector3<f64>,
    ac: Vector3<f64>,
    ab_sq: f64,
    ac_sq: f64,
    ab_ac: f64,
    /// Unit normal; zero for a degenerate triangle.
    normal: Vector3<f64>,
}

impl PreparedTriangle {
    pub(crate) fn new([a, b, c]: [Point3<f64>; 3]) -> Self {
        let (ab, ac) = (b - a, c - a);
        Self {
            a,
            ab,
            ac,
            ab_sq: ab.norm_squared(),
            ac_sq: ac.norm_squared(),
            ab_ac: ab.dot(&ac),
            normal: ab.cross(&ac).try_normalize(0.0).unwrap_or_default(),
        }
    }

    /// Its corners, but for rounding.
    pub(crate) fn corners(&self) -> [Point3<f64>; 3] {
        [self.a, self.a + self.ab, self.a + self.ac]
    }

    /// Unit normal; zero for a degenerate triangle.
    pub(crate) fn normal(&self) -> &Vector3<f64> {
        &self.normal
    }

    /// Squared distance of `p` to the triangle's plane, which the triangle cannot be nearer than; a
    /// little less, for rounding.
    #[inline]
    pub(crate) fn plane_distance_sq(&self, p: &Point3<f64>) -> f64 {
        let height = self.normal.dot(&(p - self.a));
        height * height * (1.0 - 1e-9)
    }

    /// Shares of the second and the third corner in the point of the triangle that is closest to `p` (Ericson,
    /// *Real-Time Collision Detection*, 2005, §5.1.5, in terms of the dot products at `a`).
    #[inline]
    pub(crate) fn closest(&self, p: &Point3<f64>) -> [f64; 2] {
        let ap = p - self.a;
        let (d1, d2) = (self.ab.dot(&ap), self.ac.dot(&ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return [0.0, 0.0];
        }
        let (d3, d4) = (d1 - self.ab_sq, d2 - self.ab_ac);
        if d3 >= 0.0 && d4 <= d3 {
            return [1.0, 0.0];
        }
        let (d5, d6) = (d1 - self.ab_ac, d2 - self.ac_sq);
        if d6 >= 0.0 && d5 <= d6 {
            return [0.0, 1.0];
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return [d1 / (d1 - d3), 0.0];
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return [0.0, d2 / (d2 - d6)];
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return [1.0 - t, t];
        }
        let sum = va + vb + vc;
        [vb / sum, vc / sum]
    }

    /// Squared distance of `p` to the triangle with its inside.
    #[inline]
    pub(crate) fn distance_sq(&self, p: &Point3<f64>) -> f64 {
        let ap = p - self.a;
        let (d1, d2) = (self.ab.dot(&ap), self.ac.dot(&ap));
        // Squared distance to a + s·ab + t·ac.
        let [s, t] = self.closest(p);
        let square = s * s * self.ab_sq + 2.0 * s * t * self.ab_ac + t * t * self.ac_sq;
        (ap.norm_squared() - 2.0 * (s * d1 + t * d2) + square).max(0.0)
    }

    /// The point with these shares of the second and the third corner.
    pub(crate) fn point(&self, [s, t]: [f64; 2]) -> Point3<f64> {
        self.a + self.ab * s + self.ac * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point3<f64>> {
        [-2.0..2.0f64, -2.0..2.0, -2.0..2.0].prop_map(Point3::from)
    }

    proptest! {
        #[test]
        fn distance_matches_a_dense_search(a in point(), b in point(), c in point(), p in point()) {
            let triangle = PreparedTriangle::new([a, b, c]);
            let n = 200;
            let mut dense = f64::INFINITY;
            for i in 0..=n {
                for j in 0..=(n - i) {
                    let (s, t) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                    let q = a + (b - a) * s + (c - a) * t;
                    dense = dense.min((p - q).norm());
                }
            }
            let exact = triangle.distance_sq(&p).sqrt();
            // The grid is at most half a cell's diagonal off.
            let cell = ((b - a).norm() + (c - a).norm()) / f64::from(n);
            prop_assert!(exact <= dense + 1e-7);
            prop_assert!(dense <= exact + cell);
        }
    }
}
