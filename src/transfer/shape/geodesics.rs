//! Distances over a surface, by the heat method: heat flows from the sources for a short time, its gradient
//! points along the shortest ways, and the function whose gradient has length 1 in those directions is the
//! distance.
//!
//! Both systems are factored once for all sources. Triangles are taken by their lengths only, those of the
//! [`Laplacian`].
//!
//! # Reference
//! [Crane, Weischedel & Wardetzky 2013](crate::bibliography#crane-weischedel--wardetzky-2013), algorithm 1, with
//! the natural conditions at the boundary; time: the square of the mean edge, its §3.2.4.

use std::f64::consts::PI;

use faer::reborrow::Reborrow;
use faer::{Mat, MatMut};

use super::pieces::Pieces;
use crate::mesh::{Factor, Laplacian, TriMesh, bounding_diagonal};

/// The heat of a source falls by e over the root of the time. Over more than 700 times that length nothing is left
/// of it in floating-point numbers; ways over a surface are up to about twice as long as its bounding diagonal, which
/// on a large mesh asks for a longer time than the paper's.
const LENGTHS_ACROSS: f64 = 300.0;

/// Shift that makes the second system definite, as a share of 4π over the area (the mean distance of
/// eigenvalues): what it adds to a distance is below what the method promises by far.
const SHIFT: f64 = 1e-8;

/// Sets of sources that are solved for at once, so that memory does not grow with their number.
const SETS: usize = 64;

/// Finds distances over a surface, from any vertices.
#[derive(Debug)]
pub struct Geodesics {
    laplacian: Laplacian,
    pieces: Pieces,
    heat: Factor,
    potential: Factor,
}

impl Geodesics {
    /// Ready for distances over a mesh; `None` if its systems cannot be factored, which takes memory only.
    #[must_use]
    pub fn new(mesh: &TriMesh) -> Option<Self> {
        let laplacian = Laplacian::new(mesh)?;
        let triangles = &laplacian.triangles;
        let lengths: f64 = triangles.iter().flat_map(|t| t.lengths).sum();
        let mean = lengths / (3 * triangles.len()).max(1) as f64;
        let corners = triangles.iter().flat_map(|t| t.corners);
        let across = bounding_diagonal(corners.map(|v| &mesh.positions[v as usize]));
        let time = mean.max(across / LENGTHS_ACROSS).powi(2);
        let shift = SHIFT * 4.0 * PI / laplacian.area();
        let positive = |x: f64| if x > 0.0 && x.is_finite() { x } else { 1.0 };
        let (heat, potential) = rayon::join(
            || laplacian.factor(1.0, positive(time)),
            || laplacian.factor(positive(shift), 1.0),
        );
        Some(Self {
            pieces: Pieces::new(&laplacian),
            heat: heat?,
            potential: potential?,
            laplacian,
        })
    }

    /// Area of the whole surface.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.laplacian.area()
    }

    /// #V distances to the nearest of the vertices `from`, in the scan's unit; zero at these, infinite on connected
    /// pieces that hold none of them.
    ///
    /// They are within a few per cent, coarser meshes more.
    #[must_use]
    pub fn distances(&self, from: &[u32]) -> Vec<f64> {
        self.distances_to_each(&[from]).pop().unwrap_or_default()
    }

    /// [`Geodesics::distances`] for several sets of sources, faster than one after another.
    #[must_use]
    pub fn distances_to_each(&self, sets: &[&[u32]]) -> Vec<Vec<f64>> {
        sets.chunks(SETS).flat_map(|sets| self.some(sets)).collect()
    }

    fn some(&self, sets: &[&[u32]]) -> Vec<Vec<f64>> {
        let mut columns = Mat::zeros(self.laplacian.mass.len(), sets.len());
        for (k, from) in sets.iter().enumerate() {
            for v in *from {
                columns[(*v as usize, k)] = 1.0;
            }
        }
        self.heat.solve(&mut columns);
        self.replace_by_divergence(columns.as_mut());
        self.potential.solve(&mut columns);
        (columns.col_iter().zip(sets))
            .map(|(potential, from)| {
                let potential: Vec<f64> = potential.iter().copied().collect();
                self.shifted(potential, from)
            })
            .collect()
    }

    /// Each column of heat becomes the divergence of the unit vectors against its gradient.
    fn replace_by_divergence(&self, columns: MatMut<'_, f64>) {
        let count = columns.ncols();
        if count > 1 {
            let (left, right) = columns.split_at_col_mut(count / 2);
            rayon::join(
                || self.replace_by_divergence(left),
                || self.replace_by_divergence(right),
            );
            return;
        }
        for mut column in columns.col_iter_mut() {
            let heat: Vec<f64> = column.rb().iter().copied().collect();
            column.fill(0.0);
            for triangle in &self.laplacian.triangles {
                let corners = triangle.corners.map(|v| v as usize);
                let flows = divergence(
                    triangle.lengths,
                    triangle.cotangents(),
                    corners.map(|v| heat[v]),
                );
                for (v, flow) in corners.into_iter().zip(flows) {
                    column[v] += flow;
                }
            }
        }
    }

    /// Distances from a function that is off by a constant on each piece.
    fn shifted(&self, mut potential: Vec<f64>, from: &[u32]) -> Vec<f64> {
        let mut at_sources = vec![(0.0, 0.0); self.pieces.areas.len()];
        for v in from {
            if let Some(piece) = self.pieces.of[*v as usize] {
                let (sum, count) = &mut at_sources[piece as usize];
                *sum += potential[*v as usize];
                *count += 1.0;
            }
        }
        for (value, piece) in potential.iter_mut().zip(&self.pieces.of) {
            let (sum, count) = piece.map_or((0.0, 0.0), |piece| at_sources[piece as usize]);
            *value = if count > 0.0 {
                (*value - sum / count).max(0.0)
            } else {
                f64::INFINITY
            };
        }
        for v in from {
            potential[*v as usize] = 0.0;
        }
        potential
    }
}

