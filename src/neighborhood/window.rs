//! The window: all vertices within a number of edges.

use crate::mesh::Csr;

/// Collects windows; keeps its memory between calls.
#[derive(Debug, Clone)]
pub struct Window {
    /// Number of the last call that saw the vertex.
    seen: Vec<u32>,
    call: u32,
    found: Vec<u32>,
    /// Number of the last union that the vertex is in.
    united: Vec<u32>,
    union: u32,
}

impl Window {
    /// For a mesh of so many vertices.
    #[must_use]
    pub fn new(vertices: usize) -> Self {
        Self {
            seen: vec![0; vertices],
            call: 0,
            found: Vec::new(),
            united: vec![0; vertices],
            union: 0,
        }
    }

    /// Begins a union of windows with none.
    pub fn begin_union(&mut self) {
        if self.union == u32::MAX {
            self.united.fill(0);
            self.union = 0;
        }
        self.union += 1;
    }

    /// Adds the window around `center`, and `center`, to the union.
    pub fn unite(&mut self, neighbors: &Csr, center: u32, radius: usize) {
        self.around(neighbors, center, radius);
        for v in &self.found {
            self.united[*v as usize] = self.union;
        }
    }

    /// Whether a vertex is in a window of the union.
    #[must_use]
    pub fn holds(&self, v: u32) -> bool {
        self.united[v as usize] == self.union
    }

    /// The vertices within `radius` edges of `center` (without it), nearest ring first.
    pub fn around(&mut self, neighbors: &Csr, center: u32, radius: usize) -> &[u32] {
        if self.call == u32::MAX {
            self.seen.fill(0);
            self.call = 0;
        }
        self.call += 1;
        self.found.clear();
        self.found.push(center);
        self.seen[center as usize] = self.call;
        let mut ring = 0..1;
        for _ in 0..radius {
            for i in ring.clone() {
                for n in neighbors.row(self.found[i] as usize) {
                    if self.seen[*n as usize] != self.call {
                        self.seen[*n as usize] = self.call;
                        self.found.push(*n);
                    }
                }
            }
            ring = ring.end..self.found.len();
        }
        &self.found[1..]
    }
}

/// Standard deviation of the Gaussian for a window of `radius` edges of length `spacing`: the
/// window's width over 6.4.
///
/// # Reference
/// [Efros & Leung 1999](crate::bibliography#efros--leung-1999), their published code.
#[must_use]
pub fn window_sigma(radius: usize, spacing: f64) -> f64 {
    (2 * radius + 1) as f64 * spacing / 6.4
}

/// Weight of a neighbor at a squared distance: exp(−d²/2σ²).
#[must_use]
pub fn gaussian_weight(distance_sq: f64, sigma: f64) -> f64 {
    (-distance_sq / (2.0 * sigma * sigma)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Adjacency, TriMesh};
    use nalgebra::Point3;

    #[test]
    fn a_window_holds_each_vertex_within_its_radius_once() {
        // A strip: vertex i is joined to i ± 1 and i ± 2.
        let mesh = TriMesh {
            positions: vec![Point3::origin(); 20],
            triangles: (0..18).map(|i| [i, i + 1, i + 2]).collect(),
        };
        let neighbors = Adjacency::new(&mesh).neighbors;
        let mut window = Window::new(20);
        for radius in 0..5usize {
            let mut found = window.around(&neighbors, 9, radius).to_vec();
            found.sort_unstable();
            let reach = 2 * u32::try_from(radius).unwrap();
            let expected: Vec<u32> = (9 - reach.min(9)..=(9 + reach).min(19))
                .filter(|v| *v != 9)
                .collect();
            assert_eq!(found, expected);
            window.begin_union();
            assert!(!window.holds(9));
            window.unite(&neighbors, 9, radius);
            window.unite(&neighbors, 19, 0);
            for v in 0..20 {
                assert_eq!(window.holds(v), v == 9 || v == 19 || expected.contains(&v));
            }
        }
    }

    #[test]
    fn weights_fall_off_as_published() {
        // At the edge of the window: exp(−3.2²/2).
        let sigma = window_sigma(3, 0.5);
        assert!((gaussian_weight((3.5f64 * 0.5).powi(2), sigma) - (-5.12f64).exp()).abs() < 1e-12);
    }
}
