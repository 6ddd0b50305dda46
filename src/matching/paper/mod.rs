//! The paper's metric: squared distances from the target's known neighbors to the triangles of the
//! sample surface, over every sample and every rotation.
//!
//! # Reference
//! [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), §3.

mod cells;
mod envelope;
mod lower_bounds;
mod query;
mod samples;
mod search;
mod site_grid;
mod slab;
#[cfg(test)]
mod tests;

pub use query::{Neighbor, Query};
pub use samples::{SampleId, Samples};
pub use search::{Match, Search, best_matches, match_cost};
