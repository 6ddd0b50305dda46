//! Colors that came out beside those that they were copied from.

use crate::stats::{self, ColorComparison};

/// Histograms of red, green and blue of a source and of what was made of it.
pub(super) fn beside_source(
    mut source: Vec<[f64; 3]>,
    result: &[[f64; 3]],
) -> [ColorComparison; 3] {
    let count = source.len();
    source.extend(result);
    let is_source: Vec<bool> = (0..source.len()).map(|i| i < count).collect();
    let is_result: Vec<bool> = is_source.iter().map(|is| !is).collect();
    stats::compare_colors(&source, &is_source, &is_result)
}

/// How well they agree, by channel.
pub(super) fn correlations(colors: &[ColorComparison; 3]) -> [f64; 3] {
    colors.each_ref().map(|color| color.correlation)
}

/// That of the channel that agrees least, in a sentence; `source` says whose they should be.
pub(super) fn in_words(correlations: [f64; 3], source: &str) -> String {
    let least = correlations.into_iter().fold(f64::INFINITY, f64::min);
    format!("color histograms agree with the {source}'s to {least:.3} (correlation)")
}
