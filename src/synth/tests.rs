use approx::{assert_abs_diff_eq, assert_relative_eq};

use super::*;
use crate::base::BaseKind;
use crate::mesh::{self, Adjacency, TriMesh};

fn params(kind: Kind, vertices: usize, part: Part) -> SynthParams {
    SynthParams {
        kind,
        vertices,
        part,
        noise: 0.01,
        seed: 7,
    }
}

fn mesh_of(synthetic: &Synthetic) -> TriMesh {
    let scan = &synthetic.scan;
    let axis = |i: usize| match &scan.vertices.channels[i].values {
        Column::F64(values) => values,
        other => panic!("not double: {other:?}"),
    };
    TriMesh {
        positions: (0..scan.vertices.rows)
            .map(|v| Point3::new(axis(0)[v], axis(1)[v], axis(2)[v]))
            .collect(),
        triangles: scan.faces.rows().map(|f| f.try_into().unwrap()).collect(),
    }
}

/// Edges with one triangle only, counted at each vertex: 0 or 2 where no bow tie is.
fn assert_clean(mesh: &TriMesh) {
    assert_eq!(mesh::check(mesh), Ok(()));
    assert!(mesh.used_vertices().iter().all(|used| *used));
    let adjacency = Adjacency::new(mesh);
    assert_eq!(adjacency.components().1, 1);
    for v in 0..mesh.positions.len() {
        // A fan of t triangles has t neighbors if closed and t + 1 if open; two fans have more.
        let triangles = adjacency.triangles.row(v).len();
        let neighbors = adjacency.neighbors.row(v).len();
        assert!(neighbors == triangles || neighbors == triangles + 1, "{v}");
    }
}

/// Euler characteristic of the complete object.
fn euler(kind: Kind) -> i64 {
    match kind {
        Kind::GolfBall => 2,
        Kind::Bark | Kind::Column => 0,
        Kind::Waves | Kind::Noise | Kind::Bricks => 1,
    }
}

#[test]
fn complete_objects_are_clean_and_have_the_asked_size() {
    for kind in Kind::ALL {
        for vertices in [kind.least_vertices(), 1777, 6000] {
            let full = scan(&params(kind, vertices, Part::FULL)).unwrap();
            let mesh = mesh_of(&full);
            assert_clean(&mesh);
            assert_eq!(mesh::euler_characteristic(&mesh), euler(kind), "{kind}");
            let relative = mesh.positions.len() as f64 / vertices as f64;
            assert!((relative - 1.0).abs() <= 0.02, "{kind}: {relative}");
            assert!(
                full.full_index
                    .iter()
                    .copied()
                    .eq(0..tessellate::index(full.full_index.len()))
            );
        }
    }
}

#[test]
fn triangles_face_outward() {
    for kind in Kind::ALL {
        let full = scan(&params(kind, 4000, Part::FULL)).unwrap();
        let mesh = mesh_of(&full);
        for (v, normal) in mesh::vertex_normals(&mesh).iter().enumerate() {
            let outward = full.base.foot(&mesh.positions[v]).normal;
            assert!(normal.dot(&outward) > 0.0, "{kind}, vertex {v}");
        }
    }
}

#[test]
fn positions_are_feet_plus_heights_and_the_heights_have_no_mean() {
    for kind in Kind::ALL {
        let full = scan(&params(kind, 2000, Part::FULL)).unwrap();
        let mesh = mesh_of(&full);
        for (p, height) in mesh.positions.iter().zip(&full.heights) {
            let foot = full.base.foot(p);
            assert_abs_diff_eq!(foot.height, *height, epsilon = 1e-11);
            assert_relative_eq!(foot.point + foot.normal * *height, *p, epsilon = 1e-11);
        }
        let mean = full.heights.iter().sum::<f64>() / full.heights.len() as f64;
        assert!(mean.abs() < 5.0 * 0.01 / 2000f64.sqrt(), "{kind}: {mean}");
    }
    let kind = |k| scan(&params(k, 2000, Part::FULL)).unwrap().base.kind();
    assert_eq!(kind(Kind::Bricks), BaseKind::Plane);
    assert_eq!(kind(Kind::GolfBall), BaseKind::Sphere);
    assert_eq!(kind(Kind::Bark), BaseKind::Cylinder);
}

