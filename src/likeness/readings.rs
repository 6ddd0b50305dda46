//! What a vertex sees around it, at distances that do not depend on how densely vertices stand.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::neighborhood::{Among, Stencil, Surface, View, Walker};

use super::curved::CurvedChannels;

/// Directions that are looked in, evenly around.
pub(super) const SPOKES: usize = 12;
/// Directions up to their sign: differences to the left and to the right are the same figure.
pub(super) const DIRECTIONS: usize = SPOKES / 2;
/// Distances of the variogram, in median edges: half an octave apart, as far as whole numbers allow.
pub(super) const LAGS: [usize; 10] = [1, 2, 3, 4, 6, 8, 11, 16, 23, 32];
/// Rings of features, in median edges; each is one of the [`LAGS`].
const SCALES: [usize; 4] = [1, 2, 4, 8];
/// Features of each scale: see [`VertexReading::features`].
pub(super) const FEATURES: usize = 3 * SCALES.len();
/// A ring tells of its vertex if it is known in this many directions: the rest may lie beyond a rim.
const LEAST_SPOKES: usize = 9;

/// What one channel holds around one vertex. NaN for what is not known.
#[derive(Debug, Clone, Copy)]
pub(super) struct VertexReading {
    /// Mean of the ring at one median edge less the vertex's own value, in the channel's unit.
    pub(super) laplacian: f32,
    /// Squared differences to both sides, the mean of them, by direction and then [`LAGS`].
    pub(super) increments: [f32; DIRECTIONS * LAGS.len()],
    /// At 1, 2, 4, 8 median edges: value over the ring's mean, slope of the ring, its deviation from its
    /// mean and slope.
    pub(super) features: [f32; FEATURES],
}

impl VertexReading {
    const UNKNOWN: Self = Self {
        laplacian: f32::NAN,
        increments: [f32::NAN; DIRECTIONS * LAGS.len()],
        features: [f32::NAN; FEATURES],
    };

    /// Of a vertex's own value and the values by lag and spoke.
    fn of(own: f32, rings: &[[f32; SPOKES]; LAGS.len()]) -> Self {
        let mut reading = Self::UNKNOWN;
        for (lag, ring) in rings.iter().enumerate() {
            for direction in 0..DIRECTIONS {
                let there = [ring[direction], ring[direction + DIRECTIONS]];
                let known = there.into_iter().filter(|value| !value.is_nan());
                let count = known.clone().count();
                if count > 0 {
                    let sum: f32 = known.map(|value| (value - own).powi(2)).sum();
                    reading.increments[direction * LAGS.len() + lag] =
                        sum / if count == 2 { 2.0 } else { 1.0 };
                }
            }
            if let Some(scale) = SCALES.iter().position(|scale| *scale == LAGS[lag])
                && let Some(features) = ring_features(own, ring)
            {
                reading.features[3 * scale..][..3].copy_from_slice(&features);
            }
        }
        reading.laplacian = -reading.features[0];
        reading
    }
}

/// Own value over the mean, slope (difference across the radius) and the rest's deviation.
#[expect(clippy::cast_possible_truncation, reason = "readings are single")]
fn ring_features(own: f32, ring: &[f32; SPOKES]) -> Option<[f32; 3]> {
    let known = (ring.iter().enumerate()).filter(|(_, value)| !value.is_nan());
    let count = known.clone().count();
    if count < LEAST_SPOKES {
        return None;
    }
    let n = count as f64;
    let mean = known
        .clone()
        .map(|(_, value)| f64::from(*value))
        .sum::<f64>()
        / n;
    let (mut x, mut y, mut square) = (0.0, 0.0, 0.0);
    for (spoke, value) in known {
        let (sin, cos) = (TAU * spoke as f64 / SPOKES as f64).sin_cos();
        let rest = f64::from(*value) - mean;
        x += rest * cos;
        y += rest * sin;
        square += rest * rest;
    }
    let slope = 2.0 * x.hypot(y) / n;
    let rest = (square / n - 0.5 * slope * slope).max(0.0).sqrt();
    Some([(f64::from(own) - mean) as f32, slope as f32, rest as f32])
}

