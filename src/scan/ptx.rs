//! Leica PTX: range grids as text, one scan after the other.
//!
//! A scan begins with its numbers of columns and rows, the scanner's position and three axes, and
//! the four rows of a matrix M that takes its points to the common system: (x y z 1) M. Then its
//! points follow, column by column: `x y z intensity`, or with `red green blue` behind. `0 0 0` is
//! where the scanner saw nothing.
//!
//! Reference: Leica Geosystems, *Cyclone: PTX file format*.

use std::borrow::Cow;
use std::ops::Range;

use nalgebra::{Matrix3, Point3, Vector3};

use super::channel::Scalar;
use super::range_grid::Grid;
use super::source::{Parsed, Source};
use super::text::{line_error, lines, number, table_of_doubles};
use super::{Column, Scan, ScanError, Sensor};

/// Reads a PTX file. Points of a file with more than one scan get a channel `scan` with its index
/// from 0.
pub(super) fn read(source: &Source) -> Result<Parsed, ScanError> {
    let name = source.name;
    let mut lines = lines(source.bytes).filter(|(_, line)| !line.trim().is_empty());
    let mut reader = Reader::default();
    while let Some(first) = lines.next() {
        let mut head = Head::new(name, first.0);
        let columns = head.count(Some(first), "number of columns")?;
        let rows = head.count(lines.next(), "number of rows")?;
        let placement = head.placement(&mut lines)?;
        let size = columns.checked_mul(rows);
        let size = size.ok_or_else(|| {
            let reason = format!("{columns} columns of {rows} rows are more than a file can hold");
            line_error(name, head.line, reason)
        })?;
        reader.scan(&mut lines, [columns, rows, size], &placement, name)?;
    }
    Ok(reader.finish(name))
}

/// The head of one scan, and how far it is read.
struct Head<'a> {
    name: &'a str,
    line: usize,
}

/// Where a scan's points go to, and where its scanner stood.
struct Placement {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
    scanner: Point3<f64>,
}

impl<'a> Head<'a> {
    fn new(name: &'a str, line: usize) -> Self {
        Self { name, line }
    }

    fn numbers<const N: usize>(
        &mut self,
        line: Option<(usize, Cow<str>)>,
        what: &str,
    ) -> Result<[f64; N], ScanError> {
        let Some((line_number, line)) = line else {
            let reason = format!("the file ends before the {what} of a scan; it is cut off");
            return Err(line_error(self.name, self.line, reason));
        };
        self.line = line_number;
        let values = numbers(&line).ok().filter(|(_, count)| *count == N);
        let values = values.and_then(|(v, _)| v.first_chunk::<N>().copied());
        values
            .filter(|v| v.iter().all(|v| v.is_finite()))
            .ok_or_else(|| {
                let reason = format!("the {what} of a scan should be here, as {N} numbers");
                line_error(self.name, self.line, reason)
            })
    }

    fn count(&mut self, line: Option<(usize, Cow<str>)>, what: &str) -> Result<usize, ScanError> {
        let text = line.as_ref().map(|(_, line)| line.trim().to_owned());
        let _: [f64; 1] = self.numbers(line, what)?;
        let count = text.unwrap_or_default().parse::<usize>();
        count.map_err(|_| {
            let reason = format!("the {what} is a whole number that is not negative");
            line_error(self.name, self.line, reason)
        })
    }

    fn placement<'b>(
        &mut self,
        lines: &mut impl Iterator<Item = (usize, Cow<'b, str>)>,
    ) -> Result<Placement, ScanError> {
        let position: [f64; 3] = self.numbers(lines.next(), "scanner's position")?;
        for _ in 0..3 {
            // The matrix below says the same.
            let _: [f64; 3] = self.numbers(lines.next(), "scanner's axes")?;
        }
        let mut matrix = [[0.0; 4]; 4];
        for row in &mut matrix {
            *row = self.numbers(lines.next(), "matrix")?;
        }
        // Rows of the file's matrix are columns of ours: p' = Mᵀ p.
        let rotation = Matrix3::from_fn(|r, c| matrix[c][r]);
        let translation = Vector3::new(matrix[3][0], matrix[3][1], matrix[3][2]);
        // Programs that place the points differ in which of the two they leave at zero.
        let position = Vector3::from(position);
        let scanner = if position == Vector3::zeros() {
            translation
        } else {
            position
        };
        Ok(Placement {
            rotation,
            translation,
            scanner: scanner.into(),
        })
    }
}

