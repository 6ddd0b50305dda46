//! Scans that cannot be completed.

use thiserror::Error;

use crate::base::{BaseKind, FitError};

use super::tiled::TileError;

/// Why a scan cannot be completed at all.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CompletionError {
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
    /// See [`FitError`].
    #[error(transparent)]
    Fit(#[from] FitError),
    /// See [`crate::base::FitReport::fits`].
    #[error(
        "a {kind} does not fit: the relief over it would be {rms:.4} (RMS) high in a scan of size {size:.4}; choose another --base, or cut the scan down to one surface"
    )]
    BaseDoesNotFit {
        /// The kind that was fitted.
        kind: BaseKind,
        /// RMS height.
        rms: f64,
        /// Diagonal of the scan.
        size: f64,
    },
    /// The paper's search looks up nearest points of the base.
    #[error(
        "--method paper needs a plane, sphere, cylinder or cone: choose another --base or --method"
    )]
    FreeFormByPaper,
    /// Beyond its rim free form is not known.
    #[error(
        "--extend needs a base surface that goes on beyond the scan: choose another --base than freeform"
    )]
    FreeFormHasNoEnd,
    /// There is nothing to do.
    #[error("it has no boundary: the surface is closed, nothing is missing")]
    Closed,
    /// Only outer rims are there.
    #[error(
        "it has no interior hole, only {rims} outer rim(s): --extend completes the rest of the base surface, --holes all or --holes ID fills a rim"
    )]
    NoInteriorHole {
        /// Number of outer rims.
        rims: usize,
    },
    /// Numbers say exactly which.
    #[error(
        "holes chosen by number are taken whatever their size and paint: give either numbers to --holes, or limits"
    )]
    NumbersAndLimits,
    /// Limits and paint leave nothing.
    #[error(
        "none of its {holes} hole(s) is within the limits and where it is painted: raise the limits (relievo holes tells sizes, in the scan's unit)"
    )]
    NoneAdmitted {
        /// Number of holes.
        holes: usize,
    },
    /// The channel that should tell what is painted.
    #[error(
        "its vertices have no number `{name}` that could tell what is painted: they have {known}"
    )]
    NoSuchChannel {
        /// Name asked for.
        name: String,
        /// Names that there are.
        known: String,
    },
    /// The colours that should tell what is painted.
    #[error(
        "it has no colours that could tell what is painted: give the name of a vertex property"
    )]
    NoColors,
    /// Paint somewhere.
    #[error("no vertex is painted like that: check the property or the colour given to --mask")]
    NothingPainted,
    /// A loop was asked for that is not there.
    #[error("there is no boundary loop {id}: the highest number is {last} (see relievo holes)")]
    NoSuchLoop {
        /// Number asked for.
        id: usize,
        /// Highest number.
        last: usize,
    },
    /// Nothing lies on the base to copy from.
    #[error(
        "no triangle of the scan lies on the base surface, so there is no relief to copy: choose another --base"
    )]
    NoSamples,
    /// See [`TileError`].
    #[error(transparent)]
    Tile(#[from] TileError),
}
