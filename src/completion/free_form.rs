//! Holes where no single surface with a formula fits, completed on free form.
//!
//! The scan is smoothed next to the holes; each hole is spanned over the smooth surface and bent until it
//! goes on from it without a kink. Then scan and fills are smoothed together, so that the form does not end at
//! the rims: that is the base under both.

use std::collections::BTreeSet;

use nalgebra::Point3;

use crate::base::{
    Form, FreeForm, Role, Undetermined, WavelengthChoice, choose_wavelength, smooth_form,
};
use crate::mesh::{TriMesh, smoothed_positions, vertex_normals};
use crate::relief::{self, Relief};
use crate::sampling::{Gap, Spanned};

use super::noted::RememberedFreeForm;
use super::patch::{NumberedGap, Patch, Planned, joint_triangles};
use super::surroundings::{Part, around};
use super::{Clock, CompleteParams, FreeFormReport, Input, Progress, SkippedHole, Work, index};

/// A hole's fill is bent and evened out by turns this many times: the first turn does most.
const BENDINGS: usize = 3;

/// More vertices around the holes than this are neither smoothed nor copied from: the time and memory of
/// the solve grow faster than their number.
const MOST_VERTICES: usize = 300_000;

/// What lies farther from a rim than this many wavelengths has no part in how the form leaves it.
const REACHED: f64 = 1.5;

/// What is copied comes from so many times as many vertices around a hole as it needs, and at least from …
const COPIED_RATIO: usize = 8;
/// … so many.
const COPIED_VERTICES: usize = 3000;

/// The wavelength is chosen on as many vertices around the largest hole.
const CHOOSING_VERTICES: usize = 20_000;

/// What was found of the free form.
#[derive(Debug)]
pub(super) struct FreeFormDone {
    /// Heights of the scan's vertices over it; NaN for those too far from all holes.
    pub(super) heights: Vec<f64>,
    pub(super) remembered: RememberedFreeForm,
    pub(super) choice: Option<WavelengthChoice>,
}

impl FreeFormDone {
    pub(super) fn report(&self) -> FreeFormReport {
        let lying = (self.heights.iter()).filter(|h| h.abs() <= self.remembered.reach);
        let (sum, count) = lying.fold((0.0, 0.0), |(sum, count), h| (sum + h * h, count + 1.0));
        FreeFormReport {
            wavelength: self.remembered.form.wavelength,
            choice: self.choice.clone(),
            rms: f64::sqrt(sum / f64::max(count, 1.0)),
            reach: self.remembered.reach,
        }
    }
}

/// Gaps on free form, with their targets.
pub(super) struct FreeFormPlan {
    pub(super) part: Part,
    pub(super) patch: Patch,
    pub(super) planned: Vec<Planned>,
    remembered: RememberedFreeForm,
    choice: Option<WavelengthChoice>,
}

impl FreeFormPlan {
    /// What was found, once all is grown: what was added to `work` since it had `before` gaps is numbered as the
    /// scan is.
    pub(super) fn done(self, input: &Input, before: usize, work: &mut Work) -> FreeFormDone {
        for added in &mut work.added[before..] {
            self.part.renumber(input, added);
        }
        let heights = &self.patch.relief.heights;
        FreeFormDone {
            heights: self.part.spread(heights, input.mesh.positions.len()),
            remembered: self.remembered,
            choice: self.choice,
        }
    }
}

/// Completes gaps on free form; `None` where there is no such form, with the reason among the skipped.
pub(super) fn complete_on_free_form(
    input: &Input,
    gaps: &[NumberedGap],
    params: &CompleteParams,
    work: &mut Work,
    clock: &mut Clock,
) -> Option<FreeFormDone> {
    let mut plan = plan_on_free_form(input, gaps, params, work, clock)?;
    let planned = std::mem::take(&mut plan.planned);
    let before = work.added.len();
    (plan.patch).grow(&plan.part.input, planned, params, work, clock);
    Some(plan.done(input, before, work))
}

