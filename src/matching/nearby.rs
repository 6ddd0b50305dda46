//! Full windows near a query, without the promise that they are the very nearest.
//!
//! Rows are told apart by a few principal components, searched exactly in a [`Tree`] of their own; of several near there
//! the rows themselves are compared. In so few dimensions a tree leaves out nearly all rows, in all of them hardly any.

use rayon::prelude::*;

use super::tree::{Projection, Tree, TreeParams, distance_sq};

/// How a [`Nearby`] is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NearbyParams {
    /// Number of principal components; 8 by default. More find nearer rows, fewer are faster.
    pub components: usize,
    /// Rows that are compared for each that is asked for; 4 by default.
    pub compared: usize,
}

impl Default for NearbyParams {
    fn default() -> Self {
        Self {
            components: 8,
            compared: 4,
        }
    }
}

/// Rows of numbers, arranged for the search of near ones.
#[derive(Debug, Clone)]
pub struct Nearby<'a> {
    rows: &'a [f32],
    dimensions: usize,
    projection: Projection,
    components: usize,
    /// n by components.
    projected: Vec<f32>,
    tree: Tree,
    compared: usize,
}

impl<'a> Nearby<'a> {
    /// Arranges n rows of `dimensions` values each (`rows`: n by `dimensions`).
    ///
    /// The result does not depend on the number of threads.
    ///
    /// # Panics
    /// As [`Tree::new`].
    #[must_use]
    pub fn new(rows: &'a [f32], dimensions: usize, params: &NearbyParams) -> Self {
        assert!(rows.len().is_multiple_of(dimensions), "rows must be whole");
        let components = params.components.min(dimensions);
        let projection = Projection::principal(rows, dimensions, components);
        let projected: Vec<f32> = (rows.par_chunks(dimensions))
            .flat_map_iter(|row| projection.apply(row))
            .collect();
        let tree = Tree::new(&projected, components, &TreeParams { components });
        Self {
            rows,
            dimensions,
            projection,
            components,
            projected,
            tree,
            compared: params.compared,
        }
    }

    /// Up to `k` rows near the query that `accept` takes, with their squared distances: ascending by distance, then by
    /// number.
    ///
    /// # Panics
    /// As [`Tree::nearest`].
    #[must_use]
    pub fn find(&self, query: &[f32], k: usize, accept: impl Fn(u32) -> bool) -> Vec<(u32, f32)> {
        let components: Vec<f32> = self.projection.apply(query).collect();
        self.find_projected(query, &components, k, accept)
    }

    /// The same for one of the rows, by its number.
    ///
    /// # Panics
    /// If there is no such row.
    #[must_use]
    pub fn find_for(&self, row: u32, k: usize, accept: impl Fn(u32) -> bool) -> Vec<(u32, f32)> {
        let components = &self.projected[row as usize * self.components..][..self.components];
        self.find_projected(self.row(row), components, k, accept)
    }

    fn find_projected(
        &self,
        query: &[f32],
        components: &[f32],
        k: usize,
        accept: impl Fn(u32) -> bool,
    ) -> Vec<(u32, f32)> {
        let near = self.tree.nearest(components, self.compared * k, accept);
        let mut near: Vec<(u32, f32)> = (near.into_iter())
            .map(|(row, _)| (row, distance_sq(query, self.row(row))))
            .collect();
        near.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        near.truncate(k);
        near
    }

    fn row(&self, row: u32) -> &[f32] {
        &self.rows[row as usize * self.dimensions..][..self.dimensions]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Rng, Stage};

    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "test values")]
    fn what_is_found_is_hardly_farther_than_the_nearest() {
        let mut rng = Rng::new(7, Stage::Matching, 0);
        // Rows of 60 values that follow from 5, as neighborhoods of a texture do.
        let factors: Vec<f64> = (0..300).map(|_| rng.normal()).collect();
        let mut rows = |count: usize| -> Vec<f32> {
            (0..count)
                .flat_map(|_| {
                    let hidden: Vec<f64> = (0..5).map(|_| rng.normal()).collect();
                    let value =
                        |j: usize| (0..5).map(|i| hidden[i] * factors[5 * j + i]).sum::<f64>();
                    (0..60).map(|j| value(j) as f32).collect::<Vec<_>>()
                })
                .collect()
        };
        let (all, queries) = (rows(2000), rows(50));
        let nearby = Nearby::new(&all, 60, &NearbyParams::default());
        let tree = Tree::new(&all, 60, &TreeParams::default());
        for query in queries.chunks(60) {
            let found = nearby.find(query, 3, |row| row % 2 == 0);
            assert!(found.len() == 3 && found.iter().all(|(row, _)| row % 2 == 0));
            assert!(found.is_sorted_by(|a, b| a.1 <= b.1));
            let nearest = tree.nearest(query, 1, |row| row % 2 == 0)[0].1;
            assert!(found[0].1 <= 1.01 * nearest);
        }
        assert_eq!(nearby.find_for(9, 1, |_| true)[0], (9, 0.0));
    }
}
