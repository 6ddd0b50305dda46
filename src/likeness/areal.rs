//! Areal figures of ISO 25178-2, of any part of a surface and however densely its vertices stand.

use serde::Serialize;

use super::distance::log_ratio;
use super::field::{Field, Named, Quantity, Split};
use super::readings::{DIRECTIONS, LAGS};
use super::variogram::{Both, Variogram};
use super::{Figure, Measure, variogram};

/// Where the autocorrelation counts as gone (ISO 25178-2: 0.2).
const GONE: f64 = 0.2;

/// Areal figures of a part, weighted by area. Lengths are in the scan's unit.
///
/// # Reference
/// ISO 25178-2:2021, 4.2 to 4.4.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ArealFigures {
    /// Mean of |height| over the base: Breckon & Fisher's mean integral.
    pub mean_integral: f64,
    /// Arithmetical mean height about the mean.
    pub sa: f64,
    /// Root mean square height about the mean.
    pub sq: f64,
    /// Skewness.
    pub ssk: f64,
    /// Kurtosis.
    pub sku: f64,
    /// Root mean square slope, by differences over one median edge.
    pub sdq: f64,
    /// Autocorrelation length: the shortest distance at which the autocorrelation falls to 0.2; at most 32
    /// median edges.
    pub sal: f64,
    /// Texture aspect ratio: the shortest such distance over the longest, 1 for isotropic.
    pub str: f64,
}

/// The figures of a piece against those of the known part: |ln(a/b)| for what is positive and has a scale,
/// |a − b| for skewness and aspect ratio.
pub(super) fn figures(
    field: &Field,
    quantity: &Quantity,
    split: &Split,
    variograms: &Both,
) -> Vec<Figure> {
    let inner = split.inner.iter().copied();
    let piece = with_variogram(field, quantity, inner, &variograms.piece);
    let reference = with_variogram(field, quantity, split.reference(), &variograms.reference);
    let both = piece.zip(reference);
    let ratio = |get: fn(&ArealFigures) -> f64| both.and_then(|(a, b)| log_ratio(get(&a), get(&b)));
    let difference = |get: fn(&ArealFigures) -> f64| {
        let difference = both.map(|(a, b)| (get(&a) - get(&b)).abs());
        difference.filter(|difference| difference.is_finite())
    };
    let named = |name, value| Named { name, value };
    [
        named("mean integral", ratio(|f| f.mean_integral)),
        named("Sa", ratio(|f| f.sa)),
        named("Sq", ratio(|f| f.sq)),
        named("Ssk", difference(|f| f.ssk)),
        named("Sku", ratio(|f| f.sku)),
        named("Sdq", ratio(|f| f.sdq)),
        named("Sal", ratio(|f| f.sal)),
        named("Str", difference(|f| f.str)),
    ]
    .map(|Named { name, value }| Figure {
        measure: Measure::Areal,
        name: quantity.named(name),
        value,
    })
    .to_vec()
}

/// The figures of a part; `None` if it has no area.
pub(super) fn of_part(
    field: &Field,
    quantity: &Quantity,
    part: impl Iterator<Item = u32> + Clone,
) -> Option<ArealFigures> {
    let variogram = variogram::of_part(field, quantity, part.clone());
    with_variogram(field, quantity, part, &variogram)
}

/// Root mean square about the mean, weighted by area; `None` if the part has no area.
pub(super) fn deviation(
    field: &Field,
    quantity: &Quantity,
    part: impl Iterator<Item = u32> + Clone,
) -> Option<f64> {
    let items = (part.map(|v| (quantity.values[v as usize], field.areas[v as usize])))
        .filter(|(_, area)| *area > 0.0);
    let sum = |of: &dyn Fn(f64) -> f64| -> f64 {
        items.clone().map(|(value, area)| area * of(value)).sum()
    };
    let area = sum(&|_| 1.0);
    let mean = sum(&|h| h) / area;
    (area > 0.0).then(|| (sum(&|h| (h - mean).powi(2)) / area).sqrt())
}

fn with_variogram(
    field: &Field,
    quantity: &Quantity,
    part: impl Iterator<Item = u32> + Clone,
    variogram: &Variogram,
) -> Option<ArealFigures> {
    let items = part
        .map(|v| (quantity.values[v as usize], field.areas[v as usize]))
        .filter(|(_, area)| *area > 0.0);
    let area: f64 = items.clone().map(|(_, area)| area).sum();
    if area <= 0.0 {
        return None;
    }
    let mean_of = |of: &dyn Fn(f64) -> f64| {
        let sum: f64 = items
            .clone()
            .map(|(value, weight)| weight * of(value))
            .sum();
        sum / area
    };
    let mean = mean_of(&|h| h);
    let sq = mean_of(&|h| (h - mean).powi(2)).sqrt();
    let slopes = (0..DIRECTIONS).map(|direction| variogram[direction * LAGS.len()]);
    // The mean over all directions of what a slope rises by is half its square.
    let square_slope = 2.0 * slopes.sum::<f64>() / DIRECTIONS as f64 / field.step.powi(2);
    let lengths = (variogram.chunks_exact(LAGS.len()))
        .map(|along| correlation_length(along, sq) * field.step);
    let sal = lengths.clone().fold(f64::INFINITY, f64::min);
    let longest = lengths.fold(0.0, f64::max);
    Some(ArealFigures {
        mean_integral: mean_of(&f64::abs),
        sa: mean_of(&|h| (h - mean).abs()),
        sq,
        ssk: mean_of(&|h| (h - mean).powi(3)) / sq.powi(3),
        sku: mean_of(&|h| (h - mean).powi(4)) / sq.powi(4),
        sdq: square_slope.sqrt(),
        sal,
        str: sal / longest,
    })
}

/// Where the autocorrelation 1 − γ/(2 Sq²) in one direction falls to 0.2, linearly between lags.
fn correlation_length(along: &[f64], sq: f64) -> f64 {
    let (mut lag_before, mut before) = (0.0, 1.0);
    for (gamma, lag) in along.iter().zip(LAGS) {
        let (lag, now) = (lag as f64, 1.0 - gamma / (2.0 * sq * sq));
        if now <= GONE {
            return lag_before + (lag - lag_before) * (before - GONE) / (before - now);
        }
        // Distances at which nothing is known are passed over.
        if !now.is_nan() {
            (lag_before, before) = (lag, now);
        }
    }
    LAGS[LAGS.len() - 1] as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_length_is_where_the_correlation_crosses() {
        // Sq = 1: γ/2 = 1 − ρ with ρ falling by 0.1 an edge.
        let along: Vec<f64> = LAGS.map(|lag| 0.2 * lag as f64).to_vec();
        assert_relative_eq!(correlation_length(&along, 1.0), 8.0, epsilon = 1e-12);
        let never = [0.5; LAGS.len()];
        assert_relative_eq!(correlation_length(&never, 1.0), 32.0);
        let mut gap = along;
        gap[4..6].fill(f64::NAN);
        // From 0.6 at lag 4 to -0.1 at lag 11.
        assert_relative_eq!(correlation_length(&gap, 1.0), 8.0, epsilon = 1e-12);
    }
}
