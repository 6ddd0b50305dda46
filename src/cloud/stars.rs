//! Each point's Delaunay star among its neighbors, in its own tangent plane.

use nalgebra::{Unit, Vector2, Vector3};

use super::fans::cross;
use super::points::{Neighbors, Points, Spacing, index};
use crate::base::perpendicular_frame;

/// Neighbors that are asked when the first ones do not settle a star.
const MANY: usize = 64;

/// Points nearer to a circle than this share of its radius are on it: then all stars cut the polygon
/// of these points in the same way. Larger than rounding, smaller than what a scanner tells.
const ON_CIRCLE: f64 = 1e-7;

/// What stars are made of.
#[derive(Debug)]
pub(super) struct Stars<'a> {
    pub(super) points: &'a Points,
    pub(super) neighbors: &'a Neighbors,
    pub(super) normals: &'a [Vector3<f64>],
    pub(super) spacing: &'a Spacing,
    pub(super) gap: f64,
}

/// A neighbor in the tangent plane, inverted at the unit circle.
#[derive(Debug, Clone, Copy)]
struct Inverted {
    point: u32,
    at: Vector2<f64>,
}

impl Stars<'_> {
    /// The longest edge between two points.
    pub(super) fn longest_edge(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|v| self.spacing.local[v as usize]);
        self.gap * a.max(b)
    }

    /// The triangles of a point's star, counterclockwise around its normal, each starting with its
    /// lowest point.
    pub(super) fn triangles(&self, i: usize) -> Vec<[u32; 3]> {
        let few = self.neighbors.of(i);
        let (mut star, settled) = self.star(i, few);
        if !settled && few.len() < MANY {
            star = self.star(i, &self.neighbors.more(self.points, i, MANY)).0;
        }
        let short = |&[a, b]: &[u32; 2]| self.points.distance(a, b) <= self.longest_edge(a, b);
        let i = index(i);
        (star.into_iter().filter(short))
            .map(|[a, b]| lowest_first([i, a, b]))
            .collect()
    }

    /// The star among some neighbors, nearest first, and whether farther ones could not change it.
    ///
    /// Inversion makes lines of the circles through the point: its Delaunay triangles are those edges
    /// of the inverted neighbors' convex hull that have the point on their inner side.
    fn star(&self, i: usize, neighbors: &[u32]) -> (Vec<[u32; 2]>, bool) {
        let inverted = self.inverted(i, neighbors);
        let reach = neighbors
            .last()
            .map_or(0.0, |j| self.points.distance(index(i), *j));
        let mut settled = true;
        let mut star = Vec::new();
        let hull = hull(&inverted);
        for (n, a) in hull.iter().enumerate() {
            let b = hull[(n + 1) % hull.len()];
            let length = (b.at - a.at).norm();
            let height = cross(a.at, b.at) / length;
            if height > 0.0 {
                settled &= 1.0 / height <= reach;
                let polygon = on_line(&inverted, *a, b, height);
                star.extend(cut(index(i), &polygon));
            } else {
                settled = false;
            }
        }
        // All that could be joined to the point was there.
        let complete = reach > self.gap * self.spacing.local[i];
        (star, hull.len() > 2 && settled || complete)
    }

    /// The neighbors that an edge may join and that face the same side, in the tangent plane at their
    /// true distance (Gopi, Krishnan & Silva 2000), inverted.
    fn inverted(&self, i: usize, neighbors: &[u32]) -> Vec<Inverted> {
        let (origin, normal) = (self.points.positions[i], self.normals[i]);
        let [x, y] = perpendicular_frame(&Unit::new_unchecked(normal));
        let invert = |&j: &u32| {
            let d = self.points.positions[j as usize] - origin;
            let distance = d.norm();
            let faces = self.normals[j as usize].dot(&normal) > 0.0;
            let near = distance <= self.longest_edge(index(i), j);
            let flat = Vector2::new(d.dot(&x), d.dot(&y)).try_normalize(0.0);
            let flat = flat.filter(|_| faces && near && distance > 0.0)?;
            Some(Inverted {
                point: j,
                at: flat / distance,
            })
        };
        neighbors.iter().filter_map(invert).collect()
    }
}

