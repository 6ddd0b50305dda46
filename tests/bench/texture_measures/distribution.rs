//! Distributions of single pixels' values.

use relievo::stats::compare_colors;

use super::Grid;

/// Pearson correlation of the color histograms (32 bins a channel), as for the completed part of a scan: the
/// least of red, green and blue. 1 for equal histograms.
pub(crate) fn least_histogram_correlation(sample: &Grid, result: &Grid) -> Option<f64> {
    let colors = |grid: &Grid| -> Vec<[f64; 3]> {
        let colors = grid.pixels().map(|pixel| grid.colors[pixel]);
        colors.map(|color| color.map(f64::from)).collect()
    };
    let (first, second) = (colors(sample), colors(result));
    if first.is_empty() || second.is_empty() {
        return None;
    }
    let of_sample: Vec<bool> = (0..first.len() + second.len())
        .map(|i| i < first.len())
        .collect();
    let of_result: Vec<bool> = of_sample.iter().map(|is| !is).collect();
    compare_colors(&[first, second].concat(), &of_sample, &of_result)
        .iter()
        .map(|channel| channel.correlation)
        .reduce(f64::min)
}

/// Distance of the distributions of the luma's gradient magnitudes (differences to the right and the lower
/// neighbor), as a share of their mean in the sample: 0.2 for a result whose gradients are all a fifth lower.
/// Tells blur and noise. `None` of a sample without any gradient.
pub(crate) fn gradient_distance(sample: &Grid, result: &Grid) -> Option<f64> {
    let [first, second] = [sample, result].map(gradients);
    let mean = first.iter().sum::<f64>() / first.len() as f64;
    (mean > 0.0 && !second.is_empty()).then(|| wasserstein(&first, &second) / mean)
}

/// Gradient magnitudes, ascending.
fn gradients(grid: &Grid) -> Vec<f64> {
    let luma = grid.luma();
    let mut gradients: Vec<f64> = (grid.pixels())
        .filter_map(|pixel| {
            let is_last =
                (pixel + 1).is_multiple_of(grid.width) || pixel + grid.width >= luma.len();
            let counts = !is_last && grid.counts(pixel + 1) && grid.counts(pixel + grid.width);
            counts.then(|| {
                let [right, lower] = [1, grid.width].map(|step| luma[pixel + step] - luma[pixel]);
                right.hypot(lower)
            })
        })
        .collect();
    gradients.sort_by(f64::total_cmp);
    gradients
}

/// 1-Wasserstein distance of two lists of values, both ascending and not empty: the area between their quantile
/// functions, which are steps; exact for any two counts, and the mean of the differences for equal ones.
pub(crate) fn wasserstein(first: &[f64], second: &[f64]) -> f64 {
    // In units of 1 / (n m), in which all steps end at whole numbers.
    let (n, m) = (first.len(), second.len());
    let (mut i, mut j, mut at, mut area) = (0, 0, 0, 0.0);
    while i < n && j < m {
        let ends = [(i + 1) * m, (j + 1) * n];
        let next = ends[0].min(ends[1]);
        area += (next - at) as f64 * (first[i] - second[j]).abs();
        at = next;
        i += usize::from(ends[0] == next);
        j += usize::from(ends[1] == next);
    }
    area / (n as f64 * m as f64)
}
