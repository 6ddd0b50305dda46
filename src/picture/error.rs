//! What can be wrong with a picture, each in one sentence with a remedy.

use thiserror::Error;

use crate::base::FitError;

use super::params::{LARGEST_SIDE, LARGEST_ZOOM, MOST_PIXELS, SMALLEST_SIDE};

/// Why no picture could be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PictureError {
    /// The size is in range.
    #[error(
        "a picture of {width} by {height} pixels cannot be drawn: give a width and a height from {SMALLEST_SIDE} to {LARGEST_SIDE}, and at most {} million pixels in all",
        MOST_PIXELS / 1_000_000
    )]
    Size {
        /// Pixels from left to right.
        width: u32,
        /// Pixels from top to bottom.
        height: u32,
    },
    /// The zoom is in range.
    #[error("a zoom of {0} is out of range: give one from {least} to {LARGEST_ZOOM}", least = 1.0 / LARGEST_ZOOM)]
    Zoom(f64),
    /// Ranges of values go upwards.
    #[error("a range from {low} to {high} is none: give two numbers, the smaller one first", low = .0[0], high = .0[1])]
    Range([f64; 2]),
    /// Angles are finite.
    #[error("the angles of the view are not finite: give numbers")]
    Angles,
    /// A picture shows faces.
    #[error("it has no faces to draw: make points a surface first, as all commands do")]
    NoFaces,
    /// The channel is there.
    #[error("it has no {what} to show; {}", known_in_words(.known))]
    NoChannel {
        /// What is missing.
        what: String,
        /// Names of the vertex properties that there are.
        known: Vec<String>,
    },
    /// A channel has values.
    #[error("its vertex property \"{0}\" has no finite number: choose another channel")]
    NoValues(String),
    /// Something was completed.
    #[error(
        "no vertex of it is marked as completed, so there is nothing completed to look at: look at all"
    )]
    NothingCompleted,
    /// No base surface is known, and none fits.
    #[error(
        "it has no vertex property \"height\", and no plane, sphere, cylinder or cone fits it, so there are no heights: complete it first, or choose another channel"
    )]
    NoBase,
    /// See [`FitError`].
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The build can write pictures.
    #[cfg(not(feature = "image"))]
    #[error("this relievo was built without pictures; build it with `--features image`")]
    NotBuilt,
    /// The encoder could write.
    #[error("{0}")]
    Encode(String),
}

fn known_in_words(known: &[String]) -> String {
    let names: Vec<_> = known.iter().map(|name| format!("\"{name}\"")).collect();
    match names.as_slice() {
        [] => "its vertices have no properties".to_owned(),
        names => format!("its vertex properties are {}", names.join(", ")),
    }
}
