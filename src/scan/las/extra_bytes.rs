//! Properties that a program adds to the points of a LAS file, behind those of the standard.
//!
//! Reference: ASPRS, *LAS Specification 1.4-R15*, section on the extra bytes record, tables 24 and
//! 25.

use super::{LENGTHS, Points, bytes_at};
use crate::scan::channel::Scalar;
use crate::scan::names::plain_name;
use crate::scan::{Channel, Column};

/// User and number of the record that describes the bytes.
pub(super) const RECORD: (&[u8], u16) = (b"LASF_Spec", 4);

/// Bytes of the description of one property.
const DESCRIPTION: usize = 192;

/// Bits of the options: values are to be multiplied, and moved.
const HAS_SCALE: u8 = 1 << 3;
const HAS_OFFSET: u8 = 1 << 4;

/// The types of numbers, which have the codes 1 to 10.
const SIZES: [usize; 10] = [1, 1, 2, 2, 4, 4, 8, 8, 4, 8];

/// A property as its record describes it.
#[derive(Debug)]
struct Property {
    name: String,
    /// Where it is in a point.
    at: usize,
    /// Code of its type, 1 to 10.
    kind: usize,
    scale: Option<f64>,
    offset: Option<f64>,
}

/// The channels of the added properties, and how many bytes of each point no property covers.
///
/// A property of several numbers gives a channel each. Values with a scale or an offset are `double`, and so are
/// integers of 64 bits; what a writer marks as missing keeps the value that stands for it.
pub(super) fn channels(record: &[u8], points: &Points) -> (Vec<Channel>, usize) {
    let header = points.header;
    let standard = LENGTHS[usize::from(header.format)];
    let (properties, left) = properties(record, standard, header.length);
    let channel = |property: Property| Channel {
        values: property.column(points),
        name: property.name,
    };
    (properties.into_iter().map(channel).collect(), left)
}

/// The properties that fit into the points, and the bytes that are left.
fn properties(record: &[u8], standard: usize, length: usize) -> (Vec<Property>, usize) {
    let mut properties = Vec::new();
    let mut covered = 0;
    let mut at = standard;
    for text in record.chunks_exact(DESCRIPTION) {
        let (code, options) = (usize::from(text[2]), text[3]);
        // Bytes of no type; the options are their number.
        if code == 0 {
            at += usize::from(options);
            continue;
        }
        // Codes 11 to 30 are two or three numbers of the types before (up to version 1.4-R13).
        let (kind, count) = ((code - 1) % SIZES.len() + 1, (code - 1) / SIZES.len() + 1);
        let size = SIZES[kind - 1];
        if count > 3 || at + size * count > length {
            break;
        }
        let name = text[4..36].split(|byte| *byte == 0).next();
        let name = plain_name(&String::from_utf8_lossy(name.unwrap_or_default()));
        let number = |bit: u8, place: usize| {
            let value = bytes_at(text, place).map(f64::from_le_bytes);
            value.filter(|_| options & bit != 0)
        };
        for part in 0..count {
            properties.push(Property {
                name: if count > 1 {
                    format!("{name}_{part}")
                } else {
                    name.clone()
                },
                at,
                kind,
                scale: number(HAS_SCALE, 112 + 8 * part),
                offset: number(HAS_OFFSET, 136 + 8 * part),
            });
            at += size;
            covered += size;
        }
    }
    (properties, (length - standard) - covered)
}

impl Property {
    fn column(&self, points: &Points) -> Column {
        if self.scale.is_some() || self.offset.is_some() {
            return self.doubles(points);
        }
        match self.kind {
            1 => Column::U8(self.numbers(points, u8::from_le_bytes)),
            2 => Column::I8(self.numbers(points, i8::from_le_bytes)),
            3 => Column::U16(self.numbers(points, u16::from_le_bytes)),
            4 => Column::I16(self.numbers(points, i16::from_le_bytes)),
            5 => Column::U32(self.numbers(points, u32::from_le_bytes)),
            6 => Column::I32(self.numbers(points, i32::from_le_bytes)),
            9 => Column::F32(self.numbers(points, f32::from_le_bytes)),
            _ => self.doubles(points),
        }
    }

    fn numbers<T, const N: usize>(&self, points: &Points, decode: fn([u8; N]) -> T) -> Vec<T> {
        points.each().map(|p| number(p, self.at, decode)).collect()
    }

    fn doubles(&self, points: &Points) -> Column {
        let (scale, offset) = (self.scale.unwrap_or(1.0), self.offset.unwrap_or(0.0));
        let value = |point| self.value(point) * scale + offset;
        Column::F64(points.each().map(value).collect())
    }

    fn value(&self, point: &[u8]) -> f64 {
        let at = self.at;
        match self.kind {
            1 => number(point, at, u8::from_le_bytes).exact(),
            2 => number(point, at, i8::from_le_bytes).exact(),
            3 => number(point, at, u16::from_le_bytes).exact(),
            4 => number(point, at, i16::from_le_bytes).exact(),
            5 => number(point, at, u32::from_le_bytes).exact(),
            6 => number(point, at, i32::from_le_bytes).exact(),
            // Beyond 2^53 they are rounded; identifiers of this size are rare.
            7 => number(point, at, u64::from_le_bytes) as f64,
            8 => number(point, at, i64::from_le_bytes) as f64,
            9 => number(point, at, f32::from_le_bytes).exact(),
            _ => number(point, at, f64::from_le_bytes),
        }
    }
}

fn number<T, const N: usize>(point: &[u8], at: usize, decode: fn([u8; N]) -> T) -> T {
    decode(bytes_at(point, at).unwrap_or([0; N]))
}
