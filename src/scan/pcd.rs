//! Point Cloud Library files (PCD), as text, binary and compressed.
//!
//! Organized clouds (of more than one row) are range grids. The viewpoint is where the sensor stood;
//! at the origin, which is also what PCL writes if it knows nothing, it is believed for organized
//! clouds only.
//!
//! Reference: "The PCD (Point Cloud Data) file format", documentation of PCL, version 0.7.

mod header;
mod lzf;

use std::borrow::Cow;

use nalgebra::Point3;

use super::channel::Scalar;
use super::names::channel_names;
use super::range_grid::Grid;
use super::source::{Parsed, Source};
use super::text::{line_error, lines, number, shown};
use super::{Channel, Column, Scan, ScanError, Sensor, Table};
use header::{Field, Header, Kind, Storage};

/// Reads a PCD file. Points without finite coordinates are where the sensor saw nothing; they are
/// left out.
pub(super) fn read(source: &Source) -> Result<Parsed, ScanError> {
    let name = source.name;
    let header = Header::parse(source.bytes, name)?;
    let payload = source.bytes.get(header.data..).unwrap_or_default();
    let points = header.width * header.height;
    if header.point_size() == 0 {
        return Ok(Parsed::default());
    }
    let (data, by_field) = match header.storage {
        Storage::Ascii => (Cow::Owned(encode(payload, &header, points, name)?), false),
        Storage::Binary => (Cow::Borrowed(payload), false),
        Storage::Compressed => (Cow::Owned(decompress(payload, name)?), true),
    };
    let found = data.len() / header.point_size();
    if found < points {
        return Err(ScanError::Truncated {
            name: name.to_owned(),
            element: "points".to_owned(),
            found,
            expected: points,
        });
    }
    let slots = slots(&header, points, by_field);
    let coordinates: Vec<&Slot> = ["x", "y", "z"]
        .iter()
        .filter_map(|axis| slots.iter().find(|slot| slot.name == *axis))
        .collect();
    let seen = |point: usize| {
        coordinates
            .iter()
            .all(|s| s.value(&data, point).is_finite())
    };
    let kept: Vec<usize> = (0..points).filter(|p| seen(*p)).collect();
    let vertices = table(&slots, &data, &kept);
    Ok(with_grid(&header, vertices, &kept, name))
}

/// The scan with what the header says about grid and viewpoint; `kept` are the points that became
/// vertices.
fn with_grid(header: &Header, vertices: Table, kept: &[usize], name: &str) -> Parsed {
    let points = header.width * header.height;
    let position = Point3::from(header.viewpoint);
    let is_organized = header.height > 1;
    let is_known = is_organized || position != Point3::origin();
    if !is_organized && kept.len() < points {
        log::warn!(
            "{name}: {} of {points} points dropped, whose coordinates are not finite numbers",
            points - kept.len()
        );
    }
    let mut parsed = Parsed::default();
    if is_organized {
        let mut cells = vec![None; points];
        for (vertex, point) in kept.iter().enumerate() {
            // A scan with more vertices than that is refused by its check.
            cells[*point] = u32::try_from(vertex).ok();
        }
        parsed.grids.push(Grid {
            columns: header.width,
            cells,
            sensor: Some(position),
        });
    }
    parsed.scan = Scan {
        sensors: is_known
            .then_some(Sensor {
                vertices: 0..vertices.rows,
                position,
            })
            .into_iter()
            .collect(),
        vertices,
        ..Scan::default()
    };
    parsed
}

/// Where one of a point's values is in the data.
#[derive(Debug)]
struct Slot {
    /// Name as in the file, numbered if its field has several values.
    name: String,
    kind: Kind,
    /// Where the first point has it.
    start: usize,
    /// From there to the next point's.
    stride: usize,
}

/// Where the values are: point by point, or (`by_field`) field by field, as when compressed.
fn slots(header: &Header, points: usize, by_field: bool) -> Vec<Slot> {
    let point_size = header.point_size();
    let mut slots = Vec::new();
    let mut offset = 0;
    for Field { name, kind, count } in &header.fields {
        let field_size = kind.size() * count;
        let is_padding = name == "_";
        for k in (0..*count).filter(|_| !is_padding) {
            let (start, stride) = if by_field {
                (offset * points, field_size)
            } else {
                (offset, point_size)
            };
            slots.push(Slot {
                name: if *count == 1 {
                    name.clone()
                } else {
                    format!("{name}_{k}")
                },
                kind: *kind,
                start: start + k * kind.size(),
                stride,
            });
        }
        offset += field_size;
    }
    slots
}

