//! Who is next to whom: compressed rows of neighbors and of incident triangles.

use super::TriMesh;

/// Compressed sparse rows: `rows` lists of `u32`, stored end to end.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Csr {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Csr {
    /// Rows from (row, item) pairs; each row keeps the order of the pairs.
    ///
    /// # Panics
    /// If a pair names a row that is not below `rows`, or there are 2³² pairs or more.
    #[must_use]
    pub fn from_pairs(rows: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut starts = vec![0u32; rows + 1];
        for (row, _) in pairs.clone() {
            starts[row as usize + 1] += 1;
        }
        for row in 0..rows {
            starts[row + 1] = starts[row]
                .checked_add(starts[row + 1])
                .expect("fewer than 2^32 entries");
        }
        let mut next = starts.clone();
        let mut items = vec![0u32; starts[rows] as usize];
        for (row, item) in pairs {
            items[next[row as usize] as usize] = item;
            next[row as usize] += 1;
        }
        Self { starts, items }
    }

    /// The items of one row.
    #[must_use]
    #[inline]
    pub fn row(&self, row: usize) -> &[u32] {
        &self.items[self.starts[row] as usize..self.starts[row + 1] as usize]
    }

    /// Appends a row.
    ///
    /// # Panics
    /// If there would be 2³² entries or more.
    pub fn push_row(&mut self, row: &[u32]) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        self.items.extend_from_slice(row);
        self.starts
            .push(u32::try_from(self.items.len()).expect("fewer than 2^32 entries"));
    }

    /// The rows in order.
    pub fn rows(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|row| self.row(row))
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sorts each row and drops what stands in it twice.
    fn sorted_unique(self) -> Self {
        let Self {
            mut starts,
            mut items,
        } = self;
        // In place: what is kept moves towards the front only.
        let (mut from, mut kept) = (0, 0);
        for end in starts.iter_mut().skip(1) {
            let next = *end as usize;
            items[from..next].sort_unstable();
            let first = kept;
            for i in from..next {
                if kept == first || items[i] != items[kept - 1] {
                    items[kept] = items[i];
                    kept += 1;
                }
            }
            from = next;
            *end = u32::try_from(kept).expect("no more than before");
        }
        items.truncate(kept);
        items.shrink_to_fit();
        Self { starts, items }
    }
}

/// Vertex neighbors and incident triangles of a mesh.
#[derive(Debug, Clone)]
pub struct Adjacency {
    /// For each vertex, the vertices it shares an edge with, ascending.
    pub neighbors: Csr,
    /// For each vertex, the triangles it is a corner of, ascending.
    pub triangles: Csr,
}

impl Adjacency {
    /// Adjacency of all vertices, used or not.
    ///
    /// # Panics
    /// If the mesh has 2³¹ triangles or more.
    #[must_use]
    pub fn new(mesh: &TriMesh) -> Self {
        let rows = mesh.positions.len();
        let half_edges = mesh
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)]);
        let corners = mesh
            .triangles
            .iter()
            .zip(0u32..)
            .flat_map(|(t, f)| t.map(|v| (v, f)));
        let (neighbors, triangles) = rayon::join(
            || Csr::from_pairs(rows, half_edges).sorted_unique(),
            || Csr::from_pairs(rows, corners).sorted_unique(),
        );
        Self {
            neighbors,
            triangles,
        }
    }

    /// Connected component of each vertex (components numbered by their lowest vertex) and the
    /// number of components; a vertex without an edge is a component of its own.
    ///
    /// # Panics
    /// If there are 2³² vertices or more.
    #[must_use]
    pub fn components(&self) -> (Vec<u32>, usize) {
        const UNSEEN: u32 = u32::MAX;
        let mut component = vec![UNSEEN; self.neighbors.len()];
        let mut count = 0u32;
        let mut stack = Vec::new();
        for start in 0..component.len() {
            if component[start] != UNSEEN {
                continue;
            }
            component[start] = count;
            stack.push(u32::try_from(start).expect("indices are u32"));
            while let Some(v) = stack.pop() {
                for &n in self.neighbors.row(v as usize) {
                    if component[n as usize] == UNSEEN {
                        component[n as usize] = count;
                        stack.push(n);
                    }
                }
            }
            count += 1;
        }
        (component, count as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn rows_hold_neighbors_and_triangles_once_each() {
        let mesh = TriMesh {
            positions: vec![Point3::origin(); 5],
            triangles: vec![[0, 1, 2], [2, 1, 3]],
        };
        let adjacency = Adjacency::new(&mesh);
        assert_eq!(adjacency.neighbors.row(1), [0, 2, 3]);
        assert_eq!(adjacency.triangles.row(2), [0, 1]);
        assert_eq!(adjacency.neighbors.row(4), [0u32; 0]);
        assert_eq!(adjacency.components(), (vec![0, 0, 0, 0, 1], 2));
    }
}
