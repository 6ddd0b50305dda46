//! A boundary loop of the input, which boundary vertices slide along.

use std::collections::BTreeSet;

use nalgebra::Point3;

use super::OnTriangle;
use super::half_edges::HalfEdges;
use crate::mesh::TriMesh;

/// Turn of the boundary, in radians, from which on a corner is kept: 45 degrees.
const CORNER_TURN: f64 = std::f64::consts::FRAC_PI_4;

/// A closed polyline along the edges that the surface ends at, with the surface on its left. What is at
/// arc length s is also at s plus its length.
#[derive(Debug)]
pub(super) struct Rim {
    /// Its edges: triangle, and number of the edge there.
    edges: Vec<(u32, u32)>,
    points: Vec<Point3<f64>>,
    /// Arc length at the start of each edge, and the whole; strictly ascending.
    lengths: Vec<f64>,
}

impl Rim {
    /// All of a mesh, whose triangles `edges` has joined and not changed; and by vertex of those the rim that
    /// it is on and its arc length there.
    pub(super) fn all(mesh: &TriMesh, edges: &HalfEdges) -> (Vec<Self>, Vec<Option<(u32, f64)>>) {
        let mut rims = Vec::new();
        let mut on = vec![None; edges.vertex_numbers() as usize];
        for v in 0..edges.vertex_numbers() {
            if !edges.is_boundary(v) || on[v as usize].is_some() {
                continue;
            }
            let first = edges.outgoing(v);
            let mut walk = vec![first];
            while let h = edges.next_on_boundary(walk[walk.len() - 1])
                && h != first
            {
                walk.push(h);
            }
            let rim = Self::along(mesh, &walk);
            let number = u32::try_from(rims.len()).expect("indices are u32");
            for (h, length) in walk.iter().zip(&rim.lengths) {
                on[edges.origin(*h) as usize] = Some((number, *length));
            }
            rims.push(rim);
        }
        (rims, on)
    }

    fn along(mesh: &TriMesh, walk: &[u32]) -> Self {
        let points: Vec<Point3<f64>> = (walk.iter())
            .map(|h| mesh.corners(*h as usize / 3)[*h as usize % 3])
            .collect();
        let ends = points.iter().skip(1).chain(&points[..1]);
        let edges: Vec<f64> = points
            .iter()
            .zip(ends)
            .map(|(p, q)| (q - p).norm())
            .collect();
        // An edge without length gets one, so that no two places share an arc length.
        let longest = edges.iter().copied().fold(0.0, f64::max);
        let least = if longest > 0.0 { 1e-9 * longest } else { 1.0 };
        let mut lengths = vec![0.0];
        for edge in edges {
            lengths.push(lengths[lengths.len() - 1] + edge.max(least));
        }
        Self {
            edges: walk.iter().map(|h| (h / 3, h % 3)).collect(),
            points,
            lengths,
        }
    }

    pub(super) fn length(&self) -> f64 {
        self.lengths[self.edges.len()]
    }

    /// Arc length from one place forward to another, above 0.
    pub(super) fn forward(&self, from: f64, to: f64) -> f64 {
        if to > from {
            to - from
        } else {
            to - from + self.length()
        }
    }

    /// The arc length, from 0 on, of a place a way forward (or back) from another.
    pub(super) fn moved(&self, from: f64, way: f64) -> f64 {
        let along = (from + way).rem_euclid(self.length());
        if along < self.length() { along } else { 0.0 }
    }

    /// What is there.
    pub(super) fn place(&self, along: f64) -> OnTriangle {
        let last = self.edges.len() - 1;
        let edge = self
            .lengths
            .partition_point(|l| *l <= along)
            .clamp(1, last + 1)
            - 1;
        let (start, end) = (self.lengths[edge], self.lengths[edge + 1]);
        let share = ((along - start) / (end - start)).clamp(0.0, 1.0);
        let (triangle, corner) = self.edges[edge];
        let mut weights = [0.0; 3];
        weights[corner as usize] = 1.0 - share;
        weights[(corner as usize + 1) % 3] = share;
        OnTriangle { triangle, weights }
    }

    fn point(&self, along: f64) -> Point3<f64> {
        let edge = self
            .lengths
            .partition_point(|l| *l <= along)
            .clamp(1, self.edges.len())
            - 1;
        let (start, end) = (self.lengths[edge], self.lengths[edge + 1]);
        let next = self.points[(edge + 1) % self.points.len()];
        self.points[edge] + (next - self.points[edge]) * ((along - start) / (end - start))
    }

    /// Arc lengths of the points where it turns by more than 45 degrees between what is `reach` before and
    /// behind, each sharper than any other within that reach; ascending.
    pub(super) fn corners(&self, reach: f64) -> Vec<f64> {
        // A round rim has none: a twelfth of a circle turns by 30 degrees.
        let reach = reach.min(self.length() / 12.0);
        let turn = |along: f64| {
            let here = self.point(along);
            let back = here - self.point(self.moved(along, -reach));
            let on = self.point(self.moved(along, reach)) - here;
            back.angle(&on)
        };
        let starts = &self.lengths[..self.edges.len()];
        let mut sharp: Vec<(f64, f64)> = (starts.iter())
            .map(|along| (turn(*along), *along))
            .filter(|(turn, _)| *turn > CORNER_TURN)
            .collect();
        sharp.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
        // Numbers that are not below 0 sort as their bits do.
        let mut corners: BTreeSet<u64> = BTreeSet::new();
        for (_, along) in sharp {
            let bits = along.to_bits();
            let before = corners.range(..bits).next_back().or(corners.last());
            let behind = corners.range(bits..).next().or(corners.first());
            let apart = |other: &u64| {
                let gap = (along - f64::from_bits(*other)).abs();
                gap.min(self.length() - gap) > reach
            };
            if before.is_none_or(apart) && behind.is_none_or(apart) {
                corners.insert(bits);
            }
        }
        corners.into_iter().map(f64::from_bits).collect()
    }
}
