//! Meshes on all levels, and values on them, for the tests of the engine.

use nalgebra::{Point3, Vector3};

use crate::mesh::TriMesh;
use crate::rng::{Rng, Stage};

use super::COARSEST;
use super::descriptors::{Descriptors, Factors};
use super::field::{Match, Pairing};
use super::hierarchy::{Hierarchy, counts};
use super::shape::Features;
use super::shape::test_shapes::icosphere;
use super::stack::Stack;

/// A mesh on all levels, without features.
pub(super) fn stack(mesh: &TriMesh) -> Stack {
    let (hierarchy, _) = Hierarchy::new(mesh, &counts(mesh.positions.len(), COARSEST));
    Stack::new(hierarchy, 0, Features::default())
}

/// A level of two meshes, all of whose vertices may be matched.
pub(super) fn pairing<'a>(source: &'a Stack, target: &'a Stack, level: usize) -> Pairing<'a> {
    let [from, onto] = [source, target].map(|stack| &stack.grounds[level]);
    Pairing {
        target: onto,
        source: from,
        hierarchy: &source.hierarchy,
        level,
        ratio: from.spacing / onto.spacing,
        allowed: &[],
        pinned: &[],
    }
}

/// So many values from 0 to 1 that have nothing to do with each other.
pub(super) fn noise(seed: u32, count: usize) -> Vec<f32> {
    let mut rng = Rng::new(seed, Stage::Transfer, 0);
    #[expect(clippy::cast_possible_truncation, reason = "values are single")]
    let values = (0..count).map(|_| rng.uniform() as f32).collect();
    values
}

/// What is compared of a level if all that counts is one value a vertex.
pub(super) fn of_values(stack: &Stack, level: usize, values: &[f32]) -> Descriptors {
    let factors = Factors {
        values: vec![1.0],
        features: Vec::new(),
        gradients: Vec::new(),
    };
    Descriptors::new(&stack.grounds[level], values, &[], &[], &factors)
}

/// Each vertex matched with itself.
pub(super) fn identity(count: usize) -> Vec<Match> {
    super::ground::numbers(count)
        .map(|v| Match::new(v, 0, 0.0))
        .collect()
}

/// A closed shape that is nowhere like elsewhere: an ellipsoid with waves.
pub(super) fn blob(cuts: usize) -> TriMesh {
    let mut mesh = icosphere(cuts);
    for p in &mut mesh.positions {
        let wave = 1.0 + 0.15 * (3.0 * p.x + 1.0).sin() + 0.1 * (2.0 * p.y - 4.0 * p.z).sin();
        *p = Point3::new(1.3 * p.x, p.y, 0.7 * p.z) * wave;
    }
    mesh
}

/// A tangent of a vertex that is turned with its place by `turn`: the angle by which directions at a vertex of one mesh
/// are turned to those at a vertex of another.
pub(super) fn turned_angle(
    pairing: &Pairing,
    target: u32,
    source: u32,
    turn: impl Fn(&Vector3<f64>) -> Vector3<f64>,
) -> f32 {
    let direction = turn(&pairing.target.direction(target, 0.0));
    pairing.source.polar(source, &direction).0
}

/// The vertex nearest to a point.
pub(super) fn nearest(points: &[Point3<f64>], to: &Point3<f64>) -> u32 {
    let distances = points.iter().map(|p| (p - to).norm_squared());
    let least = (0u32..).zip(distances).min_by(|a, b| a.1.total_cmp(&b.1));
    least.expect("some").0
}
