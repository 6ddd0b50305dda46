//! The doors: which format, read, write.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;

use super::color::ColorLayout;
use super::options::{ReadOptions, WriteOptions};
use super::source::{Parsed, Source};
use super::{
    OutputFile, Scan, ScanError, e57, gltf, las, obj, off, pcd, ply, ptx, range_grid, stl,
    texture_coordinates, trace, xyz,
};

/// A file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Stanford PLY.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Geomview OFF.
    Off,
    /// STL.
    Stl,
    /// Columns of numbers as text: XYZ, PTS, TXT, CSV, ASC.
    Xyz,
    /// Leica PTX: range grids as text.
    Ptx,
    /// Point Cloud Library.
    Pcd,
    /// ASTM E2807.
    E57,
    /// ASPRS LAS, and LAZ.
    Las,
    /// glTF 2.0, text or binary (GLB).
    Gltf,
    /// A depth image: 16-bit PNG, or float TIFF.
    Depth,
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Self::Ply => "PLY",
            Self::Obj => "OBJ",
            Self::Off => "OFF",
            Self::Stl => "STL",
            Self::Xyz => "columns of text",
            Self::Ptx => "PTX",
            Self::Pcd => "PCD",
            Self::E57 => "E57",
            Self::Las => "LAS",
            Self::Gltf => "glTF",
            Self::Depth => "a depth image",
        })
    }
}

/// All formats, in the order in which messages list them.
const FORMATS: [Format; 11] = [
    Format::Ply,
    Format::Obj,
    Format::Off,
    Format::Stl,
    Format::Gltf,
    Format::Xyz,
    Format::Ptx,
    Format::Pcd,
    Format::E57,
    Format::Las,
    Format::Depth,
];

impl Format {
    /// The extensions of its files, the usual one first.
    #[must_use]
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Ply => &["ply"],
            Self::Obj => &["obj"],
            Self::Off => &["off"],
            Self::Stl => &["stl"],
            Self::Xyz => &["xyz", "pts", "txt", "csv", "asc"],
            Self::Ptx => &["ptx"],
            Self::Pcd => &["pcd"],
            Self::E57 => &["e57"],
            Self::Las => &["las", "laz"],
            Self::Gltf => &["glb", "gltf"],
            Self::Depth => &["png", "tif", "tiff"],
        }
    }

    /// Whether scans can be written in it.
    #[must_use]
    pub fn can_be_written(self) -> bool {
        matches!(
            self,
            Self::Ply | Self::Obj | Self::Off | Self::Stl | Self::Gltf
        )
    }

    /// The channels of vertices, and texture coordinates of faces, that are not in a file of this format.
    fn loses(self, scan: &Scan) -> Vec<&str> {
        let channels = &scan.vertices.channels;
        let mut kept: Vec<usize> = Vec::new();
        let mut keep =
            |names: [&str; 3]| kept.extend(scan.vertices.triple(names).into_iter().flatten());
        keep(["x", "y", "z"]);
        if self == Self::Off {
            keep(["nx", "ny", "nz"]);
        }
        if matches!(self, Self::Obj | Self::Off)
            && let Some(layout) = ColorLayout::of(&scan.vertices)
        {
            kept.extend(layout.channels);
        }
        if self == Self::Obj && !scan.faces.is_empty() {
            kept.extend(
                texture_coordinates::of_vertices(&scan.vertices)
                    .into_iter()
                    .flatten(),
            );
        }
        // Those that keep all others say themselves what they cannot hold.
        let keeps_all = matches!(self, Self::Ply | Self::Gltf);
        let alpha = |name: &str| self == Self::Off && name == "alpha";
        let lost = (channels.iter().enumerate())
            .filter(|(k, c)| !keeps_all && !kept.contains(k) && !alpha(&c.name))
            .map(|(_, c)| c.name.as_str());
        let coordinates = scan.face_channels.channel(texture_coordinates::OF_CORNERS);
        let coordinates = coordinates.filter(|_| !matches!(self, Self::Ply | Self::Obj));
        lost.chain(coordinates.map(|c| c.name.as_str())).collect()
    }

    /// The format that the extension tells, in either case; `-`, which stands for standard input
    /// and output, is PLY.
    ///
    /// # Errors
    /// [`ScanError::UnknownFormat`].
    pub fn of_path(path: &Path) -> Result<Self, ScanError> {
        if path == Path::new("-") {
            return Ok(Self::Ply);
        }
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        let known = extension
            .to_str()
            .and_then(|e| FORMATS.into_iter().find(|f| f.extensions().contains(&e)));
        known.ok_or_else(|| ScanError::UnknownFormat {
            name: path.display().to_string(),
        })
    }

    /// The format that the first bytes tell beyond doubt.
    pub(super) fn of_content(bytes: &[u8]) -> Option<Self> {
        const MAGIC: [(&[u8], Format); 9] = [
            (b"ASTM-E57", Format::E57),
            (b"LASF", Format::Las),
            (b"glTF", Format::Gltf),
            (b"# .PCD", Format::Pcd),
            (b"\x89PNG\r\n\x1a\n", Format::Depth),
            (b"II*\0", Format::Depth),
            (b"MM\0*", Format::Depth),
            (b"VERSION .7", Format::Pcd),
            (b"VERSION 0.7", Format::Pcd),
        ];
        if let Some((_, format)) = MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)) {
            return Some(*format);
        }
        let first = bytes.split(u8::is_ascii_whitespace).next()?;
        match first {
            _ if first.len() == bytes.len() => None,
            b"ply" => Some(Self::Ply),
            b"OFF" | b"COFF" | b"NOFF" | b"CNOFF" | b"NCOFF" => Some(Self::Off),
            _ => None,
        }
    }

    /// What a file of no known extension most likely is.
    fn guessed(bytes: &[u8]) -> Option<Self> {
        let start = &bytes[..bytes.len().min(4096)];
        let line = start
            .split(|b| *b == b'\n')
            .find(|l| !l.trim_ascii().is_empty())?;
        let line = std::str::from_utf8(line).ok()?.trim();
        let is_between = |c: char| c.is_ascii_whitespace() || matches!(c, ',' | ';');
        let mut words = line.split(is_between).filter(|w| !w.is_empty());
        if line.starts_with("solid") {
            Some(Self::Stl)
        } else if line.starts_with('{') {
            Some(Self::Gltf)
        } else if matches!(words.clone().next(), Some("v" | "mtllib" | "o" | "g")) {
            Some(Self::Obj)
        } else if words.clone().count() >= 3 && words.all(|w| w.parse::<f64>().is_ok()) {
            Some(Self::Xyz)
        } else {
            None
        }
    }
}

