//! A tile that was grown.

use serde::{Deserialize, Serialize};

use super::super::by_stencil::NothingToCopy;
use super::super::report::Searched;
use super::TileError;
use super::places::Spot;
use super::sealed::{opened, sealed};

const KIND: &str = "grown tile";

/// What was copied to a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Copy {
    pub(super) height: f64,
    /// Normalised, in [0, 1].
    pub(super) cost: f64,
    /// The scanned vertex that was copied from.
    pub(super) vertex: u32,
    pub(super) spot: Spot,
}

/// A tile that was grown: comes from a worker as bytes. Numbers of vertices are the plan's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GrownTile {
    pub(super) tile: u32,
    /// Tells the plan from others.
    pub(super) plan: u32,
    /// Vertices of the task.
    pub(super) vertices: u32,
    /// By vertex of the tile's own: what was copied to it, `None` where nothing matched; and what was searched. Or
    /// why there is nothing to copy from.
    pub(super) copies: Result<(Vec<Option<Copy>>, Searched), NothingToCopy>,
}

impl GrownTile {
    /// Number of the tile.
    #[must_use]
    pub fn tile(&self) -> usize {
        self.tile as usize
    }

    /// The grown tile as bytes: the same on every machine.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        sealed(KIND, self)
    }

    /// A grown tile from its bytes.
    ///
    /// # Errors
    /// [`TileError::Damaged`] if they are not just what [`Self::to_bytes`] has made; [`TileError::OtherVersion`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TileError> {
        opened(KIND, bytes)
    }
}
