//! All parameters of a height map.

use rustfft::FftDirection;
use rustfft::num_complex::Complex;
use serde::Serialize;

use super::fourier::{fast_length, transform};
use super::sum::Sum;
use super::{
    ArealError, ArealParameters, Autocorrelation, FormOperation, HeightParameters,
    MaterialRatioCurve, long_waves,
};
use crate::scan::HeightMap;

/// What is done to a height map before its parameters are taken.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct SurfaceParams {
    /// The form that is taken away. Default: the plane of least squares.
    pub form: FormOperation,
    /// Cut-off (nesting index) below which waves are taken away, in the map's unit. Default: none are.
    pub s_filter: Option<f64>,
    /// Cut-off (nesting index) above which waves are taken away, in the map's unit. Default: none are.
    pub l_filter: Option<f64>,
}

/// How slopes are told for Sdq.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SlopeRule {
    /// Differences of neighbours, each direction averaged over its own. The default, as in other programs: it
    /// leaves no wave out, while the stencil passes over those of two steps.
    #[default]
    Differences,
    /// The standard's stencil over seven heights, (1, −9, 45, 0, −45, 9, −1) / 60 steps, wherever all of them
    /// are known in both directions.
    Stencil,
}

/// The scale-limited surface of a map: without form, short waves and long waves.
///
/// The form is taken away first and, after the S-filter, once more, so that a tilt does not reach the filter,
/// which would bend it near the rims. Then the waves that the L-filter lets pass are subtracted.
///
/// # Errors
/// [`ArealError`] if there are fewer than 3 by 3 heights, or the form or a filter does not suit them.
///
/// # Reference
/// ISO 25178-3:2012, 4.2 (S-F and S-L surface).
pub fn scale_limited_surface(
    map: &HeightMap,
    params: &SurfaceParams,
) -> Result<HeightMap, ArealError> {
    check(map, params)?;
    let mut surface = map.clone();
    params.form.remove(&mut surface)?;
    if let Some(cutoff) = params.s_filter {
        surface = long_waves(&surface, cutoff);
        params.form.remove(&mut surface)?;
    }
    if let Some(cutoff) = params.l_filter {
        let long = long_waves(&surface, cutoff);
        for (height, long) in surface.heights.iter_mut().zip(&long.heights) {
            *height -= long;
        }
    }
    Ok(surface)
}

fn check(map: &HeightMap, params: &SurfaceParams) -> Result<(), ArealError> {
    let (columns, rows) = (map.columns, map.rows);
    let known = map.heights.len() - map.missing();
    if columns < 3 || rows < 3 || known < 9 {
        return Err(ArealError::TooFewHeights {
            columns,
            rows,
            known,
        });
    }
    let lengths = [
        ("step along x", Some(map.dx)),
        ("step along y", Some(map.dy)),
        ("S-filter's cut-off", params.s_filter),
        ("L-filter's cut-off", params.l_filter),
    ];
    for (what, length) in lengths {
        if let Some(length) = length.filter(|length| !(*length > 0.0 && length.is_finite())) {
            return Err(ArealError::NotPositive { what, length });
        }
    }
    let side = (map.dx * (columns - 1) as f64).min(map.dy * (rows - 1) as f64);
    let filters = [("S-filter", params.s_filter), ("L-filter", params.l_filter)];
    for (filter, cutoff) in filters {
        if let Some(length) = cutoff.filter(|length| *length > side) {
            return Err(ArealError::FilterTooLong {
                filter,
                length,
                side,
            });
        }
    }
    match (params.s_filter, params.l_filter) {
        (Some(s_filter), Some(l_filter)) if s_filter >= l_filter => {
            Err(ArealError::NothingLeft { s_filter, l_filter })
        }
        _ => Ok(()),
    }
}

impl MaterialRatioCurve {
    /// The curve of a map's known heights, about their mean, each of the same weight.
    #[must_use]
    pub fn of_map(map: &HeightMap) -> Option<Self> {
        let mean = HeightParameters::of(samples(map))?.mean;
        Self::new(samples(map).map(|(height, weight)| (height - mean, weight)))
    }
}

impl ArealParameters {
    /// Parameters of a map as it is, about its mean height: every known height weighs the same.
    ///
    /// Sdr is that of the cells between four known heights, each split along both diagonals, of which the mean is
    /// taken (ISO 25178-2:2021, D.3). The autocorrelation of a lag is the mean product over all pairs of known heights
    /// that are so far apart, up to nine tenths of each side. `None` if no height is known.
    #[must_use]
    pub fn of_map(map: &HeightMap, slopes: SlopeRule) -> Option<Self> {
        let heights = HeightParameters::of(samples(map))?;
        let curve = MaterialRatioCurve::of_map(map)?;
        let acf = (heights.sq > 0.0)
            .then(|| autocorrelation(map, heights.mean))
            .flatten();
        let (sal, ratio) = acf.as_ref().map_or((None, None), Autocorrelation::lengths);
        Some(Self {
            sdq: match slopes {
                SlopeRule::Differences => gradient_by_differences(map),
                SlopeRule::Stencil => gradient_by_stencil(map),
            },
            sdr: developed_area_ratio(map),
            sal,
            str: ratio,
            std: acf.as_ref().and_then(Autocorrelation::direction),
            ..Self::of_heights(&heights, &curve)
        })
    }
}

