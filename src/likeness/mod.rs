//! A piece of a surface against the known part of it: how far its relief and colour are from being of
//! the same kind.
//!
//! A [`Field`] is what is read off a surface once: around every vertex the heights (and colours) on
//! rings at fixed distances, in units of the scan's median edge and by walking over the surface, so
//! that no figure depends on how densely the vertices stand. [`Field::figures`] then tells by how much a
//! piece differs from the known part, one [`Figure`] for each thing looked at. Pieces of one surface
//! differ, too: [`Calibration::new`] takes the same figures of true pieces ([`Field::pieces`]), and
//! [`Calibration::judge`] divides by the 95 % quantile that these have. A score of at most 1 is within the
//! surface's natural variation.
//!
//! | [`Measure`] | looks at | shows |
//! |---|---|---|
//! | [`Laplacian`](Measure::Laplacian) | distribution of the height's Laplacian | noise, blur, fading |
//! | [`Variogram`](Measure::Variogram) | mean squared differences by direction and distance | rotation, amplitude, blur |
//! | [`Areal`](Measure::Areal) | ISO 25178-2 figures | amplitude, slope, shape of the distribution |
//! | [`Seam`](Measure::Seam) | Laplacian and bend along the rim | an unblended paste |
//! | [`Classifier`](Measure::Classifier) | whether neighborhoods can be told apart | whatever else |
//! | [`Color`](Measure::Color) | the same on L\*, a\*, b\*, and colour against height | recoloured, blended |
//!
//! What was copied from where is no matter of statistics: see [`copies`].

mod areal;
mod calibration;
mod classifier;
mod color;
mod copies;
mod curved;
mod discs;
mod distance;
mod field;
mod laplacian;
mod readings;
mod seam;
mod summary;
mod variogram;

pub use areal::ArealFigures;
pub use calibration::{Calibration, FigureScore, Judgement, MeasureScore, Score};
pub(crate) use color::lightness;
pub use copies::{CopyIndex, copies};
pub use discs::Discs;
pub use field::{Field, FieldInput};
pub use summary::{MeasureSummary, Scores, Summary, worst_figures};

use serde::Serialize;

/// What is compared, see the table of [`self`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// Wasserstein distance of the height's Laplacian.
    Laplacian,
    /// Distance of directional log-variograms of the height.
    Variogram,
    /// Mean integral, Sa, Sq, Ssk, Sku, Sdq, Sal, Str of the height.
    Areal,
    /// Laplacian and bend of the height along the rim.
    Seam,
    /// Two-sample test by a classifier on neighborhoods of heights.
    Classifier,
    /// All of these on L\*, a\*, b\*, and the correlation of height and lightness.
    Color,
}

impl Measure {
    /// All of them, in the order in which they are told.
    pub const ALL: [Self; 6] = [
        Self::Laplacian,
        Self::Variogram,
        Self::Areal,
        Self::Seam,
        Self::Classifier,
        Self::Color,
    ];

    /// Its name in text.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Laplacian => "laplacian",
            Self::Variogram => "variogram",
            Self::Areal => "areal",
            Self::Seam => "seam",
            Self::Classifier => "classifier",
            Self::Color => "color",
        }
    }
}

/// By how much a piece differs from the known part in one respect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// The measure that it belongs to.
    pub measure: Measure,
    /// What was looked at, as in `Sdq` or `L* variogram`.
    pub name: String,
    /// The distance, 0 for none; `None` where it cannot be told (a flat known part, a piece along a rim).
    pub value: Option<f64>,
}

#[cfg(test)]
mod tests;
