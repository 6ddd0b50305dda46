//! Robust loss and robust scale.

/// Reach of Tukey's biweight in standard deviations (Holland & Welsch 1977: 95 % efficiency).
pub(super) const TUKEY_REACH: f64 = 4.685;

/// Normal standard deviations in a median absolute deviation: 1 / Φ⁻¹(3/4).
const MAD_TO_SIGMA: f64 = 1.482_602_218_505_602;

/// Share of the vertices that must lie on the surface for a fit to find it.
pub(super) const LEAST_SHARE: f64 = 0.35;

/// Standard deviations in half the shortest interval with [`LEAST_SHARE`] of a normal
/// distribution: 1 / Φ⁻¹((1 + 0.35)/2).
const SHORTEST_TO_SIGMA: f64 = 2.203_745_7;

/// The same if half of the weight is normal and the rest elsewhere: 1 / Φ⁻¹((1 + 0.35/0.5)/2).
const MINORITY_TO_SIGMA: f64 = 0.964_853_3;

/// The narrow estimate is used where it is this many times below the MAD. It is 1 for normal and
/// uniform distributions, 1.7 for a sine (arcsine distribution), 2.3 for a normal core of 60 % in
/// wide surroundings; one-sided dimples, joints and stray majorities are beyond 3.
const MINORITY_RATIO: f64 = 3.0;

/// Location and scale of heights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    /// Where most heights are.
    pub(super) center: f64,
    /// Robust standard deviation about it.
    pub(super) sigma: f64,
    /// That of all heights, if a majority is on the surface: from the MAD.
    pub(super) wide: f64,
    /// Middle and half width of the shortest interval with [`LEAST_SHARE`].
    pub(super) core: (f64, f64),
    /// Whether `sigma` is that of a minority.
    pub(super) minority: bool,
}

/// Location and scale of weighted heights: median and MAD, or, if the heights pile up in a band
/// much narrower than that, center and half width of the narrowest band with [`LEAST_SHARE`] of
/// the weight.
pub(super) fn spread(heights: &[f64], weights: &[f64]) -> Spread {
    let mut sorted: Vec<(f64, f64)> = heights
        .iter()
        .copied()
        .zip(weights.iter().copied())
        .collect();
    sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = sorted.iter().map(|s| s.1).sum();
    let mut below = 0.0;
    let middle = sorted
        .iter()
        .position(|s| {
            below += s.1;
            below >= 0.5 * total
        })
        .unwrap_or(0);
    let Some(&(median, _)) = sorted.get(middle) else {
        return Spread {
            center: 0.0,
            sigma: 0.0,
            wide: 0.0,
            core: (0.0, 0.0),
            minority: false,
        };
    };
    let wide = MAD_TO_SIGMA * median_deviation(&sorted, middle, 0.5 * total);
    let (low, high) = shortest_interval(&sorted, LEAST_SHARE * total);
    let core = (0.5 * (low + high), 0.5 * (high - low));
    if SHORTEST_TO_SIGMA * core.1 * MINORITY_RATIO < wide {
        Spread {
            center: core.0,
            sigma: MINORITY_TO_SIGMA * core.1,
            wide,
            core,
            minority: true,
        }
    } else {
        Spread {
            center: median,
            sigma: wide,
            wide,
            core,
            minority: false,
        }
    }
}

/// Least d such that the heights within d of the median have `weight`.
fn median_deviation(sorted: &[(f64, f64)], middle: usize, weight: f64) -> f64 {
    let median = sorted[middle].0;
    let (mut low, mut high) = (middle, middle);
    let mut inside = sorted[middle].1;
    let mut deviation = 0.0;
    while inside < weight {
        let down = low.checked_sub(1).map(|i| median - sorted[i].0);
        let up = sorted.get(high + 1).map(|s| s.0 - median);
        match (down, up) {
            (Some(d), up) if up.is_none_or(|u| d <= u) => {
                low -= 1;
                inside += sorted[low].1;
                deviation = d;
            }
            (_, Some(u)) => {
                high += 1;
                inside += sorted[high].1;
                deviation = u;
            }
            _ => break,
        }
    }
    deviation
}

