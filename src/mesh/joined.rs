//! Which triangles are joined along an edge.

use rayon::prelude::*;

/// Stands for the opposite of a half-edge that has none.
pub(crate) const ALONE: u32 = u32::MAX;

/// By half-edge its opposite, where exactly two triangles have an edge and run through it in opposite
/// directions; [`ALONE`] elsewhere. Half-edge 3 f + k runs from corner k of triangle f to the next corner.
pub(crate) fn opposite_half_edges(triangles: &[[u32; 3]]) -> Vec<u32> {
    // Ends in ascending order, in one number, and the half-edge.
    let ends = |a: u32, b: u32| u64::from(a.min(b)) << 32 | u64::from(a.max(b));
    let mut edges: Vec<(u64, u32)> = (triangles.iter())
        .flat_map(|&[a, b, c]| [ends(a, b), ends(b, c), ends(c, a)])
        .zip(0..)
        .collect();
    edges.par_sort_unstable();
    let mut opposites = vec![ALONE; edges.len()];
    let origin = |h: u32| triangles[h as usize / 3][h as usize % 3];
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, one), (_, other)] = *same
            && origin(one) != origin(other)
            // A triangle with a corner twice runs both ways itself.
            && one / 3 != other / 3
        {
            opposites[one as usize] = other;
            opposites[other as usize] = one;
        }
    }
    opposites
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_alone_that_run_against_each_other_are_joined() {
        assert_eq!(
            opposite_half_edges(&[[0, 1, 2], [2, 1, 3]]),
            [ALONE, 3, ALONE, 1, ALONE, ALONE]
        );
        // The same way, three at an edge, and an edge of one vertex.
        for triangles in [
            vec![[0, 1, 2], [1, 2, 3]],
            vec![[0, 1, 2], [2, 1, 3], [2, 1, 4]],
            vec![[0, 0, 1], [0, 0, 2]],
        ] {
            assert!(opposite_half_edges(&triangles).iter().all(|h| *h == ALONE));
        }
    }
}
