//! The cheapest candidates of a table, all of them compared.
//!
//! A query with the offsets Q known costs at a candidate
//!
//! ```text
//! Σ_{j ∈ Q} w_j Σ_c (q_jc − s_jc)²  /  Σ_{j ∈ Q} w_j
//! ```
//!
//! if the candidate knows all of Q; otherwise it is not *viable*. Sums are formed in `f32`, offset
//! after offset and channel after channel, by separate subtractions, multiplications and additions,
//! for 16 candidates side by side: costs are the same to the last bit on every machine and for any
//! number of threads.
//!
//! # Reference
//! [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), §3: the sum of squared
//! differences over the known neighbors, normalised, and the set of matches near the best one.
//! Leaving a candidate as soon as its partial sum is too high: C.-D. Bei, R. M. Gray, *An improvement
//! of the minimum distortion encoding algorithm for vector quantization*, IEEE Transactions on
//! Communications 33(10), 1132–1133, 1985.

use std::cell::Cell;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use pulp::Arch;
use rayon::prelude::*;

use crate::neighborhood::Descriptor;

use super::table::{LANES, Row, TILE, Table, Tile};

/// Tiles that one task of a parallel search reads.
const TASK: usize = 4;

/// Queries that are compared with a tile while it is in the processor's cache.
const BATCH: usize = 64;

/// Values of a query that are compared between two looks at which blocks can still hold a match.
const STAGE: usize = 6;

/// How to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Matches that cost at most (1 + tolerance) times the best are returned; at least 0.
    pub tolerance: f32,
    /// Matches that cost more than this are not returned; infinite by default.
    pub budget: f32,
    /// Whether to search on all threads. Leave it off (as by default) where several searches run
    /// side by side.
    pub parallel: bool,
}

impl Default for Search {
    fn default() -> Self {
        Self {
            tolerance: 0.0,
            budget: f32::INFINITY,
            parallel: false,
        }
    }
}

/// A candidate to copy from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Its number in the table.
    pub candidate: u32,
    /// Weighted mean of squared differences, in the square of the values' unit.
    pub cost: f32,
}

/// What to look for.
#[derive(Debug, Clone, Copy)]
pub struct Query<'a> {
    /// The neighborhood, partly known.
    pub descriptor: &'a Descriptor,
    /// Candidates to look at first, so that dear ones are dropped earlier. They do not change the
    /// result.
    pub likely: &'a [u32],
}

/// All viable candidates within the tolerance of the cheapest one and within the budget, ascending
/// by number; empty if there are none, or nothing is known in the query.
///
/// Neither `likely` (see [`Query`]) nor the number of threads change the result. Candidates with a
/// cost that is not finite are never found.
///
/// # Panics
/// If the query's shape is not the table's, the tolerance is negative or NaN, or a likely candidate
/// does not exist.
#[must_use]
pub fn best_matches(
    table: &Table,
    query: &Descriptor,
    search: &Search,
    likely: &[u32],
) -> Vec<Found> {
    let query = Query {
        descriptor: query,
        likely,
    };
    let mut found = best_matches_of_all(table, &[query], search);
    found.pop().expect("there is a list for each query")
}

