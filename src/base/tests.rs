//! Fits against known truth, against `SciPy`, under motion, scale, outliers and bad input.

use std::f64::consts::{PI, TAU};

use approx::assert_relative_eq;
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use serde::Deserialize;

use super::*;
use crate::mesh::TriMesh;
use crate::rng::{Rng, Stage};

/// A grid of vertices at `at(a, b)`, a and b from 0 to 1, both ends included.
fn grid(columns: u32, rows: u32, mut at: impl FnMut(f64, f64) -> Point3<f64>) -> TriMesh {
    let mut mesh = TriMesh::default();
    for j in 0..rows {
        for i in 0..columns {
            let (a, b) = (f64::from(i), f64::from(j));
            mesh.positions
                .push(at(a / f64::from(columns - 1), b / f64::from(rows - 1)));
        }
    }
    for j in 0..rows - 1 {
        for i in 0..columns - 1 {
            let v = j * columns + i;
            mesh.triangles.push([v, v + 1, v + columns]);
            mesh.triangles.push([v + 1, v + columns + 1, v + columns]);
        }
    }
    mesh
}

const KINDS: [BaseKind; 4] = [
    BaseKind::Plane,
    BaseKind::Sphere,
    BaseKind::Cylinder,
    BaseKind::Cone,
];

/// A patch of a surface about the z axis, `arc` radians wide, with heights over it; and the surface.
fn patch(
    kind: BaseKind,
    arc: f64,
    mut height: impl FnMut(f64, f64) -> f64,
) -> (TriMesh, BaseSurface) {
    let out = |t: f64| Vector3::new(t.cos(), t.sin(), 0.0);
    let z = Vector3::z_axis();
    let origin = Point3::origin();
    match kind {
        BaseKind::Plane => {
            let mesh = grid(40, 30, |a, b| {
                Point3::new(3.0 * a, 2.0 * b, 0.5 + height(a, b))
            });
            let point = Point3::new(1.5, 1.0, 0.5);
            (mesh, BaseSurface::Plane(Plane { point, normal: z }))
        }
        BaseKind::Sphere => {
            let mesh = grid(40, 30, |a, b| {
                let latitude = (arc.min(PI) * 0.98) * (b - 0.5);
                let direction = out(arc * a) * latitude.cos() + z.into_inner() * latitude.sin();
                origin + direction * (2.0 + height(a, b))
            });
            let (center, radius) = (origin, 2.0);
            (mesh, BaseSurface::Sphere(Sphere { center, radius }))
        }
        BaseKind::Cylinder => {
            let mesh = grid(40, 30, |a, b| {
                origin + out(arc * a) * (1.5 + height(a, b)) + z.into_inner() * (4.0 * b)
            });
            let (point, axis, radius) = (Point3::new(0.0, 0.0, 2.0), z, 1.5);
            (
                mesh,
                BaseSurface::Cylinder(Cylinder {
                    point,
                    axis,
                    radius,
                }),
            )
        }
        BaseKind::Cone => {
            let half_angle = 0.4_f64;
            let (sin, cos) = half_angle.sin_cos();
            let mesh = grid(40, 30, |a, b| {
                let (slant, h) = (1.0 + 2.0 * b, height(a, b));
                origin
                    + out(arc * a) * (slant * sin + h * cos)
                    + z.into_inner() * (slant * cos - h * sin)
            });
            (
                mesh,
                BaseSurface::Cone(Cone {
                    apex: origin,
                    axis: z,
                    half_angle,
                }),
            )
        }
    }
}

/// Largest distance of two surfaces' parameters, lengths as shares of `unit`. Points of cylinder
/// axes are compared across the axis only.
fn difference(a: &BaseSurface, b: &BaseSurface, unit: f64) -> f64 {
    match (a, b) {
        (BaseSurface::Plane(a), BaseSurface::Plane(b)) => {
            let along = (a.point - b.point).dot(&b.normal).abs() / unit;
            along.max((a.normal.into_inner() - b.normal.into_inner()).norm())
        }
        (BaseSurface::Sphere(a), BaseSurface::Sphere(b)) => {
            ((a.center - b.center).norm() / unit).max((a.radius - b.radius).abs() / unit)
        }
        (BaseSurface::Cylinder(a), BaseSurface::Cylinder(b)) => {
            let across = (a.point - b.point).cross(&b.axis).norm() / unit;
            let turn = a.axis.cross(&b.axis).norm();
            across.max((a.radius - b.radius).abs() / unit).max(turn)
        }
        (BaseSurface::Cone(a), BaseSurface::Cone(b)) => {
            let turn = (a.axis.into_inner() - b.axis.into_inner()).norm();
            let apex = (a.apex - b.apex).norm() / unit;
            apex.max((a.half_angle - b.half_angle).abs()).max(turn)
        }
        _ => f64::INFINITY,
    }
}

