//! Fills of small scans, judged.

use crate::completion::{CompleteParams, CompletionError};
use crate::likeness::Measure;
use crate::mesh::check;
use crate::scan::Scan;
use crate::synth::{Kind, Part, SynthParams};

use super::hole::Hole;
use super::{Evaluation, EvaluationError, EvaluationParams, FillKind, HeightsOver, evaluate};

fn synthetic(kind: Kind, vertices: usize) -> Scan {
    let params = SynthParams {
        kind,
        vertices,
        part: Part::default(),
        ..SynthParams::default()
    };
    crate::synth::scan(&params).unwrap().scan
}

fn params(fill: FillKind) -> EvaluationParams {
    EvaluationParams {
        fill,
        repeat: 1,
        pieces: 60,
        complete: CompleteParams {
            window: Some(4),
            sites: 1024,
            ..CompleteParams::default()
        },
        ..EvaluationParams::default()
    }
}

fn evaluated(scan: &Scan, params: &EvaluationParams) -> Evaluation {
    evaluate(scan, params, &mut |_| {}).unwrap()
}

#[test]
fn a_hole_has_one_rim_and_what_was_there() {
    let scan = synthetic(Kind::Bark, 3000);
    let mesh = scan.mesh();
    let step = crate::mesh::median_edge(&mesh).unwrap();
    let discs = super::Discs::new(&mesh, &vec![true; mesh.positions.len()], step);
    let mut rng = crate::rng::Rng::new(1, crate::rng::Stage::Evaluation, 0);
    let area = 0.04 * discs.area();
    for disc in discs.random(area, 5, &mut rng) {
        let hole = Hole::cut(&scan, &mesh, &disc);
        let cut = hole.scan.mesh();
        assert_eq!(check(&cut), Ok(()));
        assert_eq!(hole.loops().len(), 1);
        let removed = hole.removed.iter().filter(|removed| **removed).count();
        assert!(removed >= disc.len() && removed < disc.len() + 5);
        assert_eq!(cut.positions.len() + removed, mesh.positions.len());
        assert_eq!(
            cut.triangles.len() + hole.triangles(&mesh).count(),
            mesh.triangles.len()
        );
        // The faces at the rim belong to it, too.
        let report = hole.report(&mesh);
        assert!(report.area > area && report.area < 1.5 * area);
    }
}

#[test]
fn a_smooth_fill_of_stochastic_relief_is_near_to_the_truth_and_caught() {
    let scan = synthetic(Kind::Noise, 4000);
    let evaluation = evaluated(&scan, &params(FillKind::Smooth));
    let repeat = &evaluation.repeats[0];
    assert_eq!(repeat.heights_over, HeightsOver::Completed);
    assert_eq!(repeat.copies, None);
    assert!(repeat.sq_ratio().unwrap() < 1e-6);
    // As far from the truth as the truth is high: which is no more than chance would have.
    let truth = repeat.against_truth.unwrap();
    assert!((truth.rmse / truth.true_sq - 1.0).abs() < 0.3);
    assert!(repeat.rmse_over_sq().unwrap() < 1.4);
    assert!((truth.mean_integral_difference_percent + 100.0).abs() < 1.0);
    assert!(evaluation.overall.median > 1.0);
    for measure in [Measure::Laplacian, Measure::Variogram, Measure::Areal] {
        assert!(repeat.judgement.of(measure).unwrap().score > 1.0);
    }
}

#[test]
fn completed_waves_are_near_to_the_truth_and_far_better_than_a_smooth_fill() {
    let scan = synthetic(Kind::Waves, 4000);
    let completed = evaluated(&scan, &params(FillKind::Completed));
    let smooth = evaluated(&scan, &params(FillKind::Smooth));
    assert!(completed.repeats[0].rmse_over_sq().unwrap() < 0.5);
    assert!((completed.repeats[0].sq_ratio().unwrap() - 1.0).abs() < 0.2);
    assert!(completed.overall.median < 0.5 * smooth.overall.median);
    let copies = completed.repeats[0].copies.unwrap();
    assert_eq!(copies.vertices, completed.repeats[0].completed_vertices);
    assert!(copies.neighboring_edges > 0.1 && !copies.is_paste && !copies.is_garbage);
}

#[test]
fn colours_are_judged_where_there_are_some() {
    let scan = synthetic(Kind::Bark, 4000);
    let smooth = evaluated(&scan, &params(FillKind::Smooth));
    assert!(
        smooth.repeats[0]
            .judgement
            .of(Measure::Color)
            .unwrap()
            .score
            > 1.0
    );
    assert!(smooth.repeats[0].color_correlation.is_some());
}

#[test]
fn the_same_seed_gives_the_same_evaluation_and_another_one_other_holes() {
    let scan = synthetic(Kind::Noise, 3000);
    let fast = |seed| EvaluationParams {
        seed,
        ..params(FillKind::Smooth)
    };
    let figures = |seed| {
        let evaluation = evaluated(&scan, &fast(seed));
        (evaluation.repeats.into_iter())
            .map(|r| (r.hole, r.judgement))
            .collect::<Vec<_>>()
    };
    assert_eq!(figures(1), figures(1));
    assert_ne!(figures(1)[0].0, figures(2)[0].0);
}

#[test]
fn what_cannot_be_evaluated_is_refused_with_a_reason() {
    let scan = synthetic(Kind::Noise, 3000);
    let refused = |params: &EvaluationParams| evaluate(&scan, params, &mut |_| {}).unwrap_err();
    let plain = EvaluationParams::default();
    for hole in [0.0, -1.0, 0.3, f64::NAN] {
        let error = refused(&EvaluationParams {
            hole,
            ..plain.clone()
        });
        assert!(error.to_string().starts_with("--hole must be"), "{error}");
    }
    let none = EvaluationParams {
        repeat: 0,
        ..plain.clone()
    };
    assert!(matches!(
        refused(&none),
        EvaluationError::Parameter {
            name: "--repeat",
            ..
        }
    ));
    let few = EvaluationParams {
        pieces: 10,
        ..plain.clone()
    };
    assert!(refused(&few).to_string().contains("at least 60"));
    let complete = CompleteParams {
        window: Some(0),
        ..CompleteParams::default()
    };
    assert!(matches!(
        refused(&EvaluationParams { complete, ..plain }),
        EvaluationError::Completion(CompletionError::Parameter { .. })
    ));
    let mut points = scan.clone();
    points.faces = crate::mesh::Csr::default();
    points.face_channels.rows = 0;
    let error = evaluate(&points, &EvaluationParams::default(), &mut |_| {}).unwrap_err();
    assert_eq!(error, EvaluationError::NoFaces);
}
