//! Free form: the smoothest surface near what was measured, from one sparse solve.
//!
//! The surface x minimises Σ mᵥ ‖xᵥ − pᵥ‖² + (λ/2π)⁴ E(x): m is the vertices' area, p are the measured
//! positions, and E is the bending energy ∫(Δx)². Under the scan this is a low-pass of the spline kind,
//! with transmission 1 / (1 + (λ q / 2π)⁴) at the wave number q: a half at the wavelength λ
//! (ISO 16610-22 has the same curve for profiles). Where nothing was measured it is the surface that
//! bends least, and it leaves the rim without a kink.
//!
//! The energy sums, over all edges between two triangles, the squared jump of the slope there. Unlike the
//! squared cotangent Laplacian it needs no values beyond the end of the surface and leaves every
//! linear function alone, so that the base does not shrink at rims.
//!
//! # Reference
//! Energy: [Bergou et al. 2006](crate::bibliography#bergou-et-al-2006), §3. Filter: ISO 16610-22:2015, 4.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use nalgebra::Point3;
use thiserror::Error;

use crate::mesh::{TriMesh, triangle_normal, vertex_areas};

/// Slopes across a sliver change by up to its aspect ratio; edges with more than this (a regular edge has
/// 2.3) count less, so that a single sliver does not hold the surface.
const STIFFEST: f64 = 12.0;

/// Least area of a measured vertex, as a share of the mean: every one pulls at the surface.
const LEAST_AREA: f64 = 1e-6;

/// Least area of a triangle that bends, as a share of the mean: smaller ones would be stiffer than digits hold.
const LEAST_BENT_AREA: f64 = 1e-3;

/// What a vertex does in the solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It pulls the surface to its position.
    Measured,
    /// The surface passes where it bends least.
    Free,
    /// It stays where it is.
    Fixed,
}

/// Why there is no smooth surface.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "the smooth surface is not determined there: its triangles are degenerate, or hang on nothing measured"
)]
pub struct Undetermined;

/// The smoothest surface near the measured vertices: #V points, one a vertex of the mesh.
///
/// `mesh` gives the positions to stay near (of [`Role::Free`] vertices: not used), `shape` (#V points) the
/// lengths and angles that bending is measured on, `wavelength` what is told apart from relief, in the
/// scan's unit. Vertices without a triangle stay where they are.
///
/// # Errors
/// [`Undetermined`] if a free vertex hangs on nothing.
///
/// # Panics
/// If `shape` or `roles` have not one entry a vertex.
pub fn smooth_form(
    mesh: &TriMesh,
    shape: &[Point3<f64>],
    roles: &[Role],
    wavelength: f64,
) -> Result<Vec<Point3<f64>>, Undetermined> {
    let system = System::new(mesh, shape, roles, wavelength);
    let mut solved = mesh.positions.clone();
    if system.unknowns.is_empty() {
        return Ok(solved);
    }
    let right = system.solve()?;
    for (row, v) in system.unknowns.iter().enumerate() {
        let point = Point3::new(right[(row, 0)], right[(row, 1)], right[(row, 2)]);
        if !point.iter().all(|x| x.is_finite()) {
            return Err(Undetermined);
        }
        solved[*v as usize] = point;
    }
    Ok(solved)
}

/// The normal equations of the vertices that are not fixed.
struct System {
    /// The vertex of each row, ascending.
    unknowns: Vec<u32>,
    /// By vertex: its row.
    rows: Vec<Option<u32>>,
    lower: Vec<Triplet<u32, u32, f64>>,
    right: Vec<[f64; 3]>,
}

