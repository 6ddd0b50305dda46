//! The autocorrelation of a surface: how far it resembles itself.

use rayon::prelude::*;

/// Where the autocorrelation counts as gone (default of ISO 25178-3).
pub const CORRELATION_THRESHOLD: f64 = 0.2;

/// Most lags on the rim that lines are drawn to; of larger maps every second, third, … is taken.
const MOST_LINES: usize = 16_384;

/// Most steps along all lines together, which takes a second or two: of long and narrow maps still fewer lines are
/// drawn, but not less than [`LEAST_LINES`]. Maps up to 6000 by 6000 do not come near it.
const MOST_STEPS: usize = 1 << 28;

/// See [`MOST_STEPS`].
const LEAST_LINES: usize = 256;

/// Autocorrelation over a lattice of lags in both directions, 1 at lag 0.
///
/// It is meant to be unbiased: each lag's mean product over those pairs of places that are both known.
///
/// # Reference
/// ISO 25178-2:2021, 3.2.11 (f<sub>ACF</sub>).
#[derive(Debug, Clone, PartialEq)]
pub struct Autocorrelation {
    reach: [usize; 2],
    steps: [f64; 2],
    values: Vec<f64>,
}

impl Autocorrelation {
    /// An autocorrelation, or autocovariance, which is divided by its value at lag 0.
    ///
    /// `reach` is the number of lags on each side of 0 along x and along y, `steps` their distances, both
    /// positive. `values`: (2 reach\[1\] + 1) rows of (2 reach\[0\] + 1) columns, with lag (i, j) in row
    /// reach\[1\] + j and column reach\[0\] + i; NaN where unknown. x to y is counterclockwise: from a map whose
    /// rows run downwards, j counts upwards.
    ///
    /// `None` if the value at lag 0 is not positive: the surface is flat.
    ///
    /// # Panics
    /// If there are not as many values as lags, or a step is not positive.
    #[must_use]
    pub fn new(reach: [usize; 2], steps: [f64; 2], mut values: Vec<f64>) -> Option<Self> {
        let [columns, rows] = reach.map(|lags| 2 * lags + 1);
        assert_eq!(values.len(), columns * rows, "one value a lag");
        assert!(steps.iter().all(|step| *step > 0.0), "steps are positive");
        let variance = values[reach[1] * columns + reach[0]];
        if !(variance > 0.0 && variance.is_finite()) {
            return None;
        }
        for value in &mut values {
            *value /= variance;
        }
        Some(Self {
            reach,
            steps,
            values,
        })
    }

    /// Number of lags on each side of 0, along x and along y.
    #[must_use]
    pub fn reach(&self) -> [usize; 2] {
        self.reach
    }

    /// Distances of the lags along x and along y.
    #[must_use]
    pub fn steps(&self) -> [f64; 2] {
        self.steps
    }

    /// The value at a lag, i along x and j along y; NaN where unknown or out of reach.
    #[must_use]
    pub fn at(&self, i: isize, j: isize) -> f64 {
        let column = self.reach[0].checked_add_signed(i);
        let row = self.reach[1].checked_add_signed(j);
        let columns = 2 * self.reach[0] + 1;
        match (column, row) {
            (Some(column), Some(row)) if column < columns && row <= 2 * self.reach[1] => {
                self.values[row * columns + column]
            }
            _ => f64::NAN,
        }
    }

    /// The value between lags, linearly in both directions.
    fn between(&self, x: f64, y: f64) -> f64 {
        let (left, below) = (x.floor(), y.floor());
        let (right_share, above_share) = (x - left, y - below);
        #[expect(clippy::cast_possible_truncation, reason = "lags are within the reach")]
        let (i, j) = (left as isize, below as isize);
        let corners = [
            (0, 0, (1.0 - right_share) * (1.0 - above_share)),
            (1, 0, right_share * (1.0 - above_share)),
            (0, 1, (1.0 - right_share) * above_share),
            (1, 1, right_share * above_share),
        ];
        // An unknown corner that has no say does not make the value unknown.
        let counted = corners.iter().filter(|(_, _, weight)| *weight > 0.0);
        counted
            .map(|(a, b, weight)| weight * self.at(i + a, j + b))
            .sum()
    }

