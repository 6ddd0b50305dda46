//! The direction in which a surface varies most.

use rustfft::FftDirection;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

use super::Autocorrelation;
use super::fourier::{fast_length, transform};

/// Directions that the spectrum is summed in, over half a turn.
const DIRECTIONS: usize = 360;

impl Autocorrelation {
    /// Std: the direction of the largest angular power spectrum ∫ r P(r cos s, r sin s) dr, in degrees from 0 to
    /// 180, counterclockwise from x to y. It points across the grooves of a lay. `None` without any power.
    ///
    /// P is the power spectrum, the Fourier transform of the autocorrelation. That is tapered to zero (by a raised
    /// cosine of the distance) at half the shorter side's reach, where unbiased values begin to be uncertain, so
    /// that all directions are resolved alike. The sum is taken for every half degree and its maximum refined by a
    /// parabola. Of the 2021 edition's two angular densities this is that of power; that of amplitude has the same
    /// maximum where there is a single lay.
    ///
    /// # Reference
    /// ISO 25178-2:2021, 4.3.4; 2012, 3.2.9 (f<sub>APS</sub>).
    #[must_use]
    pub fn direction(&self) -> Option<f64> {
        let sums = self.angular_power_spectrum()?;
        let peak = (0..sums.len()).max_by(|a, b| sums[*a].total_cmp(&sums[*b]).then(b.cmp(a)))?;
        let neighbor = |by: usize| sums[(peak + by) % sums.len()];
        let (before, at, after) = (neighbor(sums.len() - 1), sums[peak], neighbor(1));
        let curvature = before - 2.0 * at + after;
        let shift = if curvature < 0.0 {
            0.5 * (before - after) / curvature
        } else {
            0.0
        };
        let degrees = (peak as f64 + shift) * 180.0 / sums.len() as f64;
        Some(degrees.rem_euclid(180.0))
    }

    /// The power spectrum integrated along each direction, from the lowest frequency that the taper leaves apart
    /// from zero up to the highest that both steps resolve.
    fn angular_power_spectrum(&self) -> Option<Vec<f64>> {
        let [dx, dy] = self.steps();
        let [mx, my] = self.reach();
        let radius = 0.5 * (mx as f64 * dx).min(my as f64 * dy);
        let highest = 0.5 / dx.max(dy);
        let lowest = 1.0 / radius;
        let spectrum = Spectrum::of(self, radius);
        // Half the distance of the spectrum's own samples.
        let step = 0.5
            * spectrum
                .frequency_steps
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min);
        if !(lowest < highest && step > 0.0) {
            return None;
        }
        let sum_along = |k: usize| {
            let (sin, cos) = (PI * k as f64 / DIRECTIONS as f64).sin_cos();
            let (mut sum, mut r) = (0.0, lowest);
            while r <= highest {
                // The taper's transform has small negative lobes.
                sum += r * spectrum.at(r * cos, r * sin).max(0.0);
                r += step;
            }
            sum
        };
        let sums: Vec<f64> = (0..DIRECTIONS).map(sum_along).collect();
        sums.iter().any(|sum| *sum > 0.0).then_some(sums)
    }
}

/// A power spectrum on a lattice of frequencies.
#[derive(Debug)]
struct Spectrum {
    /// Row-major, in the order of the transform: frequency 0 first.
    power: Vec<f64>,
    size: [usize; 2],
    frequency_steps: [f64; 2],
}

