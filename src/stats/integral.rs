//! Integrals of the relief over its base surface, exact for heights linear in each triangle.

use nalgebra::Point3;
use serde::Serialize;

use crate::mesh::triangle_area;
use crate::relief::Relief;

use super::areal::{ArealParameters, HeightParameters, MaterialRatioCurve};

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
    /// (ISO 25178-2:2021, 4.2, with the base surface for the form).
    pub rms_roughness: f64,
    /// Areal parameters of the heights about their mean. Heights are linear in each triangle: Sa, Sq, Ssk, Sku,
    /// Sdq and Sdr are exact for that surface; the material ratio is that of the vertices, each with a third of
    /// the area around it; Sal, Str and Std are read off square patches, and missing where no patch fits.
    pub areal: ArealParameters,
}

/// Figures of the given triangles of the relief; `None` if they have no area. Spatial parameters are not among
/// them.
#[must_use]
pub fn relief_part(relief: &Relief, triangles: &[[u32; 3]]) -> Option<ReliefPart> {
    let items = heights_by_area(relief, triangles, 0.0);
    let curve = MaterialRatioCurve::new(items.iter().copied())?;
    let of_vertices = HeightParameters::of(items.into_iter())?;
    let mut sums = Sums::default();
    for t in triangles {
        sums.add(relief, t, None);
    }
    let mean_height = sums.signed / sums.area;
    // Moments about the mean, which the first round has told.
    let mut about = Sums::default();
    for t in triangles {
        about.add(relief, t, Some(mean_height));
    }
    let [square, cube, fourth] = about.powers.map(|sum| sum / about.area);
    let rms_roughness = square.sqrt();
    let mean_integral = sums.unsigned / sums.area;
    let flat = rms_roughness <= 1e-12 * mean_integral;
    let areal = ArealParameters {
        sa: about.unsigned / about.area,
        sq: rms_roughness,
        ssk: (!flat).then(|| cube / rms_roughness.powi(3)),
        sku: (!flat).then(|| fourth / square.powi(2)),
        sdq: Some((about.square_slope / about.area).sqrt()),
        sdr: Some(100.0 * about.developed / about.area),
        ..ArealParameters::of_heights(&of_vertices, &curve)
    };
    Some(ReliefPart {
        triangles: triangles.len(),
        area: sums.area,
        mean_integral,
        mean_height,
        rms_roughness,
        areal,
    })
}

/// Heights of vertices over the given one, with a third of the base area of the triangles around each; without
/// those that have none.
pub(super) fn heights_by_area(
    relief: &Relief,
    triangles: &[[u32; 3]],
    over: f64,
) -> Vec<(f64, f64)> {
    let mut areas = vec![0.0; relief.heights.len()];
    for t in triangles {
        let area = triangle_area(t.map(|v| relief.feet[v as usize]));
        for v in t {
            areas[*v as usize] += area / 3.0;
        }
    }
    (relief.heights.iter().zip(areas))
        .filter(|(_, area)| *area > 0.0)
        .map(|(height, area)| (height - over, area))
        .collect()
}

/// Integrals over triangles.
#[derive(Default)]
struct Sums {
    area: f64,
    signed: f64,
    unsigned: f64,
    /// Of the second, third and fourth power.
    powers: [f64; 3],
    square_slope: f64,
    /// By how much the relief's area is more than the base's.
    developed: f64,
}

impl Sums {
    /// Adds a triangle, with heights about `mean` (without it about the base surface).
    fn add(&mut self, relief: &Relief, t: &[u32; 3], mean: Option<f64>) {
        let feet = t.map(|v| relief.feet[v as usize]);
        let area = triangle_area(feet);
        let heights = t.map(|v| relief.heights[v as usize] - mean.unwrap_or(0.0));
        self.area += area;
        self.signed += area * heights.iter().sum::<f64>() / 3.0;
        self.unsigned += area * mean_absolute(heights);
        for (sum, mean) in self.powers.iter_mut().zip(mean_powers(heights)) {
            *sum += area * mean;
        }
        let square_slope = square_slope(feet, heights);
        self.square_slope += area * square_slope;
        // √(1 + s) − 1 without the loss of digits for small slopes.
        self.developed += area * square_slope / (1.0 + (1.0 + square_slope).sqrt());
    }
}

/// Square of the gradient of heights that are linear in a triangle; 0 for a triangle without area.
fn square_slope([a, b, c]: [Point3<f64>; 3], h: [f64; 3]) -> f64 {
    let (along, across) = (b - a, c - a);
    let (xx, xy, yy) = (
        along.norm_squared(),
        along.dot(&across),
        across.norm_squared(),
    );
    let (u, v) = (h[1] - h[0], h[2] - h[0]);
    let determinant = xx * yy - xy * xy;
    if determinant <= 1e-20 * xx * yy {
        return 0.0;
    }
    (u * u * yy - 2.0 * u * v * xy + v * v * xx) / determinant
}

/// Means of h², h³ and h⁴ over a triangle with corner heights: complete symmetric polynomials over the number
/// of their terms.
fn mean_powers([a, b, c]: [f64; 3]) -> [f64; 3] {
    let (s1, s2, s3) = (a + b + c, a * b + b * c + c * a, a * b * c);
    // Newton's recursion of complete by elementary ones.
    let h2 = s1 * s1 - s2;
    let h3 = s1 * h2 - s2 * s1 + s3;
    let h4 = s1 * h3 - s2 * h2 + s3 * s1;
    [h2 / 6.0, h3 / 10.0, h4 / 15.0]
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

    /// Means of |h|, h², h³ and h⁴ by midpoints of n² equal triangles.
    fn dense(h: [f64; 3]) -> [f64; 4] {
        let n = 200;
        let mut sums = [0.0; 4];
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
                    let powers = [value.abs(), value.powi(2), value.powi(3), value.powi(4)];
                    for (sum, power) in sums.iter_mut().zip(powers) {
                        *sum += power;
                    }
                }
            }
        }
        let count = f64::from(n) * f64::from(n);
        sums.map(|sum| sum / count)
    }

    proptest! {
        #[test]
        fn means_match_a_dense_sum(h in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0]) {
            let [absolute, powers @ ..] = dense(h);
            prop_assert!((mean_absolute(h) - absolute).abs() < 1e-4);
            for (exact, sum) in mean_powers(h).into_iter().zip(powers) {
                prop_assert!((exact - sum).abs() < 2e-4, "{} {}", exact, sum);
            }
        }
    }

    #[test]
    fn zeros_are_no_sign_change() {
        assert!((mean_absolute([0.0, 0.0, 3.0]) - 1.0).abs() < 1e-15);
        assert!((mean_absolute([0.0, -3.0, 0.0]) - 1.0).abs() < 1e-15);
        assert!(mean_absolute([0.0; 3]).abs() < 1e-15);
    }
}
