//! Fewer vertices of a large mesh, for showing it: clusters of vertices on a grid.
//!
//! # Reference
//! Rossignac & Borrel 1993, *Multi-resolution 3D approximations for rendering complex scenes*; here the vertex
//! nearest to its cluster's mean stands for it, so that what is shown there was measured there.

use std::collections::HashSet;

use nalgebra::{Point3, Vector3};

use crate::mesh::triangle_area;

/// Cells on a side of the grid: as many as their numbers have bits for.
const MOST_CELLS: f64 = 2_097_151.0;

/// The part of a mesh that is shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Thinned {
    /// Numbers of the vertices that are shown, ascending.
    pub(super) vertices: Vec<u32>,
    /// Faces between them (numbered in `vertices`); those of the original part come first.
    pub(super) faces: Vec<[u32; 3]>,
    /// Number of faces of the original part.
    pub(super) original_faces: usize,
}

/// At most `most` of the vertices that faces use, and the faces that are left between them. Vertices of the
/// original and of the completed part never stand for each other. Faces with a corner that is not finite are
/// left out.
pub(super) fn thinned(
    positions: &[Point3<f64>],
    triangles: &[[u32; 3]],
    completed: &[bool],
    most: usize,
) -> Thinned {
    let is_finite = |v: &u32| positions[*v as usize].iter().all(|x| x.is_finite());
    let mut faces: Vec<[u32; 3]> = triangles.to_vec();
    faces.retain(|t| t.iter().all(is_finite));
    let mut used = vec![false; positions.len()];
    for v in faces.iter().flatten() {
        used[*v as usize] = true;
    }
    let used: Vec<u32> = (0u32..)
        .zip(&used)
        .filter(|(_, used)| **used)
        .map(|(v, _)| v)
        .collect();
    if used.len() > most {
        let area: f64 = (faces.iter())
            .map(|t| triangle_area(t.map(|v| positions[v as usize])))
            .sum();
        let cells = cells(positions, &used, completed, area, most.max(1));
        let stands_for = representatives(positions, &cells);
        for corner in faces.iter_mut().flatten() {
            *corner = stands_for[*corner as usize];
        }
        let mut seen = HashSet::new();
        faces.retain(|face| {
            let [a, b, c] = *face;
            let mut corners = *face;
            corners.sort_unstable();
            a != b && b != c && c != a && seen.insert(corners)
        });
    }
    numbered(faces, completed)
}

/// Vertices with the number of their cell, sorted; in at most `most` cells that are no larger than need be.
fn cells(
    positions: &[Point3<f64>],
    used: &[u32],
    completed: &[bool],
    area: f64,
    most: usize,
) -> Vec<(u64, u32)> {
    let (mut low, mut high) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
    for v in used {
        low = low.inf(&positions[*v as usize].coords);
        high = high.sup(&positions[*v as usize].coords);
    }
    let finest = (high - low).max() / MOST_CELLS;
    let mut size = f64::max(0.9 * (area / most as f64).sqrt(), finest);
    loop {
        let mut cells: Vec<(u64, u32)> = (used.iter())
            .map(|v| {
                let place = (positions[*v as usize].coords - low) / size;
                let part = u64::from(completed[*v as usize]);
                (
                    place.iter().fold(part, |cell, x| (cell << 21) | step(*x)),
                    *v,
                )
            })
            .collect();
        cells.sort_unstable();
        let count = cells.chunk_by(|a, b| a.0 == b.0).count();
        // Points at one place need one cell for each part.
        if count <= most.max(2) || size <= 0.0 {
            return cells;
        }
        size *= 1.02 * (count as f64 / most as f64).sqrt();
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "from 0 to 2²¹ − 1"
)]
fn step(place: f64) -> u64 {
    place.clamp(0.0, MOST_CELLS) as u64
}

/// For each vertex the one that stands for its cell: the one nearest to the mean of the cell's.
fn representatives(positions: &[Point3<f64>], cells: &[(u64, u32)]) -> Vec<u32> {
    let mut stands_for = vec![0; positions.len()];
    for cell in cells.chunk_by(|a, b| a.0 == b.0) {
        let members = || cell.iter().map(|(_, v)| *v);
        let sum: Vector3<f64> = members().map(|v| positions[v as usize].coords).sum();
        let mean = Point3::from(sum / cell.len() as f64);
        let distance_sq = |v: u32| (positions[v as usize] - mean).norm_squared();
        let nearest = members().min_by(|a, b| distance_sq(*a).total_cmp(&distance_sq(*b)));
        for v in members() {
            stands_for[v as usize] = nearest.unwrap_or(v);
        }
    }
    stands_for
}

