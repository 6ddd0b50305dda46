//! A mesh on several levels, of half the vertices each, and the tree that joins them.

use crate::mesh::{Csr, TriMesh};
use crate::rng::Rng;

use super::collapse::Collapse;

/// A mesh and coarser ones of the same surface.
///
/// # Reference
/// [MeshMatch 2012](crate::bibliography#meshmatch-2012), §4: edges are collapsed, the shortest first, to their midpoints; the
/// vertices that become one are its children.
#[derive(Debug, Clone)]
pub struct Hierarchy {
    /// From the finest to the coarsest.
    pub levels: Vec<TriMesh>,
    /// For each level but the coarsest: the vertex of the next coarser one that stands for each vertex.
    pub parents: Vec<Vec<u32>>,
    /// For each level but the coarsest: the vertices that each vertex of the next coarser one stands for.
    pub children: Vec<Csr>,
}

impl Hierarchy {
    /// Of a mesh, whose vertices must all be used, on levels of `counts` vertices (descending; the first not above the mesh's
    /// own). Levels end where no more edges can be collapsed.
    ///
    /// The second value has for each vertex of the given mesh the vertex of the finest level that stands for it.
    #[must_use]
    pub fn new(mesh: &TriMesh, counts: &[usize]) -> (Self, Vec<u32>) {
        let mut collapse = Collapse::new(mesh);
        let mut hierarchy = Self {
            levels: Vec::new(),
            parents: Vec::new(),
            children: Vec::new(),
        };
        let mut of_given: Vec<u32> = Vec::new();
        let mut standing_before: Vec<u32> = Vec::new();
        for wanted in counts {
            let before = collapse.count();
            collapse.to(*wanted);
            if !hierarchy.levels.is_empty() && collapse.count() * 8 > before * 7 {
                break;
            }
            let (level, standing) = collapse.now();
            if let Some(finer) = hierarchy.levels.last() {
                let mut parents = vec![0; finer.positions.len()];
                for (own, above) in standing_before.iter().zip(&standing) {
                    parents[*own as usize] = *above;
                }
                let pairs = parents.iter().copied().zip(0u32..);
                hierarchy
                    .children
                    .push(Csr::from_pairs(level.positions.len(), pairs));
                hierarchy.parents.push(parents);
            } else {
                of_given.clone_from(&standing);
            }
            hierarchy.levels.push(level);
            standing_before = standing;
        }
        (hierarchy, of_given)
    }

    /// Drops the levels beyond so many.
    pub(super) fn truncate(&mut self, levels: usize) {
        self.levels.truncate(levels);
        self.parents.truncate(levels.saturating_sub(1));
        self.children.truncate(levels.saturating_sub(1));
    }

    /// A vertex of `level` that is below the vertex `up` levels above `v`, each child as likely as the others.
    #[must_use]
    pub fn relative(&self, level: usize, v: u32, up: usize, rng: &mut Rng) -> u32 {
        let mut at = v;
        for k in level..level + up {
            at = self.parents[k][at as usize];
        }
        for k in (level..level + up).rev() {
            let children = self.children[k].row(at as usize);
            at = children[rng.index(children.len())];
        }
        at
    }

    /// Values of a level and all coarser ones (each n by `count`) from those of that level (`values`): means, weighted by the
    /// number of vertices of the level that each stands for.
    #[must_use]
    pub fn filtered(&self, level: usize, values: Vec<f32>, count: usize) -> Vec<Vec<f32>> {
        let mut sizes = vec![1.0f32; self.levels[level].positions.len()];
        let mut all = vec![values];
        for children in &self.children[level..] {
            let finer = &all[all.len() - 1];
            let mut values = Vec::with_capacity(children.len() * count);
            let mut own_sizes = Vec::with_capacity(children.len());
            for row in children.rows() {
                let size: f32 = row.iter().map(|v| sizes[*v as usize]).sum();
                values.extend((0..count).map(|k| {
                    let parts = row
                        .iter()
                        .map(|v| sizes[*v as usize] * finer[*v as usize * count + k]);
                    parts.sum::<f32>() / size
                }));
                own_sizes.push(size);
            }
            all.push(values);
            sizes = own_sizes;
        }
        all
    }
}

/// Numbers of vertices of all levels: half as many each, from `finest` down to about `coarsest`.
pub(super) fn counts(finest: usize, coarsest: usize) -> Vec<usize> {
    let mut counts = vec![finest];
    let mut next = finest / 2;
    while next >= coarsest {
        counts.push(next);
        next /= 2;
    }
    counts
}

#[cfg(test)]
mod tests;