/// Reads the channels around every vertex: #V · C readings, those of a vertex next to each other.
///
/// `axes` has the first direction at each vertex, `step` is the median edge.
pub(super) fn read(
    surface: &Surface,
    curved: &CurvedChannels,
    axes: &[Vector3<f64>],
    step: f64,
) -> Vec<VertexReading> {
    let stencil = Stencil::fan(LAGS[LAGS.len() - 1], SPOKES, step);
    let view = View {
        surface,
        channels: &curved.channels,
        stencil: &stencil,
        among: Among::Known,
    };
    let count = curved.count;
    let mut readings = vec![VertexReading::UNKNOWN; axes.len() * count];
    let of_vertex = |walker: &mut Walker, (v, out): (usize, &mut [VertexReading])| {
        let Ok(vertex) = u32::try_from(v) else { return };
        if curved.channels.is(vertex, Among::Known) {
            read_vertex(&view, walker, vertex, &axes[v], out);
        }
    };
    (readings.par_chunks_mut(count).enumerate()).for_each_init(Walker::default, of_vertex);
    readings
}

fn read_vertex(
    view: &View,
    walker: &mut Walker,
    v: u32,
    axis: &Vector3<f64>,
    out: &mut [VertexReading],
) {
    let Some(place) = view.surface.at_vertex(v, axis) else {
        return;
    };
    let mut rings = vec![[[f32::NAN; SPOKES]; LAGS.len()]; out.len()];
    let offsets = 0..u32::try_from(view.stencil.len()).unwrap_or(0);
    walker.visit(view, &place, offsets, |j, reading| {
        let Some(j) = j.checked_sub(1) else {
            return ControlFlow::Continue(());
        };
        let (ring, spoke) = (j / SPOKES + 1, j % SPOKES);
        if let (Some(reading), Ok(lag)) = (reading, LAGS.binary_search(&ring)) {
            for (c, rings) in rings.iter_mut().enumerate() {
                rings[lag][spoke] = CurvedChannels::value(reading.values(), c);
            }
        }
        ControlFlow::Continue(())
    });
    for (c, (out, rings)) in out.iter_mut().zip(&rings).enumerate() {
        *out = VertexReading::of(CurvedChannels::own(view.channels.of(v), c), rings);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_tilted_plane_has_slope_and_nothing_else() {
        let mut rings = [[0.0f32; SPOKES]; LAGS.len()];
        for (ring, lag) in rings.iter_mut().zip(LAGS) {
            for (spoke, value) in ring.iter_mut().enumerate() {
                #[expect(clippy::cast_possible_truncation, reason = "single values")]
                let along = (TAU * spoke as f64 / SPOKES as f64).cos() as f32;
                *value = 5.0 + 0.5 * lag as f32 * along;
            }
        }
        let reading = VertexReading::of(5.0, &rings);
        assert_relative_eq!(reading.laplacian, 0.0, epsilon = 1e-5);
        for (scale, features) in SCALES.iter().zip(reading.features.chunks(3)) {
            assert_relative_eq!(features[0], 0.0, epsilon = 1e-5);
            assert_relative_eq!(features[1], 0.5 * *scale as f32, epsilon = 1e-4);
            assert_relative_eq!(features[2], 0.0, epsilon = 2e-3);
        }
        // Along the slope (0.5 · 8)², across it nothing.
        assert_relative_eq!(reading.increments[5], 16.0, epsilon = 1e-4);
        assert_relative_eq!(reading.increments[3 * LAGS.len() + 5], 0.0, epsilon = 1e-4);
    }

    #[test]
    fn what_lies_beyond_a_rim_is_unknown_not_zero() {
        let mut rings = [[1.0f32; SPOKES]; LAGS.len()];
        for ring in &mut rings {
            ring[..4].fill(f32::NAN);
        }
        let reading = VertexReading::of(0.0, &rings);
        assert!(reading.laplacian.is_nan());
        assert!(reading.increments.iter().all(|x| (*x - 1.0).abs() < 1e-6));
    }
}