/// Faces of the original part first, and numbers without gaps.
fn numbered(faces: Vec<[u32; 3]>, completed: &[bool]) -> Thinned {
    let is_original = |t: &[u32; 3]| t.iter().all(|v| !completed[*v as usize]);
    let (mut faces, rest): (Vec<_>, Vec<_>) = faces.into_iter().partition(is_original);
    let original_faces = faces.len();
    faces.extend(rest);
    let mut vertices: Vec<u32> = faces.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut number = vec![0u32; completed.len()];
    for (new, old) in (0u32..).zip(&vertices) {
        number[*old as usize] = new;
    }
    for corner in faces.iter_mut().flatten() {
        *corner = number[*corner as usize];
    }
    Thinned {
        vertices,
        faces,
        original_faces,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of n by n points; its right half is completed.
    fn grid(n: u32) -> (Vec<Point3<f64>>, Vec<[u32; 3]>, Vec<bool>) {
        let at = |v: u32| Point3::new(f64::from(v % n), f64::from(v / n), f64::from(v % 7) * 0.1);
        let positions: Vec<_> = (0..n * n).map(at).collect();
        let completed = positions.iter().map(|p| p.x >= f64::from(n / 2)).collect();
        let mut triangles = Vec::new();
        for v in 0..n * (n - 1) {
            if v % n + 1 < n {
                triangles.push([v, v + 1, v + n]);
                triangles.push([v + 1, v + n + 1, v + n]);
            }
        }
        (positions, triangles, completed)
    }

    #[test]
    fn a_small_mesh_stays_as_it_is_but_for_the_order_of_its_faces() {
        let (mut positions, mut triangles, completed) = grid(8);
        positions.push(Point3::new(f64::NAN, 0.0, 0.0));
        let mut marks = completed.clone();
        marks.push(false);
        let shown = thinned(&positions, &triangles, &marks, 64);
        assert_eq!(shown.vertices, (0..64).collect::<Vec<u32>>());
        let mut faces = shown.faces.clone();
        faces.sort_unstable();
        triangles.sort_unstable();
        assert_eq!(faces, triangles);
        let of_original = |t: &[u32; 3]| t.iter().all(|v| !completed[*v as usize]);
        assert!(shown.faces[..shown.original_faces].iter().all(of_original));
        assert!(!shown.faces[shown.original_faces..].iter().any(of_original));
    }

    #[test]
    fn a_large_mesh_is_thinned_to_the_number_given_and_keeps_its_extent() {
        let (positions, triangles, completed) = grid(100);
        for most in [50, 1000, 4000] {
            let shown = thinned(&positions, &triangles, &completed, most);
            let count = shown.vertices.len();
            assert!((most * 6 / 10..=most).contains(&count), "{count} of {most}");
            let right = |v: &u32| completed[shown.vertices[*v as usize] as usize];
            let first = &shown.faces[..shown.original_faces];
            assert!(!first.iter().flatten().any(right));
            // Half but for the column of faces between the parts: a third of few.
            assert!(first.len() * 4 > shown.faces.len());
            let area = |faces: &[[u32; 3]]| -> f64 {
                let at = |v: u32| positions[shown.vertices[v as usize] as usize].xy();
                let area = |t: &[u32; 3]| {
                    let [a, b, c] = t.map(at);
                    0.5 * (b - a).perp(&(c - a))
                };
                faces.iter().map(area).sum()
            };
            let cell = 100.0 / (most as f64).sqrt();
            let lost = 99.0 * 99.0 - area(&shown.faces);
            assert!((0.0..4.0 * 100.0 * cell).contains(&lost), "{lost}");
        }
    }

    #[test]
    fn no_faces_and_points_at_one_place_are_no_trouble() {
        let nothing = thinned(&[], &[], &[], 10);
        assert!(nothing.faces.is_empty() && nothing.vertices.is_empty());
        let positions = vec![Point3::origin(); 3];
        let one = thinned(&positions, &[[0, 1, 2]], &[false, true, false], 1);
        assert!(one.faces.is_empty());
        let invalid = [Point3::new(f64::NAN, 0.0, 0.0), Point3::origin()];
        let left = thinned(&invalid, &[[0, 1, 1]], &[false; 2], 10);
        assert!(left.faces.is_empty());
    }
}