fn only(kind: BaseKind) -> FitParams {
    FitParams {
        base: BaseChoice::Kind(kind),
        ..FitParams::default()
    }
}

/// The mesh with the surface, turned, scaled and moved.
fn moved(
    mesh: &TriMesh,
    surface: &BaseSurface,
    scale: f64,
    offset: Vector3<f64>,
) -> (TriMesh, BaseSurface) {
    let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    let point = |p: Point3<f64>| turn * p * scale + offset;
    let axis = |a: Unit<Vector3<f64>>| turn * a;
    let mesh = TriMesh {
        positions: mesh.positions.iter().map(|p| point(*p)).collect(),
        triangles: mesh.triangles.clone(),
    };
    let surface = match *surface {
        BaseSurface::Plane(p) => BaseSurface::Plane(Plane {
            point: point(p.point),
            normal: axis(p.normal),
        }),
        BaseSurface::Sphere(s) => BaseSurface::Sphere(Sphere {
            center: point(s.center),
            radius: s.radius * scale,
        }),
        BaseSurface::Cylinder(c) => BaseSurface::Cylinder(Cylinder {
            point: point(c.point),
            axis: axis(c.axis),
            radius: c.radius * scale,
        }),
        BaseSurface::Cone(c) => BaseSurface::Cone(Cone {
            apex: point(c.apex),
            axis: axis(c.axis),
            ..c
        }),
    };
    (mesh, surface)
}

#[test]
fn parameters_are_recovered_without_noise_from_full_and_partial_views() {
    for kind in KINDS {
        for arc in [TAU * 0.97, PI, PI / 3.0] {
            let (mesh, truth) = patch(kind, arc, |_, _| 0.0);
            for loss in [Loss::Tukey, Loss::LeastSquares] {
                let report = fit(&mesh, &FitParams { loss, ..only(kind) }).unwrap();
                let error = difference(&report.base, &truth, 1.0);
                assert!(
                    error < 1e-9,
                    "{kind:?} {arc} {loss:?}: {error:e} {report:?}"
                );
                assert_eq!(report.reason, StopReason::Converged);
                let auto = FitParams {
                    loss,
                    ..FitParams::default()
                };
                let auto = fit(&mesh, &auto).unwrap().base.kind();
                assert_eq!(auto, kind, "{arc} {loss:?}");
            }
        }
    }
}

#[test]
fn noise_moves_the_parameters_by_no_more_than_its_standard_error() {
    for kind in KINDS {
        let mut rng = Rng::new(3, Stage::Synth, 0);
        let sigma = 0.01;
        let (mesh, truth) = patch(kind, PI, |_, _| sigma * rng.normal());
        for loss in [Loss::Tukey, Loss::LeastSquares] {
            let report = fit(&mesh, &FitParams { loss, ..only(kind) }).unwrap();
            // The expected square of the difference is k/n of the noise's; three times its root.
            let truth = mesh.positions.iter().map(|p| truth.foot(p).height);
            let found = mesh.positions.iter().map(|p| report.base.foot(p).height);
            let square: f64 = truth.zip(found).map(|(a, b)| (a - b).powi(2)).sum();
            let count = mesh.positions.len() as f64;
            let bound = 3.0 * sigma * (select::parameters(kind) as f64 / count).sqrt();
            let error = (square / count).sqrt();
            assert!(error < bound, "{kind:?} {loss:?} {error} {bound}");
            assert_relative_eq!(report.rms, sigma, max_relative = 0.12);
            assert_relative_eq!(report.scale, sigma, max_relative = 0.15);
        }
    }
}

