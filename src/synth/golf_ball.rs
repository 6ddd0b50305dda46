//! Golf ball: a sphere with 312 dimples in icosahedral order.

use std::f64::consts::PI;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::{Draw, Object, stream, tessellate};
use crate::rng::Rng;

/// Radius, in mm: the least that the rules of golf allow (42.67 mm across).
const RADIUS: f64 = 21.35;
/// Depth of a dimple, in mm.
const DEPTH: f64 = 0.25;
/// Share of the sphere within the dimples' rims.
const COVERAGE: f64 = 0.8;
/// Half-width of the rounding at a dimple's rim, in units of (distance / radius)².
const RIM_ROUNDING: f64 = 0.12;
/// The dimples are the vertices of the geodesic icosahedron {3,5+}(5,1), of which there are
/// 10 (5² + 5·1 + 1²) + 2 = 312.
const STEPS: [i32; 2] = [5, 1];
/// Steps of the repulsion that evens the distances out.
const RELAXATIONS: usize = 120;

pub(super) fn object(vertices: usize, seed: u32) -> Object {
    let mut rng = stream(seed, Draw::Jitter);
    let tessellation = tessellate::sphere(RADIUS, vertices, &mut rng);
    let turn = random_rotation(&mut stream(seed, Draw::Relief));
    let dimples: Vec<_> = dimples().iter().map(|d| turn * d).collect();
    let dimple_radius_sq = 4.0 * COVERAGE / dimples.len() as f64;
    Object {
        heights: tessellation
            .normals
            .iter()
            .map(|n| {
                // The cosine is largest for the nearest; on the unit sphere |n - d|² = 2 - 2 n·d.
                let cosine = dimples.iter().map(|d| n.dot(d)).fold(-1.0, f64::max);
                -DEPTH * profile((2.0 - 2.0 * cosine) / dimple_radius_sq)
            })
            .collect(),
        tessellation,
        colors: Vec::new(),
    }
}

/// Depth of a dimple at a squared distance (in units of its squared radius) from its middle: a
/// spherical cap whose rim is rounded.
fn profile(distance_sq: f64) -> f64 {
    let cap = 1.0 - distance_sq;
    if cap >= RIM_ROUNDING {
        cap
    } else {
        (cap + RIM_ROUNDING).max(0.0).powi(2) / (4.0 * RIM_ROUNDING)
    }
}

/// Directions of the dimples.
fn dimples() -> Vec<Vector3<f64>> {
    let corners = icosahedron();
    let [h, k] = STEPS;
    let steps_sq = f64::from(h * h + h * k + k * k);
    let mut points: Vec<Vector3<f64>> = Vec::new();
    for [a, b, c] in faces(&corners) {
        // Lattice points a·i + b·j within the large triangle (0, 0), (h, k), (-k, h + k), by
        // their barycentric coordinates; those on its sides come from two faces.
        for i in -k..=h {
            for j in 0..=h + k {
                let to_b = f64::from(i * (h + k) + j * k) / steps_sq;
                let to_c = f64::from(j * h - i * k) / steps_sq;
                let to_a = 1.0 - to_b - to_c;
                if to_a.min(to_b).min(to_c) < -1e-9 {
                    continue;
                }
                let point = (a * to_a + b * to_b + c * to_c).normalize();
                if points.iter().all(|p| (p - point).norm_squared() > 1e-6) {
                    points.push(point);
                }
            }
        }
    }
    relax(&mut points);
    points
}

/// The 12 corners of an icosahedron, as unit vectors.
fn icosahedron() -> Vec<Vector3<f64>> {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let mut corners = Vec::new();
    for (one, long) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        for corner in [
            Vector3::new(0.0, one, long),
            Vector3::new(one, long, 0.0),
            Vector3::new(long, 0.0, one),
        ] {
            corners.push(corner.normalize());
        }
    }
    corners
}

/// The 20 faces: all triples of neighbors, counterclockwise.
fn faces(corners: &[Vector3<f64>]) -> Vec<[Vector3<f64>; 3]> {
    let near = |a: &Vector3<f64>, b: &Vector3<f64>| a.dot(b) > 0.4;
    let mut faces = Vec::new();
    for (i, a) in corners.iter().enumerate() {
        for (j, b) in corners.iter().enumerate().skip(i + 1) {
            for c in &corners[j + 1..] {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = (b - a).cross(&(c - a)).dot(a) > 0.0;
                    faces.push(if outward { [*a, *b, *c] } else { [*a, *c, *b] });
                }
            }
        }
    }
    faces
}

/// Lets the points repel each other: projected from the flat faces, they are closer to each other
/// near the icosahedron's corners.
fn relax(points: &mut [Vector3<f64>]) {
    let spacing = (8.0 * PI / (3f64.sqrt() * points.len() as f64)).sqrt();
    for _ in 0..RELAXATIONS {
        let old = points.to_vec();
        for (i, p) in points.iter_mut().enumerate() {
            let mut push = Vector3::zeros();
            for (j, q) in old.iter().enumerate() {
                if i != j {
                    let away = old[i] - q;
                    push += away * (spacing.powi(6) / away.norm_squared().powi(3));
                }
            }
            *p = (*p + push * 0.02).normalize();
        }
    }
}

/// A rotation, all equally likely (normalized Gaussian quaternion).
fn random_rotation(rng: &mut Rng) -> UnitQuaternion<f64> {
    let [w, x, y, z] = std::array::from_fn(|_| rng.normal());
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_312_dimples_that_hardly_touch() {
        let dimples = dimples();
        assert_eq!(dimples.len(), 312);
        let diameter = 2.0 * (4.0 * COVERAGE / 312.0).sqrt();
        for (i, a) in dimples.iter().enumerate() {
            let nearest = dimples
                .iter()
                .enumerate()
                .filter(|(j, _)| *j != i)
                .map(|(_, b)| (a - b).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(nearest > 0.96 * diameter, "{}", nearest / diameter);
            assert!(nearest < 1.15 * diameter, "{}", nearest / diameter);
        }
    }

    #[test]
    fn the_profile_is_smooth_at_its_joints() {
        for joint in [1.0 - RIM_ROUNDING, 1.0 + RIM_ROUNDING] {
            let h = 1e-6;
            let (below, at, above) = (profile(joint - h), profile(joint), profile(joint + h));
            assert!((above - 2.0 * at + below).abs() < 10.0 * h * h / RIM_ROUNDING);
        }
    }
}
