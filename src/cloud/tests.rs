use std::path::Path;

use nalgebra::{Rotation3, Unit};

use super::*;
use crate::mesh::{
    Adjacency, LoopKind, boundary_loops, check, euler_characteristic, triangle_normal,
};
use crate::rng::{Rng, Stage};
use crate::scan::{ReadOptions, Sensor};
use crate::synth::{Kind, Part, SynthParams};

fn cloud(positions: &[Point3<f64>]) -> Scan {
    let mut scan = Scan::default();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let values = positions.iter().map(|p| p[axis]).collect();
        scan.vertices.set_channel(name, Column::F64(values));
    }
    scan
}

/// A synthetic scan's mesh, and its points only.
fn synthetic(kind: Kind, vertices: usize, part: Part, noise: f64) -> (TriMesh, Scan) {
    let params = SynthParams {
        kind,
        vertices,
        part,
        noise,
        seed: 0,
    };
    let scan = crate::synth::scan(&params).unwrap().scan;
    let mesh = scan.mesh();
    let cloud = cloud(&mesh.positions);
    (mesh, cloud)
}

/// Nearly even points on the unit sphere.
fn sphere(count: u32) -> Vec<Point3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let radius = (1.0 - z * z).sqrt();
            let angle = golden * f64::from(i);
            Point3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
        .collect()
}

fn grid(columns: u32, rows: u32, step: f64) -> Vec<Point3<f64>> {
    (0..rows)
        .flat_map(|y| (0..columns).map(move |x| [f64::from(x), f64::from(y)]))
        .map(|[x, y]| Point3::new(step * x, step * y, 0.0))
        .collect()
}

fn join_by(join: JoinChoice) -> CloudParams {
    CloudParams {
        join,
        ..CloudParams::default()
    }
}

/// Triangulates, and checks what must hold for any cloud.
fn sound(scan: &Scan, params: &CloudParams) -> Triangulated {
    let result = triangulate(scan, params).unwrap();
    let mesh = result.scan.mesh();
    assert_eq!(check(&mesh), Ok(()));
    assert_eq!(mesh.triangles.len(), result.report.triangles);
    let vertices = mesh.positions.len();
    let single = single_fans::single_fans(mesh.triangles.clone(), vertices);
    assert_eq!(single, mesh.triangles, "one fan at each vertex");
    assert_eq!(mesh.used_vertices(), result.used);
    let old = &scan.vertices.channels;
    assert_eq!(&result.scan.vertices.channels[..old.len()], &old[..]);
    assert!(result.scan.check("result").is_ok());
    let report = &result.report;
    let used = result.used.iter().filter(|used| **used).count();
    let without = report.duplicates + report.outliers + report.left_over;
    assert_eq!(used + without, report.points);
    result
}

fn normals(scan: &Scan) -> Vec<Vector3<f64>> {
    let columns = ["nx", "ny", "nz"].map(|name| scan.vertices.column(name).unwrap());
    (0..scan.vertices.rows)
        .map(|row| Vector3::from(columns.map(|c| c.get_f64(row).unwrap())))
        .collect()
}

const JOINS: [JoinChoice; 3] = [JoinChoice::Auto, JoinChoice::Chart, JoinChoice::Local];

#[test]
fn a_whole_sphere_closes_and_its_normals_point_outwards() {
    let points = sphere(2000);
    for join in JOINS {
        let result = sound(&cloud(&points), &join_by(join));
        let mesh = result.scan.mesh();
        assert_eq!(euler_characteristic(&mesh), 2);
        assert_eq!((result.report.left_over, result.report.outliers), (0, 0));
        assert_eq!((result.report.holes, result.report.rims), (0, 0));
        for (p, n) in points.iter().zip(normals(&result.scan)) {
            assert!(n.dot(&p.coords) > 2f64.to_radians().cos());
        }
        for f in 0..mesh.triangles.len() {
            let corners = mesh.corners(f);
            assert!(triangle_normal(corners).dot(&corners[0].coords) > 0.0);
        }
    }
}

