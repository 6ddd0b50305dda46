//! Scan to completed scan: base surface, relief, targets, growth.
//!
//! [`complete`] is the list of these steps. Originals come first in its result, bit for bit;
//! completion only appends.
//!
//! # Reference
//! [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), Appendix A.

mod assemble;
mod audit;
mod blend;
mod by_paper;
mod by_stencil;
mod choice;
mod correlation;
mod error;
mod free_form;
mod gaps;
mod growth;
mod noted;
mod own_base;
mod params;
mod patch;
mod report;
mod smooth_part;
mod suited;
mod surroundings;

pub use assemble::{COMPLETED, COST, HEIGHT, SOURCE};
pub use choice::{COLOR_TOLERANCE, HoleChoice, HoleLimits, Paint};
pub use error::CompletionError;
pub use noted::{
    RememberedBase, RememberedFreeForm, noted_relief, remembered_base, remembered_free_form,
};
pub use params::{CompleteParams, Method};
pub use report::{
    Chosen, CompletionReport, Counts, FilledHole, FreeFormReport, Recall, Searched, SkippedHole,
};

use std::borrow::Cow;

use nalgebra::Vector3;

use crate::base::{self, BaseChoice, FitReport};
use crate::mesh::{Adjacency, BoundaryLoop, LoopKind, TriMesh, boundary_loops, bounding_diagonal};
use crate::progress::{Clock, Progress};
use crate::relief;
use crate::sampling::{EdgeSpacing, edge_spacing};
use crate::scan::Scan;

use assemble::{assemble, earlier_marks};
use choice::{Admitted, choose};
use noted::remember;
use patch::{Added as AddedGap, NumberedGap, Patch};

/// A completed scan.
#[derive(Debug, Clone)]
pub struct Completion {
    /// The scan with the completed part appended and the channels [`COMPLETED`], [`HEIGHT`],
    /// [`SOURCE`] and [`COST`].
    pub scan: Scan,
    /// What was done.
    pub report: CompletionReport,
}

/// Completes the scan's missing parts with relief and colour.
///
/// Holes that lie off the scan's base surface (all, if no kind of base surface fits the whole scan)
/// are completed on free form, or by the paper's method each on a base surface of its own, fitted to its
/// surroundings. Holes that cannot be filled are reported in
/// [`CompletionReport::skipped`]; that is no error.
///
/// # Errors
/// [`CompletionError`] if nothing can be completed at all.
pub fn complete(
    scan: &Scan,
    params: &CompleteParams,
    progress: &mut dyn FnMut(Progress),
) -> Result<Completion, CompletionError> {
    params.check()?;
    let mut clock = Clock::new(progress);
    let (input, fit, origin) = prepare(scan, params, &mut clock)?;
    let base_fits = fit.fits() && params.fit.base != BaseChoice::FreeForm;
    let admitted = Admitted::new(scan, &input.loops, params)?;
    let chosen = choose(&input.loops, &admitted, params)?;
    let whole = base_fits.then(|| Patch::whole(&input, &fit));
    if (whole.as_ref()).is_some_and(|whole| whole.triangles.is_empty()) {
        return Err(CompletionError::NoSamples);
    }
    let plan = gaps::plan(&input, whole.as_ref(), &chosen, &admitted, params);
    if plan.is_empty() {
        return Err(CompletionError::NoInteriorHole {
            rims: input.loops.len(),
        });
    }
    let mut work = Work {
        skipped: plan.skipped,
        ..Work::default()
    };
    if params.method != Method::Paper {
        work.chosen.push(suited::spacing(params, &input.spacing));
    }
    if let Some(whole) = &whole {
        whole.complete(&input, plan.on_base, params, &mut work, &mut clock);
    }
    let off_base = with_those_off_the_chart(plan.off_base, &input, params, &mut work);
    let free_form = complete_off_base(&input, off_base, params, &mut work, &mut clock);
    let heights = match (&whole, &free_form) {
        (Some(whole), _) => whole.relief.heights.clone(),
        (None, Some(free_form)) => free_form.heights.clone(),
        (None, None) => vec![f64::NAN; input.mesh.positions.len()],
    };
    clock.begin("assemble");
    let mut scan = assemble(scan, &input, heights, &work, &origin);
    let base = base_fits.then(|| RememberedBase {
        surface: fit.base.translated(origin),
        reach: relief::reach(&fit),
    });
    let noted = free_form.as_ref().filter(|_| !base_fits);
    remember(&mut scan, base.as_ref(), noted.map(|done| &done.remembered));
    clock.end("assemble");
    let seconds = clock.stages;
    let [rims_left, holes_left] = gaps::left(&input, &work);
    let counts = Counts {
        original_vertices: input.mesh.positions.len(),
        original_faces: scan.faces.len() - work.faces(),
        completed_vertices: work.vertices(),
        completed_faces: work.faces(),
        samples: work.samples,
        loops: input.loops.len(),
        rims_left,
        holes_left,
        stray_vertices: input.strays,
    };
    let mut report = CompletionReport {
        fit,
        base_fits,
        spacing: input.spacing,
        filled: work.filled(),
        skipped: work.skipped,
        counts,
        searched: work.searched,
        chosen: work.chosen,
        free_form: free_form.as_ref().map(free_form::FreeFormDone::report),
        seconds,
    };
    report.translate(origin);
    Ok(Completion { scan, report })
}

