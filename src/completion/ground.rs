//! The surface under scan and targets, and where on it each target was copied from.

use crate::matching::coherent::continuation;
use crate::neighborhood::{Among, Channels, Frame, Place, Stencil, Surface, View};

use super::growth::Canvas;
use super::scale::Scale;
use super::smooth_part::SmoothPart;

/// What is copied from, and what was copied so far.
pub(super) struct Ground {
    pub(super) surface: Surface,
    /// By vertex of the canvas.
    pub(super) frames: Vec<Frame>,
    pub(super) channels: Channels,
    scale: Scale,
    smooth: SmoothPart,
    /// Index of the first vertex that may have a source.
    first_source: usize,
    /// By vertex from there on: where it was copied from.
    sources: Vec<Option<Place>>,
}

/// Vertices of a canvas that are copied from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Originals<'a> {
    /// By vertex: whether it may be copied from.
    pub(super) copied: &'a [bool],
    /// By vertex: whether it was measured, and so has a say in what is smooth. More than those that are
    /// copied from where the canvas shows a part of the scan, on whose edge the smooth part is not known.
    pub(super) measured: &'a [bool],
}

impl Ground {
    /// Over a surface under scan and targets, with a frame for each vertex of the canvas. No vertex before
    /// `first_source` has a source.
    pub(super) fn new(
        canvas: &Canvas,
        surface: Surface,
        frames: Vec<Frame>,
        scale: Scale,
        originals: Originals,
        first_source: usize,
    ) -> Self {
        let mut channels = Channels::new(canvas.points.len(), scale.count());
        for (v, is_sample) in originals.copied.iter().enumerate() {
            let among: &[Among] = match (canvas.known[v], is_sample) {
                (true, true) => &[Among::Known, Among::Samples],
                (true, false) => &[Among::Known],
                (false, _) => continue,
            };
            let values = scale.channels(canvas, v);
            channels.set(v, &values[..scale.count()], among);
        }
        Self {
            smooth: SmoothPart::new(canvas, originals.measured),
            sources: vec![None; canvas.points.len() - first_source],
            surface,
            frames,
            channels,
            scale,
            first_source,
        }
    }

    pub(super) fn view<'a>(&'a self, stencil: &'a Stencil, among: Among) -> View<'a> {
        View {
            surface: &self.surface,
            channels: &self.channels,
            stencil,
            among,
        }
    }

    /// Where a vertex was copied from.
    pub(super) fn source(&self, v: usize) -> Option<Place> {
        self.sources[v.checked_sub(self.first_source)?]
    }

    /// Notes where a vertex was copied from.
    ///
    /// # Panics
    /// If it is one that has no source.
    pub(super) fn set_source(&mut self, v: usize, place: Place) {
        self.sources[v - self.first_source] = Some(place);
    }

    /// Notes that a vertex is known by now.
    pub(super) fn set_known(&mut self, canvas: &Canvas, v: usize) {
        let values = self.scale.channels(canvas, v);
        (self.channels).set(v, &values[..self.scale.count()], &[Among::Known]);
    }

    /// Makes samples of all targets that are known by now.
    pub(super) fn copy_from_all_known(&mut self, canvas: &Canvas) {
        for v in canvas.first_target..canvas.points.len() {
            if canvas.known[v] {
                let values = self.scale.channels(canvas, v);
                let among = [Among::Known, Among::Samples];
                (self.channels).set(v, &values[..self.scale.count()], &among);
            }
        }
        self.smooth = SmoothPart::new(canvas, &canvas.known);
    }

    /// Places that continue what the completed neighbors of a target were copied from, each once; places less than
    /// `same` apart (in the scan's unit) with nearly the same frame are one.
    pub(super) fn continued(&self, canvas: &Canvas, v: usize, same: f64) -> Vec<Place> {
        let feet = &canvas.relief.feet;
        let mut places: Vec<Place> = Vec::new();
        for n in canvas.adjacency.neighbors.row(v) {
            let n = *n as usize;
            let place = self.source(n).and_then(|source| {
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

    /// The height at a place: that of its measured vertex, and what the smooth part of the relief rises
    /// from there, within the heights measured around it. Interpolated heights would lack the scan's finest
    /// detail; those of the nearest vertex alone would be off by up to half an edge, which looks like grain.
    pub(super) fn height(&self, canvas: &Canvas, measured: u32, place: &Place) -> f64 {
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
        let source = self.source(v)?;
        let [from, to] = [v, n].map(|v| (&canvas.relief.feet[v], &self.frames[v]));
        let place = continuation(&self.surface, &source, from, to)?;
        Some(self.height(canvas, self.measured_vertex(&place)?, &place))
    }

    /// The sample nearest to a place. What is copied are its values as they were measured.
    pub(super) fn measured_vertex(&self, place: &Place) -> Option<u32> {
        let corners = self.surface.corners(place.triangle);
        let weights = self.surface.barycentric(place);
        (corners.into_iter().zip(weights))
            .filter(|(v, _)| self.channels.is(*v, Among::Samples))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(v, _)| v)
    }
}
