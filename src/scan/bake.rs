//! Colors on a surface to a texture image, by its texture coordinates.

mod padding;
mod place;
mod surface;
#[cfg(test)]
mod tests;

pub use surface::bake_surface;

use rayon::prelude::*;
use serde::Serialize;

use super::Image;
use place::{Flat, Place};

/// Rows of the image that are drawn together. Any number gives the same image; this many keep the places of
/// their pixels in the cache.
const BAND: usize = 16;

/// How far, in pixels, a triangle colors pixels that it does not cover: to interpolate linearly at a place in
/// it takes pixels whose centers are up to √2 away.
const REACH: f64 = 1.5;

/// Images that a triangle may extend over along either axis. Textures that tile a wall need a few; more
/// are mostly mistakes, and each takes the time of drawing the whole image.
const MOST_REPEATS: f64 = 16.0;

/// No triangle.
const NONE: u32 = u32::MAX;

/// A texture image, and what it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Baked {
    /// The image, opaque, of 8 bits.
    pub image: Image,
    /// What it holds.
    pub report: BakeReport,
}

/// What a texture image holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct BakeReport {
    /// Pixels whose center is in a triangle.
    pub covered_pixels: usize,
    /// Pixels whose center is inside two triangles or more: other places of the surface show what the first
    /// one has there. Those on an edge that triangles share do not count.
    pub overlapping_pixels: usize,
    /// Triangles left out: their texture coordinates are not finite, have no area, or extend over more than
    /// 16 images.
    pub left_out_triangles: usize,
}

/// Draws the colors of a surface into an image.
///
/// `uv`: u and v of the corners of each triangle, u from 0 at the left border of the image to 1 at the right
/// one, v from 0 at the *bottom* to 1 at the top; beyond, the image repeats, as OBJ's textures do. `color`
/// gives red, green and blue, from 0 to 1 (clamped), at a place of a triangle by its number and barycentric
/// coordinates.
///
/// Every pixel whose center is in a triangle gets the color there (in the first one if there are several).
/// Pixels within 1.5 pixels of a triangle get the color of its nearest point, then 4 rings around them the
/// mean of their neighbors, and what is left means over larger and larger squares, of the whole image
/// at last: neither linear filtering nor smaller images made of this one (mipmaps) show seams. An image in
/// which nothing is covered is mid grey.
///
/// The same bytes for any number of threads.
///
/// # Panics
/// If the image has no pixels, or there are 2^32 triangles or more.
///
/// # Example
/// ```
/// use relievo::scan::bake;
///
/// let uv = [[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]];
/// let corners = |_, [a, b, c]: [f64; 3]| [a, b, c];
/// let baked = bake(64, 64, &uv, corners);
/// let lower_left = baked.image.colors[63 * 64];
/// assert!(lower_left[0] > 0.98);
/// assert_eq!(baked.report.covered_pixels, 64 * 65 / 2);
/// ```
#[must_use]
pub fn bake(
    width: u32,
    height: u32,
    uv: &[[[f64; 2]; 3]],
    color: impl Fn(usize, [f64; 3]) -> [f64; 3] + Sync,
) -> Baked {
    assert!(width > 0 && height > 0, "an image has pixels");
    let (columns, rows) = (width as usize, height as usize);
    let flats = flattened(uv, [columns, rows]);
    let bands = by_band(&flats, rows);
    let mut colors = vec![[0.0f32; 3]; columns * rows];
    let mut filled = vec![false; columns * rows];
    let counts: Vec<[usize; 2]> = (colors.par_chunks_mut(BAND * columns))
        .zip(filled.par_chunks_mut(BAND * columns))
        .zip(&bands)
        .enumerate()
        .map(|(number, ((colors, filled), triangles))| {
            let mut band = Band::new(number * BAND, [columns, rows]);
            for triangle in triangles {
                if let Some(flat) = &flats[*triangle as usize] {
                    band.draw(*triangle, flat);
                }
            }
            band.color(&color, colors, filled);
            band.counts()
        })
        .collect();
    padding::pad(&mut colors, &mut filled, columns);
    let equal = |[r, g, b]: &[f32; 3]| r.to_bits() == g.to_bits() && g.to_bits() == b.to_bits();
    Baked {
        report: BakeReport {
            covered_pixels: counts.iter().map(|c| c[0]).sum(),
            overlapping_pixels: counts.iter().map(|c| c[1]).sum(),
            left_out_triangles: flats.iter().filter(|flat| flat.is_none()).count(),
        },
        image: Image {
            width,
            height,
            is_grey: colors.iter().all(equal),
            colors,
            opaque: None,
            bits: 8,
        },
    }
}

