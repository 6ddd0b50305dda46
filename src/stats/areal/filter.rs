//! S-filter and L-filter: the areal Gaussian filter.

use rayon::prelude::*;
use std::f64::consts::{LN_2, PI};

use crate::scan::HeightMap;

/// Beyond so many cut-offs the weights add up to less than 1e-9 and are left out.
const CUT: f64 = 1.25;

/// The waves that are longer than a cut-off: the map smoothed by the areal Gaussian filter, of which a sine wave of the
/// cut-off's length keeps one half.
///
/// The weight of a height at the distance r is exp(−π r² / (α λ)²) with α = √(ln 2 / π), sampled at the
/// heights' places. Near the rims and beside missing heights the weights of what is known are normalised to
/// add up to 1, so that a constant height is kept everywhere; slopes are not, within half a cut-off of a rim. What is
/// missing stays missing.
///
/// # Reference
/// ISO 16610-61:2015, 4.
#[must_use]
pub fn long_waves(map: &HeightMap, cutoff: f64) -> HeightMap {
    let [across, down] = [map.dx, map.dy].map(|step| weights(cutoff, step));
    // About the mean of what is known, so that a large offset costs no digits.
    let known = map
        .heights
        .iter()
        .copied()
        .filter(|height| !height.is_nan());
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), height| {
        (sum + height, count + 1.0)
    });
    let mean = if count > 0.0 { sum / count } else { 0.0 };
    let or_zero = |height: &f64| if height.is_nan() { 0.0 } else { height - mean };
    let heights: Vec<f64> = map.heights.iter().map(or_zero).collect();
    let is_known = map.heights.iter().map(|height| f64::from(!height.is_nan()));
    let convolved = |grid: &[f64]| {
        let turned = convolved_and_turned(grid, map.columns, &across);
        convolved_and_turned(&turned, map.rows, &down)
    };
    let (sums, totals) = (
        convolved(&heights),
        convolved(&is_known.collect::<Vec<_>>()),
    );
    let smooth =
        (map.heights.iter().zip(sums.iter().zip(&totals))).map(|(height, (sum, total))| {
            if height.is_nan() {
                f64::NAN
            } else {
                mean + sum / total
            }
        });
    HeightMap {
        heights: smooth.collect(),
        ..*map
    }
}

/// Weights at 0, 1, 2, … steps from the middle.
fn weights(cutoff: f64, step: f64) -> Vec<f64> {
    let alpha = (LN_2 / PI).sqrt();
    let weight = |k: usize| (-PI * (k as f64 * step / (alpha * cutoff)).powi(2)).exp();
    (0..)
        .take_while(|k| *k as f64 * step <= CUT * cutoff)
        .map(weight)
        .collect()
}

/// Convolves every row with symmetric weights and gives the result with rows and columns exchanged.
fn convolved_and_turned(grid: &[f64], columns: usize, weights: &[f64]) -> Vec<f64> {
    let rows = grid.len() / columns;
    let convolved: Vec<f64> = grid
        .par_chunks_exact(columns)
        .flat_map_iter(|row| convolved_row(row, weights))
        .collect();
    let places = (0..columns).flat_map(|column| (0..rows).map(move |row| row * columns + column));
    places.map(|place| convolved[place]).collect()
}

/// One weight after the other over the whole row, which runs as fast as the memory.
fn convolved_row(row: &[f64], weights: &[f64]) -> Vec<f64> {
    let mut out: Vec<f64> = row.iter().map(|value| weights[0] * value).collect();
    for (distance, weight) in weights
        .iter()
        .enumerate()
        .skip(1)
        .take_while(|(k, _)| *k < row.len())
    {
        for (out, value) in out.iter_mut().zip(&row[distance..]) {
            *out += weight * value;
        }
        for (out, value) in out[distance..].iter_mut().zip(row) {
            *out += weight * value;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn wave(length: f64, is_across: bool) -> HeightMap {
        HeightMap::from_fn([201, 161], [0.5, 0.8], |column, row| {
            let place = if is_across {
                0.5 * column as f64
            } else {
                0.8 * row as f64
            };
            (2.0 * PI * place / length).sin()
        })
    }

    /// Amplitude of what is left of a wave, away from the rims.
    fn transmission(length: f64, cutoff: f64, is_across: bool) -> f64 {
        let before = wave(length, is_across);
        let after = long_waves(&before, cutoff);
        let (mut product, mut square) = (0.0, 0.0);
        for row in 50..110 {
            for column in 60..140 {
                product += before.at(column, row) * after.at(column, row);
                square += before.at(column, row).powi(2);
            }
        }
        product / square
    }

    #[test]
    fn waves_pass_as_the_standard_says() {
        for is_across in [true, false] {
            for cutoff in [8.0, 16.0] {
                for ratio in [0.5, 1.0, 2.0, 3.0] {
                    // exp(−π (α λc / λ)²): 50 % at the cut-off.
                    let expected = 0.5_f64.powf(1.0 / (ratio * ratio));
                    let found = transmission(ratio * cutoff, cutoff, is_across);
                    assert_relative_eq!(found, expected, epsilon = 2e-3);
                }
            }
        }
        assert_relative_eq!(transmission(10.0, 10.0, true), 0.5, epsilon = 1e-6);
    }

    #[test]
    fn constants_are_kept_at_rims_and_holes() {
        let map = HeightMap::from_fn([40, 30], [1.0, 1.0], |column, row| {
            if (10..15).contains(&column) && row < 20 {
                f64::NAN
            } else {
                7.25
            }
        });
        let smooth = long_waves(&map, 12.0);
        assert_eq!(smooth.missing(), map.missing());
        for height in smooth.heights.iter().filter(|height| !height.is_nan()) {
            assert_relative_eq!(*height, 7.25, epsilon = 1e-13);
        }
    }

    #[test]
    fn a_cutoff_far_below_the_steps_does_nothing() {
        let map = wave(9.0, true);
        let same = long_waves(&map, 0.1);
        for (before, after) in map.heights.iter().zip(&same.heights) {
            assert_relative_eq!(*before, *after, epsilon = 1e-15);
        }
    }
}
