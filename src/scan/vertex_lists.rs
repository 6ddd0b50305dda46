//! Lists of vertices, as PLY's faces, strips and grids have them, and numbers that are indices.

use super::channel::Scalar;
use super::{Column, Table};

/// Names of the list of vertices, the usual one first.
pub(super) const INDEX_NAMES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// The lists of vertices of all rows.
pub(super) fn index_lists(table: &Table) -> Option<&[Column]> {
    INDEX_NAMES.iter().find_map(|n| match table.column(n) {
        Some(Column::List(lists)) => Some(lists.as_slice()),
        _ => None,
    })
}

/// The index below `count` that the value is; of all integer types they are exact in `f64`, and a fraction is
/// none.
pub(super) fn exact_index(value: f64, count: usize) -> Option<u32> {
    let index = u32::rounded(value);
    let exact = f64::from(index).to_bits() == value.to_bits();
    (exact && (index as usize) < count).then_some(index)
}
