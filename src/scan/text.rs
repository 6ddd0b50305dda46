//! What the line-based formats (OBJ, OFF, ASCII STL) share.

use std::borrow::Cow;

use super::channel::Scalar;
use super::{Column, ScanError, Table};

/// The lines with their numbers from 1, whichever way they end. Text of another encoding than UTF-8
/// can only be in names and comments, so that a substitute for it is good enough.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let carriage_returns_only = !bytes.contains(&b'\n');
    bytes
        .split(move |b| *b == b'\n' || (carriage_returns_only && *b == b'\r'))
        .map(String::from_utf8_lossy)
        .zip(1..)
        .map(|(line, number)| (number, line))
}

/// A number of a text file, in full precision.
pub(super) fn number(token: &str) -> Result<f64, String> {
    f64::parse(token).ok_or_else(|| format!("`{}` is not a number", shown(token)))
}

/// A token, shortened if it is long.
pub(super) fn shown(token: &str) -> String {
    token.chars().take(40).collect()
}

pub(super) fn line_error(name: &str, line: usize, reason: impl Into<String>) -> ScanError {
    ScanError::Line {
        name: name.to_owned(),
        line,
        reason: reason.into(),
    }
}

/// A table with one `double` channel a name.
pub(super) fn table_of_doubles<const N: usize>(names: [&str; N], rows: &[[f64; N]]) -> Table {
    let mut table = Table::default();
    for (k, name) in names.into_iter().enumerate() {
        table.set_channel(name, Column::F64(rows.iter().map(|row| row[k]).collect()));
    }
    table
}
