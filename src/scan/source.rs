//! What readers are given, and what they give.

use std::ops::Range;
use std::path::Path;

use super::range_grid::Grid;
use super::{Column, ReadOptions, Scan};

/// A file that is to be read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source<'a> {
    /// All of it.
    pub(super) bytes: &'a [u8],
    /// Stands for it in messages.
    pub(super) name: &'a str,
    /// Where files are that it refers to; `None` if they must not be looked for.
    pub(super) folder: Option<&'a Path>,
    pub(super) options: &'a ReadOptions,
}

/// What was read, before it is checked and its grids are triangulated.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    pub(super) scan: Scan,
    pub(super) grids: Vec<Grid>,
}

impl Parsed {
    /// Gives the vertices a channel `scan` with the index, from 0, of the scan that they are of, if
    /// there are several; each of them has the next rows.
    pub(super) fn tell_scans_apart(&mut self, scans: &[Range<usize>]) {
        if scans.len() < 2 {
            return;
        }
        let mut column = if u16::try_from(scans.len()).is_ok() {
            Column::U16(Vec::new())
        } else {
            Column::U32(Vec::new())
        };
        for (index, rows) in (0_u32..).zip(scans) {
            for _ in rows.clone() {
                column.push_rounded(index.into());
            }
        }
        self.scan.vertices.set_channel("scan", column);
    }
}

impl From<Scan> for Parsed {
    fn from(scan: Scan) -> Self {
        Self {
            scan,
            grids: Vec::new(),
        }
    }
}
