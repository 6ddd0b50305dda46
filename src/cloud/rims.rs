//! Flat triangles along the rims, which a hull has and a surface has not.

use rayon::prelude::*;

use super::points::{Points, index};

/// No triangle.
const NONE: u32 = u32::MAX;

/// Cosine of the widest angle opposite a rim's edge: 150 degrees. Lattices have up to 120 there.
const WIDEST: f64 = -0.866;

/// Leaves out triangles with an edge at a rim and a nearly straight angle opposite to it, and again those
/// behind them. They are where the hull spans the small dents of a ragged rim; their normals are noise.
///
/// No point loses its last triangle: the corner at the angle keeps those beyond the other two edges, and
/// the edge's ends keep these too.
pub(super) fn peeled(triangles: Vec<[u32; 3]>, points: &Points) -> Vec<[u32; 3]> {
    let behind = behind(&triangles);
    let mut dropped = vec![false; triangles.len()];
    let mut waiting: Vec<usize> = (0..triangles.len())
        .filter(|f| behind[*f].contains(&NONE))
        .collect();
    while let Some(f) = waiting.pop() {
        let [a, b, c] = triangles[f];
        let opposite = [[c, a, b], [a, b, c], [b, c, a]];
        let sides = [0, 1, 2].map(|side| {
            let other = behind[f][side];
            let other = (other != NONE).then_some(other as usize);
            let [corner, v, w] = opposite[side];
            let other = other.filter(|g| !dropped[*g]);
            (other, cosine(points, corner, v, w))
        });
        let rims = sides.iter().filter(|(other, _)| other.is_none()).count();
        let flat = |(other, cosine): &(Option<usize>, f64)| other.is_none() && *cosine < WIDEST;
        if !dropped[f] && rims == 1 && sides.iter().any(flat) {
            dropped[f] = true;
            waiting.extend(sides.iter().filter_map(|(other, _)| *other));
        }
    }
    let mut f = 0;
    let mut kept = triangles;
    kept.retain(|_| {
        f += 1;
        !dropped[f - 1]
    });
    kept
}

/// For each triangle those behind its sides, from the first corner to the second and so on.
fn behind(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut sides: Vec<(u64, u32, u8)> = Vec::with_capacity(3 * triangles.len());
    for (f, [a, b, c]) in triangles.iter().enumerate() {
        for ((v, w), side) in [(a, b), (b, c), (c, a)].into_iter().zip(0u8..) {
            // Both ends in one number, the same from either side.
            let edge = u64::from(*v.min(w)) << 32 | u64::from(*v.max(w));
            sides.push((edge, index(f), side));
        }
    }
    sides.par_sort_unstable();
    let mut behind = vec![[NONE; 3]; triangles.len()];
    for same in sides.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, f, f_side), (_, g, g_side)] = *same {
            behind[f as usize][usize::from(f_side)] = g;
            behind[g as usize][usize::from(g_side)] = f;
        }
    }
    behind
}

/// Cosine of the angle at `corner` between two other points.
fn cosine(points: &Points, corner: u32, v: u32, w: u32) -> f64 {
    let [p, a, b] = [corner, v, w].map(|v| points.positions[v as usize]);
    let (a, b) = (a - p, b - p);
    a.dot(&b) / (a.norm() * b.norm())
}