impl Slot {
    fn bytes<const N: usize>(&self, data: &[u8], point: usize) -> [u8; N] {
        let at = self.start + point * self.stride;
        let bytes = data.get(at..at + N).and_then(|b| b.try_into().ok());
        // The data were found to be long enough.
        bytes.unwrap_or([0; N])
    }

    #[expect(
        clippy::cast_precision_loss,
        reason = "64 bit integers are times and counters, of which double keeps 53 bits"
    )]
    fn value(&self, data: &[u8], point: usize) -> f64 {
        match self.kind {
            Kind::I8 => i8::from_le_bytes(self.bytes(data, point)).into(),
            Kind::I16 => i16::from_le_bytes(self.bytes(data, point)).into(),
            Kind::I32 => i32::from_le_bytes(self.bytes(data, point)).into(),
            Kind::U8 => u8::from_le_bytes(self.bytes(data, point)).into(),
            Kind::U16 => u16::from_le_bytes(self.bytes(data, point)).into(),
            Kind::U32 => u32::from_le_bytes(self.bytes(data, point)).into(),
            Kind::F32 => f32::from_le_bytes(self.bytes(data, point)).into(),
            Kind::F64 => f64::from_le_bytes(self.bytes(data, point)),
            Kind::I64 => i64::from_le_bytes(self.bytes(data, point)) as f64,
            Kind::U64 => u64::from_le_bytes(self.bytes(data, point)) as f64,
        }
    }

    /// The channels of which a packed colour has one byte each, from the lowest.
    fn packed_color(&self) -> &'static [&'static str] {
        match self.name.as_str() {
            _ if self.kind.size() != 4 => &[],
            "rgb" => &["blue", "green", "red"],
            "rgba" => &["blue", "green", "red", "alpha"],
            _ => &[],
        }
    }
}

fn table(slots: &[Slot], data: &[u8], kept: &[usize]) -> Table {
    let mut channels: Vec<(&str, Column)> = Vec::new();
    for slot in slots {
        let packed = slot.packed_color();
        let mut colors = Vec::new();
        for (k, color) in packed.iter().enumerate() {
            let values = kept.iter().map(|p| slot.bytes::<4>(data, *p)[k]);
            colors.push((*color, Column::U8(values.collect())));
        }
        colors[..packed.len().min(3)].reverse();
        if packed.is_empty() {
            let mut column = slot.kind.column();
            column.reserve(kept.len());
            for point in kept {
                column.push_rounded(slot.value(data, *point));
            }
            channels.push((&slot.name, column));
        }
        channels.extend(colors);
    }
    let names = channel_names(channels.iter().map(|(name, _)| *name));
    Table {
        channels: names
            .into_iter()
            .zip(channels)
            .map(|(name, (_, values))| Channel { name, values })
            .collect(),
        rows: kept.len(),
    }
}

fn decompress(payload: &[u8], name: &str) -> Result<Vec<u8>, ScanError> {
    let fail = |reason: &str| ScanError::Malformed {
        name: name.to_owned(),
        reason: reason.to_owned(),
    };
    let word = |bytes: &[u8; 4]| usize::try_from(u32::from_le_bytes(*bytes)).unwrap_or(usize::MAX);
    let cut_off = || fail("it is cut off within its compressed points");
    let (sizes, rest) = payload.split_first_chunk::<8>().ok_or_else(cut_off)?;
    let [a, b, c, d, e, f, g, h] = *sizes;
    let compressed = rest.get(..word(&[a, b, c, d])).ok_or_else(cut_off)?;
    lzf::decompress(compressed, word(&[e, f, g, h]))
        .ok_or_else(|| fail("its compressed points are damaged"))
}

/// Points in text as the bytes that a binary file has.
fn encode(text: &[u8], header: &Header, points: usize, name: &str) -> Result<Vec<u8>, ScanError> {
    let mut out = Vec::new();
    let mut found = 0;
    let values = header.values();
    let kinds = || {
        let fields = header.fields.iter();
        fields.flat_map(|f| std::iter::repeat_n(f, f.count))
    };
    for (line_number, line) in lines(text) {
        let line = line.trim();
        if line.is_empty() {
            continue;
        }
        if found == points {
            log::warn!("{name}: it has more points than its header says; they are left out");
            break;
        }
        let fail = |reason: String| line_error(name, header.lines + line_number, reason);
        let mut tokens = line.split_ascii_whitespace();
        for (k, field) in kinds().enumerate() {
            let token = tokens.next();
            let token = token
                .ok_or_else(|| fail(format!("it has {k} values, where {values} are expected")))?;
            push_value(&mut out, field, token).map_err(fail)?;
        }
        if tokens.next().is_some() {
            return Err(fail(format!(
                "it has more than the expected {values} values"
            )));
        }
        found += 1;
    }
    Ok(out)
}

