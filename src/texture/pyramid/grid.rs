//! The levels of an image.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::mesh::TriMesh;
use crate::neighborhood::{Place, Surface};

use super::PyramidLevel;

/// Values on a grid of pixels, row by row from the top.
#[derive(Debug, Clone)]
pub(in crate::texture) struct Grid {
    pub(in crate::texture) width: usize,
    pub(in crate::texture) height: usize,
    pub(in crate::texture) channels: usize,
    /// Pixels by channels.
    pub(in crate::texture) values: Vec<f32>,
    /// Whether a pixel is part of the sample.
    pub(in crate::texture) known: Vec<bool>,
}

impl Grid {
    pub(super) fn pixels(&self) -> impl Iterator<Item = [usize; 2]> {
        let width = self.width;
        (0..self.width * self.height).map(move |i| [i % width, i / width])
    }

    /// Half the resolution: every other pixel of the image filtered with the binomials (1, 4, 6, 4, 1) along both
    /// axes, mirrored at the border. Pixels that are not known do not count; what is left without any that is, or
    /// is one of them, is not known.
    ///
    /// # Reference
    /// P. J. Burt, E. H. Adelson: *The Laplacian pyramid as a compact image code.* IEEE Transactions on
    /// Communications 31(4), 532–540, 1983.
    pub(super) fn reduced(&self) -> Self {
        const WEIGHTS: [f32; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut reduced = Self {
            width,
            height,
            channels: self.channels,
            values: vec![0.0; width * height * self.channels],
            known: vec![false; width * height],
        };
        for (i, [x, y]) in (reduced.pixels().collect::<Vec<_>>().into_iter()).enumerate() {
            let out = &mut reduced.values[i * self.channels..][..self.channels];
            let mut total = 0.0;
            for (dy, wy) in WEIGHTS.iter().enumerate() {
                let row = mirrored(2 * y + dy, self.height);
                for (dx, wx) in WEIGHTS.iter().enumerate() {
                    let from = row * self.width + mirrored(2 * x + dx, self.width);
                    if self.known[from] {
                        let weight = wx * wy;
                        total += weight;
                        let values = &self.values[from * self.channels..][..self.channels];
                        for (out, value) in out.iter_mut().zip(values) {
                            *out += weight * value;
                        }
                    }
                }
            }
            if total > 0.0 {
                for out in out {
                    *out /= total;
                }
            }
            reduced.known[i] = self.known[2 * y * self.width + 2 * x];
        }
        reduced
    }

    /// Pixel (x, y) is at (x, −y)·`texel`, so that the image's rows run along the first axis and its columns
    /// downwards.
    pub(in crate::texture) fn mesh(&self, texel: f64) -> TriMesh {
        let width = self.width;
        let index = |i: usize| u32::try_from(i).expect("pixels are u32");
        let positions = (self.pixels())
            .map(|[x, y]| Point3::new(x as f64 * texel, -(y as f64) * texel, 0.0))
            .collect();
        let triangles = (self.pixels())
            .filter(|[x, y]| x + 1 < width && y + 1 < self.height)
            .flat_map(|[x, y]| {
                let corner = y * width + x;
                let [a, b, c, d] =
                    [corner, corner + 1, corner + width, corner + width + 1].map(index);
                [[a, c, b], [b, c, d]]
            })
            .collect();
        TriMesh {
            positions,
            triangles,
        }
    }
}

/// Index `at` − 2 of a row of `count`, mirrored at its ends.
fn mirrored(at: usize, count: usize) -> usize {
    let last = count - 1;
    let inside = at.abs_diff(2);
    let folded = if inside > last {
        (2 * last).saturating_sub(inside)
    } else {
        inside
    };
    folded.min(last)
}

/// With up to `levels` levels; fewer if a side of the coarsest would have less than two pixels.
pub(super) fn of_image(finest: &Grid, levels: usize) -> Vec<PyramidLevel> {
    let mut grids = vec![finest.clone()];
    while grids.len() < levels {
        let grid = &grids[grids.len() - 1];
        if grid.width.min(grid.height) < 4 {
            break;
        }
        grids.push(grid.reduced());
    }
    let surfaces: Vec<(f64, Surface)> = (grids.iter().enumerate())
        .map(|(k, grid)| {
            let texel = (1u64 << k) as f64;
            (texel, Surface::new(grid.mesh(texel)))
        })
        .collect();
    let on = |k: usize, point: &Point3<f64>| {
        let (texel, surface) = surfaces.get(k)?;
        place_on_grid(surface, &grids[k], *texel, point)
    };
    (grids.iter().zip(&surfaces).enumerate())
        .map(|(k, (grid, (texel, surface)))| {
            let all = |level: Option<usize>| {
                let points = surface.positions().iter();
                points.map(|p| on(level?, p)).collect()
            };
            let pixels = u32::try_from(grid.known.len()).expect("pixels are u32");
            PyramidLevel {
                surface: surface.clone(),
                texel: *texel,
                values: grid.values.clone(),
                known: grid.known.clone(),
                places: all(Some(k)),
                above: all(Some(k + 1)),
                below: all(k.checked_sub(1)),
                size: Some([grid.width, grid.height]),
                origins: (0..if k == 0 { pixels } else { 0 }).collect(),
            }
        })
        .collect()
}

/// A point on the grid's surface; `None` beyond its border.
fn place_on_grid(surface: &Surface, grid: &Grid, texel: f64, point: &Point3<f64>) -> Option<Place> {
    let [x, y] = [point.x / texel, -point.y / texel];
    let column = x.floor().min(grid.width as f64 - 2.0);
    let row = y.floor().min(grid.height as f64 - 2.0);
    let within = |share: f64| (-1e-9..=1.0 + 1e-9).contains(&share);
    if !within(x - column) || !within(y - row) {
        return None;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a pixel"
    )]
    let vertex = row as u32 * u32::try_from(grid.width).ok()? + column as u32;
    let place = surface.at_vertex(vertex, &Vector3::x())?;
    #[expect(clippy::cast_possible_truncation, reason = "places are single")]
    let offset = [(x - column) * texel, -(y - row) * texel].map(|d| d as f32);
    surface.walk(&place, offset)
}