#[test]
fn fit_moves_turns_and_scales_with_the_mesh() {
    for kind in KINDS {
        let wave = |a: f64, b: f64| 0.02 * (37.0 * a).sin() * (29.0 * b).cos();
        let (mesh, surface) = patch(kind, 2.5, wave);
        let reference = fit(&mesh, &only(kind)).unwrap();
        // Rounding of a coordinate that is a million times the size leaves ten digits.
        for (scale, offset, tolerance) in [
            (1.0, 0.0, 1e-9),
            (1e-9, 0.0, 1e-9),
            (1e9, 0.0, 1e-9),
            (1.0, 1e6, 1e-7),
            (1e-160, 0.0, 1e-9),
            (1e150, 0.0, 1e-9),
        ] {
            let offset = Vector3::new(1.0, -2.0, 0.5) * offset;
            let (there, expected) = moved(&mesh, &reference.base, scale, offset);
            let found = fit(&there, &only(kind)).unwrap();
            let error = difference(&found.base, &expected, scale);
            assert!(error < tolerance, "{kind:?} {scale} {offset} {error:e}");
            assert_relative_eq!(found.rms / scale, reference.rms, max_relative = 1e-6);
        }
        assert!(difference(&reference.base, &surface, 1.0) < 0.02);
    }
}

#[test]
fn order_of_vertices_and_number_of_threads_do_not_matter() {
    let mut rng = Rng::new(3, Stage::Synth, 1);
    let (mesh, _) = patch(BaseKind::Cone, 2.0, |_, _| 0.01 * rng.normal());
    let report = fit(&mesh, &FitParams::default()).unwrap();
    let count = u32::try_from(mesh.positions.len()).unwrap();
    // 7 and 1200 have no common factor.
    let place = |v: u32| (v * 7 + 11) % count;
    let mut shuffled = mesh.clone();
    for v in 0..count {
        shuffled.positions[place(v) as usize] = mesh.positions[v as usize];
    }
    for t in &mut shuffled.triangles {
        *t = t.map(place);
    }
    shuffled.triangles.reverse();
    let other = fit(&shuffled, &FitParams::default()).unwrap();
    // Other starts end at a scale that differs by up to a thousandth: far below the noise.
    assert!(difference(&report.base, &other.base, 1.0) < 1e-4);
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let alone = alone.install(|| fit(&mesh, &FitParams::default()).unwrap());
    assert_eq!(alone, report);
}

#[test]
fn a_tenth_of_gross_outliers_and_a_stray_piece_do_not_pull() {
    for kind in KINDS {
        let mut rng = Rng::new(8, Stage::Synth, 0);
        let (mesh, truth) = patch(kind, PI, |a, b| {
            if a > 0.8 && b > 0.8 {
                0.5 + a
            } else if rng.uniform() < 0.1 {
                2.0 * rng.uniform()
            } else {
                0.0
            }
        });
        // A spike has more area than the surface around it, so vertices count alike.
        let params = FitParams {
            weighting: Weighting::Uniform,
            ..only(kind)
        };
        let report = fit(&mesh, &params).unwrap();
        let error = difference(&report.base, &truth, 1.0);
        assert!(error < 1e-8, "{kind:?} {error:e} {:?}", report.base);
        assert!(report.inlier_share > 0.8 && report.inlier_share < 0.9);
    }
}

#[test]
fn a_surface_with_forty_five_percent_of_the_vertices_is_found() {
    for kind in KINDS {
        let mut rng = Rng::new(9, Stage::Synth, 0);
        let (mesh, truth) = patch(kind, 4.0, |_, b| {
            let noise = 0.003 * rng.normal();
            if (0.3..0.76).contains(&b) {
                noise
            } else {
                // Steps and slopes to both sides, as of a tower's base and roof.
                noise
                    + if b < 0.3 {
                        0.25 + 0.8 * (0.3 - b)
                    } else {
                        0.1 - 1.2 * (b - 0.76)
                    }
            }
        });
        let params = FitParams {
            weighting: Weighting::Uniform,
            ..only(kind)
        };
        let report = fit(&mesh, &params).unwrap();
        let error = difference(&report.base, &truth, 1.0);
        assert!(error < 0.02, "{kind:?} {error:e} {:?}", report.base);
    }
}

