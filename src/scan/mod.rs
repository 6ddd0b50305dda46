//! Files to [`Scan`] and back, one file of this room a format.
//!
//! A scan keeps every channel of the file in the file's own type, so that what was measured is
//! written back bit for bit. Completion only [`append`](Scan::append)s.
//!
//! | format | in | out | kept |
//! |---|---|---|---|
//! | PLY | ASCII, binary, range grids, strips | binary little endian, ASCII | everything; the faces' list of vertices comes first and is called `vertex_indices`, elements are vertices, faces, others |
//! | OBJ | yes | yes | positions, colours of vertices (in: or of textures), texture coordinates, polygons; in: normals |
//! | OFF | ASCII | yes | positions, normals and colours of vertices, polygons |
//! | STL | ASCII, binary | binary | positions (out: rounded to `float`), triangles |
//! | glTF | text, binary | binary | positions (`float`), normals, colours (in: or of textures and materials), texture coordinates of vertices, triangles; out: every number |
//! | XYZ, PTS, CSV | text | no | every column |
//! | PTX | text | no | positions, intensities, colours, grids, places of the scanner |
//! | PCD | ASCII, binary, compressed | no | every field, grid, place of the sensor |
//! | E57 | yes | no | positions, normals, colours, intensities, grids, places of the scanner |
//! | LAS | LAS, LAZ | no | positions, colours, properties of the standard, extra bytes |
//! | depth images | PNG, TIFF | no | positions, colours of a second image, grid, place of the camera |
//!
//! Colours of textures are those at the vertices; [`read_color_map`] reads them in between.
//!
//! Height maps of other instruments are no scans: [`read_height_map`] reads them, from text. Nor are images
//! as such: [`read_image`] and [`write_png`].
//!
//! [`TexturedOutput`] writes PLY, OBJ and GLB with a texture image, which [`bake`](bake()) draws from the colours of a surface;
//! [`image_size`](image_size()) says how large.
//!
//! Numbers of text files other than PLY are `double`, texture coordinates `float`. Files are not trusted: whatever their bytes,
//! [`read`] gives a scan that passes [`Scan::check`], or a [`ScanError`] that says what to do, and
//! memory follows the size of the file, not what its header claims.

mod append;
mod bake;
mod channel;
mod color;
mod color_map;
#[cfg(feature = "image")]
mod depth;
mod e57;
mod error;
mod format;
mod gltf;
mod height_map;
mod image;
#[cfg(feature = "image")]
mod image_file;
mod image_size;
mod las;
mod names;
mod obj;
mod off;
mod options;
mod output;
mod paint;
mod pcd;
mod ply;
pub(crate) mod png;
mod ptx;
mod range_grid;
mod reference;
mod refined;
mod remove;
mod source;
mod stl;
mod temporary;
mod text;
mod texture;
mod texture_coordinates;
mod textured;
pub mod trace;
mod triangulate;
mod vertex_lists;
mod xyz;

pub use self::image::{Image, read_image, write_png};
pub use append::Added;
pub use bake::{BakeReport, Baked, bake, bake_surface};
pub use channel::{Channel, Column, Table};
pub use color_map::{ColorMap, read_color_map};
pub use error::ScanError;
pub use format::{Format, read, read_from, write, write_to};
pub use height_map::{HeightMap, read_height_map};
pub use image_size::image_size;
pub use options::{Intrinsics, ReadOptions, WriteOptions};
pub use output::{OutputFile, abandon_outputs, same_file};
pub use range_grid::RANGE_GRID;
pub(crate) use temporary::Temporary;
pub use textured::TexturedOutput;

use nalgebra::Point3;

use crate::mesh::{Csr, TriMesh};

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
    /// Where sensors stood, as far as the file tells. PLY written by us does not keep it.
    pub sensors: Vec<Sensor>,
}

/// Where a sensor stood that saw some of the vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Rows of the vertices that it saw.
    pub vertices: std::ops::Range<usize>,
    /// Its position, in the scan's coordinates.
    pub position: Point3<f64>,
}

