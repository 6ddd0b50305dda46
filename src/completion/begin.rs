//! What comes before growth and after it, whichever way is grown: the scan is read and its base surface fitted,
//! gaps are chosen; and all that was added is put together.

use std::borrow::Cow;

use nalgebra::Vector3;

use crate::base::{self, BaseChoice, FitReport};
use crate::mesh::{Adjacency, TriMesh, boundary_loops, bounding_diagonal};
use crate::relief;
use crate::sampling::edge_spacing;
use crate::scan::Scan;

use super::assemble::{assemble, earlier_marks};
use super::choice::{Admitted, choose};
use super::free_form::FreeFormDone;
use super::noted::{RememberedBase, remember};
use super::patch::{NumberedGap, Patch};
use super::report::{CompletionReport, Counts};
use super::{
    Clock, CompleteParams, Completion, CompletionError, Input, Method, Work, gaps, suited,
};

/// A scan with its base surface.
pub(super) struct Prepared {
    pub(super) input: Input,
    fit: FitReport,
    /// The scan's centroid.
    origin: Vector3<f64>,
    base_fits: bool,
    /// The part of the scan that lies on the base surface, if that fits.
    pub(super) whole: Option<Patch>,
}

/// A scan with the gaps that are to be filled.
pub(super) struct Begun {
    pub(super) prepared: Prepared,
    pub(super) on_base: Vec<NumberedGap>,
    pub(super) off_base: Vec<NumberedGap>,
    pub(super) work: Work,
}

/// Fits the base surface and chooses the gaps.
///
/// # Errors
/// [`CompletionError`] if nothing can be completed at all.
pub(super) fn begin(
    scan: &Scan,
    params: &CompleteParams,
    clock: &mut Clock,
) -> Result<Begun, CompletionError> {
    params.check()?;
    let (input, fit, origin) = prepare(scan, params, clock)?;
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
    Ok(Begun {
        prepared: Prepared {
            input,
            fit,
            origin,
            base_fits,
            whole,
        },
        on_base: plan.on_base,
        off_base: plan.off_base,
        work,
    })
}

impl Prepared {
    /// The completed scan, and what was done.
    pub(super) fn completed(
        &self,
        scan: &Scan,
        free_form: Option<&FreeFormDone>,
        work: Work,
        mut clock: Clock,
    ) -> Completion {
        let Self {
            input, fit, origin, ..
        } = self;
        let heights = match (&self.whole, free_form) {
            (Some(whole), _) => whole.relief.heights.clone(),
            (None, Some(free_form)) => free_form.heights.clone(),
            (None, None) => vec![f64::NAN; input.mesh.positions.len()],
        };
        clock.begin("assemble");
        let mut scan = assemble(scan, input, heights, &work, origin);
        let base = self.base_fits.then(|| RememberedBase {
            surface: fit.base.translated(*origin),
            reach: relief::reach(fit),
        });
        let noted = free_form.filter(|_| !self.base_fits);
        remember(&mut scan, base.as_ref(), noted.map(|done| &done.remembered));
        clock.end("assemble");
        let mut report = CompletionReport {
            fit: fit.clone(),
            base_fits: self.base_fits,
            spacing: input.spacing,
            filled: work.filled(),
            counts: counts(input, &scan, &work),
            skipped: work.skipped,
            searched: work.searched,
            chosen: work.chosen,
            free_form: free_form.map(FreeFormDone::report),
            seconds: clock.stages,
        };
        report.translate(*origin);
        Completion { scan, report }
    }
}

fn counts(input: &Input, completed: &Scan, work: &Work) -> Counts {
    let [rims_left, holes_left] = gaps::left(input, work);
    Counts {
        original_vertices: input.mesh.positions.len(),
        original_faces: completed.faces.len() - work.faces(),
        completed_vertices: work.vertices(),
        completed_faces: work.faces(),
        samples: work.samples,
        loops: input.loops.len(),
        rims_left,
        holes_left,
        stray_vertices: input.strays,
    }
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
