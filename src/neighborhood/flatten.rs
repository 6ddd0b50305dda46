//! The surface around a place laid flat by projection.
//!
//! # Reference
//! [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001), §3.3.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::Vector3;

use super::spots::Spot;
use super::{Place, Stencil, Surface};

/// How far outside of a triangle, in barycentric coordinates, a lattice point still counts as inside: one on an
/// edge must not fall between both triangles.
const EDGE_SLACK: f32 = 1e-5;

/// No offset of the stencil.
const NONE: u32 = u32::MAX;

/// A surface and a lattice to lay over it.
#[derive(Debug)]
pub(super) struct Flattening<'a> {
    surface: &'a Surface,
    spacing: f64,
    /// Lattice points on either side of the centre.
    radius: i64,
    /// Numbers of the stencil's offsets, row by row of the lattice.
    numbers: Vec<u32>,
}

/// Memory of a flattening, kept between places.
#[derive(Debug, Default)]
pub(super) struct Memory {
    front: BinaryHeap<Waiting>,
    seen: Seen,
}

/// Triangles that have been waiting: open addressing, emptied by counting on.
#[derive(Debug, Default)]
struct Seen {
    /// Triangle, and the count at which it was put there.
    slots: Vec<(u32, u32)>,
    count: u32,
}

impl Seen {
    /// For no more than half as many triangles as there are slots, a power of two.
    fn empty(&mut self, slots: usize) {
        if self.slots.len() != slots || self.count == u32::MAX {
            self.slots = vec![(0, 0); slots];
            self.count = 0;
        }
        self.count += 1;
    }

    /// Whether a triangle was not there yet; it is now. Nothing is new where there is no room.
    fn insert(&mut self, triangle: u32) -> bool {
        let mask = self.slots.len() - 1;
        let first = triangle.wrapping_mul(0x9E37_79B9) as usize >> 7;
        for step in 0..self.slots.len() / 2 {
            let slot = &mut self.slots[(first + step) & mask];
            if slot.1 != self.count {
                *slot = (triangle, self.count);
                return true;
            }
            if slot.0 == triangle {
                return false;
            }
        }
        false
    }
}

/// A triangle at the rim of what is laid flat.
#[derive(Debug, PartialEq)]
struct Waiting {
    /// From the centre, in lattice spacings.
    distance: f32,
    triangle: u32,
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        // The nearest is the greatest, so that the heap gives it first.
        (other.distance.total_cmp(&self.distance)).then(other.triangle.cmp(&self.triangle))
    }
}

impl<'a> Flattening<'a> {
    /// # Panics
    /// If the stencil is not a square lattice.
    pub(super) fn new(surface: &'a Surface, stencil: &Stencil) -> Self {
        let spacing = stencil.spacing();
        #[expect(clippy::cast_possible_truncation, reason = "a lattice point")]
        let lattice = |x: f32| (f64::from(x) / spacing).round() as i64;
        let radius = (stencil.offsets().iter().flatten())
            .map(|x| lattice(*x))
            .max()
            .unwrap_or(0);
        let side = 2 * radius + 1;
        let all = usize::try_from(side * side).expect("a small square");
        assert_eq!(stencil.len(), all, "a square lattice");
        let mut numbers = vec![NONE; all];
        for (number, [x, y]) in (0u32..).zip(stencil.offsets()) {
            let at = (lattice(*y) + radius) * side + lattice(*x) + radius;
            numbers[usize::try_from(at).expect("within the square")] = number;
        }
        Self {
            surface,
            spacing,
            radius,
            numbers,
        }
    }

