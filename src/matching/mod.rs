//! Neighborhood and samples to best matches over all rotations.
//!
//! [`paper`] is the paper's metric, searched exhaustively. [`table`] holds neighborhoods as values on
//! a stencil, and [`exhaustive`] compares a query with all of them. [`tree`] finds the nearest windows
//! of which everything is known.

pub mod paper;
pub mod table;
pub mod exhaustive;
pub mod tree;
