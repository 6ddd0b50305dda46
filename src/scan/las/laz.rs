//! The compressed points of LAZ files.
//!
//! The crate `laz` decodes them, but trusts the sizes in the file, and panics on much of what is
//! damaged (its arithmetic decoder is written for speed). So sizes are checked here beforehand, and
//! what panics nevertheless is turned to an error.
//!
//! Such a panic still prints its message to standard error before ours: it is the hook of the whole
//! process that prints, and a library must not change that. All panics that damaged files were seen
//! to cause are assertions and overflows that only builds with debug assertions check, deep within
//! the arithmetic code, where nothing tells beforehand; builds without them decode such files to
//! other numbers, or to an error of the decoder.
//!
//! Reference: Rapidlasso, *`LASzip` specification*, 1.4 R1: chunks, layers, and the record of items.

use std::io::{Cursor, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};

use ::laz::{LasZipDecompressor, LazItemType, LazVlr};

/// User and number of the record that describes the compression.
pub(super) const RECORD: (&[u8], u16) = (b"laszip encoded", 22204);

/// Longest point that is read: its compression takes some kilobytes of memory for each byte. The
/// longest of the standard has 67 bytes, and some more for properties of its own.
const LONGEST_POINT: usize = 2048;

/// Most points for each byte of the file; compressed scans need two to four bytes a point.
const MOST_POINTS_PER_BYTE: usize = 256;

/// Points that are decoded before the next memory is taken.
const BATCH: usize = 4096;

/// Kind of compression that stores the properties of a chunk's points in layers.
const LAYERED: u16 = 3;

/// What is known about the points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Points {
    /// Where their data begin in the file.
    pub(super) start: usize,
    /// Bytes of each.
    pub(super) size: usize,
    pub(super) count: usize,
}

/// Decodes the points of a file as a LAS file would have them; `record` describes the compression.
pub(super) fn decompress(file: &[u8], record: &[u8], points: Points) -> Result<Vec<u8>, String> {
    if points.size > LONGEST_POINT {
        return Err(format!(
            "its points have {} bytes, more than the {LONGEST_POINT} that relievo reads compressed",
            points.size
        ));
    }
    if points.count > file.len().saturating_mul(MOST_POINTS_PER_BYTE) {
        return Err("it promises more points than it can hold".to_owned());
    }
    let decoded = catch_unwind(AssertUnwindSafe(|| decode(file, record, points)));
    decoded.unwrap_or_else(|_| Err("its compressed points make no sense".to_owned()))
}

fn decode(file: &[u8], record: &[u8], points: Points) -> Result<Vec<u8>, String> {
    let vlr = LazVlr::from_buffer(record).map_err(|e| e.to_string())?;
    if vlr.items_size() != points.size as u64 {
        return Err("its points are not as long as their compression says".to_owned());
    }
    let kind = record.first_chunk().map(|b| u16::from_le_bytes(*b));
    check_chunk_table(file, points.start)?;
    if kind == Some(LAYERED) {
        check_layers(file, &vlr, points)?;
    }
    let mut cursor = Cursor::new(file);
    let start = SeekFrom::Start(points.start as u64);
    cursor.seek(start).map_err(|e| e.to_string())?;
    let mut decoder = LasZipDecompressor::new(cursor, vlr).map_err(|e| e.to_string())?;
    let mut out = Vec::new();
    let mut left = points.count;
    while left > 0 {
        let batch = left.min(BATCH);
        let at = out.len();
        out.resize(at + batch * points.size, 0);
        let done = decoder.decompress_many(&mut out[at..]);
        done.map_err(|e| format!("its compressed points end early: {e}"))?;
        left -= batch;
    }
    Ok(out)
}

fn word(file: &[u8], at: usize) -> Option<usize> {
    let bytes = file.get(at..)?.first_chunk()?;
    usize::try_from(u32::from_le_bytes(*bytes)).ok()
}

/// The table of chunks takes memory for as many as it says.
fn check_chunk_table(file: &[u8], start: usize) -> Result<(), String> {
    let place = |at: usize| {
        let bytes = file.get(at..)?.first_chunk()?;
        // Writers that could not go back leave -1 here, and the place at the end of the file.
        let place = usize::try_from(i64::from_le_bytes(*bytes)).ok();
        place.filter(|p| *p > start)
    };
    let table = place(start).or_else(|| place(file.len().checked_sub(8)?));
    // Without a table there is nothing to check: the decoder goes without, or refuses.
    let chunks = table.and_then(|at| word(file, at.checked_add(4)?));
    match chunks {
        // The first point of each chunk is stored as it is, in no less than 20 bytes.
        Some(chunks) if chunks > file.len() / 20 => {
            Err("its table of chunks is longer than the file".to_owned())
        }
        _ => Ok(()),
    }
}

/// The layers of a chunk take memory as their sizes say; these follow the chunk's first point and
/// its number of points.
fn check_layers(file: &[u8], vlr: &LazVlr, points: Points) -> Result<(), String> {
    let layers: usize = vlr
        .items()
        .iter()
        .map(|item| match item.item_type() {
            LazItemType::Point14 => 9,
            LazItemType::RGBNIR14 => 2,
            LazItemType::RGB14 | LazItemType::WavePacket14 => 1,
            LazItemType::Byte14(count) => usize::from(count),
            _ => 0,
        })
        .sum();
    let cut_off = || "its compressed points are cut off".to_owned();
    let mut at = points.start.saturating_add(8);
    let mut left = points.count;
    while left > 0 {
        let sizes = at.saturating_add(points.size + 4);
        let in_chunk = word(file, sizes - 4).ok_or_else(cut_off)?;
        let mut end = sizes + 4 * layers;
        for layer in 0..layers {
            let size = word(file, sizes + 4 * layer).ok_or_else(cut_off)?;
            end = end.saturating_add(size);
        }
        if end > file.len() {
            return Err(cut_off());
        }
        if in_chunk == 0 {
            return Err("one of its chunks has no points".to_owned());
        }
        left = left.saturating_sub(in_chunk);
        at = end;
    }
    Ok(())
}
