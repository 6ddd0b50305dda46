//! What to copy by neighborhoods on a stencil: coherent search, or all places.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::matching::coherent::{self, Search};
use crate::matching::exemplar::{Exemplar, ExemplarParams, least_bytes};
use crate::matching::exhaustive;
use crate::matching::query::{Found, Origin, Query};
use crate::neighborhood::{Among, Descriptor, Frame, Place, Stencil, View, Walker};
use crate::rng::{Rng, Stage};

use super::audit::{Audit, Verdict};
use super::ground::Ground;
use super::growth::{Canvas, Copied, Matcher, Wanted};
use super::report::Searched;

/// How to match on a stencil.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct StencilParams {
    pub(super) window: usize,
    pub(super) spacing: f64,
    /// Whether what continues the neighbors' sources is looked at; else only all the sites are.
    pub(super) coherent: bool,
    pub(super) exemplar: ExemplarParams,
    pub(super) search: Search,
    /// Share of the targets that are also searched exhaustively, to say how good the matches are.
    pub(super) audit: f64,
    /// Whether completed vertices become samples.
    pub(super) bootstrap: bool,
    /// Seed, and number of the patch: what the random picks follow from.
    pub(super) seed: [u32; 2],
}

impl StencilParams {
    /// Whether all is as [`super::CompleteParams::check`] lets it be.
    pub(super) fn is_in_range(&self) -> bool {
        let Self {
            exemplar, search, ..
        } = self;
        (1..=50).contains(&self.window)
            && self.spacing > 0.0
            && self.spacing.is_finite()
            && (1..=360).contains(&exemplar.rotations)
            && exemplar.most_sites >= 1
            && search.coherence >= 0.0
            && search.coherence.is_finite()
            && (0.0..=100.0).contains(&search.tolerance)
            && (0.0..=1.0).contains(&self.audit)
            && !self.bootstrap
    }
}

/// A matcher on a stencil.
pub(super) struct ByStencil {
    params: StencilParams,
    ground: Ground,
    stencil: Stencil,
    exemplar: Exemplar,
    audit: Option<Audit>,
    searched: Searched,
}

/// Where a target was copied from, and what an audit says of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source {
    found: Found,
    verdict: Option<Verdict>,
}

impl ByStencil {
    /// Copying from the samples of the ground.
    ///
    /// # Errors
    /// [`NothingToCopy`].
    pub(super) fn new(ground: Ground, params: StencilParams) -> Result<Self, NothingToCopy> {
        let stencil = Stencil::two_scales(params.window, params.spacing);
        let view = ground.view(&stencil, Among::Samples);
        let sites = |oversampled| sites(&view, &ground.frames, oversampled);
        let exemplar = Exemplar::new(&view, sites(!params.coherent), &params.exemplar)
            .ok_or_else(|| NothingToCopy::new(&view, &params.exemplar))?;
        // Against samples that become more an audit would compare with too few.
        let audit = if params.coherent && params.audit > 0.0 && !params.bootstrap {
            let left = params.exemplar.memory - exemplar.bytes().min(params.exemplar.memory);
            Audit::new(&view, sites(true), params.audit, left, &params.exemplar)
        } else {
            None
        };
        let searched = Searched {
            sites: exemplar.sites().len(),
            sites_offered: exemplar.offered(),
            thinned_by_memory: exemplar.thinned_by_memory(),
            table_bytes: exemplar.bytes(),
            recall: audit.as_ref().map(Audit::nothing_yet),
            ..Searched::default()
        };
        Ok(Self {
            params,
            ground,
            stencil,
            exemplar,
            audit,
            searched,
        })
    }

    /// Where the matches came from.
    pub(super) fn searched(&self) -> Searched {
        self.searched
    }

    /// What was copied from, and where from.
    pub(super) fn ground(&self) -> &Ground {
        &self.ground
    }

