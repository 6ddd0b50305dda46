//! Height maps as text: rows of numbers, the first row on top.

use std::path::Path;

use super::format::{Format, bytes_of};
use super::text::{line_error, lines, number, shown};
use super::{ScanError, xyz};

/// Heights on a rectangular grid.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    /// Row by row, the first one on top (y downwards); NaN where missing.
    pub heights: Vec<f64>,
    /// Distance of the columns, in the unit of the heights, positive.
    pub dx: f64,
    /// Distance of the rows, in the unit of the heights, positive.
    pub dy: f64,
}

impl HeightMap {
    /// A map of heights by column and row, both from 0.
    #[must_use]
    pub fn from_fn(
        [columns, rows]: [usize; 2],
        [dx, dy]: [f64; 2],
        mut height: impl FnMut(usize, usize) -> f64,
    ) -> Self {
        let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        Self {
            columns,
            rows,
            heights: places.map(|(column, row)| height(column, row)).collect(),
            dx,
            dy,
        }
    }

    /// The height at a column and a row.
    ///
    /// # Panics
    /// Outside of the map.
    #[must_use]
    pub fn at(&self, column: usize, row: usize) -> f64 {
        self.heights[row * self.columns + column]
    }

    /// Number of heights that are missing.
    #[must_use]
    pub fn missing(&self) -> usize {
        self.heights.iter().filter(|height| height.is_nan()).count()
    }
}

/// Reads a height map from a text file, or from standard input (`-`); `step` is the distance of columns and
/// of rows.
///
/// One row a line, numbers separated by semicolons, tabs, commas or blanks; decimal commas where commas do not
/// separate. Comments (`#`, `//`) and blank lines may stand anywhere. Missing heights are empty, `-`, `***`,
/// `nan`, `NA`, `null`, `bad`, or not finite. A separator at the end of every line means nothing.
///
/// # Errors
/// A [`ScanError`] that names the file, and the line that is not a row of as many numbers as the first.
pub fn read_height_map(path: &Path, step: [f64; 2]) -> Result<HeightMap, ScanError> {
    let (name, bytes) = bytes_of(path)?;
    parse(name, &bytes, step)
}

fn parse(name: String, bytes: &[u8], [dx, dy]: [f64; 2]) -> Result<HeightMap, ScanError> {
    if let Some(format) = Format::of_content(bytes) {
        return Err(ScanError::MissingOption {
            name,
            reason: format!(
                "its first bytes tell that it is {format}, and height maps are text; leave out --step, or export the heights as CSV"
            ),
        });
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let dialect = Dialect::of(bytes);
    let mut heights = Vec::new();
    // Number of the first line of heights, and how many there are.
    let mut first = None;
    let mut rows = 0;
    for (line, text) in lines(bytes).filter(|(_, text)| is_row(text, dialect)) {
        let before = heights.len();
        read_row(&text, dialect, &mut heights).map_err(|token| {
            let words = first.is_none() && token.starts_with(char::is_alphabetic);
            let reason = if words {
                format!("`{token}` is no height; take the header away, or put # in front of it")
            } else {
                format!("`{token}` is not a number")
            };
            line_error(&name, line, reason)
        })?;
        let found = heights.len() - before;
        let (first_line, columns) = *first.get_or_insert((line, found));
        if found != columns {
            let reason = format!("it has {found} heights, but line {first_line} has {columns}");
            return Err(line_error(&name, line, reason));
        }
        rows += 1;
    }
    let Some((_, columns)) = first else {
        return Err(ScanError::Malformed {
            name,
            reason: "there are no heights in it".to_owned(),
        });
    };
    if columns == 3 {
        log::warn!("{name}: three columns are read as a map, not as x, y and z");
    }
    let map = HeightMap {
        columns,
        rows,
        heights,
        dx,
        dy,
    };
    log::info!(
        "{name}: {columns} columns, {rows} rows, {} missing",
        map.missing()
    );
    Ok(map)
}

/// How the numbers of a row are separated and written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Dialect {
    /// `None`: blanks.
    separator: Option<char>,
    decimal_comma: bool,
    /// Whether every line ends with a separator behind its last number.
    ends_with_separator: bool,
}

impl Dialect {
    fn of(bytes: &[u8]) -> Self {
        /// So many rows tell it.
        const SAMPLE: usize = 100;
        let blanks = Self {
            separator: None,
            decimal_comma: false,
            ends_with_separator: false,
        };
        let sample: Vec<String> = lines(bytes)
            .map(|(_, text)| text.into_owned())
            .filter(|text| is_row(text, blanks))
            .take(SAMPLE)
            .collect();
        let any = |wanted: char| sample.iter().any(|text| text.contains(wanted));
        let separator = if any(';') {
            Some(';')
        } else if any('\t') {
            Some('\t')
        } else if any(',') && !sample.iter().all(|text| xyz::has_decimal_commas(text)) {
            Some(',')
        } else {
            None
        };
        let ends = |separator| {
            let last = |text: &str| text.trim_end_matches(['\r', ' ']).ends_with(separator);
            sample.iter().all(|text| last(text))
        };
        Self {
            separator,
            decimal_comma: separator != Some(',') && any(','),
            ends_with_separator: separator.is_some_and(ends),
        }
    }
}