impl Scan {
    /// #V points, exact: every scalar type fits into `f64`.
    ///
    /// # Panics
    /// If the vertices have no `x`, `y` and `z`, which [`check`](Self::check) tells.
    #[must_use]
    pub fn positions(&self) -> Vec<Point3<f64>> {
        let axes = self.vertices.triple(["x", "y", "z"]);
        let columns = axes
            .expect("a checked scan has coordinates")
            .map(|c| &self.vertices.channels[c].values);
        (0..self.vertices.rows)
            .map(|row| Point3::from(columns.map(|c| c.get_f64(row).unwrap_or(f64::NAN))))
            .collect()
    }

    /// #V intensities of red, green and blue, 0 to 1; `None` if the scan has no colours.
    ///
    /// Looked for as `red`, `green`, `blue`; `r`, `g`, `b`; `diffuse_red`, …; `diffuse_r`, …. Full
    /// intensity is 65535 for `ushort`, 1 for floats, and 255 for other types and for floats of which
    /// one exceeds 1. Values out of range are clamped; NaN is 0.
    #[must_use]
    pub fn colors(&self) -> Option<Vec<[f64; 3]>> {
        color::colors(&self.vertices)
    }

    /// The faces split into triangles of the same orientation, in their order.
    ///
    /// Quads split along the shorter diagonal (or the one inside, if they have a dent), larger
    /// polygons by clipping ears, always the first one.
    ///
    /// # Panics
    /// As [`positions`](Self::positions).
    #[must_use]
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        self.split_faces(&self.positions())
    }

    /// Positions and triangles; triangles with the same vertex twice are dropped.
    ///
    /// # Panics
    /// As [`positions`](Self::positions).
    #[must_use]
    pub fn mesh(&self) -> TriMesh {
        let positions = self.positions();
        let mut triangles = self.split_faces(&positions);
        triangles.retain(texture_coordinates::is_proper);
        TriMesh {
            positions,
            triangles,
        }
    }

    fn split_faces(&self, positions: &[Point3<f64>]) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(self.faces.len());
        for face in self.faces.rows() {
            triangulate::triangulate(face, |v| positions[v as usize], &mut triangles);
        }
        triangles
    }

    /// The door check: vertices with finite coordinates, and faces of three or more of them. No faces
    /// at all is fine here.
    ///
    /// `name` stands for the file in the error.
    ///
    /// # Errors
    /// The first broken rule, in the order: missing coordinates, no vertices, too many vertices,
    /// coordinates that are not finite, faces with fewer than three vertices or with one that does not
    /// exist, channels of more or fewer faces than there are.
    pub fn check(&self, name: &str) -> Result<(), ScanError> {
        let name = || name.to_owned();
        let vertices = self.vertices.rows;
        for property in ["x", "y", "z"] {
            if self.vertices.scalar_index(property).is_none() {
                return Err(if self.vertices.channels.is_empty() && vertices == 0 {
                    ScanError::NoVertices { name: name() }
                } else {
                    ScanError::MissingCoordinate {
                        name: name(),
                        property,
                    }
                });
            }
        }
        if vertices == 0 {
            return Err(ScanError::NoVertices { name: name() });
        }
        if u32::try_from(vertices).is_err() {
            return Err(ScanError::TooLarge {
                name: name(),
                what: "vertices",
            });
        }
        for property in ["x", "y", "z"] {
            let index = self.vertices.scalar_index(property);
            let column = index.map(|i| &self.vertices.channels[i].values);
            if let Some(vertex) = column.and_then(Column::first_not_finite) {
                return Err(ScanError::NotFinite {
                    name: name(),
                    property,
                    vertex,
                });
            }
        }
        for (face, corners) in self.faces.rows().enumerate() {
            if corners.len() < 3 {
                return Err(ScanError::ShortFace {
                    name: name(),
                    face,
                    corners: corners.len(),
                });
            }
            if let Some(&index) = corners.iter().find(|v| **v as usize >= vertices) {
                return Err(ScanError::NoSuchVertex {
                    name: name(),
                    face,
                    index,
                    vertices,
                });
            }
        }
        let channels = &self.face_channels;
        if !channels.channels.is_empty() && channels.rows != self.faces.len() {
            return Err(ScanError::Malformed {
                name: name(),
                reason: format!(
                    "there are {} faces, but properties of {}",
                    self.faces.len(),
                    channels.rows
                ),
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