impl PyramidLevel {
    /// The values of an image filtered with (a, 1 − 2a, a) along both axes, so that independent ones vary by `sharpness` of
    /// what they do; as they are for a sharpness of 1, or of a surface, which is read between its vertices itself.
    pub(in crate::texture) fn blurred(&self, sharpness: f64, channels: usize) -> Vec<f32> {
        let Some([width, height]) = self.size.filter(|_| sharpness < 0.999) else {
            return self.values.clone();
        };
        // (1 − 2a)² + 2a² is the root of the sharpness, a at most a third.
        let root = sharpness.max(0.0).sqrt();
        let a = (4.0 - (16.0 - 24.0 * (1.0 - root)).max(0.0).sqrt()) / 12.0;
        #[expect(clippy::cast_possible_truncation, reason = "values are single")]
        let a = a.min(1.0 / 3.0) as f32;
        let along = |values: &[f32], step: usize, place: &(dyn Fn(usize) -> [usize; 2] + Sync)| {
            let filtered = (0..values.len()).into_par_iter().map(|i| {
                let [at, count] = place(i / channels);
                let step = step * channels;
                let before = if at > 0 { i - step } else { i };
                let after = if at + 1 < count { i + step } else { i };
                values[i] + a * (values[before] - 2.0 * values[i] + values[after])
            });
            filtered.collect::<Vec<f32>>()
        };
        let rows = along(&self.values, 1, &|pixel| [pixel % width, width]);
        along(&rows, width, &|pixel| [pixel / width, height])
    }
}
