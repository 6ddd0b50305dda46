//! The target with what was on the source.

use crate::mesh::Bisected;
use crate::progress::StageTime;

use super::levels::Done;
use super::ready::Ready;
use super::report::TransferReport;
use super::stack::Stack;
use super::values::Values;
use super::{Last, TransferParams};

/// A mesh with what was on another one.
#[derive(Debug, Clone)]
pub struct Transferred {
    /// The target: its own vertices first, bit by bit where they were, then those that were put on its edges.
    pub finer: Bisected,
    /// #V intensities from 0 to 1, if the source has colors.
    pub colors: Option<Vec<[f64; 3]>>,
    /// #V heights over the mesh, in its unit, if the source has heights; scaled as lengths are from source to target.
    pub heights: Option<Vec<f64>>,
    /// #V: the vertex of the source that each was matched with.
    pub sources: Vec<u32>,
    /// #V: angles, in radians from -π to π, counterclockwise, by which what is upright on the target is turned on the
    /// source.
    pub rotations: Vec<f32>,
    /// #V: how far what is around a vertex is from what is around its source; 1 is how far things are that have nothing to
    /// do with each other.
    pub costs: Vec<f32>,
    /// What was done.
    pub report: TransferReport,
}

pub(super) fn result(
    [source, target]: [&Ready; 2],
    standing: &[u32],
    [sources, targets]: [&Stack; 2],
    values: &Values,
    done: Done,
    params: &TransferParams,
    stages: Vec<StageTime>,
) -> Transferred {
    let Done {
        field,
        voted,
        levels,
    } = done;
    let count = values.count();
    let last: Vec<f32> = match params.last {
        Last::Vote => voted,
        Last::Nearest => (field.iter())
            .flat_map(|m| &values.levels[0][m.source as usize * count..][..count])
            .copied()
            .collect(),
    };
    let (from, onto) = (&sources.grounds[0], &targets.grounds[0]);
    let upright = |of: usize, v: u32, ground: &super::ground::Ground| {
        let up = params.up[of].unwrap_or_else(nalgebra::Vector3::y);
        ground.upright(v, &up)
    };
    let rotations: Vec<f32> = (0u32..)
        .zip(&field)
        .map(|(v, m)| {
            let turned = upright(1, v, onto) + m.angle() - upright(0, m.source, from);
            let turned = turned.rem_euclid(std::f32::consts::TAU);
            if turned > std::f32::consts::PI {
                turned - std::f32::consts::TAU
            } else {
                turned
            }
        })
        .collect();
    // The first of what a vertex of the finest level stands for is as good as any.
    let mut first = vec![u32::MAX; from.len()];
    for (v, own) in (0u32..).zip(standing) {
        let first = &mut first[*own as usize];
        *first = v.min(*first);
    }
    let of_given: Vec<u32> = first.iter().map(|v| source.given_vertex(*v)).collect();
    let nearest = target.nearest();
    let at = |v: &u32| *v as usize;
    let ratio = f64::from(onto.spacing / from.spacing);
    Transferred {
        colors: values.has_colors.then(|| {
            let color = |v| std::array::from_fn(|k| f64::from(last[at(v) * count + k]));
            nearest.iter().map(color).collect()
        }),
        heights: values.has_heights.then(|| {
            let height = |v| f64::from(last[(at(v) + 1) * count - 1]) * ratio;
            nearest.iter().map(height).collect()
        }),
        sources: nearest
            .iter()
            .map(|v| of_given[field[at(v)].source as usize])
            .collect(),
        rotations: nearest.iter().map(|v| rotations[at(v)]).collect(),
        costs: nearest.iter().map(|v| field[at(v)].cost).collect(),
        finer: target.fine.clone(),
        report: TransferReport { levels, stages },
    }
}
