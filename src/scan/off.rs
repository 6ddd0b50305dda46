//! Object file format (OFF) of Geomview, with colours (`COFF`) and normals (`NOFF`) of vertices.

use std::io::{self, Write};

use super::channel::{Scalar, match_column};
use super::color;
use super::text::{line_error, lines, number, shown, table_of_doubles};
use super::{Column, Scan, ScanError, Table};

/// Reads an OFF file. Whole-number colours become `uchar` channels, others `double`; colours of
/// faces are dropped with a warning.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<Scan, ScanError> {
    let mut lines = lines(bytes)
        .map(|(number, line)| {
            let text = line.split('#').next().unwrap_or_default();
            (number, text.trim().to_owned())
        })
        .filter(|(_, line)| !line.is_empty());
    let (kind, [vertices, faces]) = read_header(&mut lines, name)?;
    let mut reader = Reader {
        kind,
        ..Reader::default()
    };
    for (element, expected) in [("vertex", vertices), ("face", faces)] {
        for found in 0..expected {
            let Some((line_number, line)) = lines.next() else {
                return Err(ScanError::Truncated {
                    name: name.to_owned(),
                    element: element.to_owned(),
                    found,
                    expected,
                });
            };
            let done = if element == "vertex" {
                reader.vertex(&line)
            } else {
                reader.face(&line)
            };
            done.map_err(|reason| line_error(name, line_number, reason))?;
        }
    }
    if reader.face_colors > 0 {
        log::warn!(
            "{name}: colours of {} faces dropped; relievo keeps those of vertices",
            reader.face_colors
        );
    }
    Ok(reader.finish(name))
}

/// What the header's keyword says about the vertices.
#[derive(Default, Clone, Copy)]
struct Kind {
    normals: bool,
    /// `NCOFF`, as `MeshLab` calls it, has the normals behind the colours.
    normals_last: bool,
}

fn read_header(
    lines: &mut impl Iterator<Item = (usize, String)>,
    name: &str,
) -> Result<(Kind, [usize; 2]), ScanError> {
    let end = |line: usize| {
        line_error(
            name,
            line,
            "the file ends before the numbers of vertices and faces",
        )
    };
    let (mut line_number, mut line) = lines.next().ok_or_else(|| end(1))?;
    let mut kind = Kind::default();
    let keyword = line
        .split_whitespace()
        .next()
        .unwrap_or_default()
        .to_owned();
    if let Some(prefix) = keyword.strip_suffix("OFF") {
        // Colours are told by the values on a vertex's line: many programs write them below `OFF`.
        match prefix {
            "" | "C" => {}
            "N" | "CN" => kind.normals = true,
            "NC" => (kind.normals, kind.normals_last) = (true, true),
            _ => {
                let reason = format!(
                    "`{}` is a kind of OFF that relievo does not read",
                    shown(&keyword)
                );
                return Err(line_error(name, line_number, reason));
            }
        }
        line = line[keyword.len()..].trim().to_owned();
        if line.is_empty() {
            (line_number, line) = lines.next().ok_or_else(|| end(line_number))?;
        }
    }
    let counts: Vec<Option<usize>> = line.split_whitespace().map(|t| t.parse().ok()).collect();
    match *counts.as_slice() {
        [Some(vertices), Some(faces)] | [Some(vertices), Some(faces), _] => {
            Ok((kind, [vertices, faces]))
        }
        _ => Err(line_error(
            name,
            line_number,
            format!(
                "`{}` are not the numbers of vertices, faces and edges",
                shown(&line)
            ),
        )),
    }
}

#[derive(Default)]
struct Reader {
    kind: Kind,
    scan: Scan,
    positions: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    colors: Vec<Vec<f64>>,
    fractions: bool,
    corners: usize,
    face_colors: usize,
}

impl Reader {
    fn vertex(&mut self, line: &str) -> Result<(), String> {
        let values = line
            .split_whitespace()
            .map(number)
            .collect::<Result<Vec<_>, _>>()?;
        let [x, y, z, rest @ ..] = values.as_slice() else {
            return Err("a vertex has three coordinates".to_owned());
        };
        self.positions.push([*x, *y, *z]);
        let rest = if self.kind.normals_last && rest.len() > 3 {
            let (rest, normal) = rest.split_at(rest.len() - 3);
            self.normals.push([normal[0], normal[1], normal[2]]);
            rest
        } else if self.kind.normals {
            let [nx, ny, nz, rest @ ..] = rest else {
                return Err("a vertex of this kind of OFF has a normal".to_owned());
            };
            self.normals.push([*nx, *ny, *nz]);
            rest
        } else {
            rest
        };
        match rest.len() {
            0 => {}
            3 | 4 => {
                self.fractions |= line
                    .split_whitespace()
                    .rev()
                    .take(rest.len())
                    .any(|t| t.contains('.'))
                    || rest.iter().any(|v| !(0.0..=255.0).contains(v));
                self.colors.push(rest.to_vec());
            }
            _ => return Err("a colour has three or four values".to_owned()),
        }
        Ok(())
    }

