//! Texture by example: which vertices may be copied, and which stay.

use super::ready::Ready;
use super::shape::Features;
use super::stack::Stack;
use super::values::{Values, merged};

/// A vertex of a coarser level is painted if this share of what it stands for is.
const PAINTED: f32 = 0.999;

/// Where no fan is painted altogether, this share is enough.
const MOSTLY: f32 = 0.5;

/// What is painted, on all levels.
#[derive(Debug)]
pub(super) struct Masks {
    /// By level and vertex of the source.
    pub(super) allowed: Vec<Vec<bool>>,
    /// By level and vertex of the target.
    pub(super) pinned: Vec<Vec<bool>>,
    /// By level: values of what is painted of the target's vertices; means of what is painted where nothing is.
    pub(super) known: Vec<Vec<f32>>,
}

impl Masks {
    pub(super) fn new(
        painted: &[bool],
        ready: &Ready,
        standing: &[u32],
        [sources, targets]: [&Stack; 2],
        values: &Values,
    ) -> Self {
        // A vertex on an edge is painted if both ends are.
        let rows: Vec<[f64; 1]> = painted.iter().map(|p| [f64::from(u8::from(*p))]).collect();
        let of_surface: Vec<f32> = (ready.on_surface(&rows).iter())
            .map(|[share]| if *share >= 1.0 { 1.0 } else { 0.0 })
            .collect();
        let of_surface = Features {
            count: 1,
            values: of_surface,
        };
        let finest = merged(&of_surface, standing, sources.grounds[0].len()).values;
        let shares = sources.hierarchy.filtered(0, finest, 1);
        let allowed = (sources.grounds.iter().zip(&shares))
            .map(|(ground, shares)| {
                let is_painted = |v: u32| shares[v as usize] >= PAINTED;
                let whole: Vec<bool> = (0..shares.len())
                    .map(|v| ground.fans.vertices(v).all(is_painted))
                    .collect();
                if whole.contains(&true) {
                    return whole;
                }
                let most = shares.iter().copied().fold(0.0, f32::max).min(MOSTLY);
                shares.iter().map(|share| *share >= most).collect()
            })
            .collect();
        let pinned: Vec<Vec<bool>> = (targets.grounds.iter().zip(&shares))
            .map(|(_, shares)| shares.iter().map(|share| *share >= PAINTED).collect())
            .collect();
        Self {
            allowed,
            pinned,
            known: known(&shares, sources, values),
        }
    }
}

/// Means over what is painted.
fn known(shares: &[Vec<f32>], stack: &Stack, values: &Values) -> Vec<Vec<f32>> {
    let count = values.count();
    let painted: Vec<f32> = (values.levels[0].chunks_exact(count).zip(&shares[0]))
        .flat_map(|(row, share)| row.iter().map(move |x| x * share))
        .collect();
    let total: f32 = shares[0].iter().sum();
    let means: Vec<f32> = (0..count)
        .map(|k| painted.iter().skip(k).step_by(count).sum::<f32>() / total)
        .collect();
    let mut levels = stack.hierarchy.filtered(0, painted, count);
    for (level, shares) in levels.iter_mut().zip(shares) {
        for (row, share) in level.chunks_exact_mut(count).zip(shares) {
            for (value, mean) in row.iter_mut().zip(&means) {
                *value = if *share > 0.0 { *value / share } else { *mean };
            }
        }
    }
    levels
}