#[test]
fn one_sided_dimples_leave_the_surface_in_its_place() {
    for kind in KINDS {
        for noise in [0.0, 0.002] {
            let mut rng = Rng::new(4, Stage::Synth, 0);
            let depth = 0.05;
            let (mesh, truth) = patch(kind, 2.8, |a, b| {
                let (x, y) = ((9.0 * a).fract() - 0.5, (6.0 * b).fract() - 0.5);
                let inside = 1.0 - (x * x + y * y) / 0.16;
                noise * rng.normal() - depth * inside.max(0.0)
            });
            let report = fit(&mesh, &only(kind)).unwrap();
            // Half of the area is land: without noise it is the surface exactly.
            let tolerance = if noise > 0.0 { depth } else { 1e-8 };
            let error = difference(&report.base, &truth, 1.0);
            assert!(error < tolerance, "{kind:?} {noise} {error:e}");
        }
    }
}

#[test]
fn auto_prefers_the_plane_whatever_its_relief() {
    let mut rng = Rng::new(6, Stage::Synth, 0);
    let waves =
        |k: f64, l: f64| move |a: f64, b: f64| (k * TAU * a + 0.7).sin() * (l * TAU * b).cos();
    let mut reliefs: Vec<Box<dyn FnMut(f64, f64) -> f64>> = vec![
        Box::new(move |_, _| 0.3 * rng.normal()),
        Box::new(|a, b| {
            if (8.0 * b).fract() < 0.2 || (6.0 * a).fract() < 0.15 {
                -1.0
            } else {
                0.0
            }
        }),
    ];
    for (k, l) in [
        (1.5, 0.0),
        (2.5, 0.0),
        (4.0, 0.0),
        (1.0, 1.0),
        (2.3, 3.1),
        (6.0, 5.0),
    ] {
        reliefs.push(Box::new(waves(k, l)));
    }
    for (i, mut relief) in reliefs.into_iter().enumerate() {
        for amplitude in [0.002, 0.02, 0.08] {
            let (mesh, _) = patch(BaseKind::Plane, 0.0, |a, b| amplitude * relief(a, b));
            let report = fit(&mesh, &FitParams::default()).unwrap();
            assert_eq!(
                report.base.kind(),
                BaseKind::Plane,
                "{i} {amplitude} {report:?}"
            );
        }
    }
}

#[test]
fn auto_names_the_kind_under_dimples_ridges_and_bumps() {
    let dimples = |a: f64, b: f64| {
        let (x, y) = ((12.0 * a).fract() - 0.5, (10.0 * b).fract() - 0.5);
        -0.04 * (1.0 - (x * x + y * y) / 0.2).max(0.0)
    };
    let ridges =
        |a: f64, b: f64| 0.05 * (40.0 * a + 1.5 * (9.0 * b).sin()).sin() + 0.02 * (31.0 * b).sin();
    for arc in [PI, 0.97 * TAU] {
        for kind in [BaseKind::Sphere, BaseKind::Cylinder, BaseKind::Cone] {
            for relief in [&dimples as &dyn Fn(f64, f64) -> f64, &ridges] {
                let (mesh, _) = patch(kind, arc, relief);
                let report = fit(&mesh, &FitParams::default()).unwrap();
                assert_eq!(report.base.kind(), kind, "{arc} {report:?}");
                assert!(report.fits());
            }
        }
    }
}

#[test]
fn a_shallow_sphere_is_told_from_a_plane() {
    let mut rng = Rng::new(7, Stage::Synth, 0);
    let mesh = grid(50, 50, |a, b| {
        let (x, y) = (a - 0.5, b - 0.5);
        Point3::new(x, y, (25.0 - x * x - y * y).sqrt() + 0.002 * rng.normal())
    });
    let report = fit(&mesh, &FitParams::default()).unwrap();
    assert_eq!(report.base.kind(), BaseKind::Sphere, "{report:?}");
}

#[test]
fn a_plane_faces_the_side_of_the_triangles_and_points_are_next_to_the_centroid() {
    let (mut mesh, _) = patch(BaseKind::Plane, 0.0, |a, b| 0.01 * (40.0 * a * b).sin());
    for sign in [1.0, -1.0] {
        let BaseSurface::Plane(plane) = fit(&mesh, &FitParams::default()).unwrap().base else {
            panic!("a plane");
        };
        assert!(plane.normal.z * sign > 0.9);
        let to_centroid = mesh.centroid() - plane.point;
        assert!(to_centroid.cross(&plane.normal).norm() < 1e-12);
        for t in &mut mesh.triangles {
            t.swap(0, 1);
        }
    }
    let (mesh, _) = patch(BaseKind::Cylinder, 2.0, |_, _| 0.0);
    let BaseSurface::Cylinder(c) = fit(&mesh, &FitParams::default()).unwrap().base else {
        panic!("a cylinder");
    };
    assert!((mesh.centroid() - c.point).dot(&c.axis).abs() < 1e-12);
    assert!(c.axis.z > 0.0);
}