    fn face(&mut self, line: &str) -> Result<(), String> {
        let mut tokens = line.split_whitespace();
        let count = tokens.next().unwrap_or_default();
        let count: usize = count
            .parse()
            .map_err(|_| format!("`{}` is not a number of corners", shown(count)))?;
        let mut face = Vec::new();
        for token in tokens.by_ref().take(count) {
            let index = u32::parse(token);
            face.push(index.ok_or_else(|| format!("`{}` is not an index", shown(token)))?);
        }
        if face.len() < count {
            return Err(format!(
                "{count} corners are promised, {} are there",
                face.len()
            ));
        }
        self.corners += face.len();
        if u32::try_from(self.corners).is_err() {
            return Err("the faces have 2^32 corners or more".to_owned());
        }
        self.face_colors += usize::from(tokens.next().is_some());
        self.scan.faces.push_row(&face);
        Ok(())
    }

    fn finish(mut self, name: &str) -> Scan {
        let mut table = table_of_doubles(["x", "y", "z"], &self.positions);
        if self.kind.normals {
            let normals = table_of_doubles(["nx", "ny", "nz"], &self.normals);
            table.channels.extend(normals.channels);
        }
        let width = self.colors.first().map_or(0, Vec::len);
        if self.colors.len() == self.positions.len() && self.colors.iter().all(|c| c.len() == width)
        {
            self.color_channels(&mut table, width);
        } else if !self.colors.is_empty() {
            log::warn!("{name}: colours dropped, since not all vertices have the same kind");
        }
        self.scan.vertices = table;
        self.scan
    }

    fn color_channels(&self, table: &mut Table, width: usize) {
        for (k, channel) in ["red", "green", "blue", "alpha"]
            .into_iter()
            .take(width)
            .enumerate()
        {
            let values = self.colors.iter().map(|c| c[k]);
            let column = if self.fractions {
                Column::F64(values.collect())
            } else {
                Column::U8(values.map(Scalar::rounded).collect())
            };
            table.set_channel(channel, column);
        }
    }
}

