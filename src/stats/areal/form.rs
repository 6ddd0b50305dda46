//! F-operation: what counts as form and is taken away.

use nalgebra::{SMatrix, SVector, SymmetricEigen};
use serde::Serialize;

use super::ArealError;
use crate::scan::HeightMap;

/// The form that is fitted to all known heights by least squares of the heights, and subtracted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FormOperation {
    /// Nothing: the heights stay as they are in the file. Parameters are about the mean all the same.
    None,
    /// The mean height.
    Mean,
    /// The plane of least squares.
    #[default]
    Plane,
    /// The polynomial of second degree, with all six products of x and y.
    Poly2,
    /// The polynomial of third degree, with all ten products of x and y.
    Poly3,
}

/// Largest number of coefficients: those of third degree.
const MOST: usize = 10;

/// Eigenvalues of the normal equations below this share of the largest one are zero but for rounding: on a map
/// that determines a polynomial of third degree they are above 1e-4 of it, in coordinates from −1 to 1.
const SINGULAR: f64 = 1e-11;

/// What subtracting a form rounds by, as a share of the largest height: a few bits of the last of 53.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl FormOperation {
    /// Number of its coefficients.
    fn coefficients(self) -> usize {
        match self {
            Self::None => 0,
            Self::Mean => 1,
            Self::Plane => 3,
            Self::Poly2 => 6,
            Self::Poly3 => MOST,
        }
    }

    /// Takes the form away; missing heights stay missing.
    ///
    /// # Errors
    /// [`ArealError::FormNotDetermined`].
    pub fn remove(self, map: &mut HeightMap) -> Result<(), ArealError> {
        if self == Self::None {
            return Ok(());
        }
        let largest = largest_height(map);
        // The second fit takes away what rounding has left of a large offset or slope.
        for _ in 0..2 {
            let fitted = self.fit(map)?;
            for_each_known(map, |height, basis| *height -= fitted.dot(basis));
        }
        // What is form and nothing else is flat, not rough by its rounding.
        if largest_height(map) <= ROUNDING * largest {
            for_each_known(map, |height, _| *height = 0.0);
        }
        Ok(())
    }

    /// The coefficients of least squares, zero beyond those that the form has.
    fn fit(self, map: &mut HeightMap) -> Result<SVector<f64, MOST>, ArealError> {
        let count = self.coefficients();
        let mut matrix = SMatrix::<f64, MOST, MOST>::zeros();
        let mut right = SVector::<f64, MOST>::zeros();
        for_each_known(map, |height, basis| {
            for i in 0..count {
                right[i] += basis[i] * *height;
                for j in 0..=i {
                    matrix[(i, j)] += basis[i] * basis[j];
                }
            }
        });
        let lower = matrix.lower_triangle();
        let full = lower + lower.transpose() - SMatrix::from_diagonal(&lower.diagonal());
        let used = full.view((0, 0), (count, count)).into_owned();
        let eigen = SymmetricEigen::new(used);
        let largest = eigen.eigenvalues.max();
        if eigen.eigenvalues.min().partial_cmp(&(SINGULAR * largest))
            != Some(std::cmp::Ordering::Greater)
        {
            return Err(ArealError::FormNotDetermined {
                coefficients: count,
            });
        }
        let mut fitted = SVector::zeros();
        for (value, vector) in eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter())
        {
            let share = vector.dot(&right.rows(0, count)) / value;
            for (k, component) in vector.iter().enumerate() {
                fitted[k] += share * component;
            }
        }
        Ok(fitted)
    }
}

/// The largest known height, up or down.
fn largest_height(map: &HeightMap) -> f64 {
    let known = map.heights.iter().filter(|height| !height.is_nan());
    known.fold(0.0, |most, height| most.max(height.abs()))
}

/// Every known height with the products of its place, from −1 to 1 along both sides, up to third degree.
fn for_each_known(map: &mut HeightMap, mut visit: impl FnMut(&mut f64, &SVector<f64, MOST>)) {
    let (columns, rows) = (map.columns, map.rows);
    let scaled = |k: usize, count: usize| 2.0 * k as f64 / (count.max(2) - 1) as f64 - 1.0;
    for (k, height) in map.heights.iter_mut().enumerate() {
        if height.is_nan() {
            continue;
        }
        let (x, y) = (scaled(k % columns, columns), scaled(k / columns, rows));
        let basis = [
            1.0,
            x,
            y,
            x * x,
            x * y,
            y * y,
            x * x * x,
            x * x * y,
            x * y * y,
            y * y * y,
        ];
        visit(height, &SVector::from(basis));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(of: impl Fn(f64, f64) -> f64) -> HeightMap {
        HeightMap::from_fn([30, 21], [0.1, 0.2], |c, r| {
            of(0.1 * c as f64, 0.2 * r as f64)
        })
    }

    #[test]
    fn each_form_takes_away_what_it_describes_and_no_more() {
        let plane = map(|x, y| 1e3 + 5.0 * x - 7.0 * y);
        let square = map(|x, y| 2.0 + x * x - 3.0 * x * y + y);
        let cubic = map(|x, y| x * x * x - x * y * y + 4.0 * y);
        for (form, left) in [
            (FormOperation::Mean, [true, true, true]),
            (FormOperation::Plane, [false, true, true]),
            (FormOperation::Poly2, [false, false, true]),
            (FormOperation::Poly3, [false, false, false]),
        ] {
            for (mut map, is_left) in [&plane, &square, &cubic]
                .map(HeightMap::clone)
                .into_iter()
                .zip(left)
            {
                form.remove(&mut map).unwrap();
                let sum: f64 = map.heights.iter().sum();
                assert!(sum.abs() < 1e-9);
                assert_eq!(
                    largest_height(&map) > 1e-10,
                    is_left,
                    "{form:?}: {}",
                    largest_height(&map)
                );
            }
        }
        let mut kept = plane.clone();
        FormOperation::None.remove(&mut kept).unwrap();
        assert_eq!(kept, plane);
    }

    #[test]
    fn missing_heights_stay_missing_and_do_not_matter() {
        let mut map = map(|x, y| 3.0 * x + y);
        for k in [0, 7, 8, 9, 200] {
            map.heights[k] = f64::NAN;
        }
        FormOperation::Plane.remove(&mut map).unwrap();
        assert_eq!(map.missing(), 5);
        assert!(largest_height(&map) < 1e-12);
    }

    #[test]
    fn heights_in_one_row_determine_no_plane() {
        let mut map = map(|x, y| if y > 0.1 { f64::NAN } else { x });
        let error = FormOperation::Plane.remove(&mut map);
        assert_eq!(
            error,
            Err(ArealError::FormNotDetermined { coefficients: 3 })
        );
        assert_eq!(FormOperation::Mean.remove(&mut map), Ok(()));
    }
}
