//! A polygon in space to triangles between its corners: the first guess at what is missing in a hole.
//!
//! # Reference
//! [Liepa 2003](crate::bibliography#liepa-2003), the first step: the triangulation whose sharpest fold is least,
//! and among these the one with the least area.

use nalgebra::{Point3, Vector3};

use crate::mesh::{triangle_area, triangle_normal};

/// Polygons with more corners are triangulated in two steps: the time grows with the cube.
const MOST_CORNERS: usize = 160;

/// A closed walk around a hole, the hole on its left; a corner may come more than once.
#[derive(Debug, Clone, Default)]
pub(super) struct Polygon {
    pub(super) vertices: Vec<u32>,
    pub(super) points: Vec<Point3<f64>>,
    /// For each side, from its corner to the next: the unit normal of the surface beyond it, zero where
    /// there is none.
    pub(super) beyond: Vec<Vector3<f64>>,
}

impl Polygon {
    pub(super) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// The same hole with an island in it: walked to along the shortest bridge, around, and back.
    pub(super) fn with_island(&self, island: &Self) -> Self {
        let distance =
            |&(i, j): &(usize, usize)| (self.points[i] - island.points[j]).norm_squared();
        let pairs = (0..self.len()).flat_map(|i| (0..island.len()).map(move |j| (i, j)));
        let nearest = pairs.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let Some((i, j)) = nearest else {
            return self.clone();
        };
        // Sides as (polygon, corner); those of the bridge have nothing beyond them.
        let around = (j..island.len()).chain(0..=j);
        let mut joint = Self::default();
        for corner in 0..=i {
            joint.push(self, corner, corner < i);
        }
        let count = island.len();
        for (k, corner) in around.enumerate() {
            joint.push(island, corner, k < count);
        }
        for corner in i..self.len() {
            joint.push(self, corner, true);
        }
        joint
    }

    fn push(&mut self, from: &Self, corner: usize, has_side: bool) {
        self.vertices.push(from.vertices[corner]);
        self.points.push(from.points[corner]);
        let beyond = if has_side {
            from.beyond[corner]
        } else {
            Vector3::zeros()
        };
        self.beyond.push(beyond);
    }

    /// Whether it comes through every vertex once, and encloses something.
    pub(super) fn is_simple(&self) -> bool {
        let mut vertices = self.vertices.clone();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.len() == self.len() && self.len() > 2
    }

    pub(super) fn centroid(&self) -> Point3<f64> {
        let sum: Vector3<f64> = self.points.iter().map(|p| p.coords).sum();
        Point3::from(sum / self.len().max(1) as f64)
    }

    /// Some of the corners, ascending, joined by straight sides.
    fn chosen(&self, corners: &[usize]) -> Self {
        let mut chosen = Self::default();
        for (k, corner) in corners.iter().enumerate() {
            let is_side = corners.get(k + 1) == Some(&(corner + 1));
            chosen.push(self, *corner, is_side);
        }
        chosen
    }
}

/// Triangles over the polygon, as triples of its corners' numbers, with the walk's orientation. `joined`
/// tells of two vertices whether the scan has an edge between them: no further one can be.
///
/// `None` if every triangulation would double an edge.
pub(super) fn triangulate(
    polygon: &Polygon,
    joined: &dyn Fn(u32, u32) -> bool,
) -> Option<Vec<[usize; 3]>> {
    if polygon.len() <= MOST_CORNERS {
        return least_fold(polygon, joined);
    }
    // A coarse polygon first, then what is between each of its sides and the walk.
    let stride = polygon.len().div_ceil(MOST_CORNERS);
    let coarse: Vec<usize> = (0..polygon.len()).step_by(stride).collect();
    let mut triangles: Vec<[usize; 3]> = least_fold(&polygon.chosen(&coarse), joined)?
        .into_iter()
        .map(|t| t.map(|corner| coarse[corner]))
        .collect();
    for (k, first) in coarse.iter().enumerate() {
        let last = coarse.get(k + 1).copied().unwrap_or(polygon.len());
        let corners: Vec<usize> = (*first..=last).map(|c| c % polygon.len()).collect();
        if corners.len() > 2 {
            let mut strip = Polygon::default();
            for corner in &corners {
                strip.push(polygon, *corner, *corner != last % polygon.len());
            }
            let fine = least_fold(&strip, joined)?;
            triangles.extend(fine.into_iter().map(|t| t.map(|corner| corners[corner])));
        }
    }
    Some(triangles)
}

/// The fold of a triangle whose corners are in line: as bad as can be, but possible.
const FLAT_FOLD: f64 = 2.0;