#[test]
fn every_form_of_surface_uses_all_points_and_ends_where_it_ends() {
    for (kind, rims) in [(Kind::GolfBall, 0), (Kind::Waves, 1), (Kind::Column, 2)] {
        let (truth, scan) = synthetic(kind, 5000, Part::default(), 0.0);
        let triangles = truth.triangles.len();
        for join in JOINS {
            let report = sound(&scan, &join_by(join)).report;
            assert_eq!(
                (report.left_over, report.outliers),
                (0, 0),
                "{kind} {join:?}"
            );
            assert_eq!((report.holes, report.rims, report.pieces), (0, rims, 1));
            // Along ragged rims there may be some more.
            let more = report.triangles - triangles;
            assert!(more * 50 < triangles, "{kind} {join:?}: {more}");
            let chart = report.joined != Joined::Local;
            assert_eq!(chart, join != JoinChoice::Local);
        }
    }
}

#[test]
fn a_gap_in_the_points_is_one_hole_of_the_gap_s_length() {
    for kind in [Kind::Waves, Kind::GolfBall] {
        let (truth, scan) = synthetic(kind, 8000, Part::hole(0.05), 0.0);
        let holes = |mesh: &TriMesh| -> Vec<f64> {
            (boundary_loops(mesh, &Adjacency::new(mesh)).iter())
                .filter(|l| l.kind == LoopKind::Hole)
                .map(|l| l.length)
                .collect()
        };
        let [expected] = holes(&truth)[..] else {
            panic!("the synthetic scan has one hole")
        };
        for join in JOINS {
            let result = sound(&scan, &join_by(join));
            let found = holes(&result.scan.mesh());
            assert_eq!(found.len(), 1, "{kind} {join:?}");
            assert!(
                (found[0] / expected - 1.0).abs() < 0.15,
                "{found:?} {expected}"
            );
        }
    }
}

#[test]
fn size_place_and_direction_do_not_matter() {
    let (truth, scan) = synthetic(Kind::GolfBall, 3000, Part::hole(0.05), 0.0);
    let counts = |scan: &Scan, join| {
        let report = sound(scan, &join_by(join)).report;
        [
            report.triangles,
            report.holes,
            report.rims,
            report.left_over,
        ]
    };
    let axis = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8));
    let turn = Rotation3::from_axis_angle(&axis, 1.1);
    for join in [JoinChoice::Auto, JoinChoice::Local] {
        let expected = counts(&scan, join);
        for (scale, offset) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e6), (1e-160, 0.0)] {
            let moved: Vec<_> = (truth.positions.iter())
                .map(|p| turn * p * scale + Vector3::repeat(offset))
                .collect();
            assert_eq!(counts(&cloud(&moved), join), expected, "{scale} {offset}");
        }
    }
}

#[test]
fn a_square_grid_is_cut_into_two_triangles_a_square() {
    for join in JOINS {
        let result = sound(&cloud(&grid(30, 20, 0.1)), &join_by(join));
        assert_eq!(result.report.triangles, 2 * 29 * 19);
        assert_eq!((result.report.holes, result.report.rims), (0, 1));
        assert!(normals(&result.scan).iter().all(|n| n.z > 0.999));
    }
}

#[test]
fn noise_leaves_a_surface() {
    // An eighth of the spacing across the surface.
    let (_, scan) = synthetic(Kind::GolfBall, 5000, Part::default(), 0.12);
    for join in [JoinChoice::Auto, JoinChoice::Local] {
        let report = sound(&scan, &join_by(join)).report;
        assert!(report.left_over < 25, "{report:?}");
        assert_eq!(report.pieces, 1);
        let complete = 2 * 5000 - 4;
        assert!(report.triangles * 100 > complete * 98, "{report:?}");
    }
}

#[test]
fn stray_points_stay_without_triangles() {
    let mut points = sphere(3000);
    let mut rng = Rng::new(1, Stage::Synth, 0);
    let strays = 30;
    for _ in 0..strays {
        let direction = Vector3::from_fn(|_, _| rng.normal()).normalize();
        points.push(Point3::from(direction * (1.4 + rng.uniform())));
    }
    let result = sound(&cloud(&points), &CloudParams::default());
    assert_eq!(result.report.outliers, strays);
    assert!(result.used[..3000].iter().all(|used| *used));
    assert!(result.used[3000..].iter().all(|used| !used));
    assert_eq!(euler_characteristic(&result.scan.mesh()), 2);
    let keep = CloudParams {
        outliers: None,
        ..CloudParams::default()
    };
    assert_eq!(sound(&cloud(&points), &keep).report.outliers, 0);
}

