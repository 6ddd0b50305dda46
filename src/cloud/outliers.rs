//! Stray points: single ones away from the rest, and small groups.

use rayon::prelude::*;

use super::params::OutlierParams;
use super::points::{Neighbors, Points, Spacing, index, median};
use super::signs::Groups;

/// Neighbors whose distances are averaged.
const NEAREST: usize = 8;

/// Normal standard deviations in a median absolute deviation: 1 / Φ⁻¹(3/4).
const MAD_TO_SIGMA: f64 = 1.482_602_218_505_602;

/// Whether each point is stray; the largest group never is.
pub(super) fn stray(
    points: &Points,
    neighbors: &Neighbors,
    spacing: &Spacing,
    gap: f64,
    params: &OutlierParams,
) -> Vec<bool> {
    let mut stray = lonely(points, neighbors, params);
    let small = in_small_groups(points, neighbors, spacing, gap, params.least_group, &stray);
    for (stray, small) in stray.iter_mut().zip(small) {
        *stray |= small;
    }
    stray
}

/// Points that are far from their neighbors, far in terms of these neighbors too, and near to nobody:
/// no other point has them among its nearest ones. The last is what tells a stray point from the first
/// row of a sparse area that begins where a dense one ends.
fn lonely(points: &Points, neighbors: &Neighbors, params: &OutlierParams) -> Vec<bool> {
    let near = |i: usize| neighbors.of(i).iter().take(NEAREST);
    let all = || (0..points.len()).into_par_iter();
    let mean = |i: usize| {
        let row = near(i);
        let count = row.len() as f64;
        row.map(|j| points.distance(index(i), *j)).sum::<f64>() / count
    };
    let means: Vec<f64> = all().map(mean).collect();
    let middle = median(&mut means.clone());
    let mut deviations: Vec<f64> = means.iter().map(|m| (m - middle).abs()).collect();
    let limit = middle + params.deviations * MAD_TO_SIGMA * median(&mut deviations);
    let is_far = |i: usize| {
        let around = || median(&mut near(i).map(|j| means[*j as usize]).collect::<Vec<_>>());
        means[i] > limit && means[i] > params.isolation * around()
    };
    let mut far: Vec<bool> = all().map(is_far).collect();
    let mut wanted = vec![false; points.len()];
    for i in (0..points.len()).filter(|i| !far[*i]) {
        for j in near(i) {
            wanted[*j as usize] = true;
        }
    }
    for (far, wanted) in far.iter_mut().zip(wanted) {
        *far &= !wanted;
    }
    far
}

/// Points of small groups: neighbors are in one group if they are within the gap by the spacing of
/// both.
fn in_small_groups(
    points: &Points,
    neighbors: &Neighbors,
    spacing: &Spacing,
    gap: f64,
    least: usize,
    stray: &[bool],
) -> Vec<bool> {
    let mut groups = Groups::new(points.len());
    for i in 0..points.len() {
        for &j in neighbors.of(i).iter().take(NEAREST) {
            let narrow = spacing.local[i].min(spacing.local[j as usize]);
            let apart = stray[i] || stray[j as usize];
            if !apart && points.distance(index(i), j) <= gap * narrow {
                groups.join(index(i), j, false);
            }
        }
    }
    let of: Vec<usize> = (0..points.len())
        .map(|i| groups.find(index(i)).0 as usize)
        .collect();
    let mut size = vec![0usize; points.len()];
    for &root in &of {
        size[root] += 1;
    }
    let largest = size.iter().copied().max().unwrap_or(0);
    of.iter()
        .map(|root| size[*root] < least.min(largest))
        .collect()
}
