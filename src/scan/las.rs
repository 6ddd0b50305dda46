//! LAS, and compressed as LAZ: the points of airborne and mobile scanners.
//!
//! Besides coordinates and colours the properties that every LAS file has are channels if any point
//! has a value other than zero there. Properties that a program adds to them are channels too, under
//! the names that its record of extra bytes gives; values with a scale are `double`.
//!
//! Reference: ASPRS, *LAS Specification 1.4-R15*, tables 3 (header) and 7 to 17 (point formats).

#[cfg(feature = "las")]
mod laz;

use super::channel::Scalar;
use super::names;
use super::source::Source;
use super::text::table_of_doubles;
use super::{Channel, Column, Scan, ScanError};

/// Lengths of a point in the formats 0 to 10.
const LENGTHS: [usize; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];

/// First format whose points have 4 bits for the number of a return, and a whole byte of class.
const FIRST_EXTENDED: u8 = 6;

/// Degrees of a step of the scan angle in the extended formats.
const ANGLE_STEP: f32 = 0.006;

/// Reads a LAS or LAZ file.
pub(super) fn read(source: &Source) -> Result<Scan, ScanError> {
    let name = source.name;
    let header = Header::parse(source.bytes).map_err(|reason| ScanError::Malformed {
        name: name.to_owned(),
        reason,
    })?;
    let unpacked;
    let data = if header.is_compressed {
        unpacked = decompress(source.bytes, &header, name)?;
        &unpacked[..]
    } else {
        source.bytes.get(header.start..).unwrap_or_default()
    };
    let found = data.len() / header.length;
    if found < header.points {
        return Err(ScanError::Truncated {
            name: name.to_owned(),
            element: "points".to_owned(),
            found,
            expected: header.points,
        });
    }
    let mut scan = scan(&header, data);
    add_extra(&mut scan, &header, source, data);
    Ok(scan)
}

/// Adds the properties that are not of the standard, under names that no other channel has.
fn add_extra(scan: &mut Scan, header: &Header, source: &Source, data: &[u8]) {
    if header.length == LENGTHS[usize::from(header.format)] {
        return;
    }
    let (user, number) = extra_bytes::RECORD;
    let record = header.record(source.bytes, user, number);
    let points = Points { header, data };
    let record = record.unwrap_or_default();
    let (extra, left) = extra_bytes::channels(record, &points);
    if left > 0 {
        let name = source.name;
        log::warn!(
            "{name}: {left} bytes of each point are of no type that the file tells; left out"
        );
    }
    let channels = &mut scan.vertices.channels;
    channels.extend(extra);
    let names = channels.iter().map(|c| c.name.clone()).collect();
    for (channel, name) in channels.iter_mut().zip(names::unique(names)) {
        channel.name = name;
    }
}

#[cfg(feature = "las")]
fn decompress(file: &[u8], header: &Header, name: &str) -> Result<Vec<u8>, ScanError> {
    use laz;
    let fail = |reason: String| ScanError::Malformed {
        name: name.to_owned(),
        reason: format!("it is damaged or cut off ({reason})"),
    };
    let (user, number) = laz::RECORD;
    let record = header.record(file, user, number);
    let record = record.ok_or_else(|| fail("it has no record `laszip encoded`".to_owned()))?;
    let points = laz::Points {
        start: header.start,
        size: header.length,
        count: header.points,
    };
    laz::decompress(file, record, points).map_err(fail)
}

/// Says what this build lacks.
#[cfg(not(feature = "las"))]
fn decompress(_: &[u8], _: &Header, name: &str) -> Result<Vec<u8>, ScanError> {
    Err(ScanError::NotBuiltIn {
        name: name.to_owned(),
        format: "LAZ",
        feature: "las",
    })
}

/// What a header says.
#[derive(Debug)]
struct Header {
    format: u8,
    is_compressed: bool,
    /// Bytes of a point.
    length: usize,
    points: usize,
    /// Where the points begin.
    start: usize,
    /// Where the header ends and the records of variable length begin.
    end: usize,
    records: usize,
    scale: [f64; 3],
    offset: [f64; 3],
}

