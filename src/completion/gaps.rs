//! Which boundary loops to fill, grouped into gaps, and on which base surface.

use nalgebra::{Point3, Unit, Vector3};

use crate::base::{self, BaseChoice, BaseSurface, FitParams, FitReport, Loss, Plane};
use crate::mesh::{BoundaryLoop, LoopKind, TriMesh, triangle_area, vector_area};
use crate::relief;
use crate::sampling::{Gap, fill, is_bounded};

use super::patch::{NumberedGap, Patch};
use super::{Clock, CompleteParams, CompletionError, HoleChoice, Input, SkippedHole, Work};

/// A loop lies on a base surface if this share of its vertices does: a few may stand on spikes.
const ON_BASE_SHARE: f64 = 0.9;

/// A hole's own base is fitted to at least this many vertices around it, and …
const SURROUNDING_VERTICES: usize = 400;
/// … to this many times as many as it is predicted to need itself.
const SURROUNDING_RATIO: f64 = 4.0;
/// A hole's own base serves if the fill has at most this many times the area of a disc with the rim's
/// length around it; a hemisphere has twice that.
const MOST_AREA_RATIO: f64 = 3.0;
/// The narrow surroundings of a hole have this many times as many vertices as its rim: about three
/// rings.
const NARROW_RATIO: usize = 3;

/// Numbers of the loops to fill, of those asked for one by one; extension is not among them.
pub(super) fn choose(
    loops: &[BoundaryLoop],
    params: &CompleteParams,
) -> Result<Vec<usize>, CompletionError> {
    let Some(last) = loops.len().checked_sub(1) else {
        return Err(CompletionError::Closed);
    };
    let holes = || loops.iter().filter(|l| l.kind == LoopKind::Hole);
    Ok(match &params.holes {
        HoleChoice::Interior => holes().map(|l| l.id).collect(),
        HoleChoice::All => (0..loops.len()).collect(),
        HoleChoice::Largest => match holes().max_by(|a, b| a.area.total_cmp(&b.area)) {
            Some(largest) => vec![largest.id],
            None if params.extend => Vec::new(),
            None => return Err(CompletionError::NoInteriorHole { rims: loops.len() }),
        },
        HoleChoice::Ids(ids) => {
            if let Some(id) = ids.iter().find(|id| **id > last) {
                return Err(CompletionError::NoSuchLoop { id: *id, last });
            }
            let mut ids = ids.clone();
            ids.sort_unstable();
            ids.dedup();
            ids
        }
    })
}

/// The gaps by where they lie.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) on_base: Vec<NumberedGap>,
    /// Holes to be filled on a base surface of their own.
    pub(super) off_base: Vec<NumberedGap>,
    pub(super) skipped: Vec<SkippedHole>,
}

impl Plan {
    pub(super) fn is_empty(&self) -> bool {
        self.on_base.is_empty() && self.off_base.is_empty() && self.skipped.is_empty()
    }
}

/// Number of outer rims that are neither filled nor skipped.
pub(super) fn rims_left(input: &Input, work: &Work) -> usize {
    let taken = |id: usize| {
        let filled = work.added.iter().flat_map(|gap| &gap.report.loops);
        let skipped = work.skipped.iter().flat_map(|hole| &hole.loops);
        filled.chain(skipped).any(|taken| *taken == id)
    };
    let rims = input.loops.iter().filter(|l| l.kind == LoopKind::Rim);
    rims.filter(|l| !taken(l.id)).count()
}

/// Groups the chosen loops into gaps, and adds those of the extension.
pub(super) fn plan(
    input: &Input,
    whole: Option<&Patch>,
    chosen: &[usize],
    params: &CompleteParams,
) -> Plan {
    let mut plan = Plan {
        on_base: Vec::new(),
        off_base: Vec::new(),
        skipped: Vec::new(),
    };
    let mut wanted: Vec<usize> = chosen.to_vec();
    // An extension covers ring gaps, and all rims as far as the surface goes.
    if whole.is_some_and(|whole| params.extend && !is_sphere(whole)) {
        wanted.retain(|id| input.loops[*id].kind == LoopKind::Hole);
    } else if let (HoleChoice::Interior, Some(whole)) = (&params.holes, whole) {
        wanted.extend(ring_gaps(input, whole));
    }
    for id in wanted {
        let boundary = &input.loops[id];
        if let Some([a, b]) = boundary.defect {
            plan.skipped.push(broken(id, [a, b]));
        } else if whole.is_some_and(|whole| lies_on(whole, boundary)) {
            plan.on_base.push(single_gap(input, id));
        } else {
            plan.off_base.push(single_gap(input, id));
        }
    }
    if let (true, Some(whole)) = (params.extend, whole) {
        extend(input, whole, &mut plan);
    }
    plan
}

