//! What to copy by neighborhoods on a stencil: coherent search, or all places.

use rayon::prelude::*;

use crate::matching::coherent::{self, Search, continuation};
use crate::matching::exemplar::{Exemplar, ExemplarParams, least_bytes};
use crate::matching::exhaustive;
use crate::matching::query::{Found, Origin, Query};
use crate::neighborhood::{
    Among, Channels, Descriptor, Frame, Place, Stencil, Surface, View, Walker,
};
use crate::rng::{Rng, Stage};

use super::audit::{Audit, Verdict};
use super::growth::{Canvas, Copied, Matcher, Wanted};
use super::report::Searched;
use super::smooth_part::SmoothPart;

/// How to match on a stencil.
#[derive(Debug, Clone, Copy)]
pub(super) struct StencilParams {
    pub(super) window: usize,
    pub(super) spacing: f64,
    /// μ: share of colour in the cost.
    pub(super) mu: f64,
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

/// A matcher on a stencil.
pub(super) struct ByStencil {
    params: StencilParams,
    surface: Surface,
    stencil: Stencil,
    channels: Channels,
    scale: Scale,
    exemplar: Exemplar,
    audit: Option<Audit>,
    frames: Vec<Frame>,
    smooth: SmoothPart,
    /// By target: where it was copied from.
    sources: Vec<Option<Place>>,
    searched: Searched,
}

/// Where a target was copied from, and what an audit says of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source {
    found: Found,
    verdict: Option<Verdict>,
}

/// From heights and colours to channels whose squared differences add up to a cost in [0, 1].
#[derive(Debug, Clone, Copy)]
struct Scale {
    /// Height that becomes 0.
    middle: f64,
    height: f64,
    color: f64,
}

impl Scale {
    /// Shares of shape and colour as in the paper's metric: over the square of the range of heights,
    /// and over 3, the largest squared distance of two colours.
    fn new(canvas: &Canvas, samples: &[bool], mu: f64) -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let [low, high] = (canvas.relief.heights.iter().zip(samples))
            .filter(|(_, is)| **is)
            .fold(none, |[low, high], (h, _)| [low.min(*h), high.max(*h)]);
        let mu = if canvas.colors.is_some() { mu } else { 0.0 };
        let range = high - low;
        Self {
            middle: 0.5 * (low + high),
            height: if range > 0.0 {
                (1.0 - mu).sqrt() / range
            } else {
                0.0
            },
            color: (mu / 3.0).sqrt(),
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "channels are single")]
    fn channels(&self, canvas: &Canvas, v: usize) -> ([f32; 4], usize) {
        let height = (canvas.relief.heights[v] - self.middle) * self.height;
        match &canvas.colors {
            Some(colors) if self.color > 0.0 => {
                let [r, g, b] = colors[v].map(|c| (c * self.color) as f32);
                ([height as f32, r, g, b], 4)
            }
            _ => ([height as f32, 0.0, 0.0, 0.0], 1),
        }
    }
}

