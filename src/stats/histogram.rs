//! Histograms of height and colour, and their correlation.

use serde::Serialize;

/// Bins of a histogram: 32 of width 8 in 8-bit values, wide enough for parts of a few hundred
/// vertices.
const BINS: usize = 32;

/// Shares of values in equal bins of [0, 1].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Histogram {
    /// Share of each bin, from dark to bright; they add up to 1.
    pub shares: Vec<f64>,
}

/// Heights of the original and the completed part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeightComparison {
    /// Lower end of the first bin, in the scan's unit.
    pub lowest: f64,
    /// Upper end of the last bin, in the scan's unit.
    pub highest: f64,
    /// Of the original part, by area.
    pub original: Histogram,
    /// Of the completed part, by area.
    pub completed: Histogram,
    /// Pearson correlation of the two over the bins; 1 for equal histograms.
    pub correlation: f64,
}

/// One colour channel of the original and the completed part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColorComparison {
    /// Name of the channel.
    pub channel: &'static str,
    /// Of the original part.
    pub original: Histogram,
    /// Of the completed part.
    pub completed: Histogram,
    /// Pearson correlation of the two over the bins; 1 for equal histograms.
    pub correlation: f64,
}

impl Histogram {
    /// Of values in [0, 1] and their weights.
    fn of(values: impl Iterator<Item = (f64, f64)>) -> Self {
        let mut counts = [0.0; BINS];
        let mut total = 0.0;
        for (value, weight) in values {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturating"
            )]
            let bin = (value * BINS as f64) as usize;
            counts[bin.min(BINS - 1)] += weight;
            total += weight;
        }
        let total = if total > 0.0 { total } else { 1.0 };
        Self {
            shares: counts.iter().map(|c| c / total).collect(),
        }
    }

    /// Pearson correlation; 1 for two that are flat and equal, 0 if only one is flat.
    fn correlation(&self, other: &Self) -> f64 {
        if self == other {
            return 1.0;
        }
        let mean = 1.0 / BINS as f64;
        let pairs = self.shares.iter().zip(&other.shares);
        let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
        for (a, b) in pairs {
            let (a, b) = (a - mean, b - mean);
            ab += a * b;
            aa += a * a;
            bb += b * b;
        }
        if aa > 0.0 && bb > 0.0 {
            ab / (aa * bb).sqrt()
        } else {
            0.0
        }
    }
}

/// Histograms of both parts, by channel. `colors` (#V by 3, in [0, 1]), and by vertex whether it is
/// of the original and of the completed part.
#[must_use]
pub fn compare_colors(
    colors: &[[f64; 3]],
    original: &[bool],
    completed: &[bool],
) -> [ColorComparison; 3] {
    let part = |channel: usize, part: &[bool]| {
        let chosen = colors.iter().zip(part).filter(|(_, is)| **is);
        Histogram::of(chosen.map(|(color, _)| (color[channel], 1.0)))
    };
    [(0, "red"), (1, "green"), (2, "blue")].map(|(index, channel)| {
        let (original, completed) = (part(index, original), part(index, completed));
        ColorComparison {
            channel,
            correlation: original.correlation(&completed),
            original,
            completed,
        }
    })
}

/// Histograms of heights with their areas, in common bins.
#[must_use]
pub fn compare_heights(original: &[(f64, f64)], completed: &[(f64, f64)]) -> HeightComparison {
    let all = || original.iter().chain(completed).map(|(height, _)| *height);
    let (lowest, highest) = (
        all().fold(f64::INFINITY, f64::min),
        all().fold(f64::NEG_INFINITY, f64::max),
    );
    let range = if highest > lowest {
        highest - lowest
    } else {
        1.0
    };
    let part = |part: &[(f64, f64)]| {
        Histogram::of(part.iter().map(|(h, area)| ((h - lowest) / range, *area)))
    };
    let (original, completed) = (part(original), part(completed));
    HeightComparison {
        lowest,
        highest,
        correlation: original.correlation(&completed),
        original,
        completed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn equal_parts_correlate_fully_and_disjoint_ones_do_not() {
        let ramp = |offset: f64| (0..500).map(move |i| [offset + f64::from(i % 50) / 101.0; 3]);
        let both = |second: f64| -> Vec<_> { ramp(0.0).chain(ramp(second)).collect() };
        let completed: Vec<bool> = (0..1000).map(|i| i >= 500).collect();
        let original: Vec<bool> = completed.iter().map(|completed| !completed).collect();
        let same = compare_colors(&both(0.0), &original, &completed);
        assert_relative_eq!(same[1].correlation, 1.0);
        assert_relative_eq!(same[1].original.shares.iter().sum::<f64>(), 1.0);
        let apart = compare_colors(&both(0.505), &original, &completed);
        assert!(apart[2].correlation < -0.9);
    }

    #[test]
    fn the_ends_of_the_range_have_bins() {
        let histogram = Histogram::of([0.0, 1.0, 1.0, 2.0].into_iter().map(|value| (value, 1.0)));
        assert_relative_eq!(histogram.shares[0], 0.25);
        assert_relative_eq!(histogram.shares[BINS - 1], 0.75);
    }

    #[test]
    fn heights_are_counted_by_area_in_common_bins() {
        let low = [(0.0, 3.0), (1.0, 1.0)];
        let same = compare_heights(&low, &[(0.0, 0.3), (1.0, 0.1)]);
        assert_relative_eq!(same.original.shares[0], 0.75);
        assert_relative_eq!(same.correlation, 1.0);
        let shifted = compare_heights(&low, &[(3.0, 1.0)]);
        assert_relative_eq!(shifted.highest, 3.0);
        assert!(shifted.correlation < 0.0);
        let flat = compare_heights(&[(2.0, 1.0)], &[(2.0, 1.0)]);
        assert_relative_eq!(flat.correlation, 1.0);
    }
}
