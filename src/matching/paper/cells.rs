//! The cells of a cubic lattice that are near a surface, numbered, by hashing.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Bits per axis of a cell's key.
const KEY_BITS: u32 = 21;

/// A triangle, and how far around it (along each axis) belongs to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ThickTriangle {
    pub(super) corners: [Point3<f64>; 3],
    pub(super) margin: f64,
}

/// Numbers of the cells near a surface.
#[derive(Debug)]
pub(super) struct Cells {
    origin: Point3<f64>,
    cell: f64,
    inverse_cell: f64,
    /// Key of the cell + 1 (0 where free) and its number; open addressing by the key.
    slots: Vec<(u64, u32)>,
    /// By number.
    keys: Vec<u64>,
}

impl Cells {
    /// The cells that any of the triangles may reach into, with sides of length `cell` or as many as
    /// fit in a key.
    ///
    /// # Panics
    /// If these are 2³² cells or more.
    pub(super) fn new(triangles: &[ThickTriangle], cell: f64) -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY].map(|x| Point3::from([x; 3]));
        let [low, high] = (triangles.iter().map(ThickTriangle::bounds))
            .fold(none, |[low, high], b| [low.inf(&b[0]), high.sup(&b[1])]);
        let most_cells = f64::from(1u32 << KEY_BITS) - 2.0;
        let cell = cell.max((high - low).amax() / most_cells);
        let mut cells = Self {
            origin: low,
            cell,
            inverse_cell: 1.0 / cell,
            slots: Vec::new(),
            keys: Vec::new(),
        };
        let mut keys = Vec::new();
        for triangle in triangles {
            let range = triangle.bounds().map(|corner| cells.coordinates(&corner));
            cells.reached(triangle, range, &mut keys);
        }
        keys.par_sort_unstable();
        keys.dedup();
        cells.insert(keys);
        cells
    }

    /// Appends the cells from `low` to `high` (inclusive) that the triangle reaches, by halving the
    /// range: a huge oblique triangle reaches few of the cells of its bounding box.
    fn reached(&self, triangle: &ThickTriangle, [low, high]: [[u64; 3]; 2], keys: &mut Vec<u64>) {
        let sides = [0, 1, 2].map(|i| high[i] - low[i] + 1);
        let half = Vector3::from(sides.map(|n| 0.5 * n as f64 * self.cell));
        let corner = Vector3::from(low.map(|n| n as f64 * self.cell));
        if !triangle.meets_box(&(self.origin + corner + half), &half) {
            return;
        }
        let longest = (0..3).max_by_key(|i| sides[*i]).unwrap_or(0);
        if sides[longest] == 1 {
            keys.push(key(low));
            return;
        }
        let (mut end, mut start) = (high, low);
        end[longest] = low[longest] + sides[longest] / 2 - 1;
        start[longest] = end[longest] + 1;
        self.reached(triangle, [low, end], keys);
        self.reached(triangle, [start, high], keys);
    }

    fn insert(&mut self, keys: Vec<u64>) {
        let mask = (2 * keys.len()).next_power_of_two() - 1;
        self.slots = vec![(0, 0); mask + 1];
        for (number, key) in keys.iter().enumerate() {
            let mut slot = hash(*key) & mask;
            while self.slots[slot].0 != 0 {
                slot = (slot + 1) & mask;
            }
            let number = u32::try_from(number).expect("fewer than 2^32 cells");
            self.slots[slot] = (key + 1, number);
        }
        self.keys = keys;
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.keys.len()
    }

    /// Length of a cell's sides.
    pub(super) fn side(&self) -> f64 {
        self.cell
    }

    /// Center of the cell with the given number.
    pub(super) fn center(&self, number: usize) -> Point3<f64> {
        let mask = (1u64 << KEY_BITS) - 1;
        let coordinate = |i: u32| ((self.keys[number] >> (i * KEY_BITS)) & mask) as f64 + 0.5;
        self.origin + Vector3::new(coordinate(0), coordinate(1), coordinate(2)) * self.cell
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturating; what is outside the grid is not found there"
    )]
    fn coordinates(&self, p: &Point3<f64>) -> [u64; 3] {
        // By way of i64, whose conversion is one instruction.
        [0, 1, 2].map(|i| ((p[i] - self.origin[i]) * self.inverse_cell) as i64 as u64)
    }

    /// Number of the cell that `p` is in; `None` far from the surface.
    #[inline]
    pub(super) fn find(&self, p: &Point3<f64>) -> Option<usize> {
        if p.x < self.origin.x || p.y < self.origin.y || p.z < self.origin.z {
            return None;
        }
        let cell = self.coordinates(p);
        if cell[0] | cell[1] | cell[2] >= 1 << KEY_BITS {
            return None;
        }
        let wanted = key(cell) + 1;
        let mask = self.slots.len().checked_sub(1)?;
        let mut at = hash(wanted - 1) & mask;
        loop {
            match self.slots[at] {
                (key, number) if key == wanted => return Some(number as usize),
                (0, _) => return None,
                _ => at = (at + 1) & mask,
            }
        }
    }
}