/// Shortest interval of heights that holds `weight`.
fn shortest_interval(sorted: &[(f64, f64)], weight: f64) -> (f64, f64) {
    let mut best = (sorted[0].0, sorted[sorted.len() - 1].0);
    let (mut start, mut inside) = (0, 0.0);
    for &(high, w) in sorted {
        inside += w;
        while inside - sorted[start].1 >= weight && sorted[start].0 < high {
            inside -= sorted[start].1;
            start += 1;
        }
        if inside >= weight && high - sorted[start].0 < best.1 - best.0 {
            best = (sorted[start].0, high);
        }
    }
    best
}

/// Tukey's weight of a height, ψ(u)/u = (1 − u²)².
pub(super) fn tukey_weight(height: f64, sigma: f64) -> f64 {
    let u = height / (TUKEY_REACH * sigma);
    let rest = 1.0 - u * u;
    if rest > 0.0 { rest * rest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Rng, Stage};
    use approx::assert_relative_eq;

    #[test]
    fn spread_of_normal_heights_is_their_standard_deviation() {
        let mut rng = Rng::new(1, Stage::Synth, 0);
        let heights: Vec<f64> = (0..40_000).map(|_| 3.0 + 0.2 * rng.normal()).collect();
        let s = spread(&heights, &vec![1.0; heights.len()]);
        // Standard error of the MAD: 1.17 σ/√n, of the median 1.25 σ/√n; five of each.
        assert_relative_eq!(s.sigma, 0.2, epsilon = 5.0 * 1.17 * 0.2 / 200.0);
        assert_relative_eq!(s.center, 3.0, epsilon = 5.0 * 1.25 * 0.2 / 200.0);
    }

    #[test]
    fn spread_matches_plain_median_and_mad() {
        let mut rng = Rng::new(2, Stage::Synth, 0);
        let heights: Vec<f64> = (0..101).map(|_| rng.uniform()).collect();
        let median = |mut v: Vec<f64>| {
            v.sort_by(f64::total_cmp);
            v[v.len() / 2]
        };
        let m = median(heights.clone());
        let mad = median(heights.iter().map(|h| (h - m).abs()).collect());
        let s = spread(&heights, &[2.5; 101]);
        assert_relative_eq!(s.center, m);
        assert_relative_eq!(s.sigma, MAD_TO_SIGMA * mad);
    }

    #[test]
    fn spread_of_a_minority_is_that_of_the_minority() {
        let mut heights: Vec<f64> = (0..45).map(|i| 1e-3 * f64::from(i % 5)).collect();
        heights.extend((0..55).map(|i| 1.0 + 0.1 * f64::from(i)));
        let s = spread(&heights, &[1.0; 100]);
        assert!(s.sigma < 0.01 && s.center < 0.01, "{s:?}");
    }

    #[test]
    fn a_weight_counts_like_copies() {
        let s = spread(&[0.0, 1.0, 5.0, 7.0], &[1.0, 3.0, 2.0, 1.0]);
        let copies = [0.0, 1.0, 1.0, 1.0, 5.0, 5.0, 7.0];
        let t = spread(&copies, &[1.0; 7]);
        assert_relative_eq!(s.center, t.center);
        assert_relative_eq!(s.sigma, t.sigma);
    }

    #[test]
    fn tukey_weight_falls_from_one_to_zero_at_its_reach() {
        assert_relative_eq!(tukey_weight(0.0, 0.3), 1.0);
        assert_relative_eq!(tukey_weight(-0.5 * TUKEY_REACH * 0.3, 0.3), 0.5625);
        assert_relative_eq!(tukey_weight(1.001 * TUKEY_REACH * 0.3, 0.3), 0.0);
    }
}
