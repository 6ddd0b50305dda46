//! Areas, lengths and normals.

use std::collections::BTreeSet;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::{TriMesh, first_at_place};

/// Area of a triangle.
#[must_use]
pub fn triangle_area([a, b, c]: [Point3<f64>; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// Normal of a triangle, of length twice its area (zero for a degenerate one).
#[must_use]
pub fn triangle_normal([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Area of all triangles together.
#[must_use]
pub fn surface_area(mesh: &TriMesh) -> f64 {
    (0..mesh.triangles.len())
        .map(|f| triangle_area(mesh.corners(f)))
        .sum()
}

/// A tangent of the plane with unit normal `from`, turned into the plane with unit normal `to` about the line
/// where they meet. Planes back to back have no such turn: it is taken as it is then.
#[must_use]
pub fn turned_tangent(
    tangent: &Vector3<f64>,
    from: &Vector3<f64>,
    to: &Vector3<f64>,
) -> Vector3<f64> {
    let cosine = from.dot(to);
    if cosine < -0.99 {
        return *tangent;
    }
    tangent - (from + to) * (tangent.dot(to) / (1.0 + cosine))
}

/// For each vertex, a third of the area of its triangles.
#[must_use]
pub fn vertex_areas(mesh: &TriMesh) -> Vec<f64> {
    let mut areas = vec![0.0; mesh.positions.len()];
    for (f, triangle) in mesh.triangles.iter().enumerate() {
        let third = triangle_area(mesh.corners(f)) / 3.0;
        for &v in triangle {
            areas[v as usize] += third;
        }
    }
    areas
}

/// Unit normals, weighted by triangle area; zero where no triangle (or only degenerate ones) meet.
#[must_use]
pub fn vertex_normals(mesh: &TriMesh) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); mesh.positions.len()];
    for (f, triangle) in mesh.triangles.iter().enumerate() {
        let normal = triangle_normal(mesh.corners(f));
        for &v in triangle {
            normals[v as usize] += normal;
        }
    }
    for normal in &mut normals {
        *normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    }
    normals
}

/// The same, and where no triangle meets that of the first vertex at the same place that has one: vertices that stood on the
/// other side of a seam before it was joined move as those that stand for them.
#[must_use]
pub fn seam_normals(mesh: &TriMesh) -> Vec<Vector3<f64>> {
    let mut normals = vertex_normals(mesh);
    let is_known = |normal: &Vector3<f64>| normal.norm_squared() > 0.0;
    if normals.iter().all(is_known) {
        return normals;
    }
    let first = first_at_place(&mesh.positions);
    let mut of_place = vec![None; normals.len()];
    for (normal, place) in normals.iter().zip(&first).filter(|(n, _)| is_known(n)) {
        of_place[*place as usize].get_or_insert(*normal);
    }
    for (normal, place) in normals.iter_mut().zip(&first) {
        if let (false, Some(known)) = (is_known(normal), of_place[*place as usize]) {
            *normal = known;
        }
    }
    normals
}

/// The undirected edges, each once as (lower, higher) index, ascending.
#[must_use]
pub fn edges(mesh: &TriMesh) -> Vec<[u32; 2]> {
    // Both ends in one number: sorted much faster than pairs.
    let mut edges: Vec<u64> = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| u64::from(a.min(b)) << 32 | u64::from(a.max(b)))
        .collect();
    edges.par_sort_unstable();
    edges.dedup();
    #[expect(clippy::cast_possible_truncation, reason = "each half is a u32")]
    let ends = |edge: u64| [(edge >> 32) as u32, edge as u32];
    edges.into_iter().map(ends).collect()
}

/// Length of every undirected edge, ascending by vertex pair.
#[must_use]
pub fn edge_lengths(mesh: &TriMesh) -> Vec<f64> {
    edges(mesh)
        .into_iter()
        .map(|[a, b]| (mesh.positions[a as usize] - mesh.positions[b as usize]).norm())
        .collect()
}

/// Median length of all edges, the upper one of an even number; `None` without triangles.
#[must_use]
pub fn median_edge(mesh: &TriMesh) -> Option<f64> {
    let mut lengths = edge_lengths(mesh);
    let middle = lengths.len() / 2;
    (!lengths.is_empty()).then(|| *lengths.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Euler characteristic V − E + F, of the vertices that a triangle uses.
#[must_use]
pub fn euler_characteristic(mesh: &TriMesh) -> i64 {
    let used: BTreeSet<u32> = mesh.triangles.iter().flatten().copied().collect();
    let signed = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
    signed(used.len()) - signed(edges(mesh).len()) + signed(mesh.triangles.len())
}

/// Length of the diagonal of the axis-aligned bounding box of `points`; 0 for none.
#[must_use]
pub fn bounding_diagonal<'a>(points: impl IntoIterator<Item = &'a Point3<f64>>) -> f64 {
    let mut points = points.into_iter();
    let Some(first) = points.next() else {
        return 0.0;
    };
    let (low, high) = points.fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// Gradients (#V) of a function that is linear in each triangle, values at the vertices (#V): the means of
/// those in their triangles by area. Triangles with a corner whose value is not finite do not count; 0 without
/// any that does.
#[must_use]
pub fn gradients(mesh: &TriMesh, values: &[f64]) -> Vec<Vector3<f64>> {
    let mut sums = vec![(Vector3::zeros(), 0.0); values.len()];
    for (f, t) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(f);
        let [ha, hb, hc] = t.map(|v| values[v as usize]);
        let normal = triangle_normal([a, b, c]);
        let double_area = normal.norm();
        // Twice the area times the gradient.
        let gradient = normal.cross(&((c - b) * ha + (a - c) * hb + (b - a) * hc)) / double_area;
        if gradient.iter().all(|x| x.is_finite()) {
            for v in t {
                let (sum, weight) = &mut sums[*v as usize];
                *sum += gradient;
                *weight += double_area;
            }
        }
    }
    (sums.into_iter())
        .map(|(sum, weight)| if weight > 0.0 { sum / weight } else { sum })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_that_a_joined_seam_left_alone_have_the_normal_of_their_place() {
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [-0.0, 0.0, 0.0],
            [7.0, 0.0, 0.0],
        ];
        let mesh = TriMesh {
            positions: corners.map(Point3::from).to_vec(),
            triangles: vec![[4, 1, 2]],
        };
        let normals = seam_normals(&mesh);
        assert_eq!(normals[..5], [Vector3::z(); 5]);
        assert_eq!(normals[5], Vector3::zeros());
    }

    #[test]
    fn a_gradient_is_that_of_a_linear_function() {
        let mesh = TriMesh {
            positions: vec![
                Point3::new(0.0, 0.0, 1.0),
                Point3::new(2.0, 0.1, 1.0),
                Point3::new(0.3, 1.0, 1.0),
                Point3::new(2.5, 1.5, 1.0),
            ],
            triangles: vec![[0, 1, 2], [1, 3, 2]],
        };
        let values: Vec<f64> = mesh.positions.iter().map(|p| 3.0 * p.x - p.y).collect();
        for gradient in gradients(&mesh, &values) {
            assert!((gradient - Vector3::new(3.0, -1.0, 0.0)).norm() < 1e-12);
        }
    }
}
