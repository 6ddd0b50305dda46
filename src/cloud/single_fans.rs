//! Points in which several fans of triangles meet keep the largest.

use super::points::index;
use super::signs::Groups;

/// End of a list.
const NONE: u32 = u32::MAX;

/// Leaves out triangles of an oriented edge-manifold until those at every vertex are one fan or one
/// ring: where several meet, the largest stays (of equals, that of the first triangle).
pub(super) fn single_fans(triangles: Vec<[u32; 3]>, vertices: usize) -> Vec<[u32; 3]> {
    let mut corners = Corners::new(&triangles, vertices);
    let mut dropped = vec![false; triangles.len()];
    let mut waiting: Vec<u32> = (0u32..).take(vertices).collect();
    // From the end: order does not matter for termination, only for being always the same.
    while let Some(v) = waiting.pop() {
        for f in corners.surplus(v, &triangles, &dropped) {
            dropped[f as usize] = true;
            waiting.extend(triangles[f as usize]);
        }
    }
    let mut kept = triangles;
    let mut f = 0;
    kept.retain(|_| {
        f += 1;
        !dropped[f - 1]
    });
    kept
}

/// For each vertex the triangles at it.
struct Corners {
    first: Vec<u32>,
    next: Vec<[u32; 3]>,
    /// Triangles at the vertex that is looked at, and the fan of each.
    around: Vec<(u32, [u32; 2], usize)>,
}

impl Corners {
    fn new(triangles: &[[u32; 3]], vertices: usize) -> Self {
        let mut corners = Self {
            first: vec![NONE; vertices],
            next: vec![[NONE; 3]; triangles.len()],
            around: Vec::new(),
        };
        // Backwards, so that the lists run forwards.
        for (f, triangle) in triangles.iter().enumerate().rev() {
            let f = index(f);
            for (place, v) in triangle.iter().enumerate() {
                corners.next[f as usize][place] = corners.first[*v as usize];
                corners.first[*v as usize] = f;
            }
        }
        corners
    }

    /// The triangles at a vertex that are not in its largest fan.
    fn surplus(&mut self, v: u32, triangles: &[[u32; 3]], dropped: &[bool]) -> Vec<u32> {
        self.around.clear();
        let mut f = self.first[v as usize];
        while f != NONE {
            let [a, b, c] = triangles[f as usize];
            let (place, wedge) = if a == v {
                (0, [b, c])
            } else if b == v {
                (1, [c, a])
            } else {
                (2, [a, b])
            };
            if !dropped[f as usize] {
                self.around.push((f, wedge, 0));
            }
            f = self.next[f as usize][place];
        }
        // Neighbors in a fan share an edge, which they run along in opposite directions: the end of one
        // wedge is the start of the next.
        let mut by_start: Vec<(u32, usize)> = (self.around.iter().enumerate())
            .map(|(t, (_, wedge, _))| (wedge[0], t))
            .collect();
        by_start.sort_unstable();
        let next = |end: u32| {
            let found = by_start.binary_search_by_key(&end, |s| s.0);
            found.ok().map(|place| by_start[place].1)
        };
        let mut sets = Groups::new(self.around.len());
        for (t, (_, wedge, _)) in self.around.iter().enumerate() {
            if let Some(n) = next(wedge[1]) {
                sets.join(index(t), index(n), false);
            }
        }
        let mut sizes = vec![0usize; self.around.len()];
        for (t, corner) in self.around.iter_mut().enumerate() {
            corner.2 = sets.find(index(t)).0 as usize;
            sizes[corner.2] += 1;
        }
        // Fans by their first triangle, whatever their root.
        let largest = (self.around.iter().map(|t| t.2).rev()).max_by_key(|fan| sizes[*fan]);
        (self.around.iter())
            .filter(|t| Some(t.2) != largest)
            .map(|t| t.0)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_fan_stays() {
        let one = vec![[0, 1, 2], [0, 2, 3]];
        assert_eq!(single_fans(one.clone(), 6), one);
        let two = vec![[0, 4, 5], [0, 1, 2], [0, 2, 3]];
        assert_eq!(single_fans(two, 6), one);
        let equal = vec![[0, 4, 5], [0, 1, 2]];
        assert_eq!(single_fans(equal, 6), [[0, 4, 5]]);
    }

    #[test]
    fn what_is_dropped_may_leave_others_to_drop() {
        // A ring around 0, a triangle that touches it, and two that touch that one.
        let ring = [[0, 1, 2], [0, 2, 3], [0, 3, 1]];
        let mut all = ring.to_vec();
        all.extend([[1, 4, 5], [4, 6, 7], [4, 7, 8]]);
        let kept = single_fans(all, 9);
        assert_eq!(
            kept,
            [[0, 1, 2], [0, 2, 3], [0, 3, 1], [4, 6, 7], [4, 7, 8]]
        );
    }
}