/// Finds the free form under the gaps and their targets on it; `None` where there is no such form, with the
/// reason among the skipped.
pub(super) fn plan_on_free_form(
    input: &Input,
    gaps: &[NumberedGap],
    params: &CompleteParams,
    work: &mut Work,
    clock: &mut Clock,
) -> Option<FreeFormPlan> {
    let ids: Vec<usize> = gaps.iter().flat_map(|gap| gap.rim_ids.clone()).collect();
    let plan = try_to_plan(input, gaps, params, work, clock);
    plan.map_err(|undetermined| {
        let told = |id: &usize| work.skipped.iter().any(|hole| hole.loops.contains(id));
        work.skipped.push(SkippedHole {
            loops: ids.into_iter().filter(|id| !told(id)).collect(),
            reason: format!("{undetermined}; remove them there, or choose another --base"),
        });
    })
    .ok()
}

fn try_to_plan(
    input: &Input,
    gaps: &[NumberedGap],
    params: &CompleteParams,
    work: &mut Work,
    clock: &mut Clock,
) -> Result<FreeFormPlan, Undetermined> {
    clock.begin("form");
    let choice = match params.form_wavelength {
        Some(_) => None,
        None => Some(choice(input, gaps)?),
    };
    let chosen = choice.as_ref().map(|choice| choice.wavelength);
    let wavelength = params.form_wavelength.or(chosen).ok_or(Undetermined)?;
    let part = Part::around(input, gaps, MOST_VERTICES);
    let smooth = smoothed(&part, gaps, wavelength)?;
    clock.end("form");
    let mut spanned: Vec<(NumberedGap, Spanned)> = Vec::new();
    // Loops that are filled around already, as islands of an earlier gap.
    let mut taken: Vec<usize> = Vec::new();
    for (number, gap) in gaps.iter().enumerate() {
        (clock.progress)(Progress {
            stage: "targets",
            done: number,
            total: gaps.len(),
        });
        let mut gap = part.gap(gap);
        if taken.contains(&gap.rim_ids[0]) {
            continue;
        }
        gap.leave_islands(&taken);
        match span(&part.input, &smooth, &gap.gap, wavelength) {
            Ok(span) => {
                taken.push(gap.rim_ids[0]);
                taken.extend(span.islands().iter().map(|i| gap.island_ids[*i]));
                spanned.push((gap, span));
            }
            Err(reason) => work.skipped.push(SkippedHole {
                loops: gap.rim_ids,
                reason,
            }),
        }
    }
    clock.end("targets");
    clock.begin("form");
    let relief = joint_relief(&part.input, &smooth, &mut spanned, wavelength)?;
    let planned = plan(
        &part.input,
        &relief,
        without_shared_edges(&part.input, spanned, work),
    );
    let reach = relief::reach_of(&used_heights(&part.input.mesh, &relief));
    let form = FreeForm { wavelength };
    let near = near_gaps(&part.input, &planned);
    let patch = Patch::new(&part.input, Form::Free(form), relief, reach, Some(&near));
    clock.end("form");
    Ok(FreeFormPlan {
        part,
        patch,
        planned,
        remembered: RememberedFreeForm { form, reach },
        choice,
    })
}

/// The wavelength that suits the surroundings of the first gap.
fn choice(input: &Input, gaps: &[NumberedGap]) -> Result<WavelengthChoice, Undetermined> {
    let first = &gaps[..gaps.len().min(1)];
    let part = Part::around(input, first, CHOOSING_VERTICES);
    choose_wavelength(&part.input.mesh, &shape(&part.input), input.spacing.median)
}

/// The scan without what would disturb lengths and angles.
fn shape(input: &Input) -> Vec<Point3<f64>> {
    smoothed_positions(&input.mesh, &input.adjacency, relief::SHAPE_ROUNDS)
}

/// The relief of a completed mesh over free form, in which what was added (`completed`, #V) has no say; `None` if it
/// is too large, or the form is not determined.
pub(super) fn relief_of_completed(
    mesh: &TriMesh,
    completed: &[bool],
    wavelength: f64,
) -> Option<Relief> {
    if mesh.positions.len() > MOST_VERTICES {
        return None;
    }
    let (relief, _) = relief::on_free_form(mesh, Some(wavelength), completed).ok()?;
    Some(relief)
}