/// The known heights, each of weight 1.
fn samples(map: &HeightMap) -> impl Iterator<Item = (f64, f64)> + Clone {
    let known = map.heights.iter().filter(|height| !height.is_nan());
    known.map(|height| (*height, 1.0))
}

/// A sum and how many values it is of, NaN left out.
#[derive(Debug, Default)]
struct Mean {
    sum: Sum,
    count: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        if !value.is_nan() {
            self.sum.add(value);
            self.count += 1.0;
        }
    }

    fn value(&self) -> Option<f64> {
        (self.count > 0.0).then(|| self.sum.value() / self.count)
    }
}

/// Sdq by differences of neighbours.
fn gradient_by_differences(map: &HeightMap) -> Option<f64> {
    let (mut along_x, mut along_y) = (Mean::default(), Mean::default());
    for row in map.heights.chunks_exact(map.columns) {
        for (a, b) in row.iter().zip(&row[1..]) {
            along_x.add(((b - a) / map.dx).powi(2));
        }
    }
    for (a, b) in map.heights.iter().zip(&map.heights[map.columns..]) {
        along_y.add(((b - a) / map.dy).powi(2));
    }
    Some((along_x.value()? + along_y.value()?).sqrt())
}

/// Sdq by the stencil over seven heights.
fn gradient_by_stencil(map: &HeightMap) -> Option<f64> {
    const WEIGHTS: [f64; 3] = [45.0, -9.0, 1.0];
    let mut squares = Mean::default();
    for row in 3..map.rows.saturating_sub(3) {
        for column in 3..map.columns.saturating_sub(3) {
            let slope = |step: f64, pair: &dyn Fn(usize) -> f64| {
                let sum: f64 = (1..=3).map(|k| WEIGHTS[k - 1] * pair(k)).sum();
                sum / (60.0 * step)
            };
            let x = slope(map.dx, &|k| {
                map.at(column + k, row) - map.at(column - k, row)
            });
            let y = slope(map.dy, &|k| {
                map.at(column, row + k) - map.at(column, row - k)
            });
            squares.add(x * x + y * y);
        }
    }
    squares.value().map(f64::sqrt)
}

/// Sdr in percent.
fn developed_area_ratio(map: &HeightMap) -> Option<f64> {
    let mut excess = Mean::default();
    for row in 1..map.rows {
        for column in 1..map.columns {
            let slope_x = |row| (map.at(column, row) - map.at(column - 1, row)) / map.dx;
            let slope_y = |column| (map.at(column, row) - map.at(column, row - 1)) / map.dy;
            // Each corner's triangle is half a cell; the two diagonals together have all four.
            for x in [slope_x(row - 1), slope_x(row)] {
                for y in [slope_y(column - 1), slope_y(column)] {
                    let square = x * x + y * y;
                    // √(1 + s) − 1 without losing the digits of a small s.
                    excess.add(square / (1.0 + (1.0 + square).sqrt()));
                }
            }
        }
    }
    excess.value().map(|excess| 100.0 * excess)
}

/// The unbiased autocorrelation of the heights about a mean, for lags up to nine tenths of each side.
fn autocorrelation(map: &HeightMap, mean: f64) -> Option<Autocorrelation> {
    let (columns, rows) = (map.columns, map.rows);
    let size = [columns, rows].map(|side| fast_length(2 * side - 1));
    let correlated = |of: &dyn Fn(f64) -> f64| {
        let mut grid = vec![Complex::default(); size[0] * size[1]];
        for (k, height) in map.heights.iter().enumerate() {
            grid[(k / columns) * size[0] + k % columns] = Complex::from(of(*height));
        }
        transform(&mut grid, size[0], size[1], FftDirection::Forward);
        for value in &mut grid {
            *value = Complex::from(value.norm_sqr());
        }
        transform(&mut grid, size[0], size[1], FftDirection::Inverse);
        let scale = 1.0 / (size[0] * size[1]) as f64;
        grid.into_iter()
            .map(|value| scale * value.re)
            .collect::<Vec<f64>>()
    };
    let products = correlated(&|height| if height.is_nan() { 0.0 } else { height - mean });
    // Without missing heights the number of pairs is known.
    let pairs = (map.missing() > 0).then(|| correlated(&|height| f64::from(!height.is_nan())));
    // Beyond nine tenths of a side the pairs are of strips that are too narrow to tell anything.
    let reach = [columns, rows].map(|side| side - 1 - side / 10);
    let [lags_across, lags_down] = reach.map(|lags| 2 * lags + 1);
    let mut values = Vec::with_capacity(lags_across * lags_down);
    // Rows of the map run downwards, lags upwards.
    for row in 0..lags_down {
        for column in 0..lags_across {
            let (across, down) = (reach[0].abs_diff(column), reach[1].abs_diff(row));
            // Lag (i, j) is lag (−i, −j), so that only whether the signs agree matters.
            let is_turned = (column > reach[0]) == (row > reach[1]) && across > 0 && down > 0;
            let wrapped = if is_turned { size[0] - across } else { across };
            let place = down * size[0] + wrapped;
            let count = match &pairs {
                Some(pairs) => pairs[place].round(),
                None => ((columns - across) * (rows - down)) as f64,
            };
            values.push(if count > 0.0 {
                products[place] / count
            } else {
                f64::NAN
            });
        }
    }
    Autocorrelation::new(reach, [map.dx, map.dy], values)
}