/// Reads a scan. The format follows from the file's first bytes where they are clear, or else from
/// its extension, or else from what it looks like; `-` reads standard input, PLY if its first bytes tell no other format. Range grids
/// become triangles.
///
/// # Errors
/// A [`ScanError`] that names the file; see there.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Scan, ScanError> {
    let (name, bytes, format) = opened(path)?;
    let source = Source {
        bytes: &bytes,
        name: &name,
        folder: path.parent().filter(|_| path != Path::new("-")),
        options,
    };
    parse(&source, format)
}

/// What stands for a file in messages, its bytes, and its format.
pub(super) fn opened(path: &Path) -> Result<(String, Vec<u8>, Format), ScanError> {
    let (name, bytes) = bytes_of(path)?;
    let format = match (Format::of_content(&bytes), Format::of_path(path)) {
        (Some(content), Ok(extension)) if content != extension && path != Path::new("-") => {
            log::warn!("{name}: read as {content}, which its first bytes tell");
            content
        }
        (Some(content), _) => content,
        (None, Ok(_)) if path == Path::new("-") => Format::guessed(&bytes).unwrap_or(Format::Ply),
        (None, Ok(extension)) => extension,
        (None, Err(unknown)) => Format::guessed(&bytes).ok_or(unknown)?,
    };
    Ok((name, bytes, format))
}

/// What stands for a file, or for standard input (`-`), in messages, and its bytes.
pub(super) fn bytes_of(path: &Path) -> Result<(String, Vec<u8>), ScanError> {
    if path == Path::new("-") {
        let name = "standard input".to_owned();
        let bytes = read_all(std::io::stdin().lock(), &name)?;
        return Ok((name, bytes));
    }
    let name = path.display().to_string();
    let bytes = load(path, &name)?;
    Ok((name, bytes))
}

/// The bytes of a file.
pub(super) fn load(path: &Path, name: &str) -> Result<Vec<u8>, ScanError> {
    let name = name.to_owned();
    if path.is_dir() {
        return Err(ScanError::IsFolder { name });
    }
    // What cannot be asked cannot be read either, which the system tells below.
    if std::fs::metadata(path).is_ok_and(|m| is_endless(m.file_type())) {
        return Err(ScanError::IsDevice { name });
    }
    let read = std::fs::read(path);
    trace::has_read(path, read.as_deref().ok());
    read.map_err(|source| match source.kind() {
        ErrorKind::NotFound => ScanError::NotFound { name },
        _ => ScanError::Read { name, source },
    })
}

/// Whether it is a device such as `/dev/zero`, which may have no end. Pipes are none.
#[cfg(unix)]
fn is_endless(file: std::fs::FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    file.is_char_device()
}

#[cfg(not(unix))]
fn is_endless(_: std::fs::FileType) -> bool {
    false
}

