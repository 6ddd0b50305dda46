//! Original against completed part in figures; areal parameters of height maps ([`areal`]).
//!
//! # Reference
//! [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), Table 1 (mean integral) and
//! Fig. 13 (colour histograms).

pub mod areal;
mod histogram;
mod integral;

pub use histogram::{ColorComparison, Histogram, compare_colors};
pub use integral::{ReliefPart, relief_part};

use serde::Serialize;
use thiserror::Error;

use crate::base::{self, BaseSurface, FitError, FitParams, Form};
use crate::completion::{COMPLETED, noted_relief, remembered_base, remembered_free_form};
use crate::mesh::TriMesh;
use crate::relief;
use crate::scan::Scan;

/// Original against completed part of a scan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The base surface that the heights are over.
    pub base: Form,
    /// What the scanner saw, as far as it lies on the base.
    pub original: ReliefPart,
    /// What completion added, as far as it lies on the base.
    pub completed: ReliefPart,
    /// Difference of the mean integrals in percent of the original's, with its sign.
    pub mean_integral_difference_percent: f64,
    /// RMS roughness of the completed part over that of the original; `None` if that is zero.
    pub roughness_ratio: Option<f64>,
    /// Red, green and blue, where the scan has colours.
    pub colors: Option<[ColorComparison; 3]>,
}

/// Scans that cannot be compared with themselves.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StatsError {
    /// Nothing tells original and completed vertices apart.
    #[error(
        "it has no vertex property \"{COMPLETED}\": give a scan that the command complete wrote as PLY"
    )]
    NotCompleted,
    /// One of the parts is missing.
    #[error("no {0} triangle lies on the base surface: there is nothing to compare")]
    EmptyPart(&'static str),
    /// No base surface is noted, and none fits.
    #[error(
        "no plane, sphere, cylinder or cone fits the original part, so there are no heights to compare"
    )]
    NoBase,
    /// See [`FitError`].
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// Compares the completed part of a scan (vertices with `completed` = 1) with the original part.
///
/// The base surface is the one that completion noted in the scan's comments; without that note it is
/// fitted to the original part. A triangle is completed if one of its vertices is.
///
/// # Errors
/// [`StatsError`] if the scan does not tell its parts apart, or one of them is empty.
pub fn compare(scan: &Scan) -> Result<Comparison, StatsError> {
    let marks = scan
        .vertices
        .channel(COMPLETED)
        .ok_or(StatsError::NotCompleted)?;
    let completed: Vec<bool> = (0..scan.vertices.rows)
        .map(|row| marks.values.get_f64(row).is_some_and(|mark| mark > 0.5))
        .collect();
    let (mesh, origin) = scan.mesh().centered();
    let is_completed = |t: &[u32; 3]| t.iter().any(|v| completed[*v as usize]);
    let (new, old): (Vec<_>, Vec<_>) = mesh.triangles.iter().partition(|t| is_completed(t));
    let noted = (remembered_base(scan).map(|known| Form::Primitive(known.surface)))
        .or_else(|| remembered_free_form(scan).map(|known| Form::Free(known.form)))
        .zip(noted_relief(scan, &mesh, &origin));
    let (base, (relief, reach)) = match noted {
        Some(noted) => noted,
        None => {
            let (surface, reach) = fitted_base(&mesh, &old)?;
            let base = Form::Primitive(surface.translated(origin));
            (base, (relief::extract(&mesh, &surface), reach))
        }
    };
    let on_base = |t: &[u32; 3]| t.iter().all(|v| relief.heights[*v as usize].abs() <= reach);
    let part = |triangles: Vec<[u32; 3]>, name| {
        let triangles: Vec<_> = triangles.into_iter().filter(|t| on_base(t)).collect();
        relief_part(&relief, &triangles).ok_or(StatsError::EmptyPart(name))
    };
    let original = part(old, "original")?;
    let completed_part = part(new, "completed")?;
    let colors = scan
        .colors()
        .map(|colors| compare_colors(&colors, &completed));
    Ok(Comparison {
        base,
        mean_integral_difference_percent: 100.0
            * (completed_part.mean_integral / original.mean_integral - 1.0),
        roughness_ratio: (original.rms_roughness > 0.0)
            .then(|| completed_part.rms_roughness / original.rms_roughness),
        original,
        completed: completed_part,
        colors,
    })
}

/// The base surface of the original part, and how high its relief is.
fn fitted_base(mesh: &TriMesh, originals: &[[u32; 3]]) -> Result<(BaseSurface, f64), StatsError> {
    let fit = base::fit_part(&mesh.positions, originals, &FitParams::default())?;
    if !fit.fits() {
        return Err(StatsError::NoBase);
    }
    let reach = relief::reach(&fit);
    Ok((fit.base, reach))
}
