//! The door: starts, search, refinement, choice.

use nalgebra::Point3;
use rayon::prelude::*;

use super::params::{BaseChoice, FitParams, Loss};
use super::refine::{Effort, Refined, refine};
use super::report::{Candidate, FitReport};
use super::robust::{LEAST_SHARE, TUKEY_REACH};
use super::samples::{Normalized, Samples};
use super::select::{Fitted, criteria, degenerate, parameters};
use super::{BaseKind, BaseSurface, Cylinder, FitError};
use super::{cone, cylinder, plane, sphere};
use crate::mesh::TriMesh;
use crate::rng::{Rng, Stage};

/// Vertices on which every start is scored.
const SCORING_VERTICES: usize = 400;

/// Vertices on which the best starts are refined.
const SEARCH_VERTICES: usize = 2000;

/// Starts that are refined: the first ones, which are algebraic fits to all vertices, and those
/// with the best scores.
const ALGEBRAIC_STARTS: usize = 5;
const SCORED_STARTS: usize = 6;

/// The stream of random numbers behind those of the kinds.
const RANKING_STREAM: u32 = BaseKind::Cone as u32 + 1;

const SEARCH_EFFORT: Effort = Effort {
    iterations: 14,
    tolerance: 1e-3,
    concentrations: 0,
};

/// Vertices to which all kinds are fitted to be compared: their parameters are then within a few
/// thousandths of the relief of those of all vertices.
const RANKING_VERTICES: usize = 20_000;

/// All kinds are fitted as well as this to be compared; the chosen one goes on.
const RANKING_EFFORT: Effort = Effort {
    iterations: 20,
    tolerance: 1e-5,
    concentrations: 0,
};

/// Largest change of any height, as a share of half the diagonal, at which the fit has converged:
/// parameters of a sixty degree patch are then good to about 1e-10.
const TOLERANCE: f64 = 1e-11;

/// Centers and tips farther away, in half diagonals, leave less than nine digits of the heights.
const MAX_DISTANCE: f64 = 1e7;

/// Fits a base surface to the vertices of a mesh that its triangles use.
///
/// Each kind is fitted by its orthogonal distance: algebraic fits and random minimal subsets are
/// scored on a few hundred vertices, the best are refined on a few thousand, the best of these of
/// each kind on up to 20 000, and the kind that is chosen on all, by Levenberg–Marquardt steps with
/// iteratively reweighted vertices ([`super::Loss::Tukey`]). A surface is found if at least about 40 % of the mesh's area
/// belongs to it. Where relief is one-sided, the fit may settle on the level that most of the
/// vertices share (the land between a golf ball's dimples).
///
/// With [`BaseChoice::Auto`] the kind with the least 2 n ρ̄ + k max(ln n, 3) is chosen ([`Candidate`]): a
/// Bayesian information criterion in which n is not the number of vertices, whose heights are
/// correlated in any relief, but the number of patches of the mesh on which the best-fitting
/// surface's heights have one sign. Few patches are little evidence: a gentle bend under a few bumps
/// of its own size is taken for relief of the simpler kind. Surfaces that a simpler kind describes
/// as well are excluded ([`super::Degenerate`]).
///
/// The result does not depend on the number of threads. The plane's normal points to the side that
/// the triangles face; the points on plane and cylinder axis are next to [`TriMesh::centroid`]; the
/// largest component of a cylinder's axis is positive.
///
/// # Errors
/// If the vertices are too few, not finite, at one place or on one line, if a triangle names a vertex
/// that does not exist, or if the kind asked for is not determined (a sphere through the vertices of
/// a plane). That the iteration did not converge, or that the surface fits badly,
/// is in the report.
pub fn fit(mesh: &TriMesh, params: &FitParams) -> Result<FitReport, FitError> {
    fit_part(&mesh.positions, &mesh.triangles, params)
}

/// As [`fit`], to the part of a mesh that some of its triangles make up.
///
/// # Errors
/// As [`fit`].
pub fn fit_part(
    positions: &[Point3<f64>],
    triangles: &[[u32; 3]],
    params: &FitParams,
) -> Result<FitReport, FitError> {
    if let Some(scale) = params.scale
        && !(scale.is_finite() && scale > 0.0)
    {
        return Err(FitError::BadScale(scale));
    }
    let mesh = Normalized::new(positions, triangles, params.weighting)?;
    let mut fits = fit_kinds(&mesh, params)?;
    let mut heights: Vec<Vec<f64>> = fits
        .par_iter()
        .map(|f| mesh.samples.heights(&f.surface))
        .collect();
    let excluded: Vec<_> = fits
        .iter()
        .map(|f| degenerate(&f.surface, &mesh.samples))
        .collect();
    let fitted: Vec<_> = (0..fits.len())
        .map(|i| Fitted {
            kind: fits[i].surface.kind(),
            heights: &heights[i],
            excluded: excluded[i].is_some(),
        })
        .collect();
    let (criteria, independent) = criteria(&mesh, &fitted);
    let mut order: Vec<usize> = (0..fits.len()).collect();
    order.sort_by(|&a, &b| {
        let excluded = excluded[a].is_some().cmp(&excluded[b].is_some());
        excluded.then(criteria[a].total_cmp(&criteria[b]))
    });
    let best = order[0];
    finish(&mut fits[best], &mesh, params);
    heights[best] = mesh.samples.heights(&fits[best].surface);
    let candidate = |&i: &usize| Candidate {
        base: oriented(&mesh, &fits[i].surface),
        rms: mesh.unit * rms(&heights[i], &mesh.samples.weights),
        scale: mesh.unit * fits[i].sigma,
        criterion: criteria[i],
        degenerate: excluded[i],
        reason: fits[i].reason,
    };
    let ranking = order.iter().map(candidate).collect();
    Ok(report(
        &mesh,
        &fits[best],
        &heights[best],
        independent,
        ranking,
    ))
}

