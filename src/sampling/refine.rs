//! A coarse triangulation of a hole to one with vertices about the spacing apart.
//!
//! # Reference
//! [Botsch & Kobbelt 2004](crate::bibliography#botsch--kobbelt-2004), §4: edges that are too long are split,
//! edges that are too short collapsed, edges flipped, and vertices moved along the surface, by turns.

use std::collections::VecDeque;

use nalgebra::{Point3, Vector3};

use super::collapse::Collapse;
use super::patch_mesh::{Diamond, PatchMesh};

/// Edges longer than this many spacings are split: halves and wholes are then equally far off it.
const LONGEST: f64 = 4.0 / 3.0;

/// Edges shorter than this many spacings are collapsed.
const SHORTEST: f64 = 0.7;

/// More rounds are not needed: each halves the longest edges.
const MOST_ROUNDS: usize = 25;

/// Rounds of smoothing after each round of splits, and at the end.
const SMOOTHINGS: usize = 2;
const LAST_SMOOTHINGS: usize = 6;

/// Flips a triangle at most, on average: enough for any triangulation met, and an end where rounding
/// lets two diagonals take turns.
const MOST_FLIPS: usize = 50;

/// How to refine.
pub(super) struct Refinement<'a> {
    /// Vertices up to this one are the rim's: they stay.
    pub(super) rim: usize,
    /// Distance of neighbors, in the scan's unit.
    pub(super) spacing: f64,
    /// Whether two of the rim's vertices have an edge in the scan, so that the fill may not have one
    /// between them.
    pub(super) joined: &'a dyn Fn(u32, u32) -> bool,
}

impl Refinement<'_> {
    /// Adds vertices until no edge is too long, and takes away those that are too close.
    pub(super) fn run(&self, mesh: &mut PatchMesh) {
        self.flip(mesh, less_area);
        for _ in 0..MOST_ROUNDS {
            let split = self.split_long(mesh);
            let collapsed = self.collapse_short(mesh);
            self.flip(mesh, less_area);
            self.even_out(mesh, SMOOTHINGS);
            if !split && !collapsed {
                break;
            }
        }
        self.even_out(mesh, LAST_SMOOTHINGS);
    }

    fn collapse_short(&self, mesh: &mut PatchMesh) -> bool {
        let collapse = Collapse {
            rim: self.rim,
            shortest: SHORTEST * self.spacing,
            longest: LONGEST * self.spacing,
            joined: self.joined,
        };
        collapse.run(mesh)
    }

    /// Moves the added vertices along the surface until they are evenly spread.
    fn even_out(&self, mesh: &mut PatchMesh, rounds: usize) {
        for _ in 0..rounds {
            self.flip(mesh, wider_angles);
            self.smooth(mesh);
        }
        self.flip(mesh, wider_angles);
    }

    /// Splits the edges that are too long, or that the scan has already; the longest first, one of a triangle.
    fn split_long(&self, mesh: &mut PatchMesh) -> bool {
        let mut long: Vec<(f64, usize)> = (0..mesh.half_edges())
            .filter_map(|half_edge| {
                let Diamond { a, b, .. } = mesh.diamond(half_edge)?;
                let length = mesh.length(a, b);
                let doubled = self.are_joined(a, b);
                (a < b && (doubled || length > LONGEST * self.spacing))
                    .then_some((length, half_edge))
            })
            .collect();
        long.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
        let mut touched = vec![false; mesh.triangles.len()];
        for (_, half_edge) in &long {
            let Some(diamond) = mesh.diamond(*half_edge) else {
                continue;
            };
            if (diamond.faces().iter()).all(|f| touched.get(*f) == Some(&false)) {
                for f in diamond.faces() {
                    touched[f] = true;
                }
                mesh.split(&diamond);
            }
        }
        !long.is_empty()
    }

    fn are_joined(&self, a: u32, b: u32) -> bool {
        let on_rim = |v: u32| (v as usize) < self.rim;
        on_rim(a) && on_rim(b) && (self.joined)(a, b)
    }

    /// Flips edges for as long as that makes the surface better.
    fn flip(&self, mesh: &mut PatchMesh, is_better: fn(&PatchMesh, &Diamond) -> bool) {
        let mut queue: VecDeque<usize> = (0..mesh.half_edges()).collect();
        let mut waiting = vec![true; mesh.half_edges()];
        let mut left = MOST_FLIPS * mesh.triangles.len();
        while let (Some(half_edge), true) = (queue.pop_front(), left > 0) {
            waiting[half_edge] = false;
            let Some(diamond) = mesh.diamond(half_edge) else {
                continue;
            };
            let is_taken = |mesh: &PatchMesh| {
                mesh.has_edge(diamond.c, diamond.d)
                    || self.are_joined(diamond.c, diamond.d)
                    || diamond.c == diamond.d
            };
            if !is_better(mesh, &diamond) || is_taken(mesh) {
                continue;
            }
            mesh.flip(&diamond);
            left -= 1;
            for f in diamond.faces() {
                for (k, waits) in waiting[3 * f..3 * f + 3].iter_mut().enumerate() {
                    if !std::mem::replace(waits, true) {
                        queue.push_back(3 * f + k);
                    }
                }
            }
        }
    }

    /// Each added vertex to the middle of its neighbors, but not off the surface.
    fn smooth(&self, mesh: &mut PatchMesh) {
        let coordinates: Vec<Vector3<f64>> = mesh.points.iter().map(|p| p.coords).collect();
        let means = mesh.neighbor_means(&coordinates);
        let mut normals = vec![Vector3::<f64>::zeros(); mesh.points.len()];
        for t in &mesh.triangles {
            let normal = mesh.normal(*t);
            for v in t {
                normals[*v as usize] += normal;
            }
        }
        for v in self.rim..mesh.points.len() {
            if let Some(normal) = normals[v].try_normalize(0.0) {
                let step = means[v] - coordinates[v];
                mesh.points[v] += step - normal * step.dot(&normal);
            }
        }
    }
}