/// [`best_matches`] of each of several queries.
///
/// They share what is read of a table, which is faster than one after the other where the table is
/// larger than the processor's caches.
///
/// # Panics
/// As [`best_matches`].
#[must_use]
pub fn best_matches_of_all(
    table: &Table,
    queries: &[Query<'_>],
    search: &Search,
) -> Vec<Vec<Found>> {
    assert!(
        search.tolerance >= 0.0 && !search.budget.is_nan(),
        "a tolerance is not negative"
    );
    (queries.chunks(BATCH))
        .flat_map(|batch| best_matches_of_batch(table, batch, search))
        .collect()
}

fn best_matches_of_batch(table: &Table, batch: &[Query<'_>], search: &Search) -> Vec<Vec<Found>> {
    let hunts: Vec<Hunt<'_>> = (batch.iter())
        .map(|query| Hunt::new(table, query, search))
        .collect();
    let collect = |tiles: Range<usize>| {
        let mut found = vec![Vec::new(); hunts.len()];
        let mut front = Front::new();
        for tile in tiles {
            for (hunt, found) in hunts.iter().zip(&mut found) {
                hunt.search(&mut front, tile, found);
            }
        }
        found
    };
    let tiles = table.tiles();
    let parts: Vec<Vec<Vec<Found>>> = if search.parallel {
        (0..tiles.div_ceil(TASK))
            .into_par_iter()
            .map(|i| collect(i * TASK..tiles.min((i + 1) * TASK)))
            .collect()
    } else {
        vec![collect(0..tiles)]
    };
    (hunts.iter().enumerate())
        .map(|(i, hunt)| hunt.best(parts.iter().flat_map(|part| &part[i])))
        .collect()
}

/// The search for the best matches of one query.
struct Hunt<'a> {
    scan: Scan<'a>,
    limit: Limit,
    budget: f32,
    /// What matches may cost in units of the best one.
    slack: f32,
}

impl<'a> Hunt<'a> {
    fn new(table: &'a Table, query: &Query<'a>, search: &Search) -> Self {
        let scan = Scan::new(table, query.descriptor);
        let hunt = Self {
            limit: Limit::new(scan.sum_limit(search.budget)),
            scan,
            budget: search.budget,
            slack: 1.0 + search.tolerance,
        };
        let mut front = Front::new();
        for candidate in query.likely {
            assert!((*candidate as usize) < table.len(), "no such candidate");
            let block = *candidate as usize / LANES;
            (hunt.scan).blocks(&mut front, block..block + 1, &hunt.limit, |_, cost| {
                hunt.offer(cost);
            });
        }
        hunt
    }

    fn search(&self, front: &mut Front, tile: usize, found: &mut Vec<Found>) {
        let blocks = self.scan.table.blocks_of(tile);
        (self.scan).blocks(front, blocks, &self.limit, |candidate, cost| {
            self.offer(cost);
            found.push(Found { candidate, cost });
        });
    }

    fn offer(&self, cost: f32) {
        self.limit.lower_to(self.scan.sum_limit(self.slack * cost));
    }

    /// Those of all found that match.
    fn best<'f>(&self, found: impl Iterator<Item = &'f Found> + Clone) -> Vec<Found> {
        let best = found
            .clone()
            .fold(f32::INFINITY, |best, f| best.min(f.cost));
        let dearest = self.budget.min(self.slack * best);
        found.filter(|f| f.cost <= dearest).copied().collect()
    }
}

/// The `k` cheapest viable candidates, ascending by cost, then by number; fewer if fewer are viable.
///
/// # Panics
/// If the query's shape is not the table's.
#[must_use]
pub fn nearest(table: &Table, query: &Descriptor, k: usize) -> Vec<Found> {
    let scan = Scan::new(table, query);
    if scan.terms.is_empty() || k == 0 {
        return Vec::new();
    }
    let limit = Cell::new(f32::INFINITY);
    let mut found: Vec<Found> = Vec::new();
    let mut front = Front::new();
    let mut insert = |candidate, cost| {
        // Candidates come in ascending order, so that equal ones go behind.
        let place = found.partition_point(|f| f.cost <= cost);
        if place < k {
            found.truncate(k - 1);
            found.insert(place, Found { candidate, cost });
        }
        if let Some(last) = found.get(k - 1) {
            limit.set(scan.sum_limit(last.cost));
        }
    };
    for tile in 0..table.tiles() {
        scan.blocks(&mut front, table.blocks_of(tile), &limit, &mut insert);
    }
    found
}