/// What flows out of each corner's share of a triangle, of the unit vector against the gradient of `heat`.
fn divergence(lengths: [f64; 3], cotangents: [f64; 3], heat: [f64; 3]) -> [f64; 3] {
    // In the plane: the corners at (0, 0), (l, 0) and above the first by the sine of its angle.
    let [across_a, side, base] = lengths;
    let cosine = ((side - across_a) * (side + across_a) + base * base) / (2.0 * side * base);
    let (x, y) = (
        side * cosine,
        side * (1.0 - cosine * cosine).max(0.0).sqrt(),
    );
    let along = (heat[1] - heat[0]) / base;
    let up = (heat[2] - heat[0] - along * x) / y;
    let length = along.hypot(up);
    let (along, up) = (-along / length, -up / length);
    if !(along.is_finite() && up.is_finite()) {
        return [0.0; 3];
    }
    // Of the edges ab, bc, ca.
    let dots = [
        base * along,
        (x - base) * along + y * up,
        -x * along - y * up,
    ];
    let [cot_a, cot_b, cot_c] = cotangents;
    let flows = [
        cot_c * dots[0] - cot_b * dots[2],
        cot_a * dots[1] - cot_c * dots[0],
        cot_b * dots[2] - cot_a * dots[1],
    ];
    // Against the paper's sign: the system has K, not −K, on its left.
    flows.map(|flow| -0.5 * flow)
}

#[cfg(test)]
mod tests {
    use super::super::test_shapes::{grid, icosphere, together};
    use super::*;
    use std::f64::consts::TAU;

    /// Root mean square error of distances from 0 as a share of the largest true one.
    fn error(mesh: &TriMesh, from: &[u32], truth: impl Fn(usize) -> f64) -> f64 {
        let distances = Geodesics::new(mesh).unwrap().distances(from);
        let (mut sum, mut largest) = (0.0, 0.0f64);
        for (v, distance) in distances.iter().enumerate() {
            sum += (distance - truth(v)).powi(2);
            largest = largest.max(truth(v));
        }
        (sum / distances.len() as f64).sqrt() / largest
    }

    #[test]
    fn on_a_plane_they_are_straight() {
        let mesh = grid(41, 31, |x, y| [x, y + 0.3 * x, 0.0]);
        let from = 41 * 15 + 20;
        let straight = |v: usize| (mesh.positions[v] - mesh.positions[from]).norm();
        let found = error(&mesh, &[u32::try_from(from).unwrap()], straight);
        assert!(found < 0.02, "{found}");
    }

    #[test]
    fn on_a_sphere_they_are_great_circles_also_to_the_nearest_of_several() {
        let mesh = icosphere(4);
        for from in [&[0u32][..], &[7, 100, 900]] {
            let circle = |v: usize| {
                let angle = |s: &u32| {
                    mesh.positions[*s as usize]
                        .coords
                        .angle(&mesh.positions[v].coords)
                };
                from.iter().map(angle).fold(f64::INFINITY, f64::min)
            };
            let found = error(&mesh, from, circle);
            assert!(found < 0.02, "{found}");
        }
    }

    #[test]
    fn on_a_tube_with_two_ends_they_go_the_shorter_way_around() {
        let columns = 48u32;
        let mut mesh = grid(columns, 33, |x, y| {
            let angle = x * TAU / 48.0;
            [angle.cos(), angle.sin(), y * TAU / 48.0]
        });
        for i in 0..32 {
            let [a, b] = [i * columns + columns - 1, i * columns];
            mesh.triangles
                .extend([[a, b, a + columns], [b, b + columns, a + columns]]);
        }
        let from = 16 * columns + 5;
        let unrolled = |v: usize| {
            let (x, y) = ((v % 48) as f64 - 5.0, (v / 48) as f64 - 16.0);
            x.abs().min(48.0 - x.abs()).hypot(y) * TAU / 48.0
        };
        let found = error(&mesh, &[from], unrolled);
        assert!(found < 0.03, "{found}");
    }

    #[test]
    fn pieces_without_a_source_are_infinitely_far() {
        let mesh = together(icosphere(1), &icosphere(1));
        let geodesics = Geodesics::new(&mesh).unwrap();
        let distances = geodesics.distances(&[50]);
        assert!(distances[..42].iter().all(|d| d.is_infinite()));
        assert!(distances[42..].iter().all(|d| d.is_finite()));
        assert!(distances[50] == 0.0);
        let both = geodesics.distances(&[8, 50]);
        assert_eq!(both[42..], distances[42..]);
        assert!(both.iter().all(|d| d.is_finite()));
    }

    #[test]
    fn many_at_once_are_those_one_by_one_and_scale_with_the_mesh() {
        let mesh = icosphere(2);
        let geodesics = Geodesics::new(&mesh).unwrap();
        let sets: Vec<[u32; 1]> = (0..70).map(|v| [2 * v]).collect();
        let sets: Vec<&[u32]> = sets.iter().map(|set| &set[..]).collect();
        let mut larger = mesh.clone();
        larger.positions.iter_mut().for_each(|p| *p *= 1e3);
        let far = Geodesics::new(&larger).unwrap();
        for (set, distances) in sets.iter().zip(geodesics.distances_to_each(&sets)) {
            for ((a, b), c) in geodesics
                .distances(set)
                .iter()
                .zip(&distances)
                .zip(far.distances(set))
            {
                assert!(
                    (a - b).abs() < 1e-9 && (a - c / 1e3).abs() < 1e-6,
                    "{a} {b} {c}"
                );
            }
        }
    }
}
