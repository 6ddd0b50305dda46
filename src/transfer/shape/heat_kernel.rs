//! Heat kernel signatures: how much of the heat put at a vertex is still there after a time.
//!
//! HKS(x, t) = Σ exp(−λᵢ t) φᵢ(x)². Short times see the curvature near a vertex, long ones its place on the whole
//! shape; bending and moving the surface changes neither.
//!
//! Each connected piece is measured by its own area and its own heat, so that its mean is 1 at every time: on
//! a surface of one piece this is the definition, and a speck next to it does not outshine it.
//!
//! # Reference
//! [Sun, Ovsjanikov & Guibas 2009](crate::bibliography#sun-ovsjanikov--guibas-2009), §4; times and scaling by the
//! heat trace: §4.2.

use rayon::prelude::*;

use super::{Eigenpairs, Features, eigenpairs};
use crate::mesh::{Laplacian, TriMesh};

/// Times at which the heat is read.
const TIMES: usize = 8;

/// Eigenpairs above zero that are summed, if the mesh has as many. At the shortest time the next ones would weigh
/// less than 10⁻⁴.
const PAIRS: usize = 200;

/// Heat kernel signatures at eight times, evenly spaced in the logarithm from 4 ln 10 / λₖ to 4 ln 10 / λ₂, where λ₂
/// is the smallest and λₖ the largest eigenvalue above zero that is used; without unit, and the same for a mesh
/// of another size.
///
/// Zero at vertices without a triangle; `seed` is of no other account than the last digits.
#[must_use]
pub fn heat_kernel_signatures(mesh: &TriMesh, seed: u32) -> Features {
    let nothing = Features {
        count: TIMES,
        values: vec![0.0; TIMES * mesh.positions.len()],
    };
    let Some(laplacian) = Laplacian::new(mesh) else {
        return nothing;
    };
    let Some(pairs) = eigenpairs(&laplacian, PAIRS, seed) else {
        return nothing;
    };
    let Some(times) = times(&pairs.values) else {
        return nothing;
    };
    let heat = heat(&pairs, &times);
    let mut traces = vec![[0.0; TIMES]; pairs.areas.len()];
    for ((heat, mass), piece) in heat.iter().zip(&laplacian.mass).zip(&pairs.pieces) {
        if let Some(piece) = piece {
            for (trace, heat) in traces[*piece as usize].iter_mut().zip(heat) {
                *trace += mass * heat;
            }
        }
    }
    let scaled = |(heat, piece): (&[f64; TIMES], &Option<u32>)| {
        let piece = piece.map(|piece| piece as usize);
        std::array::from_fn::<f32, TIMES, _>(|k| {
            let value = piece.map_or(0.0, |p| heat[k] * pairs.areas[p] / traces[p][k]);
            #[expect(
                clippy::cast_possible_truncation,
                reason = "features are stored in single precision"
            )]
            let single = value as f32;
            single
        })
    };
    Features {
        count: TIMES,
        values: heat.iter().zip(&pairs.pieces).flat_map(scaled).collect(),
    }
}

/// The times, shortest first; `None` without an eigenvalue above zero.
fn times(values: &[f64]) -> Option<[f64; TIMES]> {
    let lowest = values.iter().find(|value| **value > 0.0)?;
    let highest = values.last()?;
    let least = 4.0 * 10f64.ln() / highest;
    let step = (highest / lowest).ln() / (TIMES - 1) as f64;
    Some(std::array::from_fn(|k| least * (step * k as f64).exp()))
}

