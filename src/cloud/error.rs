//! Clouds that cannot be triangulated.

use thiserror::Error;

use crate::base::FitError;
use crate::scan::ScanError;

/// Why a cloud cannot be triangulated, in one sentence with a remedy.
#[derive(Debug, Error)]
pub enum CloudError {
    /// The scan is a sound one.
    #[error(transparent)]
    Scan(#[from] ScanError),
    /// A cloud has no faces.
    #[error("the scan has {0} faces already: triangulate scans of points only, or drop the faces")]
    HasFaces(usize),
    /// A triangle has three corners.
    #[error(
        "{found} different points are too few, 3 are needed: export the scan with all its points"
    )]
    TooFewPoints {
        /// Points at different places.
        found: usize,
    },
    /// Points differ.
    #[error("all {0} points are at the same place: check the file's coordinates")]
    Coincident(usize),
    /// Points span an area.
    #[error(
        "all points are on one line: triangles need points that span an area; check the file's columns"
    )]
    Collinear,
    /// Points have neighbors.
    #[error(
        "no three points are within the gap of each other: allow a wider --gap, or --keep-outliers"
    )]
    NothingJoined,
    /// A chart needs a base surface.
    #[error(
        "no base surface can be fitted to the points ({0}): --join local joins them without one"
    )]
    NoChart(#[source] FitError),
    /// A chart's coordinates are in the range of the predicates.
    #[error("the points reach too far along the base surface for its chart: use --join local")]
    ChartRange,
    /// The number of neighbors is sensible.
    #[error("the number of neighbors must be from {least} to {most}, not {asked}")]
    Neighbors {
        /// The number asked for.
        asked: usize,
        /// Least.
        least: usize,
        /// Largest.
        most: usize,
    },
    /// The gap is a multiple of the spacing.
    #[error("--gap must be a multiple of the points' distance and at least 1, not {0}")]
    Gap(f64),
    /// The limits of outliers are sensible.
    #[error("for outliers, the deviations must be at least 0 and the isolation at least 1")]
    Outliers,
}
