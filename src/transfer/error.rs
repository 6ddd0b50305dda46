//! Why nothing can be transferred.

use thiserror::Error;

use super::params::MOST_VERTICES;

/// Why nothing can be transferred. Texts name no file: the caller knows which.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TransferError {
    /// Of one of the meshes.
    #[error("the mesh has no faces: triangulate it first (`relievo complete` does so for points)")]
    NoFaces {
        /// Whether it is the source.
        of_source: bool,
    },
    /// All triangles are degenerate, or too large for numbers.
    #[error("the mesh has no area that could be measured: its triangles are degenerate")]
    NoArea {
        /// Whether it is the source.
        of_source: bool,
    },
    /// Out of range.
    #[error("{asked} vertices cannot be worked on: ask for 3 to {MOST_VERTICES}")]
    Vertices {
        /// How many were asked for.
        asked: usize,
    },
    /// Out of range.
    #[error("a scale of {0} is not between 1/16 and 16")]
    Scale(f64),
    /// Out of range.
    #[error("a weight of the shape of {0} is not between 0 and 1")]
    ShapeWeight(f64),
    /// Out of range.
    #[error("a coherence of {0} is not from 0 to below 1")]
    Coherence(f64),
    /// Out of range.
    #[error("a penalty of overuse of {0} is not a number from 0")]
    Overuse(f64),
    /// Out of range.
    #[error("{0} rounds are not between 1 and 100")]
    Rounds(u32),
    /// Not a direction.
    #[error("the direction that is up must be finite and not zero")]
    Up,
    /// Nothing is there to be transferred.
    #[error("the source has neither colors nor heights")]
    NoValues,
    /// A value is missing.
    #[error("some of the source's colors or heights are not finite numbers: give every vertex one")]
    NotFinite,
    /// A map of another mesh.
    #[error(
        "the map has {given} entries for the target's {vertices} vertices: it must have one a vertex"
    )]
    MapLength {
        /// Entries.
        given: usize,
        /// Vertices of the target.
        vertices: usize,
    },
    /// A map to another mesh.
    #[error(
        "the map sends vertex {target} of the target to vertex {source_vertex} of the source, which has {vertices} vertices, numbered from 0"
    )]
    MapRange {
        /// The target's vertex.
        target: usize,
        /// Where it is sent.
        source_vertex: u32,
        /// Vertices of the source.
        vertices: usize,
    },
    /// A map without entries.
    #[error("the map has no entry that is a vertex")]
    MapEmpty,
    /// The mask leaves nothing to copy from.
    #[error("nothing is painted: no vertex of the source may be copied")]
    NothingPainted,
    /// The mask leaves nothing to do.
    #[error("all is painted already: no vertex is left to be filled")]
    AllPainted,
}
