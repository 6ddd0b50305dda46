//! The invariants of a mesh, checked in order; the first that is broken is named.

use std::collections::BTreeMap;

use thiserror::Error;

use super::TriMesh;

/// The first broken invariant of a mesh.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum MeshDefect {
    /// Every coordinate is a finite number.
    #[error("vertex {0} has a coordinate that is not a finite number")]
    NotFinite(usize),
    /// A triangle's corners exist.
    #[error("triangle {triangle} refers to vertex {vertex}, but there are only {vertices}")]
    NoSuchVertex {
        /// Index of the triangle.
        triangle: usize,
        /// The index that it holds.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A triangle's corners differ.
    #[error("triangle {0} has the same vertex twice")]
    RepeatedCorner(usize),
    /// An edge has at most two triangles.
    #[error("the edge between vertices {0} and {1} has more than two triangles")]
    NonManifoldEdge(u32, u32),
    /// Two triangles at an edge run through it in opposite directions.
    #[error(
        "the triangles at the edge between vertices {0} and {1} are oriented against each other"
    )]
    Inconsistent(u32, u32),
}

/// Checks that the mesh is an oriented 2-manifold in its edges, with or without boundary.
///
/// # Errors
/// The first broken invariant, in the order of [`MeshDefect`]'s variants.
pub fn check(mesh: &TriMesh) -> Result<(), MeshDefect> {
    let vertices = mesh.positions.len();
    for (v, p) in mesh.positions.iter().enumerate() {
        if !p.iter().all(|x| x.is_finite()) {
            return Err(MeshDefect::NotFinite(v));
        }
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|v| **v as usize >= vertices) {
            return Err(MeshDefect::NoSuchVertex {
                triangle,
                vertex,
                vertices,
            });
        }
    }
    for (triangle, [a, b, c]) in mesh.triangles.iter().enumerate() {
        if a == b || b == c || c == a {
            return Err(MeshDefect::RepeatedCorner(triangle));
        }
    }
    let mut uses: BTreeMap<(u32, u32), [u32; 2]> = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let entry = uses.entry((from.min(to), from.max(to))).or_default();
            entry[usize::from(from > to)] += 1;
        }
    }
    if let Some((&(a, b), _)) = uses.iter().find(|(_, [with, against])| with + against > 2) {
        return Err(MeshDefect::NonManifoldEdge(a, b));
    }
    if let Some((&(a, b), _)) = uses.iter().find(|(_, n)| n[0] > 1 || n[1] > 1) {
        return Err(MeshDefect::Inconsistent(a, b));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn mesh(triangles: &[[u32; 3]]) -> TriMesh {
        TriMesh {
            positions: (0..5)
                .map(|i| Point3::new(f64::from(i), f64::from(i * i), 0.0))
                .collect(),
            triangles: triangles.to_vec(),
        }
    }

    #[test]
    fn each_defect_is_named() {
        assert_eq!(check(&mesh(&[[0, 1, 2], [2, 1, 3]])), Ok(()));
        let mut broken = mesh(&[[0, 1, 2]]);
        broken.positions[2].x = f64::NAN;
        assert_eq!(check(&broken), Err(MeshDefect::NotFinite(2)));
        assert!(matches!(
            check(&mesh(&[[0, 1, 9]])),
            Err(MeshDefect::NoSuchVertex { vertex: 9, .. })
        ));
        assert_eq!(
            check(&mesh(&[[0, 1, 1]])),
            Err(MeshDefect::RepeatedCorner(0))
        );
        assert_eq!(
            check(&mesh(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]])),
            Err(MeshDefect::NonManifoldEdge(0, 1))
        );
        assert_eq!(
            check(&mesh(&[[0, 1, 2], [0, 1, 3]])),
            Err(MeshDefect::Inconsistent(0, 1))
        );
    }
}