/// Completes gaps that have no place on the scan's own base surface: on free form, or by the paper's method
/// each on a base surface of its own.
fn complete_off_base(
    input: &Input,
    off_base: Vec<NumberedGap>,
    params: &CompleteParams,
    work: &mut Work,
    clock: &mut Clock,
) -> Option<free_form::FreeFormDone> {
    if params.method == Method::Paper {
        for gap in off_base {
            own_base::complete_on_own_base(input, &gap, params, work, clock);
        }
    } else {
        // Free form has no end that would tell how to close what is outside of a rim.
        let (gaps, rims): (Vec<NumberedGap>, Vec<_>) = off_base.into_iter().partition(|gap| {
            params.holes != HoleChoice::All || input.loops[gap.rim_ids[0]].kind == LoopKind::Hole
        });
        work.skipped.extend(rims.into_iter().map(|gap| SkippedHole {
            loops: gap.rim_ids,
            reason: "it is an outer rim, and no base surface closes behind it; to close it all the same give its number to --holes".to_owned(),
        }));
        if !gaps.is_empty() {
            return free_form::complete_on_free_form(input, &gaps, params, work, clock);
        }
    }
    None
}

/// The gaps off the base surface, and holes that lie on it but turn over or cross themselves as seen along
/// its normals, as between stones: they are filled on free form, too.
fn with_those_off_the_chart(
    mut off_base: Vec<NumberedGap>,
    input: &Input,
    params: &CompleteParams,
    work: &mut Work,
) -> Vec<NumberedGap> {
    for (gap, reason) in std::mem::take(&mut work.off_chart) {
        let is_hole = |id: &usize| input.loops[*id].kind == LoopKind::Hole;
        if params.method != Method::Paper && gap.rim_ids.iter().all(is_hole) {
            off_base.push(gap);
        } else {
            work.skipped.push(SkippedHole {
                loops: gap.rim_ids,
                reason,
            });
        }
    }
    off_base
}

/// The scan's mesh, loops and base surface, all around the scan's centroid, and the centroid.
fn prepare(
    scan: &Scan,
    params: &CompleteParams,
    clock: &mut Clock,
) -> Result<(Input, FitReport, Vector3<f64>), CompletionError> {
    clock.begin("loops");
    let (mesh, origin) = scan.mesh().centered();
    if mesh.triangles.is_empty() {
        return Err(CompletionError::NoFaces);
    }
    let adjacency = Adjacency::new(&mesh);
    let loops = boundary_loops(&mesh, &adjacency);
    clock.end("loops");
    clock.begin("fit");
    let mut scanned = scanned_vertices(scan, params);
    let strays = leave_out_strays(&mut scanned, &mesh, &adjacency, params);
    let fit = base::fit_part(
        &mesh.positions,
        &scanned_triangles(&mesh, &scanned),
        &params.fit,
    )?;
    check_wavelength(params, &mesh)?;
    if !fit.fits() && (params.extend || matches!(params.fit.base, BaseChoice::Kind(_))) {
        return Err(CompletionError::BaseDoesNotFit {
            kind: fit.base.kind(),
            rms: fit.inlier_rms,
            size: fit.diagonal,
        });
    }
    clock.end("fit");
    let rule = params.spacing.unwrap_or_default();
    let input = Input {
        spacing: edge_spacing(&mesh, rule).ok_or(CompletionError::NoFaces)?,
        mesh,
        adjacency,
        loops,
        colors: scan.colors(),
        scanned,
        strays,
    };
    Ok((input, fit, origin))
}

