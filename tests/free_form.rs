//! Scans that no plane, sphere, cylinder or cone lies under, completed on free form.

mod common;

use std::collections::BTreeMap;

use common::{MAJOR, MINOR, completed, cut, loops, real, synthetic, to_scan, torus, values};
use nalgebra::{Point3, Vector3};
use relievo::base::{BaseChoice, FitParams, Form};
use relievo::completion::{
    CompleteParams, CompletionError, HoleChoice, Method, complete, remembered_base,
    remembered_free_form,
};
use relievo::mesh::{LoopKind, check, euler_characteristic, triangle_normal};
use relievo::sampling::{SpacingRule, edge_spacing};
use relievo::stats;
use relievo::synth::{Kind, Part};

/// How far a point is from the torus without its bumps.
fn off_torus(p: &Point3<f64>) -> f64 {
    (p.x.hypot(p.y) - MAJOR).hypot(p.z) - MINOR
}

fn outside() -> Point3<f64> {
    Point3::new(MAJOR + MINOR, 0.0, 0.0)
}

fn free_form() -> CompleteParams {
    CompleteParams {
        fit: FitParams {
            base: BaseChoice::FreeForm,
            ..FitParams::default()
        },
        ..CompleteParams::default()
    }
}

#[test]
fn a_hole_in_a_torus_gets_its_shape_and_its_bumps() {
    let scan = cut(&to_scan(&torus()), |p| (p - outside()).norm() > 7.0);
    let (completion, mesh) = completed(&scan, &CompleteParams::default());
    assert_eq!(euler_characteristic(&mesh), 0);
    assert_eq!(loops(&mesh), []);
    let report = &completion.report;
    assert!(!report.base_fits);
    let form = report.free_form.as_ref().unwrap();
    assert_eq!(
        report.filled[0].own_base,
        Some(Form::Free(
            remembered_free_form(&completion.scan).unwrap().form
        ))
    );
    assert!(
        form.choice.is_some() && form.rms > 0.05 && form.rms < 0.25,
        "{form:?}"
    );
    // The torus bulges by 1 to 2 over the hole's rim; bumps are 0.25 high.
    let new = &mesh.positions[scan.vertices.rows..];
    let worst = new.iter().map(|p| off_torus(p).abs()).fold(0.0, f64::max);
    assert!(worst < 0.6, "{worst}");
    let mean = new.iter().map(off_torus).sum::<f64>() / new.len() as f64;
    assert!(mean.abs() < 0.15, "{mean}");
    let rms = (new
        .iter()
        .map(|p| (off_torus(p) - mean).powi(2))
        .sum::<f64>()
        / new.len() as f64)
        .sqrt();
    assert!(
        (0.07..0.2).contains(&rms),
        "bumps have 0.125, the fill {rms}"
    );
}

#[test]
fn the_fill_is_not_folded_and_heights_are_told() {
    let scan = cut(&to_scan(&torus()), |p| (p - outside()).norm() > 9.0);
    let (completion, mesh) = completed(&scan, &CompleteParams::default());
    let first = scan.vertices.rows;
    for t in &mesh.triangles {
        if t.iter().any(|v| *v as usize >= first) {
            let corners = t.map(|v| mesh.positions[v as usize]);
            let middle = Point3::from(corners.iter().map(|p| p.coords).sum::<Vector3<f64>>() / 3.0);
            let ring = Vector3::new(middle.x, middle.y, 0.0).normalize() * MAJOR;
            let outward = (middle.coords - ring).normalize();
            let normal = triangle_normal(corners).normalize();
            assert!(normal.dot(&outward) > 0.3, "{t:?} at {middle}");
        }
    }
    let heights = values(&completion.scan, "height");
    assert!(heights.iter().all(|h| h.is_finite()));
    assert_eq!(remembered_base(&completion.scan), None);
    let comparison = stats::compare(&completion.scan).unwrap();
    assert!(matches!(comparison.base, Form::Free(_)));
    let ratio = comparison.roughness_ratio.unwrap();
    assert!((0.6..1.5).contains(&ratio), "{ratio}");
}

#[test]
fn what_was_asked_for_is_done_where_a_primitive_would_fit_too() {
    for kind in [Kind::Bricks, Kind::Waves] {
        let scan = synthetic(kind, Part::hole(0.05));
        let edges = edge_spacing(&scan.mesh(), SpacingRule::Scan).unwrap();
        let wavelength = 12.0 * edges.median;
        let params = CompleteParams {
            form_wavelength: Some(wavelength),
            ..free_form()
        };
        let (completion, mesh) = completed(&scan, &params);
        let report = &completion.report;
        assert!(!report.base_fits);
        let ratio = stats::compare(&completion.scan)
            .unwrap()
            .roughness_ratio
            .unwrap();
        assert!(
            (0.5..1.5).contains(&ratio),
            "{kind}: Sq {ratio} of the original"
        );
        let form = report.free_form.as_ref().unwrap();
        assert!((form.wavelength - wavelength).abs() < 1e-12 && form.choice.is_none());
        assert_eq!(
            loops(&mesh)
                .iter()
                .filter(|l| l.kind == LoopKind::Hole)
                .count(),
            0
        );
    }
}

