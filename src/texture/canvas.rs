//! The mesh at several resolutions.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::mesh::{ClosestPoints, TriMesh, surface_area, vertex_normals};
use crate::neighborhood::{Place, Surface};

use super::retile::Retiled;

/// A mesh at one resolution, to be textured.
#[derive(Debug)]
pub(super) struct CanvasLevel {
    pub(super) surface: Surface,
    /// Length of a texel, in the scan's unit: the side of a square of two triangles' area.
    pub(super) texel: f64,
    /// Standard deviation of the edges' lengths over their mean.
    pub(super) edge_variation: f64,
    /// #V unit normals.
    pub(super) normals: Vec<Vector3<f64>>,
    /// #V unit tangents: the texture's first axis.
    pub(super) directions: Vec<Vector3<f64>>,
    /// #V: the vertices as places, with that axis.
    pub(super) places: Vec<Option<Place>>,
}

impl CanvasLevel {
    pub(super) fn new(retiled: Retiled, directions: Vec<Vector3<f64>>) -> Self {
        let normals = vertex_normals(&retiled.mesh);
        let texel = texel(&retiled.mesh);
        let surface = Surface::new(retiled.mesh);
        let places = (0u32..)
            .zip(&directions)
            .map(|(v, direction)| surface.at_vertex(v, direction))
            .collect();
        Self {
            surface,
            texel,
            edge_variation: retiled.report.edge_variation,
            normals,
            directions,
            places,
        }
    }

    /// Where points with these normals and directions are on this level: at its closest points that face the same way, and
    /// with the same direction there.
    pub(super) fn locate(
        &self,
        points: &[Point3<f64>],
        normals: &[Vector3<f64>],
        directions: &[Vector3<f64>],
    ) -> Vec<Option<Place>> {
        let closest = ClosestPoints::new(&self.surface.mesh());
        (points.par_iter().zip(normals).zip(directions))
            .map(|((point, normal), direction)| {
                let (triangle, shares, _) = closest.closest(point, Some(normal))?;
                #[expect(clippy::cast_possible_truncation, reason = "places are single")]
                let shares = shares.map(|share| share as f32);
                self.surface.in_triangle(triangle, shares, direction)
            })
            .collect()
    }
}

/// d = √(2 A), A the mean area of a triangle.
///
/// # Reference
/// [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001), §3.3.
pub(super) fn texel(mesh: &TriMesh) -> f64 {
    (2.0 * surface_area(mesh) / mesh.triangles.len().max(1) as f64).sqrt()
}
