//! Holes that lie off the scan's base surface, each completed on one of its own.

use nalgebra::{Point3, Unit, Vector3};

use crate::base::{self, BaseChoice, BaseSurface, FitParams, FitReport, Loss, Plane};
use crate::mesh::{triangle_area, vector_area};
use crate::relief;
use crate::sampling::fill;

use super::gaps::lies_on;
use super::patch::{NumberedGap, Patch};
use super::suited::PAPER_WINDOW;
use super::surroundings::Surroundings;
use super::{Clock, CompleteParams, Input, SkippedHole, Work};

/// A hole's own base serves if the fill has at most this many times the area of a disc with the rim's
/// length around it; a hemisphere has twice that.
const MOST_AREA_RATIO: f64 = 3.0;

/// Fits a base surface to the surroundings of a hole and completes the hole there.
///
/// First robustly to wide surroundings, as for a whole scan. Where these are of several surfaces (an
/// arch in a battlement), to what is next to the rim alone, whatever relief that leaves; at last the
/// plane of the rim, onto which every rim that does not fold over can be projected.
pub(super) fn complete_on_own_base(
    input: &Input,
    gap: &NumberedGap,
    params: &CompleteParams,
    work: &mut Work,
    clock: &mut Clock,
) {
    let around = Surroundings::new(input, gap, params.window.unwrap_or(PAPER_WINDOW));
    let serves =
        |patch: &Patch| lies_on(patch, &around.boundary) && is_filled_sparingly(&around, patch);
    let patch = (on_wide(&around, params).filter(serves))
        .or_else(|| on_narrow(&around, params).filter(serves))
        .or_else(|| on_rim_plane(&around).filter(serves));
    clock.end("own bases");
    let Some(patch) = patch else {
        work.skipped.push(SkippedHole {
            loops: gap.rim_ids.clone(),
            reason: "its rim lies neither on the scan's base surface nor, with its surroundings, on one of its own; cut the scan down to one surface".to_owned(),
        });
        return;
    };
    let before = work.added.len();
    patch.complete(
        &around.part.input,
        vec![around.gap.clone()],
        params,
        work,
        clock,
    );
    for added in &mut work.added[before..] {
        around.part.renumber(input, added);
    }
    // There is no other way here.
    for (gap, reason) in std::mem::take(&mut work.off_chart) {
        work.skipped.push(SkippedHole {
            loops: gap.rim_ids,
            reason,
        });
    }
}

fn on_wide(around: &Surroundings, params: &CompleteParams) -> Option<Patch> {
    let fit = fit_to(around, &around.wide, params, Loss::Tukey);
    let (fit, side) = fit.filter(|(fit, _)| fit.fits())?;
    let reach = relief::reach(&fit);
    Some(Patch::own(
        &around.part.input,
        &fit.base,
        side,
        reach,
        &around.wide,
    ))
}

fn on_narrow(around: &Surroundings, params: &CompleteParams) -> Option<Patch> {
    let (fit, side) = fit_to(around, &around.narrow, params, Loss::LeastSquares)?;
    let reach = fit.max_residual * (1.0 + 1e-9);
    Some(Patch::own(
        &around.part.input,
        &fit.base,
        side,
        reach,
        &around.wide,
    ))
}

/// The plane through the rim, seen from the side from which the hole runs counterclockwise.
fn on_rim_plane(around: &Surroundings) -> Option<Patch> {
    let positions = &around.part.input.mesh.positions;
    let rim: Vec<_> = (around.boundary.vertices.iter())
        .map(|v| positions[*v as usize])
        .collect();
    let normal = Unit::try_new(vector_area(&rim), 0.0)?;
    let sum: Vector3<f64> = rim.iter().map(|p| p.coords).sum();
    let point = Point3::from(sum / rim.len() as f64);
    let plane = BaseSurface::Plane(Plane { point, normal });
    let reach = (positions.iter().zip(&around.narrow))
        .filter(|(_, near)| **near)
        .map(|(p, _)| plane.foot(p).height.abs())
        .fold(0.0, f64::max);
    let reach = reach * (1.0 + 1e-9);
    Some(Patch::own(
        &around.part.input,
        &plane,
        1.0,
        reach,
        &around.wide,
    ))
}

/// The base surface of a region, of any kind, and the side of it that the region faces.
fn fit_to(
    around: &Surroundings,
    region: &[bool],
    params: &CompleteParams,
    loss: Loss,
) -> Option<(FitReport, f64)> {
    let mesh = &around.part.input.mesh;
    let triangles: Vec<[u32; 3]> = (mesh.triangles.iter())
        .filter(|t| t.iter().all(|v| region[*v as usize]))
        .copied()
        .collect();
    let params = FitParams {
        base: BaseChoice::Auto,
        loss,
        ..params.fit
    };
    let fit = base::fit_part(&mesh.positions, &triangles, &params).ok()?;
    let outward = |v: u32| fit.base.foot(&mesh.positions[v as usize]).normal;
    let side = relief::facing(&mesh.positions, &triangles, outward);
    Some((fit, side))
}

/// Whether the gap can be filled on the patch with about as much surface as its rim can span: a base
/// that continues the wrong way around would take the long way.
fn is_filled_sparingly(around: &Surroundings, patch: &Patch) -> bool {
    let length = around.boundary.length;
    let most = MOST_AREA_RATIO * length * length / (4.0 * std::f64::consts::PI);
    // Targets as far apart as that area allows: enough for the area, and soon done.
    let spacing = around.part.input.spacing.spacing.max(0.05 * most.sqrt());
    let Some(base) = patch.form.primitive() else {
        return false;
    };
    let filled = fill(
        base,
        &patch.relief,
        &around.part.input.adjacency,
        &around.gap.gap,
        spacing,
    );
    filled.is_ok_and(|filled| {
        let scanned = patch.relief.feet.len();
        let foot = |v: u32| match (v as usize).checked_sub(scanned) {
            None => patch.relief.feet[v as usize],
            Some(target) => filled.targets[target],
        };
        let areas = filled.triangles.iter().map(|t| triangle_area(t.map(foot)));
        areas.sum::<f64>() <= most
    })
}
