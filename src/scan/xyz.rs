//! Columns of numbers as text: XYZ, PTS, TXT, CSV, ASC.
//!
//! One point a line, its numbers separated by blanks, tabs, commas or semicolons; blank lines and
//! comments (`#`, `//`) anywhere. Names of the columns may stand in the line, or in a comment, above
//! the points. PTS files begin with the number of points, and may hold several such blocks.

mod columns;

use super::names::{MOST_COLUMNS, channel_names};
use super::source::Source;
use super::text::{line_error, lines, number};
use super::{Scan, ScanError};

/// Reads a file of columns. Points whose coordinates are not finite numbers, as some programs write
/// where the scanner saw nothing, are dropped with a warning.
pub(super) fn read(source: &Source) -> Result<Scan, ScanError> {
    let name = source.name;
    let bytes = source.bytes;
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = Reader::new(Dialect::of(bytes));
    if let Some(columns) = &source.options.columns {
        reader.set_names(given_names(columns));
        if reader.axes.is_none() {
            return Err(ScanError::MissingOption {
                name: name.to_owned(),
                reason: "the names given to its columns must hold x, y and z; name the columns in \
                         their order, and those to be skipped `-`"
                    .to_owned(),
            });
        }
    }
    for (number, line) in lines(bytes) {
        let read = reader.line(number, line.trim());
        read.map_err(|reason| line_error(name, number, reason))?;
    }
    reader.finish(name)
}

/// Names as given by the user; those of columns to be skipped are empty.
fn given_names(columns: &[String]) -> Vec<String> {
    let mut names = channel_names(columns.iter().map(String::as_str));
    for (name, given) in names.iter_mut().zip(columns) {
        if given.trim() == "-" {
            name.clear();
        }
    }
    names
}

/// How numbers are separated and written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Dialect {
    /// What separates numbers besides blanks and tabs.
    separator: Option<u8>,
    /// Whether `0,5` is one half.
    decimal_comma: bool,
}

impl Dialect {
    /// The dialect of the first lines of numbers.
    fn of(bytes: &[u8]) -> Self {
        /// So many tell it, unless all their numbers happen to be whole.
        const SAMPLE: usize = 100;
        let (mut commas, mut semicolons, mut decimal) = (false, false, true);
        let numeric =
            |line: &str| line.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        for (_, line) in lines(bytes)
            .filter(|(_, line)| numeric(line.trim()))
            .take(SAMPLE)
        {
            semicolons |= line.contains(';');
            commas |= line.contains(',');
            decimal &= has_decimal_commas(&line);
        }
        let separator = match (semicolons, commas && !decimal) {
            (true, _) => Some(b';'),
            (false, true) => Some(b','),
            (false, false) => None,
        };
        Self {
            separator,
            decimal_comma: commas && separator != Some(b','),
        }
    }
}

/// Whether the commas of a line can be decimal ones, as in `0,5 1,5 2`: at most one in a number, none of
/// them at its end, and no dots.
pub(super) fn has_decimal_commas(line: &str) -> bool {
    !line.contains('.')
        && line.split_whitespace().nth(1).is_some()
        && line.split_whitespace().all(|token| {
            let mut parts = token.split(',');
            let whole = parts.next().is_some_and(|p| !p.is_empty());
            let fraction = parts.next().is_none_or(|p| !p.is_empty());
            whole && fraction && parts.next().is_none()
        })
}

#[derive(Debug)]
struct Reader {
    dialect: Dialect,
    /// Names of the columns, empty for those to be skipped; `None` if they are to be guessed.
    names: Option<Vec<String>>,
    /// Columns of x, y and z; `None` if the names have none.
    axes: Option<[usize; 3]>,
    /// Whether a line of names was there.
    is_titled: bool,
    /// Names that a comment seems to give.
    in_comment: Option<Vec<String>>,
    /// Number of the line of the first point; 0 before.
    first: usize,
    columns: Vec<Vec<f64>>,
    /// The numbers of the current line.
    row: Vec<f64>,
    /// Points that lines of a single number promise.
    promised: Option<usize>,
    found: usize,
    dropped: usize,
}

