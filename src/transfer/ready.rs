//! A mesh as it is worked on.

use nalgebra::Point3;

use crate::mesh::{
    ALONE, Bisected, PointTree, TriMesh, bisected, opposite_half_edges, surface_area,
};

use super::TransferError;
use super::ground::number;

/// No vertex.
const NONE: u32 = u32::MAX;

/// A mesh with enough vertices, and the part of it that is surface.
#[derive(Debug)]
pub(super) struct Ready {
    /// The given mesh with vertices added on its edges.
    pub(super) fine: Bisected,
    /// The part that has faces, around the origin.
    pub(super) surface: TriMesh,
    /// By vertex of the surface: which it is of `fine`.
    pub(super) vertices: Vec<u32>,
    /// By vertex of `fine`: which it is of the surface, or [`NONE`].
    numbers: Vec<u32>,
}

/// Whether a closed surface has its outside inside: what is up would be down there, and fans would be mirrored.
fn is_inside_out(surface: &TriMesh) -> bool {
    let rims = opposite_half_edges(&surface.triangles);
    let volume = |f: usize| {
        let [a, b, c] = surface.corners(f).map(|p| p.coords);
        a.dot(&b.cross(&c))
    };
    !rims.contains(&ALONE) && (0..surface.triangles.len()).map(volume).sum::<f64>() < 0.0
}

/// Number of vertices with faces; an error if there is nothing to work on.
pub(super) fn checked(mesh: &TriMesh, of_source: bool) -> Result<usize, TransferError> {
    if mesh.triangles.is_empty() {
        return Err(TransferError::NoFaces { of_source });
    }
    let area = surface_area(mesh);
    if !(area > 0.0 && area.is_finite()) {
        return Err(TransferError::NoArea { of_source });
    }
    Ok(mesh.used_vertices().iter().filter(|used| **used).count())
}

impl Ready {
    /// With at least `vertices` vertices that have faces.
    pub(super) fn new(mesh: &TriMesh, vertices: usize) -> Self {
        let unused = mesh.used_vertices().iter().filter(|used| !**used).count();
        let fine = bisected(mesh, vertices + unused);
        let used = fine.mesh.used_vertices();
        let mut numbers = vec![NONE; used.len()];
        let mut vertices = Vec::with_capacity(used.len());
        for (v, number) in (0u32..).zip(&mut numbers) {
            if used[v as usize] {
                *number = u32::try_from(vertices.len()).expect("no more than there are");
                vertices.push(v);
            }
        }
        let surface = TriMesh {
            positions: (vertices.iter())
                .map(|v| fine.mesh.positions[*v as usize])
                .collect(),
            triangles: (fine.mesh.triangles.iter())
                .map(|triangle| triangle.map(|v| numbers[v as usize]))
                .collect(),
        };
        let mut surface = surface.centered().0;
        if is_inside_out(&surface) {
            for triangle in &mut surface.triangles {
                triangle.swap(1, 2);
            }
        }
        Self {
            surface,
            fine,
            vertices,
            numbers,
        }
    }

    /// Values of the surface's vertices, of those of the given mesh.
    pub(super) fn on_surface<const N: usize>(&self, given: &[[f64; N]]) -> Vec<[f64; N]> {
        let fine = self.fine.interpolate(given);
        self.vertices.iter().map(|v| fine[*v as usize]).collect()
    }

    /// The surface's vertex for each one of `fine`: the nearest one for those without faces.
    pub(super) fn nearest(&self) -> Vec<u32> {
        let mut nearest = self.numbers.clone();
        if nearest.contains(&NONE) {
            let points: Vec<Point3<f64>> = (self.vertices.iter())
                .map(|v| self.fine.mesh.positions[*v as usize])
                .collect();
            let tree = PointTree::new(&points);
            for (number, p) in nearest.iter_mut().zip(&self.fine.mesh.positions) {
                if *number == NONE {
                    *number = u32::try_from(tree.nearest(p).index).expect("one of them");
                }
            }
        }
        nearest
    }

    /// The vertex of the given mesh at one of the surface, or at an end of the edge that it was put on.
    pub(super) fn given_vertex(&self, v: u32) -> u32 {
        let mut v = self.vertices[v as usize] as usize;
        let given = self.fine.originals();
        while let Some(parents) = v.checked_sub(given).map(|new| self.fine.parents[new]) {
            v = parents[0] as usize;
        }
        number(v)
    }
}

#[cfg(test)]
mod tests;
