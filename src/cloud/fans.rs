//! A surface that grows triangle by triangle and stays an oriented manifold in the tangent planes.

use nalgebra::{Unit, Vector2, Vector3};

use super::points::Points;
use crate::base::perpendicular_frame;

/// End of a list of corners.
const NONE: u32 = u32::MAX;

/// Triangles, and for each point those around it: *wedges* [a, b], counterclockwise in its tangent
/// plane, that do not overlap.
#[derive(Debug)]
pub(super) struct Fans<'a> {
    points: &'a Points,
    normals: &'a [Vector3<f64>],
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each point, its last corner, 3 · triangle + place.
    last: Vec<u32>,
    /// For each corner, the one before at the same point.
    before: Vec<u32>,
}

/// An empty sector around a point: from the edge to `next` counterclockwise to the edge to `previous`.
/// A walk around the gap with it on the left comes from `previous` and goes on to `next`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sector {
    pub(super) next: u32,
    pub(super) previous: u32,
}

impl<'a> Fans<'a> {
    pub(super) fn new(points: &'a Points, normals: &'a [Vector3<f64>]) -> Self {
        Self {
            points,
            normals,
            triangles: Vec::new(),
            last: vec![NONE; points.len()],
            before: Vec::new(),
        }
    }

    /// The wedges around a point.
    pub(super) fn wedges(&self, v: u32) -> impl Iterator<Item = [u32; 2]> {
        let some = |corner: u32| (corner != NONE).then_some(corner);
        std::iter::successors(some(self.last[v as usize]), move |corner| {
            some(self.before[*corner as usize])
        })
        .map(|corner| {
            let triangle = self.triangles[(corner / 3) as usize];
            let place = (corner % 3) as usize;
            [triangle[(place + 1) % 3], triangle[(place + 2) % 3]]
        })
    }

    /// Adds a triangle if it is counterclockwise in the tangent planes of its corners and overlaps none
    /// there; tells whether it did.
    pub(super) fn add(&mut self, triangle: [u32; 3]) -> bool {
        let [a, b, c] = triangle;
        if !(self.is_free(a, [b, c]) && self.is_free(b, [c, a]) && self.is_free(c, [a, b])) {
            return false;
        }
        for v in triangle {
            let corner = super::points::index(self.before.len());
            self.before.push(self.last[v as usize]);
            self.last[v as usize] = corner;
        }
        self.triangles.push(triangle);
        true
    }

    fn is_free(&self, v: u32, [a, b]: [u32; 2]) -> bool {
        let plane = self.tangent(v);
        let [at_a, at_b] = [a, b].map(|w| plane.direction(w));
        if cross(at_a, at_b) <= 0.0 {
            return false;
        }
        let middle = at_a + at_b;
        self.wedges(v).all(|[c, d]| {
            // Edges are compared by their ends, so that touching wedges do not overlap by rounding.
            if a == c || b == d {
                return false;
            }
            let [at_c, at_d] = [c, d].map(|w| plane.direction(w));
            let inside = |x, from, to| cross(from, x) > 0.0 && cross(x, to) > 0.0;
            !((c != b && inside(at_c, at_a, at_b))
                || (d != a && inside(at_d, at_a, at_b))
                || (a != d && inside(at_a, at_c, at_d))
                || (b != c && inside(at_b, at_c, at_d))
                || inside(middle, at_c, at_d)
                || inside(at_c + at_d, at_a, at_b))
        })
    }

    fn tangent(&self, v: u32) -> Tangent<'_> {
        let axis = Unit::new_unchecked(self.normals[v as usize]);
        Tangent {
            points: self.points,
            origin: v,
            frame: perpendicular_frame(&axis),
        }
    }

    /// The empty sectors around a point that has triangles.
    pub(super) fn sectors(&self, v: u32) -> Vec<Sector> {
        let wedges: Vec<[u32; 2]> = self.wedges(v).collect();
        let starts: Vec<u32> = (wedges.iter().map(|w| w[0]))
            .filter(|start| wedges.iter().all(|w| w[1] != *start))
            .collect();
        let end = |start: u32| {
            let mut end = start;
            // A chain is no longer than the wedges are many.
            for _ in 0..wedges.len() {
                match wedges.iter().find(|w| w[0] == end) {
                    Some(wedge) => end = wedge[1],
                    None => break,
                }
            }
            end
        };
        let plane = self.tangent(v);
        (starts.iter())
            .map(|start| {
                let next = end(*start);
                let from = plane.direction(next);
                // Of all chains the one that starts first, counterclockwise from the end of this one.
                let turn = |w: u32| {
                    let to = plane.direction(w);
                    let angle = cross(from, to).atan2(from.dot(&to));
                    if angle > 0.0 {
                        angle
                    } else {
                        angle + std::f64::consts::TAU
                    }
                };
                let first = starts.iter().min_by(|a, b| turn(**a).total_cmp(&turn(**b)));
                let previous = first.copied().unwrap_or(*start);
                Sector { next, previous }
            })
            .collect()
    }
}

/// The tangent plane of a point.
struct Tangent<'a> {
    points: &'a Points,
    origin: u32,
    frame: [Vector3<f64>; 2],
}

impl Tangent<'_> {
    /// Unit direction to a point, seen along the normal.
    fn direction(&self, to: u32) -> Vector2<f64> {
        let positions = &self.points.positions;
        let d = positions[to as usize] - positions[self.origin as usize];
        let flat = Vector2::new(d.dot(&self.frame[0]), d.dot(&self.frame[1]));
        flat.try_normalize(0.0).unwrap_or_else(Vector2::zeros)
    }
}

pub(super) fn cross(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}
