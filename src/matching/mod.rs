//! Neighborhood and samples to best matches over all rotations.
//!
//! [`paper`] is the paper's metric, searched exhaustively.

pub mod paper;
