//! Hole and base surface to target vertices and the triangulation that stitches them to the scan;
//! and 1-to-4 subdivision of the sample surface.
//!
//! # Reference
//! [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), §4.

mod collapse;
mod fill;
mod lattice;
mod patch_mesh;
mod rectangle;
mod refine;
mod rims;
mod spacing;
mod span;
mod spanned;
mod subdivide;
#[cfg(test)]
mod tests;

pub use fill::{Fill, FillError, Gap, fill, is_bounded};
pub use spacing::{EdgeSpacing, SpacingRule, edge_spacing};
pub use spanned::Spanned;
pub use subdivide::{Subdivision, subdivide};