/// The same triangle from its lowest corner on.
pub(super) fn lowest_first(mut triangle: [u32; 3]) -> [u32; 3] {
    let lowest = (0..3).min_by_key(|n| triangle[*n]).unwrap_or(0);
    triangle.rotate_left(lowest);
    triangle
}

/// Convex hull, counterclockwise, without points on its edges (A. M. Andrew, 1979).
fn hull(points: &[Inverted]) -> Vec<Inverted> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| {
        let order = a.at.x.total_cmp(&b.at.x).then(a.at.y.total_cmp(&b.at.y));
        order.then(a.point.cmp(&b.point))
    });
    sorted.dedup_by(|a, b| a.at == b.at);
    if sorted.len() < 3 {
        return sorted;
    }
    let half = |points: &mut dyn Iterator<Item = &Inverted>| {
        let mut chain: Vec<Inverted> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if cross(b.at - a.at, p.at - a.at) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut sorted.iter());
    hull.extend(half(&mut sorted.iter().rev()));
    hull
}

/// `a`, the points on the line to `b` in their order, `b`; `height` is the line's from the origin.
fn on_line(points: &[Inverted], a: Inverted, b: Inverted, height: f64) -> Vec<u32> {
    let along = (b.at - a.at).normalize();
    let length = (b.at - a.at).norm();
    let mut between: Vec<(f64, u32)> = (points.iter())
        .filter(|p| p.point != a.point && p.point != b.point)
        .filter(|p| cross(along, p.at - a.at).abs() <= ON_CIRCLE * height)
        .map(|p| (along.dot(&(p.at - a.at)), p.point))
        .filter(|(place, _)| *place > 0.0 && *place < length)
        .collect();
    between.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let between = between.into_iter().map(|(_, point)| point);
    [a.point]
        .into_iter()
        .chain(between)
        .chain([b.point])
        .collect()
}

/// A point's share in the polygon of points on one circle that it makes with `others`, which is cut
/// into a fan around its lowest point, whichever point looks at it.
fn cut(point: u32, others: &[u32]) -> Vec<[u32; 2]> {
    let lowest = (0..others.len()).min_by_key(|n| others[*n]).unwrap_or(0);
    if others.len() == 2 || point < others[lowest] {
        return others.windows(2).map(|w| [w[0], w[1]]).collect();
    }
    let last = others.len() - 1;
    let ends = [others[0], others[lowest], others[last]];
    let mut share = Vec::new();
    if lowest > 0 {
        share.push([ends[0], ends[1]]);
    }
    if lowest < last {
        share.push([ends[1], ends[2]]);
    }
    share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_corners_cut_a_polygon_on_a_circle_alike() {
        for polygon in [
            vec![4, 1, 3, 2],
            vec![5, 2, 9, 1, 7, 3],
            vec![0, 1, 2, 3, 4],
        ] {
            let n = polygon.len();
            let mut votes = std::collections::BTreeMap::new();
            for i in 0..n {
                let others: Vec<u32> = (1..n).map(|k| polygon[(i + k) % n]).collect();
                for [a, b] in cut(polygon[i], &others) {
                    *votes.entry(lowest_first([polygon[i], a, b])).or_insert(0) += 1;
                }
            }
            assert_eq!(votes.len(), n - 2);
            assert!(votes.values().all(|v| *v == 3), "{votes:?}");
        }
    }

    #[test]
    fn a_hull_has_the_outer_points_only() {
        let at = |point, x, y| Inverted {
            point,
            at: Vector2::new(x, y),
        };
        let points = [
            at(0, 0.0, 0.0),
            at(1, 2.0, 0.0),
            at(2, 1.0, 0.5),
            at(3, 2.0, 2.0),
            at(4, 0.0, 2.0),
            at(5, 1.0, 0.0),
        ];
        let hull: Vec<u32> = hull(&points).iter().map(|p| p.point).collect();
        assert_eq!(hull, [0, 1, 3, 4]);
    }
}
