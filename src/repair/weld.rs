//! Seams: edges that lie at the same place bit by bit, with surface on either side.

use super::Work;
use super::edges::{by_edge, half_edges};
use crate::mesh::DisjointSets;

/// Joins the ends of every two boundary edges that lie at the same place and run against each other, if
/// there is no third one. Gives the number of vertices that another one stands for now.
///
/// Edges that run the same way are those of two sheets upon each other, not of a seam; nor is there one between
/// two edges of the same face, which has two corners at one place.
pub(super) fn join_seams(work: &mut Work, places: &[u32]) -> usize {
    if (0u32..).zip(places).all(|(v, place)| v == *place) {
        return 0;
    }
    let edges = half_edges(work);
    // By place: ends, direction, the vertices themselves in the direction of the places, and the face.
    let mut open: Vec<([u32; 2], bool, [u32; 2], u32)> = by_edge(&edges)
        .filter(|edge| edge.len() == 1)
        .map(|edge| {
            let edge = edge[0];
            let [from, to] = if edge.forward {
                [edge.low, edge.high]
            } else {
                [edge.high, edge.low]
            };
            let [a, b] = [places[from as usize], places[to as usize]];
            if a < b {
                ([a, b], true, [from, to], edge.face)
            } else {
                ([b, a], false, [to, from], edge.face)
            }
        })
        .filter(|([a, b], ..)| a != b)
        .collect();
    open.sort_unstable();
    let mut joined = DisjointSets::new(places.len());
    for same in open.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, false, first, face), (_, true, second, other)] = same
            && face != other
        {
            for (a, b) in first.iter().zip(second) {
                joined.join(*a, *b);
            }
        }
    }
    let joined = joined.into_lowest();
    let count = (0u32..).zip(&joined).filter(|(v, s)| v != *s).count();
    if count > 0 {
        work.stands_for = Some(joined);
    }
    count
}