impl Reader {
    fn new(dialect: Dialect) -> Self {
        Self {
            dialect,
            names: None,
            axes: Some([0, 1, 2]),
            is_titled: false,
            in_comment: None,
            first: 0,
            columns: Vec::new(),
            row: Vec::new(),
            promised: None,
            found: 0,
            dropped: 0,
        }
    }

    fn set_names(&mut self, names: Vec<String>) {
        let axes = ["x", "y", "z"].map(|axis| names.iter().position(|n| n == axis));
        self.axes = match axes {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            _ => None,
        };
        self.names = Some(names);
    }

    fn line(&mut self, number: usize, line: &str) -> Result<(), String> {
        if line.is_empty() {
            return Ok(());
        }
        if let Some(comment) = comment(line) {
            if self.first == 0 {
                self.in_comment = names_of_line(comment).or(self.in_comment.take());
            }
            return Ok(());
        }
        if let Err(reason) = self.parse(line) {
            return self.line_of_names(line, reason);
        }
        let count_is_due = self.found == self.promised.unwrap_or(0);
        if count_is_due && let Ok(count) = line.parse::<usize>() {
            self.promised = Some(self.found.saturating_add(count));
            return Ok(());
        }
        if self.first == 0 {
            self.begin(number);
        }
        let expected = self.columns.len();
        if self.row.len() != expected {
            let found = self.row.len();
            let first = self.first;
            return Err(if first == number {
                format!("it has {found} columns, but {expected} are named")
            } else {
                format!("it has {found} columns, but line {first} has {expected}")
            });
        }
        self.push_row();
        Ok(())
    }

    /// A line that is not all numbers can only be one of names, above the points.
    fn line_of_names(&mut self, line: &str, reason: String) -> Result<(), String> {
        if self.first > 0 || self.is_titled {
            return Err(reason);
        }
        self.is_titled = true;
        if self.names.is_some() {
            // The user knows better.
            return Ok(());
        }
        if line.to_ascii_lowercase().starts_with("ncols") {
            return Err("this is an ESRI grid, which relievo does not read; \
                        convert it to columns x y z first"
                .to_owned());
        }
        match names_of_line(line) {
            Some(names) => {
                self.set_names(names);
                Ok(())
            }
            None => Err(format!(
                "{reason}, and the line does not name columns x, y and z either; --columns can name them"
            )),
        }
    }

    /// Sets the columns up, at the first point.
    fn begin(&mut self, number: usize) {
        if self.names.is_none()
            && let Some(names) = self.in_comment.take()
            && names.len() == self.row.len()
        {
            self.set_names(names);
        }
        self.first = number;
        let count = self.names.as_ref().map_or(self.row.len(), Vec::len);
        self.columns = vec![Vec::new(); count];
    }

    /// Splits a line into the numbers of `row`.
    fn parse(&mut self, line: &str) -> Result<(), String> {
        self.row.clear();
        let Some(separator) = self.dialect.separator else {
            return self.parse_blanks(line);
        };
        let separator = char::from(separator);
        let expected = self.names.as_ref().map_or(self.columns.len(), Vec::len);
        let mut fields = line.split(separator).peekable();
        while let Some(field) = fields.next() {
            if !field.trim().is_empty() {
                self.parse_blanks(field)?;
            } else if fields.peek().is_some() || self.row.len() < expected {
                // A separator at the end of the line does not make a column.
                self.row.push(f64::NAN);
            }
        }
        Ok(())
    }