#[test]
fn what_free_form_cannot_do_is_refused_with_a_remedy() {
    let scan = synthetic(Kind::Waves, Part::hole(0.05));
    let refused = |params: CompleteParams| complete(&scan, &params, &mut |_| {}).unwrap_err();
    let paper = CompleteParams {
        method: Method::Paper,
        ..free_form()
    };
    assert_eq!(refused(paper), CompletionError::FreeFormByPaper);
    let extending = CompleteParams {
        extend: true,
        ..free_form()
    };
    assert_eq!(refused(extending), CompletionError::FreeFormHasNoEnd);
    let wavelength = CompleteParams {
        form_wavelength: Some(-1.0),
        ..free_form()
    };
    assert!(
        refused(wavelength)
            .to_string()
            .contains("--form-wavelength")
    );
}

#[test]
fn several_holes_and_an_island_are_completed_together() {
    let other = Point3::new(-MAJOR - MINOR, 0.0, 0.0);
    let scan = cut(&to_scan(&torus()), |p| {
        let ring = (p - outside()).norm();
        !(3.0..8.0).contains(&ring) && (p - other).norm() > 5.0
    });
    let before = loops(&scan.mesh());
    assert_eq!(before.len(), 3);
    let (completion, mesh) = completed(&scan, &CompleteParams::default());
    assert_eq!(euler_characteristic(&mesh), 0);
    assert_eq!(loops(&mesh), []);
    let mut counts: Vec<usize> = completion
        .report
        .filled
        .iter()
        .map(|hole| hole.loops.len())
        .collect();
    counts.sort_unstable();
    assert_eq!(counts, [1, 2]);
}

#[test]
fn the_number_of_threads_does_not_show() {
    let scan = cut(&to_scan(&torus()), |p| (p - outside()).norm() > 5.0);
    let positions = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| completed(&scan, &CompleteParams::default()).1.positions)
    };
    assert_eq!(positions(1), positions(3));
}

#[test]
fn the_base_holes_of_a_real_figure_are_closed_without_folds() {
    let Some(scan) = real("holes/bun_zipper.ply") else {
        return;
    };
    let (completion, mesh) = completed(&scan, &CompleteParams::default());
    assert_eq!(completion.report.filled.len(), 5);
    assert_eq!(loops(&mesh), []);
    // Hardly a triangle of the fill faces against the one beside it, and the fill as a whole faces down: the
    // bunny stands on it.
    let first = scan.vertices.rows;
    let is_new = |t: &[u32; 3]| t.iter().any(|v| *v as usize >= first);
    let normal = |t: &[u32; 3]| triangle_normal(t.map(|v| mesh.positions[v as usize]));
    let mut by_edge = BTreeMap::new();
    let (mut folds, mut new, mut down, mut area) = (0, 0, 0.0, 0.0);
    for t in &mesh.triangles {
        for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            if let Some(other) = by_edge.insert([a.min(b), a.max(b)], t)
                && (is_new(t) || is_new(other))
            {
                folds += usize::from(normal(t).dot(&normal(other)) < 0.0);
            }
        }
        if is_new(t) {
            new += 1;
            down -= normal(t).y;
            area += normal(t).norm();
        }
    }
    assert!(100 * folds <= new, "{folds} folds in {new} triangles");
    assert!(down > 0.7 * area, "{}", down / area);
}

#[test]
fn all_holes_are_filled_once_and_outer_rims_left_with_a_reason() {
    // Half a torus, with an island in a hole.
    let scan = cut(&to_scan(&torus()), |p| {
        let ring = (p - outside()).norm();
        p.x > -10.0 && !(3.0..8.0).contains(&ring)
    });
    let params = CompleteParams {
        holes: HoleChoice::All,
        ..CompleteParams::default()
    };
    let completion = complete(&scan, &params, &mut |_| {}).unwrap();
    let mesh = completion.scan.mesh();
    assert_eq!(check(&mesh), Ok(()));
    assert_eq!(loops(&mesh).len(), 2, "both ends of the tube stay open");
    let report = &completion.report;
    assert_eq!(report.filled.len(), 1);
    assert_eq!(report.filled[0].loops.len(), 2);
    assert!(
        report
            .skipped
            .iter()
            .all(|hole| hole.reason.contains("--holes"))
    );
}
