//! PLY out: binary little endian or ASCII, every channel in its own type.
//!
//! Order of the elements: vertices, faces, then all others. Lists are counted in `uchar`, or in
//! `uint` if one of them is longer than 255.

use std::io::{self, Write};

use ply_rs::ply::{
    Addable, DefaultElement, ElementDef, Encoding, Header, PropertyDef, PropertyType, ScalarType,
    Version,
};
use ply_rs::writer::Writer;

use crate::mesh::Csr;
use crate::scan::channel::{Scalar, match_column};
use crate::scan::vertex_lists::INDEX_NAMES;
use crate::scan::{Column, Scan, Table};

/// Rows are collected up to about this many bytes before they are written.
const CHUNK: usize = 1 << 20;

/// Writes a whole PLY file.
pub(in crate::scan) fn write(scan: &Scan, out: &mut impl Write, ascii: bool) -> io::Result<()> {
    write_header(scan, out, ascii)?;
    let mut rows = Rows {
        out,
        buffer: Vec::with_capacity(CHUNK + CHUNK / 4),
        ascii,
    };
    rows.table(&scan.vertices)?;
    rows.faces(&scan.faces, &scan.face_channels)?;
    for (_, table) in &scan.other_elements {
        rows.table(table)?;
    }
    rows.flush()
}

fn write_header(scan: &Scan, out: &mut impl Write, ascii: bool) -> io::Result<()> {
    let mut header = Header::new();
    header.encoding = if ascii {
        Encoding::Ascii
    } else {
        Encoding::BinaryLittleEndian
    };
    header.version = Version { major: 1, minor: 0 };
    header.comments = scan.comments.iter().map(|c| one_line(c)).collect();
    header.obj_infos = scan.obj_info.iter().map(|c| one_line(c)).collect();
    let writer = Writer::<DefaultElement>::new();
    header.elements.add(definition("vertex", &scan.vertices));
    if !scan.faces.is_empty() {
        let mut face = ElementDef::new("face".to_owned());
        face.count = scan.faces.len();
        let list = PropertyType::List(face_count_type(&scan.faces), face_item_type(scan));
        face.properties
            .add(PropertyDef::new(INDEX_NAMES[0].to_owned(), list));
        face.properties
            .extend(definition("face", &scan.face_channels).properties);
        header.elements.add(face);
    }
    for (name, table) in &scan.other_elements {
        header.elements.add(definition(name, table));
    }
    writer.write_header(out, &header).map(|_| ())
}

/// A line break would end the comment and start something else.
fn one_line(text: &str) -> String {
    text.replace(['\n', '\r'], " ")
}

fn definition(name: &str, table: &Table) -> ElementDef {
    let mut element = ElementDef::new(name.to_owned());
    element.count = table.rows;
    for channel in &table.channels {
        let data_type = match &channel.values {
            Column::List(lists) => {
                // Without a list there is no type to keep; `int` is what most programs expect.
                let item = lists.first().map_or(ScalarType::Int, scalar_type);
                PropertyType::List(count_type(lists.iter().map(Column::len)), item)
            }
            scalar => PropertyType::Scalar(scalar_type(scalar)),
        };
        element
            .properties
            .add(PropertyDef::new(channel.name.clone(), data_type));
    }
    debug_assert_eq!(
        element.properties.len(),
        table.channels.len(),
        "names of channels differ"
    );
    element
}

fn scalar_type(column: &Column) -> ScalarType {
    match column {
        Column::I8(_) => ScalarType::Char,
        Column::U8(_) => ScalarType::UChar,
        Column::I16(_) => ScalarType::Short,
        Column::U16(_) => ScalarType::UShort,
        Column::I32(_) | Column::List(_) => ScalarType::Int,
        Column::U32(_) => ScalarType::UInt,
        Column::F32(_) => ScalarType::Float,
        Column::F64(_) => ScalarType::Double,
    }
}

fn count_type(mut lengths: impl Iterator<Item = usize>) -> ScalarType {
    if lengths.all(|n| u8::try_from(n).is_ok()) {
        ScalarType::UChar
    } else {
        ScalarType::UInt
    }
}

fn face_count_type(faces: &Csr) -> ScalarType {
    count_type(faces.rows().map(<[u32]>::len))
}

/// `int`, as nearly every program writes it, as long as the indices fit.
fn face_item_type(scan: &Scan) -> ScalarType {
    if i32::try_from(scan.vertices.rows).is_ok() {
        ScalarType::Int
    } else {
        ScalarType::UInt
    }
}

struct Rows<'a, W> {
    out: &'a mut W,
    buffer: Vec<u8>,
    ascii: bool,
}

impl<W: Write> Rows<'_, W> {
    fn table(&mut self, table: &Table) -> io::Result<()> {
        if table.channels.is_empty() {
            return Ok(());
        }
        let wide = wide_lists(table);
        for row in 0..table.rows {
            self.values(table, &wide, row);
            self.end_row()?;
        }
        Ok(())
    }

    fn faces(&mut self, faces: &Csr, channels: &Table) -> io::Result<()> {
        let wide = wide_lists(channels);
        let wide_faces = face_count_type(faces) == ScalarType::UInt;
        for (row, face) in faces.rows().enumerate() {
            self.count(face.len(), wide_faces);
            for index in face {
                self.value(*index);
            }
            self.values(channels, &wide, row);
            self.end_row()?;
        }
        Ok(())
    }

    fn values(&mut self, table: &Table, wide: &[bool], row: usize) {
        for (channel, wide) in table.channels.iter().zip(wide) {
            match_column!(&channel.values, values => self.value(values[row]), lists => {
                self.count(lists[row].len(), *wide);
                match_column!(
                    &lists[row],
                    values => for value in values { self.value(*value); },
                    _lists => {}
                );
            });
        }
    }

    fn count(&mut self, length: usize, wide: bool) {
        // The type was chosen by the longest list.
        if wide {
            self.value(u32::try_from(length).unwrap_or(u32::MAX));
        } else {
            self.value(u8::try_from(length).unwrap_or(u8::MAX));
        }
    }

    fn value(&mut self, value: impl Scalar) {
        if self.ascii {
            value.push_ascii(&mut self.buffer);
            self.buffer.push(b' ');
        } else {
            value.push_le(&mut self.buffer);
        }
    }

    fn end_row(&mut self) -> io::Result<()> {
        if self.ascii {
            // The blank behind the last value becomes the line's end.
            if let Some(last) = self.buffer.last_mut() {
                *last = b'\n';
            }
        }
        if self.buffer.len() >= CHUNK {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.write_all(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }
}

/// For each channel, whether it is counted in `uint`.
fn wide_lists(table: &Table) -> Vec<bool> {
    let wide = |column: &Column| match column {
        Column::List(lists) => count_type(lists.iter().map(Column::len)) == ScalarType::UInt,
        _ => false,
    };
    table.channels.iter().map(|c| wide(&c.values)).collect()
}
