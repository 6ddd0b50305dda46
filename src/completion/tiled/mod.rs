//! A scan completed in tiles, each of which fits into the memory of a worker.
//!
//! What must be the same everywhere is chosen once, by a [`TilePlan`]: base surface, holes, targets, window,
//! rotations, thresholds. Targets are then divided; a tile has its own targets, what surrounds them (the overlap), and
//! as much of the scan to copy from as it has room for. A tile only grows its own targets. What other tiles have grown
//! before counts as known, with where it was copied from, so that coherent search continues their patches across the
//! border; what they have not grown yet is unknown, as the inner of a hole is. So tiles that touch are grown one after
//! the other: those next to the scan first, then inwards. Tiles of a round do not touch, and can be grown at the same
//! time on different machines: a [`TileTask`] goes there as bytes, a [`GrownTile`] comes back.
//!
//! What tiles do not share is the scan itself: each copies from its part of it. One tile that holds
//! everything gives what [`super::complete`] gives, bit for bit.

mod division;
mod error;
mod field;
mod grown;
mod nearest_first;
mod places;
mod plan;
mod region;
mod seams;
mod sealed;
mod task;

pub use error::TileError;
pub use grown::GrownTile;
pub use plan::TilePlan;
pub use seams::{SeamReport, StepsWithin, WorstBorder};
pub use task::TileTask;

use serde::{Deserialize, Serialize};

use crate::progress::Progress;
use crate::scan::Scan;

use super::{CompleteParams, CompletionError, CompletionReport};

/// How a scan is divided.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TileParams {
    /// Most vertices that a worker gets: targets, what surrounds them, and what they are copied from. Default
    /// 200 000.
    pub tile: usize,
    /// How far around its targets a tile sees everything, in the scan's unit, along edges. Default `None`: twice as
    /// far as a window reaches.
    pub overlap: Option<f64>,
}

impl Default for TileParams {
    fn default() -> Self {
        Self {
            tile: 200_000,
            overlap: None,
        }
    }
}

impl TileParams {
    /// Whether every parameter is in its range.
    ///
    /// # Errors
    /// [`CompletionError::Parameter`] for the first that is not.
    pub fn check(&self) -> Result<(), CompletionError> {
        /// Fewer vertices would show next to nothing to copy from.
        const LEAST: usize = 100;
        let parameter = |name, range, value| CompletionError::Parameter { name, range, value };
        if self.tile < LEAST {
            let value = self.tile as f64;
            return Err(parameter("--tile", "100 vertices or more", value));
        }
        match self.overlap {
            Some(length) if !(length >= 0.0 && length.is_finite()) => {
                Err(parameter("--overlap", "a length of 0 or more", length))
            }
            _ => Ok(()),
        }
    }
}

/// A scan that was completed in tiles.
#[derive(Debug, Clone)]
pub struct TiledCompletion {
    /// As of [`super::Completion`].
    pub scan: Scan,
    /// As of [`super::Completion`]; sites are those of the tile with the most.
    pub report: CompletionReport,
    /// How well the tiles fit together.
    pub seams: SeamReport,
    /// How it was divided.
    pub tiling: Tiling,
}

/// How a scan was divided.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tiling {
    /// Number of tiles.
    pub tiles: usize,
    /// Number of rounds.
    pub rounds: usize,
    /// Vertices of the largest task.
    pub most_vertices: usize,
}

/// Completes the scan's missing parts tile after tile: no more memory is needed at a time for neighborhoods than those of
/// one tile take.
///
/// # Errors
/// As [`TilePlan::new`].
pub fn complete_tiled(
    scan: &Scan,
    params: &CompleteParams,
    tiles: &TileParams,
    progress: &mut dyn FnMut(Progress),
) -> Result<TiledCompletion, CompletionError> {
    let mut plan = TilePlan::new(scan, params, tiles, progress)?;
    let targets = plan.targets();
    let total = targets.iter().sum();
    let mut before = 0;
    for tile in plan.rounds().into_iter().flatten() {
        let grown = plan.task(tile)?.grow(&mut |own| {
            progress(Progress {
                done: before + own.done,
                total,
                ..own
            });
        });
        plan.put(tile, grown)?;
        before += targets[tile];
    }
    plan.finish(progress)
}
