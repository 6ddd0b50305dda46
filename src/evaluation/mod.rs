//! A scan to how well it is completed: holes of known content are cut out of it, completed, and judged
//! by what the surface's own pieces differ among themselves.
//!
//! [`evaluate`] is the door. The truth is what was cut out; but how far a fill is from it
//! ([`AgainstTruth`]) says little: on stochastic relief a smooth fill comes nearer to the truth than
//! another true piece of the surface does. What counts is the [`crate::likeness::Judgement`].

mod error;
mod hole;
mod judged;
mod params;
mod report;
mod truth;

pub use error::EvaluationError;
pub use params::{EvaluationParams, FillKind};
pub use report::{Evaluation, HeightsOver, HoleReport, Repeat};
pub use truth::AgainstTruth;

use std::time::Instant;

use crate::completion::{CompleteParams, complete};
use crate::likeness::{Calibration, Discs, copies};
use crate::mesh::{TriMesh, median_edge};
use crate::progress::Progress;
use crate::rng::{Rng, Stage};
use crate::scan::Scan;
use crate::stats;

use hole::Hole;
use judged::Judged;

/// With fewer true pieces than this a 95 % quantile means nothing.
const LEAST_PIECES: usize = 20;

/// Cuts holes out of a scan, one at a time, completes each, and judges the fills.
///
/// # Errors
/// [`EvaluationError`] if a parameter is out of its range, the scan has no room for the holes, or no hole
/// could be filled. Holes that could not be filled while others were are reported in
/// [`Evaluation::failed`].
pub fn evaluate(
    scan: &Scan,
    params: &EvaluationParams,
    progress: &mut dyn FnMut(Progress),
) -> Result<Evaluation, EvaluationError> {
    params.check()?;
    let mesh = scan.mesh();
    if mesh.triangles.is_empty() {
        return Err(EvaluationError::NoFaces);
    }
    let step = median_edge(&mesh).ok_or(EvaluationError::NoFaces)?;
    let discs = Discs::new(&mesh, &vec![true; mesh.positions.len()], step);
    let area = params.hole * discs.area();
    let mut rng = Rng::new(params.seed, Stage::Evaluation, 0);
    let places = discs.random(area, params.repeat, &mut rng);
    if places.len() < params.repeat {
        return Err(EvaluationError::NoRoom {
            holes: params.repeat,
            places: places.len(),
        });
    }
    let (mut repeats, mut failed) = (Vec::new(), Vec::new());
    for (number, disc) in places.iter().enumerate() {
        let hole = Hole::cut(scan, &mesh, disc);
        match evaluate_hole(scan, &mesh, &hole, params, step, progress) {
            Ok(repeat) => repeats.push(repeat),
            Err(EvaluationError::NotFilled(reason)) => failed.push(reason),
            Err(error) => return Err(error),
        }
        progress(Progress {
            stage: "holes",
            done: number + 1,
            total: places.len(),
        });
    }
    if repeats.is_empty() {
        let reason = failed.into_iter().next().unwrap_or_default();
        return Err(EvaluationError::NotFilled(reason));
    }
    Ok(Evaluation::new(step, repeats, failed))
}

/// Completes and judges one hole.
fn evaluate_hole(
    scan: &Scan,
    mesh: &TriMesh,
    hole: &Hole,
    params: &EvaluationParams,
    step: f64,
    progress: &mut dyn FnMut(Progress),
) -> Result<Repeat, EvaluationError> {
    let ids = hole.loops();
    if ids.is_empty() {
        return Err(EvaluationError::NotFilled(
            "the cut left no boundary loop".to_owned(),
        ));
    }
    let complete_params = CompleteParams {
        holes: crate::completion::HoleChoice::Ids(ids),
        extend: false,
        ..params.complete.clone()
    };
    let since = Instant::now();
    let completion = complete(&hole.scan, &complete_params, progress)?;
    let seconds = since.elapsed().as_secs_f64();
    if let Some(skipped) = completion.report.skipped.first() {
        return Err(EvaluationError::NotFilled(skipped.reason.clone()));
    }
    let mut judged = Judged::new(
        &completion,
        hole.scan.vertices.rows,
        scan,
        &params.complete.fit,
    )?;
    if params.fill == FillKind::Smooth {
        judged.make_smooth();
    }
    let field = judged.field(step);
    let piece = judged.piece();
    let known = judged.known();
    let pieces = field.pieces(&known, field.area(&piece), params.pieces, params.seed);
    if pieces.len() < LEAST_PIECES.min(params.pieces) {
        return Err(EvaluationError::NoRoom {
            holes: params.pieces,
            places: pieces.len(),
        });
    }
    let calibration = Calibration::new(&field, &known, &pieces, &mut |done| {
        progress(Progress {
            stage: "true pieces",
            done,
            total: pieces.len(),
        });
    });
    let judgement = calibration.judge(&field.figures(&piece, &known));
    let reference: Vec<u32> = (0u32..)
        .zip(&known)
        .filter(|(_, known)| **known)
        .map(|(v, _)| v)
        .collect();
    let areal = (field.areal(&reference)).zip(field.areal(&piece));
    let areas = piece
        .iter()
        .map(|v| field.area(&[*v]))
        .collect::<Vec<f64>>();
    Ok(Repeat {
        hole: hole.report(mesh),
        completed_vertices: piece.len(),
        heights_over: judged.heights_over(),
        left_out: judged.left_out(),
        calibration_pieces: calibration.pieces(),
        against_truth: truth::compare(mesh, hole, &judged, &piece, &areas),
        original: areal.map(|(original, _)| original),
        completed: areal.map(|(_, completed)| completed),
        color_correlation: judged.colors.as_ref().map(|colors| {
            stats::compare_colors(colors, &judged.originals(), &judged.completed)
                .map(|channel| channel.correlation)
        }),
        copies: copies(&judged.mesh, &judged.sources, step),
        judgement,
        seconds,
    })
}

#[cfg(test)]
mod tests;
