//! Directions at the vertices of a mesh that agree with their neighbors'.

use nalgebra::{Complex, Unit, Vector3};

use crate::base::perpendicular_frame;
use crate::mesh::{Adjacency, TriMesh, turned_tangent};
use crate::rng::Rng;

use super::report::Singularity;

/// A mesh with axes at each vertex to tell directions by, and how directions are carried along its edges.
#[derive(Debug)]
pub(super) struct Connection {
    adjacency: Adjacency,
    /// Two tangents and the normal.
    axes: Vec<[Vector3<f64>; 3]>,
    /// For each vertex and each of its neighbors: what a direction there, as a complex number in the neighbor's
    /// axes, is multiplied with to be the same direction here.
    carried: Vec<Complex<f64>>,
    starts: Vec<usize>,
}

/// Rounds of relaxation after which directions that still change are taken as they are: from anywhere, …
const MOST_ROUNDS: usize = 200;
/// … and from what a coarser level has found.
const MOST_ROUNDS_ON: usize = 30;

/// Turn, in radians of n times the angle, below which a direction has settled.
const SETTLED: f64 = 1e-3;

impl Connection {
    pub(super) fn new(mesh: &TriMesh, normals: &[Vector3<f64>]) -> Self {
        let adjacency = Adjacency::new(mesh);
        let axes: Vec<[Vector3<f64>; 3]> = normals.iter().map(axes).collect();
        let mut carried = Vec::new();
        let mut starts = vec![0];
        for v in 0..axes.len() {
            for u in adjacency.neighbors.row(v) {
                carried.push(transport(&axes[*u as usize], &axes[v]));
            }
            starts.push(carried.len());
        }
        Self {
            adjacency,
            axes,
            carried,
            starts,
        }
    }

    /// A tangent direction as a complex number; 0 if the vector stands upright.
    pub(super) fn to_complex(&self, v: usize, direction: &Vector3<f64>) -> Complex<f64> {
        let [x, y, _] = &self.axes[v];
        let z = Complex::new(direction.dot(x), direction.dot(y));
        let length = z.norm();
        if length > 1e-9 {
            z / length
        } else {
            Complex::new(0.0, 0.0)
        }
    }

    pub(super) fn to_vector(&self, v: usize, z: Complex<f64>) -> Vector3<f64> {
        let [x, y, _] = &self.axes[v];
        x * z.re + y * z.im
    }

    fn around(&self, v: usize) -> impl Iterator<Item = (usize, Complex<f64>)> {
        let neighbors = self.adjacency.neighbors.row(v).iter();
        let carried = &self.carried[self.starts[v]..self.starts[v + 1]];
        neighbors.zip(carried).map(|(u, c)| (*u as usize, *c))
    }

    /// Turns directions towards their neighbors' until they have settled. A direction counts up to turns by a whole
    /// share of `symmetry`; it is given and returned to the power of that. `pinned` ones stay, others of length 0
    /// are not known yet. `goes_on`: the field comes from a coarser level.
    ///
    /// Each vertex in turn takes the direction of least error Σ sin²(n/2 · angle to the neighbor's), in closed form.
    ///
    /// # Reference
    /// [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001), §3.2.
    pub(super) fn relax(
        &self,
        field: &mut [Complex<f64>],
        symmetry: u32,
        pinned: &[bool],
        goes_on: bool,
    ) -> usize {
        let most = if goes_on { MOST_ROUNDS_ON } else { MOST_ROUNDS };
        let powers: Vec<Complex<f64>> = (self.carried.iter()).map(|c| c.powu(symmetry)).collect();
        for round in 1..=most {
            let mut largest = 0.0f64;
            for v in 0..field.len() {
                if pinned[v] {
                    continue;
                }
                let neighbors = self.adjacency.neighbors.row(v).iter();
                let carried = &powers[self.starts[v]..self.starts[v + 1]];
                let sum: Complex<f64> = neighbors
                    .zip(carried)
                    .map(|(u, c)| field[*u as usize] * c)
                    .sum();
                let length = sum.norm();
                if length > 1e-9 {
                    let new = sum / length;
                    largest = largest.max((new - field[v]).norm());
                    field[v] = new;
                }
            }
            if largest < SETTLED {
                return round;
            }
        }
        most
    }

    /// Mean over all edges of sin²(n/2 · angle between its ends' directions).
    pub(super) fn error(&self, field: &[Complex<f64>], symmetry: u32) -> f64 {
        let (mut sum, mut count) = (0.0, 0usize);
        for v in 0..field.len() {
            for (u, carried) in self.around(v) {
                let turned = field[u] * carried.powu(symmetry) * field[v].conj();
                sum += 0.5 * (1.0 - turned.re);
                count += 1;
            }
        }
        sum / count.max(1) as f64
    }

