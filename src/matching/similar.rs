//! For each site the candidates that look most like it, found beforehand.
//!
//! # Reference
//! [Tong et al. 2002](crate::bibliography#tong-et-al-2002), §4: k-coherence.

use nalgebra::Point3;
use rayon::prelude::*;

use super::table::Table;
use super::tree::{Tree, TreeParams};

/// Bytes that the search takes for each candidate while it runs, at most: its row here and in the tree, its
/// components while the tree is built and in it, its number, and its share of the double-precision rows
/// that the components are found from.
pub(super) fn bytes_a_candidate(offsets: usize, channels: usize) -> usize {
    let width = offsets * channels;
    4 * (2 * width + 2 * TreeParams::default().components + 4) + 8 * width
}

/// The most similar candidates of all sites.
#[derive(Debug, Default)]
pub(super) struct Similar {
    /// S lists, the most similar first.
    pub(super) candidates: Vec<Vec<u32>>,
    /// Median cost of the most similar one: what a good match costs on this surface.
    pub(super) typical_cost: f32,
}

/// For each site (S; `points` are where they are, and candidate s·R + r is site s at the r-th of R
/// rotations) the `k` candidates whose whole neighborhoods differ least from its own, of those farther
/// away than `apart`. None for sites of whose neighborhood something is not known.
pub(super) fn most_similar(table: &Table, points: &[Point3<f64>], k: usize, apart: f64) -> Similar {
    let Some(rotations) = table.len().checked_div(points.len()) else {
        return Similar::default();
    };
    let roots: Vec<f32> = table.weights().iter().map(|w| w.sqrt()).collect();
    let width = table.offsets() * table.channels();
    let candidates = u32::try_from(table.len()).expect("candidates are u32");
    let full: Vec<u32> = (0..candidates)
        .into_par_iter()
        .filter(|candidate| table.descriptor(*candidate).known.count() == table.offsets())
        .collect();
    let mut rows = vec![0.0; full.len() * width];
    (rows.par_chunks_mut(width).zip(&full)).for_each(|(row, candidate)| {
        let values = table.descriptor(*candidate).values;
        for (i, (value, from)) in row.iter_mut().zip(values).enumerate() {
            *value = from * roots[i / table.channels()];
        }
    });
    let tree = Tree::new(&rows, width, &TreeParams::default());
    let point = |candidate: u32| points[candidate as usize / rotations];
    let nearest: Vec<Vec<(u32, f32)>> = (0..candidates)
        .into_par_iter()
        .step_by(rotations)
        .map(|own| {
            let is_apart = |i: u32| (point(full[i as usize]) - point(own)).norm() > apart;
            match full.binary_search(&own) {
                Ok(i) => tree.nearest(&rows[i * width..][..width], k, is_apart),
                Err(_) => Vec::new(),
            }
        })
        .collect();
    let mut costs: Vec<f32> = nearest
        .iter()
        .filter_map(|list| Some(list.first()?.1))
        .collect();
    costs.sort_by(f32::total_cmp);
    let total: f32 = table.weights().iter().sum();
    let lists = (nearest.into_iter())
        .map(|list| list.into_iter().map(|(i, _)| full[i as usize]).collect())
        .collect();
    Similar {
        candidates: lists,
        typical_cost: costs.get(costs.len() / 2).map_or(0.0, |cost| cost / total),
    }
}