/// Cost of one candidate, to the bit what a search finds; `None` if it is not viable, or nothing is
/// known in the query.
///
/// # Panics
/// If the query's shape is not the table's, or there is no such candidate.
#[must_use]
pub fn cost(table: &Table, query: &Descriptor, candidate: u32) -> Option<f32> {
    assert!((candidate as usize) < table.len(), "no such candidate");
    let scan = Scan::new(table, query);
    let (block, lane) = (candidate as usize / LANES, candidate as usize % LANES);
    let known = table.known(block).iter().map(|lanes| lanes[lane]);
    if scan.terms.is_empty()
        || known
            .zip(scan.mask)
            .any(|(known, asked)| asked & !known != 0)
    {
        return None;
    }
    let (tile, b) = (table.tile(block / TILE), block % TILE);
    let sum = (scan.terms.iter()).fold(0.0, |sum, term| {
        sum + term.of(tile.run(term.row as usize)[b].0[lane])
    });
    Some(sum / scan.total)
}

/// Highest weighted sum that still matters.
trait SumLimit {
    fn get(&self) -> f32;
}

impl SumLimit for Cell<f32> {
    #[inline(always)]
    fn get(&self) -> f32 {
        self.get()
    }
}

/// A limit that threads share.
struct Limit {
    /// The bits of a nonnegative float, which are ordered as it is.
    bits: AtomicU32,
}

impl Limit {
    fn new(limit: f32) -> Self {
        Self {
            bits: AtomicU32::new(limit.to_bits()),
        }
    }

    fn lower_to(&self, limit: f32) {
        self.bits.fetch_min(limit.to_bits(), Ordering::Relaxed);
    }
}

impl SumLimit for Limit {
    #[inline(always)]
    fn get(&self) -> f32 {
        f32::from_bits(self.bits.load(Ordering::Relaxed))
    }
}

/// A value of the query, with what it is compared to.
#[derive(Debug, Clone, Copy)]
struct Term {
    /// Row in every block.
    row: u32,
    weight: f32,
    value: f32,
}

impl Term {
    /// What a candidate with `value` there contributes to the weighted sum.
    #[inline(always)]
    fn of(&self, value: f32) -> f32 {
        let difference = self.value - value;
        self.weight * (difference * difference)
    }
}

/// The blocks of a tile that can still hold a match.
struct Front {
    /// Sums so far, by block; infinite for candidates that are not viable.
    sums: [Row; TILE],
    /// Numbers of the blocks in the tile, ascending.
    alive: [u8; TILE],
    len: usize,
}

impl Front {
    fn new() -> Self {
        Self {
            sums: [Row::ZERO; TILE],
            alive: [0; TILE],
            len: 0,
        }
    }

    /// Adds some terms to the sums and drops the blocks with all sums above the limit.
    #[inline(always)]
    fn advance<const N: usize>(&mut self, tile: &Tile<'_>, terms: &[Term; N], limit: f32) {
        let runs = terms.map(|term| tile.run(term.row as usize));
        let mut len = 0;
        for i in 0..self.len {
            let block = self.alive[i] as usize % TILE;
            let mut sums = self.sums[block];
            for (term, run) in terms.iter().zip(runs) {
                for (sum, value) in sums.0.iter_mut().zip(run[block].0) {
                    *sum += term.of(value);
                }
            }
            self.sums[block] = sums;
            // No branch: whether a block survives is hard to foresee.
            self.alive[len] = self.alive[i];
            let survives = sums.0.iter().fold(false, |any, sum| any | (*sum <= limit));
            len += usize::from(survives);
        }
        self.len = len;
    }

    fn survivors(&self) -> impl Iterator<Item = (usize, &Row)> {
        let alive = &self.alive[..self.len];
        alive.iter().map(|b| (*b as usize, &self.sums[*b as usize]))
    }
}

/// A query made ready for a table.
struct Scan<'a> {
    table: &'a Table,
    mask: &'a [u64],
    /// By row, hence heaviest first.
    terms: Vec<Term>,
    /// Sum of the known offsets' weights.
    total: f32,
}

impl<'a> Scan<'a> {
    fn new(table: &'a Table, query: &'a Descriptor) -> Self {
        let channels = table.channels();
        assert!(
            query.values.len() == table.offsets() * channels,
            "the shape of a query is the table's"
        );
        let mut terms = Vec::with_capacity(query.known.count() * channels);
        let mut total = 0.0;
        for j in query.known.iter() {
            let weight = table.weights()[j];
            total += weight;
            terms.extend((j * channels..(j + 1) * channels).map(|row| Term {
                row: u32::try_from(row).expect("rows of a block are u32"),
                weight,
                value: query.values[row],
            }));
        }
        Self {
            table,
            mask: query.known.words(),
            terms,
            total,
        }
    }

