//! PLY in: ASCII, binary little endian and binary big endian.
//!
//! `ply_rs` reads the header's types and the rows of binary payloads. ASCII rows are split here,
//! because its grammar refuses `nan`, `inf`, `.5`, `5.` and blank lines, all of which scanners write.
//!
//! Reference: Greg Turk, *The PLY Polygon File Format*, 1994.

use std::io::ErrorKind;

use ply_rs::parser::Parser;
use ply_rs::ply::{
    ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::channel::Scalar;
use super::ply_header::{Element, Header, read_header};
use super::{Channel, Column, Scan, ScanError, Table};
use crate::mesh::Csr;

/// Names of the list of a face's vertices.
const INDEX_NAMES: [&str; 2] = ["vertex_indices", "vertex_index"];

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
            let indices = INDEX_NAMES
                .iter()
                .find_map(|n| element.properties.iter().position(|p| p == n));
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
    Ok(scan)
}

/// One row, in the order of the properties. `ply_rs` hands over each value with its type.
struct Row(Vec<Property>);

impl PropertyAccess for Row {
    fn new() -> Self {
        Self(Vec::with_capacity(8))
    }

    fn set_property(&mut self, _name: &str, value: Property) -> PropertyAccessResult {
        self.0.push(value);
        PropertyAccessResult::Set
    }
}

/// What is left of the file behind the header.
struct Payload<'a> {
    encoding: Encoding,
    rest: &'a [u8],
    file: &'a str,
    /// Number of ASCII rows with more values than properties.
    overlong: usize,
}

/// Why a row could not be read.
enum RowError {
    End,
    Malformed(String),
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
        for (_, column) in others(&mut columns, indices) {
            if !matches!(column, Column::List(_)) {
                column.reserve(plausible);
            }
        }
        // A row without properties takes no bytes: nothing is there to be read.
        let rows = if types.is_empty() { 0 } else { def.count };
        for row in 0..rows {
            let stored = self.row(def, &types).and_then(|values| {
                for (index, value) in values.into_iter().enumerate() {
                    if Some(index) == indices {
                        faces.push(&value).map_err(RowError::Malformed)?;
                    } else {
                        push(&mut columns[index], value);
                    }
                }
                Ok(())
            });
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
        let channels = others(&mut columns, indices)
            .map(|(index, column)| {
                column.shrink_to_fit();
                Channel {
                    name: element.properties[index].clone(),
                    values: std::mem::replace(column, Column::U8(Vec::new())),
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

    fn row(&mut self, def: &ElementDef, types: &[PropertyType]) -> Result<Vec<Property>, RowError> {
        let parser = Parser::<Row>::new();
        let row = match self.encoding {
            Encoding::Ascii => return self.ascii_row(types),
            Encoding::BinaryLittleEndian => parser.read_little_endian_element(&mut self.rest, def),
            Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut self.rest, def),
        };
        row.map(|r| r.0).map_err(|e| match e.kind() {
            ErrorKind::UnexpectedEof => RowError::End,
            _ => RowError::Malformed(e.to_string()),
        })
    }

    fn ascii_row(&mut self, types: &[PropertyType]) -> Result<Vec<Property>, RowError> {
        let line = loop {
            let is_end = |b: &u8| matches!(b, b'\n' | b'\r');
            let length = self.rest.iter().position(is_end).unwrap_or(self.rest.len());
            let (line, rest) = self.rest.split_at(length);
            self.rest = rest.get(1..).unwrap_or_default();
            if !line.trim_ascii().is_empty() {
                break line;
            }
            if rest.is_empty() {
                return Err(RowError::End);
            }
        };
        let line = std::str::from_utf8(line)
            .map_err(|_| RowError::Malformed("these bytes are not text".to_owned()))?;
        let mut tokens = line.split_ascii_whitespace();
        let mut values = Vec::with_capacity(types.len());
        for data_type in types {
            let value = match data_type {
                PropertyType::Scalar(scalar) => ascii_value(scalar, &mut tokens),
                PropertyType::List(_, item) => ascii_list(item, &mut tokens),
            };
            match value {
                Ok(value) => values.push(value),
                // A file that was cut off within a line, not a line that is too short.
                Err(None) if self.rest.is_empty() => return Err(RowError::End),
                Err(None) => {
                    return Err(RowError::Malformed("it has too few values".to_owned()));
                }
                Err(Some(reason)) => return Err(RowError::Malformed(reason)),
            }
        }
        self.overlong += usize::from(tokens.next().is_some());
        Ok(values)
    }
}

/// The columns other than the list of a face's vertices.
fn others(
    columns: &mut [Column],
    indices: Option<usize>,
) -> impl Iterator<Item = (usize, &mut Column)> {
    columns
        .iter_mut()
        .enumerate()
        .filter(move |(index, _)| Some(*index) != indices)
}

/// The faces' vertices.
#[derive(Default)]
struct Faces {
    rows: Csr,
    items: usize,
    row: Vec<u32>,
}

impl Faces {
    fn push(&mut self, list: &Property) -> Result<(), String> {
        self.row.clear();
        if let Property::ListInt(items) = list {
            for item in items {
                let item = u32::try_from(*item).map_err(|_| format!("{item} is not an index"))?;
                self.row.push(item);
            }
        } else {
            let Some(items) = list.to_u32_list() else {
                return Err("its vertex indices are not whole numbers from 0".to_owned());
            };
            self.row = items;
        }
        self.items += self.row.len();
        if u32::try_from(self.items).is_err() {
            return Err("the faces have 2^32 corners or more".to_owned());
        }
        self.rows.push_row(&self.row);
        Ok(())
    }
}

/// A token as a number. `Err(None)`: there are no more tokens.
fn next<'a, T: Scalar>(tokens: &mut impl Iterator<Item = &'a str>) -> Result<T, Option<String>> {
    let token = tokens.next().ok_or(None)?;
    T::parse(token).ok_or_else(|| {
        let shown: String = token.chars().take(40).collect();
        Some(format!("`{shown}` is not a value of its property's type"))
    })
}

fn ascii_value<'a>(
    scalar: &ScalarType,
    tokens: &mut impl Iterator<Item = &'a str>,
) -> Result<Property, Option<String>> {
    Ok(match scalar {
        ScalarType::Char => Property::Char(next(tokens)?),
        ScalarType::UChar => Property::UChar(next(tokens)?),
        ScalarType::Short => Property::Short(next(tokens)?),
        ScalarType::UShort => Property::UShort(next(tokens)?),
        ScalarType::Int => Property::Int(next(tokens)?),
        ScalarType::UInt => Property::UInt(next(tokens)?),
        ScalarType::Float => Property::Float(next(tokens)?),
        ScalarType::Double => Property::Double(next(tokens)?),
    })
}

fn ascii_list<'a>(
    item: &ScalarType,
    tokens: &mut impl Iterator<Item = &'a str>,
) -> Result<Property, Option<String>> {
    let length: u32 = next(tokens)?;
    macro_rules! items {
        () => {
            (0..length)
                .map(|_| next(tokens))
                .collect::<Result<_, _>>()?
        };
    }
    Ok(match item {
        ScalarType::Char => Property::ListChar(items!()),
        ScalarType::UChar => Property::ListUChar(items!()),
        ScalarType::Short => Property::ListShort(items!()),
        ScalarType::UShort => Property::ListUShort(items!()),
        ScalarType::Int => Property::ListInt(items!()),
        ScalarType::UInt => Property::ListUInt(items!()),
        ScalarType::Float => Property::ListFloat(items!()),
        ScalarType::Double => Property::ListDouble(items!()),
    })
}

