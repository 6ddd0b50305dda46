//! Distances between distributions and between positive figures.

/// Shares below this of a reference figure count as this: a piece without any relief is far off, but not
/// infinitely.
const LEAST_SHARE: f64 = 1e-6;

/// 1-D Wasserstein distance of two weighted samples, given together as (value, left weight, right weight)
/// in ascending order of the values; `None` if one of them has no weight.
pub(super) fn wasserstein(items: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Option<f64> {
    let (left, right) = (items.clone()).fold((0.0, 0.0), |(l, r), (_, wl, wr)| (l + wl, r + wr));
    if left <= 0.0 || right <= 0.0 {
        return None;
    }
    let (mut sum, mut excess, mut before) = (0.0, 0.0f64, None);
    for (value, wl, wr) in items {
        if let Some(before) = before {
            sum += excess.abs() * (value - before);
        }
        excess += wl / left - wr / right;
        before = Some(value);
    }
    Some(sum)
}

/// |ln(a/b)| of two figures that are not negative; `None` if the second, the reference, is zero.
pub(super) fn log_ratio(a: f64, b: f64) -> Option<f64> {
    let least = LEAST_SHARE * b;
    (b > 0.0 && a.is_finite() && b.is_finite()).then(|| ((a + least) / (b + least)).ln().abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_shifted_sample_is_as_far_as_its_shift() {
        let (left, right) = ([0.0, 1.0, 5.0], [2.0, 3.0, 7.0]);
        let mut items: Vec<(f64, f64, f64)> = (left.map(|x| (x, 0.5, 0.0)).into_iter())
            .chain(right.map(|x| (x, 0.0, 9.0)))
            .collect();
        items.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert_relative_eq!(
            wasserstein(items.iter().copied()).unwrap(),
            2.0,
            epsilon = 1e-12
        );
        assert_eq!(
            wasserstein(items.into_iter().map(|i| (i.0, i.1, 0.0))),
            None
        );
    }

    #[test]
    fn how_often_a_value_is_listed_does_not_matter_but_its_weight_does() {
        let once = [(0.0, 2.0, 1.0), (1.0, 2.0, 3.0)];
        let twice = [
            (0.0, 1.0, 1.0),
            (0.0, 1.0, 0.0),
            (1.0, 2.0, 1.5),
            (1.0, 0.0, 1.5),
        ];
        let once = wasserstein(once.into_iter()).unwrap();
        assert_relative_eq!(once, 0.25, epsilon = 1e-12);
        assert_relative_eq!(
            wasserstein(twice.into_iter()).unwrap(),
            once,
            epsilon = 1e-12
        );
    }

    #[test]
    fn ratios_count_alike_both_ways_and_stay_finite() {
        assert_relative_eq!(log_ratio(2.0, 1.0).unwrap(), 2f64.ln(), epsilon = 1e-5);
        assert_relative_eq!(log_ratio(0.5, 1.0).unwrap(), 2f64.ln(), epsilon = 1e-5);
        assert!(log_ratio(0.0, 1.0).unwrap() > 10.0);
        assert_eq!(log_ratio(1.0, 0.0), None);
    }
}
