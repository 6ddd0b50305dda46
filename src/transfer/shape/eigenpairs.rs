//! The slowest vibrations of a surface: eigenfunctions of its Laplacian with the smallest eigenvalues.
//!
//! K φ = λ M φ is solved upside down: the operator S (K + σM)⁻¹ S with S = √M is symmetric, has the eigenvalues
//! 1 / (λ + σ), largest for what is sought, and takes one sparse solve.
//!
//! The constants on each connected piece are eigenfunctions to 0, known beforehand: they are projected out, so that
//! a hundred loose pieces cost nothing.

use std::f64::consts::PI;

use faer::Mat;
use faer::reborrow::Reborrow;

use super::krylov::{Operator, Ritz, largest, ritz};
use super::pieces::Pieces;
use crate::mesh::{Factor, Laplacian};

/// Up to so many vertices, or four times what is sought, the whole operator is diagonalised.
const SMALL: usize = 600;

/// Columns of that matrix that are made at once: loose vertices, of which there may be any number, have rows in them.
const BATCH: usize = 64;

/// The shift σ as a share of 4π over the surface's area, the mean distance of eigenvalues (Weyl's law).
const SHIFT: f64 = 0.1;

/// Eigenvalues and eigenfunctions of a surface's Laplacian, without those that are constant on each connected
/// piece.
#[derive(Debug, Clone)]
pub struct Eigenpairs {
    /// Ascending, all above zero, in 1 / (the scan's unit squared).
    pub values: Vec<f64>,
    /// #V by as many as there are values: the functions, orthonormal in the mass (φᵀ M φ = 1); zero at vertices
    /// without a triangle.
    pub functions: Mat<f64>,
    /// By vertex, the number of its connected piece, which begin at 0; `None` without a triangle.
    pub pieces: Vec<Option<u32>>,
    /// By piece, its area.
    pub areas: Vec<f64>,
}

/// The `count` eigenpairs with the smallest eigenvalues above zero, or all if there are fewer.
///
/// Each eigenvalue comes with its multiplicity. Equal arguments give equal numbers, whatever the number of threads.
/// `None` if the system cannot be factored, which takes memory only: any triangles will do.
#[must_use]
pub fn eigenpairs(laplacian: &Laplacian, count: usize, seed: u32) -> Option<Eigenpairs> {
    let operator = Inverse::new(laplacian)?;
    let used = operator.pieces.iter().flatten().count();
    let count = count.min(used - operator.areas.len());
    let found = if count == 0 {
        Ritz {
            values: Vec::new(),
            vectors: Mat::zeros(laplacian.mass.len(), 0),
        }
    } else if used <= SMALL.max(4 * count) {
        operator.by_matrix(count)?
    } else {
        largest(&operator, count, seed)?
    };
    let count = count.min(found.values.len());
    let functions = Mat::from_fn(laplacian.mass.len(), count, |v, i| {
        let root = operator.roots[v];
        if root > 0.0 {
            found.vectors[(v, i)] / root
        } else {
            0.0
        }
    });
    Some(Eigenpairs {
        values: (found.values[..count].iter())
            .map(|theta| (1.0 / theta - operator.shift).max(0.0))
            .collect(),
        functions,
        pieces: operator.pieces,
        areas: operator.areas,
    })
}

/// S (K + σM)⁻¹ S, restricted to what is orthogonal to the constants on each piece.
struct Inverse {
    factor: Factor,
    shift: f64,
    /// Roots of the masses.
    roots: Vec<f64>,
    pieces: Vec<Option<u32>>,
    areas: Vec<f64>,
}

impl Inverse {
    fn new(laplacian: &Laplacian) -> Option<Self> {
        let Pieces { of: pieces, areas } = Pieces::new(laplacian);
        // Without any triangle there is nothing to shift.
        let area = if areas.is_empty() {
            1.0
        } else {
            laplacian.area()
        };
        let shift = SHIFT * 4.0 * PI / area;
        Some(Self {
            factor: laplacian.factor(shift, 1.0)?,
            shift,
            roots: laplacian.mass.iter().map(|m| m.sqrt()).collect(),
            pieces,
            areas,
        })
    }

    fn scale(&self, vectors: &mut Mat<f64>) {
        for column in vectors.col_iter_mut() {
            for (x, root) in column.iter_mut().zip(&self.roots) {
                *x *= root;
            }
        }
    }