impl Spectrum {
    /// Of the autocorrelation tapered to zero at a radius.
    fn of(acf: &Autocorrelation, radius: f64) -> Self {
        let steps = acf.steps();
        #[expect(clippy::cast_possible_truncation, reason = "at most half the reach")]
        let kept = steps.map(|step| (radius / step) as isize);
        // Twice as long as what is transformed: the spectrum is smooth between its samples.
        let size = kept.map(|lags| fast_length(2 * (2 * lags.unsigned_abs() + 1)));
        let mut grid = vec![Complex::default(); size[0] * size[1]];
        for j in -kept[1]..=kept[1] {
            for i in -kept[0]..=kept[0] {
                let distance = (i as f64 * steps[0]).hypot(j as f64 * steps[1]) / radius;
                let value = acf.at(i, j);
                if distance < 1.0 && value.is_finite() {
                    let wrapped = |lag: isize, size: usize| {
                        if lag < 0 {
                            size - lag.unsigned_abs()
                        } else {
                            lag.unsigned_abs()
                        }
                    };
                    let place = wrapped(j, size[1]) * size[0] + wrapped(i, size[0]);
                    grid[place] = Complex::from(value * 0.5 * (1.0 + (PI * distance).cos()));
                }
            }
        }
        transform(&mut grid, size[0], size[1], FftDirection::Forward);
        Self {
            power: grid.into_iter().map(|value| value.re).collect(),
            size,
            frequency_steps: [0, 1].map(|k| 1.0 / (size[k] as f64 * steps[k])),
        }
    }

    /// Power at a frequency, by cubic convolution between samples: linearly, every maximum would be on a sample.
    fn at(&self, fx: f64, fy: f64) -> f64 {
        let taps = |frequency: f64, k: usize| {
            let position = (frequency / self.frequency_steps[k]).rem_euclid(self.size[k] as f64);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "from 0 to the size"
            )]
            let before = position as usize;
            let weights = cubic_weights(position - before as f64);
            // One sample before and two after.
            let first = before + self.size[k] - 1;
            [0, 1, 2, 3].map(|tap| ((first + tap) % self.size[k], weights[tap]))
        };
        let (columns, rows) = (taps(fx, 0), taps(fy, 1));
        let along = |row: usize| -> f64 {
            let power = &self.power[row * self.size[0]..][..self.size[0]];
            columns.iter().map(|(column, w)| w * power[*column]).sum()
        };
        rows.iter().map(|(row, w)| w * along(*row)).sum()
    }
}

/// Weights of four samples at a place between the middle two (Catmull-Rom).
fn cubic_weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        0.5 * (-t3 + 2.0 * t2 - t),
        0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
        0.5 * (-3.0 * t3 + 4.0 * t2 + t),
        0.5 * (t3 - t2),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Autocorrelation of a wave that runs in a direction.
    fn wave(reach: [usize; 2], steps: [f64; 2], degrees: f64, length: f64) -> Autocorrelation {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let [mx, my] = reach.map(|lags| lags as f64);
        let columns = 2 * reach[0] + 1;
        let values = (0..columns * (2 * reach[1] + 1)).map(|k| {
            let x = ((k % columns) as f64 - mx) * steps[0];
            let y = ((k / columns) as f64 - my) * steps[1];
            (2.0 * PI * (x * cos + y * sin) / length).cos()
        });
        Autocorrelation::new(reach, steps, values.collect()).unwrap()
    }

    #[test]
    fn a_wave_has_the_direction_in_which_it_runs() {
        for degrees in [0.0, 17.3, 45.0, 90.0, 133.0, 179.0] {
            let found = wave([100, 100], [0.2, 0.2], degrees, 2.0)
                .direction()
                .unwrap();
            let apart = (found - degrees + 90.0).rem_euclid(180.0) - 90.0;
            assert!(apart.abs() < 0.3, "{degrees}: {found}");
        }
    }

    #[test]
    fn steps_and_sides_of_different_lengths_do_not_turn_it() {
        for degrees in [20.0, 70.0, 110.0] {
            let found = wave([150, 40], [0.1, 0.5], degrees, 3.0)
                .direction()
                .unwrap();
            assert!((found - degrees).abs() < 0.5, "{degrees}: {found}");
        }
    }

    #[test]
    fn a_map_too_small_for_any_wave_has_no_direction() {
        assert_eq!(wave([1, 1], [1.0, 1.0], 30.0, 2.0).direction(), None);
    }
}