fn empty_column(data_type: &PropertyType) -> Column {
    match data_type {
        PropertyType::List(..) => Column::List(Vec::new()),
        PropertyType::Scalar(ScalarType::Char) => Column::I8(Vec::new()),
        PropertyType::Scalar(ScalarType::UChar) => Column::U8(Vec::new()),
        PropertyType::Scalar(ScalarType::Short) => Column::I16(Vec::new()),
        PropertyType::Scalar(ScalarType::UShort) => Column::U16(Vec::new()),
        PropertyType::Scalar(ScalarType::Int) => Column::I32(Vec::new()),
        PropertyType::Scalar(ScalarType::UInt) => Column::U32(Vec::new()),
        PropertyType::Scalar(ScalarType::Float) => Column::F32(Vec::new()),
        PropertyType::Scalar(ScalarType::Double) => Column::F64(Vec::new()),
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

/// Appends a value; the column was made for values of its type.
fn push(column: &mut Column, value: Property) {
    match (column, value) {
        (Column::I8(values), Property::Char(value)) => values.push(value),
        (Column::U8(values), Property::UChar(value)) => values.push(value),
        (Column::I16(values), Property::Short(value)) => values.push(value),
        (Column::U16(values), Property::UShort(value)) => values.push(value),
        (Column::I32(values), Property::Int(value)) => values.push(value),
        (Column::U32(values), Property::UInt(value)) => values.push(value),
        (Column::F32(values), Property::Float(value)) => values.push(value),
        (Column::F64(values), Property::Double(value)) => values.push(value),
        (Column::List(lists), Property::ListChar(items)) => lists.push(Column::I8(items)),
        (Column::List(lists), Property::ListUChar(items)) => lists.push(Column::U8(items)),
        (Column::List(lists), Property::ListShort(items)) => lists.push(Column::I16(items)),
        (Column::List(lists), Property::ListUShort(items)) => lists.push(Column::U16(items)),
        (Column::List(lists), Property::ListInt(items)) => lists.push(Column::I32(items)),
        (Column::List(lists), Property::ListUInt(items)) => lists.push(Column::U32(items)),
        (Column::List(lists), Property::ListFloat(items)) => lists.push(Column::F32(items)),
        (Column::List(lists), Property::ListDouble(items)) => lists.push(Column::F64(items)),
        _ => debug_assert!(false, "a value of another type than declared"),
    }
}
