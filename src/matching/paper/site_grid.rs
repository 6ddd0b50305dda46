//! Nearest site on a surface in constant time: space is cut into cells, and each cell near the
//! surface lists every site that is nearest to some point in it.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::mesh::PointTree;

use super::cells::{Cells, ThickTriangle};

/// Cell size over typical distance of sites. Smaller cells list fewer sites but are more.
const CELL_PER_SPACING: f64 = 0.7;

/// Sites by cell.
#[derive(Debug)]
pub(super) struct SiteGrid {
    /// Labelled with the start of each cell's list.
    cells: Cells,
    /// Lists of the sites of all cells, end to end, each after its length.
    lists: Vec<u32>,
    points: Vec<Point3<f64>>,
}

impl SiteGrid {
    /// Over `points` (#S); only cells that meet one of `triangles` are made, so queries must fall
    /// into those.
    ///
    /// # Panics
    /// If all cells together list 2³² sites or more.
    pub(super) fn new(points: Vec<Point3<f64>>, spacing: f64, triangles: &[ThickTriangle]) -> Self {
        let mut cells = Cells::new(triangles, spacing * CELL_PER_SPACING);
        let index = |n: usize| u32::try_from(n).expect("fewer than 2^32 sites in all cells");
        let (mut starts, mut lists) = (Vec::new(), Vec::new());
        for row in nearest_somewhere(&points, &cells, 0.0) {
            starts.push(index(lists.len()));
            lists.push(index(row.len()));
            lists.extend_from_slice(&row);
        }
        cells.relabel(|cell| starts[cell]);
        Self {
            cells,
            lists,
            points,
        }
    }

    /// The sites' points (#S).
    pub(super) fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// No point with a nearest site is farther than this from the triangles' margins.
    pub(super) fn reach(&self) -> f64 {
        3f64.sqrt() * self.cells.side()
    }

    /// The site nearest to `p`, ties to the lower index; `None` far from the triangles.
    #[inline]
    pub(super) fn nearest(&self, p: &Point3<f64>) -> Option<u32> {
        Some(self.nearest_in(self.list(p)?, p))
    }

    /// Where the list of the sites that can be nearest to `p` starts; `None` far from the triangles.
    #[inline]
    pub(super) fn list(&self, p: &Point3<f64>) -> Option<u32> {
        self.cells.find(p)
    }

    /// The site nearest to `p` in its list, ties to the lower index.
    #[inline]
    pub(super) fn nearest_in(&self, list: u32, p: &Point3<f64>) -> u32 {
        let start = list as usize + 1;
        let sites = &self.lists[start..start + self.lists[start - 1] as usize];
        let mut best = (f64::INFINITY, sites[0]);
        if sites.len() > 1 {
            for site in sites {
                let distance_sq = (self.points[*site as usize] - p).norm_squared();
                if distance_sq < best.0 {
                    best = (distance_sq, *site);
                }
            }
        }
        best.1
    }
}

/// By cell, in rising order, every one of `points` that is the nearest of all to some place in the
/// cell or at most `around` away from it.
pub(super) fn nearest_somewhere(
    points: &[Point3<f64>],
    cells: &Cells,
    around: f64,
) -> Vec<Vec<u32>> {
    if cells.len() == 0 {
        return Vec::new();
    }
    let tree = PointTree::new(points);
    let half = 0.5 * cells.side() + around;
    (0..cells.len())
        .into_par_iter()
        .map(|cell| {
            let center = cells.center(cell);
            let nearest = tree.nearest(&center).distance_sq.sqrt();
            // For any place in the cell the nearest site is at most this far from the center.
            let reach = (nearest + 2.0 * 3f64.sqrt() * half) * (1.0 + 1e-9);
            undominated(points, tree.within(&center, reach), &center, half)
        })
        .collect()
}

/// Without the sites that are nowhere nearest in the cube: another is nearer to all its corners, and
/// so to all of it.
fn undominated(
    points: &[Point3<f64>],
    mut sites: Vec<u32>,
    center: &Point3<f64>,
    half: f64,
) -> Vec<u32> {
    sites.sort_unstable();
    // Rounding: corners a little outside.
    let half = half * (1.0 + 1e-6);
    let corner = |i: usize| {
        let sign = |bit: usize| if i >> bit & 1 == 1 { half } else { -half };
        center + Vector3::new(sign(0), sign(1), sign(2))
    };
    let corners: [Point3<f64>; 8] = std::array::from_fn(corner);
    let distances: Vec<[f64; 8]> = (sites.iter())
        .map(|site| corners.map(|c| (c - points[*site as usize]).norm_squared()))
        .collect();
    let dominated = |j: usize| {
        let beats = |i: &[f64; 8]| i.iter().zip(&distances[j]).all(|(i, j)| i < j);
        distances.iter().any(beats)
    };
    (sites.iter().enumerate())
        .filter(|(j, _)| !dominated(*j))
        .map(|(_, site)| *site)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nearest_matches_a_search_through_all(
            points in prop::collection::vec([0.0..3.0f64, 0.0..3.0, 0.0..0.3], 1..60),
            queries in prop::collection::vec([0.0..3.0f64, 0.0..3.0, 0.0..0.3], 20),
        ) {
            let points: Vec<Point3<f64>> = points.into_iter().map(Point3::from).collect();
            let whole = ThickTriangle {
                corners: [[0.0; 3], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]].map(Point3::from),
                margin: 0.3,
            };
            let grid = SiteGrid::new(points.clone(), 0.4, &[whole]);
            for q in queries.into_iter().map(Point3::from) {
                let plain = (points.iter().zip(0u32..))
                    .min_by(|a, b| (a.0 - q).norm_squared().total_cmp(&(b.0 - q).norm_squared()))
                    .map(|(_, i)| i);
                prop_assert_eq!(grid.nearest(&q), plain);
            }
        }
    }

    #[test]
    fn far_away_there_is_none() {
        let point = Point3::new(1.0, 1.0, 1.0);
        let triangle = ThickTriangle {
            corners: [point; 3],
            margin: 0.0,
        };
        let grid = SiteGrid::new(vec![point], 0.1, &[triangle]);
        assert_eq!(grid.nearest(&point), Some(0));
        assert_eq!(grid.nearest(&Point3::new(9.0, 1.0, 1.0)), None);
        assert_eq!(grid.nearest(&Point3::new(-9.0, 1.0, 1.0)), None);
        assert_eq!(grid.nearest(&Point3::new(1e300, 1.0, 1.0)), None);
    }
}
