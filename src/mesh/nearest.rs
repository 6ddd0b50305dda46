//! Nearest points in space.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Point3;

/// A k-d tree over points, built once.
#[derive(Debug)]
pub struct PointTree {
    tree: ImmutableKdTree<f64, 3>,
    points: usize,
}

/// A point found by [`PointTree`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Index of the point in the slice that the tree was built from.
    pub index: usize,
    /// Squared distance to the query.
    pub distance_sq: f64,
}

impl PointTree {
    /// # Panics
    /// If a coordinate is not finite, there are none, or there are 2³² points or more.
    #[must_use]
    pub fn new(points: &[Point3<f64>]) -> Self {
        let points: Vec<[f64; 3]> = points.iter().map(|p| p.coords.into()).collect();
        Self {
            tree: ImmutableKdTree::new_from_slice(&points)
                .expect("an immutable tree holds any finite points"),
            points: points.len(),
        }
    }

    /// The point nearest to `query`.
    #[must_use]
    pub fn nearest(&self, query: &Point3<f64>) -> Nearest {
        let found = (self.tree.query(&query.coords.into()))
            .nearest_one::<SquaredEuclidean<f64>>()
            .execute();
        Nearest {
            index: found.item as usize,
            distance_sq: found.distance,
        }
    }

    /// The `count` points nearest to `query` (all, if there are fewer), nearest first.
    #[must_use]
    pub fn nearest_n(&self, query: &Point3<f64>, count: usize) -> Vec<Nearest> {
        let Some(count) = NonZero::new(count.min(self.points)) else {
            return Vec::new();
        };
        (self.tree.query(&query.coords.into()))
            .nearest_n::<SquaredEuclidean<f64>>(count)
            .execute()
            .into_iter()
            .map(|found| Nearest {
                index: found.item as usize,
                distance_sq: found.distance,
            })
            .collect()
    }

    /// Indices of all points within `distance` of `query`, in no stated order.
    #[must_use]
    pub fn within(&self, query: &Point3<f64>, distance: f64) -> Vec<u32> {
        (self.tree.query(&query.coords.into()))
            .within::<SquaredEuclidean<f64>>(distance * distance)
            .unsorted()
            .execute()
            .into_iter()
            .map(|found| found.item)
            .collect()
    }
}
