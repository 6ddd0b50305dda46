//! Values between the vertices of a surface, read with their curvature.
//!
//! Linear interpolation cuts off curvature, the more of it the farther apart the vertices stand, and as
//! much as a third of the Laplacian over one edge: a piece with denser vertices would look rougher. With
//! the gradients gᵢ at the corners, quadratic functions are read exactly:
//! h = Σ bᵢ hᵢ − ½ (Σ bᵢ gᵢ·xᵢ − (Σ bᵢ gᵢ)·(Σ bᵢ xᵢ)), all of which are linear interpolations.

use nalgebra::Vector3;

use crate::mesh::{TriMesh, gradients};
use crate::neighborhood::{Among, Channels};

/// Channels for a point: its coordinates.
const SHARED: usize = 3;
/// Channels for a quantity: value, g·x, g.
const EACH: usize = 5;

/// Quantities with their gradients, ready for walks.
pub(super) struct CurvedChannels {
    pub(super) channels: Channels,
    /// Number of quantities.
    pub(super) count: usize,
}

impl CurvedChannels {
    /// Of named values; vertices that do not count are unknown.
    pub(super) fn new(feet: &TriMesh, values: &[(&str, Vec<f64>)], counts: &[bool]) -> Self {
        let gradients: Vec<Vec<Vector3<f64>>> =
            values.iter().map(|(_, h)| gradients(feet, h)).collect();
        let mut channels = Channels::new(counts.len(), SHARED + EACH * values.len());
        for v in (0..counts.len()).filter(|v| counts[*v]) {
            let x = feet.positions[v].coords;
            let mut all: Vec<f64> = x.iter().copied().collect();
            for ((_, h), g) in values.iter().zip(&gradients) {
                all.extend([h[v], g[v].dot(&x)]);
                all.extend(g[v].iter());
            }
            #[expect(clippy::cast_possible_truncation, reason = "channels are single")]
            let all: Vec<f32> = all.iter().map(|x| *x as f32).collect();
            channels.set(v, &all, &[Among::Known]);
        }
        Self {
            channels,
            count: values.len(),
        }
    }

    /// Quantity `c` from channels that were read between vertices.
    #[inline]
    pub(super) fn value(read: &[f32], c: usize) -> f32 {
        let x = &read[..SHARED];
        let of = &read[SHARED + EACH * c..][..EACH];
        let gx = of[2] * x[0] + of[3] * x[1] + of[4] * x[2];
        of[0] - 0.5 * (of[1] - gx)
    }

    /// Quantity `c` from the channels of a vertex.
    #[inline]
    pub(super) fn own(read: &[f32], c: usize) -> f32 {
        read[SHARED + EACH * c]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_function_is_read_exactly() {
        // Between (0, 0) and (2, 0) with h = x²: 0 and 4, gradients 0 and 4.
        let corner = |x: f32| [x, 0.0, 0.0, x * x, 2.0 * x * x, 2.0 * x, 0.0, 0.0];
        for share in [0.0f32, 0.25, 0.5, 0.9, 1.0] {
            let read: Vec<f32> = (corner(0.0).iter().zip(corner(2.0)))
                .map(|(a, b)| (1.0 - share) * a + share * b)
                .collect();
            let expected = (2.0 * share).powi(2);
            assert!((CurvedChannels::value(&read, 0) - expected).abs() < 1e-5);
        }
    }
}
