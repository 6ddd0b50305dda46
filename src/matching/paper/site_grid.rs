//! Nearest site on a surface in constant time: space is cut into cells, and each cell near the
//! surface lists every site that is nearest to some point in it.

use nalgebra::Point3;
use rayon::prelude::*;

use crate::mesh::PointTree;

/// Cell size over typical distance of sites. Smaller cells list fewer sites but are more.
const CELL_PER_SPACING: f64 = 0.7;

/// Bits per axis of a cell's key.
const KEY_BITS: u32 = 21;

/// Sites by cell.
#[derive(Debug)]
pub(super) struct SiteGrid {
    origin: Point3<f64>,
    inverse_cell: f64,
    /// Open addressing by the cells' keys.
    slots: Vec<Slot>,
    /// Sites of all cells, end to end.
    sites: Vec<u32>,
    points: Vec<Point3<f64>>,
}

/// A cell's place in the list of sites.
#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    /// Key of the cell + 1, or 0 where free.
    key: u64,
    start: u32,
    len: u32,
}

impl SiteGrid {
    /// Over `points` (#S); only cells that meet one of `boxes` (low and high corner) are made, so
    /// queries must fall into those.
    pub(super) fn new(points: Vec<Point3<f64>>, spacing: f64, boxes: &[[Point3<f64>; 2]]) -> Self {
        let low = (boxes.iter()).fold(Point3::from([f64::INFINITY; 3]), |low, b| low.inf(&b[0]));
        let high = (boxes.iter()).fold(low, |high, b| high.sup(&b[1]));
        // The longest side must fit in a key.
        let most_cells = f64::from(1u32 << KEY_BITS) - 2.0;
        let cell = (spacing * CELL_PER_SPACING).max((high - low).amax() / most_cells);
        let mut grid = Self {
            origin: low,
            inverse_cell: 1.0 / cell,
            slots: Vec::new(),
            sites: Vec::new(),
            points,
        };
        let mut keys: Vec<u64> = Vec::new();
        for [low, high] in boxes {
            let (from, to) = (grid.cell_of(low), grid.cell_of(high));
            for x in from[0]..=to[0] {
                for y in from[1]..=to[1] {
                    for z in from[2]..=to[2] {
                        keys.push(key([x, y, z]));
                    }
                }
            }
        }
        keys.par_sort_unstable();
        keys.dedup();
        grid.list_sites(&keys, cell);
        grid
    }

    fn list_sites(&mut self, keys: &[u64], cell: f64) {
        if keys.is_empty() {
            return;
        }
        let tree = PointTree::new(&self.points);
        let half_diagonal = 0.5 * 3f64.sqrt() * cell;
        let rows: Vec<Vec<u32>> = (keys.par_iter())
            .map(|key| {
                let center = self.center(*key, cell);
                let nearest = tree.nearest(&center).distance_sq.sqrt();
                // For any point of the cell the nearest site is at most this far from the center.
                let reach = (nearest + 2.0 * half_diagonal) * (1.0 + 1e-9);
                self.undominated(tree.within(&center, reach), &center, 0.5 * cell)
            })
            .collect();
        let mask = (2 * keys.len()).next_power_of_two() - 1;
        self.slots = vec![Slot::default(); mask + 1];
        for (key, row) in keys.iter().zip(&rows) {
            let mut slot = hash(*key) & mask;
            while self.slots[slot].key != 0 {
                slot = (slot + 1) & mask;
            }
            let index = |n: usize| u32::try_from(n).expect("fewer than 2^32 sites in all cells");
            self.slots[slot] = Slot {
                key: key + 1,
                start: index(self.sites.len()),
                len: index(row.len()),
            };
            self.sites.extend_from_slice(row);
        }
    }

    /// Without the sites that are nowhere nearest in the cell: another is nearer to all its corners,
    /// and so to all of it.
    fn undominated(&self, mut sites: Vec<u32>, center: &Point3<f64>, half: f64) -> Vec<u32> {
        sites.sort_unstable();
        // Rounding: corners a little outside.
        let half = half * (1.0 + 1e-6);
        let corner = |i: usize| {
            let sign = |bit: usize| if i >> bit & 1 == 1 { half } else { -half };
            center + nalgebra::Vector3::new(sign(0), sign(1), sign(2))
        };
        let corners: [Point3<f64>; 8] = std::array::from_fn(corner);
        let distances: Vec<[f64; 8]> = (sites.iter())
            .map(|site| corners.map(|c| (c - self.points[*site as usize]).norm_squared()))
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

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturating; what is outside the grid is not found there"
    )]
    fn cell_of(&self, p: &Point3<f64>) -> [u64; 3] {
        // By way of i64, whose conversion is one instruction.
        [0, 1, 2].map(|i| ((p[i] - self.origin[i]) * self.inverse_cell) as i64 as u64)
    }

    fn center(&self, key: u64, cell: f64) -> Point3<f64> {
        let mask = (1u64 << KEY_BITS) - 1;
        let coordinate = |i: u32| ((key >> (i * KEY_BITS)) & mask) as f64 + 0.5;
        self.origin + nalgebra::Vector3::new(coordinate(0), coordinate(1), coordinate(2)) * cell
    }

    /// The site nearest to `p`, ties to the lower index; `None` far from the boxes.
    #[inline]
    pub(super) fn nearest(&self, p: &Point3<f64>) -> Option<u32> {
        let row = self.cell(p)?;
        let (first, others) = row.split_first()?;
        if others.is_empty() {
            return Some(*first);
        }
        let mut best = (f64::INFINITY, *first);
        for site in row {
            let distance_sq = (self.points[*site as usize] - p).norm_squared();
            if distance_sq < best.0 {
                best = (distance_sq, *site);
            }
        }
        Some(best.1)
    }

    /// The sites of the cell that `p` is in; `None` far from the boxes.
    #[inline]
    fn cell(&self, p: &Point3<f64>) -> Option<&[u32]> {
        if p.x < self.origin.x || p.y < self.origin.y || p.z < self.origin.z {
            return None;
        }
        let cell = self.cell_of(p);
        if cell[0] | cell[1] | cell[2] >= 1 << KEY_BITS {
            return None;
        }
        let wanted = key(cell) + 1;
        let mask = self.slots.len().checked_sub(1)?;
        let mut at = hash(wanted - 1) & mask;
        loop {
            let slot = &self.slots[at];
            if slot.key == wanted {
                return self
                    .sites
                    .get(slot.start as usize..)?
                    .get(..slot.len as usize);
            }
            if slot.key == 0 {
                return None;
            }
            at = (at + 1) & mask;
        }
    }
}

fn key([x, y, z]: [u64; 3]) -> u64 {
    x | (y << KEY_BITS) | (z << (2 * KEY_BITS))
}

/// Fibonacci hashing (Knuth, *The Art of Computer Programming* 3, §6.4).
fn hash(key: u64) -> usize {
    (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20) as usize
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
            let whole = [Point3::origin(), Point3::new(3.0, 3.0, 0.3)];
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
        let grid = SiteGrid::new(vec![point], 0.1, &[[point, point]]);
        assert_eq!(grid.nearest(&point), Some(0));
        assert_eq!(grid.nearest(&Point3::new(9.0, 1.0, 1.0)), None);
        assert_eq!(grid.nearest(&Point3::new(-9.0, 1.0, 1.0)), None);
        assert_eq!(grid.nearest(&Point3::new(1e300, 1.0, 1.0)), None);
    }
}