impl System {
    fn new(mesh: &TriMesh, shape: &[Point3<f64>], roles: &[Role], wavelength: f64) -> Self {
        assert_eq!(mesh.positions.len(), shape.len(), "one point a vertex");
        assert_eq!(mesh.positions.len(), roles.len(), "one role a vertex");
        let used = mesh.used_vertices();
        let mut rows = vec![None; roles.len()];
        let mut unknowns = Vec::new();
        for (v, row) in (0u32..).zip(&mut rows) {
            if used[v as usize] && roles[v as usize] != Role::Fixed {
                *row = u32::try_from(unknowns.len()).ok();
                unknowns.push(v);
            }
        }
        let mut system = Self {
            right: vec![[0.0; 3]; unknowns.len()],
            lower: Vec::new(),
            unknowns,
            rows,
        };
        let shaped = TriMesh {
            positions: shape.to_vec(),
            triangles: mesh.triangles.clone(),
        };
        let areas = vertex_areas(&shaped);
        system.stay_near(mesh, &areas, roles);
        let mean_triangle = areas.iter().sum::<f64>() / mesh.triangles.len().max(1) as f64;
        let least = LEAST_BENT_AREA * mean_triangle;
        let bending = (wavelength / std::f64::consts::TAU).powi(4);
        for hinge in hinges(&mesh.triangles) {
            if let Some((stencil, weight)) = slope_jump(hinge.map(|v| shape[v as usize]), least) {
                system.bend(mesh, hinge, stencil, weight * bending);
            }
        }
        system
    }

    fn stay_near(&mut self, mesh: &TriMesh, areas: &[f64], roles: &[Role]) {
        let mean = areas.iter().sum::<f64>() / self.unknowns.len().max(1) as f64;
        for (row, v) in (0u32..).zip(&self.unknowns) {
            let v = *v as usize;
            if roles[v] == Role::Measured {
                let area = areas[v].max(LEAST_AREA * mean);
                self.lower.push(Triplet::new(row, row, area));
                self.right[row as usize] = (mesh.positions[v].coords * area).into();
            }
        }
    }

    /// Adds weight · (Σ stencil x)² over the four vertices of a hinge.
    fn bend(&mut self, mesh: &TriMesh, hinge: [u32; 4], stencil: [f64; 4], weight: f64) {
        for (a, i) in hinge.iter().zip(stencil) {
            let Some(row) = self.rows[*a as usize] else {
                continue;
            };
            for (b, j) in hinge.iter().zip(stencil) {
                let entry = weight * i * j;
                match self.rows[*b as usize] {
                    Some(column) if column <= row => {
                        self.lower.push(Triplet::new(row, column, entry));
                    }
                    Some(_) => {}
                    None => {
                        let fixed = mesh.positions[*b as usize];
                        for (sum, x) in self.right[row as usize].iter_mut().zip(fixed.iter()) {
                            *sum -= entry * x;
                        }
                    }
                }
            }
        }
    }

    /// #unknowns by 3 coordinates.
    fn solve(&self) -> Result<Mat<f64>, Undetermined> {
        let n = self.unknowns.len();
        let matrix = SparseColMat::<u32, f64>::try_new_from_triplets(n, n, &self.lower)
            .map_err(|_| Undetermined)?;
        let symbolic =
            SymbolicLlt::try_new(matrix.symbolic(), Side::Lower).map_err(|_| Undetermined)?;
        let factor = Llt::try_new_with_symbolic(symbolic, matrix.as_ref(), Side::Lower)
            .map_err(|_| Undetermined)?;
        let mut solution = Mat::from_fn(n, 3, |row, k| self.right[row][k]);
        factor.solve_in_place(&mut solution);
        Ok(solution)
    }
}

/// The edges between two triangles: both ends, then the corners across them. Edges of more triangles, or
/// of two that are oriented against each other, are no hinges.
fn hinges(triangles: &[[u32; 3]]) -> Vec<[u32; 4]> {
    // (lower end, higher end, whether it runs upwards, corner across)
    let mut sides: Vec<(u32, u32, bool, u32)> = (triangles.iter())
        .flat_map(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]])
        .map(|[a, b, c]| (a.min(b), a.max(b), a < b, c))
        .collect();
    sides.sort_unstable();
    (sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)))
        .filter_map(|edge| match edge {
            [(a, b, false, c), (_, _, true, d)] if c != d => Some([*a, *b, *d, *c]),
            _ => None,
        })
        .collect()
}

