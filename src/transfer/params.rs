//! What is asked for.

use nalgebra::Vector3;
use serde::Serialize;

use super::{Pair, TransferError};

/// More vertices than this are refused before anything is allocated: fans take about 2 kB a vertex on each mesh.
pub const MOST_VERTICES: usize = 2_000_000;

/// Without a wish, the target gets as many vertices as the source has, up to this many.
const ENOUGH: usize = 65_536;

/// The texture cannot be larger or smaller than this by the given factor.
const MOST_SCALE: f64 = 16.0;

/// More rounds change nothing any more.
const MOST_ROUNDS: u32 = 100;

/// How a transfer is done.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TransferParams {
    /// Number of vertices on which the target is worked on. Default `None`: its own, or if these are fewer, as many as
    /// the source has, up to 65 536. More than the target's own are put on its edges; the surface stays as it is.
    pub vertices: Option<usize>,
    /// How large the texture is on the target, in units of its size on the source; both meshes are taken as of the same
    /// area. 1 by default.
    pub scale: f64,
    /// What tells which part of the target is like which of the source.
    pub shape: Shape,
    /// Direction that is up, of source and target, so that what is above is not confused with what is below; `None` for
    /// none. y by default.
    pub up: [Option<Vector3<f64>>; 2],
    /// How much shape counts against color, from 0 to 1: the share that it has on the finest level. 0.2 by default.
    pub shape_weight: f64,
    /// Share of its cost that a match is spared if it continues that of a neighbor, from 0 to below 1; 0.3 by default.
    pub coherence: f64,
    /// Penalty of a source vertex that is used twice as often as others, in units of the cost; 0.02 by default. More
    /// spreads the source's parts over the target where its shape does not tell.
    pub overuse: f64,
    /// Number of the target's vertices, on the finest level, whose matches are compared with the best of all; 0 by default.
    pub audit: usize,
    /// How rotations are compared.
    pub rotations: Rotations,
    /// Rounds of search and votes on each level; 5 by default, as in the paper.
    pub rounds: u32,
    /// What the target gets in the end.
    pub last: Last,
    /// Seed of all random choices.
    pub seed: u32,
}

impl Default for TransferParams {
    fn default() -> Self {
        Self {
            vertices: None,
            scale: 1.0,
            shape: Shape::HeatKernel,
            up: [Some(Vector3::y()); 2],
            shape_weight: 0.2,
            coherence: 0.3,
            overuse: 0.02,
            audit: 0,
            rotations: Rotations::All,
            rounds: 5,
            last: Last::Nearest,
            seed: 0,
        }
    }
}

/// What tells which part of the target is like which of the source.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// How heat spreads from each vertex: the same for tips, limbs and flat parts alike, wherever they are, and however
    /// limbs are bent.
    ///
    /// # Reference
    /// [Sun, Ovsjanikov & Guibas 2009](crate::bibliography#sun-ovsjanikov--guibas-2009).
    HeatKernel,
    /// Where a vertex is in its mesh, along x, y and z: for copies that were edited, and meshes in the same pose.
    Position,
    /// How far it is to places that belong together: pairs of vertices of source and target.
    ///
    /// # Reference
    /// [MeshMatch 2012](crate::bibliography#meshmatch-2012), geodesic affinities.
    #[serde(serialize_with = "count")]
    Affinities(Vec<Pair>),
    /// Nothing but `up`.
    None,
}

/// How many there are.
fn count<S: serde::Serializer>(pairs: &[Pair], serializer: S) -> Result<S::Ok, S::Error> {
    pairs.len().serialize(serializer)
}

/// How rotations are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rotations {
    /// All 18 in each comparison, as in the paper.
    All,
    /// Those that neighbors have, and some at random, as its further work proposes.
    Search,
}

/// What the target gets in the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Last {
    /// The value of each vertex's match: nothing is mixed.
    Nearest,
    /// Means over all patches that reach over a vertex: smoother.
    Vote,
}

impl TransferParams {
    /// Whether every parameter is in its range.
    ///
    /// # Errors
    /// [`TransferError`] for the first that is not.
    pub fn check(&self) -> Result<(), TransferError> {
        if let Some(asked) = self.vertices.filter(|n| !(3..=MOST_VERTICES).contains(n)) {
            return Err(TransferError::Vertices { asked });
        }
        if !(1.0 / MOST_SCALE..=MOST_SCALE).contains(&self.scale) {
            return Err(TransferError::Scale(self.scale));
        }
        if !(0.0..=1.0).contains(&self.shape_weight) {
            return Err(TransferError::ShapeWeight(self.shape_weight));
        }
        if !(0.0..1.0).contains(&self.coherence) {
            return Err(TransferError::Coherence(self.coherence));
        }
        if !(self.overuse >= 0.0 && self.overuse.is_finite()) {
            return Err(TransferError::Overuse(self.overuse));
        }
        if !(1..=MOST_ROUNDS).contains(&self.rounds) {
            return Err(TransferError::Rounds(self.rounds));
        }
        let is_direction = |d: &Vector3<f64>| d.iter().all(|x| x.is_finite()) && d.norm() > 0.0;
        if !self.up.iter().flatten().all(is_direction) {
            return Err(TransferError::Up);
        }
        Ok(())
    }

    /// Number of vertices to work on, of a source and a target of so many.
    pub(super) fn counts(&self, source: usize, target: usize) -> Result<[usize; 2], TransferError> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates far beyond what is allowed"
        )]
        let scaled = |n: usize, by: f64| (n as f64 * by).round() as usize;
        let area = self.scale * self.scale;
        let detail = scaled(source, 1.0 / area).min(ENOUGH);
        let of_target = target.max(self.vertices.unwrap_or(detail));
        let of_source = scaled(of_target, area);
        match of_target.max(of_source) {
            most if most > MOST_VERTICES => Err(TransferError::Vertices { asked: most }),
            _ => Ok([of_source, of_target]),
        }
    }
}
