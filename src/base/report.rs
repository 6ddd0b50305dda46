//! What a fit found, and how well it fits.

use serde::{Deserialize, Serialize};

use super::{BaseKind, BaseSurface};

/// A base whose [`FitReport::relief_share`] is above this does not fit: what would be taken for
/// relief is form.
///
/// Measured: golf balls 0.002, brick walls and gentle waves 0.001 to 0.006, a scallop shell on its
/// sphere 0.010, pitted limestone on its plane 0.012, deep bark 0.013, a broken stone on a sphere
/// and waves a thirtieth as high as the plate is wide 0.018; a whole tower on a
/// cone 0.028 and on a plane 0.092, a mountain on a sphere 0.039, a figure of a rabbit on a sphere
/// 0.065.
pub const MAX_RELIEF_SHARE: f64 = 0.025;

/// Why the iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// The parameters no longer change.
    Converged,
    /// [`super::FitParams::max_iterations`] was reached; the surface is the last one.
    IterationLimit,
    /// A least-squares step could not be computed; the surface is the last good one.
    Numerical,
}

impl StopReason {
    /// Whether the surface is a minimum of the loss.
    #[must_use]
    pub fn was_successful(self) -> bool {
        self == Self::Converged
    }
}

/// Why a fitted surface is no candidate of its kind: a simpler kind says the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Degenerate {
    /// The radius of curvature is more than a hundred times the mesh's diagonal: a plane.
    Flat,
    /// The half angle is below 1 degree: a cylinder.
    NearlyCylinder,
    /// The half angle is above 85 degrees: a plane.
    NearlyPlane,
    /// The cone's tip lies inside the mesh's extent, and more than a tenth of the vertices are
    /// behind it.
    BehindApex,
}

/// A fitted surface of one kind; all but the chosen one are refined only as far as the comparison
/// needs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// The surface, in the mesh's coordinates.
    pub base: BaseSurface,
    /// Root mean square height over all vertices, weighted as in the fit; in the scan's unit.
    pub rms: f64,
    /// Robust standard deviation of the heights, in the scan's unit; see
    /// [`super::FitParams::scale`].
    pub scale: f64,
    /// The lower, the better: 2 n ρ̄ + k max(ln n, 3), with k parameters (plane 3, sphere 4, cylinder 5, cone
    /// 6), ρ̄ the mean of ln(1 + (height / σ)²), σ the least scale of all candidates (from the
    /// median absolute deviation), and n the
    /// number of independent pieces of relief; see [`super::fit`].
    pub criterion: f64,
    /// Set if it is excluded.
    pub degenerate: Option<Degenerate>,
    /// Why its iteration ended.
    pub reason: StopReason,
}

impl Candidate {
    /// Kind of its surface.
    #[must_use]
    pub fn kind(&self) -> BaseKind {
        self.base.kind()
    }
}

/// The base surface and how well it fits. All lengths are in the scan's unit; means and shares are
/// over the vertices that a triangle uses, weighted as in the fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitReport {
    /// The surface, in the mesh's coordinates.
    pub base: BaseSurface,
    /// Root mean square height.
    pub rms: f64,
    /// Mean height: far from zero if the relief is one-sided or stray pieces were left out.
    pub mean_height: f64,
    /// Largest absolute height.
    pub max_residual: f64,
    /// Robust standard deviation of the heights.
    pub scale: f64,
    /// Share (0 to 1) of the vertices that are within the reach of the loss, 4.685 times the scale.
    pub inlier_share: f64,
    /// Root mean square height of these.
    pub inlier_rms: f64,
    /// Diagonal of the bounding box of the vertices.
    pub diagonal: f64,
    /// Number of vertices that a triangle uses.
    pub vertices: usize,
    /// Reweightings of the final fit (evaluations of the heights for least squares).
    pub iterations: usize,
    /// Why the iteration ended.
    pub reason: StopReason,
    /// Number of independent pieces of relief in the criterion.
    pub independent: f64,
    /// All kinds that were fitted, the best first, excluded ones last.
    pub ranking: Vec<Candidate>,
}

impl FitReport {
    /// Root mean square height of the inliers as a share of the mesh's diagonal: how much of the
    /// mesh's form the base leaves over. See [`MAX_RELIEF_SHARE`].
    #[must_use]
    pub fn relief_share(&self) -> f64 {
        self.inlier_rms / self.diagonal
    }

    /// Whether the base explains the mesh's form well enough for its heights to be called relief.
    #[must_use]
    pub fn fits(&self) -> bool {
        self.relief_share() <= MAX_RELIEF_SHARE
    }
}
