//! Tables of named columns that keep the file's own types.

use std::io::Write;

/// The values of one property, in the file's own type.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// `char`
    I8(Vec<i8>),
    /// `uchar`
    U8(Vec<u8>),
    /// `short`
    I16(Vec<i16>),
    /// `ushort`
    U16(Vec<u16>),
    /// `int`
    I32(Vec<i32>),
    /// `uint`
    U32(Vec<u32>),
    /// `float`
    F32(Vec<f32>),
    /// `double`
    F64(Vec<f64>),
    /// `list`: one list a row, each a column of its own of one common type.
    List(Vec<Column>),
}

/// A named column.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name of the property, as in the file.
    pub name: String,
    /// One value a row.
    pub values: Column,
}

/// Columns of equal length, in the file's order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// The columns.
    pub channels: Vec<Channel>,
    /// Number of rows.
    pub rows: usize,
}

/// Runs one expression for a column of any scalar type and another for a column of lists.
macro_rules! match_column {
    ($column:expr, $values:ident => $scalar:expr, $lists:ident => $list:expr) => {
        match $column {
            $crate::scan::Column::I8($values) => $scalar,
            $crate::scan::Column::U8($values) => $scalar,
            $crate::scan::Column::I16($values) => $scalar,
            $crate::scan::Column::U16($values) => $scalar,
            $crate::scan::Column::I32($values) => $scalar,
            $crate::scan::Column::U32($values) => $scalar,
            $crate::scan::Column::F32($values) => $scalar,
            $crate::scan::Column::F64($values) => $scalar,
            $crate::scan::Column::List($lists) => $list,
        }
    };
}

/// A number of one of the file's types.
pub(super) trait Scalar: Copy + Default + Into<f64> {
    /// The same value: every type fits into `f64`.
    fn exact(self) -> f64 {
        self.into()
    }
    /// The nearest value of the type; integers clamp to their range, and NaN becomes 0 there.
    fn rounded(value: f64) -> Self;
    /// Appends the little-endian bytes.
    fn push_le(self, out: &mut Vec<u8>);
    /// Appends the shortest text that reads back to the same value.
    fn push_ascii(self, out: &mut Vec<u8>);
    /// Takes the value's bytes off the front; `None` if there are too few.
    fn take(bytes: &mut &[u8], big_endian: bool) -> Option<Self>;
    /// Reads a token of an ASCII file; `None` if the type has no such value.
    fn parse(token: &str) -> Option<Self>;
}

macro_rules! take_number {
    ($type:ty, $bytes:ident, $big_endian:ident) => {{
        let (first, rest) = $bytes.split_first_chunk()?;
        *$bytes = rest;
        Some(if $big_endian {
            <$type>::from_be_bytes(*first)
        } else {
            <$type>::from_le_bytes(*first)
        })
    }};
}

macro_rules! integer {
    ($($type:ty)*) => {$(
        impl Scalar for $type {
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a float cast saturates, which is the clamping that is promised"
            )]
            fn rounded(value: f64) -> Self {
                value.round() as $type
            }
            fn push_le(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn take(bytes: &mut &[u8], big_endian: bool) -> Option<Self> {
                take_number!($type, bytes, big_endian)
            }
            fn push_ascii(self, out: &mut Vec<u8>) {
                // Writing to a `Vec` cannot fail.
                let _ = write!(out, "{self}");
            }
            fn parse(token: &str) -> Option<Self> {
                // Some programs write `255.0` into an integer property.
                token.parse().ok().or_else(|| {
                    let value: f64 = token.parse().ok()?;
                    let rounded = Self::rounded(value);
                    (f64::from(rounded).to_bits() == value.to_bits()).then_some(rounded)
                })
            }
        }
    )*};
}
integer!(i8 u8 i16 u16 i32 u32);

macro_rules! float {
    ($($type:ty)*) => {$(
        impl Scalar for $type {
            #[allow(
                clippy::cast_possible_truncation,
                trivial_numeric_casts,
                reason = "rounding to the nearest value is what is asked for"
            )]
            fn rounded(value: f64) -> Self {
                value as $type
            }
            fn push_le(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn take(bytes: &mut &[u8], big_endian: bool) -> Option<Self> {
                take_number!($type, bytes, big_endian)
            }
            fn push_ascii(self, out: &mut Vec<u8>) {
                let size = self.abs();
                // The borders only choose the shorter of two notations of the same value.
                let _ = if size != 0.0 && !(1e-4..1e15).contains(&size) && self.is_finite() {
                    write!(out, "{self:e}")
                } else {
                    write!(out, "{self}")
                };
            }
            fn parse(token: &str) -> Option<Self> {
                token.parse().ok().or_else(|| {
                    // `1.#QNAN`, `-nan(ind)`: as the Microsoft C library prints it.
                    let token = token.to_ascii_lowercase();
                    (token.contains("nan") || token.contains("#ind")).then_some(Self::NAN)
                })
            }
        }
    )*};
}
float!(f32 f64);

impl Column {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        match_column!(self, values => values.len(), lists => lists.len())
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value of a row, exact; `None` for a list and past the end.
    #[must_use]
    pub fn get_f64(&self, row: usize) -> Option<f64> {
        match_column!(self, values => values.get(row).copied().map(Scalar::exact), _lists => None)
    }