#[test]
fn a_sparse_area_is_not_stray() {
    let mut points = grid(60, 60, 1.0);
    points.extend(grid(15, 15, 4.0).iter().map(|p| p + Vector3::x() * 63.0));
    let report = sound(&cloud(&points), &CloudParams::default()).report;
    assert_eq!((report.outliers, report.left_over), (0, 0), "{report:?}");
    assert_eq!((report.pieces, report.holes), (1, 0), "{report:?}");
}

#[test]
fn copies_of_points_have_no_triangles_and_the_normals_of_the_first() {
    let points = sphere(500);
    let twice: Vec<_> = points.iter().chain(&points).copied().collect();
    let once = sound(&cloud(&points), &CloudParams::default());
    let result = sound(&cloud(&twice), &CloudParams::default());
    assert_eq!(result.report.duplicates, 500);
    assert_eq!(result.scan.faces, once.scan.faces);
    let normals = normals(&result.scan);
    assert_eq!(normals[..500], normals[500..]);
}

#[test]
fn sensors_and_the_file_s_normals_tell_the_side() {
    let points = grid(20, 20, 1.0);
    let facing = |scan: &Scan| {
        let result = sound(scan, &CloudParams::default());
        let mesh = result.scan.mesh();
        (triangle_normal(mesh.corners(0)).z, result)
    };
    let mut scan = cloud(&points);
    for (name, value) in [("nx", 0.0), ("ny", 0.0), ("nz", -1.0)] {
        let values = vec![value; points.len()];
        scan.vertices.set_channel(name, Column::F64(values));
    }
    let (z, result) = facing(&scan);
    assert!(z < 0.0);
    assert_eq!(result.report.orientation.file, 400);
    assert_eq!(result.scan.vertices, scan.vertices);
    scan.sensors.push(Sensor {
        vertices: 0..399,
        position: Point3::new(5.0, 5.0, 30.0),
    });
    // The file's normals are of the other side: where there is a sensor, it is believed.
    scan.vertices.channels.truncate(3);
    let (z, result) = facing(&scan);
    assert!(z > 0.0);
    assert_eq!(result.report.orientation.sensor, 399);
    assert_eq!(result.report.orientation.propagated, 1);
    scan.sensors[0].position.z = -30.0;
    assert!(facing(&scan).0 < 0.0);
    assert!(normals(&facing(&scan).1.scan).iter().all(|n| n.z < -0.999));
}

#[test]
fn two_pieces_far_apart_are_both_joined() {
    let mut points = grid(20, 20, 1.0);
    let far = Vector3::new(1e7, 2e6, 0.0);
    points.extend(grid(20, 20, 1.0).iter().map(|p| p + far));
    let report = sound(&cloud(&points), &CloudParams::default()).report;
    assert_eq!((report.pieces, report.left_over), (2, 0));
    assert_eq!(report.triangles, 4 * 19 * 19);
}

#[test]
fn what_is_no_cloud_is_refused_with_a_remedy() {
    let refuse = |scan: &Scan, params: &CloudParams| triangulate(scan, params).unwrap_err();
    let line: Vec<_> = (0..50)
        .map(|i| Point3::from(Vector3::repeat(f64::from(i))))
        .collect();
    let same = vec![Point3::new(1.0, 2.0, 3.0); 40];
    let default = CloudParams::default();
    let two = [Point3::origin(), Point3::new(1.0, 0.0, 0.0)];
    assert!(matches!(
        refuse(&Scan::default(), &default),
        CloudError::Scan(_)
    ));
    assert!(matches!(
        refuse(&cloud(&same), &default),
        CloudError::Coincident(40)
    ));
    assert!(matches!(
        refuse(&cloud(&same[..1]), &default),
        CloudError::Coincident(1)
    ));
    let error = refuse(&cloud(&two), &default);
    assert!(matches!(error, CloudError::TooFewPoints { found: 2 }));
    assert!(matches!(
        refuse(&cloud(&line), &default),
        CloudError::Collinear
    ));
    let mut points = grid(5, 5, 1.0);
    points[3].y = f64::NAN;
    assert!(matches!(
        refuse(&cloud(&points), &default),
        CloudError::Scan(_)
    ));
    let mut scan = cloud(&grid(5, 5, 1.0));
    let odd = |change: fn(&mut CloudParams)| {
        let mut params = CloudParams::default();
        change(&mut params);
        params
    };
    assert!(matches!(
        refuse(&scan, &odd(|p| p.gap = f64::NAN)),
        CloudError::Gap(_)
    ));
    let error = refuse(&scan, &odd(|p| p.neighbors = 3));
    assert!(
        error.to_string().contains("from 8 to 200, not 3"),
        "{error}"
    );
    scan.faces.push_row(&[0, 1, 2]);
    assert!(matches!(refuse(&scan, &default), CloudError::HasFaces(1)));
}

