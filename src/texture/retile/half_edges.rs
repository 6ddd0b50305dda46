//! Triangles joined along their edges, which can be split, collapsed and flipped.
//!
//! Half-edge 3 f + k runs from corner k of triangle f to the next corner. An edge that the surface ends at
//! has one half-edge, any other two, which are each other's opposites.

use rayon::prelude::*;

use crate::mesh::{ALONE, opposite_half_edges};

/// No half-edge, no vertex.
pub(super) const NONE: u32 = ALONE;

/// A triangulated manifold, possibly with boundary, in which an edge can be changed in constant time. Every
/// vertex has one fan of triangles; a boundary vertex's half-edge in `outgoing` is the one on the boundary.
#[derive(Debug, Clone, Default)]
pub(super) struct HalfEdges {
    /// Corners of each triangle, [`NONE`] thrice once it is gone.
    triangles: Vec<[u32; 3]>,
    opposites: Vec<u32>,
    /// By vertex a half-edge from it, [`NONE`] once it is gone.
    outgoing: Vec<u32>,
    gone: usize,
}

/// The half-edge after this one in its triangle.
pub(super) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The half-edge before this one in its triangle.
pub(super) fn previous(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

fn index(i: usize) -> u32 {
    u32::try_from(i).expect("indices are u32")
}

impl HalfEdges {
    /// Joins triangles where two alone have an edge and run through it in opposite directions. Where
    /// several fans of triangles meet in a vertex, each gets a vertex of its own. Returns also which vertex of
    /// the triangles given each vertex was.
    pub(super) fn new(triangles: &[[u32; 3]]) -> (Self, Vec<u32>) {
        let mut edges = Self {
            triangles: vec![[NONE; 3]; triangles.len()],
            opposites: opposite_half_edges(triangles),
            ..Self::default()
        };
        let mut were = Vec::new();
        for h in 0..index(3 * triangles.len()) {
            if edges.origin(h) == NONE {
                let first = edges.most_clockwise(h);
                let v = index(were.len());
                edges.outgoing.push(first);
                were.push(triangles[h as usize / 3][h as usize % 3]);
                for fan in Fan::new(&edges, first).collect::<Vec<_>>() {
                    edges.triangles[fan as usize / 3][fan as usize % 3] = v;
                }
            }
        }
        (edges, were)
    }

    /// Number of half-edges, with those that are gone.
    pub(super) fn len(&self) -> u32 {
        index(self.opposites.len())
    }

    /// Number of vertex numbers in use, with those that are gone.
    pub(super) fn vertex_numbers(&self) -> u32 {
        index(self.outgoing.len())
    }

    /// Number of vertices.
    pub(super) fn vertices(&self) -> usize {
        self.outgoing.len() - self.gone
    }

    /// The triangles, with those that are gone.
    pub(super) fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    pub(super) fn has_vertex(&self, v: u32) -> bool {
        self.outgoing[v as usize] != NONE
    }

    pub(super) fn origin(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    pub(super) fn target(&self, h: u32) -> u32 {
        self.origin(next(h))
    }

    /// The corner opposite of the half-edge in its triangle.
    pub(super) fn apex(&self, h: u32) -> u32 {
        self.origin(previous(h))
    }

    pub(super) fn opposite(&self, h: u32) -> Option<u32> {
        let opposite = self.opposites[h as usize];
        (opposite != NONE).then_some(opposite)
    }

    /// Whether the half-edge is there and stands for its edge: each edge has one that does.
    pub(super) fn is_edge(&self, h: u32) -> bool {
        self.origin(h) != NONE && h < self.opposites[h as usize]
    }

    pub(super) fn is_boundary(&self, v: u32) -> bool {
        self.opposites[self.outgoing[v as usize] as usize] == NONE
    }

    /// A half-edge from the vertex; at a boundary vertex the one along the boundary.
    pub(super) fn outgoing(&self, v: u32) -> u32 {
        self.outgoing[v as usize]
    }

    /// The boundary half-edge that follows on a boundary half-edge.
    pub(super) fn next_on_boundary(&self, h: u32) -> u32 {
        self.outgoing(self.target(h))
    }

    /// The half-edges from a vertex, counterclockwise; from the boundary to the boundary, if it is on one.
    pub(super) fn fan(&self, v: u32) -> Fan<'_> {
        Fan::new(self, self.outgoing(v))
    }

    /// The vertices that have an edge with `v`, counterclockwise.
    pub(super) fn neighbors(&self, v: u32) -> impl Iterator<Item = u32> {
        self.fan(v).flat_map(|h| {
            let last = self.opposite(previous(h)).is_none();
            [Some(self.target(h)), last.then(|| self.apex(h))]
                .into_iter()
                .flatten()
        })
    }

    pub(super) fn has_edge(&self, a: u32, b: u32) -> bool {
        self.neighbors(a).any(|n| n == b)
    }

    /// The half-edge, of those from its origin, that the surface ends clockwise of; itself if it does not.
    fn most_clockwise(&self, h: u32) -> u32 {
        let mut first = h;
        while let Some(opposite) = self.opposite(first) {
            first = next(opposite);
            if first == h {
                break;
            }
        }
        first
    }

    fn settle(&mut self, v: u32, h: u32) {
        self.outgoing[v as usize] = self.most_clockwise(h);
    }

    fn link(&mut self, h: u32, opposite: u32) {
        for (one, other) in [(h, opposite), (opposite, h)] {
            if one != NONE {
                self.opposites[one as usize] = other;
            }
        }
    }

    fn push(&mut self, triangle: [u32; 3]) -> u32 {
        let first = self.len();
        self.triangles.push(triangle);
        self.opposites.extend([NONE; 3]);
        first
    }

    /// Puts a new vertex, whose number is returned, on an edge. The half-edge keeps its target.
    pub(super) fn split(&mut self, h: u32) -> u32 {
        let m = index(self.outgoing.len());
        self.outgoing.push(h);
        let (a, c) = (self.origin(h), self.apex(h));
        let beyond = self.opposites[previous(h) as usize];
        let opposite = self.opposite(h);
        self.triangles[h as usize / 3][h as usize % 3] = m;
        let near = self.push([a, m, c]);
        self.link(near + 1, previous(h));
        self.link(near + 2, beyond);
        if let Some(o) = opposite {
            let (d, after) = (self.apex(o), next(o));
            let beyond = self.opposites[after as usize];
            self.triangles[after as usize / 3][after as usize % 3] = m;
            let far = self.push([m, a, d]);
            self.link(far, near);
            self.link(far + 1, beyond);
            self.link(far + 2, after);
        }
        self.settle(a, near);
        self.settle(m, h);
        self.settle(c, near + 2);
        m
    }

    /// Puts a new vertex, whose number is returned, into the triangle of a half-edge.
    pub(super) fn split_triangle(&mut self, h: u32) -> u32 {
        let m = index(self.outgoing.len());
        let [ab, bc, ca] = [h, next(h), previous(h)];
        let [a, b, c] = [ab, bc, ca].map(|h| self.origin(h));
        let [beyond_bc, beyond_ca] = [bc, ca].map(|h| self.opposites[h as usize]);
        self.triangles[ca as usize / 3][ca as usize % 3] = m;
        let second = self.push([b, c, m]);
        let third = self.push([c, a, m]);
        self.link(second, beyond_bc);
        self.link(third, beyond_ca);
        self.link(bc, second + 2);
        self.link(second + 1, third + 2);
        self.link(third + 1, ca);
        self.outgoing.push(ca);
        self.settle(a, ab);
        self.settle(b, second);
        self.settle(c, third);
        m
    }

    /// Whether the half-edge's origin can be merged into its target without a change of topology: the
    /// boundary stays where it is, no edge becomes double, and no component or loop vanishes (link condition:
    /// Dey, Edelsbrunner, Guha & Nekhayev, *Topology preserving edge contraction*, 1999).
    pub(super) fn can_collapse(&self, h: u32) -> bool {
        let (a, b) = (self.origin(h), self.target(h));
        let opposite = self.opposite(h);
        if self.is_boundary(a) && (opposite.is_some() || !self.is_boundary(b)) {
            return false;
        }
        let sides = [Some(h), opposite];
        let apexes = sides.map(|h| h.map(|h| self.apex(h)));
        let common = self.neighbors(a).filter(|n| self.has_edge(*n, b)).count();
        common == apexes.iter().flatten().count()
            && sides.iter().flatten().all(|h| {
                let apex = self.apex(*h);
                if self.is_boundary(apex) {
                    let others = [next(*h), previous(*h)];
                    others.iter().any(|h| self.opposite(*h).is_some())
                } else {
                    self.neighbors(apex).nth(3).is_some()
                }
            })
    }

    /// Merges the half-edge's origin into its target; [`Self::can_collapse`] must hold.
    pub(super) fn collapse(&mut self, h: u32) {
        let (a, b) = (self.origin(h), self.target(h));
        for fan in self.fan(a).collect::<Vec<_>>() {
            self.triangles[fan as usize / 3][fan as usize % 3] = b;
        }
        self.outgoing[a as usize] = NONE;
        self.gone += 1;
        let sides = [Some(h), self.opposite(h)];
        let closed = sides.map(|side| side.map(|side| self.close(side)));
        for (apex, [from_apex, from_end]) in closed.into_iter().flatten() {
            self.settle(apex, from_apex);
            self.settle(b, from_end);
        }
    }

    /// Removes a triangle whose two corners on the half-edge have become one. Returns its apex and
    /// half-edges that are left from the apex and from the other corner.
    fn close(&mut self, h: u32) -> (u32, [u32; 2]) {
        let apex = self.apex(h);
        let [one, other] = [next(h), previous(h)].map(|h| self.opposites[h as usize]);
        self.link(one, other);
        self.link(other, one);
        self.triangles[h as usize / 3] = [NONE; 3];
        for dead in [h, next(h), previous(h)] {
            self.opposites[dead as usize] = NONE;
        }
        // `one` ran from the apex to the end, `other` from the end to the apex.
        if one == NONE {
            (apex, [next(other), other])
        } else {
            (apex, [one, next(one)])
        }
    }

    /// Whether the edge can be turned without making an edge double.
    pub(super) fn can_flip(&self, h: u32) -> bool {
        self.opposite(h).is_some_and(|o| {
            let (c, d) = (self.apex(h), self.apex(o));
            c != d && !self.has_edge(c, d)
        })
    }

    /// Turns an edge into the one between the two corners opposite of it; [`Self::can_flip`] must hold.
    pub(super) fn flip(&mut self, h: u32) {
        let Some(o) = self.opposite(h) else { return };
        let (a, b, c, d) = (self.origin(h), self.target(h), self.apex(h), self.apex(o));
        let [bc, ca, ad, db] =
            [next(h), previous(h), next(o), previous(o)].map(|h| self.opposites[h as usize]);
        let (f, g) = (h / 3, o / 3);
        self.triangles[f as usize] = [c, a, d];
        self.triangles[g as usize] = [d, b, c];
        self.link(3 * f, ca);
        self.link(3 * f + 1, ad);
        self.link(3 * f + 2, 3 * g + 2);
        self.link(3 * g, db);
        self.link(3 * g + 1, bc);
        self.settle(a, 3 * f + 1);
        self.settle(b, 3 * g + 1);
        self.settle(c, 3 * f);
        self.settle(d, 3 * g);
    }

    /// The numbers of the vertices that are there, ascending.
    pub(super) fn kept(&self) -> Vec<u32> {
        (0..self.vertex_numbers())
            .filter(|v| self.has_vertex(*v))
            .collect()
    }

    /// Drops what is gone and gives the vertices new numbers: their places in `kept`, which has every one. The
    /// triangles come in the order of their lowest vertex.
    pub(super) fn renumber(&mut self, kept: &[u32]) {
        let mut vertices = vec![NONE; self.outgoing.len()];
        for (new, old) in (0..).zip(kept) {
            vertices[*old as usize] = new;
        }
        let there = (0u32..).zip(&self.triangles).filter(|(_, t)| t[0] != NONE);
        let mut order: Vec<(u32, u32)> = there
            .map(|(f, t)| {
                (
                    t.map(|v| vertices[v as usize])
                        .into_iter()
                        .fold(NONE, u32::min),
                    f,
                )
            })
            .collect();
        order.par_sort_unstable();
        let mut triangles = vec![NONE; self.triangles.len()];
        for (new, (_, old)) in (0..).zip(&order) {
            triangles[*old as usize] = new;
        }
        let moved = |h: u32| {
            if h == NONE {
                NONE
            } else {
                3 * triangles[h as usize / 3] + h % 3
            }
        };
        let old = |f: &(u32, u32)| f.1 as usize;
        let opposites = (order.iter().map(old))
            .flat_map(|f| [3 * f, 3 * f + 1, 3 * f + 2])
            .map(|h| moved(self.opposites[h]))
            .collect();
        let outgoing = (kept.iter())
            .map(|v| moved(self.outgoing[*v as usize]))
            .collect();
        let corners = |f: usize| self.triangles[f].map(|v| vertices[v as usize]);
        *self = Self {
            triangles: order.iter().map(old).map(corners).collect(),
            opposites,
            outgoing,
            gone: 0,
        };
    }
}

/// The half-edges from a vertex, counterclockwise.
#[derive(Debug, Clone)]
pub(super) struct Fan<'a> {
    edges: &'a HalfEdges,
    first: u32,
    current: Option<u32>,
}

impl<'a> Fan<'a> {
    fn new(edges: &'a HalfEdges, first: u32) -> Self {
        let current = Some(first);
        Self {
            edges,
            first,
            current,
        }
    }
}

impl Iterator for Fan<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let h = self.current?;
        let onward = self.edges.opposite(previous(h));
        self.current = onward.filter(|onward| *onward != self.first);
        Some(h)
    }
}