/// The scan without its relief, next to the gaps; without the finest of it elsewhere.
fn smoothed(part: &Part, gaps: &[NumberedGap], wavelength: f64) -> Result<TriMesh, Undetermined> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, saturating"
    )]
    let rings = (REACHED * wavelength / part.input.spacing.median).ceil() as usize;
    let gaps: Vec<NumberedGap> = gaps.iter().map(|gap| part.gap(gap)).collect();
    let near = Part::within(&part.input, &gaps, rings);
    let mut positions = shape(&part.input);
    let mesh = &near.input.mesh;
    let roles = vec![Role::Measured; mesh.positions.len()];
    let smooth = smooth_form(mesh, &near.chosen(&positions), &roles, wavelength)?;
    near.put_back(&smooth, &mut positions);
    Ok(TriMesh {
        positions,
        triangles: part.input.mesh.triangles.clone(),
    })
}

/// Spans a gap and bends the fill until it goes on from the smooth surface.
///
/// # Errors
/// In words, why it cannot be spanned.
fn span(input: &Input, smooth: &TriMesh, gap: &Gap, wavelength: f64) -> Result<Spanned, String> {
    let mut spanned = Spanned::new(gap, smooth, &input.adjacency, input.spacing.spacing)
        .map_err(|error| error.to_string())?;
    for _ in 0..BENDINGS {
        let bent = bent(input, smooth, &spanned, wavelength).map_err(|error| error.to_string())?;
        spanned.move_targets(&bent);
        (spanned.refine(&input.adjacency)).map_err(|error| error.to_string())?;
    }
    Ok(spanned)
}

/// Targets where they bend least between the triangles around the gap.
fn bent(
    input: &Input,
    smooth: &TriMesh,
    spanned: &Spanned,
    wavelength: f64,
) -> Result<Vec<Point3<f64>>, Undetermined> {
    let rim = spanned.rim();
    let mut faces: Vec<u32> = (rim.iter())
        .flat_map(|v| input.adjacency.triangles.row(*v as usize))
        .copied()
        .collect();
    faces.sort_unstable();
    faces.dedup();
    let around = faces.iter().map(|f| smooth.triangles[*f as usize]);
    let mut beyond: Vec<u32> = (around.clone().flatten())
        .filter(|v| rim.binary_search(v).is_err())
        .collect();
    beyond.sort_unstable();
    beyond.dedup();
    // Numbers: the rim, the targets, the vertices beyond the rim.
    let targets = spanned.targets().len();
    let number = |v: u32| match (rim.binary_search(&v), beyond.binary_search(&v)) {
        (Ok(i), _) => index(i),
        (_, Ok(i) | Err(i)) => index(rim.len() + targets + i),
    };
    let scanned = |v: &u32| smooth.positions[*v as usize];
    let positions: Vec<Point3<f64>> = (rim.iter().map(scanned))
        .chain(spanned.targets().iter().copied())
        .chain(beyond.iter().map(scanned))
        .collect();
    let mut roles = vec![Role::Fixed; positions.len()];
    roles[rim.len()..rim.len() + targets].fill(Role::Free);
    let mesh = TriMesh {
        positions,
        triangles: (spanned.triangles().iter().copied())
            .chain(around.map(|t| t.map(number)))
            .collect(),
    };
    let bent = smooth_form(&mesh, &mesh.positions, &roles, wavelength)?;
    Ok(bent[rim.len()..rim.len() + targets].to_vec())
}

