//! Scan to completed scan through the library, on small scans with known truth.

mod common;

use std::f64::consts::TAU;

use common::{
    assert_only_appended, cut, holed, loops, real, synthetic, to_scan, turned_over, values,
};
use nalgebra::{Point3, Vector3};
use relievo::base::{BaseChoice, BaseKind, BaseSurface, FitParams};
use relievo::completion::{
    COMPLETED, CompleteParams, Completion, CompletionError, HoleChoice, Method, SOURCE, complete,
    remembered_base,
};
use relievo::mesh::{Adjacency, LoopKind, TriMesh, check, euler_characteristic, triangle_area};
use relievo::sampling::SpacingRule;
use relievo::scan::{Column, Format, Scan, WriteOptions, write_to};
use relievo::stats;
use relievo::synth::{Kind, Part};

/// For tests to which the quality of the matches does not matter.
fn quick() -> CompleteParams {
    CompleteParams {
        window: Some(2),
        rotations: Some(1),
        ..CompleteParams::default()
    }
}

fn extending() -> CompleteParams {
    CompleteParams {
        extend: true,
        ..quick()
    }
}

/// Completes, and checks what holds for every completion.
#[track_caller]
fn completed(scan: &Scan, params: &CompleteParams) -> (Completion, TriMesh) {
    let (completion, mesh) = common::completed(scan, params);
    assert!(
        mesh.used_vertices()[scan.vertices.rows..]
            .iter()
            .all(|used| *used),
        "a new vertex has no triangle"
    );
    let counts = completion.report.counts;
    assert_eq!(counts.original_vertices, scan.vertices.rows);
    assert_eq!(
        counts.original_vertices + counts.completed_vertices,
        completion.scan.vertices.rows
    );
    assert_eq!(
        counts.original_faces + counts.completed_faces,
        completion.scan.faces.len()
    );
    assert_near_base(scan, &completion);
    (completion, mesh)
}

/// New vertices are as far from the base as originals are, and their `height` says how far.
#[track_caller]
fn assert_near_base(scan: &Scan, completion: &Completion) {
    let base = remembered_base(&completion.scan).expect("the base is noted");
    let height = |p: &Point3<f64>| {
        let foot = base.surface.foot(p);
        (p - foot.point).dot(&foot.normal)
    };
    let positions = completion.scan.positions();
    let (old, new) = positions.split_at(scan.vertices.rows);
    let largest = |points: &[Point3<f64>]| {
        points
            .iter()
            .map(height)
            .fold(0.0, |a: f64, h| a.max(h.abs()))
    };
    assert!(
        largest(new) <= 1.1 * largest(old),
        "new vertices are {} from the base, originals {}",
        largest(new),
        largest(old)
    );
    let inward = completion.report.fit.base.kind();
    for (row, (p, noted)) in positions
        .iter()
        .zip(values(&completion.scan, "height"))
        .enumerate()
    {
        assert!(
            (height(p).abs() - noted.abs()).abs() < 1e-3 * largest(old),
            "vertex {row} on a {inward:?}: {} from the base, {noted} noted",
            height(p)
        );
    }
}

fn holes_in(mesh: &TriMesh) -> usize {
    (loops(mesh).iter())
        .filter(|l| l.kind == LoopKind::Hole)
        .count()
}

fn area(mesh: &TriMesh) -> f64 {
    (0..mesh.triangles.len())
        .map(|f| triangle_area(mesh.corners(f)))
        .sum()
}

/// Every colour of a new vertex lies between the extremes of the originals.
#[track_caller]
fn assert_colors_in_range(scan: &Scan, completion: &Completion) {
    let old = scan.colors().expect("the scan has colours");
    let new = completion.scan.colors().expect("colours are kept");
    for channel in 0..3 {
        let low = old.iter().map(|c| c[channel]).fold(f64::INFINITY, f64::min);
        let high = old.iter().map(|c| c[channel]).fold(0.0, f64::max);
        for color in &new[old.len()..] {
            assert!((low..=high).contains(&color[channel]), "{color:?}");
        }
    }
}