/// The bytes at a place, if they are there.
fn bytes_at<const N: usize>(file: &[u8], at: usize) -> Option<[u8; N]> {
    file.get(at..)?.first_chunk().copied()
}

impl Header {
    fn parse(file: &[u8]) -> Result<Self, String> {
        /// Length of the header since version 1.4.
        const LENGTH_1_4: usize = 375;
        let cut_off = || "it is cut off within its header".to_owned();
        let short = |at| {
            bytes_at(file, at)
                .map(u16::from_le_bytes)
                .ok_or_else(cut_off)
        };
        let word = |at| {
            bytes_at(file, at)
                .map(u32::from_le_bytes)
                .ok_or_else(cut_off)
        };
        let whole = |value: u32| usize::try_from(value).map_err(|_| cut_off());
        let doubles = |at: usize| {
            let mut values = [0.0; 3];
            for (k, value) in values.iter_mut().enumerate() {
                let bytes = bytes_at(file, at + 8 * k).ok_or_else(cut_off)?;
                *value = f64::from_le_bytes(bytes);
                if !value.is_finite() {
                    return Err("the scale of its coordinates is not finite".to_owned());
                }
            }
            Ok(values)
        };
        let [packed_format] = bytes_at(file, 104).ok_or_else(cut_off)?;
        // LAZ sets one of the two highest bits.
        let format = packed_format & 0x3f;
        let length = usize::from(short(105)?);
        let shortest = LENGTHS.get(usize::from(format));
        if shortest.is_none_or(|shortest| length < *shortest) {
            return Err(format!(
                "points of {length} bytes in format {format} are not of the standard"
            ));
        }
        let end = usize::from(short(94)?);
        let mut points = u64::from(word(107)?);
        if points == 0 && end >= LENGTH_1_4 {
            points = u64::from_le_bytes(bytes_at(file, 247).ok_or_else(cut_off)?);
        }
        Ok(Self {
            format,
            is_compressed: packed_format != format,
            length,
            points: usize::try_from(points).map_err(|_| cut_off())?,
            start: whole(word(96)?)?,
            end,
            records: whole(word(100)?)?,
            scale: doubles(131)?,
            offset: doubles(155)?,
        })
    }

    /// The content of the record of variable length with that user and number.
    fn record<'a>(&self, file: &'a [u8], user: &[u8], number: u16) -> Option<&'a [u8]> {
        /// Bytes of a record before its content.
        const HEAD: usize = 54;
        let mut at = self.end;
        for _ in 0..self.records {
            let head: [u8; HEAD] = bytes_at(file, at)?;
            let length = usize::from(u16::from_le_bytes([head[20], head[21]]));
            at += HEAD;
            if head[2..18].starts_with(user) && u16::from_le_bytes([head[18], head[19]]) == number {
                return file.get(at..at + length);
            }
            at += length;
        }
        None
    }

    fn is_extended(&self) -> bool {
        self.format >= FIRST_EXTENDED
    }

    /// Where a point has its GPS time.
    fn gps_time(&self) -> Option<usize> {
        match self.format {
            1 | 3..=5 => Some(20),
            FIRST_EXTENDED.. => Some(22),
            _ => None,
        }
    }

    /// Where a point has its colour.
    fn color(&self) -> Option<usize> {
        match self.format {
            2 => Some(20),
            3 | 5 => Some(28),
            7 | 8 | 10 => Some(30),
            _ => None,
        }
    }

    /// Where a point has its near infrared.
    fn near_infrared(&self) -> Option<usize> {
        matches!(self.format, 8 | 10).then_some(36)
    }
}