    fn view(&self, among: Among) -> View<'_> {
        self.ground.view(&self.stencil, among)
    }

    /// Reads what is known around a target.
    fn read_known(
        &self,
        canvas: &Canvas,
        wanted: &Wanted,
        walker: &mut Walker,
        known: &mut Descriptor,
    ) -> Option<()> {
        let v = canvas.first_target + wanted.target;
        let axis = &self.ground.frames[v].axes[0];
        let place = self.ground.surface.at_vertex(super::index(v), axis)?;
        // A target that was skipped sees no farther than its window.
        let count = if wanted.window < self.params.window {
            self.stencil.within(wanted.window)
        } else {
            self.stencil.len()
        };
        walker.gather(&self.view(Among::Known), &place, count, known);
        Some(())
    }

    /// The stream of random numbers of a target.
    fn rng(&self, wanted: &Wanted) -> Rng {
        let [seed, patch] = self.params.seed;
        Rng::of_part(seed, Stage::Matching, patch, super::index(wanted.target))
    }

    /// Coherent search for a target.
    fn find_coherently(
        &self,
        canvas: &Canvas,
        wanted: &Wanted,
        walker: &mut Walker,
        known: &mut Descriptor,
    ) -> Option<Copied<Source>> {
        self.read_known(canvas, wanted, walker, known)?;
        let v = canvas.first_target + wanted.target;
        let same = 0.1 * self.stencil.spacing();
        let search = coherent::Task {
            exemplar: &self.exemplar,
            view: &self.view(Among::Samples),
            query: &Query::new(known, &self.stencil),
            continued: &self.ground.continued(canvas, v, same),
            search: &self.params.search,
        };
        let mut rng = self.rng(wanted);
        // With random numbers of its own, so that the audit does not change what the search draws.
        let verdict = (self.audit.as_ref())
            .and_then(|audit| audit.verdict(&search, &mut rng.clone(), walker));
        let found = coherent::find(&search, &mut rng, walker)?;
        self.copied(canvas, Source { found, verdict })
    }

    /// Search through all sites for some targets together.
    fn find_exhaustively(&self, canvas: &Canvas, wanted: &[Wanted]) -> Vec<Option<Copied<Source>>> {
        let mut walker = Walker::default();
        let nothing = Descriptor::new(self.stencil.len(), self.ground.channels.count());
        let known: Vec<Descriptor> = (wanted.iter())
            .map(|wanted| {
                let mut known = nothing.clone();
                // Where the surface has no such vertex nothing is known.
                let _ = self.read_known(canvas, wanted, &mut walker, &mut known);
                known
            })
            .collect();
        let queries: Vec<exhaustive::Query> = (known.iter())
            .map(|descriptor| exhaustive::Query {
                descriptor,
                likely: &[],
            })
            .collect();
        let search = exhaustive::Search {
            tolerance: self.params.search.tolerance,
            ..exhaustive::Search::default()
        };
        let matches = exhaustive::best_matches_of_all(self.exemplar.table(), &queries, &search);
        (wanted.iter().zip(matches))
            .map(|(wanted, matches)| {
                let pick = self.rng(wanted).pick(&matches)?;
                let found = Found {
                    place: self.exemplar.place(pick.candidate),
                    cost: pick.cost,
                    origin: Origin::Global,
                };
                let verdict = None;
                self.copied(canvas, Source { found, verdict })
            })
            .collect()
    }

    /// What is copied from a place.
    fn copied(&self, canvas: &Canvas, source: Source) -> Option<Copied<Source>> {
        let place = &source.found.place;
        let vertex = self.ground.measured_vertex(place)?;
        Some(Copied {
            height: self.ground.height(canvas, vertex, place),
            color: canvas.colors.as_ref().map(|colors| colors[vertex as usize]),
            vertex,
            cost: f64::from(source.found.cost).min(1.0),
            source,
        })
    }
}

/// Why there is no exemplar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error, Serialize, Deserialize)]
pub(super) enum NothingToCopy {
    #[error(
        "the neighborhoods of a single place take {needed} bytes, and --memory allows {allowed}: allow more, or take a smaller --window or fewer --rotations"
    )]
    Memory { needed: usize, allowed: usize },
    #[error("there is nothing to copy from: no part of the scan lies on its base surface")]
    NoSample,
}

