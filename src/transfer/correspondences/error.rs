//! What can be wrong with correspondences, each in one sentence with a remedy.

use thiserror::Error;

use super::MOST_PAIRS;

/// Which of the two surfaces a place is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The surface whose texture is transferred.
    Source,
    /// The surface that receives it.
    Target,
}

impl std::fmt::Display for Side {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Source => "source",
            Self::Target => "target",
        })
    }
}

/// Why correspondences cannot be used. Pairs are counted from 1, in the order of the file.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CorrespondenceError {
    /// The file is JSON.
    #[error(
        "the correspondences are not JSON: line {line}, column {column}: {reason}; correct the file there"
    )]
    NotJson {
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// What the parser says.
        reason: String,
    },
    /// The file is a list of pairs, or an object that holds one.
    #[error(
        "the correspondences hold no list of pairs; write [[12, 40], …] or {{\"pairs\": [{{\"source\": 12, \"target\": 40}}, …]}}"
    )]
    NoList,
    /// There is at least one pair.
    #[error("the correspondences are empty; give at least one pair, or leave the file out")]
    Empty,
    /// There are not too many pairs.
    #[error("there are {count} correspondences; choose at most {MOST_PAIRS} of them")]
    TooMany {
        /// Number of pairs.
        count: usize,
    },
    /// A pair has a source and a target.
    #[error(
        "correspondence {pair} is no pair; write [12, 40] or {{\"source\": 12, \"target\": 40}}"
    )]
    NoPair {
        /// Its number.
        pair: usize,
    },
    /// A place is a vertex or a point.
    #[error(
        "correspondence {pair}: its {side} is `{text}`, which is neither a vertex (a whole number from 0) nor a point (three finite numbers); correct it"
    )]
    NoPlace {
        /// Its number.
        pair: usize,
        /// On which surface.
        side: Side,
        /// What stands there, the beginning of it if it is long.
        text: String,
    },
    /// A vertex exists.
    #[error(
        "correspondence {pair}: the {side} has no vertex {vertex}, only 0 to {last}; vertices count from 0"
    )]
    NoVertex {
        /// Its number.
        pair: usize,
        /// On which surface.
        side: Side,
        /// The number that was given.
        vertex: u64,
        /// The last vertex that there is.
        last: usize,
    },
    /// A vertex is a corner of a face.
    #[error(
        "correspondence {pair}: no face uses vertex {vertex} of the {side}; choose one on the surface"
    )]
    Loose {
        /// Its number.
        pair: usize,
        /// On which surface.
        side: Side,
        /// The vertex.
        vertex: u64,
    },
    /// A point is near its surface.
    #[error(
        "correspondence {pair}: its point on the {side} is {distance} away from it, but the {side} is only {size} large; give it in the unit and position of that mesh"
    )]
    FarAway {
        /// Its number.
        pair: usize,
        /// On which surface.
        side: Side,
        /// Distance to the nearest vertex, in the scan's unit.
        distance: f64,
        /// Diagonal of the surface's bounding box, in the scan's unit.
        size: f64,
    },
    /// A surface has faces.
    #[error(
        "the {side} has no faces, so that no place on it can correspond to another; give a mesh with faces"
    )]
    NoSurface {
        /// Which of them.
        side: Side,
    },
    /// A vertex of the target belongs to one place of the source.
    #[error(
        "correspondences {first} and {second} contradict each other: both have vertex {vertex} of the target, one with vertex {first_source} of the source, the other with vertex {second_source}; remove one of them"
    )]
    Contradiction {
        /// Number of the earlier pair.
        first: usize,
        /// Number of the later pair.
        second: usize,
        /// The vertex of the target.
        vertex: u32,
        /// The earlier pair's vertex of the source.
        first_source: u32,
        /// The later pair's vertex of the source.
        second_source: u32,
    },
}