fn as_ply(scan: &Scan) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_to(
        scan,
        &mut bytes,
        Format::Ply,
        &WriteOptions::default(),
        "test",
    )
    .expect("memory takes it");
    bytes
}

#[test]
fn half_a_golf_ball_becomes_a_whole_one() {
    let half = synthetic(Kind::GolfBall, Part::view(Vector3::z()));
    let (completion, mesh) = completed(&half, &extending());
    assert_eq!(euler_characteristic(&mesh), 2);
    assert_eq!(loops(&mesh), []);
    assert_eq!(completion.report.fit.base.kind(), BaseKind::Sphere);
    let whole = synthetic(Kind::GolfBall, Part::FULL).mesh();
    assert!(
        (area(&mesh) / area(&whole) - 1.0).abs() < 0.05,
        "{}",
        area(&mesh)
    );
}

#[test]
fn holes_in_every_kind_of_surface_are_closed() {
    for (kind, base, euler) in [
        (Kind::GolfBall, BaseKind::Sphere, 2),
        (Kind::Waves, BaseKind::Plane, 1),
        (Kind::Noise, BaseKind::Plane, 1),
        (Kind::Bricks, BaseKind::Plane, 1),
        (Kind::Bark, BaseKind::Cylinder, 0),
        (Kind::Column, BaseKind::Cylinder, 0),
    ] {
        let scan = holed(kind);
        let (completion, mesh) = completed(&scan, &quick());
        assert_eq!(completion.report.fit.base.kind(), base, "{kind}");
        assert_eq!(euler_characteristic(&mesh), euler, "{kind}");
        assert_eq!(holes_in(&mesh), 0, "{kind}");
        let whole = synthetic(kind, Part::FULL).mesh();
        assert!(
            (area(&mesh) / area(&whole) - 1.0).abs() < 0.05,
            "{kind}: {}",
            area(&mesh)
        );
        if matches!(kind, Kind::Bricks | Kind::Bark) {
            assert_colors_in_range(&scan, &completion);
        }
    }
}

#[test]
fn the_mean_integral_of_a_golf_ball_is_met() {
    let scan = synthetic(Kind::GolfBall, Part::hole(0.05));
    let by_paper = CompleteParams {
        method: Method::Paper,
        ..CompleteParams::default()
    };
    let (completion, _) = completed(&scan, &by_paper);
    let comparison = stats::compare(&completion.scan).unwrap();
    let difference = comparison.mean_integral_difference_percent;
    assert!(difference.abs() < 20.0, "{difference} %");
    // Some fifty new vertices are few dimples: single completions scatter by as much as their mean.
    let differences = (0..4u32).map(|seed| {
        let params = CompleteParams {
            seed,
            ..CompleteParams::default()
        };
        let (completion, _) = completed(&scan, &params);
        let comparison = stats::compare(&completion.scan).unwrap();
        comparison.mean_integral_difference_percent
    });
    let difference = differences.sum::<f64>() / 4.0;
    assert!(difference.abs() < 20.0, "{difference} %");
}

#[test]
fn a_gap_all_around_a_trunk_is_an_interior_hole() {
    let whole = synthetic(Kind::Bark, Part::FULL);
    let z: Vec<f64> = values(&whole, "z");
    let low = z.iter().copied().fold(f64::INFINITY, f64::min);
    let high = z.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let third = (high - low) / 3.0;
    let ends = cut(&whole, |p| p.z < low + third || p.z > high - third);
    assert_eq!(Adjacency::new(&ends.mesh()).components().1, 2);
    let (completion, mesh) = completed(&ends, &quick());
    assert_eq!(completion.report.filled.len(), 1);
    assert_eq!(completion.report.filled[0].loops.len(), 2);
    assert_eq!(euler_characteristic(&mesh), 0);
    assert_eq!(loops(&mesh).len(), 2, "the ends of the trunk stay open");
    assert_eq!(Adjacency::new(&mesh).components().1, 1);
    assert_colors_in_range(&ends, &completion);
}