impl NothingToCopy {
    fn new(view: &View, params: &ExemplarParams) -> Self {
        let (needed, allowed) = (least_bytes(view, params), params.memory);
        if allowed < needed {
            Self::Memory { needed, allowed }
        } else {
            Self::NoSample
        }
    }
}

/// All samples as places; oversampled, with the places between them.
fn sites(view: &View, frames: &[Frame], oversampled: bool) -> Vec<Place> {
    let mut sites: Vec<Place> = (frames.iter().zip(0u32..))
        .filter(|(_, v)| view.channels.is(*v, Among::Samples))
        .filter_map(|(frame, v)| view.surface.at_vertex(v, &frame.axes[0]))
        .collect();
    if oversampled {
        sites.extend(edge_sites(view, frames));
    }
    sites
}

/// The middles of all edges between samples: with the vertices the places that the paper's oversampling
/// by 1-to-4 subdivision searches.
fn edge_sites(view: &View, frames: &[Frame]) -> Vec<Place> {
    (view.surface.edges())
        .filter_map(|(triangle, ends)| {
            let corners = view.surface.corners(triangle);
            let between_samples =
                (ends.iter()).all(|end| view.channels.is(corners[*end], Among::Samples));
            if !between_samples {
                return None;
            }
            let [a, b] = ends.map(|end| frames[corners[end] as usize].axes[0]);
            // Where the frames jump there is no direction between them.
            let axis = if a.dot(&b) > 0.0 { a + b } else { a };
            let mut weights = [0.0; 3];
            weights[ends[0]] = 0.5;
            weights[ends[1]] = 0.5;
            view.surface.in_triangle(triangle, weights, &axis)
        })
        .collect()
}

impl Matcher for ByStencil {
    type Source = Source;
    const BATCHES: bool = true;

    fn find(&mut self, canvas: &Canvas, wanted: &[Wanted]) -> Vec<Option<Copied<Source>>> {
        /// Fewer are done sooner than handed to other threads.
        const WORTH_SHARING: usize = 4;
        /// Searched through the table together, see [`exhaustive::best_matches_of_all`].
        const TOGETHER: usize = 16;
        if !self.params.coherent {
            return (wanted.par_chunks(TOGETHER))
                .flat_map_iter(|wanted| self.find_exhaustively(canvas, wanted))
                .collect();
        }
        let scratch = || {
            let known = Descriptor::new(self.stencil.len(), self.ground.channels.count());
            (Walker::default(), known)
        };
        (wanted.par_iter())
            .with_min_len(WORTH_SHARING)
            .map_init(scratch, |(walker, known), wanted| {
                self.find_coherently(canvas, wanted, walker, known)
            })
            .collect()
    }

    fn completed(&mut self, canvas: &Canvas, target: usize, copied: &Copied<Source>) {
        let v = canvas.first_target + target;
        let Source { found, verdict } = copied.source;
        self.ground.set_source(v, found.place);
        self.ground.set_known(canvas, v);
        if let (Some(recall), Some(verdict)) = (&mut self.searched.recall, verdict) {
            recall.count(verdict);
        }
        match found.origin {
            Origin::Continued => self.searched.continued += 1,
            Origin::Similar => self.searched.similar += 1,
            Origin::Global => self.searched.global += 1,
        }
    }

    fn front_ended(&mut self, canvas: &Canvas) {
        if !self.params.bootstrap {
            return;
        }
        self.ground.copy_from_all_known(canvas);
        let view = self.view(Among::Samples);
        let oversampled = !self.params.coherent;
        let sites = sites(&view, &self.ground.frames, oversampled);
        if let Some(renewed) = Exemplar::new(&view, sites, &self.params.exemplar) {
            self.searched.sites = renewed.sites().len();
            self.searched.sites_offered = renewed.offered();
            self.searched.table_bytes = renewed.bytes();
            self.exemplar = renewed;
        }
    }
}