    fn parse_blanks(&mut self, text: &str) -> Result<(), String> {
        for token in text.split_ascii_whitespace() {
            if comment(token).is_some() {
                break;
            }
            let index = self.row.len();
            if index >= MOST_COLUMNS {
                return Err(format!("it has more than {MOST_COLUMNS} columns"));
            }
            let is_skipped = |names: &Vec<String>| names.get(index).is_some_and(String::is_empty);
            let value = if self.names.as_ref().is_some_and(is_skipped) {
                f64::NAN
            } else if self.dialect.decimal_comma && token.contains(',') {
                number(&token.replace(',', "."))?
            } else {
                number(token.trim_matches('"'))?
            };
            self.row.push(value);
        }
        Ok(())
    }

    fn push_row(&mut self) {
        self.found += 1;
        let axes = self.axes.into_iter().flatten();
        // A missing column is for the check of the scan to tell.
        let mut coordinates = axes.filter_map(|axis| self.row.get(axis));
        if !coordinates.all(|v| v.is_finite()) {
            self.dropped += 1;
            return;
        }
        for (column, value) in self.columns.iter_mut().zip(&self.row) {
            column.push(*value);
        }
    }

    fn finish(self, name: &str) -> Result<Scan, ScanError> {
        if let Some(expected) = self.promised {
            if self.found < expected {
                return Err(ScanError::Truncated {
                    name: name.to_owned(),
                    element: "points".to_owned(),
                    found: self.found,
                    expected,
                });
            }
            if self.found > expected {
                log::warn!(
                    "{name}: {} points, but its count says {expected}; all are read",
                    self.found
                );
            }
        }
        if self.dropped > 0 {
            log::warn!(
                "{name}: {} of {} points dropped, whose coordinates are not finite numbers",
                self.dropped,
                self.found
            );
        }
        let names = self.names.unwrap_or_else(|| {
            let names = columns::guess(&self.columns);
            log::info!(
                "{name}: its columns are taken for {}; if they are not, name them",
                names.join(" ")
            );
            names
        });
        Ok(Scan {
            vertices: columns::table(&names, self.columns),
            ..Scan::default()
        })
    }
}

/// The text behind the mark of a comment.
fn comment(line: &str) -> Option<&str> {
    line.strip_prefix('#').or_else(|| line.strip_prefix("//"))
}