    /// A weighted sum that no candidate exceeds that costs at most `cost`.
    #[expect(clippy::cast_possible_truncation, reason = "rounded up")]
    fn sum_limit(&self, cost: f32) -> f32 {
        // A cost is a rounded quotient: the sum is at most half a unit of the cost's last digit
        // more than the product says, and the smallest unit there is at costs near 0.
        let cost = f64::from(cost.next_up());
        ((cost * f64::from(self.total)) as f32).next_up()
    }

    /// Calls `found` for every candidate of `blocks`, all of one tile, with a sum within the limit.
    fn blocks(
        &self,
        front: &mut Front,
        blocks: Range<usize>,
        limit: &impl SumLimit,
        mut found: impl FnMut(u32, f32),
    ) {
        if self.terms.is_empty() {
            return;
        }
        let tile = blocks.start / TILE;
        let first = tile * TILE;
        Arch::new().dispatch(
            #[inline(always)]
            || {
                self.enter(front, first, blocks);
                self.run(front, &self.table.tile(tile), limit.get());
            },
        );
        for (block, sums) in front.survivors() {
            self.report(first + block, sums, limit.get(), &mut found);
        }
    }

    /// Calls `found` for the candidates of a block with a sum within the limit.
    fn report(&self, block: usize, sums: &Row, limit: f32, found: &mut impl FnMut(u32, f32)) {
        for (lane, sum) in sums.0.into_iter().enumerate() {
            if sum <= limit && sum < f32::INFINITY {
                #[expect(clippy::cast_possible_truncation, reason = "candidates are u32")]
                let candidate = (block * LANES + lane) as u32;
                found(candidate, sum / self.total);
            }
        }
    }

    /// Starts a tile with those of `blocks` that have a viable candidate.
    #[inline(always)]
    fn enter(&self, front: &mut Front, first: usize, blocks: Range<usize>) {
        front.len = 0;
        for block in blocks {
            if let Some(sums) = self.viable(block) {
                front.sums[block - first] = sums;
                #[expect(clippy::cast_possible_truncation, reason = "a tile has 64 blocks")]
                let block = (block - first) as u8;
                front.alive[front.len] = block;
                front.len += 1;
            }
        }
    }

    /// Sums up a tile's differences until no block is left or all are summed.
    #[inline(always)]
    fn run(&self, front: &mut Front, tile: &Tile<'_>, limit: f32) {
        let (stages, rest) = self.terms.as_chunks::<STAGE>();
        for stage in stages {
            if front.len == 0 {
                return;
            }
            front.advance(tile, stage, limit);
        }
        for term in rest {
            front.advance(tile, &[*term], limit);
        }
    }

    /// 0 for the candidates of a block that know all that the query knows, infinity for the others;
    /// `None` if none does.
    #[inline(always)]
    fn viable(&self, block: usize) -> Option<Row> {
        let common = self.table.common(block);
        let (mut lacking_in_all, mut lacking_in_any) = (0, 0);
        for (asked, common) in self.mask.iter().zip(common) {
            lacking_in_all |= asked & !common.any;
            lacking_in_any |= asked & !common.all;
        }
        if lacking_in_all != 0 {
            return None;
        }
        let mut sums = Row::ZERO;
        if lacking_in_any != 0 {
            let mut lacking = [0; LANES];
            for (asked, known) in self.mask.iter().zip(self.table.known(block)) {
                for (lacking, known) in lacking.iter_mut().zip(known) {
                    *lacking |= asked & !known;
                }
            }
            for (sum, lacking) in sums.0.iter_mut().zip(lacking) {
                if lacking != 0 {
                    *sum = f32::INFINITY;
                }
            }
        }
        Some(sums)
    }
}

#[cfg(test)]
mod tests;
