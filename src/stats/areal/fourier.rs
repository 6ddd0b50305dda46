//! Fourier transforms of grids.

use rustfft::num_complex::Complex;
use rustfft::{FftDirection, FftPlanner};

/// Transforms a grid (row-major, `rows` times `columns`) in both directions, without any factor.
pub(in crate::stats) fn transform(
    grid: &mut [Complex<f64>],
    columns: usize,
    rows: usize,
    direction: FftDirection,
) {
    let mut planner = FftPlanner::new();
    planner.plan_fft(columns, direction).process(grid);
    let along_rows = planner.plan_fft(rows, direction);
    let mut turned = vec![Complex::default(); grid.len()];
    transpose(grid, &mut turned, columns, rows);
    along_rows.process(&mut turned);
    transpose(&turned, grid, rows, columns);
}

/// Writes the columns of one grid as rows of the other, in squares that fit into the cache.
fn transpose(from: &[Complex<f64>], to: &mut [Complex<f64>], columns: usize, rows: usize) {
    const SQUARE: usize = 32;
    for top in (0..rows).step_by(SQUARE) {
        for left in (0..columns).step_by(SQUARE) {
            for row in top..rows.min(top + SQUARE) {
                for column in left..columns.min(left + SQUARE) {
                    to[column * rows + row] = from[row * columns + column];
                }
            }
        }
    }
}

/// The smallest length of at least `least` that transforms fast: no prime factor above 5.
pub(in crate::stats) fn fast_length(least: usize) -> usize {
    let is_fast = |mut n: usize| {
        for factor in [2, 3, 5] {
            while n.is_multiple_of(factor) {
                n /= factor;
            }
        }
        n == 1
    };
    (least.max(1)..)
        .find(|n| is_fast(*n))
        .unwrap_or(least.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn transforms_match_the_sum_of_the_definition() {
        let (columns, rows) = (6, 35);
        let value = |c: usize, r: usize| ((c * 7 + r * r * 3) % 11) as f64;
        let mut grid: Vec<_> = (0..columns * rows)
            .map(|k| Complex::from(value(k % columns, k / columns)))
            .collect();
        let before = grid.clone();
        transform(&mut grid, columns, rows, FftDirection::Forward);
        for (u, v) in [(0, 0), (1, 0), (0, 3), (5, 34), (2, 17)] {
            let mut sum = Complex::default();
            for (k, value) in before.iter().enumerate() {
                let turns = (u * (k % columns)) as f64 / columns as f64
                    + (v * (k / columns)) as f64 / rows as f64;
                sum += value * Complex::cis(-std::f64::consts::TAU * turns);
            }
            assert_relative_eq!(grid[v * columns + u].re, sum.re, epsilon = 1e-9);
            assert_relative_eq!(grid[v * columns + u].im, sum.im, epsilon = 1e-9);
        }
        transform(&mut grid, columns, rows, FftDirection::Inverse);
        for (there, back) in before.iter().zip(&grid) {
            assert_relative_eq!(210.0 * there.re, back.re, epsilon = 1e-9);
        }
    }

    #[test]
    fn fast_lengths_have_small_factors_only() {
        assert_eq!(
            [0, 1, 7, 511, 513, 601].map(fast_length),
            [1, 1, 8, 512, 540, 625]
        );
    }
}
