//! What the tests of readers share: damaging files.

use super::range_grid;
use super::source::{Parsed, Source};
use super::{ReadOptions, ScanError};
use crate::rng::{Rng, Stage};

pub(super) fn source<'a>(bytes: &'a [u8], options: &'a ReadOptions) -> Source<'a> {
    Source {
        bytes,
        name: "a",
        folder: None,
        options,
    }
}

/// Whether a reader gave an error, or a scan that passes the check and whose grids can be used.
fn holds(parsed: Result<Parsed, ScanError>) {
    let Ok(Parsed { mut scan, grids }) = parsed else {
        return;
    };
    if scan.check("a").is_err() {
        return;
    }
    let vertices = scan.vertices.rows;
    for channel in &scan.vertices.channels {
        assert_eq!(channel.values.len(), vertices, "{}", channel.name);
    }
    for sensor in &scan.sensors {
        assert!(sensor.vertices.end <= vertices, "{sensor:?}");
        assert!(sensor.position.iter().all(|v| v.is_finite()), "{sensor:?}");
    }
    for cell in grids.iter().flat_map(|g| &g.cells).flatten() {
        assert!((*cell as usize) < vertices);
    }
    range_grid::triangulate(&mut scan, grids, "a").unwrap();
    assert!(scan.check("a").is_ok());
}

/// Cuts a file off at every byte.
pub(super) fn truncated(file: &[u8], read: impl Fn(&[u8]) -> Result<Parsed, ScanError>) {
    for end in 0..=file.len() {
        holds(read(&file[..end]));
    }
}

/// Damages one to four bytes of a file, many times.
pub(super) fn damaged(file: &[u8], read: impl Fn(&[u8]) -> Result<Parsed, ScanError>) {
    let mut rng = Rng::new(1, Stage::Synth, 0);
    let mut bytes = file.to_vec();
    for _ in 0..4000 {
        bytes.copy_from_slice(file);
        for _ in 0..=rng.index(4) {
            let at = rng.index(file.len());
            // Half of the time a byte from elsewhere in the file, which text readers take further.
            bytes[at] = if rng.index(2) == 0 {
                file[rng.index(file.len())]
            } else {
                u8::try_from(rng.index(256)).unwrap()
            };
        }
        holds(read(&bytes));
    }
}
