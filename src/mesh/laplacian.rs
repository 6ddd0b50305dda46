//! The cotangent Laplacian of a triangle mesh, and systems with it.
//!
//! Two matrices stand for it: the stiffness K, with xᵀ K x = ∫|∇x|² for a function that is linear in each
//! triangle, and the lumped mass M, the vertices' areas; −Δx is M⁻¹ K x. At a boundary no value flows out
//! (natural, Neumann conditions); where more than two triangles meet at an edge, what each adds is summed.
//!
//! Slivers would give weights without bound. All edges are therefore made longer by the least length that keeps
//! every triangle a triangle by a margin; on a mesh without slivers it is zero.
//!
//! # Reference
//! Mollification: [Sharp & Crane 2020](crate::bibliography#sharp--crane-2020), its section on intrinsic
//! mollification. Weights: the same, its section on the Laplacian of triangle meshes.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, MatMut, Side};

use super::TriMesh;

/// By how much two sides of a triangle together are longer than the third, at least, as a share of the mean
/// edge: what the authors of the mollification take in their library `robust-laplacian`.
const MARGIN: f64 = 1e-5;

/// Columns that are solved together. A fixed number: which ones are must not depend on the number of threads.
const COLUMNS: usize = 8;

/// The cotangent Laplacian of a mesh: stiffness and mass.
#[derive(Debug, Clone)]
pub struct Laplacian {
    /// #V by #V, symmetric and positive semidefinite, without unit; only the lower triangle is kept, and each
    /// diagonal entry is there. Rows of vertices without a triangle are zero.
    pub stiffness: SparseColMat<u32, f64>,
    /// #V areas, a third of every vertex's triangles, in the scan's unit squared; above zero where a vertex has
    /// a triangle with three corners, zero elsewhere.
    pub mass: Vec<f64>,
    /// The triangles that it is made of.
    pub triangles: Vec<IntrinsicTriangle>,
    /// Which entries a factor of the stiffness has.
    symbolic: SymbolicLlt<u32>,
}

/// A positive definite system, ready to be solved for many right-hand sides.
#[derive(Debug)]
pub struct Factor {
    llt: Llt<u32, f64>,
}

/// A triangle by its lengths alone, wherever it is in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntrinsicTriangle {
    /// The vertices at its corners.
    pub corners: [u32; 3],
    /// Length of the side across each corner, in the scan's unit, any two together longer than the third.
    pub lengths: [f64; 3],
}

impl Laplacian {
    /// The Laplacian of all triangles that have three different corners at finite places.
    ///
    /// `None` if there are more entries than an index holds (2³² and more), or than memory.
    #[must_use]
    pub fn new(mesh: &TriMesh) -> Option<Self> {
        let mut triangles = usable(mesh);
        mollify(&mut triangles);
        let count = mesh.positions.len();
        let mut mass = vec![0.0; count];
        let mut diagonal = vec![0.0; count];
        let mut entries = Vec::with_capacity(count + 3 * triangles.len());
        for triangle in &triangles {
            let [a, b, c] = triangle.corners;
            let third = triangle.area() / 3.0;
            let cotangents = triangle.cotangents();
            for ([v, a, b], cotangent) in [[a, b, c], [b, c, a], [c, a, b]]
                .into_iter()
                .zip(cotangents)
            {
                mass[v as usize] += third;
                let weight = 0.5 * cotangent;
                entries.push(Triplet::new(a.max(b), a.min(b), -weight));
                diagonal[a as usize] += weight;
                diagonal[b as usize] += weight;
            }
        }
        entries.extend(
            (0u32..)
                .zip(diagonal)
                .map(|(v, sum)| Triplet::new(v, v, sum)),
        );
        let stiffness = SparseColMat::try_new_from_triplets(count, count, &entries).ok()?;
        let symbolic = SymbolicLlt::try_new(stiffness.symbolic(), Side::Lower).ok()?;
        Some(Self {
            stiffness,
            mass,
            triangles,
            symbolic,
        })
    }

