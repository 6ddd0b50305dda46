//! The doors: which format, read, write.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;

use super::{OutputFile, Scan, ScanError, obj, off, ply, ply_write, range_grid, stl};

/// A file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Stanford PLY.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Geomview OFF; can only be read.
    Off,
    /// STL.
    Stl,
}

impl Format {
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
        match extension.to_str() {
            Some("ply") => Ok(Self::Ply),
            Some("obj") => Ok(Self::Obj),
            Some("off") => Ok(Self::Off),
            Some("stl") => Ok(Self::Stl),
            _ => Err(ScanError::UnknownFormat {
                name: path.display().to_string(),
            }),
        }
    }

    /// The format that the first bytes tell beyond doubt.
    fn of_content(bytes: &[u8]) -> Option<Self> {
        let first = bytes.split(u8::is_ascii_whitespace).next()?;
        match first {
            _ if first.len() == bytes.len() => None,
            b"ply" => Some(Self::Ply),
            b"OFF" | b"COFF" | b"NOFF" | b"CNOFF" => Some(Self::Off),
            _ => None,
        }
    }
}

/// How to write.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// PLY as text instead of binary; the other formats have one way only. Default: binary.
    pub ascii: bool,
}

/// Reads a scan. The format follows from the file's first bytes where they are clear, or else from
/// its extension; `-` reads PLY from standard input. Range grids become triangles.
///
/// # Errors
/// A [`ScanError`] that names the file; see there.
pub fn read(path: &Path) -> Result<Scan, ScanError> {
    if path == Path::new("-") {
        return read_from(std::io::stdin().lock(), Format::Ply, "standard input");
    }
    let name = path.display().to_string();
    if path.is_dir() {
        return Err(ScanError::IsFolder { name });
    }
    let bytes = std::fs::read(path).map_err(|source| match source.kind() {
        ErrorKind::NotFound => ScanError::NotFound { name: name.clone() },
        _ => ScanError::Read {
            name: name.clone(),
            source,
        },
    })?;
    let format = match (Format::of_content(&bytes), Format::of_path(path)) {
        (Some(content), Ok(extension)) if content != extension => {
            log::warn!("{name}: read as {content:?}, which its first bytes tell");
            content
        }
        (Some(content), _) => content,
        (None, extension) => extension?,
    };
    parse(&bytes, format, &name)
}

/// Reads a scan of a known format; `name` stands for the file in errors.
///
/// # Errors
/// A [`ScanError`] that names the file; see there.
pub fn read_from(mut reader: impl Read, format: Format, name: &str) -> Result<Scan, ScanError> {
    let mut bytes = Vec::new();
    reader
        .read_to_end(&mut bytes)
        .map_err(|source| ScanError::Read {
            name: name.to_owned(),
            source,
        })?;
    parse(&bytes, format, name)
}

fn parse(bytes: &[u8], format: Format, name: &str) -> Result<Scan, ScanError> {
    let mut scan = match format {
        Format::Ply => ply::read(bytes, name)?,
        Format::Obj => obj::read(bytes, name)?,
        Format::Off => off::read(bytes, name)?,
        Format::Stl => stl::read(bytes, name)?,
    };
    scan.check(name)?;
    range_grid::triangulate(&mut scan, name)?;
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

/// Writes a scan; `name` stands for the file in errors. OBJ keeps positions, colours and faces; STL
/// positions and triangles, rounded to `float`.
///
/// # Errors
/// [`ScanError::CannotWriteFormat`] for OFF; [`ScanError::Write`] with what the system says.
pub fn write_to(
    scan: &Scan,
    writer: &mut impl Write,
    format: Format,
    options: &WriteOptions,
    name: &str,
) -> Result<(), ScanError> {
    let written = match format {
        Format::Ply => ply_write::write(scan, writer, options.ascii),
        Format::Obj => obj::write(scan, writer),
        Format::Stl => stl::write(scan, writer),
        Format::Off => {
            return Err(ScanError::CannotWriteFormat {
                name: name.to_owned(),
            });
        }
    };
    written.map_err(|source| ScanError::Write {
        name: name.to_owned(),
        source,
    })
}