#[test]
fn parts_are_bit_for_bit_subsets_of_the_complete_object() {
    let direction = Vector3::new(1.0, 0.3, 0.2);
    let parts = [
        Part::hole(0.2),
        Part::view(direction),
        Part {
            view: Some(direction),
            hole: Some(0.1),
        },
    ];
    for kind in Kind::ALL {
        let full = scan(&params(kind, 3000, Part::FULL)).unwrap();
        for part in parts {
            let cut = scan(&params(kind, 3000, part)).unwrap();
            assert_eq!(cut.base, full.base);
            assert!(cut.full_index.is_sorted_by(|a, b| a < b));
            for (v, &whole) in cut.full_index.iter().enumerate() {
                let whole = whole as usize;
                assert_eq!(cut.heights[v].to_bits(), full.heights[whole].to_bits());
                for (a, b) in cut
                    .scan
                    .vertices
                    .channels
                    .iter()
                    .zip(&full.scan.vertices.channels)
                {
                    match (&a.values, &b.values) {
                        (Column::F64(a), Column::F64(b)) => {
                            assert_eq!(a[v].to_bits(), b[whole].to_bits());
                        }
                        (Column::U8(a), Column::U8(b)) => assert_eq!(a[v], b[whole]),
                        other => panic!("{other:?}"),
                    }
                }
            }
        }
    }
}

#[test]
fn a_hole_is_one_loop_that_holds_its_share() {
    for kind in Kind::ALL {
        for (vertices, fraction) in [(2500, 0.03), (2500, 0.1), (2500, 0.5), (9000, 0.3)] {
            for seed in 0..4 {
                let with = |part| {
                    let params = params(kind, vertices, part);
                    scan(&SynthParams { seed, ..params }).unwrap()
                };
                let full = with(Part::FULL).heights.len() as f64;
                let mesh = mesh_of(&with(Part::hole(fraction)));
                assert_clean(&mesh);
                assert_eq!(mesh::euler_characteristic(&mesh), euler(kind) - 1, "{kind}");
                let share = 1.0 - mesh.positions.len() as f64 / full;
                assert!(
                    (share / fraction - 1.0).abs() < 0.1,
                    "{kind} {fraction}: {share}"
                );
            }
        }
    }
}

#[test]
fn a_view_is_one_disc_of_what_faces_the_scanner() {
    for kind in [Kind::GolfBall, Kind::Bark, Kind::Column] {
        for hole in [None, Some(0.05), Some(0.5)] {
            let direction = Vector3::new(0.0, -5.0, 1.0);
            let part = Part {
                view: Some(direction),
                hole,
            };
            let seen = scan(&params(kind, 4000, part)).unwrap();
            let mesh = mesh_of(&seen);
            assert_clean(&mesh);
            for p in &mesh.positions {
                assert!(seen.base.foot(p).normal.dot(&direction) > 0.0);
            }
            let expected = 2000.0 * (1.0 - hole.unwrap_or(0.0));
            let relative = mesh.positions.len() as f64 / expected;
            assert!((relative - 1.0).abs() < 0.05, "{kind} {hole:?}: {relative}");
            let loops = 1 + i64::from(hole.is_some());
            assert_eq!(mesh::euler_characteristic(&mesh), 2 - loops, "{kind}");
        }
    }
}