/// The points, one after the other in `data`, as a scan.
fn scan(header: &Header, data: &[u8]) -> Scan {
    let points = Points { header, data };
    let position = |p: &[u8]| {
        [0, 1, 2].map(|k| {
            let steps = bytes_at(p, 4 * k).map_or(0, i32::from_le_bytes);
            f64::from(steps) * header.scale[k] + header.offset[k]
        })
    };
    let positions: Vec<[f64; 3]> = points.each().map(position).collect();
    let mut table = table_of_doubles(["x", "y", "z"], &positions);
    if let Some(at) = header.color() {
        table.channels.extend(points.colors(at));
    }
    let gps_time = header.gps_time().map(|at| {
        let times = points.each().map(|p| bytes_at(p, at).unwrap_or_default());
        Column::F64(times.map(f64::from_le_bytes).collect())
    });
    let infrared = header.near_infrared().map(|at| points.shorts(at));
    let [return_number, returns, class, user_data, angle, source] = if header.is_extended() {
        let degrees = |p: &[u8]| bytes_at(p, 18).map_or(0, i16::from_le_bytes);
        let angles = points.each().map(|p| f32::from(degrees(p)) * ANGLE_STEP);
        [
            points.bytes(14, 0, 0xf),
            points.bytes(14, 4, 0xf),
            points.bytes(16, 0, 0xff),
            points.bytes(17, 0, 0xff),
            Column::F32(angles.collect()),
            points.shorts(20),
        ]
    } else {
        let degrees = |p: &[u8]| bytes_at(p, 16).map_or(0, i8::from_le_bytes);
        [
            points.bytes(14, 0, 0x7),
            points.bytes(14, 3, 0x7),
            points.bytes(15, 0, 0x1f),
            points.bytes(17, 0, 0xff),
            Column::I8(points.each().map(degrees).collect()),
            points.shorts(18),
        ]
    };
    for (name, values) in [
        ("intensity", Some(points.shorts(12))),
        ("nir", infrared),
        ("classification", Some(class)),
        ("return_number", Some(return_number)),
        ("number_of_returns", Some(returns)),
        ("scan_angle", Some(angle)),
        ("user_data", Some(user_data)),
        ("point_source_id", Some(source)),
        ("gps_time", gps_time),
    ] {
        let is_used = |v: &Column| (0..v.len()).any(|k| v.get_f64(k) != Some(0.0));
        if let Some(values) = values.filter(is_used) {
            let name = name.to_owned();
            table.channels.push(Channel { name, values });
        }
    }
    Scan {
        vertices: table,
        ..Scan::default()
    }
}

/// The points as the header describes them.
struct Points<'a> {
    header: &'a Header,
    data: &'a [u8],
}

impl Points<'_> {
    fn each(&self) -> impl Iterator<Item = &[u8]> {
        self.data
            .chunks_exact(self.header.length)
            .take(self.header.points)
    }

    /// The part of a byte of each point.
    fn bytes(&self, at: usize, shift: u32, mask: u8) -> Column {
        Column::U8(self.each().map(|p| (p[at] >> shift) & mask).collect())
    }

    fn shorts(&self, at: usize) -> Column {
        let values = self.each().map(|p| bytes_at(p, at).unwrap_or_default());
        Column::U16(values.map(u16::from_le_bytes).collect())
    }

    /// Red, green and blue; none if all are black. Many writers do not scale colours of 8 bits to
    /// 16, as the standard wants: if no value needs more, they are of 8 bits.
    fn colors(&self, at: usize) -> Vec<Channel> {
        let colors = [("red", 0), ("green", 2), ("blue", 4)]
            .map(|(name, offset)| (name, self.shorts(at + offset)));
        let values = |column: &Column| {
            let rows = 0..column.len();
            rows.filter_map(|k| column.get_f64(k)).fold(0.0, f64::max)
        };
        let largest = colors.iter().map(|(_, c)| values(c)).fold(0.0, f64::max);
        if largest <= 0.0 {
            return Vec::new();
        }
        let narrow = |column: Column| match column {
            Column::U16(values) if largest <= 255.0 => {
                let values = values.into_iter().map(|v| Scalar::rounded(v.into()));
                Column::U8(values.collect())
            }
            wide => wide,
        };
        colors
            .into_iter()
            .map(|(name, column)| Channel {
                name: name.to_owned(),
                values: narrow(column),
            })
            .collect()
    }
}

mod extra_bytes;

#[cfg(test)]
mod tests;
