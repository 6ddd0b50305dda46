//! Closest points on a mesh.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::{PreparedTriangle, TriMesh};

/// Most triangles in a leaf of the tree of boxes.
const LEAF: usize = 4;

/// The deepest a tree can be: a leaf for every two of 2³² triangles, and one more level.
const MOST_LEVELS: usize = 32;

/// Finds the closest points on a mesh: a binary tree of boxes over its triangles, built once, each box cut at the
/// median across its longest side.
///
/// # Reference
/// C. Ericson: *Real-Time Collision Detection.* Morgan Kaufmann, 2005, §6.2 and 6.6.
#[derive(Debug)]
pub struct ClosestPoints {
    /// Leaf by leaf, with the number that each had.
    triangles: Vec<(PreparedTriangle, u32)>,
    /// The root in 1, the two parts of box i in 2 i and 2 i + 1, the leaves at the end.
    boxes: Vec<Aabb>,
    /// Where each leaf's triangles begin, and their number.
    starts: Vec<usize>,
}

/// A box along the axes: lowest and highest coordinates.
#[derive(Debug, Clone, Copy)]
struct Aabb {
    low: Point3<f64>,
    high: Point3<f64>,
}

/// The closest point so far.
#[derive(Debug, Clone, Copy)]
struct Found {
    distance_sq: f64,
    /// Place of its triangle in the leaves.
    at: usize,
    shares: [f64; 2],
}

impl ClosestPoints {
    /// Over all triangles of a mesh.
    ///
    /// # Panics
    /// If there are 2³² triangles or more.
    #[must_use]
    pub fn new(mesh: &TriMesh) -> Self {
        let count = u32::try_from(mesh.triangles.len()).expect("indices are u32");
        let mut centers: Vec<(Point3<f64>, u32)> = (0..count)
            .map(|f| {
                let [a, b, c] = mesh.corners(f as usize);
                (Point3::from((a.coords + b.coords + c.coords) / 3.0), f)
            })
            .collect();
        let width = centers.len().div_ceil(LEAF).next_power_of_two();
        sort_into_leaves(&mut centers, width);
        let mut starts = vec![0, centers.len()];
        while starts.len() <= width {
            starts = halved(&starts);
        }
        let leaf = |ends: &[usize]| {
            let corners =
                (centers[ends[0]..ends[1]].iter()).flat_map(|c| mesh.corners(c.1 as usize));
            corners.fold(Aabb::EMPTY, |all, p| all.with(&Aabb { low: p, high: p }))
        };
        let mut boxes = vec![Aabb::EMPTY; width];
        boxes.extend(starts.windows(2).map(leaf));
        for i in (1..width).rev() {
            boxes[i] = boxes[2 * i].with(&boxes[2 * i + 1]);
        }
        let prepared = |f: u32| (PreparedTriangle::new(mesh.corners(f as usize)), f);
        Self {
            triangles: centers.par_iter().map(|c| prepared(c.1)).collect(),
            boxes,
            starts,
        }
    }

    /// The point of the mesh that is closest to `point`: its triangle, its barycentric coordinates there,
    /// and its distance. With a `normal` (of any length) only triangles that do not face away from it
    /// count, unless all do. Of several as close, the one of the triangle with the lowest number. `None`
    /// on a mesh without triangles, or for a point that is not finite.
    #[must_use]
    pub fn closest(
        &self,
        point: &Point3<f64>,
        normal: Option<&Vector3<f64>>,
    ) -> Option<(u32, [f64; 3], f64)> {
        let facing = normal.and_then(|normal| {
            self.search(point, |t: &PreparedTriangle| t.normal().dot(normal) >= 0.0)
        });
        let found = facing.or_else(|| self.search(point, |_| true))?;
        let [s, t] = found.shares;
        let number = self.triangles[found.at].1;
        let weights = [(1.0 - s - t).max(0.0), s, t];
        Some((number, weights, found.distance_sq.sqrt()))
    }

