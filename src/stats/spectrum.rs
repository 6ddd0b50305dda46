//! Radially averaged power spectra.

use rustfft::FftDirection;
use rustfft::num_complex::Complex;
use serde::Serialize;

use super::areal::fourier::transform;
use super::patches::Patches;

/// Power by wavelength.
///
/// # Reference
/// T. D. B. Jacobs, T. Junge, L. Pastewka: *Quantitative characterization of surface topography using
/// spectral analysis.* Surface Topography: Metrology and Properties 5(1), 2017: 2-D isotropic power spectral
/// density.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spectrum {
    /// Wavelengths in the scan's unit, descending: the patch's side and its whole fractions.
    pub wavelengths: Vec<f64>,
    /// Power spectral density of the original part, the mean over all directions, in the fourth power of the
    /// scan's unit.
    pub original: Vec<f64>,
    /// … of the completed part.
    pub completed: Vec<f64>,
    /// Number of patches of either part that it was averaged over.
    pub patches: [usize; 2],
}

impl Spectrum {
    /// Of patches of equal size.
    pub(super) fn new(original: &Patches, completed: &Patches) -> Self {
        let length = original.side as f64 * original.step;
        let patches = [original.heights.len(), completed.heights.len()];
        let [original, completed] =
            [original, completed].map(|part| radial(&part.heights, part.side, part.step));
        Self {
            wavelengths: (1..=original.len()).map(|k| length / k as f64).collect(),
            original,
            completed,
            patches,
        }
    }
}

/// Density at 1, 2, … waves a side, up to half the side.
fn radial(patches: &[Vec<f64>], side: usize, step: f64) -> Vec<f64> {
    let half = side / 2;
    let (mut sums, mut counts) = (vec![0.0; half], vec![0.0f64; half]);
    let window: Vec<f64> = (0..side)
        .map(|i| {
            let phase = std::f64::consts::TAU * (i as f64 + 0.5) / side as f64;
            0.5 - 0.5 * phase.cos()
        })
        .collect();
    let energy = window.iter().map(|w| w * w).sum::<f64>().powi(2);
    for patch in patches {
        let power = power(&without_plane(patch, side), &window, side);
        for (index, power) in power.iter().enumerate() {
            let wave = |i: usize| i.min(side - i) as f64;
            let waves = wave(index % side).hypot(wave(index / side)).round();
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a small whole number"
            )]
            let waves = waves as usize;
            if (1..=half).contains(&waves) {
                sums[waves - 1] += power * step * step / energy;
                counts[waves - 1] += 1.0;
            }
        }
    }
    (sums.iter().zip(counts))
        .map(|(sum, count)| sum / count.max(1.0))
        .collect()
}

/// Heights about their least-squares plane: what is longer than the patch would leak into all waves.
fn without_plane(patch: &[f64], side: usize) -> Vec<f64> {
    let center = (side as f64 - 1.0) / 2.0;
    let place = |i: usize| (i as f64 - center) / center.max(1.0);
    let (mut mean, mut x_sum, mut y_sum, mut square) = (0.0, 0.0, 0.0, 0.0);
    for (index, height) in patch.iter().enumerate() {
        let (x, y) = (place(index % side), place(index / side));
        mean += height;
        x_sum += height * x;
        y_sum += height * y;
        square += x * x;
    }
    mean /= patch.len() as f64;
    let (along_x, along_y) = (x_sum / square, y_sum / square);
    (patch.iter().enumerate())
        .map(|(i, h)| h - mean - along_x * place(i % side) - along_y * place(i / side))
        .collect()
}

/// Squared magnitudes of the windowed heights' Fourier transform.
fn power(heights: &[f64], window: &[f64], side: usize) -> Vec<f64> {
    let mut grid: Vec<Complex<f64>> = (heights.iter().enumerate())
        .map(|(i, h)| Complex::from(h * window[i % side] * window[i / side]))
        .collect();
    transform(&mut grid, side, side, FftDirection::Forward);
    grid.iter().map(Complex::norm_sqr).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn wave(side: usize, waves: f64, amplitude: f64) -> Vec<f64> {
        let phase = |i: usize| std::f64::consts::TAU * waves * i as f64 / side as f64;
        (0..side * side)
            .map(|i| amplitude * phase(i % side).sin() + 7.0 + 0.1 * (i / side) as f64)
            .collect()
    }

    #[test]
    fn a_wave_has_its_power_at_its_wavelength() {
        let of = |amplitude| Patches {
            side: 33,
            step: 0.5,
            heights: vec![wave(33, 8.0, amplitude)],
        };
        let spectrum = Spectrum::new(&of(2.0), &of(1.0));
        let strongest =
            (0..16).max_by(|a, b| spectrum.original[*a].total_cmp(&spectrum.original[*b]));
        assert_eq!(strongest, Some(7));
        assert_relative_eq!(spectrum.wavelengths[7], 33.0 * 0.5 / 8.0);
        assert_relative_eq!(
            spectrum.original[7] / spectrum.completed[7],
            4.0,
            max_relative = 1e-2
        );
    }

    #[test]
    fn densities_add_up_to_the_variance() {
        use crate::rng::{Rng, Stage};
        let mut rng = Rng::new(5, Stage::Likeness, 0);
        let (side, step) = (33, 0.25);
        let noise: Vec<Vec<f64>> = (0..40)
            .map(|_| (0..side * side).map(|_| 3.0 * rng.normal()).collect())
            .collect();
        let density = radial(&noise, side, step);
        // White noise: variance · step² at every wave.
        let mean = density.iter().sum::<f64>() / density.len() as f64;
        assert_relative_eq!(mean, 9.0 * step * step, max_relative = 0.03);
    }
}
