//! Why there are no figures.

use thiserror::Error;

use crate::base::{BaseKind, FitError, Undetermined};
use crate::completion::COMPLETED;

/// Scans that cannot be compared.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StatsError {
    /// Nothing tells original and completed vertices apart.
    #[error(
        "it has no vertex property \"{COMPLETED}\": give a scan that the command complete wrote as PLY"
    )]
    NotCompleted,
    /// There is no surface.
    #[error("it has no faces, and heights are taken of a surface")]
    NoFaces,
    /// One of the parts is missing.
    #[error("no {0} triangle lies on the base surface: there is nothing to compare")]
    EmptyPart(&'static str),
    /// The base surface that was asked for is too far from the scan.
    #[error("no {0} fits the scan: try another --base, or freeform")]
    BaseDoesNotFit(BaseKind),
    /// No part of the surface lies on the base.
    #[error("no triangle lies on the base surface: there is nothing to measure")]
    Nothing,
    /// A part is too small to tell what is natural.
    #[error(
        "a part is too small, or too narrow, to be compared with pieces of the other of its size"
    )]
    NoRoom,
    /// Too few or too many pieces.
    #[error("--pieces {0}: expected from 60 to 10000, or 0 for no scores")]
    Pieces(usize),
    /// Nobody wants to know.
    #[error("no scores were asked for")]
    NotAsked,
    /// A length is none.
    #[error("{name} {value}: expected a positive length in the scan's unit")]
    Length {
        /// The option.
        name: &'static str,
        /// What it was given.
        value: f64,
    },
    /// The filters leave nothing.
    #[error(
        "--s-filter {s} takes off all waves that --l-filter {l} leaves: give the S-filter the shorter length"
    )]
    NothingBetween {
        /// Nesting index of the S-filter.
        s: f64,
        /// Nesting index of the L-filter.
        l: f64,
    },
    /// See [`FitError`].
    #[error(transparent)]
    Fit(#[from] FitError),
    /// See [`Undetermined`].
    #[error(transparent)]
    Undetermined(#[from] Undetermined),
}
