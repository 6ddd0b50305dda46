//! Edges of a mesh collapsed one after the other, the shortest first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::{Point3, Vector3};

use crate::mesh::{TriMesh, triangle_normal};

/// Stands for a vertex that was merged into another one.
const GONE: u32 = u32::MAX;

/// A triangle may turn by up to the angle of this cosine in a collapse.
const LEAST_COSINE: f64 = 0.2;

/// A mesh in which edges are collapsed to their midpoints.
///
/// A collapse changes neither topology nor the number of boundaries, folds nothing over, and leaves a boundary
/// where it is but for the midpoints of its own edges.
pub(super) struct Collapse {
    positions: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    alive: Vec<bool>,
    /// By vertex: its triangles.
    around: Vec<Vec<u32>>,
    is_boundary: Vec<bool>,
    /// By vertex: how often it was moved, so that edges in the heap can be told from those of old.
    version: Vec<u32>,
    /// The vertex that each was merged into.
    merged: Vec<u32>,
    heap: BinaryHeap<Reverse<Edge>>,
    /// Edges that could not be collapsed when they were the shortest.
    refused: Vec<[u32; 2]>,
    count: usize,
}

/// An edge in the order in which edges are taken. Squared lengths are not negative: their bits sort as they do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    length_sq: u64,
    ends: [u32; 2],
    versions: [u32; 2],
}

