//! The sample at several resolutions.

mod grid;
mod surface;
#[cfg(test)]
mod tests;

pub(super) use grid::Grid;

use crate::neighborhood::{Place, Surface};
use crate::rng::Rng;

use super::TextureError;
use super::level::Window;
use super::params::Method;
use super::sample::{Kind, Sample};
use super::sites::has_sites;
use grid::of_image;
use surface::of_surface;

/// A sample: levels of half the resolution each, the finest first.
#[derive(Debug)]
pub(super) struct Pyramid {
    pub(super) levels: Vec<PyramidLevel>,
    /// Number C of values a vertex.
    pub(super) channels: usize,
}

/// A sample at one resolution. An image is a flat surface with a vertex a pixel.
#[derive(Debug)]
pub(super) struct PyramidLevel {
    pub(super) surface: Surface,
    /// Length of a texel, in the unit of the surface.
    pub(super) texel: f64,
    /// #V by C.
    pub(super) values: Vec<f32>,
    /// #V: whether there is something to copy.
    pub(super) known: Vec<bool>,
    /// #V: the vertices as places, with the texture's first axis.
    pub(super) places: Vec<Option<Place>>,
    /// #V: where they are on the next coarser level.
    pub(super) above: Vec<Option<Place>>,
    /// #V: where they are on the next finer level.
    pub(super) below: Vec<Option<Place>>,
    /// Width and height, of an image.
    pub(super) size: Option<[usize; 2]>,
    /// #V of the finest level: the pixel or the scan's vertex that each stands for; empty on others.
    pub(super) origins: Vec<u32>,
}

/// More values of neighborhoods than this are not held: they take 4 bytes each, and as much again in a tree.
const MOST_VALUES: usize = 300_000_000;

impl Pyramid {
    /// With up to `levels` levels; fewer if a whole neighborhood does not fit into the coarser ones.
    ///
    /// # Errors
    /// [`TextureError`] if it does not fit into any, or there are too many.
    pub(super) fn new(
        sample: &Sample,
        method: Method,
        levels: usize,
        rng: &mut Rng,
    ) -> Result<Self, TextureError> {
        let channels = sample.channels.count();
        let window = Window::of_level(0, levels, method);
        let offsets = |radius: usize| (2 * radius + 1).pow(2);
        let width = channels * (offsets(window.own) + window.coarse.map_or(0, offsets));
        let (texels, most) = (sample.texels(), MOST_VALUES / width);
        if texels > most {
            return Err(TextureError::SampleTooLarge { texels, most });
        }
        let mut levels = match &sample.kind {
            Kind::Image(grid) => of_image(grid, levels),
            Kind::Surface(surface) => of_surface(surface, channels, levels, rng),
        };
        while !levels.is_empty() {
            let count = levels.len();
            let fits = (levels.iter().enumerate()).all(|(k, level)| {
                let window = Window::of_level(k, count, method);
                has_sites(level, levels.get(k + 1), &window)
            });
            if fits {
                return Ok(Self { levels, channels });
            }
            levels.pop();
        }
        Err(too_small(
            sample,
            2 * Window::of_level(0, 1, method).own + 1,
        ))
    }
}

fn too_small(sample: &Sample, window: usize) -> TextureError {
    match &sample.kind {
        Kind::Image(grid) => TextureError::SampleTooSmall {
            width: grid.width,
            height: grid.height,
            window,
        },
        Kind::Surface(_) => TextureError::SampleSurfaceTooSmall { window },
    }
}

impl PyramidLevel {
    /// Where a place of this level is on the next finer one.
    pub(super) fn one_finer(&self, place: &Place, finer: &Self) -> Option<Place> {
        let vertex = self.nearest(place);
        let at_vertex = self.places[vertex as usize]?;
        let from = self.surface.positions()[vertex as usize];
        let offset = self
            .surface
            .to_local(&at_vertex, &(self.surface.position(place) - from));
        finer.surface.walk(&self.below[vertex as usize]?, offset)
    }

    /// The place with the texture's first axis, from which walks may have turned off: that of the vertex nearest to
    /// it.
    pub(super) fn straightened(&self, place: &Place) -> Place {
        let vertex = self.nearest(place);
        let Some(there) = self.places[vertex as usize] else {
            return *place;
        };
        let shares = self.surface.barycentric(place);
        let axis = self.surface.axis(&there);
        self.surface
            .in_triangle(place.triangle, shares, &axis)
            .unwrap_or(*place)
    }

    /// The vertex nearest to a place.
    pub(super) fn nearest(&self, place: &Place) -> u32 {
        let weights = self.surface.barycentric(place);
        let corners = self.surface.corners(place.triangle);
        let mut best = 0;
        for k in 1..3 {
            if weights[k] > weights[best] {
                best = k;
            }
        }
        corners[best]
    }
}