    /// The `count` largest eigenvalues and their vectors, by the whole matrix of the vertices in a piece.
    fn by_matrix(&self, count: usize) -> Option<Ritz> {
        let used: Vec<usize> = (self.pieces.iter().enumerate())
            .filter_map(|(v, piece)| piece.map(|_| v))
            .collect();
        let mut matrix = Mat::zeros(used.len(), used.len());
        for (batch, from) in used.chunks(BATCH).zip((0..).step_by(BATCH)) {
            let mut columns = Mat::zeros(self.size(), batch.len());
            for (k, v) in batch.iter().enumerate() {
                columns[(*v, k)] = 1.0;
            }
            self.project(&mut columns);
            self.apply(&mut columns);
            for (row, v) in used.iter().enumerate() {
                for k in 0..batch.len() {
                    matrix[(row, from + k)] = columns[(*v, k)];
                }
            }
        }
        let mut found = ritz(matrix.as_ref())?;
        found.values.truncate(count);
        let mut vectors = Mat::zeros(self.size(), count);
        for (row, v) in used.iter().enumerate() {
            for i in 0..count {
                vectors[(*v, i)] = found.vectors[(row, i)];
            }
        }
        found.vectors = vectors;
        Some(found)
    }
}

impl Operator for Inverse {
    fn size(&self) -> usize {
        self.roots.len()
    }

    fn apply(&self, vectors: &mut Mat<f64>) {
        self.scale(vectors);
        self.factor.solve(vectors);
        self.scale(vectors);
        self.project(vectors);
    }

