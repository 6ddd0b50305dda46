//! What a completion did.

use serde::{Deserialize, Serialize};

use crate::base::{FitReport, Form, WavelengthChoice};
use crate::progress::StageTime;
use crate::sampling::EdgeSpacing;

/// What [`super::complete`] did. Lengths are in the scan's unit.
#[derive(Debug, Clone, Serialize)]
pub struct CompletionReport {
    /// The base surface of the whole scan.
    pub fit: FitReport,
    /// Whether it lies under the whole scan; if not, heights are over the free form, or by the paper's method,
    /// where each hole has a base surface of its own, not known for original vertices (NaN).
    pub base_fits: bool,
    /// Edge lengths and the spacing of new vertices.
    pub spacing: EdgeSpacing,
    /// Loops filled, in the order of their numbers.
    pub filled: Vec<FilledHole>,
    /// Loops that were chosen but could not be filled.
    pub skipped: Vec<SkippedHole>,
    /// Vertices and faces before and after, samples searched, and the like.
    pub counts: Counts,
    /// What was searched, on the scan's own base surface and on those of single holes.
    pub searched: Searched,
    /// Every parameter that follows from the scan unless it is given, with the reason for its value: the
    /// spacing, then those of the scan's own base surface, then those of the free form. None by the paper's
    /// method.
    pub chosen: Vec<Chosen>,
    /// The free form under holes that do not lie on the base surface.
    pub free_form: Option<FreeFormReport>,
    /// Wall-clock seconds by stage, in order.
    pub seconds: Vec<StageTime>,
}

/// Sizes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Vertices of the input.
    pub original_vertices: usize,
    /// Faces of the input.
    pub original_faces: usize,
    /// Vertices added.
    pub completed_vertices: usize,
    /// Faces added.
    pub completed_faces: usize,
    /// Vertices that were copied from, on the scan's own base surface or on free form, whichever has more; by
    /// the paper's method after subdivision.
    pub samples: usize,
    /// Boundary loops of the input.
    pub loops: usize,
    /// Outer rims among them that were not chosen.
    pub rims_left: usize,
    /// Holes among them that were not chosen.
    pub holes_left: usize,
    /// Vertices of stray pieces of surface: kept, but neither fitted to nor copied from.
    pub stray_vertices: usize,
}

/// What a search over neighborhoods on a stencil looked at, and where its matches came from. All 0
/// by the paper's method.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Searched {
    /// Sites that were looked at for every new vertex (on the base surface with the most).
    pub sites: usize,
    /// Sites that there are; more than `sites` if they were thinned to the given number or to the
    /// memory.
    pub sites_offered: usize,
    /// Whether there are fewer sites than asked for because `memory` does not hold more.
    pub thinned_by_memory: bool,
    /// Bytes of the tables.
    pub table_bytes: usize,
    /// New vertices that continue what a neighbor was copied from.
    pub continued: usize,
    /// New vertices copied from a place like one that continues a neighbor's source.
    pub similar: usize,
    /// New vertices copied from the best of all sites.
    pub global: usize,
    /// How good the matches are, if that was asked for.
    pub recall: Option<Recall>,
}

/// How often the searches find a match that costs at most 1.1 times as much as the best of all places
/// at all rotations.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Recall {
    /// New vertices that were searched for by every way.
    pub audited: usize,
    /// Places times rotations that they were compared with.
    pub compared: usize,
    /// Share of them matched as well by what continues the neighbors' sources alone.
    pub continuing: f64,
    /// The same, with what is similar to that.
    pub coherent: f64,
    /// The same, with the best of all sites and random search around it.
    pub all: f64,
}

impl Searched {
    /// Adds what was searched on another base surface.
    pub(super) fn add(&mut self, other: &Self) {
        self.sites = self.sites.max(other.sites);
        self.sites_offered = self.sites_offered.max(other.sites_offered);
        self.thinned_by_memory |= other.thinned_by_memory;
        self.table_bytes = self.table_bytes.max(other.table_bytes);
        self.continued += other.continued;
        self.similar += other.similar;
        self.global += other.global;
        if let Some(recall) = &other.recall {
            self.recall.get_or_insert_default().add(recall);
        }
    }
}

impl Recall {
    /// Adds what was found for further new vertices.
    pub(super) fn add(&mut self, other: &Self) {
        let audited = self.audited + other.audited;
        let share = |own: f64, others: f64| {
            let sum = own * self.audited as f64 + others * other.audited as f64;
            sum / audited.max(1) as f64
        };
        *self = Self {
            audited,
            compared: self.compared.max(other.compared),
            continuing: share(self.continuing, other.continuing),
            coherent: share(self.coherent, other.coherent),
            all: share(self.all, other.all),
        };
    }
}

/// A parameter that was chosen, or given.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chosen {
    /// Name of its option, without dashes in front.
    pub name: &'static str,
    /// Its value; a length in the scan's unit.
    pub value: f64,
    /// Why, in words.
    pub reason: String,
}

/// The free form under some holes and their surroundings. Lengths are in the scan's unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FreeFormReport {
    /// What is longer is form, what is shorter is relief.
    pub wavelength: f64,
    /// How the wavelength was chosen, unless it was given.
    pub choice: Option<WavelengthChoice>,
    /// Root mean square height over it.
    pub rms: f64,
    /// Largest absolute height that counts as relief.
    pub reach: f64,
}

/// A gap that was filled.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FilledHole {
    /// Numbers of the boundary loops around it.
    pub loops: Vec<usize>,
    /// New vertices.
    pub vertices: usize,
    /// New faces.
    pub faces: usize,
    /// Mean normalised cost of the matches, in [0, 1]; 0 where no vertex was needed.
    pub mean_cost: f64,
    /// Largest.
    pub worst_cost: f64,
    /// What it was filled on, where it does not lie on the scan's base surface.
    pub own_base: Option<Form>,
}

/// A gap that was not filled.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SkippedHole {
    /// Numbers of the boundary loops around it.
    pub loops: Vec<usize>,
    /// Why, in words.
    pub reason: String,
}
