//! A target's neighborhood, in its own frame.

use nalgebra::{Point3, Vector3};

use crate::neighborhood::Frame;

/// A known neighbor of a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbor {
    /// Its foot, from the target's foot, in the target's frame.
    pub foot: Vector3<f64>,
    /// The point on the relief, from the target's foot, in the target's frame.
    pub point: Vector3<f64>,
    /// Its colour in [0, 1], where it has one.
    pub color: Option<[f64; 3]>,
    /// Gaussian weight.
    pub weight: f64,
}

/// What is known around a target.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Query {
    /// Known neighbors, heaviest first.
    neighbors: Vec<Neighbor>,
}

impl Query {
    /// From the neighbors in any order. The heaviest come first, so that a bad candidate is found out
    /// early.
    #[must_use]
    pub fn new(mut neighbors: Vec<Neighbor>) -> Self {
        neighbors.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        Self { neighbors }
    }

    /// The neighbors, heaviest first.
    #[must_use]
    pub fn neighbors(&self) -> &[Neighbor] {
        &self.neighbors
    }
}

impl Neighbor {
    /// A neighbor with the given foot and point on the relief, as seen from a target at
    /// `target_foot` with `frame`; `weigh` turns the squared distance of the feet into a weight.
    #[must_use]
    pub fn new(
        target_foot: &Point3<f64>,
        frame: &Frame,
        foot: &Point3<f64>,
        point: &Point3<f64>,
        color: Option<[f64; 3]>,
        weigh: impl Fn(f64) -> f64,
    ) -> Self {
        let to_foot = foot - target_foot;
        Self {
            foot: frame.to_local(&to_foot),
            point: frame.to_local(&(point - target_foot)),
            color,
            weight: weigh(to_foot.norm_squared()),
        }
    }
}
