//! Free form: the triangles that the local stars agree on.

use rayon::prelude::*;

use super::fans::Fans;
use super::gaps;
use super::points::Points;
use super::rims;
use super::single_fans::single_fans;
use super::stars::Stars;

/// Corners of a triangle that must have it in their star.
const LEAST_VOTES: u8 = 2;

/// An oriented manifold of the triangles that at least two of their corners' Delaunay stars hold, first
/// those of all three, small circles before large ones, each if it overlaps none before it; then the
/// small gaps between them are closed.
///
/// # Reference
/// Gopi, Krishnan & Silva 2000, in [`crate::bibliography`]. They join what the stars hold as it comes;
/// here the agreement decides, so that noise leaves gaps instead of folds.
pub(super) fn triangulate(stars: &Stars) -> Vec<[u32; 3]> {
    let mut fans = Fans::new(stars.points, stars.normals);
    for triangle in agreed(stars) {
        fans.add(triangle);
    }
    gaps::close(&mut fans, stars);
    finished(fans.triangles, stars.points)
}

/// Without the flat triangles at rims, and one fan at each point.
pub(super) fn finished(mut triangles: Vec<[u32; 3]>, points: &Points) -> Vec<[u32; 3]> {
    // What is close on the list is then close in space, and in memory.
    triangles.par_sort_unstable();
    single_fans(rims::peeled(triangles, points), points.len())
}

/// The triangles of the stars by falling agreement.
fn agreed(stars: &Stars) -> Vec<[u32; 3]> {
    let points = stars.points;
    let mut all: Vec<[u32; 3]> = (0..points.len())
        .into_par_iter()
        .flat_map_iter(|i| stars.triangles(i))
        .collect();
    all.par_sort_unstable();
    let mut ranked: Vec<(u8, u64, [u32; 3])> = (all.chunk_by(|a, b| a == b))
        .filter_map(|same| {
            let votes = u8::try_from(same.len()).unwrap_or(3).min(3);
            let size = circumradius(points, same[0]).to_bits();
            (votes >= LEAST_VOTES).then_some((3 - votes, size, same[0]))
        })
        .collect();
    ranked.par_sort_unstable();
    ranked
        .into_iter()
        .map(|(_, _, triangle)| triangle)
        .collect()
}

/// Radius of the circle through the corners; infinite if they are on one line.
pub(super) fn circumradius(points: &Points, triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| points.positions[v as usize]);
    let double_area = (b - a).cross(&(c - a)).norm();
    let sides = (b - a).norm() * (c - b).norm() * (a - c).norm();
    if double_area > 0.0 {
        sides / (2.0 * double_area)
    } else {
        f64::INFINITY
    }
}

/// Whether each point has a triangle.
pub(super) fn used(triangles: &[[u32; 3]], points: usize) -> Vec<bool> {
    let mut used = vec![false; points];
    for v in triangles.iter().flatten() {
        used[*v as usize] = true;
    }
    used
}
