//! Plane with two sine waves crossing at right angles.

use std::f64::consts::TAU;

use nalgebra::Vector2;

use super::{Draw, Object, stream, tessellate};

/// Side of the square, in mm.
const SIDE: f64 = 100.0;
/// Wavelength, in mm: eight periods a side.
const WAVELENGTH: f64 = 12.5;
/// Amplitude of each of the two waves, in mm.
const AMPLITUDE: f64 = 0.8;

pub(super) fn object(vertices: usize, seed: u32) -> Object {
    let mut rng = stream(seed, Draw::Jitter);
    let tessellation = tessellate::plane(Vector2::new(SIDE, SIDE), vertices, &mut rng);
    let wave = |x: f64| AMPLITUDE * (TAU * x / WAVELENGTH).sin();
    Object {
        heights: tessellation
            .wall
            .iter()
            .map(|w| wave(w.x) + wave(w.y))
            .collect(),
        tessellation,
        colors: Vec::new(),
    }
}