/// The numbers of a line: up to seven, and how many there are.
fn numbers(line: &str) -> Result<([f64; 7], usize), String> {
    let mut values = [0.0; 7];
    let mut count = 0;
    for token in line.split_ascii_whitespace() {
        let value = number(token)?;
        if let Some(slot) = values.get_mut(count) {
            *slot = value;
        }
        count += 1;
    }
    Ok((values, count))
}

#[derive(Default)]
struct Reader {
    positions: Vec<[f64; 3]>,
    intensities: Vec<f64>,
    colors: Vec<[f64; 3]>,
    scans: Vec<Range<usize>>,
    sensors: Vec<Sensor>,
    grids: Vec<Grid>,
}

impl Reader {
    /// Reads the points of one scan of so many columns, rows and cells.
    fn scan<'a>(
        &mut self,
        lines: &mut impl Iterator<Item = (usize, Cow<'a, str>)>,
        [columns, rows, size]: [usize; 3],
        placement: &Placement,
        name: &str,
    ) -> Result<(), ScanError> {
        let start = self.positions.len();
        let mut seen: Vec<Option<u32>> = Vec::new();
        while seen.len() < size {
            let Some((line_number, line)) = lines.next() else {
                return Err(ScanError::Truncated {
                    name: name.to_owned(),
                    element: format!("scan {}", self.scans.len()),
                    found: seen.len(),
                    expected: size,
                });
            };
            let vertex = self
                .point(&line, placement)
                .map_err(|reason| line_error(name, line_number, reason))?;
            seen.push(vertex);
        }
        // Column by column in the file, row by row in a grid.
        let mut cells = vec![None; size];
        for (k, vertex) in seen.into_iter().enumerate() {
            cells[k % rows * columns + k / rows] = vertex;
        }
        let vertices = start..self.positions.len();
        self.scans.push(vertices.clone());
        self.sensors.push(Sensor {
            vertices,
            position: placement.scanner,
        });
        self.grids.push(Grid {
            columns,
            cells,
            sensor: Some(placement.scanner),
        });
        Ok(())
    }

    /// Reads a point, and gives its vertex if the scanner saw any.
    fn point(&mut self, line: &str, placement: &Placement) -> Result<Option<u32>, String> {
        let ([x, y, z, intensity, color @ ..], count) = numbers(line)?;
        let local = Vector3::new(x, y, z);
        // Some programs write only the coordinates where nothing was seen.
        if (3..=7).contains(&count)
            && (local == Vector3::zeros() || !local.iter().all(|v| v.is_finite()))
        {
            return Ok(None);
        }
        if count != 4 && count != 7 {
            return Err(format!(
                "it has {count} numbers, where `x y z intensity` or `x y z intensity red green blue` are expected"
            ));
        }
        let vertex = u32::try_from(self.positions.len());
        let vertex = vertex.map_err(|_| "there are 2^32 points or more".to_owned())?;
        let position = placement.rotation * local + placement.translation;
        self.positions.push(position.into());
        self.intensities.push(intensity);
        if count == 7 {
            self.colors.push(color);
        }
        Ok(Some(vertex))
    }

