//! Plane with band-limited random relief: a sum of many sine waves of random direction and phase,
//! which is close to a Gaussian field.

use std::f64::consts::TAU;

use nalgebra::Vector2;

use super::{Draw, Object, stream, tessellate};

/// Side of the square, in mm.
const SIDE: f64 = 100.0;
/// Shortest and longest wavelength, in edges. The autocorrelation of an isotropic wave, a Bessel
/// function, first falls to zero at 0.38 wavelengths: here at about 4 edges.
const WAVELENGTHS: [f64; 2] = [6.0, 18.0];
/// Root mean square of the heights, in edges: slopes of about 20°, as on cast stone.
const ROUGHNESS: f64 = 0.6;
/// Number of waves: enough that no single one is seen.
const WAVES: u32 = 160;

pub(super) fn object(vertices: usize, seed: u32) -> Object {
    let mut rng = stream(seed, Draw::Jitter);
    let tessellation = tessellate::plane(Vector2::new(SIDE, SIDE), vertices, &mut rng);
    let edge = tessellation.edge;

    let mut rng = stream(seed, Draw::Relief);
    let [shortest, longest] = WAVELENGTHS;
    let waves: Vec<(Vector2<f64>, f64)> = (0..WAVES)
        .map(|_| {
            let (sin, cos) = (TAU * rng.uniform()).sin_cos();
            // Even in the logarithm of the wavelength.
            let wavelength = edge * shortest * (longest / shortest).powf(rng.uniform());
            (
                Vector2::new(cos, sin) * (TAU / wavelength),
                TAU * rng.uniform(),
            )
        })
        .collect();
    let amplitude = ROUGHNESS * edge * (2.0 / f64::from(WAVES)).sqrt();
    Object {
        heights: tessellation
            .wall
            .iter()
            .map(|w| {
                let sum: f64 = waves
                    .iter()
                    .map(|(k, phase)| (k.dot(&w.coords) + phase).sin())
                    .sum();
                amplitude * sum
            })
            .collect(),
        tessellation,
        colors: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_have_the_stated_deviation_and_correlation_length() {
        let field = object(20_000, 2);
        let heights = &field.heights;
        let edge = field.tessellation.edge;
        let n = heights.len() as f64;
        let mean_square = heights.iter().map(|h| h * h).sum::<f64>() / n;
        assert!((mean_square.sqrt() / (ROUGHNESS * edge) - 1.0).abs() < 0.1);

        // Along the rows, vertices follow each other at about one edge.
        let correlation = |lag: usize| {
            let pairs = heights.iter().zip(&heights[lag..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (n * mean_square)
        };
        assert!(correlation(1) > 0.8, "{}", correlation(1));
        assert!(correlation(2) > 0.3, "{}", correlation(2));
        assert!(correlation(5) < 0.1, "{}", correlation(5));
    }
}