/// How bad a triangulation is: one minus the cosine of its sharpest fold, then its area.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Weight {
    fold: f64,
    area: f64,
}

impl Weight {
    const NOTHING: Self = Self {
        fold: 0.0,
        area: 0.0,
    };
    const IMPOSSIBLE: Self = Self {
        fold: f64::INFINITY,
        area: f64::INFINITY,
    };

    fn with(self, other: Self) -> Self {
        Self {
            fold: self.fold.max(other.fold),
            area: self.area + other.area,
        }
    }

    fn is_less(self, other: Self) -> bool {
        // Folds that differ by rounding only do not decide.
        if (self.fold - other.fold).abs() > 1e-9 || !other.fold.is_finite() {
            self.fold < other.fold
        } else {
            self.area < other.area
        }
    }
}

/// The best triangulations of all parts of the walk, from corner i to corner j > i.
struct Table {
    size: usize,
    weights: Vec<Weight>,
    /// The third corner of the triangle over the side from j back to i.
    middles: Vec<usize>,
}

impl Table {
    fn weight(&self, i: usize, j: usize) -> Weight {
        self.weights[i * self.size + j]
    }

    fn middle(&self, i: usize, j: usize) -> usize {
        self.middles[i * self.size + j]
    }
}

fn least_fold(polygon: &Polygon, joined: &dyn Fn(u32, u32) -> bool) -> Option<Vec<[usize; 3]>> {
    let n = polygon.len();
    if n < 3 {
        return None;
    }
    let mut table = Table {
        size: n,
        weights: vec![Weight::NOTHING; n * n],
        middles: vec![0; n * n],
    };
    for span in 2..n {
        for i in 0..n - span {
            let j = i + span;
            let (mut best, mut middle) = (Weight::IMPOSSIBLE, i + 1);
            if allowed(polygon, i, j, joined) {
                for m in i + 1..j {
                    let weight = over(polygon, &table, [i, m, j]);
                    if weight.is_less(best) {
                        (best, middle) = (weight, m);
                    }
                }
            }
            table.weights[i * n + j] = best;
            table.middles[i * n + j] = middle;
        }
    }
    if !table.weight(0, n - 1).fold.is_finite() {
        return None;
    }
    let mut triangles = Vec::with_capacity(n - 2);
    let mut open = vec![(0, n - 1)];
    while let Some((i, j)) = open.pop() {
        if j - i >= 2 {
            let m = table.middle(i, j);
            triangles.push([i, m, j]);
            open.extend([(i, m), (m, j)]);
        }
    }
    Some(triangles)
}

/// Whether there may be an edge between two corners: the closing side of the walk, or a new one.
fn allowed(polygon: &Polygon, i: usize, j: usize, joined: &dyn Fn(u32, u32) -> bool) -> bool {
    let [a, b] = [polygon.vertices[i], polygon.vertices[j]];
    let closing = i == 0 && j + 1 == polygon.len();
    closing || (a != b && !joined(a, b))
}

/// Weight of the part from i to j with the triangle (i, m, j) at its end.
fn over(polygon: &Polygon, table: &Table, [i, m, j]: [usize; 3]) -> Weight {
    let (first, second) = (table.weight(i, m), table.weight(m, j));
    if !first.fold.is_finite() || !second.fold.is_finite() {
        return Weight::IMPOSSIBLE;
    }
    let corners = [i, m, j].map(|corner| polygon.points[corner]);
    let area = triangle_area(corners);
    let normal = unit_normal(corners);
    if normal.norm_squared() <= 0.0 {
        return first.with(second).with(Weight {
            fold: FLAT_FOLD,
            area,
        });
    }
    let mut fold = fold_across(polygon, table, &normal, i, m);
    fold = fold.max(fold_across(polygon, table, &normal, m, j));
    if i == 0 && j + 1 == polygon.len() {
        fold = fold.max(fold_between(&normal, &polygon.beyond[j]));
    }
    first.with(second).with(Weight { fold, area })
}

fn fold_across(polygon: &Polygon, table: &Table, normal: &Vector3<f64>, i: usize, j: usize) -> f64 {
    if j == i + 1 {
        return fold_between(normal, &polygon.beyond[i]);
    }
    let corners = [i, table.middle(i, j), j].map(|corner| polygon.points[corner]);
    fold_between(normal, &unit_normal(corners))
}