/// Reads a scan of a known format; `name` stands for the file in errors. Files that it refers to
/// (materials, textures, buffers) are not looked for.
///
/// # Errors
/// A [`ScanError`] that names the file; see there.
pub fn read_from(
    reader: impl Read,
    format: Format,
    name: &str,
    options: &ReadOptions,
) -> Result<Scan, ScanError> {
    let bytes = read_all(reader, name)?;
    let source = Source {
        bytes: &bytes,
        name,
        folder: None,
        options,
    };
    parse(&source, format)
}

fn read_all(mut reader: impl Read, name: &str) -> Result<Vec<u8>, ScanError> {
    let mut bytes = Vec::new();
    let done = reader.read_to_end(&mut bytes);
    done.map_err(|source| ScanError::Read {
        name: name.to_owned(),
        source,
    })?;
    Ok(bytes)
}

fn parse(source: &Source, format: Format) -> Result<Scan, ScanError> {
    let Parsed { mut scan, grids } = match format {
        Format::Ply => ply::read(source.bytes, source.name)?.into(),
        Format::Obj => obj::read(source)?.into(),
        Format::Off => off::read(source.bytes, source.name)?.into(),
        Format::Stl => stl::read(source.bytes, source.name)?.into(),
        Format::Xyz => xyz::read(source)?.into(),
        Format::Ptx => ptx::read(source)?,
        Format::Pcd => pcd::read(source)?,
        Format::E57 => e57::read(source)?,
        Format::Las => las::read(source)?.into(),
        Format::Gltf => gltf::read(source)?.into(),
        #[cfg(feature = "image")]
        Format::Depth => super::depth::read(source)?,
        #[cfg(not(feature = "image"))]
        Format::Depth => {
            return Err(ScanError::NotBuiltIn {
                name: source.name.to_owned(),
                format: "depth images",
                feature: "image",
            });
        }
    };
    let name = source.name;
    scan.check(name)?;
    range_grid::triangulate(&mut scan, grids, name)?;
    log::info!(
        "{name}: {} vertices, {} faces",
        scan.vertices.rows,
        scan.faces.len()
    );
    Ok(scan)
}

/// Writes a scan in the format of the path's extension; `-` writes PLY to standard output.
///
/// The file appears whole or not at all. To check a path before long work, or to protect the input,
/// use [`OutputFile`] and [`write_to`].
///
/// # Errors
/// A [`ScanError`] that names the file: unknown format, or not writable.
pub fn write(scan: &Scan, path: &Path, options: &WriteOptions) -> Result<(), ScanError> {
    let format = Format::of_path(path)?;
    let mut output = OutputFile::create(path, None)?;
    let name = output.name().to_owned();
    write_to(scan, &mut output, format, options, &name)?;
    output.commit()
}

/// Writes a scan; `name` stands for the file in errors. PLY keeps every channel; OBJ positions, colours,
/// faces and texture coordinates; OFF positions, normals, colours and faces; STL positions and triangles, rounded
/// to `float`; glTF (as GLB) positions, rounded to `float`, normals, colours, texture coordinates of vertices,
/// triangles, and every other channel that is a number. What is lost is
/// told by a warning.
///
/// # Errors
/// [`ScanError::CannotWriteFormat`]; [`ScanError::NoFacesToWrite`]; [`ScanError::Write`] with what the system says.
pub fn write_to(
    scan: &Scan,
    writer: &mut impl Write,
    format: Format,
    options: &WriteOptions,
    name: &str,
) -> Result<(), ScanError> {
    if format == Format::Stl && scan.faces.is_empty() {
        return Err(ScanError::NoFacesToWrite {
            name: name.to_owned(),
        });
    }
    let lost = format.loses(scan);
    if !lost.is_empty() {
        log::warn!("{name}: {format} does not keep {}", lost.join(", "));
    }
    let written = match format {
        Format::Ply => ply::write(scan, writer, options.ascii),
        Format::Obj => obj::write(scan, None, writer),
        Format::Stl => stl::write(scan, writer),
        Format::Off => off::write(scan, writer),
        Format::Gltf => gltf::write(scan, None, writer),
        Format::Xyz | Format::Ptx | Format::Pcd | Format::E57 | Format::Las | Format::Depth => {
            return Err(ScanError::CannotWriteFormat {
                name: name.to_owned(),
            });
        }
    };
    written.map_err(|source| ScanError::writing(name, source))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_bytes_tell_the_format() {
        for (bytes, format) in [
            ("VERSION 0.7\nFIELDS x y z\n", Some(Format::Pcd)),
            ("VERSION .7\nFIELDS x y z\n", Some(Format::Pcd)),
            ("# .PCD v0.7 - Point Cloud Data\n", Some(Format::Pcd)),
            ("VERSION 2\n", None),
            ("ply\r\n", Some(Format::Ply)),
            ("ply", None),
            ("CNOFF\n1 0 0\n", Some(Format::Off)),
            ("offset 1\n", None),
            ("", None),
        ] {
            assert_eq!(Format::of_content(bytes.as_bytes()), format, "{bytes}");
        }
    }
}
