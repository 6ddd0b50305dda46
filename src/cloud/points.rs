//! The points in coordinates fit to compute with, each place once, and who is near whom.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use rayon::prelude::*;

use super::CloudError;
use crate::mesh::{PointTree, first_at_place, spatial_order};

/// Points nearer to one line than this share of the cloud's extent are on the line, as in
/// [`crate::base`]: rounding of coordinates a million times the extent leaves 1e-10.
const COLLINEAR: f64 = 1e-9;

/// Different places, along a curve through space, in units of about the cloud's size around the
/// middle of its box.
#[derive(Debug)]
pub(super) struct Points {
    pub(super) positions: Vec<Point3<f64>>,
    /// The row of each in the scan.
    pub(super) rows: Vec<u32>,
    /// The unit, in the scan's: a power of two, so that dividing by it rounds nothing.
    pub(super) unit: f64,
}

impl Points {
    /// The different places among finite `positions`, and for each row the point at its place.
    pub(super) fn new(positions: &[Point3<f64>]) -> Result<(Self, Vec<u32>), CloudError> {
        let Some(&first) = positions.first() else {
            return Err(CloudError::TooFewPoints { found: 0 });
        };
        let (low, high) = (positions.iter()).fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
        // Halved before they are added or subtracted, so that nothing overflows.
        let (half_low, half_high) = (low.coords * 0.5, high.coords * 0.5);
        let largest = (half_high - half_low).amax();
        if largest == 0.0 {
            return Err(CloudError::Coincident(positions.len()));
        }
        let unit = largest.log2().floor().exp2();
        let middle = half_low + half_high;
        let near: Vec<Point3<f64>> = (positions.par_iter())
            .map(|p| Point3::from((p.coords - middle) / unit))
            .collect();
        let first_row = first_at_place(&near);
        let different = (0u32..)
            .zip(&first_row)
            .filter(|(row, first)| row == *first)
            .map(|(row, _)| row);
        let order = spatial_order(&near, different.collect());
        let mut place = vec![0u32; positions.len()];
        for (point, row) in (0u32..).zip(&order) {
            place[*row as usize] = point;
        }
        let points = Self {
            positions: order.iter().map(|row| near[*row as usize]).collect(),
            rows: order,
            unit,
        };
        if points.positions.len() < 3 {
            let found = points.positions.len();
            return Err(CloudError::TooFewPoints { found });
        }
        if is_collinear(&points.positions) {
            return Err(CloudError::Collinear);
        }
        let point_of_row = first_row.iter().map(|row| place[*row as usize]).collect();
        Ok((points, point_of_row))
    }

    pub(super) fn len(&self) -> usize {
        self.positions.len()
    }

    /// Distance of two points.
    pub(super) fn distance(&self, a: u32, b: u32) -> f64 {
        (self.positions[a as usize] - self.positions[b as usize]).norm()
    }

    /// Those that `keep` tells, and for each of the present ones its new index.
    fn only(&self, keep: &[bool]) -> (Self, Vec<u32>) {
        let mut new_index = vec![u32::MAX; self.len()];
        let (mut positions, mut rows) = (Vec::new(), Vec::new());
        for (i, _) in keep.iter().enumerate().filter(|(_, keep)| **keep) {
            new_index[i] = index(positions.len());
            positions.push(self.positions[i]);
            rows.push(self.rows[i]);
        }
        let unit = self.unit;
        let points = Self {
            positions,
            rows,
            unit,
        };
        (points, new_index)
    }
}

fn is_collinear(points: &[Point3<f64>]) -> bool {
    let mean = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
    let matrix: Matrix3<f64> = (points.iter())
        .map(|p| (p.coords - mean) * (p.coords - mean).transpose())
        .sum();
    let eigen = SymmetricEigen::new(matrix);
    let along = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    (points.iter().map(|p| p.coords - mean))
        .all(|v| (v - along * along.dot(&v)).norm() <= COLLINEAR)
}

