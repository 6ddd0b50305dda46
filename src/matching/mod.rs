//! Neighborhood and samples to best matches over all rotations.
//!
//! [`exhaustive`] is the paper's metric over every sample and every rotation: the reference that
//! anything faster is tested against.

pub mod exhaustive;
mod point_triangle;
mod query;
mod samples;
mod site_grid;
mod slab;
#[cfg(test)]
mod tests;

pub use exhaustive::{Match, Search, best_matches, match_cost};
pub use query::{Neighbor, Query};
pub use samples::{SampleId, Samples};
