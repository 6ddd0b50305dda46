//! Faces that are there twice.

use super::Work;

/// Removes every face whose corners lie where those of an earlier one do, in whatever order. Gives their
/// number.
pub(super) fn remove(work: &mut Work, places: &[u32]) -> usize {
    let mut keyed: Vec<(u64, u32)> = work
        .left()
        .map(|f| (key(&sorted_places(work, f, places)), f))
        .collect();
    keyed.sort_unstable();
    let mut removed = Vec::new();
    for group in keyed.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() > 1) {
        // Faces of the same key may still differ.
        let mut rows: Vec<(Vec<u32>, u32)> = group
            .iter()
            .map(|(_, f)| (sorted_places(work, *f, places), *f))
            .collect();
        rows.sort_unstable();
        for same in rows.chunk_by(|a, b| a.0 == b.0) {
            removed.extend(same[1..].iter().map(|(_, f)| *f));
        }
    }
    for f in &removed {
        work.kept[*f as usize] = false;
    }
    removed.len()
}

fn sorted_places(work: &Work, f: u32, places: &[u32]) -> Vec<u32> {
    let mut row: Vec<u32> = work.corners(f).map(|v| places[v as usize]).collect();
    row.sort_unstable();
    row
}

/// Fowler, Noll & Vo's hash (FNV-1a) of the numbers: always the same, unlike those of the standard library.
fn key(row: &[u32]) -> u64 {
    let bytes = row.iter().flat_map(|v| v.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