fn is_sphere(patch: &Patch) -> bool {
    matches!(patch.base, BaseSurface::Sphere(_))
}

fn broken(id: usize, [a, b]: [u32; 2]) -> SkippedHole {
    SkippedHole {
        loops: vec![id],
        reason: format!(
            "more than two triangles meet, or two are oriented against each other, at its edge between vertices {a} and {b}; repair the scan there"
        ),
    }
}

/// Whether a loop lies on the patch's base surface.
fn lies_on(patch: &Patch, boundary: &BoundaryLoop) -> bool {
    patch.share_on_base(&boundary.vertices) >= ON_BASE_SHARE
}

/// One loop, and the rims of other pieces of surface that may lie inside it.
fn single_gap(input: &Input, id: usize) -> NumberedGap {
    let boundary = &input.loops[id];
    let islands: Vec<&BoundaryLoop> = (input.loops.iter())
        .filter(|l| l.component != boundary.component && l.kind == LoopKind::Rim)
        .filter(|l| l.defect.is_none())
        .collect();
    NumberedGap {
        gap: Gap {
            rims: vec![boundary.vertices.clone()],
            islands: islands.iter().map(|l| l.vertices.clone()).collect(),
            extend_over: None,
        },
        rim_ids: vec![id],
        island_ids: islands.iter().map(|l| l.id).collect(),
    }
}

/// Rims that face each other around a column: neither is a hole by itself, but between them the
/// wall is missing.
fn ring_gaps(input: &Input, whole: &Patch) -> Vec<usize> {
    if !matches!(whole.base, BaseSurface::Cylinder(_) | BaseSurface::Cone(_)) {
        return Vec::new();
    }
    (input.loops.iter())
        .filter(|l| l.kind == LoopKind::Rim && l.defect.is_none())
        .filter(|l| lies_on(whole, l))
        .filter(|l| {
            let with_others = single_gap(input, l.id).gap;
            let alone = Gap {
                islands: Vec::new(),
                ..with_others.clone()
            };
            !is_bounded(&whole.base, &whole.relief, &alone)
                && is_bounded(&whole.base, &whole.relief, &with_others)
        })
        .map(|l| l.id)
        .collect()
}

/// The rest of the base surface beyond the rims of the scan's main piece.
fn extend(input: &Input, whole: &Patch, plan: &mut Plan) {
    let Some(main) = main_component(input, whole) else {
        return;
    };
    let taken: Vec<usize> = (plan.on_base.iter().chain(&plan.off_base))
        .flat_map(|gap| gap.rim_ids.iter().copied())
        .collect();
    let mut rims: Vec<&BoundaryLoop> = (input.loops.iter())
        .filter(|l| l.kind == LoopKind::Rim && l.component == main)
        .filter(|l| !taken.contains(&l.id))
        .collect();
    for rim in &rims {
        if let Some(edge) = rim.defect
            && !plan.skipped.iter().any(|hole| hole.loops.contains(&rim.id))
        {
            plan.skipped.push(broken(rim.id, edge));
        }
    }
    rims.retain(|l| l.defect.is_none());
    if is_sphere(whole) {
        plan.on_base
            .extend(rims.iter().map(|l| single_gap(input, l.id)));
        return;
    }
    let Some(first) = rims.first() else {
        return;
    };
    let mut gap = single_gap(input, first.id);
    gap.gap.rims = rims.iter().map(|l| l.vertices.clone()).collect();
    gap.gap.extend_over = Some(
        (0u32..)
            .zip(&whole.on_base)
            .filter_map(|(v, on)| on.then_some(v))
            .collect(),
    );
    gap.rim_ids = rims.iter().map(|l| l.id).collect();
    plan.on_base.push(gap);
}

/// The connected piece with the most vertices on the base.
fn main_component(input: &Input, whole: &Patch) -> Option<u32> {
    let (components, count) = input.adjacency.components();
    let mut sizes = vec![0usize; count];
    for (component, on) in components.iter().zip(&whole.on_base) {
        sizes[*component as usize] += usize::from(*on);
    }
    (0u32..)
        .zip(&sizes)
        .max_by_key(|(component, size)| (**size, std::cmp::Reverse(*component)))
        .map(|(component, _)| component)
}