    /// Sal and Str: the shortest distance from lag 0 at which the autocorrelation falls to 0.2, and its ratio to
    /// the longest, over the straight lines from lag 0 to the lags on the rim, along each of which the first
    /// fall counts; linear between lags. Where the rim has more than 16 384 lags, lines go to some of them only,
    /// evenly along it; of maps that are very long and narrow to still fewer, at least 256.
    ///
    /// Sal is `None` if no line falls so far. Str is `None` if one does not before the rim or the unknown: the
    /// longest distance is larger than the map then.
    ///
    /// # Reference
    /// ISO 25178-2:2021, 4.3.2 and 4.3.3.
    #[must_use]
    pub fn lengths(&self) -> (Option<f64>, Option<f64>) {
        let Some(sure) = self.sure() else {
            return (None, None);
        };
        let rim: Vec<(f64, f64)> = self.rim().collect();
        let falls: Vec<Option<f64>> = (rim.par_iter())
            .map(|(i, j)| self.falls_towards(*i, *j, sure))
            .collect();
        let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
        for distance in falls.iter().flatten() {
            shortest = shortest.min(*distance);
            longest = longest.max(*distance);
        }
        let sal = shortest.is_finite().then_some(shortest);
        let ratio = sal.map(|sal| sal / longest);
        (sal, ratio.filter(|_| falls.iter().all(Option::is_some)))
    }

    /// How many lags in each direction nothing falls to the threshold or is unknown; `None` if nothing falls at
    /// all. What lies between lags is a mean of them.
    fn sure(&self) -> Option<usize> {
        let columns = 2 * self.reach[0] + 1;
        let rows = self.values.par_chunks_exact(columns).enumerate();
        let (nearest, any_falls) = rows
            .map(|(row, values)| {
                let up = row.abs_diff(self.reach[1]);
                let (mut nearest, mut any_falls) = (usize::MAX, false);
                for (column, value) in values.iter().enumerate() {
                    if value.is_nan() || *value <= CORRELATION_THRESHOLD {
                        nearest = nearest.min(up.max(column.abs_diff(self.reach[0])));
                        any_falls |= !value.is_nan();
                    }
                }
                (nearest, any_falls)
            })
            .reduce(|| (usize::MAX, false), |a, b| (a.0.min(b.0), a.1 || b.1));
        any_falls.then(|| nearest.saturating_sub(1))
    }

    /// Half of the outermost lags; the autocorrelation is symmetric.
    fn rim(&self) -> impl Iterator<Item = (f64, f64)> {
        let [mx, my] = self.reach.map(|lags| lags as f64);
        let top = (0..=2 * self.reach[0]).map(move |k| (k as f64 - mx, my));
        let right = (0..self.reach[1]).map(move |k| (mx, k as f64));
        let left = (1..self.reach[1]).map(move |k| (-mx, k as f64));
        let all = (top.chain(right).chain(left)).filter(|(i, j)| i.abs() + j.abs() > 0.0);
        let lags = 2 * (self.reach[0] + self.reach[1]);
        let steps = 2 * self.reach[0].max(self.reach[1]).max(1);
        let most = (MOST_STEPS / steps).clamp(LEAST_LINES, MOST_LINES);
        all.step_by(1 + lags / most)
    }

