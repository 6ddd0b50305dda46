//! Which kind of surface: a criterion that does not reward needless parameters.

use rayon::prelude::*;

use super::robust::spread;
use super::samples::{Normalized, Samples};
use super::{BaseKind, BaseSurface, Degenerate};
use crate::mesh::DisjointSets;

/// Radius of curvature, in half diagonals, beyond which a surface is a plane: over the whole mesh
/// it bends by less than 1/800 of the diagonal.
const FLAT_RADIUS: f64 = 200.0;

/// Half angles of cones, in degrees, that are no cylinder and no plane.
const CONE_ANGLES: (f64, f64) = (1.0, 85.0);

/// Largest share of the vertices behind a cone's apex.
const MAX_BEHIND: f64 = 0.1;

/// Differences of fit below this, in half diagonals, are no evidence for anything.
const LEAST_SCALE: f64 = 1e-6;

/// Least penalty of a parameter. With fewer than e³ = 20 patches ln n is too little: a plane with one
/// and a half waves became a cone.
const LEAST_PENALTY: f64 = 3.0;

/// Patches smaller than this share of the typical one do not count as independent.
const SPECK: f64 = 0.1;

/// Number of parameters of a surface.
pub(super) fn parameters(kind: BaseKind) -> usize {
    match kind {
        BaseKind::Plane => 3,
        BaseKind::Sphere => 4,
        BaseKind::Cylinder => 5,
        BaseKind::Cone => 6,
    }
}

/// Whether a simpler kind says the same as `surface`.
pub(super) fn degenerate(surface: &BaseSurface, samples: &Samples) -> Option<Degenerate> {
    match surface {
        BaseSurface::Plane(_) => None,
        BaseSurface::Sphere(s) => (s.radius > FLAT_RADIUS).then_some(Degenerate::Flat),
        BaseSurface::Cylinder(c) => (c.radius > FLAT_RADIUS).then_some(Degenerate::Flat),
        BaseSurface::Cone(cone) => {
            let along = |p: &nalgebra::Point3<f64>| (p - cone.apex).dot(&cone.axis);
            let total: f64 = samples.weights.iter().sum();
            let behind: f64 = samples
                .points
                .iter()
                .zip(&samples.weights)
                .filter(|(p, _)| along(p) < 0.0)
                .map(|(_, w)| *w)
                .sum();
            let angle = cone.half_angle;
            let curvature_radius = along(&samples.mean()) * angle.tan() / angle.cos();
            if angle < CONE_ANGLES.0.to_radians() {
                Some(Degenerate::NearlyCylinder)
            } else if angle > CONE_ANGLES.1.to_radians() {
                Some(Degenerate::NearlyPlane)
            } else if behind > MAX_BEHIND * total {
                Some(Degenerate::BehindApex)
            } else {
                (curvature_radius > FLAT_RADIUS).then_some(Degenerate::Flat)
            }
        }
    }
}

/// What the criterion is computed from.
pub(super) struct Fitted<'a> {
    pub(super) kind: BaseKind,
    pub(super) heights: &'a [f64],
    pub(super) excluded: bool,
}

/// The criterion of each candidate, and the number n of independent pieces of relief in it.
///
/// 2 n ρ̄ + k max(ln n, 3), the Bayesian information criterion (Schwarz 1978) with three changes. The heights
/// are taken to follow a Cauchy distribution, ρ = ln(1 + (h/σ)²), with the least MAD as its scale, so
/// that stray pieces count little but a surface that misses them by less still counts as better
/// (a bounded loss preferred a plane to the cylinder of a tower with half its vertices off it). And
/// the number of observations heeds that neighboring heights are not independent: n is the number
/// of patches of equal sign of the best-fitting candidate. See also [`LEAST_PENALTY`].
pub(super) fn criteria(mesh: &Normalized, fitted: &[Fitted<'_>]) -> (Vec<f64>, f64) {
    let weights = &mesh.samples.weights;
    let total: f64 = weights.iter().sum();
    let scales: Vec<f64> = fitted
        .par_iter()
        .filter(|f| !f.excluded)
        .map(|f| spread(f.heights, weights).wide)
        .collect();
    let sigma = (scales.into_iter())
        .fold(f64::INFINITY, f64::min)
        .max(LEAST_SCALE);
    let losses: Vec<f64> = fitted
        .par_iter()
        .map(|f| {
            let pairs = f.heights.iter().zip(weights);
            pairs
                .map(|(h, w)| w * (h / sigma).powi(2).ln_1p())
                .sum::<f64>()
                / total
        })
        .collect();
    let best = (0..fitted.len())
        .filter(|&i| !fitted[i].excluded)
        .min_by(|&a, &b| losses[a].total_cmp(&losses[b]));
    let n = best.map_or(2.0, |i| independent(mesh, fitted[i].heights));
    let criteria = fitted
        .iter()
        .zip(&losses)
        .map(|(f, loss)| 2.0 * n * loss + parameters(f.kind) as f64 * n.ln().max(LEAST_PENALTY))
        .collect();
    (criteria, n)
}

/// Number of independent pieces of relief: connected patches of the mesh on which the height is
/// above (or below) its median; at least 2.
fn independent(mesh: &Normalized, heights: &[f64]) -> f64 {
    let center = spread(heights, &mesh.samples.weights).center;
    let above: Vec<bool> = heights.iter().map(|h| *h > center).collect();
    let mut patches = DisjointSets::new(heights.len());
    for &[a, b, c] in &mesh.triangles {
        for (i, j) in [(a, b), (b, c), (c, a)] {
            if above[i as usize] == above[j as usize] {
                patches.join(i, j);
            }
        }
    }
    let patches = patches.into_lowest();
    let mut areas = vec![0.0; patches.len()];
    for (patch, area) in patches.iter().zip(&mesh.samples.weights) {
        areas[*patch as usize] += area;
    }
    // Each patch by its lowest vertex.
    let areas = (0u32..)
        .zip(areas)
        .filter(|(v, _)| patches[*v as usize] == *v);
    let count = |areas: &[f64]| {
        // The mean patch of a random vertex. Noise sprinkles specks along the borders of patches,
        // which would otherwise pass for a wealth of evidence.
        let typical = areas.iter().map(|a| a * a).sum::<f64>() / areas.iter().sum::<f64>();
        areas.iter().filter(|a| **a >= SPECK * typical).count()
    };
    // Each sign by itself: the land between dimples is one, however many these are.
    let (high, low): (Vec<_>, Vec<_>) = areas.partition(|(v, _)| above[*v as usize]);
    let [high, low] = [high, low].map(|side| side.into_iter().map(|(_, a)| a).collect::<Vec<_>>());
    let count = count(&high) + count(&low);
    (count as f64).max(2.0)
}