/// The relief of the scan over the smoothest surface through it and all fills, and the targets of the fills on
/// that surface.
fn joint_relief(
    input: &Input,
    smooth: &TriMesh,
    spanned: &mut [(NumberedGap, Spanned)],
    wavelength: f64,
) -> Result<Relief, Undetermined> {
    let scanned = input.mesh.positions.len();
    let mut joint = input.mesh.clone();
    let mut shape = smooth.positions.clone();
    for (_, spanned) in &*spanned {
        let fill = spanned.fill(index(shape.len()));
        shape.extend(&fill.targets);
        joint.triangles.extend(&fill.triangles);
    }
    joint.positions.extend(&shape[scanned..]);
    let mut roles = vec![Role::Measured; shape.len()];
    roles[scanned..].fill(Role::Free);
    let form = smooth_form(&joint, &shape, &roles, wavelength)?;
    let mut first = scanned;
    let relief = relief::over_form(&input.mesh, form[..scanned].to_vec());
    for (_, spanned) in spanned {
        let next = first + spanned.targets().len();
        // Smoothing moves a ragged rim sidewards, too; the fill has to meet it where it is.
        spanned.move_to(&form, first);
        spanned.meet_rim(&relief.feet);
        // It was refined before: at worst it stays like that.
        if let Err(error) = spanned.refine(&input.adjacency) {
            log::debug!("a fill is not evened out: {error}");
        }
        first = next;
    }
    Ok(relief)
}

/// The fills with the normals of the base surface that they and the scan's feet make.
fn plan(input: &Input, relief: &Relief, spanned: Vec<(NumberedGap, Spanned)>) -> Vec<Planned> {
    let mut joint = TriMesh {
        positions: relief.feet.clone(),
        triangles: input.mesh.triangles.clone(),
    };
    let scanned = joint.positions.len();
    let mut planned: Vec<Planned> = Vec::new();
    for (gap, spanned) in spanned {
        let fill = spanned.fill(index(scanned));
        let start = joint.positions.len() - scanned;
        joint.positions.extend(&fill.targets);
        let mut loops = gap.rim_ids;
        loops.extend(fill.islands.iter().map(|i| gap.island_ids[*i]));
        planned.push(Planned {
            loops,
            targets: start..start + fill.targets.len(),
            normals: Vec::new(),
            fill,
        });
    }
    joint.triangles.extend(joint_triangles(input, &planned));
    let normals = vertex_normals(&joint);
    for gap in &mut planned {
        gap.normals = normals[scanned + gap.targets.start..scanned + gap.targets.end].to_vec();
    }
    planned
}

/// The fills but those that have an edge between two of the scan's vertices which an earlier one has, too: it
/// would have more than two triangles.
fn without_shared_edges(
    input: &Input,
    spanned: Vec<(NumberedGap, Spanned)>,
    work: &mut Work,
) -> Vec<(NumberedGap, Spanned)> {
    let scanned = input.mesh.positions.len();
    let mut edges = BTreeSet::new();
    let mut kept = Vec::new();
    for (gap, spanned) in spanned {
        let is_new = |[a, b]: &[u32; 2]| {
            let both_scanned = (*b as usize) < scanned;
            both_scanned
                && (input.adjacency.neighbors.row(*a as usize))
                    .binary_search(b)
                    .is_err()
        };
        let own: BTreeSet<[u32; 2]> = (spanned.fill(index(scanned)).triangles.iter())
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .filter(is_new)
            .collect();
        if edges.is_disjoint(&own) {
            edges.extend(own);
            kept.push((gap, spanned));
        } else {
            work.skipped.push(SkippedHole {
                loops: gap.rim_ids,
                reason: "it shares two vertices with another hole, and an edge between them; complete it in a second run".to_owned(),
            });
        }
    }
    kept
}

/// Which vertices are copied from: those around the gaps, since a scan of free form has many kinds of relief.
fn near_gaps(input: &Input, planned: &[Planned]) -> Vec<bool> {
    let scanned = input.mesh.positions.len();
    let mut near = vec![false; scanned];
    for gap in planned {
        let rim: Vec<u32> = (gap.fill.triangles.iter().flatten().copied())
            .filter(|v| (*v as usize) < scanned)
            .collect();
        let enough = (COPIED_RATIO * gap.targets.len()).max(COPIED_VERTICES);
        for v in around(&input.adjacency, &rim, |_, count| count < enough).0 {
            near[v as usize] = true;
        }
    }
    near
}

fn used_heights(mesh: &TriMesh, relief: &Relief) -> Vec<f64> {
    (relief.heights.iter().zip(mesh.used_vertices()))
        .filter_map(|(height, used)| used.then_some(*height))
        .collect()
}
