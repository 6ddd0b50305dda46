//! Scans and images that Python holds.

use std::sync::Arc;

use pyo3::buffer::{Element, PyBuffer, PyUntypedBuffer};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::array::{Array, Numbers};
use super::error;
use crate::mesh::Csr;
use crate::scan::{Channel, Column, Format, Image, ReadOptions, Scan, Table, WriteOptions};
use crate::scan::{Sensor, read_from, write_to};

/// A scan that nobody changes any more.
#[pyclass(frozen, name = "HeldScan", module = "relievo._relievo")]
pub(super) struct HeldScan(pub(super) Arc<Scan>);

/// What pickles hold: PLY bytes, and of each sensor the first vertex, the one after its last, and its position.
type Pickled<'py> = (Bound<'py, PyBytes>, Vec<(usize, usize, [f64; 3])>);

#[pymethods]
impl HeldScan {
    /// A scan of named columns of the vertices (copied) and faces of equally many corners (#F by k, `uint32`).
    #[staticmethod]
    fn of_columns(
        py: Python<'_>,
        columns: Vec<(String, Bound<'_, PyAny>)>,
        faces: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mut vertices = Table::default();
        for (name, values) in columns {
            let values = column(py, &values)?;
            if vertices.channels.is_empty() {
                vertices.rows = values.len();
            } else if values.len() != vertices.rows {
                return Err(PyValueError::new_err("columns of unequal length"));
            }
            vertices.channels.push(Channel { name, values });
        }
        let faces = faces.map_or_else(|| Ok(Csr::default()), |faces| corners(py, &faces))?;
        let scan = Scan {
            vertices,
            faces,
            ..Scan::default()
        };
        py.detach(|| scan.check("the scan"))
            .map_err(|error| error::usage(py, &error.to_string()))?;
        Ok(Self(Arc::new(scan)))
    }

    /// The names of the vertices' channels that are no lists, in the file's order, with their indices.
    fn channels(&self) -> Vec<(String, usize)> {
        let channels = self.0.vertices.channels.iter().enumerate();
        channels
            .filter(|(_, channel)| !matches!(channel.values, Column::List(_)))
            .map(|(index, channel)| (channel.name.clone(), index))
            .collect()
    }

    /// A channel of the vertices: a view.
    fn channel(&self, index: usize) -> Array {
        Numbers::Channel(Arc::clone(&self.0), index).into()
    }

    /// #V by 3 coordinates: a copy.
    fn positions(&self, py: Python<'_>) -> Array {
        let positions = py.detach(|| self.0.positions().into_iter().map(Into::into).collect());
        Numbers::Points(positions).into()
    }

    /// #T by 3 corners of the faces, split into triangles: a copy.
    fn triangles(&self, py: Python<'_>) -> Array {
        Numbers::Triangles(py.detach(|| self.0.triangles())).into()
    }

    /// #V by 3 intensities of red, green and blue, from 0 to 255: a copy; `None` without colors.
    fn colors(&self, py: Python<'_>) -> Option<Array> {
        let colors =
            py.detach(|| Some(self.0.colors()?.into_iter().map(|c| c.map(byte)).collect()));
        colors.map(|colors| Numbers::Colors(colors).into())
    }

    #[getter]
    fn vertex_count(&self) -> usize {
        self.0.vertices.rows
    }

    #[getter]
    fn face_count(&self) -> usize {
        self.0.faces.len()
    }

    /// All of the scan, exact.
    fn pickled<'py>(&self, py: Python<'py>) -> PyResult<Pickled<'py>> {
        let bytes = py.detach(|| {
            let mut bytes = Vec::new();
            let options = WriteOptions::default();
            write_to(&self.0, &mut bytes, Format::Ply, &options, "a pickle").map(|()| bytes)
        });
        let bytes = bytes.map_err(|error| error::of_file(py, &error))?;
        let sensors = self.0.sensors.iter().map(|sensor| {
            let rows = &sensor.vertices;
            (rows.start, rows.end, sensor.position.into())
        });
        Ok((PyBytes::new(py, &bytes), sensors.collect()))
    }

    /// The scan of such a pickle.
    #[staticmethod]
    fn of_pickle(
        py: Python<'_>,
        ply: &[u8],
        sensors: Vec<(usize, usize, [f64; 3])>,
    ) -> PyResult<Self> {
        let read = py.detach(|| read_from(ply, Format::Ply, "a pickle", &ReadOptions::default()));
        let mut scan = read.map_err(|error| error::of_file(py, &error))?;
        let sensors = sensors.into_iter().map(|(start, end, position)| Sensor {
            vertices: start..end,
            position: position.into(),
        });
        scan.sensors = sensors.collect();
        Ok(Self(Arc::new(scan)))
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "intensities are from 0 to 1"
)]
fn byte(intensity: f64) -> u8 {
    (255.0 * intensity).round() as u8
}

/// A copy of an array of one dimension, in its own type.
fn column(py: Python<'_>, values: &Bound<'_, PyAny>) -> PyResult<Column> {
    let buffer = PyUntypedBuffer::get(values)?;
    macro_rules! first_of {
        ($($kind:ident)*) => {$(
            if let Ok(typed) = buffer.as_typed() {
                return Ok(Column::$kind(typed.to_vec(py)?));
            }
        )*};
    }
    first_of!(I8 U8 I16 U16 I32 U32 F32 F64);
    Err(PyTypeError::new_err("a column of another type"))
}

/// The elements of an array and its shape.
fn elements<T: Element, const D: usize>(
    py: Python<'_>,
    array: &Bound<'_, PyAny>,
) -> PyResult<(Vec<T>, [usize; D])> {
    let buffer = PyBuffer::<T>::get(array)?;
    let shape = buffer.shape().try_into();
    let shape = shape.map_err(|_| PyTypeError::new_err("an array of another shape"))?;
    Ok((buffer.to_vec(py)?, shape))
}

fn corners(py: Python<'_>, faces: &Bound<'_, PyAny>) -> PyResult<Csr> {
    let (indices, [_, corners]) = elements::<u32, 2>(py, faces)?;
    if u32::try_from(indices.len()).is_err() {
        let message = "the scan has too many faces: relievo counts their corners in 32 bits";
        return Err(error::usage(py, message));
    }
    let mut rows = Csr::default();
    if corners > 0 {
        indices
            .chunks_exact(corners)
            .for_each(|face| rows.push_row(face));
    }
    Ok(rows)
}

/// An image that nobody changes any more.
#[pyclass(frozen, name = "HeldImage", module = "relievo._relievo")]
pub(super) struct HeldImage(pub(super) Arc<Image>);

#[pymethods]
impl HeldImage {
    /// An image of height × width × 3 intensities of red, green and blue (`uint8`).
    #[staticmethod]
    fn of_pixels(py: Python<'_>, pixels: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (values, [height, width, channels]) = elements::<u8, 3>(py, pixels)?;
        let sides = [width, height].map(u32::try_from);
        let ([Ok(width), Ok(height)], 3) = (sides, channels) else {
            return Err(PyTypeError::new_err("no image of three channels"));
        };
        let intensity = |value: u8| f32::from(value) / f32::from(u8::MAX);
        let (triples, _) = values.as_chunks::<3>();
        Ok(Self(Arc::new(Image {
            width,
            height,
            colors: triples.iter().map(|pixel| pixel.map(intensity)).collect(),
            opaque: None,
            is_grey: triples.iter().all(|[r, g, b]| r == g && g == b),
            bits: 8,
        })))
    }
}