#[test]
fn three_points_are_one_triangle() {
    let points = [[0.0, 0.0], [1.0, 0.0], [0.2, 1.0]].map(|[x, y]| Point3::new(x, y, 0.0));
    assert_eq!(
        sound(&cloud(&points), &join_by(JoinChoice::Local))
            .report
            .triangles,
        1
    );
    assert_eq!(
        sound(&cloud(&points), &CloudParams::default())
            .report
            .triangles,
        1
    );
}

#[test]
fn clouds_that_are_no_surface_give_a_sound_mesh_or_an_error() {
    let mut rng = Rng::new(5, Stage::Synth, 0);
    let mut clouds: Vec<Vec<Point3<f64>>> = Vec::new();
    for count in [3, 4, 5, 8, 30, 600] {
        let mut random = |size: fn(&mut Rng) -> f64| -> Vec<_> {
            (0..count)
                .map(|_| Point3::from([(); 3].map(|()| size(&mut rng))))
                .collect()
        };
        clouds.push(random(Rng::uniform));
        clouds.push(random(|r| (3.0 * r.uniform()).floor()));
        clouds.push(random(|r| (8.0 * r.uniform()).floor()));
        clouds.push(random(|r| (300.0 * r.normal()).exp()));
        clouds.push(random(|r| 1e308 * (2.0 * r.uniform() - 1.0)));
        clouds.push(random(|r| {
            f64::MIN_POSITIVE * 1e-10 * (r.uniform() * 50.0).floor()
        }));
    }
    // A spiral, a fan around one point, a needle of rings.
    let turns = |step: f64, rise: f64, growth: f64| -> Vec<_> {
        (0..800)
            .map(f64::from)
            .map(|i| {
                let radius = 1.0 + growth * i;
                let angle = step * i;
                Point3::new(radius * angle.cos(), radius * angle.sin(), rise * i)
            })
            .collect()
    };
    clouds.push(turns(0.1, 0.0, 0.01));
    clouds.push([turns(0.01, 0.0, 0.0), vec![Point3::origin()]].concat());
    clouds.push(turns(2.4, 100.0, 0.0));
    for points in &clouds {
        for join in JOINS {
            let params = join_by(join);
            match triangulate(&cloud(points), &params) {
                Ok(_) => drop(sound(&cloud(points), &params)),
                Err(error) => assert!(error.to_string().len() > 30, "{error}"),
            }
        }
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let (_, scan) = synthetic(Kind::Column, 4000, Part::hole(0.05), 0.5);
    for join in [JoinChoice::Auto, JoinChoice::Local] {
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap()
                .install(|| triangulate(&scan, &join_by(join)).unwrap())
        });
        assert_eq!(one, three);
    }
}

/// A scan of the folder of real data, as points only, and its own mesh.
fn real(file: &str) -> Option<(TriMesh, Scan)> {
    let path = Path::new("../shared/data").join(file);
    if !path.exists() {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    }
    let mesh = crate::scan::read(&path, &ReadOptions::default())
        .unwrap()
        .mesh();
    let cloud = cloud(&mesh.positions);
    Some((mesh, cloud))
}

#[test]
fn the_rabbit_has_its_five_holes_again() {
    let Some((truth, scan)) = real("holes/bun_zipper.ply") else {
        return;
    };
    let result = sound(&scan, &CloudParams::default());
    assert_eq!(
        (
            result.report.holes + result.report.rims,
            result.report.pieces
        ),
        (5, 1)
    );
    assert!(result.report.left_over + result.report.outliers < 5);
    let truth = crate::mesh::vertex_normals(&truth);
    let found = crate::mesh::vertex_normals(&result.scan.mesh());
    assert!(truth.iter().zip(found).all(|(a, b)| a.dot(&b) >= 0.0));
}