/// The best surface of each kind asked for; at least one.
fn fit_kinds(mesh: &Normalized, params: &FitParams) -> Result<Vec<Refined>, FitError> {
    let found = mesh.samples.points.len();
    let kinds = match params.base {
        BaseChoice::Kind(kind) => vec![kind],
        BaseChoice::Auto | BaseChoice::FreeForm => {
            let all = [
                BaseKind::Plane,
                BaseKind::Sphere,
                BaseKind::Cylinder,
                BaseKind::Cone,
            ];
            all.into_iter()
                .filter(|k| parameters(*k) <= found)
                .collect()
        }
    };
    let needed = kinds.first().map_or(3, |k| parameters(*k));
    if found < needed {
        return Err(FitError::TooFewVertices { found, needed });
    }
    let sigma = params.scale.map(|s| s / mesh.unit);
    let effort = Effort {
        iterations: params.max_iterations.min(RANKING_EFFORT.iterations),
        ..RANKING_EFFORT
    };
    let samples = &mesh.samples;
    let search = |kind, cylinder: Option<&Cylinder>| search(samples, kind, cylinder, params, sigma);
    let round = kinds
        .iter()
        .any(|k| matches!(k, BaseKind::Cylinder | BaseKind::Cone));
    let cylinder = match round.then(|| search(BaseKind::Cylinder, None)).flatten() {
        Some(BaseSurface::Cylinder(cylinder)) => Some(cylinder),
        _ => None,
    };
    let mut rng = Rng::new(params.seed, Stage::Fit, RANKING_STREAM);
    let many = samples.thinned(RANKING_VERTICES, &mut rng);
    let fits: Vec<Option<Refined>> = kinds
        .par_iter()
        .map(|&kind| {
            let start = match kind {
                BaseKind::Cylinder => cylinder.map(BaseSurface::Cylinder),
                _ => search(kind, cylinder.as_ref()),
            };
            let refined = refine(&start?, &many, params.loss, sigma, effort);
            is_usable(&refined.surface).then_some(refined)
        })
        .collect();
    let fits: Vec<_> = fits.into_iter().flatten().collect();
    if fits.is_empty() {
        return Err(FitError::Undetermined(kinds[0]));
    }
    Ok(fits)
}

/// Takes the fit that was good enough for comparison to the minimum.
fn finish(fit: &mut Refined, mesh: &Normalized, params: &FitParams) {
    let effort = Effort {
        iterations: params.max_iterations,
        tolerance: TOLERANCE,
        concentrations: 0,
    };
    let sigma = params.scale.map(|s| s / mesh.unit);
    let finished = refine(&fit.surface, &mesh.samples, params.loss, sigma, effort);
    if is_usable(&finished.surface) {
        *fit = finished;
    }
}

/// The best start of a kind, refined on some of the vertices.
fn search(
    samples: &Samples,
    kind: BaseKind,
    cylinder: Option<&Cylinder>,
    params: &FitParams,
    sigma: Option<f64>,
) -> Option<BaseSurface> {
    // A stream for each kind, so that a kind's result does not depend on the others asked for.
    let mut rng = Rng::new(params.seed, Stage::Fit, kind as u32);
    let thin = samples.thinned(SEARCH_VERTICES, &mut rng);
    let few = thin.thinned(SCORING_VERTICES, &mut rng);
    let starts = match kind {
        BaseKind::Plane => plane::starts(&thin, params.starts, &mut rng),
        BaseKind::Sphere => sphere::starts(&thin, params.starts, &mut rng),
        BaseKind::Cylinder => cylinder::starts(&thin, params.starts, &mut rng),
        BaseKind::Cone => cone::starts(&thin, cylinder, params.starts, &mut rng),
    };
    let mut scored: Vec<(f64, usize)> = starts
        .iter()
        .map(|s| score(&few, s, params.loss))
        .zip(0..)
        .filter(|(score, _)| score.is_finite())
        .collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // The random ones are first drawn to the core of what they touch, the algebraic ones not.
    let concentrating = Effort {
        concentrations: 4,
        ..SEARCH_EFFORT
    };
    let algebraic = (0..starts.len().min(ALGEBRAIC_STARTS)).map(|i| (i, SEARCH_EFFORT));
    let scored = scored.iter().take(SCORED_STARTS);
    let chosen: Vec<_> = algebraic
        .chain(scored.map(|s| (s.1, concentrating)))
        .collect();
    let refined: Vec<_> = chosen
        .into_par_iter()
        .map(|(i, effort)| refine(&starts[i], &thin, params.loss, sigma, effort))
        .filter(|r| is_usable(&r.surface))
        .map(|r| (quality(&thin, &r, params.loss), r.surface))
        .filter(|(quality, _)| quality.is_finite())
        .collect();
    (refined.into_iter())
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, surface)| surface)
}

