//! Files to [`Scan`] and back: PLY (ASCII, both binary byte orders, Stanford range grids), OBJ, OFF
//! and STL in; PLY, OBJ and STL out.
//!
//! A scan keeps every channel of the file in the file's own type, so that what was measured is
//! written back bit for bit. Completion only appends.

mod channel;

pub use channel::{Channel, Column, Table};

use crate::mesh::Csr;

/// What the scanner delivered: vertices, faces and every further channel, in the file's own types.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scan {
    /// One row a vertex; holds at least `x`, `y` and `z`, in the file's order of properties.
    pub vertices: Table,
    /// One row a face: its vertex indices, counterclockwise, three or more.
    pub faces: Csr,
    /// Properties of faces other than the vertex indices; no channels, or one row a face.
    pub face_channels: Table,
    /// Elements other than vertices and faces (cameras, range grids, …), kept as they are.
    pub other_elements: Vec<(String, Table)>,
    /// `comment` lines.
    pub comments: Vec<String>,
    /// `obj_info` lines.
    pub obj_info: Vec<String>,
}