/// What is longer than the scan cannot be told apart in it.
fn check_wavelength(params: &CompleteParams, mesh: &TriMesh) -> Result<(), CompletionError> {
    let diagonal = bounding_diagonal(&mesh.positions);
    match params.form_wavelength {
        Some(wavelength) if wavelength > diagonal => Err(CompletionError::Parameter {
            name: "--form-wavelength",
            range: "at most the length of the scan",
            value: wavelength,
        }),
        _ => Ok(()),
    }
}

/// The scan as every step sees it: around its centroid, so that large offsets (national grids) cost
/// no precision.
#[derive(Debug)]
struct Input {
    mesh: TriMesh,
    adjacency: Adjacency,
    loops: Vec<BoundaryLoop>,
    colors: Option<Vec<[f64; 3]>>,
    spacing: EdgeSpacing,
    /// Whether a vertex may be copied from; what an earlier completion invented may not.
    scanned: Vec<bool>,
    /// Number of vertices on stray pieces of surface, which are not copied from either.
    strays: usize,
}

/// What was completed so far.
#[derive(Debug, Default)]
struct Work {
    added: Vec<AddedGap>,
    skipped: Vec<SkippedHole>,
    /// Gaps that cannot be filled in the chart of the scan's own base surface, and why.
    off_chart: Vec<(NumberedGap, String)>,
    /// Samples searched on the scan's own base surface.
    samples: usize,
    searched: Searched,
    /// What was chosen for want of being given.
    chosen: Vec<Chosen>,
    /// Number of patches begun: each has random numbers of its own.
    patches: u32,
}

impl Work {
    fn vertices(&self) -> usize {
        self.added.iter().map(|gap| gap.points.len()).sum()
    }

    fn faces(&self) -> usize {
        self.added.iter().map(|gap| gap.triangles.len()).sum()
    }

    fn filled(&self) -> Vec<FilledHole> {
        self.added.iter().map(|gap| gap.report.clone()).collect()
    }
}

impl CompletionReport {
    /// From coordinates around the centroid to the scan's own.
    fn translate(&mut self, origin: Vector3<f64>) {
        self.fit.base = self.fit.base.translated(origin);
        for candidate in &mut self.fit.ranking {
            candidate.base = candidate.base.translated(origin);
        }
        for hole in &mut self.filled {
            hole.own_base = hole.own_base.map(|base| base.translated(origin));
        }
    }
}

/// For each vertex whether it may be copied from: not if an earlier completion invented it, but for
/// bootstrapping.
fn scanned_vertices(scan: &Scan, params: &CompleteParams) -> Vec<bool> {
    match earlier_marks(scan) {
        Some(earlier) if !params.bootstrap => {
            earlier.completed.iter().map(|mark| *mark == 0).collect()
        }
        _ => vec![true; scan.vertices.rows],
    }
}

/// Marks what lies on stray pieces of surface as nothing to copy from, and gives the number of vertices.
fn leave_out_strays(
    scanned: &mut [bool],
    mesh: &TriMesh,
    adjacency: &Adjacency,
    params: &CompleteParams,
) -> usize {
    let (components, count) = adjacency.components();
    let used = mesh.used_vertices();
    let mut sizes = vec![0usize; count];
    for (component, _) in components.iter().zip(&used).filter(|(_, used)| **used) {
        sizes[*component as usize] += 1;
    }
    let largest = sizes.iter().copied().max().unwrap_or_default();
    let least = params.stray * largest as f64;
    let mut strays = 0;
    for (v, component) in components.iter().enumerate().filter(|(v, _)| used[*v]) {
        if (sizes[*component as usize] as f64) < least {
            scanned[v] = false;
            strays += 1;
        }
    }
    strays
}

/// The triangles whose corners were all scanned.
fn scanned_triangles<'a>(mesh: &'a TriMesh, scanned: &[bool]) -> Cow<'a, [[u32; 3]]> {
    if scanned.iter().all(|scanned| *scanned) {
        return Cow::Borrowed(&mesh.triangles);
    }
    let triangles = mesh.triangles.iter().copied();
    triangles
        .filter(|t| t.iter().all(|v| scanned[*v as usize]))
        .collect()
}

fn index(v: usize) -> u32 {
    u32::try_from(v).expect("vertex indices are u32")
}
