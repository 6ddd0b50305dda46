//! Wavefront OBJ: vertices with colours and normals, and polygons with texture coordinates.
//!
//! Our own parser, since the vertices must stay as they are: `tobj` stores `f32` unless the whole
//! build is switched, regroups vertices by object, and drops those that no face uses.

mod colors;
mod mtl;
mod normals;

use std::collections::HashMap;
use std::io::{self, Write};

use super::channel::{Scalar, match_column};
use super::color::ColorLayout;
use super::paint::Painted;
use super::source::Source;
use super::text::{line_error, lines, number, shown, table_of_doubles};
use super::texture_coordinates::{Coordinates, OF_CORNERS, float};
use super::{Column, Scan, ScanError};
use colors::Surface;
use mtl::split_word;
pub(super) use mtl::write as write_library;
use normals::Normals;

/// Reads an OBJ file. Coordinates, colours and normals become `double` channels; where vertices have
/// no colours, those of the materials and their textures become `uchar` channels. Texture coordinates become
/// a list of the faces. Lines, points and groups are dropped.
pub(super) fn read(source: &Source) -> Result<Scan, ScanError> {
    Ok(lines_of(source)?.finish(source))
}

/// Reads an OBJ file with the materials of its faces; colours of vertices are those of the file itself.
pub(super) fn read_painted(source: &Source) -> Result<Painted, ScanError> {
    let mut reader = lines_of(source)?;
    reader.take_positions();
    reader.take_own_colors();
    reader.take_texture_coordinates();
    let Reader { scan, surface, .. } = reader;
    Ok(surface.painted(scan, source))
}

fn lines_of(source: &Source) -> Result<Reader, ScanError> {
    let mut reader = Reader::default();
    let mut continued: Option<(usize, String)> = None;
    for (line_number, line) in lines(source.bytes) {
        let line = line.trim_end();
        let (first, mut text) = continued.take().unwrap_or((line_number, String::new()));
        text.push_str(line);
        if let Some(open) = text.strip_suffix('\\') {
            continued = Some((first, format!("{open} ")));
            continue;
        }
        reader
            .line(&text)
            .map_err(|reason| line_error(source.name, first, reason))?;
    }
    if let Some((first, text)) = continued {
        reader
            .line(&text)
            .map_err(|reason| line_error(source.name, first, reason))?;
    }
    Ok(reader)
}

#[derive(Default)]
struct Reader {
    scan: Scan,
    positions: Vec<[f64; 3]>,
    colors: Vec<[f64; 3]>,
    surface: Surface,
    normals: Normals,
    face: Vec<u32>,
    corners: usize,
    dropped: Dropped,
}

/// How often something was met that a scan has no place for.
#[derive(Default)]
struct Dropped {
    lines_and_points: usize,
    weights: usize,
    other: usize,
}