/// How far the samples are from a start; the lower, the better.
fn score(samples: &Samples, start: &BaseSurface, loss: Loss) -> f64 {
    let heights = samples.heights(start);
    match loss {
        Loss::LeastSquares => rms(&heights, &samples.weights),
        Loss::Tukey => {
            let mut sizes: Vec<f64> = heights.iter().map(|h| h.abs()).collect();
            // The sizes are at most a few hundred: rounding down the index is all that is meant.
            let share = (0..sizes.len())
                .take_while(|i| (*i as f64) < LEAST_SHARE * sizes.len() as f64)
                .count();
            let index = share.min(sizes.len() - 1);
            *sizes.select_nth_unstable_by(index, f64::total_cmp).1
        }
    }
}

/// What is least at the best of several minima.
fn quality(samples: &Samples, refined: &Refined, loss: Loss) -> f64 {
    match loss {
        Loss::LeastSquares => rms(&samples.heights(&refined.surface), &samples.weights),
        Loss::Tukey => refined.sigma,
    }
}

fn rms(heights: &[f64], weights: &[f64]) -> f64 {
    let sum: f64 = heights.iter().zip(weights).map(|(h, w)| w * h * h).sum();
    (sum / weights.iter().sum::<f64>()).sqrt()
}

/// Whether heights over the surface can be computed: finite and not from too far away.
fn is_usable(surface: &BaseSurface) -> bool {
    let far = match surface {
        BaseSurface::Plane(plane) => plane.point.coords.norm(),
        BaseSurface::Sphere(sphere) => sphere.center.coords.norm().max(sphere.radius),
        BaseSurface::Cylinder(cylinder) => cylinder.point.coords.norm().max(cylinder.radius),
        BaseSurface::Cone(cone) => cone.apex.coords.norm(),
    };
    let foot = surface.foot(&Point3::origin());
    far < MAX_DISTANCE && foot.height.is_finite() && foot.normal.iter().all(|x| x.is_finite())
}

/// In the mesh's coordinates; a plane's point next to the centroid and its normal to the side that
/// the triangles face.
fn oriented(mesh: &Normalized, surface: &BaseSurface) -> BaseSurface {
    let mut surface = *surface;
    if let BaseSurface::Plane(plane) = &mut surface {
        let facing = plane.normal.dot(&mesh.facing);
        let largest = plane.normal[plane.normal.iamax()];
        if facing < 0.0 || (facing == 0.0 && largest < 0.0) {
            plane.normal = -plane.normal;
        }
    }
    mesh.to_mesh(&surface)
}

fn report(
    mesh: &Normalized,
    best: &Refined,
    heights: &[f64],
    independent: f64,
    ranking: Vec<Candidate>,
) -> FitReport {
    let weights = &mesh.samples.weights;
    let base = ranking[0].base;
    // The plane may have been turned over since.
    let sign = match (&base, &best.surface) {
        (BaseSurface::Plane(a), BaseSurface::Plane(b)) if a.normal.dot(&b.normal) < 0.0 => -1.0,
        _ => 1.0,
    };
    let total: f64 = weights.iter().sum();
    let mean: f64 = heights.iter().zip(weights).map(|(h, w)| w * h).sum::<f64>() / total;
    let (near, near_weights): (Vec<f64>, Vec<f64>) = heights
        .iter()
        .zip(weights)
        .filter(|(h, _)| h.abs() <= TUKEY_REACH * best.sigma)
        .unzip();
    let near_total: f64 = near_weights.iter().sum();
    FitReport {
        base,
        rms: ranking[0].rms,
        mean_height: sign * mesh.unit * mean,
        max_residual: mesh.unit * heights.iter().fold(0.0, |m: f64, h| m.max(h.abs())),
        scale: mesh.unit * best.sigma,
        inlier_share: near_total / total,
        inlier_rms: if near_total > 0.0 {
            mesh.unit * rms(&near, &near_weights)
        } else {
            ranking[0].rms
        },
        diagonal: 2.0 * mesh.unit,
        vertices: heights.len(),
        iterations: best.iterations,
        reason: best.reason,
        independent,
        ranking,
    }
}
