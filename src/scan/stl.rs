//! STL: triangles in ASCII or binary; corners at the same place become one vertex.
//!
//! Our own parser, since `stl_io` rounds the numbers of text to `f32`, takes every binary
//! file that begins with `solid` for text, and does not say where a file is broken.

use std::collections::HashMap;
use std::io::{self, Write};

use nalgebra::Point3;

use super::channel::Scalar;
use super::text::{line_error, lines, number, table_of_doubles};
use super::{Column, Scan, ScanError, Table};
use crate::mesh::triangle_normal;

/// A binary file: 80 bytes of anything, the number of triangles, 50 bytes each.
const HEADER: usize = 84;
const FACET: usize = 50;

/// Reads an STL file. Corners whose coordinates are bitwise equal become one vertex, numbered as
/// they come. Normals and attributes are dropped: the triangles' order of corners tells the side.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<Scan, ScanError> {
    // Binary files may begin with `solid`, too; their size gives them away.
    let claimed = bytes
        .get(80..HEADER)
        .and_then(|n| n.try_into().ok())
        .map(u32::from_le_bytes);
    let expected = claimed.and_then(|n| usize::try_from(n).ok());
    let size = expected.and_then(|n| n.checked_mul(FACET)?.checked_add(HEADER));
    let start = bytes.trim_ascii_start();
    let is_solid = start
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let is_text = is_solid && size != Some(bytes.len());
    if is_text {
        return read_text(bytes, name);
    }
    let Some(expected) = expected else {
        let reason = "this is neither an ASCII STL file (`solid …`) nor a binary one";
        return Err(line_error(name, 1, reason));
    };
    let facets = bytes[HEADER..].chunks_exact(FACET);
    if facets.len() < expected {
        return Err(ScanError::Truncated {
            name: name.to_owned(),
            element: "facet".to_owned(),
            found: facets.len(),
            expected,
        });
    }
    if size != Some(bytes.len()) {
        log::warn!("{name}: there is more behind the {expected} triangles, which is ignored");
    }
    let mut weld = Weld::default();
    for facet in facets.take(expected) {
        let mut values = facet[12..48]
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        for _ in 0..3 {
            weld.corner(
                [(); 3].map(|()| values.next().unwrap_or_default()),
                f32::to_bits,
            );
        }
    }
    let positions = &weld.positions;
    let mut vertices = Table::default();
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        vertices.set_channel(axis, Column::F32(positions.iter().map(|p| p[k]).collect()));
    }
    weld.into_scan(vertices, name)
}

fn read_text(bytes: &[u8], name: &str) -> Result<Scan, ScanError> {
    let mut weld = Weld::default();
    let mut corners = 0;
    let mut ended = false;
    let mut last = 1;
    for (line_number, line) in lines(bytes) {
        let error = |reason: String| line_error(name, line_number, reason);
        let mut tokens = line.split_whitespace();
        // Some programs shout.
        let keyword = tokens.next().map(str::to_ascii_lowercase);
        match keyword.as_deref() {
            Some("vertex") => {
                let values = tokens
                    .map(number)
                    .collect::<Result<Vec<_>, _>>()
                    .map_err(error)?;
                let [x, y, z] = *values.as_slice() else {
                    return Err(error("a vertex has three coordinates".to_owned()));
                };
                weld.corner([x, y, z], f64::to_bits);
                corners += 1;
            }
            Some("endloop") => {
                if corners != 3 {
                    return Err(error(format!("a facet has 3 corners, not {corners}")));
                }
                corners = 0;
            }
            Some("endsolid") => ended = true,
            Some("solid" | "facet" | "outer" | "endfacet") | None => {}
            Some(_) => return Err(error("this is not a line of an ASCII STL file".to_owned())),
        }
        last = line_number;
    }
    if !ended || corners != 0 {
        return Err(line_error(name, last, "the file ends before `endsolid`"));
    }
    let vertices = table_of_doubles(["x", "y", "z"], &weld.positions);
    weld.into_scan(vertices, name)
}

/// Corners to vertices.
#[derive(Default)]
struct Weld<T, B> {
    known: HashMap<[B; 3], u32>,
    positions: Vec<[T; 3]>,
    corners: Vec<u32>,
}