    /// The first row whose value is NaN or infinite; lists are not looked into.
    pub(super) fn first_not_finite(&self) -> Option<usize> {
        match self {
            Self::F32(values) => values.iter().position(|v| !v.is_finite()),
            Self::F64(values) => values.iter().position(|v| !v.is_finite()),
            _ => None,
        }
    }

    /// A column of the same type without rows.
    pub(super) fn emptied(&self) -> Self {
        match self {
            Self::I8(_) => Self::I8(Vec::new()),
            Self::U8(_) => Self::U8(Vec::new()),
            Self::I16(_) => Self::I16(Vec::new()),
            Self::U16(_) => Self::U16(Vec::new()),
            Self::I32(_) => Self::I32(Vec::new()),
            Self::U32(_) => Self::U32(Vec::new()),
            Self::F32(_) => Self::F32(Vec::new()),
            Self::F64(_) => Self::F64(Vec::new()),
            Self::List(_) => Self::List(Vec::new()),
        }
    }

    /// Appends a copy of row `source`.
    pub(super) fn push_copy(&mut self, source: usize) {
        match_column!(
            self,
            values => values.push(values[source]),
            lists => lists.push(lists[source].clone())
        );
    }

    /// Appends the nearest value of the column's type; an empty list to lists.
    pub(super) fn push_rounded(&mut self, value: f64) {
        match_column!(
            self,
            values => values.push(Scalar::rounded(value)),
            lists => {
                let empty = lists.first().map_or(Self::I32(Vec::new()), Self::emptied);
                lists.push(empty);
            }
        );
    }

    pub(super) fn reserve(&mut self, rows: usize) {
        match_column!(self, values => values.reserve(rows), lists => lists.reserve(rows));
    }

    pub(super) fn shrink_to_fit(&mut self) {
        match_column!(self, values => values.shrink_to_fit(), lists => lists.shrink_to_fit());
    }
}

impl Table {
    /// The values of the (first) channel of that name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.channel(name).map(|c| &c.values)
    }

    /// The (first) channel of that name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|c| c.name == name)
    }

    /// Replaces the channel of that name, or appends it. The first channel of a table that has
    /// neither channels nor rows sets the number of rows.
    ///
    /// # Panics
    /// If the column has not one value a row.
    pub fn set_channel(&mut self, name: &str, values: Column) {
        if self.channels.is_empty() && self.rows == 0 {
            self.rows = values.len();
        }
        assert_eq!(values.len(), self.rows, "one value a row");
        if let Some(channel) = self.channels.iter_mut().find(|c| c.name == name) {
            channel.values = values;
        } else {
            self.channels.push(Channel {
                name: name.to_owned(),
                values,
            });
        }
    }

    /// Index of the (first) channel of that name that is not a list.
    pub(super) fn scalar_index(&self, name: &str) -> Option<usize> {
        self.channels
            .iter()
            .position(|c| c.name == name && !matches!(c.values, Column::List(_)))
    }

    /// Indices of three scalar channels.
    pub(super) fn triple(&self, names: [&str; 3]) -> Option<[usize; 3]> {
        let [a, b, c] = names.map(|name| self.scalar_index(name));
        Some([a?, b?, c?])
    }
}

pub(super) use match_column;

#[cfg(test)]
mod tests {
    use super::*;

    fn ascii(value: impl Scalar) -> String {
        let mut out = Vec::new();
        value.push_ascii(&mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn text_is_short_and_reads_back() {
        assert_eq!(ascii(0.1f32), "0.1");
        assert_eq!(ascii(1.0f64), "1");
        assert_eq!(ascii(1e-30f32), "1e-30");
        assert_eq!(ascii(-0.0f64), "-0");
        assert_eq!(ascii(f32::NAN), "NaN");
        assert_eq!(ascii(f64::NEG_INFINITY), "-inf");
        for value in [f64::MIN_POSITIVE, f64::MAX, 1.0 / 3.0, 123_456_789.125] {
            assert_eq!(f64::parse(&ascii(value)), Some(value));
        }
    }

    #[test]
    fn tokens_of_the_wrong_type_are_refused() {
        assert_eq!(u8::parse("255.0"), Some(255));
        assert_eq!(u8::parse("256"), None);
        assert_eq!(u8::parse("0.5"), None);
        assert_eq!(i8::parse("-128"), Some(-128));
        assert_eq!(f64::parse(".5"), Some(0.5));
        assert_eq!(f64::parse("x"), None);
        assert!(f32::parse("-nan(ind)").unwrap().is_nan());
    }

    #[test]
    fn rounding_clamps_to_the_type() {
        assert_eq!(u8::rounded(254.5), 255);
        assert_eq!(u8::rounded(1e9), 255);
        assert_eq!(i16::rounded(-1e9), i16::MIN);
        assert_eq!(u32::rounded(f64::NAN), 0);
    }

    #[test]
    fn set_channel_replaces_or_appends() {
        let mut table = Table::default();
        table.set_channel("a", Column::U8(vec![1, 2]));
        table.set_channel("b", Column::F32(vec![0.5, 1.5]));
        table.set_channel("a", Column::I32(vec![-1, -2]));
        assert_eq!(table.rows, 2);
        assert_eq!(table.channels.len(), 2);
        assert_eq!(table.column("a").unwrap().get_f64(1), Some(-2.0));
        assert_eq!(table.column("c"), None);
    }
}
