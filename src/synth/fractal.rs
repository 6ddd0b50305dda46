//! Value noise and its fractal sum, for surfaces that are rough without a pattern.

use nalgebra::Vector3;

use crate::rng::Rng;

/// Smooth random function of space with features of size 1; repeats every 256 units.
#[derive(Debug, Clone)]
pub(super) struct ValueNoise {
    /// Values at lattice points, in [-1, 1).
    values: [f64; 256],
    /// A random permutation of 0..256, to hash lattice points.
    permutation: [u8; 256],
}

impl ValueNoise {
    pub(super) fn new(rng: &mut Rng) -> Self {
        let mut permutation: [u8; 256] = std::array::from_fn(low_byte);
        for i in (1..256).rev() {
            permutation.swap(i, rng.index(i + 1));
        }
        Self {
            values: std::array::from_fn(|_| 2.0 * rng.uniform() - 1.0),
            permutation,
        }
    }

    /// Value at `p`, in [-1, 1), with continuous second derivatives.
    pub(super) fn at(&self, p: Vector3<f64>) -> f64 {
        let cell = p.map(f64::floor);
        let weight = (p - cell).map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
        let [x, y, z] = [cell.x, cell.y, cell.z].map(cell_byte);
        let mut sum = 0.0;
        for corner in 0u8..8 {
            let [dx, dy, dz] = [corner & 1, corner >> 1 & 1, corner >> 2];
            let hash = |byte: u8| self.permutation[usize::from(byte)];
            let h = hash(
                hash(hash(x.wrapping_add(dx)).wrapping_add(y.wrapping_add(dy)))
                    .wrapping_add(z.wrapping_add(dz)),
            );
            let side = |d: u8, w: f64| if d == 1 { w } else { 1.0 - w };
            sum += self.values[usize::from(h)]
                * side(dx, weight.x)
                * side(dy, weight.y)
                * side(dz, weight.z);
        }
        sum
    }

    /// Fractal sum: each octave half as large and half as high as the one before. In (-2, 2),
    /// mostly in (-1, 1).
    pub(super) fn fractal(&self, p: Vector3<f64>, octaves: u32) -> f64 {
        let (mut sum, mut amplitude, mut position) = (0.0, 1.0, p);
        for _ in 0..octaves {
            sum += amplitude * self.at(position);
            amplitude *= 0.5;
            // The shift keeps lattice planes of the octaves from coinciding.
            position = position * 2.0 + Vector3::new(19.19, 7.73, 31.37);
        }
        sum
    }
}

/// A whole number modulo 256.
fn low_byte(i: usize) -> u8 {
    i.to_le_bytes()[0]
}

/// A whole number, possibly negative, modulo 256.
#[expect(
    clippy::cast_possible_truncation,
    reason = "lattice points of objects a few thousand units wide"
)]
fn cell_byte(x: f64) -> u8 {
    (x as i64).to_le_bytes()[0]
}

/// 0 below `from`, 1 above `to`, and a smooth step between.
pub(super) fn smooth_step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Colour between `from` (0) and `to` (1), times `brightness`; intensities 0 to 255.
pub(super) fn blend(from: [f64; 3], to: [f64; 3], t: f64, brightness: f64) -> [u8; 3] {
    std::array::from_fn(|i| to_byte((from[i] + t * (to[i] - from[i])) * brightness))
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to the range of the type"
)]
fn to_byte(intensity: f64) -> u8 {
    intensity.round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stage;

    #[test]
    fn value_noise_is_bounded_continuous_and_not_constant() {
        let noise = ValueNoise::new(&mut Rng::new(1, Stage::Synth, 0));
        let line: Vec<f64> = (-4000..4000)
            .map(|i| noise.at(Vector3::new(0.01 * f64::from(i), 0.4, -0.7)))
            .collect();
        assert!(line.iter().all(|v| v.abs() <= 1.0));
        assert!(line.windows(2).all(|w| (w[1] - w[0]).abs() < 0.05));
        let mean_square = line.iter().map(|v| v * v).sum::<f64>() / 8000.0;
        assert!(mean_square > 0.03, "{mean_square}");
    }
}