fn push_value(out: &mut Vec<u8>, field: &Field, token: &str) -> Result<(), String> {
    fn push<T: Scalar>(out: &mut Vec<u8>, token: &str) -> Option<()> {
        T::parse(token)?.push_le(out);
        Some(())
    }
    let pushed = match field.kind {
        Kind::I8 => push::<i8>(out, token),
        Kind::I16 => push::<i16>(out, token),
        Kind::I32 => push::<i32>(out, token),
        Kind::U8 => push::<u8>(out, token),
        Kind::U16 => push::<u16>(out, token),
        Kind::U32 => push::<u32>(out, token),
        Kind::F32 if field.name == "rgb" || field.name == "rgba" => {
            let value = number(token)?;
            // The bits of the float are the colour, which is a tiny number, or a huge negative one
            // with alpha. Some programs write the colour as a number instead.
            if (1.0..=f64::from(u32::MAX)).contains(&value) {
                u32::rounded(value).push_le(out);
                Some(())
            } else {
                push::<f32>(out, token)
            }
        }
        Kind::F32 => push::<f32>(out, token),
        Kind::F64 => push::<f64>(out, token),
        Kind::I64 => token.parse().ok().map(|v: i64| out.extend(v.to_le_bytes())),
        Kind::U64 => token.parse().ok().map(|v: u64| out.extend(v.to_le_bytes())),
    };
    let token = shown(token);
    pushed.ok_or_else(|| format!("`{token}` is not a value of its field `{}`", field.name))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{damaged, source, truncated};
    use super::*;
    use crate::scan::ReadOptions;

    const HEAD: &str = "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb label f _\nSIZE 4 4 4 4 2 8 1\n\
        TYPE F F F U U F U\nCOUNT 1 1 1 1 1 2 3\nWIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 9 1 0 0 0\nPOINTS 4\n";

    /// What differs between the four points: x, y, colour.
    const POINTS: [(f32, f32, u32); 4] = [
        (0.0, 0.0, 0x00ff_8001),
        (1.0, 0.0, 2),
        (0.0, 1.0, 3),
        (f32::NAN, 1.0, 4),
    ];

    fn ascii() -> Vec<u8> {
        let mut text = format!("{HEAD}DATA ascii\n");
        for (x, y, color) in POINTS {
            text += &format!("{x} {y} 0.5 {color} 7 1e9 -1 0 0 0\n");
        }
        text.into_bytes()
    }

    fn fields() -> [Vec<Vec<u8>>; 7] {
        let of = |value: &dyn Fn((f32, f32, u32)) -> Vec<u8>| POINTS.map(value).to_vec();
        [
            of(&|p| p.0.to_le_bytes().into()),
            of(&|p| p.1.to_le_bytes().into()),
            of(&|_| 0.5_f32.to_le_bytes().into()),
            of(&|p| p.2.to_le_bytes().into()),
            of(&|_| vec![7, 0]),
            of(&|_| [1e9_f64.to_le_bytes(), (-1.0_f64).to_le_bytes()].concat()),
            of(&|_| vec![0; 3]),
        ]
    }

    fn binary() -> Vec<u8> {
        let mut file = format!("{HEAD}DATA binary\n").into_bytes();
        for point in 0..4 {
            for field in fields() {
                file.extend(&field[point]);
            }
        }
        file
    }

    fn compressed() -> Vec<u8> {
        let plain = fields().concat().concat();
        let mut lzf = Vec::new();
        for literal in plain.chunks(32) {
            lzf.push(u8::try_from(literal.len() - 1).unwrap());
            lzf.extend(literal);
        }
        let mut file = format!("{HEAD}DATA binary_compressed\n").into_bytes();
        for length in [lzf.len(), plain.len()] {
            file.extend(u32::try_from(length).unwrap().to_le_bytes());
        }
        file.extend(lzf);
        file
    }

    fn parsed(bytes: &[u8]) -> Result<Parsed, ScanError> {
        read(&source(bytes, &ReadOptions::default()))
    }

    #[test]
    fn text_binary_and_compressed_give_the_same_grid() {
        for file in [ascii(), binary(), compressed()] {
            let Parsed { scan, grids } = parsed(&file).unwrap();
            let names: Vec<&str> = scan.vertices.channels.iter().map(|c| &*c.name).collect();
            assert_eq!(
                names,
                ["x", "y", "z", "red", "green", "blue", "label", "f_0", "f_1"]
            );
            let column = |name| scan.vertices.column(name).unwrap();
            assert_eq!(*column("x"), Column::F32(vec![0.0, 1.0, 0.0]));
            assert_eq!(*column("red"), Column::U8(vec![255, 0, 0]));
            assert_eq!(*column("green"), Column::U8(vec![128, 0, 0]));
            assert_eq!(*column("blue"), Column::U8(vec![1, 2, 3]));
            assert_eq!(*column("label"), Column::U16(vec![7; 3]));
            assert_eq!(*column("f_1"), Column::F64(vec![-1.0; 3]));
            assert_eq!(grids[0].cells, [Some(0), Some(1), Some(2), None]);
            assert_eq!(grids[0].columns, 2);
            assert_eq!(scan.sensors[0].position, Point3::new(0.0, 0.0, 9.0));
            assert_eq!(scan.sensors[0].vertices, 0..3);
        }
    }

    #[test]
    fn unorganized_clouds_have_no_grid_and_no_default_sensor() {
        let text = "VERSION .7\nFIELDS x y z normal_x rgb\nSIZE 4 4 4 4 4\nTYPE F F F F F\n\
            WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3 0.5 4.2108e+06\nnan 0 0 0 2.3418052e-38\n";
        let Parsed { scan, grids } = parsed(text.as_bytes()).unwrap();
        assert!(grids.is_empty() && scan.sensors.is_empty());
        assert_eq!(scan.vertices.column("nx"), Some(&Column::F32(vec![0.5])));
        // 0x404050: written with five digits, as in PCL's tutorials.
        assert_eq!(scan.vertices.column("red"), Some(&Column::U8(vec![64])));
        let swapped = text.replace("nan", "1");
        let Parsed { scan, .. } = parsed(swapped.as_bytes()).unwrap();
        assert_eq!(
            scan.vertices.column("red"),
            Some(&Column::U8(vec![64, 255]))
        );
    }

    #[test]
    fn bad_files_are_named() {
        let ascii = String::from_utf8(ascii()).unwrap();
        for (from, to, part) in [
            ("POINTS 4", "POINTS 5", "WIDTH times HEIGHT"),
            (
                "WIDTH 2",
                "WIDTH 18446744073709551615",
                "WIDTH times HEIGHT",
            ),
            ("WIDTH 2", "WIDTH -2", "WIDTH needs"),
            ("SIZE 4 4 4 4 2 8 1", "SIZE 4", "do not fit"),
            ("SIZE 4", "SIZE 3", "TYPE F with SIZE 3"),
            ("COUNT 1", "COUNT 99999999999999999999", "COUNT needs"),
            ("COUNT 1", "COUNT 9999999", "more than the 4096"),
            ("DATA ascii", "DATA zip", "DATA is ascii"),
            ("DATA ascii", "DATAascii", "not an entry"),
            ("DATA ascii\n", "", "not an entry"),
            ("0 1 0.5", "0 b 0.5", "line 14: `b`"),
            ("7 1e9 -1 0 0 0", "7 1e9 -1 0 0", "line 12: it has 9"),
            ("0 1 0.5", "0 0 1 0.5", "line 14"),
            ("WIDTH 2\nHEIGHT 2", "WIDTH 4\nHEIGHT 5", "WIDTH times"),
            (
                "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 9 1 0 0 0\nPOINTS 4",
                "POINTS 5",
                "only 4 are there",
            ),
        ] {
            let text = ascii.replacen(from, to, 1);
            assert_ne!(text, ascii, "{from}");
            let error = parsed(text.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(part), "{to}: {error}");
        }
        let mut file = compressed();
        file.truncate(file.len() - 1);
        let error = parsed(&file).unwrap_err().to_string();
        assert!(error.contains("cut off"), "{error}");
    }

    #[test]
    fn whatever_the_bytes_there_is_a_scan_or_an_error() {
        for file in [ascii(), binary(), compressed()] {
            truncated(&file, parsed);
            damaged(&file, parsed);
        }
    }
}