impl ByStencil {
    /// Over the base under scan and targets, with a frame for each vertex of the canvas, copying from the
    /// vertices that are `samples`.
    ///
    /// # Errors
    /// In words, if there are no samples, or the memory does not hold the neighborhoods of one.
    pub(super) fn new(
        canvas: &Canvas,
        frames: Vec<Frame>,
        surface: Surface,
        samples: &[bool],
        params: StencilParams,
    ) -> Result<Self, String> {
        let stencil = Stencil::two_scales(params.window, params.spacing);
        let scale = Scale::new(canvas, samples, params.mu);
        let count = scale.channels(canvas, 0).1;
        let mut channels = Channels::new(canvas.points.len(), count);
        for (v, is_sample) in samples.iter().enumerate() {
            let among: &[Among] = match (canvas.known[v], is_sample) {
                (true, true) => &[Among::Known, Among::Samples],
                (true, false) => &[Among::Known],
                (false, _) => continue,
            };
            let (values, count) = scale.channels(canvas, v);
            channels.set(v, &values[..count], among);
        }
        let view = View {
            surface: &surface,
            channels: &channels,
            stencil: &stencil,
            among: Among::Samples,
        };
        let sites = |oversampled| sites(&view, &frames, oversampled);
        let exemplar = Exemplar::new(&view, sites(!params.coherent), &params.exemplar)
            .ok_or_else(|| nothing_to_copy(&view, &params.exemplar))?;
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
            sources: vec![None; canvas.points.len() - canvas.first_target],
            smooth: SmoothPart::new(canvas, samples),
            params,
            scale,
            exemplar,
            audit,
            frames,
            searched,
            surface,
            stencil,
            channels,
        })
    }

    /// Where the matches came from.
    pub(super) fn searched(&self) -> Searched {
        self.searched
    }

    fn view(&self, among: Among) -> View<'_> {
        View {
            surface: &self.surface,
            channels: &self.channels,
            stencil: &self.stencil,
            among,
        }
    }

    /// Places that continue what the completed neighbors of a target were copied from, each once.
    fn continued(&self, canvas: &Canvas, v: usize) -> Vec<Place> {
        let feet = &canvas.relief.feet;
        let same = 0.1 * self.stencil.spacing();
        let mut places: Vec<Place> = Vec::new();
        for n in canvas.adjacency.neighbors.row(v) {
            let n = *n as usize;
            let source = n
                .checked_sub(canvas.first_target)
                .and_then(|n| self.sources[n]);
            let place = source.and_then(|source| {
                let from = (&feet[n], &self.frames[n]);
                continuation(&self.surface, &source, from, (&feet[v], &self.frames[v]))
            });
            let Some(place) = place else { continue };
            let position = self.surface.position(&place);
            let is_new = |known: &Place| {
                (self.surface.position(known) - position).norm_squared() > same * same
                    || (self.surface.axis(known) - self.surface.axis(&place)).norm_squared() > 0.01
            };
            if places.iter().all(is_new) {
                places.push(place);
            }
        }
        places
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
        let axis = &self.frames[v].axes[0];
        let place = self.surface.at_vertex(super::index(v), axis)?;
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
        let search = coherent::Task {
            exemplar: &self.exemplar,
            view: &self.view(Among::Samples),
            query: &Query::new(known, &self.stencil),
            continued: &self.continued(canvas, canvas.first_target + wanted.target),
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
        let nothing = Descriptor::new(self.stencil.len(), self.channels.count());
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
        let vertex = self.measured_vertex(place)?;
        Some(Copied {
            height: self.height(canvas, vertex, place),
            color: canvas.colors.as_ref().map(|colors| colors[vertex as usize]),
            vertex,
            cost: f64::from(source.found.cost).min(1.0),
            source,
        })
    }

    /// The height at a place: that of its measured vertex, and what the smooth part of the relief rises
    /// from there, within the heights measured around it. Interpolated heights would lack the scan's finest
    /// detail; those of the nearest vertex alone would be off by up to half an edge, which looks like grain.
    fn height(&self, canvas: &Canvas, measured: u32, place: &Place) -> f64 {
        let height = canvas.relief.heights[measured as usize];
        let corners = self.surface.corners(place.triangle);
        if !corners.iter().all(|v| self.channels.is(*v, Among::Samples)) {
            return height;
        }
        let weights = self.surface.barycentric(place);
        let rise = (self.smooth).rise(&canvas.relief.feet, measured, corners, weights);
        let around = (canvas.adjacency.neighbors.row(measured as usize).iter())
            .filter(|n| self.channels.is(**n, Among::Samples))
            .map(|n| canvas.relief.heights[*n as usize]);
        let [low, high] = around.fold([height; 2], |[low, high], h| [low.min(h), high.max(h)]);
        (height + rise).clamp(low, high)
    }

    /// The height that the source of target vertex `v` shows at vertex `n`: what would be copied to `n` if
    /// it continued that source. `None` where samples end before.
    pub(super) fn continued_height(&self, canvas: &Canvas, v: usize, n: usize) -> Option<f64> {
        let source = self.sources[v.checked_sub(canvas.first_target)?]?;
        let [from, to] = [v, n].map(|v| (&canvas.relief.feet[v], &self.frames[v]));
        let place = continuation(&self.surface, &source, from, to)?;
        Some(self.height(canvas, self.measured_vertex(&place)?, &place))
    }

    /// The sample nearest to a place. What is copied are its values as they were measured.
    fn measured_vertex(&self, place: &Place) -> Option<u32> {
        let corners = self.surface.corners(place.triangle);
        let weights = self.surface.barycentric(place);
        (corners.into_iter().zip(weights))
            .filter(|(v, _)| self.channels.is(*v, Among::Samples))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(v, _)| v)
    }
}

/// Why there is no exemplar.
fn nothing_to_copy(view: &View, params: &ExemplarParams) -> String {
    let needed = least_bytes(view, params);
    if params.memory < needed {
        format!(
            "the neighborhoods of a single place take {needed} bytes, and --memory allows {}: allow more, or take a smaller --window or fewer --rotations",
            params.memory
        )
    } else {
        "there is nothing to copy from: no part of the scan lies on its base surface".to_owned()
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
            let known = Descriptor::new(self.stencil.len(), self.channels.count());
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
        self.sources[target] = Some(found.place);
        let (values, count) = self.scale.channels(canvas, v);
        self.channels.set(v, &values[..count], &[Among::Known]);
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
        for v in canvas.first_target..canvas.points.len() {
            if canvas.known[v] {
                let (values, count) = self.scale.channels(canvas, v);
                (self.channels).set(v, &values[..count], &[Among::Known, Among::Samples]);
            }
        }
        self.smooth = SmoothPart::new(canvas, &canvas.known);
        let view = self.view(Among::Samples);
        let oversampled = !self.params.coherent;
        let sites = sites(&view, &self.frames, oversampled);
        if let Some(renewed) = Exemplar::new(&view, sites, &self.params.exemplar) {
            self.searched.sites = renewed.sites().len();
            self.searched.sites_offered = renewed.offered();
            self.searched.table_bytes = renewed.bytes();
            self.exemplar = renewed;
        }
    }
}
