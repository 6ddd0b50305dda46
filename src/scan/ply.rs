//! PLY in: ASCII, binary little endian and binary big endian.
//!
//! `ply_rs` reads the header's types. Rows are split here: its ASCII grammar refuses `nan`, `inf`, `.5`,
//! `5.` and blank lines, all of which scanners write, and it makes a list of values of every row before they
//! can be put where they belong.
//!
//! Reference: Greg Turk, *The PLY Polygon File Format*, 1994.

mod header;
mod rows;
mod texture;
mod tristrips;
mod write;

pub(super) use self::texture::{IMAGE_NUMBER, TEXTURE_FILE, read_painted};
pub(super) use self::write::write;

use ply_rs::ply::{Encoding, PropertyType, ScalarType};

use super::vertex_lists::INDEX_NAMES;
use super::{Channel, Column, Scan, ScanError, Table};
use crate::mesh::Csr;
use header::{Element, Header, read_header};
use rows::{Row, RowError};

/// Reads a PLY file; range grids are not yet triangulated.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<Scan, ScanError> {
    let (header, start) = read_header(bytes, name)?;
    let Header {
        encoding,
        elements,
        comments,
        obj_info,
    } = header;
    let mut scan = Scan {
        comments,
        obj_info,
        ..Scan::default()
    };
    let mut payload = Payload {
        encoding,
        rest: &bytes[start..],
        file: name,
        overlong: 0,
    };
    for element in &elements {
        if element.name == "face" {
            let indices = index_list(element);
            if indices.is_none() && element.def.count > 0 {
                return Err(ScanError::MissingIndices {
                    name: name.to_owned(),
                });
            }
            (scan.face_channels, scan.faces) = payload.element(element, indices)?;
        } else {
            let (table, _) = payload.element(element, None)?;
            if element.name == "vertex" {
                scan.vertices = table;
            } else {
                scan.other_elements.push((element.name.clone(), table));
            }
        }
    }
    if payload.overlong > 0 {
        log::warn!(
            "{name}: {} rows have more values than the header says; the last ones are ignored",
            payload.overlong
        );
    }
    if !payload.rest.trim_ascii().is_empty() {
        log::warn!(
            "{name}: {} bytes behind the last row are ignored",
            payload.rest.len()
        );
    }
    if scan.face_channels.channels.is_empty() {
        scan.face_channels = Table::default();
    }
    tristrips::unroll(&mut scan, name)?;
    Ok(scan)
}

/// The list of a face's vertices among its properties.
fn index_list(element: &Element) -> Option<usize> {
    let types = element.def.properties.values().map(|p| &p.data_type);
    let properties = || element.properties.iter().zip(types.clone());
    INDEX_NAMES.iter().find_map(|known| {
        properties().position(|(name, data_type)| {
            name == known && matches!(data_type, PropertyType::List(..))
        })
    })
}

/// What is left of the file behind the header.
struct Payload<'a> {
    encoding: Encoding,
    rest: &'a [u8],
    file: &'a str,
    /// Number of ASCII rows with more values than properties.
    overlong: usize,
}

impl Payload<'_> {
    /// Reads all rows of an element. The list at `indices` goes to the rows of the second result.
    ///
    /// Nothing is allocated because a header says so: memory follows what was found in the file.
    fn element(
        &mut self,
        element: &Element,
        indices: Option<usize>,
    ) -> Result<(Table, Csr), ScanError> {
        let def = &element.def;
        let types: Vec<PropertyType> = def
            .properties
            .values()
            .map(|p| p.data_type.clone())
            .collect();
        let mut columns: Vec<Column> = types.iter().map(empty_column).collect();
        let mut faces = Faces::default();
        let row_size: usize = types.iter().map(least_size).sum();
        let plausible = def.count.min(self.rest.len() / row_size.max(1));
        for (index, column) in columns.iter_mut().enumerate() {
            if Some(index) != indices && !matches!(column, Column::List(_)) {
                column.reserve(plausible);
            }
        }
        // A row without properties takes no bytes: nothing is there to be read.
        let rows = if types.is_empty() { 0 } else { def.count };
        for row in 0..rows {
            let stored = self.row(&types, &mut columns, indices, &mut faces);
            stored.map_err(|e| match e {
                RowError::End => ScanError::Truncated {
                    name: self.file.to_owned(),
                    element: element.name.clone(),
                    found: row,
                    expected: def.count,
                },
                RowError::Malformed(reason) => ScanError::Row {
                    name: self.file.to_owned(),
                    element: element.name.clone(),
                    row,
                    reason,
                },
            })?;
        }
        let named = columns.into_iter().zip(&element.properties).enumerate();
        let channels = named
            .filter(|(index, _)| Some(*index) != indices)
            .map(|(_, (mut values, name))| {
                values.shrink_to_fit();
                Channel {
                    name: name.clone(),
                    values,
                }
            })
            .collect();
        Ok((
            Table {
                channels,
                rows: def.count,
            },
            faces.rows,
        ))
    }

    fn row(
        &mut self,
        types: &[PropertyType],
        columns: &mut [Column],
        indices: Option<usize>,
        faces: &mut Faces,
    ) -> Result<(), RowError> {
        let mut row = Row::next(&self.encoding, &mut self.rest)?;
        for (index, (data_type, column)) in types.iter().zip(columns).enumerate() {
            match data_type {
                PropertyType::List(count, item) if Some(index) == indices => {
                    row.indices(count, item, &mut faces.row)?;
                    faces.push().map_err(RowError::Malformed)?;
                }
                PropertyType::List(count, item) => row.list(count, item, column)?,
                PropertyType::Scalar(_) => row.value(column)?,
            }
        }
        self.overlong += usize::from(row.has_more());
        Ok(())
    }
}

/// The faces' vertices.
#[derive(Default)]
struct Faces {
    rows: Csr,
    items: usize,
    row: Vec<u32>,
}

impl Faces {
    /// Takes over the row.
    fn push(&mut self) -> Result<(), String> {
        self.items += self.row.len();
        if u32::try_from(self.items).is_err() {
            return Err("the faces have 2^32 corners or more".to_owned());
        }
        self.rows.push_row(&self.row);
        Ok(())
    }
}

fn empty_column(data_type: &PropertyType) -> Column {
    match data_type {
        PropertyType::List(..) => Column::List(Vec::new()),
        PropertyType::Scalar(scalar) => scalar_column(scalar),
    }
}

/// A column for values of a type.
pub(super) fn scalar_column(scalar: &ScalarType) -> Column {
    match scalar {
        ScalarType::Char => Column::I8(Vec::new()),
        ScalarType::UChar => Column::U8(Vec::new()),
        ScalarType::Short => Column::I16(Vec::new()),
        ScalarType::UShort => Column::U16(Vec::new()),
        ScalarType::Int => Column::I32(Vec::new()),
        ScalarType::UInt => Column::U32(Vec::new()),
        ScalarType::Float => Column::F32(Vec::new()),
        ScalarType::Double => Column::F64(Vec::new()),
    }
}

/// The fewest bytes that a value takes in any encoding: in ASCII a digit and a separator, hence at
/// least as much as this says only for single bytes. An estimate for reserving, never a check.
fn least_size(data_type: &PropertyType) -> usize {
    match data_type {
        PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => match scalar {
            ScalarType::Char | ScalarType::UChar => 1,
            ScalarType::Short | ScalarType::UShort => 2,
            ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
            ScalarType::Double => 8,
        },
    }
}
