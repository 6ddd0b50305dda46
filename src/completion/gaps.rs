//! Which boundary loops to fill, grouped into gaps.

use crate::base::{BaseSurface, Form};
use crate::mesh::{BoundaryLoop, LoopKind};
use crate::sampling::{Gap, is_bounded};

use super::choice::{Admitted, HoleChoice};
use super::patch::{NumberedGap, Patch};
use super::{CompleteParams, Input, SkippedHole, Work};

/// A loop lies on a base surface if this share of its vertices does: a few may stand on spikes.
const ON_BASE_SHARE: f64 = 0.9;

/// The gaps by where they lie.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) on_base: Vec<NumberedGap>,
    /// Holes to be filled on free form, or on a base surface of their own.
    pub(super) off_base: Vec<NumberedGap>,
    pub(super) skipped: Vec<SkippedHole>,
}

impl Plan {
    pub(super) fn is_empty(&self) -> bool {
        self.on_base.is_empty() && self.off_base.is_empty() && self.skipped.is_empty()
    }
}

/// Numbers of rims and of holes that are neither filled nor skipped.
pub(super) fn left(input: &Input, work: &Work) -> [usize; 2] {
    let filled = work.added.iter().flat_map(|gap| &gap.report.loops);
    let skipped = work.skipped.iter().flat_map(|hole| &hole.loops);
    let taken = marked(input, filled.chain(skipped));
    [LoopKind::Rim, LoopKind::Hole].map(|kind| {
        let loops = input.loops.iter().filter(|l| l.kind == kind);
        loops.filter(|l| !taken[l.id]).count()
    })
}

/// For each loop, whether its number is among `ids`.
fn marked<'a>(input: &Input, ids: impl Iterator<Item = &'a usize>) -> Vec<bool> {
    let mut marked = vec![false; input.loops.len()];
    for id in ids {
        marked[*id] = true;
    }
    marked
}

/// Groups the chosen loops into gaps, and adds those of the extension.
pub(super) fn plan(
    input: &Input,
    whole: Option<&Patch>,
    chosen: &[usize],
    admitted: &Admitted,
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
        let rings = ring_gaps(input, whole).into_iter();
        wanted.extend(rings.filter(|id| admitted.admits(*id)));
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
    matches!(patch.form, Form::Primitive(BaseSurface::Sphere(_)))
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
pub(super) fn lies_on(patch: &Patch, boundary: &BoundaryLoop) -> bool {
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
    let Form::Primitive(base @ (BaseSurface::Cylinder(_) | BaseSurface::Cone(_))) = &whole.form
    else {
        return Vec::new();
    };
    (input.loops.iter())
        .filter(|l| l.kind == LoopKind::Rim && l.defect.is_none())
        .filter(|l| lies_on(whole, l))
        .filter(|l| {
            let alone = Gap {
                rims: vec![l.vertices.clone()],
                islands: Vec::new(),
                extend_over: None,
            };
            !is_bounded(base, &whole.relief, &alone)
                && is_bounded(base, &whole.relief, &single_gap(input, l.id).gap)
        })
        .map(|l| l.id)
        .collect()
}

/// The rest of the base surface beyond the rims of the scan's main piece.
fn extend(input: &Input, whole: &Patch, plan: &mut Plan) {
    let Some(main) = main_component(input, whole) else {
        return;
    };
    let gaps = plan.on_base.iter().chain(&plan.off_base);
    let taken = marked(input, gaps.flat_map(|gap| &gap.rim_ids));
    let skipped = marked(input, plan.skipped.iter().flat_map(|hole| &hole.loops));
    let mut rims: Vec<&BoundaryLoop> = (input.loops.iter())
        .filter(|l| l.kind == LoopKind::Rim && l.component == main)
        .filter(|l| !taken[l.id])
        .collect();
    for rim in &rims {
        if let Some(edge) = rim.defect
            && !skipped[rim.id]
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
