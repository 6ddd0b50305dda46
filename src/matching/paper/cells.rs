//! The cells of a cubic lattice that are near a surface, numbered: bricks of cells by hashing, so that
//! cells near each other are near each other in memory, too.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Bits per axis of a cell's coordinates.
const AXIS_BITS: u32 = 21;

/// Bits per axis of a cell's place in its brick.
const BRICK_BITS: u32 = 2;

/// Cells in a brick.
const BRICK: usize = 1 << (3 * BRICK_BITS);

/// Label of a cell that there is not.
const NO_CELL: u32 = u32::MAX;

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
    /// Key of the brick + 1 (0 where free) and its number; open addressing by the key.
    slots: Vec<(u64, u32)>,
    /// By brick, number or label of each of its cells.
    bricks: Vec<[u32; BRICK]>,
    /// Keys of the cells, by number: first the brick's, then the place in it.
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
        let most_cells = f64::from(1u32 << AXIS_BITS) - 2.0;
        let cell = cell.max((high - low).amax() / most_cells);
        let mut cells = Self {
            origin: low,
            cell,
            inverse_cell: 1.0 / cell,
            slots: Vec::new(),
            bricks: Vec::new(),
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
        let mut numbers = 0u32..NO_CELL;
        for same in keys.chunk_by(|a, b| brick_of(*a) == brick_of(*b)) {
            let mut brick = [NO_CELL; BRICK];
            for key in same {
                brick[place_in_brick(*key)] = numbers.next().expect("fewer than 2^32 - 1 cells");
            }
            self.bricks.push(brick);
        }
        let mask = (2 * self.bricks.len()).next_power_of_two() - 1;
        self.slots = vec![(0, 0); mask + 1];
        let bricks = keys.chunk_by(|a, b| brick_of(*a) == brick_of(*b));
        for (brick, number) in bricks.map(|same| brick_of(same[0])).zip(0u32..) {
            let mut slot = hash(brick) & mask;
            while self.slots[slot].0 != 0 {
                slot = (slot + 1) & mask;
            }
            self.slots[slot] = (brick + 1, number);
        }
        self.keys = keys;
    }

    /// Has [`find`](Self::find) give something else in place of each number.
    pub(super) fn relabel(&mut self, label: impl Fn(usize) -> u32) {
        for cell in self.bricks.iter_mut().flatten() {
            if *cell != NO_CELL {
                *cell = label(*cell as usize);
            }
        }
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
        let middle = coordinates_of(self.keys[number]).map(|n| n as f64 + 0.5);
        self.origin + Vector3::from(middle) * self.cell
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

    /// Number of the cell that `p` is in, or what it was relabelled to; `None` far from the surface.
    #[inline]
    pub(super) fn find(&self, p: &Point3<f64>) -> Option<u32> {
        if p.x < self.origin.x || p.y < self.origin.y || p.z < self.origin.z {
            return None;
        }
        let cell = self.coordinates(p);
        if cell[0] | cell[1] | cell[2] >= 1 << AXIS_BITS {
            return None;
        }
        let key = key(cell);
        let wanted = brick_of(key) + 1;
        let mask = self.slots.len().checked_sub(1)?;
        let mut at = hash(wanted - 1) & mask;
        loop {
            match self.slots[at] {
                (brick, number) if brick == wanted => {
                    let label = self.bricks[number as usize][place_in_brick(key)];
                    return (label != NO_CELL).then_some(label);
                }
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
    let mask = (1 << BRICK_BITS) - 1;
    let join = |[x, y, z]: [u64; 3], bits: u32| x | (y << bits) | (z << (2 * bits));
    let brick = join([x, y, z].map(|n| n >> BRICK_BITS), AXIS_BITS - BRICK_BITS);
    (brick << (3 * BRICK_BITS)) | join([x, y, z].map(|n| n & mask), BRICK_BITS)
}

fn coordinates_of(key: u64) -> [u64; 3] {
    let part = |joined: u64, bits: u32, axis: u32| (joined >> (axis * bits)) & ((1 << bits) - 1);
    [0, 1, 2].map(|axis| {
        let brick = part(brick_of(key), AXIS_BITS - BRICK_BITS, axis);
        (brick << BRICK_BITS) | part(key, BRICK_BITS, axis)
    })
}

fn brick_of(key: u64) -> u64 {
    key >> (3 * BRICK_BITS)
}

#[expect(clippy::cast_possible_truncation, reason = "only the last bits count")]
fn place_in_brick(key: u64) -> usize {
    key as usize % BRICK
}

/// Fibonacci hashing (Knuth, *The Art of Computer Programming* 3, §6.4).
fn hash(key: u64) -> usize {
    (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20) as usize
}

#[cfg(test)]
mod tests {
    use super::super::tests::point;
    use super::*;
    use proptest::prelude::*;

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
        // Over each of the 20 000 squares under it, it rises by two cells and so reaches four at
        // most; some more along the diagonal side. The bounding box has eight million.
        let count = Cells::new(&[triangle], 1.0).len();
        assert!(count < 4 * 20_500, "{count}");
    }
}
