//! Tiles that cannot be made, grown or put back.

use thiserror::Error;

/// What is wrong with a tile, or with what was asked of a [`super::TilePlan`].
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum TileError {
    /// The paper's search looks at every sample of the scan.
    #[error(
        "--method paper looks at the whole scan for every new vertex and cannot be tiled: choose --method coherent or exhaustive, or complete the scan in one piece"
    )]
    ByPaper,
    /// What is completed in one tile would have to become samples of all others.
    #[error(
        "--bootstrap copies from what was completed anywhere before and cannot be tiled: leave it out, or complete the scan in one piece"
    )]
    Bootstrap,
    /// A tile holds its new vertices, what surrounds them, and something to copy from.
    #[error(
        "tiles of {tile} vertices are too small: a few new vertices and their overlap take {needed} already; raise --tile to {least} at least, or lower --overlap"
    )]
    TooSmall {
        /// Most vertices of a tile, as asked for.
        tile: usize,
        /// New vertices of a part that is not divided any more, and the vertices within the overlap.
        needed: usize,
        /// Vertices of a tile that holds as many.
        least: usize,
    },
    /// Tiles are numbered from 0.
    #[error("there is no tile {tile}: there are {tiles}, numbered from 0")]
    NoSuchTile {
        /// Number asked for.
        tile: usize,
        /// Number of tiles.
        tiles: usize,
    },
    /// A tile continues what was grown before.
    #[error(
        "tile {tile} comes too early: tile {missing} of an earlier round has not been put back yet"
    )]
    TooEarly {
        /// The tile asked for.
        tile: usize,
        /// A tile that it waits for.
        missing: usize,
    },
    /// Not all is grown.
    #[error("tile {tile} has not been put back yet: grow it before the completion is finished")]
    Missing {
        /// Its number.
        tile: usize,
    },
    /// See [`super::TileTask::from_bytes`] and [`super::GrownTile::from_bytes`].
    #[error("{kind} cannot be read: {reason}; make it and send it anew")]
    Damaged {
        /// What it should be.
        kind: &'static str,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// Tiles of another version would not fit.
    #[error(
        "a {kind} comes from relievo {theirs}, and this is relievo {ours}: install the same version on all machines"
    )]
    OtherVersion {
        /// What it is.
        kind: &'static str,
        /// The version that has made it.
        theirs: String,
        /// The version that is to take it.
        ours: &'static str,
    },
    /// A tile was grown from something else.
    #[error(
        "what was grown for tile {tile} does not belong there: {reason}; grow it from the task of this plan"
    )]
    Foreign {
        /// The tile that it was given for.
        tile: usize,
        /// What does not fit.
        reason: &'static str,
    },
}
