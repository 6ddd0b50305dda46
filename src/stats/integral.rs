//! Integrals of the relief over its base surface, exact for heights linear in each triangle.

use serde::Serialize;

use crate::mesh::triangle_area;
use crate::relief::Relief;

/// Figures of a part of the relief.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReliefPart {
    /// Number of triangles.
    pub triangles: usize,
    /// Area of the base surface under them, in square units.
    pub area: f64,
    /// Volume between base surface and relief (both sides counted positive) over the area: the
    /// paper's mean integral, in the scan's unit.
    pub mean_integral: f64,
    /// Mean height, signed, in the scan's unit.
    pub mean_height: f64,
    /// RMS roughness Sq: root mean square height about the mean height, in the scan's unit
    /// (ISO 25178-2, 4.1.1, with the base surface for the form).
    pub rms_roughness: f64,
}

/// Figures of the given triangles of the relief; `None` if they have no area.
#[must_use]
pub fn relief_part(relief: &Relief, triangles: &[[u32; 3]]) -> Option<ReliefPart> {
    let (mut area, mut signed, mut unsigned, mut square) = (0.0, 0.0, 0.0, 0.0);
    for t in triangles {
        let base_area = triangle_area(t.map(|v| relief.feet[v as usize]));
        let heights = t.map(|v| relief.heights[v as usize]);
        area += base_area;
        signed += base_area * heights.iter().sum::<f64>() / 3.0;
        unsigned += base_area * mean_absolute(heights);
        square += base_area * mean_square(heights);
    }
    if area <= 0.0 {
        return None;
    }
    let mean_height = signed / area;
    Some(ReliefPart {
        triangles: triangles.len(),
        area,
        mean_integral: unsigned / area,
        mean_height,
        rms_roughness: (square / area - mean_height * mean_height).max(0.0).sqrt(),
    })
}

/// Mean of h² over a triangle with corner heights.
fn mean_square(h: [f64; 3]) -> f64 {
    let sum: f64 = h.iter().sum();
    (sum * sum + h.iter().map(|x| x * x).sum::<f64>()) / 12.0
}

/// Mean of |h| over a triangle with corner heights. Where the sign changes, the corner that is alone
/// on its side cuts off a smaller triangle.
fn mean_absolute(h: [f64; 3]) -> f64 {
    let sum: f64 = h.iter().sum();
    let negative = h.iter().filter(|x| **x < 0.0).count();
    let alone_is_negative = negative == 1;
    let alone = (0..3).find(|i| (h[*i] < 0.0) == alone_is_negative);
    match (negative, alone) {
        (1 | 2, Some(i)) => {
            let (tip, a, b) = (h[i].abs(), h[(i + 1) % 3].abs(), h[(i + 2) % 3].abs());
            let share = tip * tip / ((tip + a) * (tip + b));
            let others = if alone_is_negative { sum } else { -sum };
            others / 3.0 + 2.0 * share * tip / 3.0
        }
        _ => sum.abs() / 3.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Means of |h| and h² by midpoints of n² equal triangles.
    fn dense(h: [f64; 3]) -> (f64, f64) {
        let n = 200;
        let (mut absolute, mut square) = (0.0, 0.0);
        for i in 0..n {
            for j in 0..n - i {
                let upright = (f64::from(i) + 1.0 / 3.0, f64::from(j) + 1.0 / 3.0);
                let turned = (f64::from(i) + 2.0 / 3.0, f64::from(j) + 2.0 / 3.0);
                for (s, t) in [upright, turned] {
                    if s + t > f64::from(n) {
                        continue;
                    }
                    let (s, t) = (s / f64::from(n), t / f64::from(n));
                    let value = h[0] + (h[1] - h[0]) * s + (h[2] - h[0]) * t;
                    absolute += value.abs();
                    square += value * value;
                }
            }
        }
        let count = f64::from(n) * f64::from(n);
        (absolute / count, square / count)
    }

    proptest! {
        #[test]
        fn means_match_a_dense_sum(h in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0]) {
            let (absolute, square) = dense(h);
            prop_assert!((mean_absolute(h) - absolute).abs() < 1e-4);
            prop_assert!((mean_square(h) - square).abs() < 1e-4);
        }
    }

    #[test]
    fn zeros_are_no_sign_change() {
        assert!((mean_absolute([0.0, 0.0, 3.0]) - 1.0).abs() < 1e-15);
        assert!((mean_absolute([0.0, -3.0, 0.0]) - 1.0).abs() < 1e-15);
        assert!(mean_absolute([0.0; 3]).abs() < 1e-15);
    }
}
