//! The edges of a mesh in the making, the longest first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::{Point3, center};

use super::index;
use crate::mesh::TriMesh;

/// No half-edge, or no edge.
const NONE: u32 = u32::MAX;

/// The edges, and the half-edges at each: 3 f + k runs from corner k of triangle f to the next corner. Hash tables
/// would take more than twice the time.
#[derive(Default)]
pub(super) struct Edges {
    /// By edge its ends, the lower number first.
    pub(super) ends: Vec<[u32; 2]>,
    /// By edge one of its half-edges.
    first: Vec<u32>,
    /// By half-edge its edge.
    edge: Vec<u32>,
    /// By half-edge the next one of the same edge, and the one before, around in a circle.
    links: Vec<[u32; 2]>,
    /// Those that can be halved.
    longest: BinaryHeap<Longest>,
}

/// An edge that can be halved, the greater the earlier.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Longest {
    /// The bits of the squared length, which are in the order of the numbers, since none is negative.
    length: u64,
    ends: Reverse<[u32; 2]>,
    edge: u32,
}

impl Edges {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let mut edges = Self::default();
        let mut all: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * mesh.triangles.len());
        for (f, &[a, b, c]) in mesh.triangles.iter().enumerate() {
            edges.make_room();
            if a != b && b != c && c != a {
                let half_edges = [[a, b], [b, c], [c, a]].into_iter().zip(3 * f..);
                all.extend(half_edges.map(|([a, b], h)| ([a.min(b), a.max(b)], index(h))));
            }
        }
        all.sort_unstable();
        for same in all.chunk_by(|a, b| a.0 == b.0) {
            let [a, b] = same[0].0;
            let edge = edges.add(a, b, &mesh.positions);
            for (_, h) in same {
                edges.attach(*h, edge);
            }
        }
        edges
    }

    /// The longest edge, which is not given again; of several as long the one with the lowest numbers.
    pub(super) fn longest(&mut self) -> Option<u32> {
        self.longest.pop().map(|longest| longest.edge)
    }

    /// Takes room for the half-edges of one more triangle.
    pub(super) fn make_room(&mut self) {
        self.edge.extend([NONE; 3]);
        self.links.extend([[NONE; 2]; 3]);
    }

    /// Adds an edge without half-edges; gives its number.
    pub(super) fn add(&mut self, a: u32, b: u32, positions: &[Point3<f64>]) -> u32 {
        let edge = index(self.ends.len());
        let ends = [a.min(b), a.max(b)];
        self.ends.push(ends);
        self.first.push(NONE);
        let [p, q] = ends.map(|v| positions[v as usize]);
        let (length_sq, middle) = ((q - p).norm_squared(), center(&p, &q));
        // Two numbers next to each other have none between them.
        if length_sq > 0.0 && length_sq.is_finite() && middle != p && middle != q {
            self.longest.push(Longest {
                length: length_sq.to_bits(),
                ends: Reverse(ends),
                edge,
            });
        }
        edge
    }

    /// Puts a half-edge behind the others of an edge.
    pub(super) fn attach(&mut self, half_edge: u32, edge: u32) {
        self.edge[half_edge as usize] = edge;
        let first = self.first[edge as usize];
        if first == NONE {
            self.first[edge as usize] = half_edge;
            self.link(half_edge, half_edge);
        } else {
            let [_, last] = self.links[first as usize];
            self.link(last, half_edge);
            self.link(half_edge, first);
        }
    }

    /// Puts a half-edge in the place of another one.
    pub(super) fn replace(&mut self, old: u32, new: u32) {
        let edge = self.edge[old as usize];
        self.edge[new as usize] = edge;
        if self.first[edge as usize] == old {
            self.first[edge as usize] = new;
        }
        let [next, previous] = self.links[old as usize].map(|h| if h == old { new } else { h });
        self.link(previous, new);
        self.link(new, next);
    }

    fn link(&mut self, one: u32, next: u32) {
        self.links[one as usize][0] = next;
        self.links[next as usize][1] = one;
    }

    /// The half-edges of an edge.
    pub(super) fn around(&self, edge: u32) -> Vec<u32> {
        let first = self.first[edge as usize];
        let next = |h: &u32| Some(self.links[*h as usize][0]).filter(|next| *next != first);
        std::iter::successors(Some(first), next).collect()
    }
}
