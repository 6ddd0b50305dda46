//! Square patches of heights, read by walking over the base surface.
//!
//! Power spectra and autocorrelations are defined on regular grids. On a curved or irregularly triangulated
//! surface such grids are laid out around many of its vertices, in tangent frames that follow the surface, so
//! that no global parameterisation is needed.

use std::ops::ControlFlow;

use nalgebra::Vector3;

use rustfft::FftDirection;
use rustfft::num_complex::Complex;

use crate::mesh::{Adjacency, TriMesh, spatial_order};
use crate::neighborhood::{Among, Channels, Stencil, Surface, View, Walker, smooth_frames};

use super::areal::Autocorrelation;
use super::areal::fourier::{fast_length, transform};

/// Half the side of a patch in steps, the largest first: larger ones tell of longer waves.
const RADII: [usize; 5] = [32, 24, 16, 12, 8];
/// So many patches of a part must be complete.
const LEAST: usize = 3;
/// Places that are tried in a part.
const TRIED: usize = 512;
/// 0.618… of it, odd: multiples of it visit every place, and every beginning is spread evenly.
const SCATTER: usize = 317;
/// Patches that are enough.
const ENOUGH: usize = 96;

/// Patches of a part of a surface, all of the same size.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Patches {
    /// Heights along a side.
    pub(super) side: usize,
    /// Distance of neighboring heights, in the scan's unit.
    pub(super) step: f64,
    /// Heights row by row, side · side of each patch.
    pub(super) heights: Vec<Vec<f64>>,
}

/// Reads patches off a surface.
pub(super) struct PatchReader<'a> {
    feet: &'a TriMesh,
    heights: &'a [f64],
    step: f64,
    surface: Surface,
    /// #V: first tangents.
    axes: Vec<Vector3<f64>>,
}

impl<'a> PatchReader<'a> {
    /// `feet` are the vertices' feet on the base surface, `normals` (unit) and `heights` are #V, `step` is the
    /// distance of neighboring heights.
    pub(super) fn new(
        feet: &'a TriMesh,
        normals: &[Vector3<f64>],
        heights: &'a [f64],
        step: f64,
    ) -> Self {
        let frames = smooth_frames(&Adjacency::new(feet), normals, &first_axis(normals));
        Self {
            feet,
            heights,
            step,
            surface: Surface::new(feet.clone()),
            axes: frames.iter().map(|frame| frame.axes[0]).collect(),
        }
    }

    /// The largest that a part (#V) has room for; `None` if there is none.
    pub(super) fn largest(&self, part: &[bool]) -> Option<Patches> {
        let vertices = vertices_of(self.feet, part);
        RADII
            .into_iter()
            .find_map(|radius| self.read(&vertices, radius))
    }

    /// Of the size of others.
    pub(super) fn like(&self, others: &Patches, part: &[bool]) -> Option<Patches> {
        self.read(&vertices_of(self.feet, part), others.side / 2)
    }

    /// Complete patches around some of the vertices of a part.
    fn read(&self, vertices: &[u32], radius: usize) -> Option<Patches> {
        // Single readings keep more digits of heights about their mean.
        let count = vertices.len().max(1) as f64;
        let sum: f64 = vertices.iter().map(|v| self.heights[*v as usize]).sum();
        let mean = sum / count;
        let mut channels = Channels::new(self.heights.len(), 1);
        for v in vertices {
            #[expect(clippy::cast_possible_truncation, reason = "channels are single")]
            let height = (self.heights[*v as usize] - mean) as f32;
            channels.set(*v as usize, &[height], &[Among::Known]);
        }
        let stencil = Stencil::square(radius, self.step);
        let view = View {
            surface: &self.surface,
            channels: &channels,
            stencil: &stencil,
            among: Among::Known,
        };
        let mut walker = Walker::default();
        let complete = spread(vertices).filter_map(|v| {
            let mut patch = patch(&view, &mut walker, v, &self.axes[v as usize], radius)?;
            for height in &mut patch {
                *height += mean;
            }
            Some(patch)
        });
        let heights: Vec<Vec<f64>> = complete.take(ENOUGH).collect();
        (heights.len() >= LEAST).then_some(Patches {
            side: 2 * radius + 1,
            step: self.step,
            heights,
        })
    }
}

/// The axis of space that the surface lies along most: nowhere (nearly) is it normal to it.
fn first_axis(normals: &[Vector3<f64>]) -> Vector3<f64> {
    let along = |axis: &Vector3<f64>| normals.iter().map(|n| n.dot(axis).powi(2)).sum::<f64>();
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let least = (axes.into_iter()).min_by(|a, b| along(a).total_cmp(&along(b)));
    least.unwrap_or_else(Vector3::x)
}

/// The vertices of a part, in the order of a walk through it.
fn vertices_of(feet: &TriMesh, part: &[bool]) -> Vec<u32> {
    let vertices: Vec<u32> = (0u32..)
        .zip(part)
        .filter(|(_, is)| **is)
        .map(|(v, _)| v)
        .collect();
    spatial_order(&feet.positions, vertices)
}

/// Vertices spread over all of a part, each once; so is any beginning of the list.
fn spread(order: &[u32]) -> impl Iterator<Item = u32> {
    let (count, places) = (order.len(), TRIED.min(order.len()));
    (0..TRIED)
        .map(|k| k * SCATTER % TRIED)
        .filter(move |k| *k < places)
        .map(move |k| order[k * count / places])
}