    /// Area of the whole surface.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.mass.iter().sum()
    }

    /// Factors `of_mass` · M + `of_stiffness` · K by sparse Cholesky, both factors above zero. Vertices without
    /// a triangle stand alone in it: what is on their right-hand side is their solution.
    ///
    /// `None` if the matrix is not positive definite in floating-point numbers, or does not fit in memory.
    #[must_use]
    pub fn factor(&self, of_mass: f64, of_stiffness: f64) -> Option<Factor> {
        let mut matrix = self.stiffness.clone();
        let (symbolic, mut rest) = matrix.parts_mut();
        for (column, mass) in self.mass.iter().enumerate() {
            let (values, others) = rest.split_at_mut(symbolic.col_range(column).len());
            rest = others;
            for value in values.iter_mut() {
                *value *= of_stiffness;
            }
            // The lower triangle's first entry in a column, rows ascending, is on the diagonal.
            if let Some(diagonal) = values.first_mut() {
                *diagonal += if *mass > 0.0 { of_mass * mass } else { 1.0 };
            }
        }
        Llt::try_new_with_symbolic(self.symbolic.clone(), matrix.as_ref(), Side::Lower)
            .ok()
            .map(|llt| Factor { llt })
    }
}

impl Factor {
    /// Replaces the right-hand sides (#V by any number) by their solutions, several at once on several threads.
    ///
    /// The numbers are the same for any number of threads: which columns go together is fixed, and each such group
    /// is solved by one thread.
    pub fn solve(&self, right: &mut Mat<f64>) {
        self.solve_in(right.as_mut());
    }

    /// As [`Factor::solve`], for a part of a matrix.
    pub fn solve_in(&self, mut right: MatMut<'_, f64>) {
        let groups = right.ncols().div_ceil(COLUMNS);
        if groups <= 1 {
            if right.ncols() > 0 {
                self.llt.solve_in_place(right.as_mut());
            }
            return;
        }
        let (left, right) = right.split_at_col_mut(groups / 2 * COLUMNS);
        rayon::join(|| self.solve_in(left), || self.solve_in(right));
    }
}

impl IntrinsicTriangle {
    /// Its area, in Kahan's form of Heron's formula, which keeps its digits for slivers.
    #[must_use]
    pub fn area(&self) -> f64 {
        let mut lengths = self.lengths;
        lengths.sort_unstable_by(|x, y| y.total_cmp(x));
        let [a, b, c] = lengths;
        let product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
        0.25 * product.max(0.0).sqrt()
    }

    /// Cotangent of the angle at each corner.
    #[must_use]
    pub fn cotangents(&self) -> [f64; 3] {
        let [a, b, c] = self.lengths;
        let fourfold = 4.0 * self.area();
        // b² + c² − a², by differences that lose fewer digits.
        [[a, b, c], [b, c, a], [c, a, b]].map(|[a, b, c]| ((b - a) * (b + a) + c * c) / fourfold)
    }
}

/// The usable triangles, at the lengths that they have in space.
fn usable(mesh: &TriMesh) -> Vec<IntrinsicTriangle> {
    (mesh.triangles.iter().enumerate())
        .filter(|(_, [a, b, c])| a != b && b != c && c != a)
        .map(|(f, corners)| {
            let [a, b, c] = mesh.corners(f);
            IntrinsicTriangle {
                corners: *corners,
                lengths: [(c - b).norm(), (a - c).norm(), (b - a).norm()],
            }
        })
        .filter(|triangle| triangle.lengths.iter().all(|l| l.is_finite()))
        .collect()
}

