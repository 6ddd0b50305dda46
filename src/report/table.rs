//! Tables.

use std::io::{self, Write};

use super::markup::escaped;

/// A table; cells are text as it is shown.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Table {
    /// What it holds, in a few words.
    pub caption: String,
    /// Its columns; the first names the rows.
    pub columns: Vec<Column>,
    /// As many cells a row as there are columns; cells that lack are empty.
    pub rows: Vec<Vec<String>>,
}

/// Head of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// What is in it, with the unit.
    pub heading: String,
    /// Whether it holds numbers, which stand at the right.
    pub numbers: bool,
}

impl Column {
    /// A column of words.
    #[must_use]
    pub fn words(heading: &str) -> Self {
        Self {
            heading: heading.to_owned(),
            numbers: false,
        }
    }

    /// A column of numbers.
    #[must_use]
    pub fn numbers(heading: &str) -> Self {
        Self {
            heading: heading.to_owned(),
            numbers: true,
        }
    }
}

impl Table {
    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        // Wide tables scroll in a box of their own; with the keyboard it must have the focus.
        let caption = escaped(&self.caption);
        write!(
            out,
            "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\"><table>\n<caption>{caption}</caption>\n<thead><tr>"
        )?;
        for column in &self.columns {
            let class = class(column);
            write!(
                out,
                "<th scope=\"col\"{class}>{}</th>",
                escaped(&column.heading)
            )?;
        }
        out.write_all(b"</tr></thead>\n<tbody>\n")?;
        for row in &self.rows {
            out.write_all(b"<tr>")?;
            for (index, column) in self.columns.iter().enumerate() {
                let text = escaped(row.get(index).map_or("", String::as_str));
                let class = class(column);
                if index == 0 {
                    write!(out, "<th scope=\"row\"{class}>{text}</th>")?;
                } else {
                    write!(out, "<td{class}>{text}</td>")?;
                }
            }
            out.write_all(b"</tr>\n")?;
        }
        out.write_all(b"</tbody></table></div>\n")
    }
}

fn class(column: &Column) -> &'static str {
    if column.numbers {
        " class=\"number\""
    } else {
        ""
    }
}
