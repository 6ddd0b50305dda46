//! A piece of triangle mesh that can be edited: edges split and flipped.

use std::collections::{HashMap, HashSet};

use nalgebra::{Point3, Vector3};

use crate::mesh::triangle_normal;

/// No half-edge: the edge is on the rim.
const RIM: u32 = u32::MAX;

/// Triangles with the half-edge opposite of each half-edge; half-edge 3 f + k runs from corner k of
/// triangle f to the next.
#[derive(Debug, Clone, Default)]
pub(super) struct PatchMesh {
    pub(super) points: Vec<Point3<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
    opposites: Vec<u32>,
    /// Edges that there are, lower vertex first.
    edges: HashSet<[u32; 2]>,
}

/// An edge between two triangles, (a, b, c) and (b, a, d).
#[derive(Debug, Clone, Copy)]
pub(super) struct Diamond {
    faces: [usize; 2],
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) c: u32,
    pub(super) d: u32,
    /// The half-edges beyond b→c, c→a, a→d and d→b.
    beyond: [u32; 4],
}

impl Diamond {
    /// The numbers of both triangles.
    pub(super) fn faces(&self) -> [usize; 2] {
        self.faces
    }
}

impl PatchMesh {
    pub(super) fn new(points: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Self {
        let mut by_ends = HashMap::new();
        for (f, t) in (0u32..).zip(&triangles) {
            for k in 0..3u32 {
                let from = t[k as usize];
                let to = t[(k as usize + 1) % 3];
                by_ends.insert((from, to), 3 * f + k);
            }
        }
        let ends = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        let opposites = (triangles.iter().flat_map(ends))
            .map(|(from, to)| by_ends.get(&(to, from)).copied().unwrap_or(RIM))
            .collect();
        let edges = (triangles.iter().flat_map(ends))
            .map(|(a, b)| sorted(a, b))
            .collect();
        Self {
            points,
            triangles,
            opposites,
            edges,
        }
    }

    /// Number of half-edges.
    pub(super) fn half_edges(&self) -> usize {
        self.opposites.len()
    }

    pub(super) fn has_edge(&self, a: u32, b: u32) -> bool {
        self.edges.contains(&sorted(a, b))
    }

    /// What is on both sides of a half-edge; `None` on the rim.
    pub(super) fn diamond(&self, half_edge: usize) -> Option<Diamond> {
        let opposite = self.opposites[half_edge];
        if opposite == RIM {
            return None;
        }
        let (f, g) = (half_edge / 3, opposite as usize / 3);
        let corner = |f: usize, k: usize| self.triangles[f][k % 3];
        let beyond = |f: usize, k: usize| self.opposites[3 * f + k % 3];
        let (k, l) = (half_edge % 3, opposite as usize % 3);
        Some(Diamond {
            faces: [f, g],
            a: corner(f, k),
            b: corner(f, k + 1),
            c: corner(f, k + 2),
            d: corner(g, l + 2),
            beyond: [
                beyond(f, k + 1),
                beyond(f, k + 2),
                beyond(g, l + 1),
                beyond(g, l + 2),
            ],
        })
    }

    pub(super) fn normal(&self, corners: [u32; 3]) -> Vector3<f64> {
        triangle_normal(corners.map(|v| self.points[v as usize]))
    }

    /// By vertex: the mean of its neighbors' values, for vertices that are not on the rim; there, of most of
    /// its neighbors.
    pub(super) fn neighbor_means(&self, values: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut sums = vec![(Vector3::zeros(), 0.0); values.len()];
        for t in &self.triangles {
            for k in 0..3 {
                // Around a vertex inside every neighbor comes once as the next corner.
                let (sum, count) = &mut sums[t[k] as usize];
                *sum += values[t[(k + 1) % 3] as usize];
                *count += 1.0;
            }
        }
        sums.into_iter()
            .map(|(sum, count)| sum / f64::max(count, 1.0))
            .collect()
    }

    pub(super) fn length(&self, a: u32, b: u32) -> f64 {
        (self.points[a as usize] - self.points[b as usize]).norm()
    }

    /// Turns the edge between a and b into one between c and d.
    pub(super) fn flip(&mut self, diamond: &Diamond) {
        let Diamond { a, b, c, d, .. } = *diamond;
        let [f, g] = diamond.faces;
        let [bc, ca, ad, db] = diamond.beyond;
        self.triangles[f] = [c, a, d];
        self.triangles[g] = [d, b, c];
        self.link(3 * f, ca);
        self.link(3 * f + 1, ad);
        self.link(3 * f + 2, index(3 * g + 2));
        self.link(3 * g, db);
        self.link(3 * g + 1, bc);
        self.edges.remove(&sorted(a, b));
        self.edges.insert(sorted(c, d));
    }

    /// Puts a vertex in the middle of the edge.
    pub(super) fn split(&mut self, diamond: &Diamond) {
        let Diamond { a, b, c, d, .. } = *diamond;
        let [f, g] = diamond.faces;
        let [bc, ca, ad, db] = diamond.beyond;
        let m = index(self.points.len());
        let middle = nalgebra::center(&self.points[a as usize], &self.points[b as usize]);
        self.points.push(middle);
        let (h, i) = (self.triangles.len(), self.triangles.len() + 1);
        self.triangles[f] = [a, m, c];
        self.triangles[g] = [b, m, d];
        self.triangles.extend([[m, b, c], [m, a, d]]);
        self.opposites.extend([RIM; 6]);
        self.link(3 * f, index(3 * i));
        self.link(3 * f + 1, index(3 * h + 2));
        self.link(3 * f + 2, ca);
        self.link(3 * h, index(3 * g));
        self.link(3 * h + 1, bc);
        self.link(3 * g + 1, index(3 * i + 2));
        self.link(3 * g + 2, db);
        self.link(3 * i + 1, ad);
        self.edges.remove(&sorted(a, b));
        for end in [a, b, c, d] {
            self.edges.insert(sorted(end, m));
        }
    }

    fn link(&mut self, half_edge: usize, opposite: u32) {
        self.opposites[half_edge] = opposite;
        if opposite != RIM {
            self.opposites[opposite as usize] = index(half_edge);
        }
    }
}

fn sorted(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn index(v: usize) -> u32 {
    u32::try_from(v).expect("indices are u32")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, check, triangle_area};
    use approx::assert_relative_eq;

    /// A flat strip of triangles, with whatever flips and splits come by a fixed rule.
    fn edited() -> PatchMesh {
        let points = (0..6u32)
            .flat_map(|i| [0.0, 1.0].map(|y| Point3::new(f64::from(i), y, 0.0)))
            .collect();
        let triangles = (0..5u32)
            .flat_map(|i| {
                let a = 2 * i;
                [[a, a + 2, a + 3], [a, a + 3, a + 1]]
            })
            .collect();
        let mut mesh = PatchMesh::new(points, triangles);
        for round in 0..40usize {
            let half_edge = (7 * round * round + 3) % mesh.half_edges();
            let Some(diamond) = mesh.diamond(half_edge) else {
                continue;
            };
            let sides = [
                mesh.normal([diamond.c, diamond.a, diamond.d]).z,
                mesh.normal([diamond.d, diamond.b, diamond.c]).z,
            ];
            let convex = sides.iter().all(|z| *z > 0.0);
            if round % 3 > 0 && convex && !mesh.has_edge(diamond.c, diamond.d) {
                mesh.flip(&diamond);
            } else {
                mesh.split(&diamond);
            }
        }
        mesh
    }

    #[test]
    fn edits_keep_the_surface_and_its_rim() {
        let mesh = edited();
        let plain = TriMesh {
            positions: mesh.points.clone(),
            triangles: mesh.triangles.clone(),
        };
        assert_eq!(check(&plain), Ok(()));
        assert!(mesh.points.len() > 20);
        let area: f64 = (0..plain.triangles.len())
            .map(|f| triangle_area(plain.corners(f)))
            .sum();
        assert_relative_eq!(area, 5.0, epsilon = 1e-12);
        assert!(plain.triangles.iter().all(|t| mesh.normal(*t).z > 0.0));
        // Opposites and edges as if made anew.
        let anew = PatchMesh::new(mesh.points.clone(), mesh.triangles.clone());
        assert_eq!(anew.opposites, mesh.opposites);
        assert_eq!(anew.edges, mesh.edges);
        let rim = mesh.opposites.iter().filter(|o| **o == RIM).count();
        assert_eq!(rim, 12);
    }
}
