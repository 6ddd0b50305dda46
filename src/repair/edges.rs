//! The edges of faces, each with all faces at it.

use rayon::prelude::*;

use super::Work;

/// One side of an edge. Sorted, those of one edge are neighbors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct HalfEdge {
    /// The smaller vertex.
    pub(super) low: u32,
    /// The larger one.
    pub(super) high: u32,
    pub(super) face: u32,
    /// Whether the face runs from the smaller to the larger one.
    pub(super) forward: bool,
}

/// The half-edges of all faces that are left, sorted.
pub(super) fn half_edges(work: &Work) -> Vec<HalfEdge> {
    let mut edges = Vec::new();
    for face in work.left() {
        let corners = work.corners(face);
        let ahead = corners.clone().cycle().skip(1);
        for (from, to) in corners.zip(ahead).filter(|(from, to)| from != to) {
            edges.push(HalfEdge {
                low: from.min(to),
                high: from.max(to),
                face,
                forward: (from < to) != work.flipped[face as usize],
            });
        }
    }
    // All fields take part, so that the order does not depend on the algorithm.
    edges.par_sort_unstable();
    edges
}

/// The edges, each with its half-edges.
pub(super) fn by_edge(edges: &[HalfEdge]) -> impl Iterator<Item = &[HalfEdge]> {
    edges.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high))
}

/// Number of vertices in which several rims touch.
pub(super) fn touching_vertices(work: &Work) -> usize {
    let edges = half_edges(work);
    let mut rims = vec![0u8; work.positions.len()];
    for edge in by_edge(&edges).filter(|edge| edge.len() == 1) {
        for v in [edge[0].low, edge[0].high] {
            rims[v as usize] = rims[v as usize].saturating_add(1);
        }
    }
    rims.iter().filter(|edges| **edges > 2).count()
}