/// Zero for corners in line: what is left of their area is rounding.
fn unit_normal([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    let longest = (b - a).norm_squared().max((c - a).norm_squared());
    let normal = triangle_normal([a, b, c]);
    let least = 1e-9 * longest;
    normal.try_normalize(least).unwrap_or_default()
}

fn fold_between(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    if b.norm_squared() > 0.0 {
        1.0 - a.dot(b)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::TAU;

    fn polygon(points: Vec<Point3<f64>>) -> Polygon {
        Polygon {
            vertices: (0u32..).take(points.len()).collect(),
            beyond: vec![Vector3::zeros(); points.len()],
            points,
        }
    }

    fn star(corners: u32, wave: f64) -> Polygon {
        let corner = |k: u32| {
            let angle = TAU * f64::from(k) / f64::from(corners);
            let radius = 1.0 + wave * (5.0 * angle).cos();
            Point3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        };
        polygon((0..corners).map(corner).collect())
    }

    fn area(polygon: &Polygon, triangles: &[[usize; 3]]) -> f64 {
        (triangles.iter())
            .map(|t| triangle_area(t.map(|corner| polygon.points[corner])))
            .sum()
    }

    fn enclosed(polygon: &Polygon) -> f64 {
        let next = |i: usize| polygon.points[(i + 1) % polygon.len()];
        (0..polygon.len())
            .map(|i| 0.5 * polygon.points[i].coords.cross(&next(i).coords).z)
            .sum()
    }

    #[test]
    fn a_flat_polygon_is_covered_once_however_many_corners_and_notches_it_has() {
        for (corners, wave) in [(3, 0.0), (17, 0.3), (90, 0.6)] {
            let star = star(corners, wave);
            let triangles = triangulate(&star, &|_, _| false).unwrap();
            assert_eq!(triangles.len() + 2, star.len());
            assert_relative_eq!(area(&star, &triangles), enclosed(&star), epsilon = 1e-9);
        }
        let many = star(1000, 0.3);
        let triangles = triangulate(&many, &|_, _| false).unwrap();
        assert_eq!(triangles.len() + 2, many.len());
        // Strips beside notches may lie on both sides of a coarse side.
        assert!(area(&many, &triangles) < 1.02 * enclosed(&many));
    }

    #[test]
    fn corners_in_line_are_triangulated_all_the_same() {
        let line = (0..300u32).map(|i| Point3::new(f64::from(i), 0.0, 0.0));
        let mut points: Vec<_> = line.collect();
        points.push(Point3::new(150.0, 100.0, 0.0));
        let triangles = triangulate(&polygon(points), &|_, _| false).unwrap();
        assert_eq!(triangles.len(), 299);
    }

    #[test]
    fn no_edge_is_doubled() {
        let square = star(4, 0.0);
        let triangles = triangulate(&square, &|a, b| (a.min(b), a.max(b)) == (0, 2)).unwrap();
        assert!(
            triangles
                .iter()
                .all(|t| !(t.contains(&0) && t.contains(&2)))
        );
        assert_eq!(triangulate(&square, &|_, _| true), None);
    }

    #[test]
    fn an_island_stays_open() {
        let outer = star(24, 0.0);
        let mut points: Vec<_> = star(9, 0.0).points;
        points.reverse();
        let mut island = polygon(points.iter().map(|p| p * 0.3).collect());
        for v in &mut island.vertices {
            *v += 100;
        }
        let joint = outer.with_island(&island);
        assert_eq!(joint.len(), 24 + 9 + 2);
        let triangles = triangulate(&joint, &|_, _| false).unwrap();
        let expected = enclosed(&outer) + enclosed(&island);
        assert_relative_eq!(area(&joint, &triangles), expected, epsilon = 1e-9);
    }

    #[test]
    fn the_fill_goes_on_from_the_surface_beyond() {
        // A square bent along a diagonal: what is beyond says along which.
        let mut bent = star(4, 0.0);
        bent.points[0].z = 0.5;
        bent.points[2].z = 0.5;
        let along = [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]];
        let normal = |triangles: &[[usize; 3]; 2], side: [usize; 2]| {
            let holds = |t: &&[usize; 3]| side.iter().all(|c| t.contains(c));
            let over = triangles.iter().find(holds).unwrap();
            triangle_normal(over.map(|c| bent.points[c])).normalize()
        };
        for (right, wrong) in [(along[0], along[1]), (along[1], along[0])] {
            let mut bent = bent.clone();
            bent.beyond = ([[0, 1], [1, 2], [2, 3], [3, 0]].into_iter())
                .map(|side| (normal(&right, side) * 3.0 - normal(&wrong, side) * 2.0).normalize())
                .collect();
            let mut found = triangulate(&bent, &|_, _| false).unwrap();
            found.sort_unstable();
            assert_eq!(found, right);
        }
    }
}
