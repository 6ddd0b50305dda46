//! The nearest full window of each of many queries, all windows compared.
//!
//! Squared distances are ‖a‖² − 2 a·b + ‖b‖², the products those of one matrix with another, which costs a tenth
//! of subtracting row by row. That formula loses digits where distances are small against the values: every
//! row that it does not clearly exclude is compared plainly, so that what is found is the very nearest.

use nalgebra::{DMatrix, DMatrixView};
use rayon::prelude::*;

use super::tree::{distance_sq, norm_sq};

/// Queries that are multiplied at once.
const QUERIES: usize = 64;

/// Rows that are multiplied at once: they and their products stay in the processor's cache.
const ROWS: usize = 512;

/// Rows of numbers to be compared with many others.
#[derive(Debug, Clone)]
pub struct Batch {
    dimensions: usize,
    rows: Vec<f32>,
    mean: Vec<f32>,
    /// Squared norms of the rows less their mean.
    norms: Vec<f32>,
}

impl Batch {
    /// Of n rows of `dimensions` values each (`rows`: n by `dimensions`).
    ///
    /// # Panics
    /// If `dimensions` is 0, `rows` is no whole number of rows or has 2³² of them or more.
    #[must_use]
    pub fn new(rows: &[f32], dimensions: usize) -> Self {
        assert!(dimensions > 0, "nothing to compare");
        assert!(rows.len().is_multiple_of(dimensions), "rows must be whole");
        assert!(
            u32::try_from(rows.len() / dimensions).is_ok(),
            "rows are u32"
        );
        let mut sums = vec![0.0; dimensions];
        for row in rows.chunks_exact(dimensions) {
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += f64::from(*value);
            }
        }
        let count = (rows.len() / dimensions).max(1) as f64;
        #[expect(clippy::cast_possible_truncation, reason = "rows are single")]
        let mean: Vec<f32> = sums.iter().map(|sum| (sum / count) as f32).collect();
        let norms = (rows.par_chunks_exact(dimensions))
            .map(|row| norm_sq(&centred(row, &mean).collect::<Vec<f32>>()))
            .collect();
        Self {
            dimensions,
            rows: rows.to_vec(),
            mean,
            norms,
        }
    }

    /// For each query (`queries`: m by `dimensions`) the number of the nearest row and its squared distance; the
    /// first of several as near. None at all without rows.
    ///
    /// The result does not depend on the number of threads.
    ///
    /// # Panics
    /// If `queries` is no whole number of rows.
    #[must_use]
    pub fn nearest_of_all(&self, queries: &[f32]) -> Vec<(u32, f32)> {
        assert!(
            queries.len().is_multiple_of(self.dimensions),
            "queries must be whole"
        );
        if self.norms.is_empty() {
            return Vec::new();
        }
        (queries.par_chunks(QUERIES * self.dimensions))
            .flat_map_iter(|some| self.nearest_of_some(some))
            .collect()
    }

    fn nearest_of_some(&self, queries: &[f32]) -> Vec<(u32, f32)> {
        let width = self.dimensions;
        let count = queries.len() / width;
        let less_mean = |rows: &[f32]| -> Vec<f32> {
            let rows = rows.chunks_exact(width);
            rows.flat_map(|row| centred(row, &self.mean)).collect()
        };
        let centred = less_mean(queries);
        let lengths: Vec<f32> = centred.chunks_exact(width).map(norm_sq).collect();
        let matrix = DMatrixView::from_slice(&centred, width, count);
        let mut products = DMatrix::zeros(ROWS, count);
        // By query the rows that may be the nearest, with what they cost at least, and the least that one costs at
        // most.
        let mut left: Vec<Vec<(u32, f32)>> = vec![Vec::new(); count];
        let mut limits = vec![f32::INFINITY; count];
        let blocks = self.rows.chunks(ROWS * width).zip(self.norms.chunks(ROWS));
        for (block, (rows, norms)) in blocks.enumerate() {
            let rows = less_mean(rows);
            let rows = DMatrixView::from_slice(&rows, width, norms.len());
            let mut products = products.rows_mut(0, norms.len());
            products.gemm(1.0, &rows.transpose(), &matrix, 0.0);
            for (q, column) in products.column_iter().enumerate() {
                for (i, (product, norm)) in column.iter().zip(norms).enumerate() {
                    let cost = norm - 2.0 * product + lengths[q];
                    let slack = self.slack(norm + lengths[q]);
                    if cost - slack <= limits[q] {
                        limits[q] = limits[q].min(cost + slack);
                        let row = u32::try_from(block * ROWS + i).expect("rows are u32");
                        left[q].push((row, cost - slack));
                    }
                }
            }
        }
        (left
            .into_iter()
            .zip(queries.chunks_exact(width))
            .zip(limits))
        .map(|((left, query), limit)| {
            (left.into_iter())
                .filter(|(_, least)| *least <= limit)
                .map(|(row, _)| (row, distance_sq(query, self.row(row))))
                .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
                .expect("the row that set the limit is left")
        })
        .collect()
    }

    fn row(&self, row: u32) -> &[f32] {
        &self.rows[row as usize * self.dimensions..][..self.dimensions]
    }

    /// How far the formula may be off the plain sum where the squared norms add up to this: each of its terms by a unit
    /// of the last digit for each product, as much for the plain sum's, and some for taking off the mean.
    fn slack(&self, norms: f32) -> f32 {
        f32::EPSILON * (2 * self.dimensions + 8) as f32 * norms
    }
}

