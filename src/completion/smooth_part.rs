//! The part of the relief that is the same a little beside its vertices.

use nalgebra::{Point3, Vector3};

use crate::mesh::{TriMesh, gradients};

use super::growth::Canvas;

/// The heights of samples without what changes from vertex to vertex, readable between them.
///
/// Each is the mean of a vertex and its ring. Adding again what a second mean takes away, so that relief of some
/// five edges' length is taken along, measured worse.
pub(super) struct SmoothPart {
    /// By vertex.
    heights: Vec<f64>,
    /// By vertex: how they rise over the base.
    slopes: Vec<Vector3<f64>>,
}

impl SmoothPart {
    pub(super) fn new(canvas: &Canvas, samples: &[bool]) -> Self {
        let heights = ring_means(canvas, samples);
        let of_samples = |t: &&[u32; 3]| t.iter().all(|v| samples[*v as usize]);
        let mesh = TriMesh {
            positions: canvas.relief.feet.clone(),
            triangles: canvas
                .triangles
                .iter()
                .filter(of_samples)
                .copied()
                .collect(),
        };
        Self {
            slopes: gradients(&mesh, &heights),
            heights,
        }
    }

    /// How much it rises from vertex `from` to a place between three samples with the given weights: exact
    /// for quadratic functions.
    pub(super) fn rise(
        &self,
        feet: &[Point3<f64>],
        from: u32,
        corners: [u32; 3],
        weights: [f32; 3],
    ) -> f64 {
        let weighted = || {
            (corners.iter())
                .zip(weights)
                .map(|(v, w)| (*v as usize, f64::from(w)))
        };
        let place: Vector3<f64> = weighted().map(|(v, w)| feet[v].coords * w).sum();
        let height: f64 = weighted()
            .map(|(v, weight)| {
                let away = place - feet[v].coords;
                weight * (self.heights[v] + 0.5 * self.slopes[v].dot(&away))
            })
            .sum();
        height - self.heights[from as usize]
    }
}

/// Mean of each sample and the samples next to it; 0 for what is no sample.
fn ring_means(canvas: &Canvas, samples: &[bool]) -> Vec<f64> {
    let heights = &canvas.relief.heights;
    let mean = |v: usize| {
        let ring = (canvas.adjacency.neighbors.row(v).iter()).map(|n| *n as usize);
        let (sum, count) = (ring.filter(|n| samples[*n]))
            .fold((heights[v], 1.0), |(sum, count), n| {
                (sum + heights[n], count + 1.0)
            });
        sum / count
    };
    (0..heights.len())
        .map(|v| if samples[v] { mean(v) } else { 0.0 })
        .collect()
}

/// Root mean square of what changes from vertex to vertex, over that of the heights about their mean: 0.1 for
/// relief as smooth as the vertices are dense, 1 for noise.
pub(super) fn roughness(canvas: &Canvas, samples: &[bool]) -> f64 {
    let smooth = ring_means(canvas, samples);
    let (mut count, mut sum, mut square, mut rough) = (0.0, 0.0, 0.0, 0.0);
    for (v, height) in canvas.relief.heights.iter().enumerate() {
        if samples[v] {
            count += 1.0;
            sum += height;
            square += height * height;
            rough += (height - smooth[v]).powi(2);
        }
    }
    let variance = square / f64::max(count, 1.0) - (sum / f64::max(count, 1.0)).powi(2);
    let ratio = (rough / f64::max(count, 1.0) / variance).sqrt();
    if ratio.is_finite() { ratio } else { 0.0 }
}