#[test]
fn a_plane_is_seen_whole_or_not_at_all() {
    let whole = scan(&params(Kind::Waves, 900, Part::FULL)).unwrap();
    let seen = scan(&params(
        Kind::Waves,
        900,
        Part::view(Vector3::new(3.0, 0.0, 0.1)),
    ))
    .unwrap();
    assert_eq!(whole.scan, seen.scan);
    let behind = Part::view(Vector3::new(3.0, 0.0, -0.1));
    assert_eq!(
        scan(&params(Kind::Waves, 900, behind)),
        Err(SynthError::NothingInView(Kind::Waves))
    );
    let along_the_axis = Part::view(Vector3::z());
    assert_eq!(
        scan(&params(Kind::Bark, 900, along_the_axis)),
        Err(SynthError::NothingInView(Kind::Bark))
    );
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_another() {
    for kind in Kind::ALL {
        let with = |seed| {
            let params = params(kind, 1500, Part::hole(0.1));
            scan(&SynthParams { seed, ..params }).unwrap()
        };
        assert_eq!(with(1), with(1));
        assert_ne!(with(1), with(2));
    }
}

#[test]
fn noise_has_the_asked_deviation_and_moves_nothing_else() {
    let with = |noise| {
        let params = params(Kind::Bark, 5000, Part::hole(0.1));
        scan(&SynthParams { noise, ..params }).unwrap()
    };
    let (clean, noisy) = (with(0.0), with(0.4));
    assert_eq!(clean.full_index, noisy.full_index);
    assert_eq!(clean.scan.faces, noisy.scan.faces);
    assert_eq!(clean.base, noisy.base);
    let n = clean.heights.len() as f64;
    let differences = clean.heights.iter().zip(&noisy.heights).map(|(a, b)| b - a);
    let variance = differences.map(|d| d * d).sum::<f64>() / n;
    // Five standard errors.
    assert!((variance / 0.16 - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
}

#[test]
fn the_golf_ball_is_dimpled_over_four_fifths() {
    let ball = scan(&SynthParams {
        vertices: 20_000,
        ..SynthParams::default()
    })
    .unwrap();
    let mesh = mesh_of(&ball);
    let BaseSurface::Sphere(sphere) = ball.base else {
        panic!("not a sphere: {:?}", ball.base)
    };
    let depth = |p: &Point3<f64>| 21.35 - (p - sphere.center).norm();
    let deepest = mesh.positions.iter().map(depth).fold(0.0, f64::max);
    assert!((0.24..0.2501).contains(&deepest), "{deepest}");
    // At the rim's middle line the rounding leaves RIM_ROUNDING / 4 of the depth.
    let dimpled = mesh
        .positions
        .iter()
        .filter(|p| depth(p) > 0.25 * 0.03)
        .count();
    assert_abs_diff_eq!(dimpled as f64 / 20_000.0, 0.8, epsilon = 0.02);
    // Bottoms: vertices deeper than all vertices within two edges.
    let adjacency = Adjacency::new(&mesh);
    let is_bottom = |v: usize| {
        let near = |w: u32| adjacency.neighbors.row(w as usize).iter();
        let around = adjacency.neighbors.row(v).iter().flat_map(|w| near(*w));
        let own = depth(&mesh.positions[v]);
        own > 0.2
            && around
                .filter(|w| **w as usize != v)
                .all(|w| own > depth(&mesh.positions[*w as usize]))
    };
    let bottoms = (0..mesh.positions.len()).filter(|v| is_bottom(*v)).count();
    assert!((290..340).contains(&bottoms), "{bottoms}");
}

#[test]
fn only_bark_and_bricks_are_coloured() {
    for kind in Kind::ALL {
        let synthetic = scan(&params(kind, 1500, Part::FULL)).unwrap();
        let names = synthetic.scan.vertices.channels.iter();
        let names: Vec<&str> = names.map(|c| c.name.as_str()).collect();
        if matches!(kind, Kind::Bark | Kind::Bricks) {
            assert_eq!(names, ["x", "y", "z", "red", "green", "blue"]);
        } else {
            assert_eq!(names, ["x", "y", "z"]);
        }
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let fine = params(Kind::Waves, 900, Part::FULL);
    let error = |change: fn(&mut SynthParams)| {
        let mut params = fine.clone();
        change(&mut params);
        scan(&params).unwrap_err()
    };
    for kind in Kind::ALL {
        let few = params(kind, kind.least_vertices() - 1, Part::FULL);
        assert!(matches!(scan(&few), Err(SynthError::TooFewVertices { .. })));
    }
    assert_eq!(
        error(|p| p.vertices = MOST_VERTICES + 1),
        SynthError::TooManyVertices(MOST_VERTICES + 1)
    );
    assert_eq!(error(|p| p.noise = -0.1), SynthError::Noise(-0.1));
    assert!(matches!(
        error(|p| p.noise = f64::NAN),
        SynthError::Noise(_)
    ));
    assert!(matches!(
        error(|p| p.noise = f64::INFINITY),
        SynthError::Noise(_)
    ));
    assert_eq!(
        error(|p| p.part = Part::hole(0.0)),
        SynthError::Fraction(0.0)
    );
    assert_eq!(
        error(|p| p.part = Part::hole(0.51)),
        SynthError::Fraction(0.51)
    );
    assert!(matches!(
        error(|p| p.part = Part::hole(f64::NAN)),
        SynthError::Fraction(_)
    ));
    assert_eq!(
        error(|p| p.part = Part::view(Vector3::zeros())),
        SynthError::Direction
    );
    assert_eq!(
        error(|p| p.part = Part::view(Vector3::new(f64::NAN, 1.0, 0.0))),
        SynthError::Direction
    );
}

#[test]
fn params_survive_serialization() {
    let all = params(Kind::GolfBall, 2000, Part::hole(0.25));
    let text = serde_json::to_string(&all).unwrap();
    assert_eq!(serde_json::from_str::<SynthParams>(&text).unwrap(), all);
    assert_eq!(
        serde_json::from_str::<SynthParams>("{}").unwrap(),
        SynthParams::default()
    );
}
