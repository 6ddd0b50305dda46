//! All candidates' neighborhoods in the order in which a search reads them.

use std::ops::Range;

use rayon::prelude::*;

use crate::neighborhood::{Descriptor, Mask};

/// Candidates of a block: their values at one offset and channel fill a cache line.
pub(super) const LANES: usize = 16;

/// Blocks of a tile: their rows at one offset and channel fill a page of memory.
pub(super) const TILE: usize = 64;

/// The values of a block's candidates at one offset and channel.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Row(pub(super) [f32; LANES]);

impl Row {
    pub(super) const ZERO: Self = Self([0.0; LANES]);
}

/// The descriptors of all candidates, arranged for [`exhaustive`](super::exhaustive) search.
///
/// A candidate is a sample neighborhood at one rotation; what its number means is the caller's.
/// Candidates are kept in blocks of 16 and blocks in tiles of 64. A tile is J·C runs of memory, each
/// with the values of its 1024 candidates at one offset and channel: a search reads on and on what
/// its query knows and what its candidates begin with, and skips the rest.
#[derive(Debug, Clone)]
pub struct Table {
    len: usize,
    channels: usize,
    weights: Vec<f32>,
    /// Tiles by offsets by channels by blocks of the tile, which are 64 but in the last tile.
    rows: Vec<Row>,
    /// Words of the masks: blocks by words of a mask by 16.
    known: Vec<[u64; LANES]>,
    /// What the masks of a block have in common: blocks by words of a mask.
    common: Vec<Common>,
}

/// One word of a block's masks, summed up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Common {
    /// Offsets known in all candidates of the block.
    pub(super) all: u64,
    /// Offsets known in any of them.
    pub(super) any: u64,
}

impl Table {
    /// Describes `candidates` candidates with `channels` values at each offset; `weights` are the
    /// J offsets' own, heaviest first if searches are to end early.
    ///
    /// `describe` gets the number of a candidate and a cleared descriptor to fill, from any thread
    /// and in any order. What it leaves at unknown offsets is not stored.
    ///
    /// # Panics
    /// If there are no offsets or channels, a weight is not positive and finite, there are 2³²
    /// candidates or more, or `describe` changes the descriptor's shape.
    #[must_use]
    pub fn build(
        candidates: usize,
        channels: usize,
        weights: &[f32],
        describe: impl Fn(usize, &mut Descriptor) + Sync,
    ) -> Self {
        let offsets = weights.len();
        assert!(offsets > 0 && channels > 0, "nothing to compare");
        assert!(u32::try_from(candidates).is_ok(), "candidates are u32");
        let positive = |w: &f32| *w > 0.0 && w.is_finite();
        assert!(weights.iter().all(positive), "weights must be positive");
        let blocks = candidates.div_ceil(LANES);
        let words = Mask::words_for(offsets);
        let stride = offsets * channels;
        let mut rows = vec![Row::ZERO; blocks * stride];
        let mut known = vec![[0; LANES]; blocks * words];
        (rows.par_chunks_mut(TILE * stride))
            .zip(known.par_chunks_mut(TILE * words))
            .enumerate()
            .for_each_init(
                || (Descriptor::new(offsets, channels), vec![Row::ZERO; stride]),
                |(scratch, block), (tile, (rows, known))| {
                    let width = rows.len() / stride;
                    for (b, known) in known.chunks_mut(words).enumerate() {
                        let first = (tile * TILE + b) * LANES;
                        block.fill(Row::ZERO);
                        for lane in 0..LANES.min(candidates - first) {
                            scratch.clear();
                            describe(first + lane, scratch);
                            store(scratch, lane, channels, block, known);
                        }
                        for (run, row) in rows.chunks_mut(width).zip(&*block) {
                            run[b] = *row;
                        }
                    }
                },
            );
        let common = known.iter().map(Common::of).collect();
        Self {
            len: candidates,
            channels,
            weights: weights.to_vec(),
            rows,
            known,
            common,
        }
    }

    /// Memory that a table of this size takes, in bytes.
    #[must_use]
    pub fn bytes(candidates: usize, offsets: usize, channels: usize) -> usize {
        let product =
            |factors: &[usize]| factors.iter().fold(1, |p: usize, f| p.saturating_mul(*f));
        let blocks = candidates.div_ceil(LANES);
        let words = Mask::words_for(offsets);
        product(&[blocks, offsets, channels, size_of::<Row>()])
            .saturating_add(product(&[blocks, words, size_of::<[u64; LANES]>()]))
            .saturating_add(product(&[blocks, words, size_of::<Common>()]))
            .saturating_add(product(&[offsets, size_of::<f32>()]))
    }

    /// Number of candidates.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no candidates.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number J of offsets of the stencil.
    #[must_use]
    pub fn offsets(&self) -> usize {
        self.weights.len()
    }

