//! How far a synthesized texture is from its sample, in figures; nothing here is for users of the library.
//!
//! Every function takes two [`Grid`]s and is the same on every run. What a figure means is best seen against
//! [`between_halves`]: how far one half of the sample is from the other.
#![allow(dead_code, reason = "each crate that includes it uses its own share")]

// The paths are spelled out, so that benches and tests can both include this file.
#[path = "texture_measures/copies.rs"]
mod copies;
#[path = "texture_measures/distribution.rs"]
mod distribution;
#[path = "texture_measures/grid.rs"]
mod grid;
#[path = "texture_measures/patches.rs"]
mod patches;
#[path = "texture_measures/spectrum.rs"]
mod spectrum;

#[allow(
    unused_imports,
    reason = "each crate that includes it uses its own share"
)]
pub(crate) use {
    copies::{Copies, Source, copies},
    distribution::{gradient_distance, least_histogram_correlation, wasserstein},
    grid::{Grid, between_halves},
    patches::{coarse_sliced_wasserstein, sliced_wasserstein},
    spectrum::spectrum_distance,
};