/// Fits a base surface to the surroundings of a hole and completes the hole there.
///
/// First robustly to wide surroundings, as for a whole scan. Where these are of several surfaces (an
/// arch in a battlement), to what is next to the rim alone, whatever relief that leaves; at last the
/// plane of the rim, onto which every rim that does not fold over can be projected.
pub(super) fn complete_on_own_base(
    input: &Input,
    gap: NumberedGap,
    params: &CompleteParams,
    work: &mut Work,
    clock: &mut Clock,
) {
    let id = gap.rim_ids[0];
    let boundary = &input.loops[id];
    let wide = surroundings(input, boundary, enough_vertices(input, boundary));
    let narrow = surroundings(input, boundary, NARROW_RATIO * boundary.vertices.len());
    let on_wide = || {
        let (fit, side) =
            fit_to(input, &wide, params, Loss::Tukey).filter(|(fit, _)| fit.fits())?;
        Some(Patch::own(
            input,
            &fit.base,
            side,
            relief::reach(&fit),
            &wide,
        ))
    };
    let on_narrow = || {
        let (fit, side) = fit_to(input, &narrow, params, Loss::LeastSquares)?;
        let reach = fit.max_residual * (1.0 + 1e-9);
        Some(Patch::own(input, &fit.base, side, reach, &wide))
    };
    let serves =
        |patch: &Patch| lies_on(patch, boundary) && is_filled_sparingly(input, patch, &gap);
    let patch = (on_wide().filter(serves))
        .or_else(|| on_narrow().filter(serves))
        .or_else(|| on_rim_plane(input, boundary, &narrow, &wide).filter(serves));
    clock.end("own bases");
    match patch {
        Some(patch) => patch.complete(input, vec![gap], params, work, clock),
        None => work.skipped.push(SkippedHole {
            loops: vec![id],
            reason: "its rim lies neither on the scan's base surface nor, with its surroundings, on one of its own; cut the scan down to one surface".to_owned(),
        }),
    }
}

/// Whether the gap can be filled on the patch with about as much surface as its rim can span: a base
/// that continues the wrong way around would take the long way.
fn is_filled_sparingly(input: &Input, patch: &Patch, gap: &NumberedGap) -> bool {
    let length = input.loops[gap.rim_ids[0]].length;
    let most = MOST_AREA_RATIO * length * length / (4.0 * std::f64::consts::PI);
    // Targets as far apart as that area allows: enough for the area, and soon done.
    let spacing = input.spacing.spacing.max(0.05 * most.sqrt());
    let filled = fill(
        &patch.base,
        &patch.relief,
        &input.adjacency,
        &gap.gap,
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

/// The base surface of a region, of any kind, and the side of it that the region faces.
fn fit_to(
    input: &Input,
    region: &[bool],
    params: &CompleteParams,
    loss: Loss,
) -> Option<(FitReport, f64)> {
    let mesh = TriMesh {
        positions: input.mesh.positions.clone(),
        triangles: (input.mesh.triangles.iter())
            .filter(|t| t.iter().all(|v| region[*v as usize]))
            .copied()
            .collect(),
    };
    let params = FitParams {
        base: BaseChoice::Auto,
        loss,
        ..params.fit
    };
    let fit = base::fit(&mesh, &params).ok()?;
    let side = relief::facing(&mesh, &fit.base);
    Some((fit, side))
}

/// The plane through a rim, seen from the side from which the hole runs counterclockwise.
fn on_rim_plane(
    input: &Input,
    boundary: &BoundaryLoop,
    narrow: &[bool],
    wide: &[bool],
) -> Option<Patch> {
    let rim: Vec<_> = (boundary.vertices.iter())
        .map(|v| input.mesh.positions[*v as usize])
        .collect();
    let normal = Unit::try_new(vector_area(&rim), 0.0)?;
    let sum: Vector3<f64> = rim.iter().map(|p| p.coords).sum();
    let point = Point3::from(sum / rim.len() as f64);
    let plane = BaseSurface::Plane(Plane { point, normal });
    let reach = (input.mesh.positions.iter().zip(narrow))
        .filter(|(_, near)| **near)
        .map(|(p, _)| plane.foot(p).height.abs())
        .fold(0.0, f64::max);
    Some(Patch::own(input, &plane, 1.0, reach * (1.0 + 1e-9), wide))
}

/// Size of the wide surroundings: enough to fit, and to copy the hole's relief from.
fn enough_vertices(input: &Input, boundary: &BoundaryLoop) -> usize {
    let needed = boundary.area / input.spacing.spacing.powi(2);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturating"
    )]
    let enough = (SURROUNDING_RATIO * needed) as usize;
    enough
        .max(SURROUNDING_VERTICES)
        .max(2 * boundary.vertices.len())
}

/// Vertices around a hole, ring by ring, until there are enough.
fn surroundings(input: &Input, boundary: &BoundaryLoop, enough: usize) -> Vec<bool> {
    let mut region = vec![false; input.mesh.positions.len()];
    let mut ring = boundary.vertices.clone();
    let mut count = 0;
    while !ring.is_empty() && count < enough {
        let mut next = Vec::new();
        for v in ring {
            if !std::mem::replace(&mut region[v as usize], true) {
                count += 1;
                next.extend(input.adjacency.neighbors.row(v as usize));
            }
        }
        ring = next;
    }
    region
}