/// By vertex and time, the heat kernel from a vertex to itself.
fn heat(pairs: &Eigenpairs, times: &[f64; TIMES]) -> Vec<[f64; TIMES]> {
    let weights: Vec<[f64; TIMES]> = (pairs.values.iter())
        .map(|value| times.map(|t| (-value * t).exp()))
        .collect();
    let at = |(v, piece): (usize, &Option<u32>)| {
        // The constant on the piece.
        let mut sums = [piece.map_or(0.0, |piece| 1.0 / pairs.areas[piece as usize]); TIMES];
        for (i, weights) in weights.iter().enumerate() {
            let square = pairs.functions[(v, i)].powi(2);
            for (sum, weight) in sums.iter_mut().zip(weights) {
                *sum += weight * square;
            }
        }
        sums
    };
    pairs.pieces.par_iter().enumerate().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::super::test_shapes::{grid, icosphere, together};
    use super::*;
    use nalgebra::{Point3, Rotation3, Vector3};

    fn ellipsoid() -> TriMesh {
        let mut mesh = icosphere(3);
        for p in &mut mesh.positions {
            *p = Point3::new(3.0 * p.x, 2.0 * p.y, p.z);
        }
        mesh
    }

    fn assert_close(a: &[f32], b: &[f32], tolerance: f32) {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= tolerance * a.abs().max(1.0), "{a} {b}");
        }
    }

    #[test]
    fn a_sphere_is_the_same_everywhere() {
        // Many of its harmonics are cut off in the middle of a multiplicity, which shows at short times only.
        let features = heat_kernel_signatures(&icosphere(4), 1);
        assert_eq!((features.count, features.values.len()), (8, 8 * 2562));
        assert_close(&features.values, &vec![1.0; 8 * 2562], 0.02);
    }

    #[test]
    fn moving_turning_and_scaling_change_nothing() {
        let mesh = ellipsoid();
        let rotation = Rotation3::from_scaled_axis(Vector3::new(0.4, -0.9, 0.3));
        let mut moved = mesh.clone();
        for p in &mut moved.positions {
            *p = rotation * (*p * 40.0) + Vector3::new(2e5, -3e5, 1e4);
        }
        let [a, b] = [mesh, moved].map(|mesh| heat_kernel_signatures(&mesh, 1).values);
        assert_close(&a, &b, 1e-5);
    }

    #[test]
    fn mirrored_places_agree_and_tips_keep_their_heat() {
        let mesh = ellipsoid();
        let features = heat_kernel_signatures(&mesh, 1);
        let row = |v: usize| &features.values[8 * v..8 * v + 8];
        let nearest = |q: Point3<f64>| {
            let distance = |v: &usize| (mesh.positions[*v] - q).norm();
            (0..mesh.positions.len())
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .unwrap()
        };
        for (v, p) in mesh.positions.iter().enumerate() {
            assert_close(row(v), row(nearest(Point3::new(-p.x, p.y, p.z))), 1e-4);
        }
        let [tip, flat] = [[3.0, 0.0, 0.0], [0.0, 0.0, 1.0]].map(|p| row(nearest(p.into())));
        assert!(
            tip.iter().zip(flat).all(|(tip, flat)| tip > flat),
            "{tip:?} {flat:?}"
        );
    }

    #[test]
    fn a_bent_strip_has_those_of_the_flat_one() {
        let flat = grid(40, 9, |x, y| [0.1 * x, 0.1 * y, 0.0]);
        let bent = grid(40, 9, |x, y| [(0.1 * x).sin(), 0.1 * y, (0.1 * x).cos()]);
        let [a, b] = [flat, bent].map(|mesh| heat_kernel_signatures(&mesh, 1).values);
        assert_close(&a, &b, 0.01);
    }

    #[test]
    fn a_speck_and_a_loose_vertex_do_not_disturb_a_surface() {
        let mesh = ellipsoid();
        let speck = TriMesh {
            positions: [
                [9.0, 0.0, 0.0],
                [9.001, 0.0, 0.0],
                [9.0, 0.001, 0.0],
                [7.0, 7.0, 7.0],
            ]
            .map(Point3::from)
            .to_vec(),
            triangles: vec![[0, 1, 2]],
        };
        let alone = heat_kernel_signatures(&mesh, 1).values;
        let values = heat_kernel_signatures(&together(mesh, &speck), 1).values;
        let (surface, rest) = values.split_at(alone.len());
        assert_close(&alone, surface, 1e-4);
        assert_close(&rest[..24], &[1.0; 24], 1e-4);
        assert_eq!(rest[24..], [0.0; 8]);
    }

    #[test]
    fn three_faces_and_none_have_finite_ones() {
        let fan = TriMesh {
            positions: [
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [-1.0, 0.0, 0.5],
                [0.0, -1.0, 0.0],
            ]
            .map(Point3::from)
            .to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]],
        };
        let values = heat_kernel_signatures(&fan, 1).values;
        assert!(values.iter().all(|x| x.is_finite() && *x > 0.0));
        assert!(
            heat_kernel_signatures(&TriMesh::default(), 1)
                .values
                .is_empty()
        );
    }
}