/// Makes all sides longer by the least length with which every triangle has its margin.
fn mollify(triangles: &mut [IntrinsicTriangle]) {
    let sum: f64 = triangles.iter().flat_map(|t| t.lengths).sum();
    // A mesh that is one point has lengths only by this; which ones does not matter.
    let mean = if sum > 0.0 {
        sum / (3 * triangles.len()) as f64
    } else {
        1.0
    };
    let lacking = |[a, b, c]: [f64; 3]| MARGIN * mean + (a - b - c).max(b - c - a).max(c - a - b);
    let longer = (triangles.iter())
        .map(|triangle| lacking(triangle.lengths))
        .fold(0.0, f64::max);
    for length in triangles.iter_mut().flat_map(|t| &mut t.lengths) {
        *length += longer;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::vertex_areas;
    use approx::assert_relative_eq;
    use nalgebra::Point3;

    /// A wavy sheet of irregular triangles.
    fn sheet(size: u32) -> TriMesh {
        let mut mesh = TriMesh::default();
        for i in 0..size {
            for j in 0..size {
                let (x, y) = (f64::from(j), f64::from(i));
                let shift = 0.2 * (1.7 * x + 2.9 * y).sin();
                let z = (0.4 * x).sin() + 0.1 * y;
                mesh.positions.push(Point3::new(x + shift, y - shift, z));
                if i + 1 < size && j + 1 < size {
                    let [a, b] = [i * size + j, i * size + j + 1];
                    let [c, d] = [a + size, b + size];
                    mesh.triangles.extend([[a, b, c], [b, d, c]]);
                }
            }
        }
        mesh
    }

    /// K x, both triangles of the matrix.
    fn stiff(laplacian: &Laplacian, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; x.len()];
        for entry in laplacian.stiffness.triplet_iter() {
            let (row, column) = (entry.row, entry.col);
            product[row] += entry.val * x[column];
            if row != column {
                product[column] += entry.val * x[row];
            }
        }
        product
    }

    #[test]
    fn a_constant_has_no_gradient_and_a_plane_the_energy_of_its_slope() {
        let mut mesh = sheet(9);
        for p in &mut mesh.positions {
            p.z = 0.0;
        }
        let laplacian = Laplacian::new(&mesh).unwrap();
        let ones = vec![1.0; mesh.positions.len()];
        assert!(stiff(&laplacian, &ones).iter().all(|x| x.abs() < 1e-12));
        let slope: Vec<f64> = mesh.positions.iter().map(|p| 2.0 * p.x - p.y).collect();
        let energy: f64 = stiff(&laplacian, &slope)
            .iter()
            .zip(&slope)
            .map(|(a, b)| a * b)
            .sum();
        assert_relative_eq!(energy, 5.0 * laplacian.area(), max_relative = 1e-12);
    }

    #[test]
    fn a_mesh_without_slivers_keeps_its_areas() {
        let mesh = sheet(7);
        let laplacian = Laplacian::new(&mesh).unwrap();
        for (mass, area) in laplacian.mass.iter().zip(vertex_areas(&mesh)) {
            assert_relative_eq!(*mass, area, max_relative = 1e-12);
        }
    }

    #[test]
    fn a_solution_solves_its_system_and_a_loose_vertex_keeps_its_value() {
        let mut mesh = sheet(8);
        mesh.positions.push(Point3::new(1e3, 0.0, 0.0));
        let laplacian = Laplacian::new(&mesh).unwrap();
        let factor = laplacian.factor(0.7, 1.3).unwrap();
        let right = |v: usize, k: usize| ((v * (k + 2)) as f64).sin();
        let mut solution = Mat::from_fn(65, 19, right);
        factor.solve(&mut solution);
        for k in 0..19 {
            let x: Vec<f64> = solution.col(k).iter().copied().collect();
            for (v, kx) in stiff(&laplacian, &x).iter().enumerate().take(64) {
                let left = 1.3 * kx + 0.7 * laplacian.mass[v] * x[v];
                assert_relative_eq!(left, right(v, k), epsilon = 1e-10);
            }
            assert_relative_eq!(x[64], right(64, k));
        }
    }

    #[test]
    fn solutions_are_the_same_for_any_number_of_threads() {
        let laplacian = Laplacian::new(&sheet(30)).unwrap();
        let solved = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| {
                let factor = laplacian.factor(1.0, 1.0).unwrap();
                let mut solution = Mat::from_fn(900, 37, |v, k| ((v * (k + 2)) as f64).sin());
                factor.solve(&mut solution);
                solution
            })
        };
        assert_eq!(solved(1), solved(3));
    }

    #[test]
    fn slivers_folds_and_crowded_edges_leave_it_definite_and_their_surroundings_alone() {
        let mesh = sheet(8);
        let clean = Laplacian::new(&mesh).unwrap();
        let mut dirty = mesh.clone();
        // A needle, a triangle without area, one without three corners, and a third one at an edge.
        dirty
            .positions
            .push(mesh.positions[0] + (mesh.positions[1] - mesh.positions[0]) * 1e-14);
        dirty.positions.push(mesh.positions[1]);
        dirty
            .triangles
            .extend([[0, 1, 64], [1, 65, 2], [0, 0, 1], [1, 0, 17]]);
        let laplacian = Laplacian::new(&dirty).unwrap();
        assert!(laplacian.mass.iter().all(|m| *m > 0.0));
        assert!(laplacian.factor(1e-6, 1.0).is_some());
        // A vertex far from them has the same row but for the margin.
        let row = |of: &Laplacian, count: usize| {
            let mut unit = vec![0.0; count];
            unit[44] = 1.0;
            stiff(of, &unit)
        };
        for (a, b) in row(&clean, 64).iter().zip(row(&laplacian, 66)) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
    }

    #[test]
    fn a_mesh_of_nothing_has_an_empty_one() {
        let empty = Laplacian::new(&TriMesh::default()).unwrap();
        assert!(empty.mass.is_empty());
        let point = TriMesh {
            positions: vec![Point3::origin(); 3],
            triangles: vec![[0, 1, 2]],
        };
        assert!(Laplacian::new(&point).unwrap().factor(1.0, 1.0).is_some());
    }
}
