//! A mesh prepared on all levels.

use rayon::prelude::*;

use super::descriptors::{Factors, gradients};
use super::ground::{Ground, single};
use super::hierarchy::Hierarchy;
use super::shape::Features;

/// A mesh on all levels, with what is known of its vertices.
#[derive(Debug)]
pub(super) struct Stack {
    pub(super) hierarchy: Hierarchy,
    pub(super) grounds: Vec<Ground>,
    /// Number K of features.
    pub(super) features: usize,
    /// By level: n by K.
    pub(super) shape: Vec<Vec<f32>>,
    /// By level: n by K, how they grow.
    pub(super) gradients: Vec<Vec<[f32; 2]>>,
}

impl Stack {
    /// Of a hierarchy and features of one of its levels.
    pub(super) fn new(hierarchy: Hierarchy, level: usize, of_level: Features) -> Self {
        let features = of_level.count;
        let grounds: Vec<Ground> = hierarchy.levels.iter().cloned().map(Ground::new).collect();
        let mut finer = Vec::new();
        for (ground, parents) in grounds.iter().zip(&hierarchy.parents).take(level).rev() {
            let coarse = finer.last().unwrap_or(&of_level.values);
            finer.push(spread(ground, parents, coarse, features));
        }
        finer.reverse();
        let mut shape = finer;
        shape.extend(hierarchy.filtered(level, of_level.values, features));
        let gradients = (grounds.iter().zip(&shape))
            .map(|(ground, shape)| gradients(ground, shape, features))
            .collect();
        Self {
            hierarchy,
            grounds,
            features,
            shape,
            gradients,
        }
    }

    pub(super) fn levels(&self) -> usize {
        self.grounds.len()
    }
}

/// Values (n by `count`) of a level from those of the next coarser one: each vertex has its parent's, and then the mean over
/// its fan, so that they change as smoothly as the finer level can tell.
fn spread(ground: &Ground, parents: &[u32], coarse: &[f32], count: usize) -> Vec<f32> {
    let own: Vec<f32> = (parents.iter())
        .flat_map(|parent| &coarse[*parent as usize * count..][..count])
        .copied()
        .collect();
    let mut smooth = vec![0.0; own.len()];
    if count == 0 {
        return smooth;
    }
    let unknown = vec![0.0; count];
    let offsets = ground.fans.offsets();
    (smooth.par_chunks_mut(count).enumerate()).for_each_init(
        || vec![0.0f32; offsets * count],
        |fan, (v, out)| {
            ground.fans.read(v, &own, &unknown, fan);
            for values in fan.chunks_exact(count) {
                for (out, value) in out.iter_mut().zip(values) {
                    *out += value / offsets as f32;
                }
            }
        },
    );
    smooth
}

/// How much of the variance of values (n by `count`) is within the fans of a level: the mean over fans of the variance on
/// each.
pub(super) fn variance_in_fans(ground: &Ground, values: &[f32], count: usize) -> f64 {
    let unknown = vec![0.0; count];
    let offsets = ground.fans.offsets();
    let sums: Vec<f64> = (0..ground.len())
        .into_par_iter()
        .map_init(
            || vec![0.0f32; offsets * count],
            |fan, v| {
                ground.fans.read(v, values, &unknown, fan);
                (0..count)
                    .map(|k| variance(fan.iter().skip(k).step_by(count)))
                    .sum()
            },
        )
        .collect();
    sums.iter().sum::<f64>() / sums.len().max(1) as f64
}

pub(super) fn variance<'a>(values: impl Iterator<Item = &'a f32> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().map(|x| f64::from(*x)).sum::<f64>() / count;
    values.map(|x| (f64::from(*x) - mean).powi(2)).sum::<f64>() / count
}

/// Factors of values (`groups`: numbers of channels that belong together, `variances`: by channel, of its group) by which values that have nothing to do with each other differ by `value_weight`, and shapes by what is left to
/// 1.
pub(super) fn factors(
    stack: &Stack,
    level: usize,
    groups: &[usize],
    variances: &[f64],
    value_weight: f32,
) -> Factors {
    let parts = groups.len() as f32;
    let of_values = variances
        .iter()
        .map(|sum| factor(value_weight / parts, *sum));
    let k = stack.features;
    let share = (1.0 - value_weight) / k.max(1) as f32;
    let of_feature = |f: usize| variance(stack.shape[level].iter().skip(f).step_by(k));
    let of_gradient = |f: usize| {
        let gradients = stack.gradients[level].iter().skip(f).step_by(k);
        let count = gradients.clone().count().max(1) as f64;
        gradients
            .map(|[x, y]| f64::from(x * x + y * y))
            .sum::<f64>()
            / count
    };
    Factors {
        values: of_values.collect(),
        features: (0..k).map(|f| factor(0.5 * share, of_feature(f))).collect(),
        gradients: (0..k)
            .map(|f| factor(0.5 * share, of_gradient(f)))
            .collect(),
    }
}

/// The factor that makes the mean squared difference of independent values of that variance `weight`: without it, that is twice
/// the variance.
fn factor(weight: f32, variance: f64) -> f32 {
    /// Less is no variation.
    const LEAST: f64 = 1e-12;
    if variance < LEAST {
        return 0.0;
    }
    single((f64::from(weight) / (2.0 * variance)).sqrt())
}