fn centred<'a>(row: &'a [f32], mean: &'a [f32]) -> impl Iterator<Item = f32> + 'a {
    row.iter().zip(mean).map(|(value, mean)| value - mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::tree::{Tree, TreeParams};
    use crate::rng::{Rng, Stage};

    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "test values")]
    fn all_are_compared_as_the_plain_search_compares_them() {
        let mut rng = Rng::new(3, Stage::Matching, 0);
        for (count, width) in [(1, 1), (700, 3), (1500, 75)] {
            let mut values =
                |n: usize| -> Vec<f32> { (0..n).map(|_| 100.0 + rng.normal() as f32).collect() };
            let (rows, queries) = (values(count * width), values(130 * width));
            let found = Batch::new(&rows, width).nearest_of_all(&queries);
            let tree = Tree::new(&rows, width, &TreeParams::default());
            assert_eq!(found.len(), 130);
            for (query, (row, cost)) in queries.chunks(width).zip(found) {
                let plain = |row: &[f32]| -> f64 {
                    row.iter()
                        .zip(query)
                        .map(|(a, b)| f64::from(a - b).powi(2))
                        .sum()
                };
                let costs: Vec<f64> = rows.chunks(width).map(plain).collect();
                let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
                // The mean is taken off in single precision.
                assert!((costs[row as usize] - least).abs() <= 1e-3 * least.max(1e-3));
                assert!((f64::from(cost) - least).abs() <= 1e-3 * least.max(1e-3));
                assert_eq!(tree.nearest(query, 1, |_| true)[0].0, row);
            }
        }
        assert!(Batch::new(&[], 3).nearest_of_all(&[0.0; 6]).is_empty());
    }

    #[test]
    fn of_equal_rows_the_first_is_found() {
        let rows = [1.0, 2.0, 5.0, 5.0, 5.0, 5.0, 1.0, 2.0];
        let found = Batch::new(&rows, 2).nearest_of_all(&[5.0, 5.0, 1.0, 2.1]);
        assert_eq!([found[0].0, found[1].0], [1, 0]);
    }

    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "test values")]
    fn of_rows_as_near_the_tree_finds_the_same() {
        let mut rng = Rng::new(6, Stage::Matching, 0);
        let width = 75;
        // A periodic texture: every row is there several times, and many queries lie right between two.
        let mut different = vec![0f32; 40 * width];
        different.fill_with(|| (rng.uniform() * 255.0).round() as f32 / 255.0);
        let rows = different.repeat(9);
        let between = |i: usize| {
            let [a, b] = [i % 40, i * 7 % 40].map(|row| &different[row * width..][..width]);
            a.iter()
                .zip(b)
                .map(|(a, b)| 0.5 * (a + b))
                .collect::<Vec<f32>>()
        };
        let queries: Vec<f32> = (0..300).flat_map(between).collect();
        let tree = Tree::new(&rows, width, &TreeParams::default());
        let found = Batch::new(&rows, width).nearest_of_all(&queries);
        for (query, (row, cost)) in queries.chunks(width).zip(found) {
            let (expected, least) = tree.nearest(query, 1, |_| true)[0];
            assert_eq!((row, cost.to_bits()), (expected, least.to_bits()));
            assert!(row < 40, "the first of them");
        }
    }
}