/// The extension covers what lies between two pieces of a trunk, and covers nothing twice.
#[test]
fn two_pieces_of_a_trunk_are_extended_into_one() {
    let full = synthetic(Kind::Bark, Part::FULL);
    let height = loops(&full.mesh())
        .iter()
        .flat_map(|l| l.vertices.clone())
        .map(|v| full.positions()[v as usize].z.abs())
        .fold(0.0, f64::max);
    let pieces = cut(&full, |p| p.z < -0.2 * height || p.z > 0.5 * height);
    for holes in [HoleChoice::Interior, HoleChoice::All] {
        let params = CompleteParams {
            holes,
            ..extending()
        };
        let (_, mesh) = completed(&pieces, &params);
        assert_eq!(euler_characteristic(&mesh), 0);
        assert_eq!(loops(&mesh).len(), 2);
    }
}

#[test]
fn one_side_of_a_trunk_becomes_a_tube() {
    let side = synthetic(Kind::Bark, Part::view(Vector3::x()));
    let (_, mesh) = completed(&side, &extending());
    assert_eq!(euler_characteristic(&mesh), 0);
    assert_eq!(loops(&mesh).len(), 2);
}

#[test]
fn an_l_shaped_plane_is_extended_to_its_rectangle() {
    let whole = synthetic(Kind::Waves, Part::FULL);
    let remainder = cut(&whole, |p| p.x < 0.0 || p.y < 0.0);
    let (_, mesh) = completed(&remainder, &extending());
    assert_eq!(euler_characteristic(&mesh), 1);
    assert_eq!(loops(&mesh).len(), 1);
    let (found, expected) = (area(&mesh), area(&whole.mesh()));
    assert!(
        (found / expected - 1.0).abs() < 0.05,
        "{found} of {expected}"
    );
}