/// The stencil over both ends of an edge and the two corners across it whose sum is the jump of the slope
/// times the edge's length, and the weight of its square, in which no area is less than `least_area`; `None`
/// for a degenerate triangle.
fn slope_jump([a, b, c, d]: [Point3<f64>; 4], least_area: f64) -> Option<([f64; 4], f64)> {
    // Of the angles at both ends, in the triangle with the corner `across`.
    let cotangents = |across: &Point3<f64>| {
        let normal = triangle_normal([a, b, *across]).norm();
        let (from_a, from_b) = ((b - a).dot(&(across - a)), (a - b).dot(&(across - b)));
        let longest = (b - a).norm_squared().max((across - a).norm_squared());
        (normal > 1e-12 * longest).then(|| (from_a / normal, from_b / normal, normal / 2.0))
    };
    let (at_a_of_c, at_b_of_c, area_of_c) = cotangents(&c)?;
    let (at_a_of_d, at_b_of_d, area_of_d) = cotangents(&d)?;
    let stencil = [
        at_b_of_c + at_b_of_d,
        at_a_of_c + at_a_of_d,
        -(at_a_of_c + at_b_of_c),
        -(at_a_of_d + at_b_of_d),
    ];
    let stiffness = stencil.iter().map(|s| s * s).sum::<f64>().sqrt();
    let limit = (STIFFEST / stiffness).min(1.0);
    Some((
        stencil,
        limit * limit / (area_of_c.max(least_area) + area_of_d.max(least_area)),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;

    /// A hexagonal grid of unit edges with a height over each vertex.
    fn sheet(size: u32, height: impl Fn(f64, f64) -> f64) -> TriMesh {
        let mut mesh = TriMesh::default();
        for i in 0..size {
            for j in 0..size {
                let x = f64::from(j) + 0.5 * f64::from(i % 2);
                let y = f64::from(i) * 0.75f64.sqrt();
                mesh.positions.push(Point3::new(x, y, height(x, y)));
                if i + 1 < size && j + 1 < size {
                    let [a, b] = [i * size + j, i * size + j + 1];
                    let [c, d] = [a + size, b + size];
                    if i % 2 == 0 {
                        mesh.triangles.extend([[a, b, c], [b, d, c]]);
                    } else {
                        mesh.triangles.extend([[a, b, d], [a, d, c]]);
                    }
                }
            }
        }
        mesh
    }

    fn flat(mesh: &TriMesh) -> Vec<Point3<f64>> {
        let flatten = |p: &Point3<f64>| Point3::new(p.x, p.y, 0.0);
        mesh.positions.iter().map(flatten).collect()
    }

    /// How much of a wave in the given direction is left in the middle of the sheet.
    fn transmission(wavelength: f64, cutoff: f64, direction: f64) -> f64 {
        let phase = |x: f64, y: f64| {
            let along = x * direction.cos() + y * direction.sin();
            (std::f64::consts::TAU * along / wavelength).cos()
        };
        let mesh = sheet(80, phase);
        let roles = vec![Role::Measured; mesh.positions.len()];
        let smooth = smooth_form(&mesh, &flat(&mesh), &roles, cutoff).unwrap();
        let (mut both, mut square) = (0.0, 0.0);
        for p in &smooth {
            if (p.x - 40.0).hypot(p.y - 35.0) < 15.0 {
                both += p.z * phase(p.x, p.y);
                square += phase(p.x, p.y).powi(2);
            }
        }
        both / square
    }

    #[test]
    fn a_wave_of_the_cutoff_is_halved_and_others_follow_the_filter_curve() {
        for direction in [0.0, 0.3, 1.2] {
            for (wavelength, cutoff) in [(12.0, 12.0), (16.0, 12.0), (10.0, 14.0)] {
                let expected = 1.0 / (1.0 + f64::powi(cutoff / wavelength, 4));
                let measured = transmission(wavelength, cutoff, direction);
                assert!((measured - expected).abs() < 0.03, "{measured} {expected}");
            }
        }
    }

    #[test]
    fn planes_stay_to_their_rims_whatever_the_triangles() {
        let mut mesh = sheet(12, |x, y| 0.3 * x - 0.7 * y + 2.0);
        // Irregular ones.
        for (i, p) in mesh.positions.iter_mut().enumerate() {
            let t = i as f64;
            *p += Vector3::new(1.0, 0.0, 0.3) * (0.3 * (1.7 * t).sin());
            *p += Vector3::new(0.0, 1.0, -0.7) * (0.3 * (2.9 * t).sin());
        }
        let mut roles = vec![Role::Measured; mesh.positions.len()];
        roles[40..60].fill(Role::Free);
        let mut mesh_with_hole = mesh.clone();
        for p in &mut mesh_with_hole.positions[40..60] {
            *p = Point3::new(1e3, 1e3, 1e3);
        }
        let smooth = smooth_form(&mesh_with_hole, &mesh.positions, &roles, 50.0).unwrap();
        for (p, q) in smooth.iter().zip(&mesh.positions) {
            assert_relative_eq!(p, q, epsilon = 1e-8);
        }
    }

    #[test]
    fn a_hole_is_spanned_by_what_bends_like_its_surroundings() {
        // A shallow bowl, and what a flat fill would miss of it.
        let bowl = |x: f64, y: f64| ((x - 20.0).powi(2) + (y - 17.0).powi(2)) / 100.0;
        let mesh = sheet(40, bowl);
        let is_hole = |p: &Point3<f64>| (p.x - 20.0).hypot(p.y - 17.0) < 8.0;
        let roles: Vec<Role> = (mesh.positions.iter())
            .map(|p| {
                if is_hole(p) {
                    Role::Free
                } else {
                    Role::Measured
                }
            })
            .collect();
        let smooth = smooth_form(&mesh, &mesh.positions, &roles, 8.0).unwrap();
        for (p, q) in smooth.iter().zip(&mesh.positions) {
            if is_hole(q) {
                assert!((p.z - bowl(p.x, p.y)).abs() < 0.1, "{p} {q}");
            }
        }
        // 0.64 deep in the middle under the rim's plane: 0.1 is small against it.
        let fixed: Vec<Role> = (roles.iter())
            .map(|r| {
                if *r == Role::Free {
                    Role::Free
                } else {
                    Role::Fixed
                }
            })
            .collect();
        let filled = smooth_form(&mesh, &mesh.positions, &fixed, 8.0).unwrap();
        for ((p, q), role) in filled.iter().zip(&mesh.positions).zip(&fixed) {
            match role {
                Role::Fixed => assert_eq!(p, q),
                _ => assert!((p.z - q.z).abs() < 0.1, "{p} {q}"),
            }
        }
    }

    #[test]
    fn what_hangs_on_nothing_is_an_error_and_loose_vertices_stay() {
        let mut mesh = sheet(6, |_, _| 0.0);
        let free = vec![Role::Free; mesh.positions.len()];
        let shape = mesh.positions.clone();
        assert_eq!(smooth_form(&mesh, &shape, &free, 3.0), Err(Undetermined));
        mesh.positions.push(Point3::new(9.0, 9.0, 9.0));
        let roles = vec![Role::Measured; mesh.positions.len()];
        let smooth = smooth_form(&mesh, &mesh.positions, &roles, 3.0).unwrap();
        assert_eq!(smooth.last(), mesh.positions.last());
    }

    #[test]
    fn a_piece_shrunk_to_a_point_does_not_break_it() {
        let mut mesh = sheet(12, |x, y| (0.3 * x).sin() + 0.1 * y);
        let count = mesh.positions.len();
        let mut shape = mesh.positions.clone();
        for i in 0..4u32 {
            let (x, y) = (f64::from(i % 2), f64::from(i / 2));
            mesh.positions.push(Point3::new(30.0 + x, y, 0.0));
            shape.push(Point3::new(30.0 + 1e-7 * x, 1e-7 * y, 0.0));
        }
        let at = |i: usize| u32::try_from(count + i).unwrap();
        mesh.triangles
            .extend([[at(0), at(1), at(3)], [at(0), at(3), at(2)]]);
        let roles = vec![Role::Measured; shape.len()];
        let smooth = smooth_form(&mesh, &shape, &roles, 20.0).unwrap();
        assert!(smooth.iter().all(|p| p.coords.amax() < 60.0));
    }

    #[test]
    fn slivers_and_bent_sheets_do_not_break_it() {
        let mut mesh = sheet(10, |x, y| (0.3 * x).sin() + 0.1 * y);
        mesh.positions[45] = mesh.positions[46] + Vector3::new(1e-9, 0.0, 0.0);
        mesh.positions[23] = mesh.positions[24];
        let roles = vec![Role::Measured; mesh.positions.len()];
        let smooth = smooth_form(&mesh, &mesh.positions, &roles, 6.0).unwrap();
        assert!(smooth.iter().all(|p| p.coords.amax() < 20.0));
    }
}