#[test]
fn vertices_without_triangles_and_their_coordinates_do_not_count() {
    let (mut mesh, truth) = patch(BaseKind::Sphere, 2.0, |_, _| 0.0);
    mesh.positions.push(Point3::new(f64::NAN, 1e300, 0.0));
    let report = fit(&mesh, &FitParams::default()).unwrap();
    assert!(difference(&report.base, &truth, 1.0) < 1e-9);
    assert_eq!(report.vertices, 1200);
}

#[test]
fn area_weights_undo_uneven_sampling() {
    // A bent sheet, sampled four times more densely on one half: the plane of the even sheet.
    let sheet = |warp: fn(f64) -> f64| {
        grid(60, 20, move |a, b| {
            let x = warp(a);
            Point3::new(x, b, 0.1 * x * x)
        })
    };
    let even = sheet(|a| 2.0 * a - 1.0);
    let uneven = sheet(|a| {
        if a < 0.8 {
            a / 0.8 - 1.0
        } else {
            (a - 0.8) / 0.2
        }
    });
    let slope = |mesh: &TriMesh, weighting| {
        let loss = Loss::LeastSquares;
        let params = FitParams {
            loss,
            weighting,
            ..only(BaseKind::Plane)
        };
        match fit(mesh, &params).unwrap().base {
            BaseSurface::Plane(p) => p.normal.x / p.normal.z,
            _ => f64::NAN,
        }
    };
    let reference = slope(&even, Weighting::Uniform);
    assert!((slope(&uneven, Weighting::Area) - reference).abs() < 0.003);
    assert!((slope(&uneven, Weighting::Uniform) - reference).abs() > 0.015);
}

fn mesh_of(points: &[[f64; 3]]) -> TriMesh {
    let count = u32::try_from(points.len()).unwrap();
    TriMesh {
        positions: points.iter().map(|p| Point3::from(*p)).collect(),
        triangles: (0..count.saturating_sub(2))
            .map(|i| [i, i + 1, i + 2])
            .collect(),
    }
}

#[test]
fn bad_input_is_an_error_that_says_so() {
    let auto = FitParams::default();
    let error = |points: &[[f64; 3]]| fit(&mesh_of(points), &auto).unwrap_err();
    let too_few = FitError::TooFewVertices {
        found: 0,
        needed: 3,
    };
    assert_eq!(error(&[]), too_few);
    assert_eq!(error(&[[0.0; 3]]), too_few);
    assert_eq!(error(&[[0.0; 3], [1.0; 3]]), too_few);
    assert_eq!(error(&[[1.0; 3]; 5]), FitError::Coincident);
    let line: Vec<_> = (0..9)
        .map(f64::from)
        .map(|i| [i, 0.1 * i, -0.3 * i])
        .collect();
    assert_eq!(error(&line), FitError::Collinear);
    let far: Vec<_> = line.iter().map(|p| p.map(|x| x + 1e5)).collect();
    assert_eq!(error(&far), FitError::Collinear);
    let nan = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, f64::NAN, 0.0]];
    assert_eq!(error(&nan), FitError::NotFinite(2));
    let mut mesh = mesh_of(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    mesh.triangles.push([0, 1, 7]);
    let missing = FitError::NoSuchVertex {
        triangle: 1,
        vertex: 7,
    };
    assert_eq!(fit(&mesh, &auto).unwrap_err(), missing);
    let scale = Some(0.0);
    assert_eq!(
        fit(&mesh, &FitParams { scale, ..auto }).unwrap_err(),
        FitError::BadScale(0.0)
    );
}

