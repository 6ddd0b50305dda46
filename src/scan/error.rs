//! What can be wrong with a file, each in one sentence with a remedy.

use std::io;

use thiserror::Error;

/// Why a scan could not be read or written.
#[derive(Debug, Error)]
pub enum ScanError {
    /// The file exists.
    #[error("{name}: there is no such file; check the path")]
    NotFound {
        /// The path.
        name: String,
    },
    /// The path is a file.
    #[error("{name} is a folder; name a file in it")]
    IsFolder {
        /// The path.
        name: String,
    },
    /// The path is not a device.
    #[error("{name} is a device, which may have no end; name a file or a pipe")]
    IsDevice {
        /// The path.
        name: String,
    },
    /// The file can be read.
    #[error("cannot read {name} ({source}); check its permissions")]
    Read {
        /// The path.
        name: String,
        /// What the system says.
        source: io::Error,
    },
    /// The extension, or the first bytes, tell a known format.
    #[error(
        "{name}: the extension does not tell a format that relievo knows; convert the file to .ply, .obj, .glb, .xyz or another of the formats of `relievo complete --help`"
    )]
    UnknownFormat {
        /// The path.
        name: String,
    },
    /// Headers follow their format.
    #[error("{name}: header line {line} (`{text}`): {reason}; export the file again")]
    Header {
        /// The file.
        name: String,
        /// Number of the line, from 1.
        line: usize,
        /// The line.
        text: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The file holds as many rows as its header says.
    #[error(
        "{name} is cut off: its header promises {expected} rows of `{element}`, but only {found} are there; copy or export it again"
    )]
    Truncated {
        /// The file.
        name: String,
        /// The element whose rows are missing.
        element: String,
        /// Number of complete rows.
        found: usize,
        /// Number of rows that the header promises.
        expected: usize,
    },
    /// A row holds what the header says.
    #[error(
        "{name}: row {row} (from 0) of `{element}`: {reason}; repair the row or export the file again"
    )]
    Row {
        /// The file.
        name: String,
        /// The element.
        element: String,
        /// Index of the row, from 0.
        row: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// A line of a text format can be understood.
    #[error("{name}: line {line}: {reason}; repair the line or export the file again")]
    Line {
        /// The file.
        name: String,
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// The file follows its format.
    #[error("{name}: {reason}; export the file again")]
    Malformed {
        /// The file.
        name: String,
        /// What is wrong, and where.
        reason: String,
    },
    /// Reading needs something that the file does not tell.
    #[error("{name}: {reason}")]
    MissingOption {
        /// The file.
        name: String,
        /// What is needed, and how to give it.
        reason: String,
    },
    /// This program was built with the format.
    #[cfg(not(all(feature = "e57", feature = "las", feature = "image")))]
    #[error(
        "{name}: this relievo was built without {format}; build it with `--features {feature}`, or convert the file to .ply"
    )]
    NotBuiltIn {
        /// The file.
        name: String,
        /// What cannot be read.
        format: &'static str,
        /// The feature of the build that it needs.
        feature: &'static str,
    },
    /// This program was built with images.
    #[cfg(not(feature = "image"))]
    #[error("{name}: this relievo was built without images; build it with `--features image`")]
    NoImagesBuiltIn {
        /// The file.
        name: String,
    },
    /// A scan has vertices.
    #[error("{name} holds no vertices; export the scan with its points")]
    NoVertices {
        /// The file.
        name: String,
    },
    /// Vertices have the scalar properties `x`, `y` and `z`.
    #[error("{name}: its vertices have no number `{property}`; export the scan with x, y and z")]
    MissingCoordinate {
        /// The file.
        name: String,
        /// The property that is missing.
        property: &'static str,
    },
    /// Faces have a list of vertices.
    #[error(
        "{name}: its faces have no list `vertex_indices` or `vertex_index`; export the scan with them"
    )]
    MissingIndices {
        /// The file.
        name: String,
    },
    /// Coordinates are finite numbers.
    #[error(
        "{name}: coordinate {property} of vertex {vertex} (from 0) is not a finite number; remove such vertices first"
    )]
    NotFinite {
        /// The file.
        name: String,
        /// `x`, `y` or `z`.
        property: &'static str,
        /// Index of the vertex, from 0.
        vertex: usize,
    },
    /// A face's vertices exist.
    #[error(
        "{name}: face {face} (from 0) refers to vertex {index} (from 0), but there are only {vertices} vertices; export the file again"
    )]
    NoSuchVertex {
        /// The file.
        name: String,
        /// Index of the face, from 0.
        face: usize,
        /// The index that it holds.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A face has three vertices or more.
    #[error("{name}: face {face} (from 0) has only {corners} vertices; remove such faces first")]
    ShortFace {
        /// The file.
        name: String,
        /// Index of the face, from 0.
        face: usize,
        /// Number of its vertices.
        corners: usize,
    },
    /// A range grid has as many cells as columns times rows.
    #[error(
        "{name}: {columns} columns by {rows} rows (num_cols, num_rows) do not make the {cells} cells of its range_grid; correct the obj_info lines"
    )]
    GridSize {
        /// The file.
        name: String,
        /// `num_cols`, as in the file.
        columns: String,
        /// `num_rows`, as in the file.
        rows: String,
        /// Number of rows of the element.
        cells: usize,
    },
    /// Indices fit into 32 bits.
    #[error("{name} has too many {what} (2^32 or more); split the scan into parts")]
    TooLarge {
        /// The file.
        name: String,
        /// What there is too much of.
        what: &'static str,
    },
    /// The format can be written.
    #[error(
        "{name}: cannot write this format; choose an output that ends in .ply, .obj, .off, .stl or .glb"
    )]
    CannotWriteFormat {
        /// The path.
        name: String,
    },
    /// STL holds triangles and nothing else.
    #[error(
        "cannot write {name}: STL holds triangles, and the scan has none; make them with --surface, or choose .ply"
    )]
    NoFacesToWrite {
        /// The path.
        name: String,
    },
    /// The output's folder exists.
    #[error("cannot write {name}: there is no folder {folder}; make it first")]
    NoFolder {
        /// The path of the output.
        name: String,
        /// The folder that is missing.
        folder: String,
    },
    /// The output is not the input.
    #[error(
        "{name} is the input and would be overwritten; choose another name, or allow it with --overwrite"
    )]
    WouldOverwrite {
        /// The path of the output.
        name: String,
    },
    /// The output is no file that was read.
    #[error("{name} is read as well, and would be overwritten; choose another name")]
    WouldReplaceInput {
        /// The path of the output.
        name: String,
    },
    /// What is replaced was written by the same work before.
    #[error(
        "{name} exists and was not written by this work; choose another place, or allow it with --overwrite"
    )]
    WouldReplace {
        /// The path of the output.
        name: String,
    },
    /// Several files go to several names.
    #[error(
        "a mesh with a texture image cannot go to standard output: name a file that ends in .ply, .obj or .glb"
    )]
    TextureToStdout,
    /// The format holds a texture image.
    #[error("{name}: cannot write a texture image with this format; choose .ply, .obj or .glb")]
    NoTextureFormat {
        /// The path.
        name: String,
    },
    /// A texture image goes with texture coordinates.
    #[error(
        "cannot write {name} with a texture image: the mesh has no texture coordinates; unwrap it in a modelling program first"
    )]
    NoTextureCoordinates {
        /// The path.
        name: String,
    },
    /// What lies beside an output is not replaced unless it is of an earlier one.
    #[error(
        "{name}, which belongs to {mesh}, is there already, and {mesh} is not; choose another name, or remove {name} first"
    )]
    Foreign {
        /// The path of the output that there is.
        name: String,
        /// The path of the mesh that it goes with.
        mesh: String,
    },
    /// Files name each other in plain text.
    #[error(
        "cannot write {name} with a texture image: other programs could not read such a name; choose one without line breaks and in UTF-8"
    )]
    UnusableName {
        /// The path.
        name: String,
    },
    /// Somebody reads what is written to a pipe.
    #[error("cannot write {name}: the program that reads it has ended; let it read to the end")]
    ClosedPipe {
        /// The path of the output.
        name: String,
    },
    /// The output can be written.
    #[error("cannot write {name} ({source}); check its permissions and the space left")]
    Write {
        /// The path of the output.
        name: String,
        /// What the system says.
        source: io::Error,
    },
}

impl ScanError {
    /// Whether it is about a file that was to be written, and not about one that was read.
    #[must_use]
    pub fn is_of_writing(&self) -> bool {
        matches!(
            self,
            Self::CannotWriteFormat { .. }
                | Self::NoFacesToWrite { .. }
                | Self::NoFolder { .. }
                | Self::WouldOverwrite { .. }
                | Self::TextureToStdout
                | Self::NoTextureFormat { .. }
                | Self::NoTextureCoordinates { .. }
                | Self::Foreign { .. }
                | Self::UnusableName { .. }
                | Self::ClosedPipe { .. }
                | Self::Write { .. }
        )
    }

    /// Why an output could not be written.
    pub(super) fn writing(name: &str, source: io::Error) -> Self {
        let name = name.to_owned();
        match source.kind() {
            io::ErrorKind::BrokenPipe => Self::ClosedPipe { name },
            _ => Self::Write { name, source },
        }
    }
}
