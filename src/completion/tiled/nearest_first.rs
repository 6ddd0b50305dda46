//! Vertices by their distance along edges.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::ControlFlow;

use nalgebra::Point3;

use crate::mesh::Csr;

/// Visits vertices by their distance along edges from the nearest of `start`, which come first; equally distant ones
/// by their numbers. `visit` hears vertex and distance, and may break off. What no edges lead to is not visited.
pub(super) fn nearest_first(
    neighbors: &Csr,
    points: &[Point3<f64>],
    start: &[u32],
    mut visit: impl FnMut(u32, f64) -> ControlFlow<()>,
) {
    let mut distances = vec![f64::INFINITY; points.len()];
    // Distances are not negative: their bits are ordered as they are.
    let mut waiting = BinaryHeap::new();
    for v in start {
        distances[*v as usize] = 0.0;
        waiting.push(Reverse((0u64, *v)));
    }
    while let Some(Reverse((bits, v))) = waiting.pop() {
        let distance = f64::from_bits(bits);
        if distance > distances[v as usize] {
            continue;
        }
        if visit(v, distance).is_break() {
            return;
        }
        // Never again, even if it was in `start` twice.
        distances[v as usize] = f64::NEG_INFINITY;
        for n in neighbors.row(v as usize) {
            let way = distance + (points[*n as usize] - points[v as usize]).norm();
            if way < distances[*n as usize] {
                distances[*n as usize] = way;
                waiting.push(Reverse((way.to_bits(), *n)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Adjacency, TriMesh};

    #[test]
    fn vertices_come_once_each_in_the_order_of_their_distance() {
        // A strip: even numbers below, odd ones above; and a triangle elsewhere.
        let at = |v: u32| Point3::new(f64::from(v / 2), f64::from(v % 2), 0.0);
        let mut triangles: Vec<[u32; 3]> = (0..18).map(|i| [i, i + 1, i + 2]).collect();
        triangles.push([20, 21, 22]);
        let mesh = TriMesh {
            positions: (0..23).map(at).collect(),
            triangles,
        };
        let neighbors = Adjacency::new(&mesh).neighbors;
        let mut found = Vec::new();
        nearest_first(&neighbors, &mesh.positions, &[4, 4], |v, distance| {
            found.push((v, distance));
            ControlFlow::Continue(())
        });
        assert!(found.is_sorted_by(|a, b| (a.1, a.0) <= (b.1, b.0)));
        let mut seen: Vec<u32> = found.iter().map(|(v, _)| *v).collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..20).collect::<Vec<u32>>());
        // Along the lower edge straight, up by one edge more.
        for (v, distance) in &found {
            let along = (f64::from(v / 2) - 2.0).abs();
            let up = f64::from(v % 2);
            let least = along.hypot(up);
            assert!(*distance >= least - 1e-12 && *distance <= along + up + 1e-12);
        }
    }
}
