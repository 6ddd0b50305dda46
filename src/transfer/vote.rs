//! Votes: values of the target from all patches that reach over each vertex.
//!
//! # Reference
//! [MeshMatch 2012](crate::bibliography#meshmatch-2012), §5; Wexler, Shechtman & Irani 2007 for the images'.

use rayon::prelude::*;

use super::field::{Match, Pairing};
use super::ground::{Patch, numbers};

/// Patches reach this many spacings.
const RADIUS: f32 = 2.0;

/// Standard deviation of their weights, in spacings.
const SIGMA: f32 = 1.0;

/// The weight of a patch falls by e for each of this many mean costs that its match costs: where patches do not agree,
/// what fits well must not be mixed with what fits badly.
const SHARPNESS: f32 = 0.3;

/// No patch is without any weight.
const LEAST_WEIGHT: f32 = 1e-6;

/// Values of all vertices of the target (n by `count`): means over the patches of the vertices around, each as the patch's
/// match has it at that place of the source (`values`: by vertex of the source). Pinned vertices keep what is in `known`.
pub(super) fn voted(
    pairing: &Pairing,
    field: &[Match],
    values: &[f32],
    count: usize,
    known: &[f32],
) -> Vec<f32> {
    let fit = fitness(field);
    let radius = RADIUS * pairing.target.spacing;
    let scale = 1.0 / (SIGMA * pairing.target.spacing);
    let mut out = vec![0.0; field.len() * count];
    let rows = out.par_chunks_mut(count).zip(numbers(field.len()));
    rows.for_each_init(Patch::default, |patch, (out, v)| {
        if pairing.is_pinned(v) {
            out.copy_from_slice(&known[v as usize * count..][..count]);
            return;
        }
        pairing.target.patch(v, radius, patch);
        let mut total = 0.0;
        for member in &patch.members {
            let theirs = field[member.vertex as usize];
            let (angle, length) = member.way_back();
            // The vertex itself is on the surface, even where its direction leads off it.
            let angle = match length > 0.0 {
                true => angle + theirs.angle(),
                false => 0.0,
            };
            let Some(place) = (pairing.source).walk(theirs.source, angle, length * pairing.ratio)
            else {
                continue;
            };
            let distance = length * scale;
            let weight = (-0.5 * distance * distance).exp() * fit(&theirs);
            total += weight;
            let corners = pairing.source.surface.corners(place.triangle);
            let shares = pairing.source.surface.barycentric(&place);
            for (corner, share) in corners.iter().zip(shares) {
                let values = &values[*corner as usize * count..][..count];
                for (out, value) in out.iter_mut().zip(values) {
                    *out += weight * share * value;
                }
            }
        }
        // The vertex's own patch is always there.
        out.iter_mut().for_each(|out| *out /= total);
    });
    out
}

/// The weight of a match by its cost; of all the same where no costs are known yet.
fn fitness(field: &[Match]) -> impl Fn(&Match) -> f32 + Sync {
    let sum: f64 = field.iter().map(|m| f64::from(m.cost)).sum();
    let mean = sum / field.len() as f64;
    #[expect(clippy::cast_possible_truncation, reason = "weights are single")]
    let scale = if mean.is_finite() && mean > 0.0 {
        (1.0 / (f64::from(SHARPNESS) * mean)) as f32
    } else {
        0.0
    };
    move |found| match scale {
        0.0 => 1.0,
        scale => (-found.cost * scale).exp() + LEAST_WEIGHT,
    }
}

#[cfg(test)]
mod tests;
