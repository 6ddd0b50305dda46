//! A second opinion: can a classifier tell neighborhoods of the piece from those of the known part?

use nalgebra::Point3;

use crate::mesh::spatial_order;

use super::field::{Field, Quantity, Split};
use super::readings::FEATURES;
use super::{Figure, Measure};

/// Neighborhoods that are looked at in each part; fewer only in parts with fewer vertices.
const SAMPLES: usize = 400;
/// Blocks of neighboring samples that are left out together: what stands next to each other looks alike
/// and would be recognised.
const BLOCKS: usize = 5;
/// Neighbors that have a say.
const NEIGHBORS: usize = 15;

/// |AUC − ½| of a classifier by nearest neighbors (in standardised features at 1, 2, 4, 8 median edges)
/// that has to tell piece and known part apart, each sample by those of the other blocks alone.
///
/// # Reference
/// D. Lopez-Paz, M. Oquab: *Revisiting classifier two-sample tests.* ICLR, 2017.
pub(super) fn figure(field: &Field, quantities: &[Quantity], split: &Split) -> Figure {
    let piece = samples(field, quantities, &split.inner);
    let reference: Vec<u32> = split.reference().collect();
    let reference = samples(field, quantities, &reference);
    let value = (piece.len().min(reference.len()) >= 2 * BLOCKS * NEIGHBORS)
        .then(|| (area_under_curve(&scores(&piece, &reference)) - 0.5).abs());
    Figure {
        measure: Measure::Classifier,
        name: quantities[0].named("classifier"),
        value,
    }
}

/// A neighborhood: its features one after another.
type Sample = Vec<f32>;

/// Evenly chosen neighborhoods of a part, an equal area to each, in an order along which what is close on
/// the list is close in space.
fn samples(field: &Field, quantities: &[Quantity], part: &[u32]) -> Vec<Sample> {
    let counts = |v: &u32| {
        field.areas[*v as usize] > 0.0
            && (quantities.iter()).all(|q| {
                let features = &q.readings[*v as usize].features;
                features.iter().all(|x| x.is_finite())
            })
    };
    let part: Vec<u32> = part.iter().copied().filter(counts).collect();
    let positions: &[Point3<f64>] = &field.feet.positions;
    let order = spatial_order(positions, part);
    let total: f64 = order.iter().map(|v| field.areas[*v as usize]).sum();
    let share = total / SAMPLES.min(order.len()).max(1) as f64;
    let (mut chosen, mut covered, mut next) = (Vec::new(), 0.0, 0.5 * share);
    for v in order {
        covered += field.areas[v as usize];
        if covered >= next {
            next += share;
            chosen.push(
                (quantities.iter())
                    .flat_map(|q| q.readings[v as usize].features)
                    .collect(),
            );
        }
    }
    chosen
}

/// For every sample how much it looks like one of the piece, and whether it is.
fn scores(piece: &[Sample], reference: &[Sample]) -> Vec<(f64, bool)> {
    let scales = inverse_deviations(reference);
    let labelled = |samples: &[Sample], is_piece: bool| -> Vec<(Sample, usize, bool)> {
        (samples.iter().enumerate())
            .map(|(i, sample)| {
                let scaled = sample.iter().zip(&scales).map(|(x, s)| x * s).collect();
                (scaled, i * BLOCKS / samples.len(), is_piece)
            })
            .collect()
    };
    let all = [labelled(piece, true), labelled(reference, false)].concat();
    (all.iter())
        .map(|(sample, block, is_piece)| {
            let mut others: Vec<(f32, bool)> = (all.iter())
                .filter(|(_, other, _)| other != block)
                .map(|(other, _, label)| (distance_sq(sample, other), *label))
                .collect();
            // Of equally near ones those of the known part first: an order, if an arbitrary one.
            let by_distance =
                |a: &(f32, bool), b: &(f32, bool)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
            others.select_nth_unstable_by(NEIGHBORS, by_distance);
            let of_piece = others[..NEIGHBORS].iter().filter(|(_, label)| *label);
            (of_piece.count() as f64 / NEIGHBORS as f64, *is_piece)
        })
        .collect()
}

fn distance_sq(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// One over the standard deviation of each feature; 0 for one that is constant.
#[expect(clippy::cast_possible_truncation, reason = "features are single")]
fn inverse_deviations(samples: &[Sample]) -> Vec<f32> {
    let features = samples.first().map_or(FEATURES, Vec::len);
    let n = samples.len().max(1) as f64;
    (0..features)
        .map(|i| {
            let mean = samples.iter().map(|s| f64::from(s[i])).sum::<f64>() / n;
            let square = (samples.iter()).map(|s| (f64::from(s[i]) - mean).powi(2));
            let deviation = (square.sum::<f64>() / n).sqrt();
            if deviation > 0.0 {
                (1.0 / deviation) as f32
            } else {
                0.0
            }
        })
        .collect()
}

/// Area under the ROC curve: the share of pairs of a positive and a negative in which the positive scores
/// higher, ties counted half.
fn area_under_curve(scores: &[(f64, bool)]) -> f64 {
    let mut sorted = scores.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut below, mut wins, mut positives) = (0.0, 0.0, 0.0);
    for tied in sorted.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
        let up = tied.iter().filter(|(_, positive)| *positive).count() as f64;
        let down = tied.len() as f64 - up;
        wins += up * (below + 0.5 * down);
        below += down;
        positives += up;
    }
    if positives * below > 0.0 {
        wins / (positives * below)
    } else {
        0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Rng, Stage};
    use approx::assert_relative_eq;

    #[test]
    fn the_area_is_that_of_all_pairs() {
        let scores = [
            (0.1, false),
            (0.4, true),
            (0.4, false),
            (0.8, true),
            (0.9, false),
        ];
        // Pairs: 0.4 beats 0.1, ties 0.4, loses; 0.8 beats two, loses one.
        assert_relative_eq!(area_under_curve(&scores), 3.5 / 6.0, epsilon = 1e-12);
        assert_relative_eq!(area_under_curve(&[(1.0, true), (0.0, false)]), 1.0);
    }

    #[test]
    fn what_is_drawn_alike_cannot_be_told_apart_and_a_ring_around_a_blob_can() {
        #[expect(clippy::cast_possible_truncation, reason = "features are single")]
        let draw = |seed, radius: f64| -> Vec<Sample> {
            let mut rng = Rng::new(seed, Stage::Likeness, 1);
            (0..SAMPLES)
                .map(|_| {
                    let angle = std::f64::consts::TAU * rng.uniform();
                    let r = radius + 0.1 * rng.normal();
                    vec![(r * angle.cos()) as f32, (r * angle.sin()) as f32]
                })
                .collect()
        };
        let auc = |a: &[Sample], b: &[Sample]| area_under_curve(&scores(a, b));
        // Standard error of the area for 400 against 400: 0.02.
        assert!((auc(&draw(1, 1.0), &draw(2, 1.0)) - 0.5).abs() < 0.06);
        // Equal means: no linear classifier can.
        assert!(auc(&draw(1, 0.3), &draw(2, 1.0)) > 0.95);
    }
}
