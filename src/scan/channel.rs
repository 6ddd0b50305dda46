//! Tables of named columns that keep the file's own types.

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