    /// Number C of values at each offset.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Weights of the J offsets.
    #[must_use]
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// A candidate's descriptor, as it was given (0 at unknown offsets).
    ///
    /// # Panics
    /// If there is no such candidate.
    #[must_use]
    pub fn descriptor(&self, candidate: u32) -> Descriptor {
        let candidate = candidate as usize;
        assert!(candidate < self.len, "no such candidate");
        let (block, lane) = (candidate / LANES, candidate % LANES);
        let mut descriptor = Descriptor::new(self.offsets(), self.channels);
        let (tile, b) = (self.tile(block / TILE), block % TILE);
        for (row, value) in descriptor.values.iter_mut().enumerate() {
            *value = tile.run(row)[b].0[lane];
        }
        let known = self.known(block);
        for j in 0..self.offsets() {
            let word = known[j / u64::BITS as usize][lane];
            if word >> (j % u64::BITS as usize) & 1 == 1 {
                descriptor.known.set(j);
            }
        }
        descriptor
    }

    /// Number of blocks, the last of which may have lanes that are no candidates (nothing is known
    /// there).
    fn blocks(&self) -> usize {
        self.len.div_ceil(LANES)
    }

    /// Number of tiles.
    pub(super) fn tiles(&self) -> usize {
        self.blocks().div_ceil(TILE)
    }

    /// The blocks of a tile.
    pub(super) fn blocks_of(&self, tile: usize) -> Range<usize> {
        tile * TILE..self.blocks().min((tile + 1) * TILE)
    }

    /// Values of a tile's blocks.
    #[inline(always)]
    pub(super) fn tile(&self, tile: usize) -> Tile<'_> {
        let stride = self.weights.len() * self.channels;
        let width = self.blocks_of(tile).len();
        Tile {
            rows: &self.rows[tile * TILE * stride..][..width * stride],
            width,
        }
    }

    /// The words of a block's masks.
    #[inline(always)]
    pub(super) fn known(&self, block: usize) -> &[[u64; LANES]] {
        let words = Mask::words_for(self.weights.len());
        &self.known[block * words..][..words]
    }

    /// The words of a block's masks, summed up.
    #[inline(always)]
    pub(super) fn common(&self, block: usize) -> &[Common] {
        let words = Mask::words_for(self.weights.len());
        &self.common[block * words..][..words]
    }
}

/// Values of up to 64 blocks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tile<'a> {
    rows: &'a [Row],
    width: usize,
}

impl<'a> Tile<'a> {
    /// A row of all blocks.
    #[inline(always)]
    pub(super) fn run(&self, row: usize) -> &'a [Row] {
        &self.rows[row * self.width..][..self.width]
    }
}

impl Common {
    fn of(lanes: &[u64; LANES]) -> Self {
        Self {
            all: lanes.iter().fold(u64::MAX, |all, word| all & word),
            any: lanes.iter().fold(0, |any, word| any | word),
        }
    }
}

/// Copies the known values of a descriptor into a lane of a block of zeros.
fn store(
    descriptor: &Descriptor,
    lane: usize,
    channels: usize,
    rows: &mut [Row],
    known: &mut [[u64; LANES]],
) {
    assert!(
        descriptor.values.len() == rows.len() && descriptor.known.words().len() == known.len(),
        "the shape of a descriptor is the table's"
    );
    for j in descriptor.known.iter() {
        let values = j * channels..(j + 1) * channels;
        for (row, value) in (rows[values.clone()].iter_mut()).zip(&descriptor.values[values]) {
            row.0[lane] = *value;
        }
    }
    for (lanes, word) in known.iter_mut().zip(descriptor.known.words()) {
        lanes[lane] = *word;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn odd_only(candidate: usize, descriptor: &mut Descriptor) {
        descriptor.values.fill(f32::NAN);
        for j in (1..descriptor.values.len() / 2).step_by(2) {
            descriptor.known.set(j);
            descriptor.values[2 * j] = candidate as f32;
            descriptor.values[2 * j + 1] = j as f32;
        }
    }

    #[test]
    fn candidates_come_back_without_what_stood_at_unknown_offsets() {
        let table = Table::build(37, 2, &[1.0; 70], odd_only);
        assert_eq!(
            (table.len(), table.offsets(), table.channels()),
            (37, 70, 2)
        );
        for candidate in 0..37 {
            let descriptor = table.descriptor(candidate);
            for j in 0..70 {
                let expected = match j % 2 {
                    1 => [candidate as f32, j as f32],
                    _ => [0.0; 2],
                };
                assert_eq!(descriptor.values[2 * j..2 * j + 2], expected);
                assert_eq!(descriptor.known.get(j), j % 2 == 1);
            }
        }
    }

    #[test]
    fn memory_is_foretold_to_the_byte() {
        for (candidates, offsets, channels) in [(0, 1, 1), (1, 81, 1), (1061, 70, 2), (64, 128, 4)]
        {
            let table = Table::build(candidates, channels, &vec![1.0; offsets], |_, _| {});
            let taken = size_of::<f32>() * table.weights.capacity()
                + size_of::<Row>() * table.rows.capacity()
                + size_of::<[u64; LANES]>() * table.known.capacity()
                + size_of::<Common>() * table.common.capacity();
            assert_eq!(taken, Table::bytes(candidates, offsets, channels));
        }
        assert_eq!(Table::bytes(usize::MAX, usize::MAX, 4), usize::MAX);
    }

    #[test]
    #[should_panic(expected = "positive")]
    fn a_weight_of_zero_is_refused() {
        let _ = Table::build(1, 1, &[1.0, 0.0], |_, _| {});
    }
}