impl Reader {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let (keyword, name) = split_word(line);
        match keyword {
            // Names of materials may have a number sign.
            "usemtl" => return self.surface.use_material(name, self.scan.faces.len()),
            "mtllib" => {
                self.surface.add_library(name);
                return Ok(());
            }
            _ => {}
        }
        let line = line.split('#').next().unwrap_or_default();
        let mut tokens = line.split_whitespace();
        match tokens.next() {
            Some("v") => self.vertex(tokens)?,
            Some("f") => self.polygon(tokens)?,
            Some("vt") => self.surface.coordinates.push(texture_coordinates(tokens)),
            Some("vn") => self.normals.push(tokens),
            Some("l" | "p") => self.dropped.lines_and_points += 1,
            None | Some("g" | "o" | "s") => {}
            Some(_) => self.dropped.other += 1,
        }
        Ok(())
    }

    fn vertex<'a>(&mut self, tokens: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let values = tokens.map(number).collect::<Result<Vec<_>, _>>()?;
        // x y z, perhaps a weight, perhaps a colour.
        let (position, color) = match *values.as_slice() {
            [x, y, z] => ([x, y, z], None),
            [x, y, z, _] => ([x, y, z], None),
            [x, y, z, r, g, b] | [x, y, z, _, r, g, b] => ([x, y, z], Some([r, g, b])),
            _ => return Err("a vertex is `v x y z` or `v x y z red green blue`".to_owned()),
        };
        if values.len() % 3 == 1 {
            self.dropped.weights += 1;
        }
        self.positions.push(position);
        self.colors.extend(color);
        Ok(())
    }

    fn polygon<'a>(&mut self, corners: impl Iterator<Item = &'a str>) -> Result<(), String> {
        self.face.clear();
        for corner in corners {
            let mut tokens = corner.split('/');
            let token = tokens.next().unwrap_or_default();
            let index: i64 = token
                .parse()
                .map_err(|_| format!("`{}` is not the index of a vertex", shown(corner)))?;
            let vertex = from_zero(index, self.positions.len())
                .ok_or_else(|| format!("there is no vertex `{}`", shown(corner)))?;
            self.face.push(vertex);
            let mut index = |so_far: usize| {
                let index = tokens.next().and_then(|t| t.parse().ok())?;
                from_zero(index, so_far)
            };
            let texture = index(self.surface.coordinates.len());
            let normal = index(self.normals.len());
            self.surface
                .push_corner(texture, self.corners + self.face.len() - 1);
            self.normals.push_corner(vertex, normal);
        }
        if self.face.len() < 3 {
            return Err("a face has three vertices or more".to_owned());
        }
        self.corners += self.face.len();
        if u32::try_from(self.corners).is_err() {
            return Err("the faces have 2^32 corners or more".to_owned());
        }
        self.scan.faces.push_row(&self.face);
        Ok(())
    }

    fn finish(mut self, source: &Source) -> Scan {
        let name = source.name;
        self.take_positions();
        if let Some(normals) = self.normals.of_vertices(self.positions.len(), name) {
            let normals = table_of_doubles(["nx", "ny", "nz"], &normals);
            self.scan.vertices.channels.extend(normals.channels);
        }
        if !self.take_own_colors() {
            if !self.colors.is_empty() {
                log::warn!("{name}: colours dropped, since only some vertices have one");
            }
            let colors = self
                .surface
                .colors(&self.scan.faces, self.positions.len(), source);
            for (k, channel) in ["red", "green", "blue"].into_iter().enumerate() {
                if let Some(colors) = &colors {
                    let values = colors.iter().map(|color| color[k]).collect();
                    let values = Column::U8(values);
                    self.scan.vertices.set_channel(channel, values);
                }
            }
        }
        self.take_texture_coordinates();
        for (count, what) in [
            (self.dropped.lines_and_points, "lines and points"),
            (self.dropped.weights, "weights of vertices"),
            (self.dropped.other, "statements of other kinds"),
        ] {
            if count > 0 {
                log::warn!(
                    "{name}: {count} {what} dropped; relievo keeps vertices and faces of OBJ"
                );
            }
        }
        self.scan
    }

    fn take_positions(&mut self) {
        self.scan.vertices = table_of_doubles(["x", "y", "z"], &self.positions);
    }

    /// Takes the colours of the vertices, if all have one.
    fn take_own_colors(&mut self) -> bool {
        let complete = self.colors.len() == self.positions.len();
        if complete {
            let colors = table_of_doubles(["red", "green", "blue"], &self.colors);
            self.scan.vertices.channels.extend(colors.channels);
        }
        complete
    }

    fn take_texture_coordinates(&mut self) {
        if let Some(coordinates) = self.surface.texture_coordinates(&self.scan.faces) {
            (self.scan.face_channels).set_channel(OF_CORNERS, coordinates);
        }
    }
}

/// An index of an OBJ file (from 1, or negative from the last one so far) as one from 0.
fn from_zero(index: i64, so_far: usize) -> Option<u32> {
    let so_far = i64::try_from(so_far).ok()?;
    let index = if index < 0 { so_far + index } else { index - 1 };
    u32::try_from(index).ok()
}

/// u and v; what cannot be understood is 0, as a missing v is.
fn texture_coordinates<'a>(mut tokens: impl Iterator<Item = &'a str>) -> [f64; 2] {
    [(); 2].map(|()| tokens.next().and_then(f64::parse).unwrap_or(0.0))
}

