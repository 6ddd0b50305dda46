//! Seams: edges that lie at the same place bit by bit, with surface on either side.

use nalgebra::Point3;
use rayon::prelude::*;

use super::Work;
use super::edges::{by_edge, half_edges};

/// For each vertex the first vertex at the same place.
pub(super) fn places(positions: &[Point3<f64>]) -> Vec<u32> {
    // Adding 0 makes -0 the same place as 0.
    let bits = |v: &u32| -> [u64; 3] {
        let place = positions[*v as usize].coords;
        place.map(|x| (x + 0.0).to_bits()).into()
    };
    let mut order: Vec<u32> = (0u32..).take(positions.len()).collect();
    order.par_sort_unstable_by_key(|v| (bits(v), *v));
    let mut places = vec![0; positions.len()];
    for same in order.chunk_by(|a, b| bits(a) == bits(b)) {
        for v in same {
            places[*v as usize] = same[0];
        }
    }
    places
}

/// Joins the ends of every two boundary edges that lie at the same place and run against each other, if
/// there is no third one. Gives the number of vertices that another one stands for now.
///
/// Edges that run the same way are those of two sheets upon each other, not of a seam.
pub(super) fn join_seams(work: &mut Work, places: &[u32]) -> usize {
    if (0u32..).zip(places).all(|(v, place)| v == *place) {
        return 0;
    }
    let edges = half_edges(work);
    // By place: ends, direction, and the vertices themselves in the direction of the places.
    let mut open: Vec<([u32; 2], bool, [u32; 2])> = by_edge(&edges)
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
                ([a, b], true, [from, to])
            } else {
                ([b, a], false, [to, from])
            }
        })
        .filter(|([a, b], _, _)| a != b)
        .collect();
    open.sort_unstable();
    let mut joined: Vec<u32> = (0u32..).take(places.len()).collect();
    for same in open.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, false, first), (_, true, second)] = same {
            for (a, b) in first.iter().zip(second) {
                join(&mut joined, *a, *b);
            }
        }
    }
    for v in (0u32..).take(places.len()) {
        joined[v as usize] = root(&joined, v);
    }
    let count = (0u32..).zip(&joined).filter(|(v, s)| v != *s).count();
    if count > 0 {
        work.stands_for = Some(joined);
    }
    count
}

/// The smallest vertex of a set stands for it.
fn join(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}

/// Sets are as small as the number of faces at a place: their paths are short.
fn root(parents: &[u32], mut v: u32) -> u32 {
    while parents[v as usize] != v {
        v = parents[v as usize];
    }
    v
}