impl<T: Copy, B: Eq + std::hash::Hash> Weld<T, B> {
    fn corner(&mut self, position: [T; 3], bits: impl Fn(T) -> B) {
        // Past 2^32 vertices the index is wrong, but `into_scan` refuses such a file.
        let next = u32::try_from(self.positions.len()).unwrap_or(u32::MAX);
        let vertex = *self.known.entry(position.map(bits)).or_insert(next);
        if vertex == next {
            self.positions.push(position);
        }
        self.corners.push(vertex);
    }

    fn into_scan(self, vertices: Table, name: &str) -> Result<Scan, ScanError> {
        if u32::try_from(self.corners.len()).is_err() {
            return Err(ScanError::TooLarge {
                name: name.to_owned(),
                what: "corners of faces",
            });
        }
        let mut scan = Scan {
            vertices,
            ..Scan::default()
        };
        for face in self.corners.chunks_exact(3) {
            scan.faces.push_row(face);
        }
        Ok(scan)
    }
}

/// Writes a binary STL file: positions rounded to `float`, polygons split into triangles.
pub(super) fn write(scan: &Scan, out: &mut impl Write) -> io::Result<()> {
    let mesh = scan.mesh();
    let count = u32::try_from(mesh.triangles.len())
        .map_err(|_| io::Error::other("STL holds fewer than 2^32 triangles"))?;
    let mut buffer = Vec::with_capacity(HEADER);
    // Must not begin with `solid`: some programs take that for ASCII.
    buffer.extend_from_slice(b"binary STL written by relievo");
    buffer.resize(80, b' ');
    count.push_le(&mut buffer);
    out.write_all(&buffer)?;
    for f in 0..mesh.triangles.len() {
        buffer.clear();
        let corners: [Point3<f64>; 3] = mesh.corners(f);
        let normal = triangle_normal(corners);
        let normal = normal.try_normalize(0.0).unwrap_or_default();
        let corners = corners.iter().flat_map(|p| p.coords.iter());
        for value in normal.iter().chain(corners) {
            <f32 as Scalar>::rounded(*value).push_le(&mut buffer);
        }
        buffer.extend_from_slice(&[0, 0]);
        out.write_all(&buffer)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid two triangles\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n\
        vertex 1 0 0\nvertex 0 1e0 0\nendloop\nendfacet\n  facet normal 0 0 1\n outer loop\n\
        vertex 1 0 0\nvertex 1 1 0.1\nvertex 0 1 0\nendloop\nendfacet\nendsolid two triangles\n";

    #[test]
    fn text_and_binary_weld_corners() {
        let text = read(TEXT.as_bytes(), "a.stl").unwrap();
        assert_eq!(text.vertices.rows, 4);
        let faces: Vec<&[u32]> = text.faces.rows().collect();
        assert_eq!(faces, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(text.vertices.column("z").unwrap().get_f64(3), Some(0.1));
        let mut out = Vec::new();
        write(&text, &mut out).unwrap();
        assert_eq!(out.len(), HEADER + 2 * FACET);
        let binary = read(&out, "a.stl").unwrap();
        assert_eq!(binary.faces, text.faces);
        assert_eq!(
            binary.vertices.column("z").unwrap().get_f64(3),
            Some(f64::from(0.1f32))
        );
        // Some programs begin binary files with `solid`, too.
        out[..5].copy_from_slice(b"solid");
        assert_eq!(read(&out, "a.stl").unwrap(), binary);
    }

    #[test]
    fn truncated_files_are_errors() {
        let mut binary = Vec::new();
        write(&read(TEXT.as_bytes(), "a.stl").unwrap(), &mut binary).unwrap();
        for n in 0..binary.len() {
            assert!(read(&binary[..n], "a.stl").is_err(), "{n}");
        }
        let complete = TEXT.find("endsolid").unwrap() + 8;
        for n in 0..complete {
            assert!(read(&TEXT.as_bytes()[..n], "a.stl").is_err(), "{n}");
        }
    }

    #[test]
    fn bad_lines_are_named() {
        for (from, to, line) in [
            ("vertex 1 0 0\nvertex 0 1e0 0", "vertex 1 0 0", 6),
            ("vertex 0 0 0", "vertex 0 0", 4),
            ("outer loop", "nonsense", 3),
        ] {
            let error = read(TEXT.replacen(from, to, 1).as_bytes(), "a.stl").unwrap_err();
            assert!(
                error.to_string().contains(&format!("line {line}:")),
                "{error}"
            );
        }
    }
}