/// An index of a point: their number was checked at the door.
pub(super) fn index(i: usize) -> u32 {
    u32::try_from(i).expect("the number of points was checked")
}

/// For each point the indices of its nearest others, nearest first.
#[derive(Debug)]
pub(super) struct Neighbors {
    tree: PointTree,
    rows: Vec<u32>,
    count: usize,
}

impl Neighbors {
    pub(super) fn new(points: &Points, count: usize) -> Self {
        let count = count.min(points.len() - 1);
        let tree = PointTree::new(&points.positions);
        let rows = (0..points.len())
            .into_par_iter()
            .flat_map_iter(|i| nearest(&tree, points, i, count))
            .collect();
        Self { tree, rows, count }
    }

    pub(super) fn of(&self, point: usize) -> &[u32] {
        &self.rows[point * self.count..(point + 1) * self.count]
    }

    /// As [`of`](Self::of), another number of them.
    pub(super) fn more(&self, points: &Points, point: usize, count: usize) -> Vec<u32> {
        nearest(&self.tree, points, point, count.min(points.len() - 1))
    }

    /// The points without the stray ones, their neighbors, and the new index of each.
    pub(super) fn without(self, points: &Points, stray: &[bool]) -> (Points, Self, Vec<u32>) {
        let keep: Vec<bool> = stray.iter().map(|stray| !stray).collect();
        let (kept, new_index) = points.only(&keep);
        let count = self.count.min(kept.len() - 1);
        let tree = PointTree::new(&kept.positions);
        let row = |i: usize| {
            let old = &self.of(i)[..count];
            if old.iter().all(|j| keep[*j as usize]) {
                old.iter().map(|j| new_index[*j as usize]).collect()
            } else {
                nearest(&tree, &kept, new_index[i] as usize, count)
            }
        };
        let rows = (0..points.len())
            .into_par_iter()
            .filter(|i| keep[*i])
            .flat_map_iter(row)
            .collect();
        (kept, Self { tree, rows, count }, new_index)
    }
}

/// The `count` points nearest to a point, itself aside.
fn nearest(tree: &PointTree, points: &Points, point: usize, count: usize) -> Vec<u32> {
    let found = tree.nearest_n(&points.positions[point], count + 1);
    // Places so near that their squared distance is zero may come before the point itself.
    let mut others: Vec<u32> = (found.iter())
        .filter(|n| n.index != point)
        .map(|n| index(n.index))
        .collect();
    others.truncate(count);
    others
}

/// How far apart points are.
#[derive(Debug)]
pub(super) struct Spacing {
    /// Median distance to the nearest neighbor.
    pub(super) median: f64,
    /// #V local spacing, see [`Spacing::new`].
    pub(super) local: Vec<f64>,
}

/// The neighbor whose distance is a point's reach: in a triangular grid that is one spacing, in a
/// square grid 1.4, in points without order 1.4 times the mean one.
const REACH_NEIGHBOR: usize = 6;

impl Spacing {
    /// The local spacing is the median, over a point and its nearest neighbors, of the distance to the
    /// sixth neighbor: it follows changes of density within a few points, but a single point far from
    /// others does not spread it.
    pub(super) fn new(points: &Points, neighbors: &Neighbors) -> Self {
        let distance = |i: usize, n: usize| {
            let row = neighbors.of(i);
            points.distance(index(i), row[n.min(row.len() - 1)])
        };
        let all = || (0..points.len()).into_par_iter();
        let nearest: Vec<f64> = all().map(|i| distance(i, 0)).collect();
        let reach: Vec<f64> = all().map(|i| distance(i, REACH_NEIGHBOR - 1)).collect();
        let smooth = |i: usize| {
            let row = neighbors.of(i).iter().take(2 * REACH_NEIGHBOR);
            let around = row.map(|j| reach[*j as usize]);
            median(&mut around.chain([reach[i]]).collect::<Vec<_>>())
        };
        Self {
            median: median(&mut nearest.clone()),
            local: all().map(smooth).collect(),
        }
    }
}

/// The middle value, the higher of two; 0 of none.
pub(super) fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
