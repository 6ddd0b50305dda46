//! Edges that are too short, drawn together.

use nalgebra::Point3;

use crate::mesh::{Adjacency, TriMesh, triangle_normal};

use super::patch_mesh::PatchMesh;

/// What may be collapsed.
pub(super) struct Collapse<'a> {
    /// Vertices up to this one stay where they are.
    pub(super) rim: usize,
    /// Edges shorter than this go, …
    pub(super) shortest: f64,
    /// … unless that makes one longer than this.
    pub(super) longest: f64,
    /// Whether two vertices may not get an edge between them.
    pub(super) joined: &'a dyn Fn(u32, u32) -> bool,
}

impl Collapse<'_> {
    /// Takes out vertices at the ends of edges that are too short, the shortest first, where neither the kind
    /// of the surface nor the side that a triangle faces changes. Returns whether there were any.
    pub(super) fn run(&self, mesh: &mut PatchMesh) -> bool {
        let plain = TriMesh {
            positions: std::mem::take(&mut mesh.points),
            triangles: std::mem::take(&mut mesh.triangles),
        };
        let adjacency = Adjacency::new(&plain);
        let mut into: Vec<Option<u32>> = vec![None; plain.positions.len()];
        let mut touched = vec![false; plain.positions.len()];
        for [gone, kept] in self.short_edges(&plain) {
            let ring = adjacency.neighbors.row(gone as usize);
            let free = |v: &u32| !touched[*v as usize];
            if free(&gone) && ring.iter().all(free) && self.allowed(&plain, &adjacency, gone, kept)
            {
                into[gone as usize] = Some(kept);
                touched[gone as usize] = true;
                for v in ring {
                    touched[*v as usize] = true;
                }
            }
        }
        let any = into.iter().any(Option::is_some);
        *mesh = without(plain, &into);
        any
    }

    /// (vertex to take out, vertex that takes its place), the shortest edges first.
    fn short_edges(&self, mesh: &TriMesh) -> Vec<[u32; 2]> {
        let length =
            |[a, b]: [u32; 2]| (mesh.positions[a as usize] - mesh.positions[b as usize]).norm();
        let mut short: Vec<(f64, [u32; 2])> = (mesh.triangles.iter())
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .filter(|[a, _]| *a as usize >= self.rim)
            .map(|edge| (length(edge), edge))
            .filter(|(length, _)| *length < self.shortest)
            .collect();
        short.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        short.into_iter().map(|(_, edge)| edge).collect()
    }

    fn allowed(&self, mesh: &TriMesh, adjacency: &Adjacency, gone: u32, kept: u32) -> bool {
        let ring = adjacency.neighbors.row(gone as usize);
        let beside_kept = adjacency.neighbors.row(kept as usize);
        let shared = ring.iter().filter(|v| beside_kept.binary_search(v).is_ok());
        if shared.count() != 2 {
            return false;
        }
        let place = mesh.positions[kept as usize];
        let new_edges_fit = (ring.iter())
            .filter(|v| **v != kept && beside_kept.binary_search(v).is_err())
            .all(|v| {
                let both_rim = (*v as usize) < self.rim && (kept as usize) < self.rim;
                let doubled = both_rim && (self.joined)(*v, kept);
                !doubled && (mesh.positions[*v as usize] - place).norm() <= self.longest
            });
        new_edges_fit
            && (adjacency.triangles.row(gone as usize).iter())
                .map(|f| mesh.triangles[*f as usize])
                .filter(|t| !t.contains(&kept))
                .all(|t| faces_the_same_way(mesh, t, gone, place))
    }
}

/// Whether a triangle keeps its side when one of its corners moves.
fn faces_the_same_way(mesh: &TriMesh, t: [u32; 3], moved: u32, to: Point3<f64>) -> bool {
    let old = t.map(|v| mesh.positions[v as usize]);
    let new = t.map(|v| {
        if v == moved {
            to
        } else {
            mesh.positions[v as usize]
        }
    });
    let (old, new) = (triangle_normal(old), triangle_normal(new));
    old.dot(&new) > 0.5 * old.norm() * new.norm()
}

/// The mesh with vertices put into others.
fn without(mesh: TriMesh, into: &[Option<u32>]) -> PatchMesh {
    let mut next = 0u32;
    let numbers: Vec<u32> = (into.iter())
        .map(|into| {
            let number = next;
            next += u32::from(into.is_none());
            number
        })
        .collect();
    let number = |v: u32| numbers[into[v as usize].unwrap_or(v) as usize];
    let triangles = (mesh.triangles.iter())
        .map(|t| t.map(number))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    let points = (mesh.positions.into_iter().zip(into))
        .filter_map(|(point, into)| into.is_none().then_some(point))
        .collect();
    PatchMesh::new(points, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{check, edge_lengths, euler_characteristic, triangle_area};
    use approx::assert_relative_eq;

    #[test]
    fn a_grid_that_is_too_fine_becomes_coarser_and_covers_the_same() {
        let size = 21u32;
        let at = |i: u32, j: u32| Point3::new(0.25 * f64::from(j), 0.25 * f64::from(i), 0.0);
        let is_rim = |i: u32, j: u32| i.is_multiple_of(size - 1) || j.is_multiple_of(size - 1);
        let all = || (0..size).flat_map(|i| (0..size).map(move |j| (i, j)));
        let mut order: Vec<(u32, u32)> = all().filter(|(i, j)| is_rim(*i, *j)).collect();
        let rim = order.len();
        order.extend(all().filter(|(i, j)| !is_rim(*i, *j)));
        let number = |i: u32, j: u32| {
            u32::try_from(order.iter().position(|v| *v == (i, j)).unwrap()).unwrap()
        };
        let mut triangles = Vec::new();
        for i in 0..size - 1 {
            for j in 0..size - 1 {
                let [a, b, c, d] =
                    [(i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1)].map(|(i, j)| number(i, j));
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        let points = order.iter().map(|(i, j)| at(*i, *j)).collect();
        let mut mesh = PatchMesh::new(points, triangles);
        let collapse = Collapse {
            rim,
            shortest: 0.8,
            longest: 1.3,
            joined: &|_, _| false,
        };
        let before = mesh.points.clone();
        for _ in 0..20 {
            if !collapse.run(&mut mesh) {
                break;
            }
        }
        assert_eq!(mesh.points[..rim], before[..rim]);
        let plain = TriMesh {
            positions: mesh.points.clone(),
            triangles: mesh.triangles.clone(),
        };
        assert_eq!(check(&plain), Ok(()));
        assert_eq!(euler_characteristic(&plain), 1);
        let area: f64 = (0..plain.triangles.len())
            .map(|f| triangle_area(plain.corners(f)))
            .sum();
        assert_relative_eq!(area, 25.0, epsilon = 1e-9);
        assert!(mesh.points.len() < rim + 100, "{}", mesh.points.len() - rim);
        assert!(edge_lengths(&plain).iter().all(|l| *l <= 1.3 + 1e-12));
    }
}