    fn finish(self, name: &str) -> Parsed {
        let mut vertices = table_of_doubles(["x", "y", "z"], &self.positions);
        vertices.set_channel("intensity", Column::F64(self.intensities));
        if self.colors.len() == self.positions.len() {
            for (k, color) in ["red", "green", "blue"].into_iter().enumerate() {
                let values = self.colors.iter().map(|c| Scalar::rounded(c[k]));
                vertices.set_channel(color, Column::U8(values.collect()));
            }
        } else if !self.colors.is_empty() {
            log::warn!("{name}: colours dropped, since not all points have one");
        }
        let mut parsed = Parsed {
            scan: Scan {
                vertices,
                sensors: self.sensors,
                ..Scan::default()
            },
            grids: self.grids,
        };
        parsed.tell_scans_apart(&self.scans);
        parsed
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{damaged, source, truncated};
    use super::*;
    use crate::scan::ReadOptions;

    fn parsed(bytes: &[u8]) -> Result<Parsed, ScanError> {
        read(&source(bytes, &ReadOptions::default()))
    }

    /// Turns x to y and y to -x, then moves.
    const HEAD: &str =
        "2\n3\n10 20 30\n1 0 0\n0 1 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n";

    const POINTS: &str = "1 0 5 0.5 255 0 1\n1 1 5 0.25 2 3 4\n0 0 0 0.5 0 0 0\n2 0 5 0 5 6 7\n0 0 0\n2 2 5 1 8 9 10\n";

    #[test]
    fn points_are_placed_and_their_grid_runs_by_rows() {
        let Parsed { scan, grids } = parsed(format!("{HEAD}{POINTS}").as_bytes()).unwrap();
        let positions = scan.positions();
        assert_eq!(positions[0], Point3::new(10.0, 21.0, 35.0));
        assert_eq!(positions[1], Point3::new(9.0, 21.0, 35.0));
        let column = |name| scan.vertices.column(name);
        assert_eq!(
            column("intensity"),
            Some(&Column::F64(vec![0.5, 0.25, 0.0, 1.0]))
        );
        assert_eq!(column("red"), Some(&Column::U8(vec![255, 2, 5, 8])));
        assert_eq!(column("scan"), None);
        let cells = [Some(0), Some(2), Some(1), None, None, Some(3)];
        assert_eq!((grids[0].columns, &grids[0].cells[..]), (2, &cells[..]));
        assert_eq!(scan.sensors[0].position, Point3::new(10.0, 20.0, 30.0));
    }

    #[test]
    fn several_scans_are_told_apart() {
        let plain = "1\r\n1\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n0 0 1\r\n1 0 0 0\r\n0 1 0 0\r\n0 0 1 0\r\n0 0 7 1\r\n1 2 3 0.5\r\n";
        let text = format!("{HEAD}{POINTS}\n{plain}");
        let Parsed { scan, grids } = parsed(text.as_bytes()).unwrap();
        assert_eq!(
            scan.vertices.column("scan"),
            Some(&Column::U16(vec![0, 0, 0, 0, 1]))
        );
        assert_eq!(scan.vertices.column("red"), None);
        assert_eq!(scan.sensors[1].vertices, 4..5);
        assert_eq!(scan.sensors[1].position, Point3::new(0.0, 0.0, 7.0));
        assert_eq!(scan.positions()[4], Point3::new(1.0, 2.0, 10.0));
        assert_eq!(grids[1].cells, [Some(4)]);
    }

    #[test]
    fn bad_files_are_named() {
        let text = format!("{HEAD}{POINTS}");
        for (from, to, part) in [
            (
                "2\n3\n",
                "2\n4\n",
                "promises 8 rows of `scan 0`, but only 6",
            ),
            (
                "2\n3\n",
                "99999999999\n99999999999\n",
                "more than a file can hold",
            ),
            ("2\n3\n", "-2\n3\n", "line 1: the number of columns is"),
            ("2\n3\n", "2\nthree\n", "line 2: the number of rows"),
            ("2\n3\n", "2\n2\n", "line 15: the number of columns"),
            ("10 20 30\n1", "10 20\n1", "line 3: the scanner's position"),
            ("10 20 30 1\n", "10 20 nan 1\n", "line 10: the matrix"),
            ("0 1 0 0\n", "", "line 10: the matrix"),
            (
                "1 1 5 0.25 2 3 4",
                "1 1 5 0.25 2 3",
                "line 12: it has 6 numbers",
            ),
            ("1 1 5 0.25 2 3 4", "1 1 five", "line 12: `five`"),
        ] {
            let changed = text.replacen(from, to, 1);
            assert_ne!(changed, text, "{from}");
            let error = parsed(changed.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(part), "{to}: {error}");
        }
    }

    #[test]
    fn whatever_the_bytes_there_is_a_scan_or_an_error() {
        let file = format!("{HEAD}{POINTS}{HEAD}{POINTS}");
        truncated(file.as_bytes(), parsed);
        damaged(file.as_bytes(), parsed);
    }
}