impl ThickTriangle {
    fn bounds(&self) -> [Point3<f64>; 2] {
        let [a, b, c] = &self.corners;
        let margin = Vector3::repeat(self.margin);
        [a.inf(b).inf(c) - margin, a.sup(b).sup(c) + margin]
    }

    /// Whether the triangle and a box with the given center and half sides, grown by the margin, are
    /// not separated by a plane (but for rounding, for which some are kept that are): the theorem
    /// of separating axes (Ericson, *Real-Time Collision Detection*, 2005, §5.2.9).
    fn meets_box(&self, center: &Point3<f64>, half: &Vector3<f64>) -> bool {
        let half = half * (1.0 + 1e-9) + Vector3::repeat(self.margin);
        let corners = self.corners.map(|c| c - center);
        let edges = [0, 1, 2].map(|i| corners[(i + 1) % 3] - corners[i]);
        let units = [Vector3::x(), Vector3::y(), Vector3::z()];
        let separates = |axis: &Vector3<f64>| {
            let [a, b, c] = corners.map(|corner| corner.dot(axis));
            let reach = half.dot(&axis.abs()) * (1.0 + 1e-9);
            a.min(b).min(c) > reach || a.max(b).max(c) < -reach
        };
        !(units.iter().any(separates)
            || separates(&edges[0].cross(&edges[1]))
            || (edges.iter()).any(|e| units.iter().any(|u| separates(&e.cross(u)))))
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

    fn point() -> impl Strategy<Value = Point3<f64>> {
        [-2.0..2.0f64, -2.0..2.0, -2.0..2.0].prop_map(Point3::from)
    }

    proptest! {
        #[test]
        fn every_point_within_the_margin_is_in_a_cell(
            corners in [point(), point(), point()],
            margin in 1e-3..0.3f64,
            cell in 0.1..1.0f64,
            places in prop::collection::vec(
                ([0.0..1.0f64, 0.0..1.0], [-1.0..1.0f64, -1.0..1.0, -1.0..1.0]), 20),
        ) {
            let cells = Cells::new(&[ThickTriangle { corners, margin }], cell);
            let [a, b, c] = corners;
            for ([s, t], offset) in places {
                let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                let on = a + (b - a) * s + (c - a) * t;
                prop_assert!(cells.find(&(on + Vector3::from(offset) * margin)).is_some());
            }
        }
    }

    #[test]
    fn a_huge_oblique_triangle_reaches_few_cells_of_its_bounding_box() {
        let corners = [[0.0; 3], [200.0, 0.0, 200.0], [0.0, 200.0, 200.0]].map(Point3::from);
        let triangle = ThickTriangle {
            corners,
            margin: 1e-3,
        };
        // Its plane crosses about three cells over each of the 20 000 squares under it.
        assert!(Cells::new(&[triangle], 1.0).len() < 80_000);
    }
}