/// Frustum of a cone with relief about z with the apex at the origin, open at both ends.
fn cone(height: impl Fn(f64, f64) -> f64) -> TriMesh {
    let (around, along) = (48u32, 24u32);
    let half_angle: f64 = 0.35;
    let mut mesh = TriMesh::default();
    for i in 0..along {
        for j in 0..around {
            let angle = TAU * f64::from(j) / f64::from(around);
            let distance = 60.0 + 2.5 * f64::from(i);
            let height = height(angle, distance);
            let radius = distance * half_angle.sin() + height * half_angle.cos();
            let z = distance * half_angle.cos() - height * half_angle.sin();
            mesh.positions
                .push(Point3::new(radius * angle.cos(), radius * angle.sin(), z));
        }
    }
    for i in 0..along - 1 {
        for j in 0..around {
            let v = |i, j| i * around + j % around;
            let [a, b, c, d] = [v(i, j), v(i, j + 1), v(i + 1, j), v(i + 1, j + 1)];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    mesh
}

/// The cone without a patch on its side.
fn with_hole(cone: &TriMesh) -> Scan {
    let middle = cone.positions[12 * 48 + 7];
    cut(&to_scan(cone), |p| (p - middle).norm() > 8.0)
}

#[test]
fn a_hole_in_a_cone_is_closed() {
    let scan = with_hole(&cone(|angle, distance| {
        0.4 * (7.0 * angle + 0.3).sin() * (0.6 * distance).cos()
    }));
    assert_eq!(holes_in(&scan.mesh()), 1);
    let (completion, mesh) = completed(&scan, &quick());
    let BaseSurface::Cone(base) = completion.report.fit.base else {
        panic!("{:?}", completion.report.fit.base)
    };
    assert!((base.half_angle - 0.35).abs() < 0.01, "{}", base.half_angle);
    assert_eq!(euler_characteristic(&mesh), 0);
    assert_eq!(loops(&mesh).len(), 2);
}

#[test]
fn a_loose_piece_inside_a_hole_is_stitched() {
    let whole = synthetic(Kind::GolfBall, Part::FULL);
    let from_pole = |p: &Point3<f64>| p.coords.angle(&Vector3::z());
    let scan = cut(&whole, |p| !(0.3..0.6).contains(&from_pole(p)));
    assert_eq!(Adjacency::new(&scan.mesh()).components().1, 2);
    let (completion, mesh) = completed(&scan, &quick());
    assert_eq!(completion.report.filled[0].loops.len(), 2);
    assert_eq!(euler_characteristic(&mesh), 2);
    assert_eq!(loops(&mesh), []);
    assert_eq!(Adjacency::new(&mesh).components().1, 1);
}

#[test]
fn inner_walls_are_completed_too() {
    for (kind, euler) in [(Kind::GolfBall, 2), (Kind::Bark, 0), (Kind::Bricks, 1)] {
        let (_, mesh) = completed(&turned_over(&holed(kind)), &quick());
        assert_eq!(euler_characteristic(&mesh), euler, "{kind}");
        assert_eq!(holes_in(&mesh), 0, "{kind}");
    }
}

#[test]
fn a_seed_gives_the_same_bytes_and_another_gives_others() {
    let scan = holed(Kind::GolfBall);
    let bytes = |seed| {
        let params = CompleteParams { seed, ..quick() };
        as_ply(&completed(&scan, &params).0.scan)
    };
    assert!(bytes(1) == bytes(1));
    assert!(bytes(1) != bytes(2));
}

#[test]
fn the_order_of_loops_asked_for_does_not_matter() {
    let scan = two_holes();
    let bytes = |ids: &[usize]| {
        let params = CompleteParams {
            holes: HoleChoice::Ids(ids.to_vec()),
            ..quick()
        };
        as_ply(&completed(&scan, &params).0.scan)
    };
    assert!(bytes(&[0, 1]) == bytes(&[1, 0, 1]));
}

/// A golf ball with a hole at each of two poles, the one at +z larger.
fn two_holes() -> Scan {
    cut(&synthetic(Kind::GolfBall, Part::FULL), |p| {
        p.coords.angle(&Vector3::z()) > 0.4 && p.coords.angle(&-Vector3::z()) > 0.3
    })
}

#[test]
fn the_largest_hole_and_single_holes_are_chosen() {
    let scan = two_holes();
    assert_eq!(loops(&scan.mesh()).len(), 2);
    for (choice, filled) in [
        (HoleChoice::Largest, 0),
        (HoleChoice::Ids(vec![0]), 0),
        (HoleChoice::Ids(vec![1]), 1),
    ] {
        let params = CompleteParams {
            holes: choice,
            ..quick()
        };
        let (completion, mesh) = completed(&scan, &params);
        assert_eq!(completion.report.filled[0].loops, [filled]);
        let left = loops(&mesh);
        assert_eq!(left.len(), 1);
        let z = mesh.positions[left[0].vertices[0] as usize].z;
        assert!((z > 0.0) == (filled == 1));
    }
}

#[test]
fn a_second_completion_keeps_the_marks_of_the_first() {
    let scan = two_holes();
    let params = CompleteParams {
        holes: HoleChoice::Largest,
        ..quick()
    };
    let (first, _) = completed(&scan, &params);
    let second = complete(&first.scan, &quick(), &mut |_| {}).unwrap();
    let mesh = second.scan.mesh();
    assert_eq!(check(&mesh), Ok(()));
    assert_eq!(loops(&mesh), []);
    for name in [COMPLETED, SOURCE] {
        let before = values(&first.scan, name);
        let after = values(&second.scan, name);
        approx::assert_abs_diff_eq!(after[..before.len()], before[..], epsilon = 0.0);
    }
    assert!(
        values(&second.scan, COMPLETED)[first.scan.vertices.rows..]
            .iter()
            .all(|m| *m > 0.5)
    );
    let names: Vec<&str> = (second.scan.vertices.channels.iter())
        .map(|c| c.name.as_str())
        .collect();
    assert_eq!(
        names,
        ["x", "y", "z", "completed", "height", "source", "cost"]
    );
}

#[test]
fn a_closed_surface_and_a_base_that_does_not_fit_are_refused() {
    let full = synthetic(Kind::GolfBall, Part::FULL);
    let error = complete(&full, &quick(), &mut |_| {}).unwrap_err();
    assert_eq!(error, CompletionError::Closed);
    let plane = CompleteParams {
        fit: FitParams {
            base: BaseChoice::Kind(BaseKind::Plane),
            ..FitParams::default()
        },
        ..quick()
    };
    let error = complete(&holed(Kind::GolfBall), &plane, &mut |_| {}).unwrap_err();
    assert!(
        matches!(error, CompletionError::BaseDoesNotFit { .. }),
        "{error}"
    );
}

/// A flat plate with a hole, engraved on a fifth of its vertices: more than half of the heights are
/// exactly zero.
fn engraved_plate() -> Scan {
    let side = 32u32;
    let mut mesh = TriMesh::default();
    for i in 0..side {
        for j in 0..side {
            let depth = if (i % 8) < 3 && (j % 8) < 4 { 0.5 } else { 0.0 };
            mesh.positions
                .push(Point3::new(f64::from(i), f64::from(j), -depth));
        }
    }
    for i in 0..side - 1 {
        for j in 0..side - 1 {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| i * side + j);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    cut(&to_scan(&mesh), |p| {
        (p - Point3::new(16.0, 16.0, 0.0)).norm() > 4.0
    })
}

#[test]
fn engravings_in_a_flat_plate_are_relief() {
    let (completion, mesh) = completed(&engraved_plate(), &quick());
    assert_eq!(holes_in(&mesh), 0);
    let counts = completion.report.counts;
    assert_eq!(counts.samples, counts.original_vertices);
    let by_paper = CompleteParams {
        method: Method::Paper,
        ..quick()
    };
    let (completion, mesh) = completed(&engraved_plate(), &by_paper);
    assert_eq!(holes_in(&mesh), 0);
    let counts = completion.report.counts;
    // Every vertex and every edge's middle.
    assert!(
        counts.samples * 10 > 38 * counts.original_vertices,
        "{counts:?}"
    );
}

/// A frustum over half of which the relief is zero but for rounding.
#[test]
fn relief_that_is_zero_on_half_of_a_cone_is_no_obstacle() {
    let mesh = cone(|angle, distance| 0.4 * (12.0 * angle).sin() * (0.6 * distance).cos());
    let scan = with_hole(&mesh);
    assert!(complete(&scan, &quick(), &mut |_| {}).is_ok());
}

#[test]
fn options_that_steer_the_search_give_whole_results() {
    let scan = holed(Kind::Bricks);
    for method in [Method::Paper, Method::Exhaustive, Method::Coherent] {
        let quick = || CompleteParams { method, ..quick() };
        let plain = as_ply(&completed(&scan, &quick()).0.scan);
        let options = [
            CompleteParams {
                bootstrap: true,
                ..quick()
            },
            CompleteParams {
                mu: Some(0.0),
                ..quick()
            },
            CompleteParams {
                mu: Some(1.0),
                ..quick()
            },
            CompleteParams {
                tolerance: 0.0,
                ..quick()
            },
            CompleteParams {
                error_threshold: Some(1e-6),
                ..quick()
            },
        ];
        for params in options {
            let (completion, mesh) = completed(&scan, &params);
            assert_eq!(holes_in(&mesh), 0, "{params:?}");
            assert_colors_in_range(&scan, &completion);
            let low_threshold = params
                .error_threshold
                .is_some_and(|threshold| threshold < 0.1);
            // After least squares hardly any two matches cost the same to a tenth, and what continues a
            // source that is no longer than a few edges seldom leads to new samples.
            let seldom = method == Method::Coherent && (params.tolerance < 0.1 || params.bootstrap);
            assert!(
                low_threshold || seldom || as_ply(&completion.scan) != plain,
                "no effect: {params:?}"
            );
        }
    }
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    for kind in [Kind::GolfBall, Kind::Bricks] {
        let scan = holed(kind);
        for method in [Method::Exhaustive, Method::Coherent] {
            let params = CompleteParams {
                method,
                audit: 0.2,
                ..CompleteParams::default()
            };
            let bytes = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                let (completion, _) = pool.install(|| completed(&scan, &params));
                (as_ply(&completion.scan), completion.report.searched)
            };
            let with_one = bytes(1);
            assert!(with_one == bytes(2), "{kind} {method:?}");
            assert!(with_one == bytes(8), "{kind} {method:?}");
        }
    }
}

/// RMS over the rim's new vertices of how far they are from the mean of their neighbors.
fn roughness_at_the_rim(completion: &Completion, mesh: &TriMesh) -> f64 {
    let heights = values(&completion.scan, "height");
    let first = completion.report.counts.original_vertices;
    let neighbors = Adjacency::new(mesh).neighbors;
    let bends: Vec<f64> = (first..heights.len())
        .filter(|v| neighbors.row(*v).iter().any(|n| (*n as usize) < first))
        .map(|v| {
            let row = neighbors.row(v);
            let mean = row.iter().map(|n| heights[*n as usize]).sum::<f64>() / row.len() as f64;
            (heights[v] - mean).powi(2)
        })
        .collect();
    (bends.iter().sum::<f64>() / bends.len() as f64).sqrt()
}

#[test]
fn copied_patches_are_fitted_to_the_scan_unless_told_otherwise() {
    let scan = holed(Kind::Noise);
    let with = |blend: bool, method: Method| {
        let params = CompleteParams {
            blend: Some(blend),
            method,
            ..CompleteParams::default()
        };
        completed(&scan, &params)
    };
    let [fitted, copied] = [true, false].map(|blend| {
        let (completion, mesh) = with(blend, Method::Coherent);
        roughness_at_the_rim(&completion, &mesh)
    });
    assert!(fitted < 0.9 * copied, "{fitted} after {copied}");
    let [fitted, copied] = [true, false].map(|blend| with(blend, Method::Exhaustive).0);
    // The same sources, at other heights.
    assert!(values(&fitted.scan, SOURCE) == values(&copied.scan, SOURCE));
    assert!(values(&fitted.scan, "height") != values(&copied.scan, "height"));
    let quick = |blend: bool| CompleteParams {
        blend: Some(blend),
        method: Method::Paper,
        ..quick()
    };
    let [asked, not] = [true, false].map(|blend| as_ply(&completed(&scan, &quick(blend)).0.scan));
    assert!(asked == not, "the paper's method copies");
}

#[test]
fn further_channels_come_from_where_the_relief_does() {
    let mut scan = holed(Kind::GolfBall);
    let rows = u16::try_from(scan.vertices.rows).unwrap();
    let intensity = (0..rows).map(|row| f32::from(row) + 0.25).collect();
    (scan.vertices).set_channel("intensity", Column::F32(intensity));
    (scan.vertices).set_channel("label", Column::U16((0..rows).rev().collect()));
    for method in [Method::Coherent, Method::Exhaustive] {
        let params = CompleteParams { method, ..quick() };
        let made = completed(&scan, &params).0.scan;
        let [sources, intensity, label] =
            [SOURCE, "intensity", "label"].map(|name| values(&made, name));
        let first = usize::from(rows);
        assert!(made.vertices.rows > first);
        for row in first..made.vertices.rows {
            assert!((intensity[row] - sources[row] - 0.25).abs() < 1e-9, "{row}");
            assert!((label[row] + sources[row] + 1.0 - f64::from(rows)).abs() < 1e-9);
        }
    }
}

#[test]
fn coherent_matches_are_nearly_as_good_as_the_best_of_all() {
    let (mut audited, mut as_good) = (0, 0.0);
    for kind in [Kind::GolfBall, Kind::Noise, Kind::Bark, Kind::Bricks] {
        let scan = holed(kind);
        let plain = completed(&scan, &CompleteParams::default()).0;
        let watched = CompleteParams {
            audit: 1.0,
            ..CompleteParams::default()
        };
        let completion = completed(&scan, &watched).0;
        // To be watched changes nothing.
        assert!(as_ply(&plain.scan) == as_ply(&completion.scan), "{kind}");
        let searched = completion.report.searched;
        let recall = searched.recall.unwrap();
        assert!(
            recall.continuing <= recall.coherent && recall.coherent <= 1.0,
            "{kind}: {recall:?}"
        );
        let found = searched.continued + searched.similar + searched.global;
        let new = completion.report.counts.completed_vertices;
        assert_eq!((found, recall.audited), (new, new), "{kind}: {searched:?}");
        audited += recall.audited;
        as_good += recall.all * recall.audited as f64;
    }
    let recall = as_good / audited as f64;
    assert!(recall > 0.85, "{recall} of {audited}");
}

#[test]
fn completed_vertices_become_samples_of_coherent_search() {
    let scan = synthetic(Kind::GolfBall, Part::view(Vector3::z()));
    let params = CompleteParams {
        bootstrap: true,
        ..extending()
    };
    let report = completed(&scan, &params).0.report;
    let counts = report.counts;
    assert_eq!(
        report.searched.sites_offered,
        counts.original_vertices + counts.completed_vertices
    );
}

#[test]
fn tables_are_thinned_to_the_memory_and_too_little_is_said() {
    let scan = holed(Kind::Noise);
    let with = |memory: usize| CompleteParams {
        memory,
        ..CompleteParams::default()
    };
    let searched = completed(&scan, &with(400_000)).0.report.searched;
    assert!(searched.sites < searched.sites_offered, "{searched:?}");
    assert!(searched.table_bytes <= 400_000, "{searched:?}");
    let report = complete(&scan, &with(1000), &mut |_| {}).unwrap().report;
    assert!(report.filled.is_empty());
    assert!(report.skipped[0].reason.contains("--memory"));
}

/// A torus: no kind of base fits it.
fn torus() -> TriMesh {
    let (around, along) = (72u32, 30u32);
    let mut mesh = TriMesh::default();
    for i in 0..along {
        for j in 0..around {
            let angle = TAU * f64::from(j) / f64::from(around);
            let minor = TAU * f64::from(i) / f64::from(along);
            let radius = 30.0 + 12.0 * minor.cos();
            let z = 12.0 * minor.sin();
            mesh.positions
                .push(Point3::new(radius * angle.cos(), radius * angle.sin(), z));
            let v = |i, j| i % along * around + j % around;
            let [a, b, c, d] = [v(i, j), v(i, j + 1), v(i + 1, j), v(i + 1, j + 1)];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    mesh
}

#[test]
fn a_hole_where_no_base_fits_gets_one_of_its_own_or_stays_open_with_a_reason() {
    let scan = cut(&to_scan(&torus()), |p| {
        (p - Point3::new(42.0, 0.0, 0.0)).norm() > 4.0
    });
    let completion = complete(&scan, &quick(), &mut |_| {}).unwrap();
    assert!(!completion.report.base_fits);
    assert_only_appended(&scan, &completion.scan);
    let mesh = completion.scan.mesh();
    assert_eq!(check(&mesh), Ok(()));
    let report = completion.report;
    assert_eq!(loops(&mesh).len(), report.skipped.len());
    assert_eq!(report.filled.len() + report.skipped.len(), 1);
    assert!(report.filled.iter().all(|hole| hole.own_base.is_some()));
    assert!(report.skipped.iter().all(|hole| !hole.reason.is_empty()));
    let extending = complete(&scan, &extending(), &mut |_| {});
    assert!(matches!(
        extending,
        Err(CompletionError::BaseDoesNotFit { .. })
    ));
}

#[test]
fn extension_fills_interior_holes_too() {
    let part = Part {
        view: Some(Vector3::z()),
        hole: Some(0.05),
    };
    let scan = synthetic(Kind::GolfBall, part);
    assert_eq!(loops(&scan.mesh()).len(), 2);
    for holes in [HoleChoice::Interior, HoleChoice::All] {
        let (_, mesh) = completed(
            &scan,
            &CompleteParams {
                holes,
                ..extending()
            },
        );
        assert_eq!(euler_characteristic(&mesh), 2);
        assert_eq!(loops(&mesh), []);
    }
}

#[test]
fn a_rotated_scan_is_extended_as_well() {
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    let side = synthetic(Kind::Bark, Part::view(Vector3::x()));
    let mut mesh = side.mesh();
    for p in &mut mesh.positions {
        *p = turn * *p;
    }
    let (_, mesh) = completed(&to_scan(&mesh), &extending());
    assert_eq!(euler_characteristic(&mesh), 0);
    assert_eq!(loops(&mesh).len(), 2);
}

#[test]
fn the_unit_of_length_does_not_matter() {
    let scan = holed(Kind::GolfBall);
    let vertices = completed(&scan, &quick()).1.positions.len();
    for unit in [1e-6, 1e6] {
        let mut mesh = scan.mesh();
        for p in &mut mesh.positions {
            p.coords *= unit;
        }
        let (_, mesh) = completed(&to_scan(&mesh), &quick());
        assert_eq!(loops(&mesh), [], "unit {unit}");
        assert_eq!(mesh.positions.len(), vertices, "unit {unit}");
    }
}

#[test]
fn progress_never_runs_past_its_end() {
    let mut calls = 0;
    complete(&holed(Kind::Waves), &quick(), &mut |progress| {
        calls += 1;
        assert!(
            progress.total == 0 || progress.done <= progress.total,
            "{progress:?}"
        );
    })
    .unwrap();
    assert!(calls > 0);
}

#[test]
fn a_length_sets_the_spacing() {
    let scan = holed(Kind::Waves);
    let vertices = |length: f64| {
        let params = CompleteParams {
            spacing: Some(SpacingRule::Length(length)),
            ..quick()
        };
        completed(&scan, &params).0.report.counts.completed_vertices
    };
    let median = completed(&scan, &quick()).0.report.spacing.median;
    let (coarse, fine) = (vertices(median), vertices(median / 2.0));
    assert!(
        (2 * coarse..=7 * coarse).contains(&fine),
        "{coarse} and {fine}"
    );
}

#[test]
fn a_real_scan_with_many_small_holes_is_completed_where_it_lies_on_its_base() {
    let Some(scan) = real("holes/many_small_holes.ply") else {
        return;
    };
    let completion = complete(&scan, &quick(), &mut |_| {}).unwrap();
    assert_only_appended(&scan, &completion.scan);
    assert_colors_in_range(&scan, &completion);
    let (before, after) = (scan.mesh(), completion.scan.mesh());
    assert_eq!(check(&before), Ok(()));
    assert_eq!(check(&after), Ok(()));
    let filled = completion.report.filled.len();
    assert!(filled >= 15, "{filled}");
    assert_eq!(holes_in(&before), filled + completion.report.skipped.len());
    assert_eq!(loops(&after).len(), loops(&before).len() - filled);
}

#[test]
fn a_hole_in_a_real_shell_is_completed_with_its_colours() {
    let Some(whole) = real("relief/scallop_shell_rgb.ply") else {
        return;
    };
    let positions = whole.positions();
    let middle = whole.mesh().centroid();
    let near = |p: &Point3<f64>| (p - middle).norm();
    let center = *positions
        .iter()
        .min_by(|a, b| near(a).total_cmp(&near(b)))
        .unwrap();
    let scan = cut(&whole, |p| (p - center).norm() > 1.5);
    let completion = complete(&scan, &quick(), &mut |_| {}).unwrap();
    assert_only_appended(&scan, &completion.scan);
    assert_colors_in_range(&scan, &completion);
    let filled = completion.report.filled.len();
    assert!(filled >= 1, "{:?}", completion.report.skipped);
    let mesh = completion.scan.mesh();
    assert_eq!(loops(&mesh).len(), loops(&scan.mesh()).len() - filled);
    let gone = loops(&mesh)
        .iter()
        .all(|l| (l.vertices.iter()).all(|v| (mesh.positions[*v as usize] - center).norm() > 2.5));
    assert!(gone, "the hole is still there");
}
