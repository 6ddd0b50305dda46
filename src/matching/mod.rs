//! Neighborhood and samples to best matches over all rotations.
//!
//! Two metrics: [`paper`] is the paper's distance to the sample surface. All else compares
//! neighborhoods as values on a stencil. A [`query`] is a partly known one, a [`table`] holds those of
//! all candidates, [`exhaustive`] compares the query with each of them, [`tree`] finds the nearest of
//! those of which everything is known, [`batch`] does so for many queries at once by comparing all, and [`nearby`] finds ones that are about as near. An [`exemplar`] is where on the sample surface the candidates
//! are, [`coherent`] search prefers what continues the neighbors' sources, [`local`] search makes a
//! match better, and [`randomized`] search
//! matches all vertices of a surface at once.

pub mod paper;
pub mod query;
pub mod table;
pub mod exhaustive;
pub mod tree;
pub mod batch;
pub mod nearby;
mod similar;
pub mod exemplar;
pub mod local;
pub mod coherent;
pub mod randomized;
#[cfg(test)]
mod tests;
