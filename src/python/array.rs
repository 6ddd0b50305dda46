//! Numbers of ours as numpy arrays, without a copy.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::scan::{Column, Scan};

/// Numbers that numpy may look at (`numpy.asarray`), by its array interface, version 3.
///
/// numpy keeps this object as the base of its arrays, so that the numbers live at least as long as these. Nothing
/// changes them meanwhile: they are behind a shared reference for good, and numpy is told that they are read-only,
/// which it does not let anybody undo for memory that is not its own.
#[pyclass(frozen, module = "relievo._relievo")]
pub(super) struct Array(Numbers);

/// Where the numbers are.
pub(super) enum Numbers {
    /// A channel of the vertices, by its index.
    Channel(Arc<Scan>, usize),
    /// Rows of three `double`s.
    Points(Vec<[f64; 3]>),
    /// Rows of three indices.
    Triangles(Vec<[u32; 3]>),
    /// Rows of red, green and blue.
    Colors(Vec<[u8; 3]>),
    /// Height × width pixels of red, green and blue.
    Pixels([usize; 2], Vec<[u8; 3]>),
    /// The same with opacity.
    Translucent([usize; 2], Vec<[u8; 4]>),
}

impl From<Numbers> for Array {
    fn from(numbers: Numbers) -> Self {
        Self(numbers)
    }
}

/// What numpy wants to know of memory.
struct Layout {
    /// Kind and bytes of a number.
    kind: &'static str,
    address: usize,
    shape: Vec<usize>,
}

fn layout<T>(kind: &'static str, numbers: &[T], shape: &[usize]) -> Layout {
    Layout {
        kind,
        address: numbers.as_ptr().expose_provenance(),
        shape: shape.to_vec(),
    }
}

impl Numbers {
    /// `None` for lists, which are no arrays.
    fn layout(&self) -> Option<Layout> {
        Some(match self {
            Self::Channel(scan, index) => {
                return of_column(&scan.vertices.channels.get(*index)?.values);
            }
            Self::Points(rows) => layout("f8", rows, &[rows.len(), 3]),
            Self::Triangles(rows) => layout("u4", rows, &[rows.len(), 3]),
            Self::Colors(rows) => layout("u1", rows, &[rows.len(), 3]),
            Self::Pixels([height, width], rows) => layout("u1", rows, &[*height, *width, 3]),
            Self::Translucent([height, width], rows) => layout("u1", rows, &[*height, *width, 4]),
        })
    }
}

fn of_column(column: &Column) -> Option<Layout> {
    let shape = [column.len()];
    Some(match column {
        Column::I8(values) => layout("i1", values, &shape),
        Column::U8(values) => layout("u1", values, &shape),
        Column::I16(values) => layout("i2", values, &shape),
        Column::U16(values) => layout("u2", values, &shape),
        Column::I32(values) => layout("i4", values, &shape),
        Column::U32(values) => layout("u4", values, &shape),
        Column::F32(values) => layout("f4", values, &shape),
        Column::F64(values) => layout("f8", values, &shape),
        Column::List(_) => return None,
    })
}

#[pymethods]
impl Array {
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Some(layout) = self.0.layout() else {
            return Err(pyo3::exceptions::PyTypeError::new_err(
                "lists are no arrays",
            ));
        };
        let order = if cfg!(target_endian = "big") {
            '>'
        } else {
            '<'
        };
        let dict = PyDict::new(py);
        dict.set_item("version", 3)?;
        dict.set_item("typestr", format!("{order}{}", layout.kind))?;
        dict.set_item("shape", pyo3::types::PyTuple::new(py, layout.shape)?)?;
        // The second one: read-only.
        dict.set_item("data", (layout.address, true))?;
        Ok(dict)
    }
}