fn patch(
    view: &View,
    walker: &mut Walker,
    v: u32,
    axis: &Vector3<f64>,
    radius: usize,
) -> Option<Vec<f64>> {
    let side = 2 * radius + 1;
    let place = view.surface.at_vertex(v, axis)?;
    let mut patch = vec![f64::NAN; side * side];
    let mut complete = true;
    let offsets = 0..u32::try_from(view.stencil.len()).ok()?;
    walker.visit(view, &place, offsets, |j, reading| {
        let Some(reading) = reading else {
            complete = false;
            return ControlFlow::Break(());
        };
        let [x, y] = view.stencil.offsets()[j].map(|offset| {
            let steps = f64::from(offset) / view.stencil.spacing();
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "from 0 to the side"
            )]
            let index = (steps.round() + radius as f64) as usize;
            index
        });
        patch[y * side + x] = f64::from(reading.values()[0]);
        ControlFlow::Continue(())
    });
    complete.then_some(patch)
}

impl Patches {
    /// The autocorrelation about the mean height: of all pairs of heights within one patch.
    pub(super) fn autocorrelation(&self) -> Option<Autocorrelation> {
        let (patches, side) = (&self.heights, self.side);
        let count = (patches.len() * side * side) as f64;
        let mean = patches.iter().flatten().sum::<f64>() / count;
        let reach = side / 2;
        let length = fast_length(side + reach);
        // The transform of a sum of autocovariances is the sum of the patches' power.
        let mut power = vec![Complex::default(); length * length];
        let mut grid = power.clone();
        for patch in patches {
            grid.fill(Complex::default());
            for (i, height) in patch.iter().enumerate() {
                grid[i / side * length + i % side] = Complex::from(height - mean);
            }
            transform(&mut grid, length, length, FftDirection::Forward);
            for (sum, value) in power.iter_mut().zip(&grid) {
                *sum += value.norm_sqr();
            }
        }
        transform(&mut power, length, length, FftDirection::Inverse);
        let scale = patches.len() as f64 * (length * length) as f64;
        let lags = 2 * reach + 1;
        let covariance = (0..lags * lags)
            .map(|k| {
                let lag = |k: usize| (k + length - reach) % length;
                let pairs = |k: usize| (side - k.abs_diff(reach)) as f64;
                let (column, row) = (k % lags, k / lags);
                power[lag(row) * length + lag(column)].re / (scale * pairs(column) * pairs(row))
            })
            .collect();
        Autocorrelation::new([reach; 2], [self.step; 2], covariance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Point3;

    #[test]
    fn the_autocorrelation_is_the_mean_product_of_pairs() {
        let side = 17;
        let value = |p: usize, i: usize| ((p * 31 + i * i * 7 + i * 3) % 23) as f64;
        let patch = |p: usize| (0..side * side).map(|i| value(p, i)).collect::<Vec<f64>>();
        let patches = Patches {
            side,
            step: 0.5,
            heights: vec![patch(1), patch(2)],
        };
        let mean = patches.heights.iter().flatten().sum::<f64>() / 578.0;
        let covariance = |di: usize, dj: usize| {
            let (mut sum, mut count) = (0.0, 0.0f64);
            for p in &patches.heights {
                for row in 0..side - dj {
                    for column in 0..side - di {
                        let (a, b) = (p[row * side + column], p[(row + dj) * side + column + di]);
                        sum += (a - mean) * (b - mean);
                        count += 1.0;
                    }
                }
            }
            sum / count
        };
        let correlation = patches.autocorrelation().unwrap();
        for (di, dj) in [(0, 0), (1, 0), (0, 1), (3, 5), (8, 8)] {
            assert_relative_eq!(
                correlation.at(di.try_into().unwrap(), dj.try_into().unwrap()),
                covariance(di, dj) / covariance(0, 0),
                epsilon = 1e-9
            );
        }
    }

    #[test]
    fn patches_read_the_heights_of_their_lattice() {
        let size = 60u32;
        let mut feet = TriMesh::default();
        for v in 0..size * size {
            let (x, y) = (f64::from(v % size), f64::from(v / size));
            feet.positions.push(Point3::new(x, y, 0.0));
            if v % size + 1 < size && v / size + 1 < size {
                feet.triangles
                    .extend([[v, v + 1, v + size + 1], [v, v + size + 1, v + size]]);
            }
        }
        let heights: Vec<f64> = (feet.positions.iter())
            .map(|p| 5.0 + 0.1 * p.x - 0.2 * p.y)
            .collect();
        let normals = vec![Vector3::z(); heights.len()];
        let part = vec![true; heights.len()];
        let none = vec![false; heights.len()];
        let reader = PatchReader::new(&feet, &normals, &heights, 1.0);
        let patches = reader.largest(&part).unwrap();
        assert_eq!(patches.side, 49);
        for patch in &patches.heights {
            let middle = patch[24 * 49 + 24];
            for (i, height) in patch.iter().enumerate() {
                let (x, y) = ((i % 49) as f64 - 24.0, (i / 49) as f64 - 24.0);
                // Which way the axes lie is up to the frames, but both keep the plane's slope.
                let slope = (height - middle).abs();
                assert!(slope <= 0.05f64.sqrt() * x.hypot(y) + 1e-4);
            }
            let corner = |i: usize| patch[i] - middle;
            assert_relative_eq!(corner(0), -corner(49 * 49 - 1), epsilon = 1e-4);
        }
        assert_eq!(reader.largest(&none), None);
        let corner: Vec<bool> = (0..part.len())
            .map(|v| v % 60 < 30 && v < 60 * 30)
            .collect();
        let small = reader.largest(&corner).unwrap();
        assert_eq!(small.side, 25);
        assert_eq!(reader.like(&small, &part).unwrap().side, 25);
    }
}