/// Whether a line is one of heights: neither blank nor a comment.
fn is_row(text: &str, dialect: Dialect) -> bool {
    let start = text.trim_start();
    let is_blank = match dialect.separator {
        // Tabs alone are a row of missing heights.
        Some('\t') => start.is_empty() && !text.contains('\t'),
        _ => start.is_empty(),
    };
    !is_blank && !start.starts_with('#') && !start.starts_with("//")
}

/// Appends the heights of a line, or gives the token that is none.
fn read_row(text: &str, dialect: Dialect, heights: &mut Vec<f64>) -> Result<(), String> {
    let Some(separator) = dialect.separator else {
        for token in text.split_whitespace() {
            heights.push(height(token, dialect.decimal_comma)?);
        }
        return Ok(());
    };
    let mut text = text.trim_end_matches(['\r', ' ']);
    if dialect.ends_with_separator {
        text = text.strip_suffix(separator).unwrap_or(text);
    }
    for token in text.split(separator) {
        heights.push(height(token.trim(), dialect.decimal_comma)?);
    }
    Ok(())
}

/// The height that a token stands for; NaN if it stands for a missing one.
fn height(token: &str, decimal_comma: bool) -> Result<f64, String> {
    const MISSING: [&str; 7] = ["na", "n/a", "null", "none", "bad", "inf", "-inf"];
    let is_dash = token.bytes().all(|b| b == b'-') || token.bytes().all(|b| b == b'*');
    if is_dash || MISSING.iter().any(|word| token.eq_ignore_ascii_case(word)) {
        return Ok(f64::NAN);
    }
    let value = if decimal_comma {
        number(&token.replacen(',', ".", 1))
    } else {
        number(token)
    };
    match value {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Ok(f64::NAN),
        Err(_) => Err(shown(token)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns and heights of a text; missing ones are −999.
    fn read(text: &str) -> Result<(usize, Vec<f64>), String> {
        let map = parse("map.csv".to_owned(), text.as_bytes(), [1.0, 2.0]);
        let map = map.map_err(|error| error.to_string())?;
        let known = |height: f64| if height.is_nan() { -999.0 } else { height };
        Ok((map.columns, map.heights.into_iter().map(known).collect()))
    }

    #[test]
    fn every_separator_gives_the_same_map() {
        let expected = Ok((3, vec![1.5, -2.0, 3e-2, 4.0, -999.0, 6.0]));
        for text in [
            "1.5,-2,3e-2\n4,,6\n",
            "\u{feff}# map\r\n1.5, -2, 3e-2\r\n\r\n4, nan, 6\r\n",
            "1,5;-2;0,03\n4;***;6\n",
            "1.5;-2;3e-2;\n4;-;6;\n",
            "1.5\t-2\t3e-2\n4\t\t6",
            "1,5\t-2\t3e-2\n4\tNA\t6",
            "  1.5 -2   3e-2 \n4 --- 6",
            "1,5 -2,0 0,03\n// more\n4,0 inf 6,0",
            "1.5,-2,3e-2\r4,bad,6\r",
        ] {
            assert_eq!(read(text), expected, "{text:?}");
        }
    }

    #[test]
    fn rows_of_missing_heights_are_rows() {
        assert_eq!(
            read("1,2\n,\n3,4").unwrap().1,
            [1.0, 2.0, -999.0, -999.0, 3.0, 4.0]
        );
        assert_eq!(read("1\t2\n\t\n3\t4\n").unwrap().1.len(), 6);
        assert_eq!(
            read("1,2\n3,\n5,6").unwrap().1,
            [1.0, 2.0, 3.0, -999.0, 5.0, 6.0]
        );
    }

    #[test]
    fn what_is_no_map_is_refused_with_the_line() {
        let refused = |text: &str, words: &[&str]| {
            let message = read(text).unwrap_err();
            for word in words {
                assert!(message.contains(word), "{text:?}: {message}");
            }
        };
        refused("x,y,z\n1,2,3\n", &["line 1", "`x`", "header"]);
        refused(
            "1,2,3\n# ok\n4,5\n",
            &["line 3", "2 heights", "line 1 has 3"],
        );
        refused("1,2,3\n4,5x,6\n", &["line 2", "`5x` is not a number"]);
        refused("", &["no heights"]);
        refused("# only\n\n", &["no heights"]);
        refused("ply\nformat ascii 1.0\n", &["PLY", "leave out --step"]);
    }
}
