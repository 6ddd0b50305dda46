//! Scans that cannot be evaluated.

use thiserror::Error;

use crate::base::FitError;
use crate::completion::CompletionError;

/// Why a scan cannot be evaluated.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EvaluationError {
    /// Relief needs a surface.
    #[error("it has vertices but no faces: triangulate the points first")]
    NoFaces,
    /// A parameter is out of its range.
    #[error("{name} must be {range}, not {value}")]
    Parameter {
        /// Name, as on the command line.
        name: &'static str,
        /// What it may be.
        range: &'static str,
        /// What it is.
        value: f64,
    },
    /// Pieces of the hole's size do not fit between the rims.
    #[error(
        "it has room for {places} of {holes} pieces of the hole's size away from its rims: try a smaller --hole"
    )]
    NoRoom {
        /// Number asked for.
        holes: usize,
        /// Number found.
        places: usize,
    },
    /// Completion left the hole open.
    #[error("a hole that was cut could not be filled: {0}")]
    NotFilled(String),
    /// See [`CompletionError`].
    #[error(transparent)]
    Completion(#[from] CompletionError),
    /// See [`FitError`].
    #[error(transparent)]
    Fit(#[from] FitError),
}