/// Whether the other diagonal makes less surface: what is folded over unfolds.
fn less_area(mesh: &PatchMesh, diamond: &Diamond) -> bool {
    let Diamond { a, b, c, d, .. } = *diamond;
    let area = |corners| mesh.normal(corners).norm();
    area([c, a, d]) + area([d, b, c]) < (1.0 - 1e-9) * (area([a, b, c]) + area([b, a, d]))
}

/// Whether the other diagonal makes a Delaunay pair of the triangles, and no fold.
fn wider_angles(mesh: &PatchMesh, diamond: &Diamond) -> bool {
    let Diamond { a, b, c, d, .. } = *diamond;
    let [pa, pb, pc, pd] = [a, b, c, d].map(|v| mesh.points[v as usize]);
    // Both angles across the edge together are more than half a turn where the sum of their cotangents is
    // negative.
    let cotangent = |tip: Point3<f64>| {
        let (to_a, to_b) = (pa - tip, pb - tip);
        to_a.dot(&to_b) / to_a.cross(&to_b).norm().max(f64::MIN_POSITIVE)
    };
    if cotangent(pc) + cotangent(pd) >= -1e-9 {
        return false;
    }
    let (old, new) = (
        [mesh.normal([a, b, c]), mesh.normal([b, a, d])],
        [mesh.normal([c, a, d]), mesh.normal([d, b, c])],
    );
    let up = old[0] + old[1];
    new[0].dot(&new[1]) > 0.0 && new.iter().all(|n| n.dot(&up) > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, check, edge_lengths, triangle_area};
    use std::f64::consts::TAU;

    /// A disc of radius 10 as a fan of rim vertices.
    fn fan(corners: u32, height: impl Fn(f64) -> f64) -> PatchMesh {
        let point = |k: u32| {
            let angle = TAU * f64::from(k) / f64::from(corners);
            Point3::new(10.0 * angle.cos(), 10.0 * angle.sin(), height(angle))
        };
        let triangles = (1..corners - 1).map(|k| [0, k, k + 1]).collect();
        PatchMesh::new((0..corners).map(point).collect(), triangles)
    }

    fn refined(mut mesh: PatchMesh) -> PatchMesh {
        let refinement = Refinement {
            rim: mesh.points.len(),
            spacing: 1.0,
            joined: &|_, _| false,
        };
        refinement.run(&mut mesh);
        mesh
    }

    #[test]
    fn a_disc_is_filled_evenly_at_the_spacing() {
        let mesh = refined(fan(60, |_| 0.0));
        let plain = TriMesh {
            positions: mesh.points.clone(),
            triangles: mesh.triangles.clone(),
        };
        assert_eq!(check(&plain), Ok(()));
        let lengths = edge_lengths(&plain);
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        assert!((0.85..1.15).contains(&mean), "{mean}");
        let spread = lengths.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / lengths.len() as f64;
        assert!(spread.sqrt() < 0.2 * mean, "{}", spread.sqrt());
        // As many vertices as equilateral triangles of that side would have.
        let ideal = 314.0 / 0.75f64.sqrt();
        assert!((0.75..1.25).contains(&(mesh.points.len() as f64 / ideal)));
        let worst = (0..plain.triangles.len())
            .map(|f| {
                let [a, b, c] = plain.corners(f);
                (b - a)
                    .angle(&(c - a))
                    .min((a - b).angle(&(c - b)))
                    .min((a - c).angle(&(b - c)))
            })
            .fold(f64::INFINITY, f64::min);
        assert!(worst.to_degrees() > 20.0, "{}", worst.to_degrees());
    }

    #[test]
    fn the_rim_stays_and_a_saddle_is_not_folded() {
        let rough = fan(64, |angle| 2.0 * (2.0 * angle).cos());
        let rim: Vec<_> = rough.points.clone();
        let mesh = refined(rough);
        assert_eq!(mesh.points[..rim.len()], rim[..]);
        assert!(mesh.triangles.iter().all(|t| mesh.normal(*t).z > 0.0));
    }

    #[test]
    fn folds_of_the_first_guess_are_undone() {
        // A notched rim and a fan that runs out over the notches.
        let corners = 80u32;
        let point = |k: u32| {
            let angle = TAU * f64::from(k) / f64::from(corners);
            let radius = if k.is_multiple_of(4) { 8.0 } else { 10.0 };
            Point3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        };
        let mut points: Vec<_> = (0..corners).map(point).collect();
        points.rotate_left(1);
        let triangles = (1..corners - 1).map(|k| [0, k, k + 1]).collect();
        let mesh = refined(PatchMesh::new(points, triangles));
        let area: f64 = (mesh.triangles.iter())
            .map(|t| triangle_area(t.map(|v| mesh.points[v as usize])))
            .sum();
        let signed: f64 = mesh.triangles.iter().map(|t| 0.5 * mesh.normal(*t).z).sum();
        assert!(area < 1.001 * signed, "{area} {signed}");
    }

    #[test]
    fn an_edge_that_the_scan_has_already_is_split() {
        let mut mesh = fan(4, |_| 0.0);
        let refinement = Refinement {
            rim: 4,
            spacing: 100.0,
            joined: &|a, b| (a.min(b), a.max(b)) == (0, 2) || (a.min(b), a.max(b)) == (1, 3),
        };
        refinement.run(&mut mesh);
        assert_eq!(mesh.points.len(), 5);
        assert!(!mesh.has_edge(0, 2) && !mesh.has_edge(1, 3));
    }
}
