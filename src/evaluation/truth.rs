//! A fill against what was cut out. Told, but nothing is ranked by it.

use nalgebra::{Point3, Vector3};
use serde::Serialize;

use crate::mesh::{Adjacency, PointTree, TriMesh};

use super::hole::Hole;
use super::judged::Judged;

/// Triangles of the truth that are looked at: those of so many vertices next to a completed one.
const NEAREST: usize = 12;

/// How far a fill is from the truth: smooth fills of stochastic relief come out better here than true pieces
/// of the same surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AgainstTruth {
    /// Root mean square distance of the completed vertices from the true surface along the base normal,
    /// in the scan's unit.
    pub rmse: f64,
    /// The mean integral of the fill less that of the truth in the same place, in percent of that.
    pub mean_integral_difference_percent: f64,
    /// Root mean square height of the truth about its mean there.
    pub true_sq: f64,
    /// Completed vertices with a true surface above or below.
    pub vertices: usize,
}

/// Compares the piece, an area to each of its vertices, with the truth; `None` if there is none anywhere.
pub(super) fn compare(
    uncut: &TriMesh,
    hole: &Hole,
    judged: &Judged,
    piece: &[u32],
    areas: &[f64],
) -> Option<AgainstTruth> {
    let truth = Truth::new(uncut, hole, judged.origin)?;
    let rows: Vec<[f64; 3]> = (piece.iter().zip(areas))
        .filter_map(|(v, area)| {
            let (p, normal) = (judged.mesh.positions[*v as usize], judged.normal(*v));
            let height = judged.height(*v);
            Some([*area, height, height + truth.along(&p, &normal)?])
        })
        .collect();
    let total: f64 = rows.iter().map(|[area, ..]| area).sum();
    if total <= 0.0 {
        return None;
    }
    let mean = |of: &dyn Fn(f64, f64) -> f64| {
        let sum: f64 = rows
            .iter()
            .map(|[area, fill, truth]| area * of(*fill, *truth))
            .sum();
        sum / total
    };
    let true_mean = mean(&|_, truth| truth);
    Some(AgainstTruth {
        rmse: mean(&|fill, truth| (fill - truth).powi(2)).sqrt(),
        mean_integral_difference_percent: 100.0
            * (mean(&|fill, _| fill.abs()) / mean(&|_, truth| truth.abs()) - 1.0),
        true_sq: mean(&|_, truth| (truth - true_mean).powi(2)).sqrt(),
        vertices: rows.len(),
    })
}

/// What was cut out.
struct Truth {
    positions: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    adjacency: Adjacency,
    tree: PointTree,
    /// By number in the tree: vertex.
    vertices: Vec<u32>,
}

impl Truth {
    fn new(uncut: &TriMesh, hole: &Hole, origin: Vector3<f64>) -> Option<Self> {
        let mesh = TriMesh {
            positions: uncut.positions.iter().map(|p| p - origin).collect(),
            triangles: hole.triangles(uncut).copied().collect(),
        };
        let mut vertices: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        if vertices.is_empty() {
            return None;
        }
        let points: Vec<_> = (vertices.iter())
            .map(|v| mesh.positions[*v as usize])
            .collect();
        Some(Self {
            tree: PointTree::new(&points),
            adjacency: Adjacency::new(&mesh),
            positions: mesh.positions,
            triangles: mesh.triangles,
            vertices,
        })
    }

    /// How far the true surface is from `p` along `normal`: the nearest place where the line meets it.
    fn along(&self, p: &Point3<f64>, normal: &Vector3<f64>) -> Option<f64> {
        let near = self.tree.nearest_n(p, NEAREST);
        (near.iter())
            .flat_map(|found| {
                self.adjacency
                    .triangles
                    .row(self.vertices[found.index] as usize)
            })
            .filter_map(|f| {
                let corners = self.triangles[*f as usize].map(|v| self.positions[v as usize]);
                meet(p, normal, corners)
            })
            .min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }
}

/// Where the line from `p` along `d` meets a triangle, in lengths of `d`.
///
/// # Reference
/// T. Möller, B. Trumbore: *Fast, minimum storage ray-triangle intersection.* Journal of Graphics Tools
/// 2(1), 21–28, 1997.
fn meet(p: &Point3<f64>, d: &Vector3<f64>, [a, b, c]: [Point3<f64>; 3]) -> Option<f64> {
    /// Next to an edge, rounding must not lose the line between two triangles.
    const SLACK: f64 = 1e-9;
    let (ab, ac) = (b - a, c - a);
    let across = d.cross(&ac);
    let volume = ab.dot(&across);
    let from_a = p - a;
    let u = from_a.dot(&across) / volume;
    let other = from_a.cross(&ab);
    let v = d.dot(&other) / volume;
    let inside = u >= -SLACK && v >= -SLACK && u + v <= 1.0 + SLACK;
    let t = ac.dot(&other) / volume;
    (inside && t.is_finite()).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_meets_a_triangle_where_it_is_and_nowhere_else() {
        let corners = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 3.0]].map(Point3::from);
        let up = Vector3::z();
        let t = meet(&Point3::new(0.5, 0.5, 0.0), &up, corners).unwrap();
        assert!((t - 1.5).abs() < 1e-12);
        let t = meet(&Point3::new(0.5, 0.5, 9.0), &up, corners).unwrap();
        assert!((t + 7.5).abs() < 1e-12);
        assert_eq!(meet(&Point3::new(1.5, 1.5, 0.0), &up, corners), None);
        assert_eq!(
            meet(&Point3::new(0.5, 0.5, 0.0), &Vector3::x(), corners),
            None
        );
    }
}
