//! The connected pieces of a surface.

use crate::mesh::{DisjointSets, Laplacian};

/// Which vertices hang together.
#[derive(Debug, Clone)]
pub(super) struct Pieces {
    /// By vertex, the number of its piece, from 0 in the order of their lowest vertices; `None` without a triangle.
    pub(super) of: Vec<Option<u32>>,
    /// By piece, its area.
    pub(super) areas: Vec<f64>,
}

impl Pieces {
    pub(super) fn new(laplacian: &Laplacian) -> Self {
        let mut sets = DisjointSets::new(laplacian.mass.len());
        for triangle in &laplacian.triangles {
            let [a, b, c] = triangle.corners;
            sets.join(a, b);
            sets.join(b, c);
        }
        let mut of: Vec<Option<u32>> = vec![None; laplacian.mass.len()];
        let mut areas: Vec<f64> = Vec::new();
        let mut count = 0;
        // The lowest of a piece is met first.
        for (v, lowest) in sets.into_lowest().into_iter().enumerate() {
            let mass = laplacian.mass[v];
            if mass > 0.0 {
                let piece = *of[lowest as usize].get_or_insert_with(|| {
                    areas.push(0.0);
                    count += 1;
                    count - 1
                });
                of[v] = Some(piece);
                areas[piece as usize] += mass;
            }
        }
        Self { of, areas }
    }
}