    fn search(
        &self,
        point: &Point3<f64>,
        counts: impl Fn(&PreparedTriangle) -> bool,
    ) -> Option<Found> {
        let width = self.boxes.len() / 2;
        let mut best: Option<Found> = None;
        // Boxes to be looked into with their distances; the nearer part is looked into first.
        let mut waiting = [(0, 0.0); MOST_LEVELS];
        let mut count = 0;
        let mut next = Some((1, self.boxes[1].distance_sq(point)));
        while let Some((i, distance_sq)) = next {
            let limit = best.map_or(f64::MAX, |b| b.distance_sq);
            let mut onward = None;
            if distance_sq > limit {
                // Nothing there can be closer.
            } else if i >= width {
                self.look_into(i - width, point, &counts, &mut best);
            } else {
                let parts = [2 * i, 2 * i + 1].map(|i| (i, self.boxes[i].distance_sq(point)));
                let [near, far] = if parts[1].1 < parts[0].1 {
                    [parts[1], parts[0]]
                } else {
                    parts
                };
                if far.1 <= limit {
                    waiting[count] = far;
                    count += 1;
                }
                onward = Some(near);
            }
            next = onward.or_else(|| {
                count = count.checked_sub(1)?;
                Some(waiting[count])
            });
        }
        best
    }

    fn look_into(
        &self,
        leaf: usize,
        point: &Point3<f64>,
        counts: &impl Fn(&PreparedTriangle) -> bool,
        best: &mut Option<Found>,
    ) {
        for at in self.starts[leaf]..self.starts[leaf + 1] {
            let (triangle, number) = &self.triangles[at];
            let is_far = best.is_some_and(|b| triangle.plane_distance_sq(point) > b.distance_sq);
            if is_far || !counts(triangle) {
                continue;
            }
            let shares = triangle.closest(point);
            let distance_sq = (point - triangle.point(shares)).norm_squared();
            let is_closer = best.is_none_or(|best| {
                let order = distance_sq.total_cmp(&best.distance_sq);
                order.then(number.cmp(&self.triangles[best.at].1)).is_lt()
            });
            if is_closer && distance_sq.is_finite() {
                *best = Some(Found {
                    distance_sq,
                    at,
                    shares,
                });
            }
        }
    }
}

/// Sorts by place, so that cutting at the middle again and again, until there are `leaves` parts, puts together
/// what is close; of equal places what has the lower number comes first.
fn sort_into_leaves(centers: &mut [(Point3<f64>, u32)], leaves: usize) {
    if leaves < 2 || centers.len() < 2 {
        return;
    }
    let all = centers.iter().fold(Aabb::EMPTY, |all, (p, _)| {
        all.with(&Aabb { low: *p, high: *p })
    });
    let axis = (all.high - all.low).imax();
    let middle = centers.len() / 2;
    centers.select_nth_unstable_by(middle, |a, b| {
        a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1))
    });
    let (low, high) = centers.split_at_mut(middle);
    rayon::join(
        || sort_into_leaves(low, leaves / 2),
        || sort_into_leaves(high, leaves / 2),
    );
}

/// The bounds with the middle of each two between them.
fn halved(bounds: &[usize]) -> Vec<usize> {
    let halves = bounds
        .windows(2)
        .flat_map(|b| [b[0], b[0] + (b[1] - b[0]) / 2]);
    halves.chain(bounds.last().copied()).collect()
}