impl Collapse {
    /// Of a mesh whose vertices are all used.
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let count = mesh.positions.len();
        let mut around = vec![Vec::with_capacity(8); count];
        for (f, triangle) in (0u32..).zip(&mesh.triangles) {
            for v in triangle {
                around[*v as usize].push(f);
            }
        }
        let mut collapse = Self {
            positions: mesh.positions.clone(),
            triangles: mesh.triangles.clone(),
            alive: vec![true; mesh.triangles.len()],
            around,
            is_boundary: vec![false; count],
            version: vec![0; count],
            merged: vec![GONE; count],
            heap: BinaryHeap::with_capacity(3 * count),
            refused: Vec::new(),
            count,
        };
        for (a, b) in collapse.edges() {
            if collapse.shared([a, b]).count() != 2 {
                collapse.is_boundary[a as usize] = true;
                collapse.is_boundary[b as usize] = true;
            }
            collapse.push(a, b);
        }
        collapse
    }

    /// All edges of the mesh as it is, each once.
    fn edges(&self) -> Vec<(u32, u32)> {
        let mut edges: Vec<(u32, u32)> = (self.triangles.iter().zip(&self.alive))
            .filter(|(_, alive)| **alive)
            .flat_map(|(&[a, b, c], _)| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Number of vertices that are left.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Collapses edges until `count` vertices are left, or none can be collapsed any more.
    pub(super) fn to(&mut self, count: usize) {
        let mut collapsed_since = false;
        while self.count > count {
            let Some(Reverse(edge)) = self.heap.pop() else {
                // What was refused may fit by now.
                if !collapsed_since || self.refused.is_empty() {
                    return;
                }
                collapsed_since = false;
                for [a, b] in std::mem::take(&mut self.refused) {
                    if [a, b].iter().all(|v| self.merged[*v as usize] == GONE)
                        && self.shared([a, b]).next().is_some()
                    {
                        self.push(a, b);
                    }
                }
                continue;
            };
            let current = edge.ends.map(|v| self.version[v as usize]);
            let is_left = edge.ends.iter().all(|v| self.merged[*v as usize] == GONE);
            if !is_left || current != edge.versions {
                continue;
            }
            match self.midpoint(edge.ends) {
                Some(to) if self.may_move(edge.ends, &to) => {
                    self.collapse(edge.ends, to);
                    collapsed_since = true;
                }
                _ => self.refused.push(edge.ends),
            }
        }
    }

    fn push(&mut self, a: u32, b: u32) {
        let ends = [a.min(b), a.max(b)];
        let [p, q] = ends.map(|v| self.positions[v as usize]);
        self.heap.push(Reverse(Edge {
            length_sq: (q - p).norm_squared().to_bits(),
            ends,
            versions: ends.map(|v| self.version[v as usize]),
        }));
    }

    /// The triangles at an edge.
    fn shared(&self, [a, b]: [u32; 2]) -> impl Iterator<Item = u32> {
        let around = self.around[a as usize].iter().copied();
        around.filter(move |f| self.triangles[*f as usize].contains(&b))
    }

    /// The vertices next to one, each once, ascending.
    fn neighbors(&self, v: u32) -> Vec<u32> {
        let around = self.around[v as usize].iter();
        let mut all: Vec<u32> = around.flat_map(|f| self.triangles[*f as usize]).collect();
        all.sort_unstable();
        all.dedup();
        all.retain(|w| *w != v);
        all
    }

    /// Where the ends of an edge meet; `None` if that would change the topology: no vertices may be next to both ends but
    /// those across the edge, and no edge may be collapsed that joins two boundaries, or ends a closed piece.
    fn midpoint(&self, ends: [u32; 2]) -> Option<Point3<f64>> {
        let shared = self.shared(ends).count();
        let [of_a, of_b] = ends.map(|v| self.neighbors(v));
        let common = of_a.iter().filter(|v| of_b.binary_search(v).is_ok());
        if common.count() != shared || of_a.len().max(of_b.len()) <= shared + 1 {
            return None;
        }
        // A tetrahedron is the least that is closed.
        if shared == 2 && of_a.len() + of_b.len() - shared <= 4 {
            return None;
        }
        let [p, q] = ends.map(|v| self.positions[v as usize]);
        match ends.map(|v| self.is_boundary[v as usize]) {
            [true, true] if shared != 1 => None,
            [true, false] => Some(p),
            [false, true] => Some(q),
            _ => Some(Point3::from((p.coords + q.coords) / 2.0)),
        }
    }

    /// Whether no triangle folds over when both ends move there.
    fn may_move(&self, ends: [u32; 2], to: &Point3<f64>) -> bool {
        let normal = |corners: [Point3<f64>; 3]| -> Vector3<f64> { triangle_normal(corners) };
        ends.into_iter().all(|v| {
            self.around[v as usize].iter().all(|f| {
                let triangle = self.triangles[*f as usize];
                if ends.iter().all(|end| triangle.contains(end)) {
                    return true;
                }
                let before = normal(triangle.map(|w| self.positions[w as usize]));
                let after = normal(triangle.map(|w| {
                    if w == v {
                        *to
                    } else {
                        self.positions[w as usize]
                    }
                }));
                let sizes = before.norm() * after.norm();
                // A triangle without area has no side that it could be turned from.
                before.norm() <= 0.0 || before.dot(&after) > LEAST_COSINE * sizes
            })
        })
    }

    fn collapse(&mut self, [kept, gone]: [u32; 2], to: Point3<f64>) {
        for f in std::mem::take(&mut self.around[gone as usize]) {
            let triangle = &mut self.triangles[f as usize];
            if triangle.contains(&kept) {
                self.alive[f as usize] = false;
                for v in *triangle {
                    self.around[v as usize].retain(|g| *g != f);
                }
            } else {
                *triangle = triangle.map(|v| if v == gone { kept } else { v });
                self.around[kept as usize].push(f);
            }
        }
        self.merged[gone as usize] = kept;
        self.is_boundary[kept as usize] |= self.is_boundary[gone as usize];
        self.positions[kept as usize] = to;
        self.version[kept as usize] += 1;
        self.count -= 1;
        for w in self.neighbors(kept) {
            self.push(kept, w);
        }
    }

    /// The mesh as it is, and for each vertex of the first mesh the one that stands for it.
    pub(super) fn now(&self) -> (TriMesh, Vec<u32>) {
        let mut number = vec![GONE; self.positions.len()];
        let mut mesh = TriMesh::default();
        for (v, merged) in self.merged.iter().enumerate() {
            if *merged == GONE {
                number[v] = u32::try_from(mesh.positions.len()).expect("vertices are u32");
                mesh.positions.push(self.positions[v]);
            }
        }
        mesh.triangles = (self.triangles.iter().zip(&self.alive))
            .filter(|(_, alive)| **alive)
            .map(|(triangle, _)| triangle.map(|v| number[v as usize]))
            .collect();
        let standing = (0..self.merged.len()).map(|v| {
            let mut v = v;
            while self.merged[v] != GONE {
                v = self.merged[v] as usize;
            }
            number[v]
        });
        (mesh, standing.collect())
    }
}

#[cfg(test)]
mod tests;