    /// Lays the surface around a place flat, triangle by triangle, the nearest first, until the lattice is covered
    /// (`row`: one spot an offset). A triangle that would lie face down is left out, and nothing grows over it.
    pub(super) fn lay(
        &self,
        memory: &mut Memory,
        place: &Place,
        normal: &Vector3<f64>,
        row: &mut [Spot],
    ) {
        let axis = self.surface.axis(place);
        let Some(x) = (axis - normal * axis.dot(normal)).try_normalize(1e-9) else {
            return;
        };
        let axes = [x, normal.cross(&x)].map(|axis| axis / self.spacing);
        let centre = self.surface.position(place);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "lattice coordinates are single"
        )]
        let flat = |v: u32| {
            let from = self.surface.positions()[v as usize] - centre;
            axes.map(|axis| from.dot(&axis) as f32)
        };
        let reach = self.radius as f32 + EDGE_SLACK;
        let Memory { front, seen } = memory;
        front.clear();
        // A texel has two triangles; where they are smaller, there may be many more.
        seen.empty((64 * row.len()).next_power_of_two());
        front.push(Waiting {
            distance: 0.0,
            triangle: place.triangle,
        });
        seen.insert(place.triangle);
        let mut left = row.len();
        while let Some(Waiting { triangle, .. }) = front.pop() {
            let corners = self.surface.corners(triangle).map(flat);
            let Some(covered) = self.cover(triangle, corners, row) else {
                continue;
            };
            left -= covered;
            if left == 0 {
                return;
            }
            for edge in 0..3 {
                let Some(next) = self.surface.across(triangle, edge) else {
                    continue;
                };
                let ends = [corners[edge], corners[(edge + 1) % 3]];
                if may_cross(ends, reach) && seen.insert(next) {
                    front.push(Waiting {
                        distance: distance_to_segment(ends),
                        triangle: next,
                    });
                }
            }
        }
    }

    /// Puts the lattice points in a flat triangle there, but those that are in one laid before. How many; `None` if
    /// the triangle lies face down.
    fn cover(&self, triangle: u32, [a, b, c]: [[f32; 2]; 3], row: &mut [Spot]) -> Option<usize> {
        let double_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if double_area <= 0.0 {
            return None;
        }
        let side = 2 * self.radius + 1;
        let range = |k: usize| {
            let low = a[k].min(b[k]).min(c[k]) - EDGE_SLACK;
            let high = a[k].max(b[k]).max(c[k]) + EDGE_SLACK;
            #[expect(clippy::cast_possible_truncation, reason = "clamped to the lattice")]
            let lattice = |x: f32| (x as i64).clamp(-self.radius - 1, self.radius + 1);
            lattice(low.ceil()).max(-self.radius)..=lattice(high.floor()).min(self.radius)
        };
        let mut covered = 0;
        for y in range(1) {
            for x in range(0) {
                let at = usize::try_from((y + self.radius) * side + x + self.radius)
                    .expect("within the lattice");
                let spot = &mut row[self.numbers[at] as usize];
                #[expect(clippy::cast_precision_loss, reason = "small numbers")]
                let (x, y) = (x as f32, y as f32);
                let second =
                    ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / double_area;
                let third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / double_area;
                let inside = second.min(third).min(1.0 - second - third) >= -EDGE_SLACK;
                if inside && !spot.is_somewhere() {
                    *spot = Spot {
                        triangle,
                        shares: [second, third],
                    };
                    covered += 1;
                }
            }
        }
        Some(covered)
    }
}

/// Whether a segment may come into the square that reaches so far to all sides: beyond it are no lattice points.
fn may_cross([a, b]: [[f32; 2]; 2], reach: f32) -> bool {
    (0..2).all(|k| a[k].min(b[k]) <= reach && a[k].max(b[k]) >= -reach)
}

/// Distance of the origin to a segment.
fn distance_to_segment([a, b]: [[f32; 2]; 2]) -> f32 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length_sq = along[0] * along[0] + along[1] * along[1];
    let share = -(a[0] * along[0] + a[1] * along[1]) / length_sq.max(f32::MIN_POSITIVE);
    let share = share.clamp(0.0, 1.0);
    (a[0] + share * along[0]).hypot(a[1] + share * along[1])
}
