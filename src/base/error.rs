//! Input that cannot be fitted.

use thiserror::Error;

use super::BaseKind;

/// Why no base surface can be fitted.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FitError {
    /// A surface with n parameters needs n vertices.
    #[error(
        "{found} vertices with triangles are too few, {needed} are needed: \
         check that the file has faces, or triangulate its points first"
    )]
    TooFewVertices {
        /// Vertices that a triangle uses.
        found: usize,
        /// Least number for the surface asked for.
        needed: usize,
    },
    /// Coordinates are finite, and so is the size of the mesh.
    #[error("vertex {0} has a coordinate that is not a usable number: remove or repair it")]
    NotFinite(usize),
    /// A triangle's corners exist.
    #[error("triangle {triangle} refers to vertex {vertex}, which does not exist: repair the file")]
    NoSuchVertex {
        /// Index of the triangle.
        triangle: usize,
        /// The index that it holds.
        vertex: u32,
    },
    /// Vertices differ.
    #[error("all vertices are at the same place: check the file's coordinates")]
    Coincident,
    /// Vertices span an area.
    #[error("all vertices are on one line: a base surface needs vertices that span an area")]
    Collinear,
    /// A fixed scale is a positive number.
    #[error("the scale of the relief must be positive and finite, not {0}")]
    BadScale(f64),
    /// The surface asked for is determined by the vertices.
    #[error("the vertices determine no {0}: choose another kind of base surface")]
    Undetermined(BaseKind),
}