impl Aabb {
    /// Nothing: farther than any distance from everything.
    const EMPTY: Self = Self {
        low: Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Point3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    fn with(&self, other: &Self) -> Self {
        Self {
            low: self.low.inf(&other.low),
            high: self.high.sup(&other.high),
        }
    }

    /// Squared distance to a point, 0 inside; a little less, for rounding.
    #[inline]
    fn distance_sq(&self, p: &Point3<f64>) -> f64 {
        let outside = |i: usize| (self.low[i] - p[i]).max(p[i] - self.high[i]).max(0.0);
        let [x, y, z] = [0, 1, 2].map(outside);
        (x * x + y * y + z * z) * (1.0 - 1e-12)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Rng, Stage};

    /// Triangles of all sizes and shapes, some without area.
    fn soup(seed: u32, triangles: u32) -> TriMesh {
        let mut rng = Rng::new(seed, Stage::Synth, 0);
        let mut mesh = TriMesh::default();
        for f in 0..triangles {
            let mut coordinate = |size: f64| size * (rng.uniform() - 0.5);
            let size = 0.01 + coordinate(2.0).max(0.0).powi(3);
            let center = Vector3::from([0; 3].map(|_| coordinate(2.0)));
            for corner in 0..3 {
                let off = Vector3::from([0; 3].map(|_| coordinate(size)));
                let off = if f % 7 == 0 && corner > 0 {
                    off * 0.0
                } else {
                    off
                };
                mesh.positions.push(Point3::from(center + off));
            }
            mesh.triangles.push([3 * f, 3 * f + 1, 3 * f + 2]);
        }
        mesh
    }

    fn plain(mesh: &TriMesh, p: &Point3<f64>, normal: Option<&Vector3<f64>>) -> (f64, bool) {
        let distances = |facing: bool| {
            (0..mesh.triangles.len())
                .map(|f| PreparedTriangle::new(mesh.corners(f)))
                .filter(|t| !facing || normal.is_none_or(|n| t.normal().dot(n) >= 0.0))
                .map(|t| (p - t.point(t.closest(p))).norm())
                .min_by(f64::total_cmp)
        };
        match distances(true) {
            Some(distance) => (distance, true),
            None => (distances(false).unwrap(), false),
        }
    }

    #[test]
    fn the_closest_point_is_that_of_a_search_through_all_triangles() {
        for (seed, triangles) in [(1, 1), (2, 3), (3, 5), (4, 200), (5, 333)] {
            let mesh = soup(seed, triangles);
            let tree = ClosestPoints::new(&mesh);
            let mut rng = Rng::new(seed, Stage::Synth, 1);
            for query in 0..100 {
                let p = Point3::from([0; 3].map(|_| 3.0 * rng.uniform() - 1.5));
                let normal = Vector3::from([0; 3].map(|_| rng.uniform() - 0.5));
                let normal = (query % 2 == 0).then_some(&normal);
                let (triangle, weights, distance) = tree.closest(&p, normal).unwrap();
                let (expected, facing) = plain(&mesh, &p, normal);
                assert!((distance - expected).abs() < 1e-12);
                assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                assert!(weights.iter().all(|w| *w >= 0.0));
                let corners = mesh.corners(triangle as usize);
                let at: Vector3<f64> = (corners.iter().zip(weights))
                    .map(|(corner, weight)| corner.coords * weight)
                    .sum();
                assert!(((p.coords - at).norm() - distance).abs() < 1e-9);
                let own = PreparedTriangle::new(corners);
                assert!(!facing || normal.is_none_or(|n| own.normal().dot(n) >= 0.0));
            }
        }
    }

    #[test]
    fn a_normal_keeps_to_one_side_of_a_thin_slab() {
        let square =
            |z: f64| [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Point3::new(x, y, z));
        let slab = TriMesh {
            positions: [square(0.01), square(0.0)].concat(),
            triangles: vec![[0, 1, 2], [3, 5, 4]],
        };
        let tree = ClosestPoints::new(&slab);
        let p = Point3::new(0.2, 0.2, 0.004);
        assert_eq!(tree.closest(&p, None).unwrap().0, 1);
        assert_eq!(tree.closest(&p, Some(&Vector3::z())).unwrap().0, 0);
        assert_eq!(tree.closest(&p, Some(&-Vector3::z())).unwrap().0, 1);
        // All face away: as if none were asked for.
        let one = TriMesh {
            triangles: vec![[0, 1, 2]],
            ..slab
        };
        assert!(
            ClosestPoints::new(&one)
                .closest(&p, Some(&-Vector3::z()))
                .is_some()
        );
    }

    #[test]
    fn without_triangles_or_for_a_point_that_is_not_finite_nothing_is_closest() {
        let p = Point3::origin();
        assert_eq!(
            ClosestPoints::new(&TriMesh::default()).closest(&p, None),
            None
        );
        let tree = ClosestPoints::new(&soup(1, 20));
        assert_eq!(tree.closest(&Point3::new(f64::NAN, 0.0, 0.0), None), None);
        assert_eq!(
            tree.closest(&Point3::new(f64::INFINITY, 0.0, 0.0), None),
            None
        );
    }
}