/// Writes positions, colours, faces and their texture coordinates. Whole-number colours become intensities
/// from 0 to 1.
///
/// With a material, the name of whose library is given, there are no colours of vertices: readers would
/// take them, or mix both.
pub(super) fn write(scan: &Scan, library: Option<&str>, out: &mut impl Write) -> io::Result<()> {
    if let Some(library) = library {
        writeln!(out, "mtllib {library}")?;
    }
    let layout = ColorLayout::of(&scan.vertices).filter(|_| library.is_none());
    let colors: Vec<&Column> = layout
        .iter()
        .flat_map(|l| l.channels.map(|c| &scan.vertices.channels[c].values))
        .collect();
    let full = layout.map_or(1.0, |l| l.full);
    let mut line = Vec::new();
    for row in 0..scan.vertices.rows {
        line.clear();
        line.push(b'v');
        // `float` channels print as such: their shortest text is shorter than that of the double.
        for axis in ["x", "y", "z"] {
            line.push(b' ');
            if let Some(column) = scan.vertices.column(axis) {
                push_value(column, row, &mut line);
            }
        }
        for column in &colors {
            line.push(b' ');
            match column {
                // Fractions stay as they were read, whatever their scale.
                Column::F32(_) | Column::F64(_) => push_value(column, row, &mut line),
                whole => {
                    let intensity = whole.get_f64(row).unwrap_or(0.0) / full;
                    <f32 as Scalar>::rounded(intensity).push_ascii(&mut line);
                }
            }
        }
        line.push(b'\n');
        out.write_all(&line)?;
    }
    write_faces(scan, library.is_some(), out)
}

/// Writes the different texture coordinates, and the faces.
fn write_faces(scan: &Scan, with_material: bool, out: &mut impl Write) -> io::Result<()> {
    let coordinates = Coordinates::of(scan);
    let of_face = |number: usize, face: &[u32]| {
        let places = coordinates
            .map(|c| c.face(number, face))
            .unwrap_or_default();
        places
            .into_iter()
            .map(|place| place.map(f64::to_bits))
            .collect::<Vec<_>>()
    };
    let mut line = Vec::new();
    let mut numbers: HashMap<[u64; 2], usize> = HashMap::new();
    for (number, face) in scan.faces.rows().enumerate() {
        for place in of_face(number, face) {
            let next = numbers.len() + 1;
            if *numbers.entry(place).or_insert(next) == next {
                line.clear();
                line.extend_from_slice(b"vt");
                for value in place.map(f64::from_bits) {
                    line.push(b' ');
                    push_shortest(value, &mut line);
                }
                line.push(b'\n');
                out.write_all(&line)?;
            }
        }
    }
    if with_material {
        writeln!(out, "usemtl {}", mtl::TEXTURE)?;
    }
    for (number, face) in scan.faces.rows().enumerate() {
        line.clear();
        line.push(b'f');
        let places = of_face(number, face);
        for (corner, index) in face.iter().enumerate() {
            // u64: index 2^32 - 1 is vertex 2^32 there.
            write!(line, " {}", u64::from(*index) + 1)?;
            if let Some(place) = places.get(corner).and_then(|place| numbers.get(place)) {
                write!(line, "/{place}")?;
            }
        }
        line.push(b'\n');
        out.write_all(&line)?;
    }
    Ok(())
}

/// Pushes the shortest text of a number, which is mostly a `float` of the file.
fn push_shortest(value: f64, line: &mut Vec<u8>) {
    let single = float(value);
    if f64::from(single).to_bits() == value.to_bits() {
        single.push_ascii(line);
    } else {
        value.push_ascii(line);
    }
}

