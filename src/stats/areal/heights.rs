//! Height parameters: moments and extremes.

use super::sum::Sum;

/// Height parameters of weighted heights, about their mean.
///
/// # Reference
/// ISO 25178-2:2021, 4.2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightParameters {
    /// The mean that the others are taken about.
    pub mean: f64,
    /// Arithmetical mean height.
    pub sa: f64,
    /// Root mean square height.
    pub sq: f64,
    /// Skewness; `None` if all heights are equal.
    pub ssk: Option<f64>,
    /// Kurtosis; `None` if all heights are equal.
    pub sku: Option<f64>,
    /// Maximum peak height.
    pub sp: f64,
    /// Maximum pit depth, positive.
    pub sv: f64,
}

impl HeightParameters {
    /// Of heights with their weights (areas), any number of them; heights that are not finite or weigh
    /// nothing are left out. `None` if nothing is left.
    #[must_use]
    pub fn of(samples: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Self> {
        let samples = samples.filter(|(height, weight)| height.is_finite() && *weight > 0.0);
        let sum_of = |of: &dyn Fn(f64) -> f64| {
            samples
                .clone()
                .map(|(height, weight)| weight * of(height))
                .collect::<Sum>()
                .value()
        };
        let area = sum_of(&|_| 1.0);
        let (low, high) = (samples.clone())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (h, _)| {
                (low.min(h), high.max(h))
            });
        if !(area > 0.0 && area.is_finite()) {
            return None;
        }
        // Equal heights must not get a roughness from the rounding of their mean.
        let mean = if low < high {
            let mean = sum_of(&|h| h) / area;
            mean + sum_of(&|h| h - mean) / area
        } else {
            low
        };
        let sq = (sum_of(&|h| (h - mean).powi(2)) / area).sqrt();
        let moment = |order: i32| {
            let moment = sum_of(&|h| ((h - mean) / sq).powi(order)) / area;
            (sq > 0.0).then_some(moment)
        };
        Some(Self {
            mean,
            sa: sum_of(&|h| (h - mean).abs()) / area,
            sq,
            ssk: moment(3),
            sku: moment(4),
            sp: high - mean,
            sv: mean - low,
        })
    }

    /// Maximum height Sp + Sv.
    #[must_use]
    pub fn sz(&self) -> f64 {
        self.sp + self.sv
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::{FRAC_1_SQRT_2, PI};

    #[test]
    fn a_sine_wave_has_the_values_of_the_formulas() {
        let wave = (0..1000).map(|i| (5.0 + (PI * (f64::from(i) + 0.5) / 500.0).sin(), 2.0));
        let heights = HeightParameters::of(wave).unwrap();
        assert_relative_eq!(heights.mean, 5.0, epsilon = 1e-12);
        assert_relative_eq!(heights.sq, FRAC_1_SQRT_2, epsilon = 1e-12);
        assert_relative_eq!(heights.sa, 2.0 / PI, epsilon = 1e-5);
        assert_relative_eq!(heights.ssk.unwrap(), 0.0, epsilon = 1e-12);
        assert_relative_eq!(heights.sku.unwrap(), 1.5, epsilon = 1e-12);
        assert_relative_eq!(heights.sz(), 2.0, epsilon = 1e-4);
    }

    #[test]
    fn a_weight_of_three_is_the_height_three_times() {
        let once = [(1.0, 3.0), (2.0, 1.0), (7.0, 2.0), (f64::NAN, 1.0)];
        let often = [1.0, 1.0, 1.0, 2.0, 7.0, 7.0].map(|h| (h, 1.0));
        let [a, b] = [once.to_vec(), often.to_vec()]
            .map(|samples| HeightParameters::of(samples.into_iter()).unwrap());
        assert_relative_eq!(a.sq, b.sq, epsilon = 1e-14);
        assert_relative_eq!(a.ssk.unwrap(), b.ssk.unwrap(), epsilon = 1e-14);
        assert_relative_eq!(a.sku.unwrap(), b.sku.unwrap(), epsilon = 1e-14);
        assert_relative_eq!(a.sv, b.sv, epsilon = 1e-14);
    }

    #[test]
    fn equal_heights_have_no_skewness_and_no_heights_no_parameters() {
        let flat = HeightParameters::of(std::iter::repeat_n((0.1, 0.3), 7)).unwrap();
        assert!(flat.sq.abs() < 1e-300 && flat.sa.abs() < 1e-300);
        assert_eq!((flat.ssk, flat.sku), (None, None));
        assert_eq!(HeightParameters::of([(f64::NAN, 1.0)].into_iter()), None);
        assert_eq!(HeightParameters::of([(1.0, 0.0)].into_iter()), None);
    }
}
