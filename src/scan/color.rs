//! Colours of any type as intensities from 0 to 1.

use super::channel::Scalar;
use super::{Column, Table};

/// Names that programs give to the colour channels, in the order in which they are looked for.
const NAMES: [[&str; 3]; 4] = [
    ["red", "green", "blue"],
    ["r", "g", "b"],
    ["diffuse_red", "diffuse_green", "diffuse_blue"],
    ["diffuse_r", "diffuse_g", "diffuse_b"],
];

/// Where a table's colours are, and the value that stands for full intensity.
///
/// The scale follows from the values themselves, so that nothing needs to be remembered: colours
/// that are appended at this scale leave it as it is.
pub(super) struct ColorLayout {
    pub(super) channels: [usize; 3],
    pub(super) full: f64,
}

impl ColorLayout {
    pub(super) fn of(table: &Table) -> Option<Self> {
        let channels = NAMES.iter().find_map(|names| table.triple(*names))?;
        let columns = channels.map(|c| &table.channels[c].values);
        let full = if columns.iter().all(|c| matches!(c, Column::U16(_))) {
            f64::from(u16::MAX)
        } else if columns
            .iter()
            .all(|c| matches!(c, Column::F32(_) | Column::F64(_)))
            && !columns.iter().any(|c| exceeds_one(c))
        {
            1.0
        } else {
            f64::from(u8::MAX)
        };
        Some(Self { channels, full })
    }
}

fn exceeds_one(column: &Column) -> bool {
    match column {
        Column::F32(values) => values.iter().any(|v| *v > 1.0),
        Column::F64(values) => values.iter().any(|v| *v > 1.0),
        _ => false,
    }
}

/// The value of `alpha` that stands for opaque.
pub(super) fn full_alpha(column: &Column) -> f64 {
    match column {
        Column::U16(_) => 65535.0,
        Column::F32(_) | Column::F64(_) => 1.0,
        _ => 255.0,
    }
}

/// #V intensities, 0 to 1; what lies outside is clamped, and NaN counts as 0.
pub(super) fn colors(table: &Table) -> Option<Vec<[f64; 3]>> {
    let layout = ColorLayout::of(table)?;
    let intensity = |row: usize, channel: usize| {
        let value = table.channels[channel].values.get_f64(row).unwrap_or(0.0);
        // `max` turns NaN into 0.
        (value / layout.full).max(0.0).clamp(0.0, 1.0)
    };
    Some(
        (0..table.rows)
            .map(|row| layout.channels.map(|channel| intensity(row, channel)))
            .collect(),
    )
}

impl Table {
    /// Puts intensities (one triple a row, 0 to 1; clamped) into `red`, `green` and `blue`, as `uchar`.
    ///
    /// # Panics
    /// If there is not one triple a row.
    pub fn set_colors(&mut self, colors: &[[f64; 3]]) {
        let byte = |value: f64| <u8 as Scalar>::rounded(255.0 * value.clamp(0.0, 1.0));
        for (k, name) in NAMES[0].into_iter().enumerate() {
            self.set_channel(
                name,
                Column::U8(colors.iter().map(|c| byte(c[k])).collect()),
            );
        }
    }

    /// The same into the colors that are there, by their names, in their type: whole numbers up to its largest value or
    /// 255, `float` up to 1. Into `red`, `green` and `blue` as `uchar` if there are none, or `float` up to 255, which
    /// dark colors would be taken for up to 1.
    ///
    /// # Panics
    /// If there is not one triple a row.
    pub fn replace_colors(&mut self, colors: &[[f64; 3]]) {
        let byte = f64::from(u8::MAX);
        let Some(layout) = ColorLayout::of(self) else {
            return self.set_colors(colors);
        };
        let is_float =
            |c: &usize| matches!(self.channels[*c].values, Column::F32(_) | Column::F64(_));
        let is_wide = layout.full >= byte && layout.channels.iter().any(is_float);
        for (k, channel) in layout.channels.into_iter().enumerate() {
            let channel = &mut self.channels[channel];
            let mut column = match is_wide {
                true => Column::U8(Vec::new()),
                false => channel.values.emptied(),
            };
            let full = if is_wide { byte } else { layout.full };
            for color in colors {
                column.push_rounded(full * color[k].clamp(0.0, 1.0));
            }
            assert_eq!(column.len(), self.rows, "one triple a row");
            channel.values = column;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(names: [&str; 3], column: &Column) -> Table {
        let mut table = Table::default();
        for name in names {
            table.set_channel(name, column.clone());
        }
        table
    }

    #[test]
    fn every_type_ends_between_0_and_1() {
        for (column, expected) in [
            (Column::U8(vec![0, 51, 255]), [0.0, 0.2, 1.0]),
            (Column::U16(vec![0, 13107, 65535]), [0.0, 0.2, 1.0]),
            (Column::F32(vec![0.0, 0.25, 1.0]), [0.0, 0.25, 1.0]),
            (Column::F64(vec![0.0, 51.0, 255.0]), [0.0, 0.2, 1.0]),
            (Column::F64(vec![f64::NAN, -1.0, 1.0]), [0.0, 0.0, 1.0]),
            (Column::I32(vec![0, 51, 300]), [0.0, 0.2, 1.0]),
        ] {
            let colors = colors(&table(["red", "green", "blue"], &column)).unwrap();
            assert_eq!(colors, expected.map(|e| [e; 3]), "{column:?}");
        }
    }

    #[test]
    fn colors_are_replaced_in_their_own_type() {
        let wanted = [[0.0, 0.2, 1.0], [1.5, 0.001, -1.0]];
        for (column, expected) in [
            (Column::U8(vec![1, 2]), Column::U8(vec![51, 0])),
            (Column::U16(vec![1, 2]), Column::U16(vec![13107, 66])),
            (Column::F32(vec![0.0, 1.0]), Column::F32(vec![0.2, 0.001])),
            (Column::F64(vec![9.0, 1.0]), Column::U8(vec![51, 0])),
            (Column::I32(vec![9, 1]), Column::I32(vec![51, 0])),
        ] {
            for names in NAMES {
                let mut table = table(names, &column);
                table.replace_colors(&wanted);
                assert_eq!(table.channels.len(), 3);
                assert_eq!(table.column(names[1]), Some(&expected), "{column:?}");
            }
        }
        let mut table = table(["x", "y", "z"], &Column::F32(vec![0.0; 2]));
        table.replace_colors(&wanted);
        assert_eq!(table.column("green"), Some(&Column::U8(vec![51, 0])));
    }

    #[test]
    fn other_names_are_found_and_lists_are_not_colors() {
        let column = Column::U8(vec![255]);
        for names in NAMES {
            assert!(colors(&table(names, &column)).is_some(), "{names:?}");
        }
        assert!(colors(&table(["red", "green", "beige"], &column)).is_none());
        let lists = Column::List(vec![column]);
        assert!(colors(&table(["red", "green", "blue"], &lists)).is_none());
    }
}
