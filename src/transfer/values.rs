//! What is transferred: colors and heights of the source, on all levels.

use super::ground::single;
use super::ready::Ready;
use super::shape::Features;
use super::stack::{Stack, variance, variance_in_fans};
use super::{Source, TransferError};

/// Colors and heights of the source's vertices.
#[derive(Debug)]
pub(super) struct Values {
    /// Numbers of channels that belong together: 3 of color, 1 of height.
    pub(super) groups: Vec<usize>,
    pub(super) has_colors: bool,
    pub(super) has_heights: bool,
    /// By level: n by the number of all channels.
    pub(super) levels: Vec<Vec<f32>>,
    /// By level: from 0 on the coarsest level, to 1 on the finest, how much of the detail can be seen.
    pub(super) seen: Vec<f64>,
}

/// Whether there is one value a vertex: all else is the caller's mistake.
pub(super) fn assert_complete(source: &Source) {
    let vertices = source.mesh.positions.len();
    let fits = |count: Option<usize>| count.is_none_or(|count| count == vertices);
    assert!(fits(source.colors.map(<[_]>::len)), "one color a vertex");
    assert!(fits(source.heights.map(<[_]>::len)), "one height a vertex");
}

pub(super) fn check(source: &Source) -> Result<(), TransferError> {
    if source.colors.is_none() && source.heights.is_none() {
        return Err(TransferError::NoValues);
    }
    let colors = source.colors.unwrap_or_default().iter().flatten();
    let heights = source.heights.unwrap_or_default();
    if !colors.chain(heights).all(|x| x.is_finite()) {
        return Err(TransferError::NotFinite);
    }
    Ok(())
}

impl Values {
    pub(super) fn new(source: &Source, ready: &Ready, standing: &[u32], stack: &Stack) -> Self {
        let colors = source.colors.map(|colors| ready.on_surface(colors));
        let heights = source.heights.map(|heights| {
            let rows: Vec<[f64; 1]> = heights.iter().map(|h| [*h]).collect();
            ready.on_surface(&rows)
        });
        let count = 3 * usize::from(colors.is_some()) + usize::from(heights.is_some());
        let mut flat = Vec::with_capacity(ready.vertices.len() * count);
        for v in 0..ready.vertices.len() {
            flat.extend(colors.iter().flat_map(|c| c[v]).map(single));
            flat.extend(heights.iter().flat_map(|h| h[v]).map(single));
        }
        let all = Features {
            count,
            values: flat,
        };
        let finest = merged(&all, standing, stack.grounds[0].len()).values;
        let levels = stack.hierarchy.filtered(0, finest, count);
        let mut groups = Vec::new();
        groups.extend(colors.is_some().then_some(3));
        groups.extend(heights.is_some().then_some(1));
        let details: Vec<f64> = (stack.grounds.iter().zip(&levels))
            .map(|(ground, values)| variance_in_fans(ground, values, count))
            .collect();
        let total = details.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        Self {
            groups,
            has_colors: colors.is_some(),
            has_heights: heights.is_some(),
            seen: (0..levels.len())
                .map(|level| details[level..].iter().sum::<f64>() / total)
                .collect(),
            levels,
        }
    }

    /// Number of all channels.
    pub(super) fn count(&self) -> usize {
        self.groups.iter().sum()
    }

    /// By channel of a level: the variance of its group's values.
    pub(super) fn variances(&self, level: usize) -> Vec<f64> {
        let count = self.count();
        let mut variances = Vec::with_capacity(count);
        for channels in &self.groups {
            let first = variances.len();
            let sum: f64 = (first..first + channels)
                .map(|k| variance(self.levels[level].iter().skip(k).step_by(count)))
                .sum();
            variances.extend(vec![sum; *channels]);
        }
        variances
    }
}

/// Means of what stands for the same vertex.
pub(super) fn merged(given: &Features, standing: &[u32], vertices: usize) -> Features {
    let count = given.count;
    let mut values = vec![0.0; vertices * count];
    if count == 0 {
        return Features { count, values };
    }
    let mut sizes = vec![0.0f32; vertices];
    for (own, given) in standing.iter().zip(given.values.chunks_exact(count)) {
        sizes[*own as usize] += 1.0;
        for (sum, value) in values[*own as usize * count..].iter_mut().zip(given) {
            *sum += value;
        }
    }
    for (sum, size) in values.chunks_exact_mut(count).zip(sizes) {
        sum.iter_mut().for_each(|s| *s /= size);
    }
    Features { count, values }
}
