//! A surface in figures, and two parts of one against each other: original against completed, or two scans.
//!
//! [`compare`] takes a completed scan; [`Measured`] and [`compare_parts`] any two parts, and
//! [`natural_variation`] tells how much of their differences pieces of one surface show by themselves.
//!
//! # Reference
//! [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), Table 1 (mean integral) and
//! Fig. 13 (colour histograms); ISO 25178-2:2021 for [`areal`].

pub mod areal;
mod error;
mod histogram;
mod integral;
mod measured;
mod natural;
mod patches;
mod rows;
mod spectrum;
mod verdict;

pub use error::StatsError;
pub use histogram::{
    ColorComparison, HeightComparison, Histogram, compare_colors, compare_heights,
};
pub use integral::{ReliefPart, relief_part};
pub use measured::{MeasureParams, Measured, completed_vertices};
pub use natural::{JudgedPiece, Natural, NaturalParams, Variogram, natural_variation};
pub use rows::ComparisonRow;
pub use spectrum::Spectrum;
pub use verdict::{Verdict, verdict};

use serde::Serialize;

use crate::base::Form;
use crate::completion::{COMPLETED, SOURCE};
use crate::likeness::{CopyIndex, copies};
pub use crate::progress::Progress;
use crate::scan::Scan;

use patches::{PatchReader, Patches};

/// Original against completed part of a scan, or one part (or scan) against another: what is said of the
/// original is said of the first, what is said of the completed part of the second.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The base surface that the (original's) heights are over.
    pub base: Form,
    /// What the scanner saw, as far as it lies on the base.
    pub original: ReliefPart,
    /// What completion added, as far as it lies on the base.
    pub completed: ReliefPart,
    /// Difference of the mean integrals in percent of the original's, with its sign.
    pub mean_integral_difference_percent: f64,
    /// RMS roughness of the completed part over that of the original; `None` if that is zero.
    pub roughness_ratio: Option<f64>,
    /// Histograms of the heights about the mean height of the original.
    pub heights: HeightComparison,
    /// Red, green and blue, where there are colours.
    pub colors: Option<[ColorComparison; 3]>,
    /// Power by wavelength, where both parts have room for square patches of heights.
    pub spectrum: Option<Spectrum>,
    /// What was copied from where, if the scan tells.
    pub copies: Option<CopyIndex>,
}

/// Compares the completed part of a scan (vertices with `completed` = 1) with the original part.
///
/// The base surface is the one that completion noted in the scan's comments; without that note it is
/// fitted to the original part. A triangle is completed if one of its vertices is.
///
/// # Errors
/// [`StatsError`] if the scan does not tell its parts apart, or one of them is empty.
pub fn compare(scan: &Scan) -> Result<Comparison, StatsError> {
    if scan.vertices.channel(COMPLETED).is_none() {
        return Err(StatsError::NotCompleted);
    }
    let measured = Measured::new(scan, &MeasureParams::default())?;
    let completed = completed_vertices(scan);
    let original: Vec<bool> = completed.iter().map(|completed| !completed).collect();
    let mut comparison = compare_parts(&measured, &original, &completed)?;
    comparison.copies = copied(scan, &measured);
    Ok(comparison)
}

/// What the completed vertices of a scan were copied from, if it tells.
#[must_use]
pub fn copied(scan: &Scan, measured: &Measured) -> Option<CopyIndex> {
    let column = scan.vertices.column(SOURCE)?;
    #[expect(clippy::cast_possible_truncation, reason = "vertex indices")]
    let source = |row| column.get_f64(row).map_or(-1, |source| source as i64);
    let sources: Vec<i64> = (0..scan.vertices.rows).map(source).collect();
    let original: Vec<bool> = sources.iter().map(|source| *source < 0).collect();
    copies(&measured.mesh, &sources, measured.median_edge(&original)?)
}