#[test]
fn three_vertices_are_a_plane_and_too_few_for_the_rest() {
    let mesh = mesh_of(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let report = fit(&mesh, &FitParams::default()).unwrap();
    assert_eq!(report.base.kind(), BaseKind::Plane);
    assert!(report.rms < 1e-12);
    let error = fit(&mesh, &only(BaseKind::Cone)).unwrap_err();
    assert_eq!(
        error,
        FitError::TooFewVertices {
            found: 3,
            needed: 6
        }
    );
}

#[test]
fn nothing_panics_on_strange_meshes() {
    let mut rng = Rng::new(11, Stage::Synth, 0);
    for trial in 0..60_u32 {
        let count = 3 + rng.index(12);
        // Coarse coordinates, so that duplicates, lines and planes occur.
        let coarse = f64::from(1 + trial % 4);
        let mut coordinate = || {
            (rng.uniform() * coarse).floor()
                * 10.0_f64.powi(100 * (i32::try_from(trial % 7).unwrap() - 3))
        };
        let points: Vec<_> = (0..count).map(|_| [(); 3].map(|()| coordinate())).collect();
        for kind in KINDS {
            for loss in [Loss::Tukey, Loss::LeastSquares] {
                let max_iterations = (trial % 3) as usize;
                let params = FitParams {
                    loss,
                    max_iterations,
                    starts: 20,
                    ..only(kind)
                };
                if let Ok(report) = fit(&mesh_of(&points), &params) {
                    assert_eq!(report.base.kind(), kind);
                }
            }
        }
    }
}

#[test]
fn a_plane_asked_to_be_round_is_nearly_flat_or_refused() {
    let (mesh, _) = patch(BaseKind::Plane, 0.0, |_, _| 0.0);
    for kind in [BaseKind::Sphere, BaseKind::Cylinder, BaseKind::Cone] {
        match fit(&mesh, &only(kind)) {
            Ok(report) => {
                assert!(report.rms < 0.01, "{report:?}");
                assert!(report.ranking[0].degenerate.is_some(), "{report:?}");
            }
            Err(error) => assert_eq!(error, FitError::Undetermined(kind)),
        }
    }
}

#[derive(Deserialize)]
struct Golden {
    columns: u32,
    rows: u32,
    scale: f64,
    cases: Vec<GoldenCase>,
}

#[derive(Deserialize)]
struct GoldenCase {
    kind: BaseKind,
    points: Vec<[f64; 3]>,
    least_squares: GoldenFit,
    tukey: GoldenFit,
}

#[derive(Deserialize)]
struct GoldenFit {
    surface: BaseSurface,
    rms: f64,
}

#[test]
fn fits_agree_with_scipy() {
    let golden: Golden = serde_json::from_str(include_str!("../../data/golden/fits.json")).unwrap();
    for case in &golden.cases {
        let mut points = case.points.iter();
        let mesh = grid(golden.columns, golden.rows, |_, _| {
            Point3::from(*points.next().unwrap())
        });
        for (loss, scale, expected) in [
            (Loss::LeastSquares, None, &case.least_squares),
            (Loss::Tukey, Some(golden.scale), &case.tukey),
        ] {
            let weighting = Weighting::Uniform;
            let params = FitParams {
                loss,
                scale,
                weighting,
                ..only(case.kind)
            };
            let report = fit(&mesh, &params).unwrap();
            let mut base = report.base;
            if let (BaseSurface::Plane(p), BaseSurface::Plane(q)) = (&mut base, &expected.surface)
                && p.normal.dot(&q.normal) < 0.0
            {
                p.normal = -p.normal;
            }
            let error = difference(&base, &expected.surface, 1.0);
            // SciPy stops at gradients of 1e-8 and less, which is 1e-7 in an apex.
            assert!(
                error < 1e-7,
                "{:?} {loss:?} {error:e} {report:?}",
                case.kind
            );
            assert_relative_eq!(report.rms, expected.rms, max_relative = 1e-8);
        }
    }
}

#[test]
fn report_survives_json() {
    let (mesh, _) = patch(BaseKind::Cone, 2.0, |a, b| 0.01 * (50.0 * a * b).sin());
    let report = fit(&mesh, &FitParams::default()).unwrap();
    let back: FitReport = serde_json::from_str(&serde_json::to_string(&report).unwrap()).unwrap();
    assert_eq!(back.base.kind(), report.base.kind());
    assert_relative_eq!(back.rms, report.rms);
    assert_eq!(back.ranking.len(), 4);
}
