//! Power spectra of the luma, averaged over directions.

use std::f64::consts::TAU;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use super::Grid;

/// Sides of the squares, the largest for which both images have room is taken: it tells of the longest waves.
const SIDES: [usize; 4] = [64, 32, 16, 8];
/// Variance that rounding to 8 bits adds at every pixel: differences of less power are none.
const ROUNDING: f64 = 1.0 / (12.0 * 255.0 * 255.0);

/// Root of the mean square of log10 of the ratio of two images' power, over all bands of 1, 2, … waves a
/// square: 0.3 if the power of all waves differs by a factor of 2. Both are averaged over overlapping squares of the
/// same size. `None` if either has no room for one of 8 by 8 pixels.
pub(crate) fn spectrum_distance(sample: &Grid, result: &Grid) -> Option<f64> {
    let (side, corners) = SIDES.iter().find_map(|side| {
        let corners = [sample, result].map(|grid| grid.squares(*side, side / 2));
        let is_there = corners.iter().all(|corners| !corners.is_empty());
        is_there.then_some((*side, corners))
    })?;
    let [first, second] = [(sample, &corners[0]), (result, &corners[1])]
        .map(|(grid, corners)| radial(grid, corners, side));
    let squares = (first.iter().zip(&second))
        .map(|(a, b)| (a.max(ROUNDING) / b.max(ROUNDING)).log10().powi(2));
    Some((squares.sum::<f64>() / first.len() as f64).sqrt())
}

/// Mean power in each band up to half as many waves as pixels, so scaled that it is the variance of white noise.
fn radial(grid: &Grid, corners: &[usize], side: usize) -> Vec<f64> {
    let luma = grid.luma();
    let window = window(side);
    let energy: f64 = window.iter().map(|weight| weight * weight).sum();
    let transform = FftPlanner::new().plan_fft_forward(side);
    let (mut sums, mut counts) = (vec![0.0; side / 2], vec![0.0f64; side / 2]);
    for corner in corners {
        let square: Vec<f64> = grid
            .square(*corner, side)
            .map(|pixel| luma[pixel])
            .collect();
        for (index, power) in power(&square, &window, &*transform).iter().enumerate() {
            if let Some(band) = band(index, side) {
                sums[band] += power / energy;
                counts[band] += 1.0;
            }
        }
    }
    (sums.iter().zip(counts))
        .map(|(sum, count)| sum / count)
        .collect()
}

/// Hann window.
fn window(side: usize) -> Vec<f64> {
    let along = |i: usize| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / side as f64).cos();
    (0..side * side)
        .map(|i| along(i / side) * along(i % side))
        .collect()
}

/// Squared magnitudes of the Fourier transform of a square without its mean, which would leak into long waves;
/// its columns as rows.
fn power(square: &[f64], window: &[f64], transform: &dyn Fft<f64>) -> Vec<f64> {
    let side = transform.len();
    let weighted = square
        .iter()
        .zip(window)
        .map(|(value, weight)| value * weight);
    let mean = weighted.sum::<f64>() / window.iter().sum::<f64>();
    let mut rows: Vec<Complex<f64>> = (square.iter().zip(window))
        .map(|(value, weight)| Complex::from((value - mean) * weight))
        .collect();
    transform.process(&mut rows);
    let mut columns: Vec<Complex<f64>> = (0..side * side)
        .map(|i| rows[i % side * side + i / side])
        .collect();
    transform.process(&mut columns);
    columns.iter().map(Complex::norm_sqr).collect()
}

/// Waves a side, rounded, less one; `None` for none and for those that only diagonal waves can have.
fn band(index: usize, side: usize) -> Option<usize> {
    let waves = |i: usize| i.min(side - i) as f64;
    let waves = waves(index % side).hypot(waves(index / side)).round();
    (0..side / 2).find(|band| (waves - (band + 1) as f64).abs() < 0.5)
}
