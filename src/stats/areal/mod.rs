//! Areal surface texture parameters of ISO 25178-2, and the pieces that they are made of.
//!
//! | file | what it has | clauses of ISO 25178-2:2021 |
//! |---|---|---|
//! | `parameters` | [`ArealParameters`], all of them under the standard's names | 4.2 to 4.5 |
//! | `heights` | [`HeightParameters`] of heights with weights | 4.2 |
//! | `material_ratio` | [`MaterialRatioCurve`] of heights with weights | 4.5 |
//! | `spatial` | [`Autocorrelation`] → Sal and Str | 4.3.2, 4.3.3 |
//! | `direction` | [`Autocorrelation`] → Std | 4.3.4 |
//! | `grid` | height map → [`scale_limited_surface`] → [`ArealParameters::of_map`] | 4.2 to 4.5 |
//! | `form` | [`FormOperation`] | ISO 25178-3 |
//! | `filter` | areal Gaussian filter, [`long_waves`] | ISO 16610-61 |
//!
//! The upper five do not care where heights come from: a grid, or a triangulated relief whose vertices weigh as
//! much as the area around them.

mod direction;
mod error;
mod filter;
mod form;
pub(in crate::stats) mod fourier;
mod grid;
mod heights;
mod material_ratio;
mod parameters;
mod spatial;
mod sum;
#[cfg(test)]
mod tests;

pub use error::ArealError;
pub use filter::long_waves;
pub use form::FormOperation;
pub use grid::{SlopeRule, SurfaceParams, scale_limited_surface};
pub use heights::HeightParameters;
pub use material_ratio::{Core, MaterialRatioCurve, Volumes};
pub use parameters::{ArealParameters, ParameterUnit, Row};
pub use spatial::{Autocorrelation, CORRELATION_THRESHOLD};