/// The triangles on the image, in pixels; `None` for those that are left out.
fn flattened(uv: &[[[f64; 2]; 3]], [columns, rows]: [usize; 2]) -> Vec<Option<Flat>> {
    assert!(u32::try_from(uv.len()).is_ok_and(|n| n < NONE), "too many");
    let size = [columns as f64, rows as f64];
    uv.par_iter()
        .map(|corners| {
            let ends = |axis: usize| {
                let values = corners.map(|c| c[axis]);
                let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                (low.floor(), high - low)
            };
            let ((left, wide), (bottom, high)) = (ends(0), ends(1));
            let finite = corners.iter().flatten().all(|c| c.is_finite());
            let fits = wide <= MOST_REPEATS && high <= MOST_REPEATS;
            // Whole images away is the same place.
            let corner = |[u, v]: [f64; 2]| [(u - left) * size[0], (1.0 - (v - bottom)) * size[1]];
            (finite && fits)
                .then(|| Flat::new(corners.map(corner)))
                .flatten()
        })
        .collect()
}

/// The triangles that reach into each band, ascending.
fn by_band(flats: &[Option<Flat>], rows: usize) -> Vec<Vec<u32>> {
    let mut bands: Vec<Vec<u32>> = vec![Vec::new(); rows.div_ceil(BAND)];
    for (triangle, flat) in (0u32..).zip(flats) {
        let Some(flat) = flat else { continue };
        let [low, high] = flat.rows();
        // Once around is everywhere.
        let high = high.min(low + whole(rows) - 1);
        let mut row = low;
        while row <= high {
            let band = wrapped(row, rows) / BAND;
            if bands[band].last() != Some(&triangle) {
                bands[band].push(triangle);
            }
            // On to the next band, or around to the first one.
            let next = ((band + 1) * BAND).min(rows) - wrapped(row, rows);
            row += whole(next);
        }
    }
    bands
}

/// Where an unwrapped row or column is on the image.
fn wrapped(place: i64, size: usize) -> usize {
    usize::try_from(place.rem_euclid(whole(size))).unwrap_or_default()
}

/// Numbers of rows and columns fit.
fn whole(size: usize) -> i64 {
    i64::try_from(size).unwrap_or(i64::MAX)
}

/// Some rows of the image in the making.
struct Band {
    /// The first of them.
    first: usize,
    columns: usize,
    /// Of the whole image.
    rows: usize,
    pixels: Vec<Pixel>,
}

/// What is known of a pixel.
#[derive(Clone, Copy)]
struct Pixel {
    /// The triangle whose color it gets.
    triangle: u32,
    /// Whether two triangles have it inside.
    overlaps: bool,
    place: Place,
}

impl Pixel {
    const EMPTY: Self = Self {
        triangle: NONE,
        overlaps: false,
        place: Place {
            weights: [0.0; 3],
            distance_sq: f64::INFINITY,
        },
    };
}

impl Band {
    fn new(first: usize, [columns, rows]: [usize; 2]) -> Self {
        let pixels = vec![Pixel::EMPTY; BAND.min(rows - first) * columns];
        Self {
            first,
            columns,
            rows,
            pixels,
        }
    }

    /// Draws what a triangle has in these rows, wherever they repeat.
    fn draw(&mut self, triangle: u32, flat: &Flat) {
        let [low, high] = flat.rows();
        for within in 0..self.pixels.len() / self.columns {
            let behind = whole(self.first + within) - low;
            let mut row = low + behind.rem_euclid(whole(self.rows));
            while row <= high {
                self.draw_row(triangle, flat, row, within * self.columns);
                row += whole(self.rows);
            }
        }
    }

    fn draw_row(&mut self, triangle: u32, flat: &Flat, row: i64, start: usize) {
        let y = row as f64 + 0.5;
        let Some([left, right]) = flat.columns(y) else {
            return;
        };
        let mut at = wrapped(left, self.columns);
        for column in left..=right {
            let pixel = &mut self.pixels[start + at];
            at = if at + 1 == self.columns { 0 } else { at + 1 };
            if pixel.place.is_inside() && pixel.overlaps {
                continue;
            }
            let place = flat.place([column as f64 + 0.5, y]);
            if pixel.place.is_inside() && place.is_inside() {
                pixel.overlaps = true;
            } else if place.distance_sq < pixel.place.distance_sq
                && place.distance_sq <= REACH * REACH
            {
                (pixel.triangle, pixel.place) = (triangle, place);
            }
        }
    }

    fn color(
        &self,
        color: &impl Fn(usize, [f64; 3]) -> [f64; 3],
        colors: &mut [[f32; 3]],
        filled: &mut [bool],
    ) {
        for ((pixel, stored), filled) in self.pixels.iter().zip(colors).zip(filled) {
            if pixel.triangle != NONE {
                let color = color(pixel.triangle as usize, pixel.place.weights);
                *stored = color.map(intensity);
                *filled = true;
            }
        }
    }

    /// Pixels that are covered, and those that several triangles have inside.
    fn counts(&self) -> [usize; 2] {
        let covered = self.pixels.iter().filter(|p| p.place.is_covered());
        let overlapping = self.pixels.iter().filter(|p| p.overlaps);
        [covered.count(), overlapping.count()]
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "images do not tell intensities apart that finely"
)]
fn intensity(value: f64) -> f32 {
    value.clamp(0.0, 1.0) as f32
}