    /// Distance of the first fall to the threshold on the line from lag 0 to a lag on the rim. Up to `sure` lags
    /// away there is none.
    fn falls_towards(&self, i: f64, j: f64, sure: usize) -> Option<f64> {
        // Steps of half a lag: between lags the value is linear along the axes, and nearly so elsewhere.
        let steps = 2.0 * i.abs().max(j.abs());
        let length = (i * self.steps[0]).hypot(j * self.steps[1]);
        let first = 2.0 * sure as f64;
        let (mut before, mut k) = (
            self.between(i * first / steps, j * first / steps),
            first + 1.0,
        );
        while k <= steps {
            let value = self.between(i * k / steps, j * k / steps);
            if value.is_nan() {
                return None;
            }
            if value <= CORRELATION_THRESHOLD {
                let share = (before - CORRELATION_THRESHOLD) / (before - value);
                return Some(length * (k - 1.0 + share) / steps);
            }
            before = value;
            k += 1.0;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn made(reach: [usize; 2], steps: [f64; 2], of: impl Fn(f64, f64) -> f64) -> Autocorrelation {
        let [mx, my] = reach.map(|lags| lags as f64);
        let columns = 2 * reach[0] + 1;
        let values = (0..columns * (2 * reach[1] + 1)).map(|k| {
            let (column, row) = ((k % columns) as f64, (k / columns) as f64);
            of((column - mx) * steps[0], (row - my) * steps[1])
        });
        Autocorrelation::new(reach, steps, values.collect()).unwrap()
    }

    #[test]
    fn an_elliptic_decay_has_its_two_lengths() {
        // exp(−d) is 0.2 at ln 5.
        let of = |x: f64, y: f64| 7.0 * (-(x / 3.0).hypot(y / 9.0)).exp();
        let acf = made([80, 60], [0.1, 0.5], of);
        let (sal, ratio) = acf.lengths();
        assert_relative_eq!(sal.unwrap(), 3.0 * 5.0_f64.ln(), max_relative = 1e-3);
        assert_relative_eq!(ratio.unwrap(), 1.0 / 3.0, max_relative = 1e-3);
        assert_relative_eq!(acf.at(0, 0), 1.0);
        assert!(acf.at(81, 0).is_nan() && acf.at(0, -61).is_nan());
    }

    #[test]
    fn a_decay_across_the_diagonal_is_found_there() {
        let of = |x: f64, y: f64| (-((x + y) / 2.0).hypot((x - y) / 8.0)).exp();
        let (sal, ratio) = made([60, 60], [0.25, 0.25], of).lengths();
        let along = |length: f64| length * 5.0_f64.ln() / 2.0_f64.sqrt();
        assert_relative_eq!(sal.unwrap(), along(2.0), max_relative = 5e-3);
        assert_relative_eq!(ratio.unwrap(), 0.25, max_relative = 5e-3);
    }

    #[test]
    fn grooves_have_a_length_but_no_aspect_ratio() {
        let (sal, ratio) = made([50, 50], [1.0, 1.0], |x, _| (x / 5.0).cos()).lengths();
        assert_relative_eq!(sal.unwrap(), 5.0 * 0.2_f64.acos(), max_relative = 5e-3);
        assert_eq!(ratio, None);
        assert_eq!(made([5, 5], [1.0, 1.0], |_, _| 2.0).lengths(), (None, None));
    }

    #[test]
    fn unknown_lags_end_a_line() {
        let of = |x: f64, y: f64| {
            if y.abs() > 2.0 {
                f64::NAN
            } else {
                (-(x.hypot(y)) / 3.0).exp()
            }
        };
        let (sal, ratio) = made([20, 20], [1.0, 1.0], of).lengths();
        assert_relative_eq!(sal.unwrap(), 3.0 * 5.0_f64.ln(), max_relative = 1e-2);
        assert_eq!(ratio, None);
    }

    /// The definition alone: every line from lag 0 on.
    fn plainly(acf: &Autocorrelation) -> (Option<f64>, Option<f64>) {
        let falls: Vec<Option<f64>> = (acf.rim())
            .map(|(i, j)| acf.falls_towards(i, j, 0))
            .collect();
        let known = || falls.iter().flatten().copied();
        let sal = known().min_by(f64::total_cmp);
        let longest = known().max_by(f64::total_cmp);
        let ratio = sal.zip(longest).map(|(sal, longest)| sal / longest);
        (sal, ratio.filter(|_| falls.iter().all(Option::is_some)))
    }

    #[test]
    fn what_is_sure_to_hold_no_fall_changes_nothing() {
        let slow = |x: f64, y: f64| (-(x / 9.0).hypot(y / 13.0)).exp();
        let ripples = |x: f64, y: f64| 0.35 + 0.65 * (x / 3.0 + y / 7.0).cos();
        let some = |x: f64, y: f64| if x > 12.0 { f64::NAN } else { slow(x, y) };
        let never = |x: f64, y: f64| 0.5 + 0.5 * (-x.hypot(y)).exp();
        let unknown = |x: f64, y: f64| if x.hypot(y) > 2.0 { f64::NAN } else { 1.0 };
        let at_once = |x: f64, y: f64| f64::from(u8::from(x.hypot(y) < 0.1));
        let all: [&dyn Fn(f64, f64) -> f64; 6] =
            [&slow, &ripples, &some, &never, &unknown, &at_once];
        for (k, of) in all.into_iter().enumerate() {
            let acf = made([40, 35], [1.0, 0.7], of);
            assert_eq!(acf.lengths(), plainly(&acf), "surface {k}");
        }
        let sure = |of: &dyn Fn(f64, f64) -> f64| made([40, 35], [1.0, 0.7], of).sure();
        // On the diagonal of the lags it falls to 0.2 at ln 5 / 0.1235 = 13.03 lags along each axis.
        assert_eq!(sure(&slow), Some(13));
        assert_eq!([sure(&never), sure(&unknown)], [None, None]);
        assert_eq!(sure(&at_once), Some(0));
    }

    #[test]
    fn a_long_and_narrow_map_has_few_lines() {
        let acf = Autocorrelation {
            reach: [2_000_000, 2],
            steps: [1.0; 2],
            values: Vec::new(),
        };
        assert!((LEAST_LINES..=LEAST_LINES + 1).contains(&acf.rim().count()));
        let square = Autocorrelation {
            reach: [5400, 5400],
            ..acf
        };
        assert!(square.rim().count() > 10_000);
    }

    #[test]
    fn a_flat_surface_has_none() {
        assert_eq!(Autocorrelation::new([1, 1], [1.0, 1.0], vec![0.0; 9]), None);
    }
}
