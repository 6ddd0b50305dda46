//! Meshes and samples that no texture comes of.

use thiserror::Error;

use crate::base::{FitError, Undetermined};

use super::params::MOST_VERTICES;

/// Why a mesh cannot be textured, in one sentence with a remedy.
#[derive(Debug, Error)]
pub enum TextureError {
    /// A surface is needed.
    #[error("the mesh has no faces: texture needs a surface; triangulate the points first")]
    NoFaces,
    /// A surface has an area.
    #[error("all faces of the mesh are degenerate: nothing is left to put a texture on")]
    NoArea,
    /// The number of vertices is sensible.
    #[error(
        "the number of vertices must be from 4 to {MOST_VERTICES}, not {asked}: use another --vertices"
    )]
    Vertices {
        /// The number asked for.
        asked: usize,
    },
    /// The density leads to a sensible number of vertices.
    #[error(
        "texels of {texel} would take {asked} vertices, and 4 to {MOST_VERTICES} are possible: give another --texel, or --vertices"
    )]
    VerticesOfTexel {
        /// The length of a texel, in the scan's unit.
        texel: f64,
        /// The number of vertices it would take.
        asked: usize,
    },
    /// The sample's own size leads to a sensible number of vertices.
    #[error(
        "texels as large as the sample scan's own ({texel}) would take {asked} vertices, so that its unit is hardly the mesh's: say how large they are by --texel, or --vertices"
    )]
    VerticesOfOwnTexel {
        /// The length of a texel, in the sample's unit.
        texel: f64,
        /// The number of vertices it would take.
        asked: usize,
    },
    /// Lengths are above 0.
    #[error("--texel must be a length above 0 in the scan's unit, not {0}")]
    Texel(f64),
    /// A turn by a whole share.
    #[error(
        "--symmetry must be from 1 to {most}, not {asked}: 1 if the texture looks the same only after a full turn, 2 after a half, 4 after a quarter"
    )]
    Symmetry {
        /// What was asked for.
        asked: u32,
        /// Largest.
        most: u32,
    },
    /// Resolutions.
    #[error("--levels must be from 1 to {most}, not {asked}")]
    Levels {
        /// What was asked for.
        asked: usize,
        /// Largest.
        most: usize,
    },
    /// A direction has a length.
    #[error("the direction of --orientation must be finite and not zero")]
    Direction,
    /// Something says where to.
    #[error("no direction of the orientation file is finite and longer than zero")]
    NoDirections,
    /// A neighborhood fits into the sample.
    #[error(
        "the sample has {width} by {height} texels, and no neighborhood of {window} by {window} that are not transparent fits into it: use a larger one"
    )]
    SampleTooSmall {
        /// Texels along its rows.
        width: usize,
        /// Texels along its columns.
        height: usize,
        /// Side of a neighborhood in texels.
        window: usize,
    },
    /// A neighborhood fits onto the sample's surface.
    #[error(
        "no neighborhood of {window} by {window} texels fits onto the sample's surface: use a larger piece of it"
    )]
    SampleSurfaceTooSmall {
        /// Side of a neighborhood in texels.
        window: usize,
    },
    /// Descriptor tables fit into memory.
    #[error(
        "the sample has {texels} texels, and up to {most} are compared: crop it, or scale it down"
    )]
    SampleTooLarge {
        /// Its number of texels.
        texels: usize,
        /// Largest.
        most: usize,
    },
    /// The sample is a surface.
    #[error("the sample scan has no faces: triangulate its points first")]
    SampleWithoutFaces,
    /// Heights are over something.
    #[error("the sample scan's relief cannot be taken off its form ({0}): use another piece of it")]
    SampleForm(#[from] Undetermined),
    /// The sample's base can be fitted.
    #[error("no base surface can be fitted to the sample scan: {0}")]
    SampleBase(#[from] FitError),
    /// The sample has something to copy.
    #[error("the sample scan is smooth and has no colors: there is nothing to copy")]
    SampleEmpty,
    /// Heights come from the sample.
    #[error("--displace takes a finite number, not {0}")]
    Displace(f64),
}