fn push_value(column: &Column, row: usize, line: &mut Vec<u8>) {
    match_column!(
        column,
        values => values[row].push_ascii(line),
        _lists => {}
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Rng, Stage};
    use crate::scan::{Format, ReadOptions, read_from};

    fn scan(text: &str) -> Result<Scan, String> {
        read_bytes(text.as_bytes()).map_err(|e| e.to_string())
    }

    fn read_bytes(bytes: &[u8]) -> Result<Scan, ScanError> {
        read(&Source {
            bytes,
            name: "a.obj",
            folder: None,
            options: &ReadOptions::default(),
        })
    }

    #[test]
    fn every_kind_of_face_is_read() {
        let text = "# tower\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\n\
                    f 1 2 3\nf 1/1 2/1 3/1\nf 1//1 3//1 4//1\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -4 -3 -2\n\
                    v 7 7 7\n";
        for ending in ["\n", "\r\n", "\r"] {
            let scan = scan(&text.replace('\n', ending)).unwrap();
            let faces: Vec<&[u32]> = scan.faces.rows().collect();
            let expected: [&[u32]; 5] = [
                &[0, 1, 2],
                &[0, 1, 2],
                &[0, 2, 3],
                &[0, 1, 2, 3],
                &[0, 1, 2],
            ];
            assert_eq!(faces, expected);
            assert_eq!(scan.vertices.rows, 5);
            assert_eq!(scan.colors(), None);
        }
    }

    #[test]
    fn doubles_and_colors_survive_the_way_out_and_back() {
        let text =
            "v 0.1234567890123456 1e-30 -0 0.5 0.25 1\nv 1 0 0 0 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n";
        let first = scan(text).unwrap();
        assert_eq!(
            first.vertices.column("x").unwrap().get_f64(0),
            Some(0.123_456_789_012_345_6)
        );
        assert_eq!(first.colors().unwrap()[..1], [[0.5, 0.25, 1.0]]);
        let mut out = Vec::new();
        write(&first, None, &mut out).unwrap();
        assert_eq!(String::from_utf8(out.clone()).unwrap(), text);
        assert_eq!(read_bytes(&out).unwrap(), first);
    }

    #[test]
    fn colors_keep_their_digits_and_their_scale() {
        let text = "v 0 0 0 0.12345678901 0 1\n";
        for text in [text, "v 0 0 0 255 127.5 0\n"] {
            let mut out = Vec::new();
            write(&scan(text).unwrap(), None, &mut out).unwrap();
            assert_eq!(String::from_utf8(out).unwrap(), text);
        }
        let mut bytes = scan(text).unwrap();
        for name in ["red", "green", "blue"] {
            bytes.vertices.set_channel(name, Column::U8(vec![51]));
        }
        let mut out = Vec::new();
        write(&bytes, None, &mut out).unwrap();
        assert_eq!(out, b"v 0 0 0 0.2 0.2 0.2\n");
    }

    #[test]
    fn long_lines_may_be_broken_and_some_colors_are_none() {
        let scan = scan("v 0 0 0\nv 1 0 0 1 1 1\nv 0 1 0 1\nf 1 \\\n2 \\\n3\n").unwrap();
        assert_eq!(scan.faces.row(0), [0, 1, 2]);
        assert_eq!(scan.colors(), None);
    }

    #[test]
    fn normals_are_kept_if_each_vertex_has_one() {
        let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 0\nvn 0 0 1\n";
        let nz = |faces: &str| {
            let scan = scan(&format!("{corners}{faces}\n")).unwrap();
            scan.vertices.column("nz").cloned()
        };
        let in_order = Some(Column::F64(vec![1.0, 0.0, 1.0]));
        assert_eq!(nz(""), in_order);
        assert_eq!(nz("f 1//1 2//2 3//3"), in_order);
        assert_eq!(
            nz("f 1//2 2//1 3//2"),
            Some(Column::F64(vec![0.0, 1.0, 0.0]))
        );
        assert!(nz("f 1//1 2//1 3//1\nf 1//-1 2//3 3//1").is_some());
        assert_eq!(nz("f 1//1 2//1 3//1\nf 1//2 2//1 3//1"), None);
        assert_eq!(nz("f 1//1 2//1 3//9"), None);
        assert_eq!(nz("f 1//2 2//1 3"), None);
    }

    #[test]
    fn broken_files_are_scans_or_errors() {
        let good = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvn 0 0 1\nusemtl a\n\
                    f 1/1/1 2/1/-1 3//1\n";
        let mut rng = Rng::new(1, Stage::Synth, 0);
        for length in 0..good.len() {
            let check = |bytes: &[u8]| {
                if let Ok(scan) = read_from(bytes, Format::Obj, "a.obj", &ReadOptions::default()) {
                    assert!(scan.check("a.obj").is_ok());
                }
            };
            check(&good.as_bytes()[..length]);
            for _ in 0..50 {
                let mut bad = good.as_bytes().to_vec();
                bad[length] = u8::try_from(rng.index(256)).unwrap();
                let other = rng.index(bad.len());
                bad[other] = b"0123456789-/. \n"[rng.index(15)];
                check(&bad);
            }
        }
    }

    #[test]
    fn bad_lines_are_named() {
        for bad in [
            "v 1 2",
            "v 1 2 x",
            "f 1 2",
            "f 0 1 2",
            "f 1 2 -9",
            "f 1 2 x/3",
            "f 1 2 99999999999",
        ] {
            let error = scan(&format!("v 0 0 0\nv 0 0 1\n\n{bad}\n")).unwrap_err();
            assert!(error.contains("line 4"), "{bad}: {error}");
        }
    }
}