    /// The triangles around which the directions turn.
    pub(super) fn singularities(
        &self,
        mesh: &TriMesh,
        field: &[Complex<f64>],
        symmetry: u32,
    ) -> Vec<Singularity> {
        let mut found = Vec::new();
        for (f, t) in (0u32..).zip(&mesh.triangles) {
            let mut turned = 0.0;
            let mut whole = Complex::new(1.0, 0.0);
            for k in 0..3 {
                let [from, to] = [t[k], t[(k + 1) % 3]].map(|v| v as usize);
                let carried = transport(&self.axes[from], &self.axes[to]);
                whole *= carried;
                let expected = field[from] * carried.powu(symmetry);
                turned += (field[to] * expected.conj()).arg();
            }
            // What is carried around turns by the curvature within.
            let index = (turned + f64::from(symmetry) * whole.arg()) / std::f64::consts::TAU;
            let index = index.round();
            if index != 0.0 {
                let [a, b, c] = mesh.corners(f as usize);
                found.push(Singularity {
                    triangle: f,
                    position: ((a.coords + b.coords + c.coords) / 3.0).into(),
                    turns: index / f64::from(symmetry),
                });
            }
        }
        found
    }

    /// Of the n directions that each number of a field stands for one: the one that agrees best with what is given for
    /// the vertex or, where nothing is, with a neighbor's, beginning anywhere.
    pub(super) fn branches(
        &self,
        field: &[Complex<f64>],
        symmetry: u32,
        given: Option<&[Complex<f64>]>,
    ) -> Vec<Complex<f64>> {
        let n = f64::from(symmetry);
        let root = |z: Complex<f64>| Complex::from_polar(1.0, z.arg() / n);
        if let Some(given) = given {
            return (field.iter().zip(given))
                .map(|(z, wanted)| nearest_root(*z, n, *wanted))
                .collect();
        }
        let mut chosen: Vec<Option<Complex<f64>>> = vec![None; field.len()];
        let mut queue = std::collections::VecDeque::new();
        for start in 0..field.len() {
            if chosen[start].is_some() {
                continue;
            }
            chosen[start] = Some(root(field[start]));
            queue.push_back(start);
            while let Some(u) = queue.pop_front() {
                let direction = chosen[u].unwrap_or_default();
                for v in self.adjacency.neighbors.row(u) {
                    let v = *v as usize;
                    if chosen[v].is_none() {
                        let wanted = direction * transport(&self.axes[u], &self.axes[v]);
                        chosen[v] = Some(nearest_root(field[v], n, wanted));
                        queue.push_back(v);
                    }
                }
            }
        }
        chosen.into_iter().flatten().collect()
    }
}

/// Of the n-th roots of a number the one whose direction is nearest to the wanted one.
fn nearest_root(z: Complex<f64>, n: f64, wanted: Complex<f64>) -> Complex<f64> {
    let own = z.arg() / n;
    let step = std::f64::consts::TAU / n;
    let turns = ((wanted.arg() - own) / step).round();
    Complex::from_polar(1.0, own + turns * step)
}

/// Directions all over, each as likely as another.
pub(super) fn random(count: usize, rng: &mut Rng) -> Vec<Complex<f64>> {
    (0..count)
        .map(|_| Complex::from_polar(1.0, std::f64::consts::TAU * rng.uniform()))
        .collect()
}

/// Two tangents and the normal; any, where there is none.
fn axes(normal: &Vector3<f64>) -> [Vector3<f64>; 3] {
    let axis = Unit::try_new(*normal, 1e-12).unwrap_or_else(Vector3::z_axis);
    let [x, y] = perpendicular_frame(&axis);
    [x, y, *normal]
}

/// What a direction in the axes `from` is multiplied with to be, in the axes `to`, the same after the least turn
/// that brings one normal onto the other.
fn transport(from: &[Vector3<f64>; 3], to: &[Vector3<f64>; 3]) -> Complex<f64> {
    let ([x, _, n], [u, v, m]) = (from, to);
    let carried = turned_tangent(x, n, m);
    let z = Complex::new(carried.dot(u), carried.dot(v));
    let length = z.norm();
    if length > 1e-12 {
        z / length
    } else {
        Complex::new(1.0, 0.0)
    }
}

#[cfg(test)]
mod tests;