/// Compares two parts (#V) of a surface that was measured, or of two [side by side](Measured::beside).
///
/// A triangle is of the second part if one of its vertices is (and all are of either part), of the first if all
/// are.
///
/// # Errors
/// [`StatsError::EmptyPart`] if there is no triangle of a part on the base surface.
///
/// # Panics
/// If a part has not one entry a vertex.
#[expect(
    clippy::panic_in_result_fn,
    reason = "a part of another surface is a mistake of the caller's"
)]
pub fn compare_parts(
    measured: &Measured,
    first: &[bool],
    second: &[bool],
) -> Result<Comparison, StatsError> {
    let count = measured.vertices();
    assert!(
        first.len() == count && second.len() == count,
        "one entry a vertex"
    );
    let on_base: Vec<bool> = (0..count)
        .map(|v| measured.on_base[v] && (first[v] || second[v]))
        .collect();
    let whole = |t: &&[u32; 3]| t.iter().all(|v| on_base[*v as usize]);
    let is_second = |t: &[u32; 3]| t.iter().any(|v| second[*v as usize]);
    let triangles = measured.mesh.triangles.iter().filter(whole).copied();
    let (new, old): (Vec<_>, Vec<_>) = triangles.partition(is_second);
    let part = |triangles: &[[u32; 3]], name| {
        relief_part(&measured.relief, triangles).ok_or(StatsError::EmptyPart(name))
    };
    let mut original = part(&old, "original")?;
    let mut completed = part(&new, "completed")?;
    let spectrum = read_patches(measured, [first, second], [&mut original, &mut completed]);
    let ratio = |new: f64, old: f64| (old > 0.0).then(|| new / old);
    let weighted = |triangles: &[[u32; 3]]| {
        integral::heights_by_area(&measured.relief, triangles, original.mean_height)
    };
    Ok(Comparison {
        base: measured.base(),
        mean_integral_difference_percent: 100.0
            * (completed.mean_integral / original.mean_integral - 1.0),
        roughness_ratio: ratio(completed.rms_roughness, original.rms_roughness),
        heights: compare_heights(&weighted(&old), &weighted(&new)),
        colors: (measured.colors.as_ref()).map(|colors| compare_colors(colors, first, second)),
        spectrum,
        copies: None,
        original,
        completed,
    })
}

/// Figures of a part (#V) of a surface that was measured.
///
/// # Errors
/// [`StatsError::Nothing`] if there is no triangle of it on the base surface.
///
/// # Panics
/// If it has not one entry a vertex.
#[expect(
    clippy::panic_in_result_fn,
    reason = "a part of another surface is a mistake of the caller's"
)]
pub fn figures(measured: &Measured, part: &[bool]) -> Result<ReliefPart, StatsError> {
    assert_eq!(part.len(), measured.vertices(), "one entry a vertex");
    let is_part = |v: &u32| part[*v as usize] && measured.on_base[*v as usize];
    let triangles: Vec<[u32; 3]> = (measured.mesh.triangles.iter())
        .filter(|t| t.iter().all(is_part))
        .copied()
        .collect();
    let mut figures = relief_part(&measured.relief, &triangles).ok_or(StatsError::Nothing)?;
    let marks = measured.marks(part);
    if let Some(step) = measured.median_edge(&marks) {
        let feet = measured.feet();
        let relief = &measured.relief;
        let reader = PatchReader::new(&feet, &relief.normals, &relief.heights, step);
        set_spatial(&mut figures, reader.largest(&marks).as_ref());
    }
    Ok(figures)
}

/// Sets the spatial parameters of two parts, and gives their spectra, as far as they have room for square
/// patches of heights; at the coarser part's median edge.
fn read_patches(
    measured: &Measured,
    parts: [&[bool]; 2],
    figures: [&mut ReliefPart; 2],
) -> Option<Spectrum> {
    let [first, second] = parts.map(|part| measured.marks(part));
    let step = f64::max(
        measured.median_edge(&first)?,
        measured.median_edge(&second)?,
    );
    let feet = measured.feet();
    let relief = &measured.relief;
    let reader = PatchReader::new(&feet, &relief.normals, &relief.heights, step);
    let largest = [reader.largest(&first), reader.largest(&second)];
    for (figures, patches) in figures.into_iter().zip(&largest) {
        set_spatial(figures, patches.as_ref());
    }
    let [of_first, of_second] = largest;
    let (of_first, of_second) = (of_first?, of_second?);
    // Of the size that both have room for.
    if of_first.side > of_second.side {
        Some(Spectrum::new(&reader.like(&of_second, &first)?, &of_second))
    } else {
        Some(Spectrum::new(&of_first, &reader.like(&of_first, &second)?))
    }
}

/// Sal, Str and Std of a part, if it has an autocorrelation.
fn set_spatial(part: &mut ReliefPart, patches: Option<&Patches>) {
    if let Some(autocorrelation) = patches.and_then(Patches::autocorrelation) {
        (part.areal.sal, part.areal.str) = autocorrelation.lengths();
        part.areal.std = autocorrelation.direction();
    }
}