/// Writes positions, faces, normals (`N`) and colours (`C`). Colours become whole numbers of 0 to 255 with an
/// alpha, which Geomview wants, and without which `Open3D` reads no faces.
pub(super) fn write(scan: &Scan, out: &mut impl Write) -> io::Result<()> {
    let vertices = &scan.vertices;
    let columns = |channels: [usize; 3]| channels.map(|c| &vertices.channels[c].values);
    let normals = vertices.triple(["nx", "ny", "nz"]).map(columns);
    let colors = scan.colors();
    let alpha = vertices.column("alpha");
    let opacity = |row: usize| {
        let part = alpha.and_then(|a| Some(a.get_f64(row)? / color::full_alpha(a)));
        part.unwrap_or(1.0)
    };
    let prefix = match (&colors, &normals) {
        (Some(_), Some(_)) => "CN",
        (Some(_), None) => "C",
        (None, Some(_)) => "N",
        (None, None) => "",
    };
    writeln!(out, "{prefix}OFF\n{} {} 0", vertices.rows, scan.faces.len())?;
    let axes = vertices.triple(["x", "y", "z"]).map(columns);
    let mut line = Vec::new();
    for row in 0..vertices.rows {
        line.clear();
        let numbers = axes
            .into_iter()
            .flatten()
            .chain(normals.into_iter().flatten());
        for column in numbers {
            match_column!(column, values => values[row].push_ascii(&mut line), _lists => {});
            line.push(b' ');
        }
        if let Some(colors) = &colors {
            // Always with the opacity: some programs read no color without it.
            for intensity in colors[row].into_iter().chain([opacity(row)]) {
                <u8 as Scalar>::rounded(intensity * 255.0).push_ascii(&mut line);
                line.push(b' ');
            }
        }
        line.pop();
        line.push(b'\n');
        out.write_all(&line)?;
    }
    for face in scan.faces.rows() {
        write!(out, "{}", face.len())?;
        for index in face {
            write!(out, " {index}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(text: &str) -> Result<Scan, String> {
        read(text.as_bytes(), "a.off").map_err(|e| e.to_string())
    }

    #[test]
    fn variants_give_the_same_mesh() {
        let body = "0 0 0\n1 0 0 # a corner\n\n0 1 0\n1 1 0\n3 0 1 2\n4 0 1 3 2 255 0 0\n";
        for header in [
            "OFF\n4 2 0\n",
            "OFF 4 2 0\n",
            "# c\nOFF\n# c\n4 2\n",
            "4 2 0\n",
            "OFF\r\n4 2 5\r\n",
        ] {
            let scan = scan(&format!("{header}{body}")).unwrap();
            let faces: Vec<&[u32]> = scan.faces.rows().collect();
            let expected: [&[u32]; 2] = [&[0, 1, 2], &[0, 1, 3, 2]];
            assert_eq!(faces, expected, "{header}");
            assert_eq!(scan.vertices.rows, 4);
        }
    }

    #[test]
    fn colors_of_vertices_keep_their_kind() {
        let whole = scan("COFF\n2 0 0\n0 0 0 255 0 51 255\n1 0 0 0 0 0 255\n").unwrap();
        assert_eq!(
            whole.vertices.column("alpha"),
            Some(&Column::U8(vec![255, 255]))
        );
        assert_eq!(whole.colors().unwrap()[..1], [[1.0, 0.0, 0.2]]);
        let parts = scan("OFF\n2 0 0\n0 0 0 1.0 0 0.5\n1 0 0 0 0 0\n").unwrap();
        assert_eq!(parts.colors().unwrap()[..1], [[1.0, 0.0, 0.5]]);
        let normals = scan("CNOFF\n1 0 0\n0 0 0 0 0 1 9 8 7\n").unwrap();
        assert_eq!(normals.vertices.column("nz"), Some(&Column::F64(vec![1.0])));
        assert_eq!(normals.vertices.column("green"), Some(&Column::U8(vec![8])));
    }

    #[test]
    fn what_is_written_reads_back_the_same() {
        let body = "0.1 1e-300 -3\n1 0 0\n0 123456.789 0\n1 1 0\n";
        let colored = "0 0 0.5 0 0 1 9 8 7 255\n1 0 0 0 1 0 255 0 0 6\n0 1 0 1 0 0 0 0 255 0\n";
        for text in [
            format!("OFF\n4 2 0\n{body}3 0 1 2\n4 0 1 3 2\n"),
            "COFF\n2 0 0\n0 0 0 255 0 51 255\n1 0 0 0 0 0 7\n".to_owned(),
            format!("CNOFF\n3 1 0\n{colored}3 0 1 2\n"),
            "NOFF\n1 0 0\n0 0 0 0 0 1\n".to_owned(),
        ] {
            let first = scan(&text).unwrap();
            let mut out = Vec::new();
            write(&first, &mut out).unwrap();
            assert_eq!(String::from_utf8(out).unwrap(), text);
        }
    }

    #[test]
    fn fractions_of_colors_become_whole_numbers() {
        let mut out = Vec::new();
        let parts = scan("OFF\n1 0 0\n0 0 0 1.0 0 0.2 0.5\n").unwrap();
        write(&parts, &mut out).unwrap();
        assert_eq!(out, b"COFF\n1 0 0\n0 0 0 255 0 51 128\n");
    }

    #[test]
    fn colors_are_written_with_their_opacity() {
        let bare = scan("CNOFF\n1 0 0\n0 0 0 0 0 1 9 8 7\n").unwrap();
        let mut out = Vec::new();
        write(&bare, &mut out).unwrap();
        assert_eq!(out, b"CNOFF\n1 0 0\n0 0 0 0 0 1 9 8 7 255\n");
    }

    #[test]
    fn bad_files_are_named() {
        for (text, part) in [
            ("", "line 1"),
            ("OFF\n", "line 1"),
            ("OFF\nx y\n", "line 2"),
            ("4OFF\n1 0 0\n", "line 1"),
            ("OFF BINARY\n\u{1}", "line 1"),
            ("OFF\n9999999999 1 0\n0 0 0\n", "only 1 are there"),
            ("OFF\n1 1 0\n0 0 0\n", "only 0 are there"),
            ("OFF\n1 1 0\n0 0\n", "line 3"),
            ("OFF\n1 1 0\n0 0 0\n9999999999 0 1", "line 4"),
            ("OFF\n1 1 0\n0 0 0\n3 0 -1 0", "line 4"),
        ] {
            let error = scan(text).unwrap_err();
            assert!(error.contains(part), "{text:?}: {error}");
        }
    }
}
