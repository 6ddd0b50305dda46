//! Hole and base surface to target vertices and the triangulation that stitches them to the scan;
//! and 1-to-4 subdivision of the sample surface.
//!
//! # Reference
//! [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), §4.

mod fill;
mod lattice;
mod rectangle;
mod rims;
mod spacing;
mod subdivide;
#[cfg(test)]
mod tests;

pub use fill::{Fill, FillError, Gap, fill, is_bounded};
pub use spacing::{EdgeSpacing, SpacingRule, edge_spacing};
pub use subdivide::{Subdivision, subdivide};
