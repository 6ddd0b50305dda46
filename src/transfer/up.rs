//! A field on the next finer level.

use nalgebra::Point3;
use rayon::prelude::*;

use super::descriptors::turn_of;
use super::field::{Match, Pairing};
use super::ground::{largest, numbers};
use super::hierarchy::Hierarchy;

/// The field of a coarser level on the next finer one: each vertex lies to its parent's match as to its parent.
pub(super) fn refined(
    coarse: &Pairing,
    fine: &Pairing,
    of_target: &Hierarchy,
    target_level: usize,
    field: &[Match],
) -> Vec<Match> {
    let parents = &of_target.parents[target_level];
    let children = &coarse.hierarchy.children[fine.level];
    (parents.par_iter().zip(numbers(parents.len())))
        .map(|(parent, v)| {
            let above = field[*parent as usize];
            let offset = fine.target.position(v) - coarse.target.position(*parent);
            let (angle, length) = coarse.target.polar(*parent, &offset);
            let place =
                (coarse.source).walk(above.source, angle + above.angle(), length * coarse.ratio);
            let (near, point) = match place {
                Some(place) => {
                    let shares = coarse.source.surface.barycentric(&place);
                    let corner = largest(shares);
                    (
                        coarse.source.surface.corners(place.triangle)[corner],
                        coarse.source.surface.position(&place),
                    )
                }
                None => (above.source, *coarse.source.position(above.source)),
            };
            let mut source = None;
            for child in children.row(near as usize) {
                let distance = (fine.source.position(*child) - point).norm_squared();
                if fine.is_allowed(*child) && source.is_none_or(|(d, _)| distance < d) {
                    source = Some((distance, *child));
                }
            }
            let children = children.row(above.source as usize);
            let allowed = || children.iter().find(|child| fine.is_allowed(**child));
            let source = (source.map(|(_, s)| s))
                .or_else(|| allowed().copied())
                .or_else(|| nearest_allowed(fine, &point))
                .unwrap_or(children[0]);
            // The same direction in space has other angles here and there.
            let on_target = fine
                .target
                .polar(v, &coarse.target.direction(*parent, 0.0))
                .0;
            let ahead = coarse.source.direction(above.source, above.angle());
            let on_source = fine.source.polar(source, &ahead).0;
            Match::new(source, turn_of(on_source - on_target), f32::INFINITY)
        })
        .collect()
}

/// The vertex of the source nearest to a point of those that may be copied.
fn nearest_allowed(pairing: &Pairing, point: &Point3<f64>) -> Option<u32> {
    let distance = |s: &u32| (pairing.source.position(*s) - point).norm_squared();
    (numbers(pairing.source.len()).filter(|s| pairing.is_allowed(*s)))
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

#[cfg(test)]
mod tests;