    /// Takes out the constants, and what is on vertices without a triangle.
    fn project(&self, vectors: &mut Mat<f64>) {
        let mut sums = vec![0.0; self.areas.len()];
        for column in vectors.col_iter_mut() {
            sums.fill(0.0);
            for ((x, root), piece) in column.rb().iter().zip(&self.roots).zip(&self.pieces) {
                if let Some(piece) = piece {
                    sums[*piece as usize] += x * root;
                }
            }
            for (sum, area) in sums.iter_mut().zip(&self.areas) {
                *sum /= area;
            }
            for ((x, root), piece) in column.iter_mut().zip(&self.roots).zip(&self.pieces) {
                *x = piece.map_or(0.0, |piece| *x - sums[piece as usize] * root);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_shapes::{grid, icosphere, together};
    use super::*;
    use crate::mesh::TriMesh;
    use approx::assert_relative_eq;
    use nalgebra::{DMatrix, Vector3};

    fn bumpy(columns: u32, rows: u32) -> TriMesh {
        grid(columns, rows, |x, y| {
            [
                x + 0.3 * (y + x).sin(),
                y,
                (0.5 * x).sin() * (0.3 * y).cos(),
            ]
        })
    }

    /// All eigenvalues by a dense solver of another crate, ascending, of the vertices that have a triangle.
    fn dense(laplacian: &Laplacian) -> Vec<f64> {
        let n = laplacian.mass.len();
        let mut matrix = DMatrix::zeros(n, n);
        for entry in laplacian.stiffness.triplet_iter() {
            let (i, j) = (entry.row, entry.col);
            let mass = (laplacian.mass[i] * laplacian.mass[j]).sqrt();
            matrix[(i, j)] = if mass > 0.0 { entry.val / mass } else { 0.0 };
            matrix[(j, i)] = matrix[(i, j)];
        }
        let mut values: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
        values.sort_unstable_by(f64::total_cmp);
        values
    }

    /// The functions are orthonormal in the mass and solve their equations.
    fn assert_eigen(laplacian: &Laplacian, pairs: &Eigenpairs) {
        let (n, count) = (pairs.functions.nrows(), pairs.values.len());
        let mass = |v: usize| laplacian.mass[v];
        let weighted = Mat::from_fn(n, count, |v, i| mass(v) * pairs.functions[(v, i)]);
        let gram = pairs.functions.transpose() * &weighted;
        for i in 0..count {
            for j in 0..count {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert_relative_eq!(gram[(i, j)], expected, epsilon = 1e-9);
            }
        }
        let mut stiff = Mat::<f64>::zeros(n, count);
        for entry in laplacian.stiffness.triplet_iter() {
            let (row, column) = (entry.row, entry.col);
            for i in 0..count {
                stiff[(row, i)] += entry.val * pairs.functions[(column, i)];
                if row != column {
                    stiff[(column, i)] += entry.val * pairs.functions[(row, i)];
                }
            }
        }
        for (i, value) in pairs.values.iter().enumerate() {
            // In the norm that belongs to the mass.
            let residual: f64 = (0..n)
                .filter(|v| mass(*v) > 0.0)
                .map(|v| (stiff[(v, i)] - value * weighted[(v, i)]).powi(2) / mass(v))
                .sum();
            assert!(
                residual.sqrt() < 1e-3 * value,
                "{i}: {value} {}",
                residual.sqrt()
            );
        }
    }

    #[test]
    fn they_agree_with_a_dense_solver_by_either_way() {
        // The second is large enough for the iteration.
        for (columns, rows, count) in [(11, 13, 60), (31, 23, 40)] {
            let laplacian = Laplacian::new(&bumpy(columns, rows)).unwrap();
            let pairs = eigenpairs(&laplacian, count, 1).unwrap();
            let all = dense(&laplacian);
            assert_eq!(pairs.values.len(), count);
            for (value, expected) in pairs.values.iter().zip(&all[1..]) {
                assert_relative_eq!(value, expected, max_relative = 1e-9);
            }
            assert_eigen(&laplacian, &pairs);
        }
    }

    #[test]
    fn a_sphere_has_its_harmonics_with_their_multiplicities() {
        let laplacian = Laplacian::new(&icosphere(3)).unwrap();
        let pairs = eigenpairs(&laplacian, 48, 1).unwrap();
        assert_eq!(pairs.values.len(), 48);
        for l in 1..7usize {
            // l (l + 1), 2 l + 1 times. With lumped masses a value is too low by about the twelfth of itself times the
            // square of an edge, here 0.15.
            let expected = (l * (l + 1)) as f64;
            let tolerance = 0.01 + expected * 0.15f64.powi(2) / 12.0;
            for value in &pairs.values[l * l - 1..(l + 1) * (l + 1) - 1] {
                assert_relative_eq!(*value, expected, max_relative = tolerance);
            }
        }
        assert_eigen(&laplacian, &pairs);
    }

    #[test]
    fn pieces_loose_vertices_and_copies_have_what_each_has_alone() {
        let piece = bumpy(13, 17);
        let alone = eigenpairs(&Laplacian::new(&piece).unwrap(), 12, 1).unwrap();
        let mut mesh = TriMesh::default();
        for k in 0..4 {
            let mut copy = piece.clone();
            for p in &mut copy.positions {
                *p += Vector3::new(100.0 * f64::from(k), 0.0, 0.0);
            }
            mesh.positions.push(piece.positions[0]);
            mesh = together(mesh, &copy);
        }
        let laplacian = Laplacian::new(&mesh).unwrap();
        let pairs = eigenpairs(&laplacian, 48, 1).unwrap();
        for (i, value) in pairs.values.iter().enumerate() {
            assert_relative_eq!(*value, alone.values[i / 4], max_relative = 1e-8);
        }
        assert_eigen(&laplacian, &pairs);
        assert_eq!(pairs.areas.len(), 4);
        assert_eq!(pairs.pieces[0], None);
        assert_eq!(pairs.pieces[1], Some(0));
        assert!(pairs.functions.row(0).iter().all(|x| *x == 0.0));
    }

    #[test]
    fn there_are_no_more_than_a_mesh_has() {
        let mut mesh = bumpy(2, 2);
        mesh.triangles.truncate(1);
        let pairs = eigenpairs(&Laplacian::new(&mesh).unwrap(), 200, 1).unwrap();
        assert_eq!(pairs.values.len(), 2);
        let none = eigenpairs(&Laplacian::new(&TriMesh::default()).unwrap(), 200, 1).unwrap();
        assert!(none.values.is_empty());
    }

    #[test]
    fn they_are_the_same_for_any_number_of_threads() {
        let laplacian = Laplacian::new(&bumpy(61, 71)).unwrap();
        let solved = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap()
                .install(|| eigenpairs(&laplacian, 20, 1).unwrap())
        };
        let (one, three) = (solved(1), solved(3));
        assert_eq!(one.values, three.values);
        assert_eq!(one.functions, three.functions);
    }
}