/// The channels that a line of names tells; `None` unless they hold x, y and z.
fn names_of_line(line: &str) -> Option<Vec<String>> {
    let separator = [';', ',', '\t'].into_iter().find(|s| line.contains(*s));
    let names = match separator {
        Some(separator) => {
            let mut names: Vec<&str> = line.split(separator).take(MOST_COLUMNS).collect();
            if names.last().is_some_and(|n| n.trim().is_empty()) {
                names.pop();
            }
            channel_names(names)
        }
        None => channel_names(line.split_whitespace().take(MOST_COLUMNS)),
    };
    ["x", "y", "z"]
        .iter()
        .all(|axis| names.iter().any(|n| n == axis))
        .then_some(names)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{damaged, source, truncated};
    use super::*;
    use crate::scan::{Column, ReadOptions};

    fn scan(text: &str) -> Result<Scan, String> {
        let options = ReadOptions::default();
        let scan = read(&source(text.as_bytes(), &options)).map_err(|e| e.to_string())?;
        scan.check("a").map_err(|e| e.to_string())?;
        Ok(scan)
    }

    fn names(scan: &Scan) -> String {
        let names: Vec<&str> = scan.vertices.channels.iter().map(|c| &*c.name).collect();
        names.join(" ")
    }

    #[test]
    fn dialects_give_the_same_points() {
        for text in [
            "1.5 -2 3e0\n4 5 6",
            "1.5,-2,3\n4,5,6,\n",
            "1.5, -2, 3\r\n\r\n4, 5, 6\r\n",
            "# a\n1,5;-2;3,0\n4;5;6\n",
            "1,5\t-2\t3,0\n4\t5\t6\n",
            "\u{feff}X;Y;Z\n1.5;-2;3\n4;5;6",
            "2\n1.5 -2 3 # a\n4 5 6 // b\n",
            "1\n1.5 -2 3\n1\n4 5 6\n",
            "1.5 -2 3\r4 5 6\r",
            "\"1.5\",\"-2\",\"3\"\n4,5,6",
            "1.5 -2 3\nnan nan nan\n4 5 6\n0 inf 0\n",
        ] {
            let scan = scan(text).unwrap();
            let points = scan.positions();
            assert_eq!(
                points,
                [[1.5, -2.0, 3.0].into(), [4.0, 5.0, 6.0].into()],
                "{text}"
            );
            assert_eq!(names(&scan), "x y z", "{text}");
        }
    }

    #[test]
    fn names_come_from_the_line_the_comment_or_the_user() {
        let row = "1 2 3 4 5 6 0.5\n";
        for head in [
            "//X Y Z R G B Scalar_field\n1\n",
            "# x,y,z,red,green,blue,Scalar field\n",
            "X Y Z R G B \"Scalar_field\"\n# seven columns\n",
        ] {
            let scan = scan(&format!("{head}{row}")).unwrap();
            assert_eq!(names(&scan), "x y z red green blue Scalar_field", "{head}");
            assert_eq!(scan.vertices.column("green"), Some(&Column::U8(vec![5])));
        }
        let columns = ["z", "-", "x", "y", "-", "-", "quality"].map(str::to_owned);
        let options = ReadOptions {
            columns: Some(columns.into()),
            ..ReadOptions::default()
        };
        let text = "a b c d e f g\n1 ? 2 3 ? ? 4\n";
        let scan = read(&source(text.as_bytes(), &options)).unwrap();
        assert_eq!(names(&scan), "z x y quality");
        assert_eq!(scan.positions(), [[2.0, 3.0, 1.0].into()]);
    }

    #[test]
    fn pts_has_intensity_before_colors() {
        let scan = scan("2\n0 0 1 -1200 255 0 9\n0 1 1 700 1 2 3\n").unwrap();
        assert_eq!(names(&scan), "x y z intensity red green blue");
        assert_eq!(scan.vertices.column("blue"), Some(&Column::U8(vec![9, 3])));
    }

    #[test]
    fn missing_values_of_other_columns_are_nan() {
        let scan = scan("x,y,z,a,b\n1,2,3,,\n1,2,3,4,5\n").unwrap();
        for name in ["a", "b"] {
            assert!(
                scan.vertices
                    .column(name)
                    .unwrap()
                    .get_f64(0)
                    .unwrap()
                    .is_nan()
            );
        }
    }

    #[test]
    fn bad_files_are_named() {
        for (text, part) in [
            ("", "no vertices"),
            ("# a\n", "no vertices"),
            ("nan nan nan\n", "no vertices"),
            ("1 2\n", "`z`"),
            ("1 2 3\n1 2\n", "line 2: it has 2 columns, but line 1 has 3"),
            ("1 2 3\n1 2 b\n", "line 2: `b` is not a number"),
            (
                "x y z i\n1 2 3\n",
                "line 2: it has 3 columns, but 4 are named",
            ),
            ("a b c\n1 2 3\n", "line 1: `a` is not a number, and"),
            ("x y z\nx y z\n1 2 3\n", "line 2: `x`"),
            ("99999999999\n1 2 3\n", "only 1 are there"),
            ("99999999999999999999\n1 2 3\n", "line 2"),
            ("ncols 4\nnrows 4\n", "ESRI"),
        ] {
            let error = scan(text).unwrap_err();
            assert!(error.contains(part), "{text:?}: {error}");
        }
    }

    #[test]
    fn whatever_the_bytes_there_is_a_scan_or_an_error() {
        let text = b"//X,Y;Z R G\n2\n0.5,1,2,255,0,1 # a\n-1e3,2;nan 5 6 7\n\"3\"\t4 5 6 7 8\n";
        let options = ReadOptions::default();
        let read = |bytes: &[u8]| read(&source(bytes, &options)).map(Into::into);
        truncated(text, read);
        damaged(text, read);
    }
}
