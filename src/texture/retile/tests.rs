use std::collections::{BTreeSet, HashMap};
use std::f64::consts::TAU;
use std::path::Path;

use nalgebra::{Point3, Vector3};

use super::{OnTriangle, Retiled, retile};
use crate::mesh::{
    Adjacency, TriMesh, boundary_loops, check, euler_characteristic, triangle_area, triangle_normal,
};
use crate::repair::{RepairParams, repair};
use crate::rng::{Rng, Stage};
use crate::scan::{ReadOptions, read};

/// Euler characteristic, components and boundary loops.
fn topology(mesh: &TriMesh) -> (i64, usize, usize) {
    let adjacency = Adjacency::new(mesh);
    let (components, _) = adjacency.components();
    let used = mesh.triangles.iter().map(|t| components[t[0] as usize]);
    let loops = boundary_loops(mesh, &adjacency).len();
    (
        euler_characteristic(mesh),
        used.collect::<BTreeSet<_>>().len(),
        loops,
    )
}

fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriMesh {
    TriMesh {
        positions: positions.iter().map(|p| Point3::from(*p)).collect(),
        triangles: triangles.to_vec(),
    }
}

fn tetrahedron() -> TriMesh {
    mesh(
        &[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ],
        &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    )
}

fn block(size: [f64; 3]) -> TriMesh {
    let corner = |i: u32| [0, 1, 2].map(|axis| f64::from(i >> axis & 1) * size[axis]);
    let triangles = [
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    mesh(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner), &triangles)
}

/// A chart of `columns` by `rows` cells, closed around itself where `around` says so.
fn chart(
    [columns, rows]: [u32; 2],
    around: [bool; 2],
    at: impl Fn(f64, f64) -> [f64; 3],
) -> TriMesh {
    let counts = [
        columns + u32::from(!around[0]),
        rows + u32::from(!around[1]),
    ];
    let number = |i: u32, j: u32| i % counts[0] + counts[0] * (j % counts[1]);
    let share = |i: u32, n: u32| f64::from(i) / f64::from(n);
    let vertices = (0..counts[0] * counts[1]).map(|v| {
        let (i, j) = (v % counts[0], v / counts[0]);
        Point3::from(at(share(i, columns), share(j, rows)))
    });
    let cells = (0..columns * rows).flat_map(|cell| {
        let (i, j) = (cell % columns, cell / columns);
        let [a, b] = [number(i, j), number(i + 1, j)];
        let [d, c] = [number(i, j + 1), number(i + 1, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriMesh {
        positions: vertices.collect(),
        triangles: cells.collect(),
    }
}

fn torus() -> TriMesh {
    chart([24, 10], [true, true], |u, v| {
        let (u, v) = (TAU * u, TAU * v);
        let radius = 1.0 + 0.4 * v.cos();
        [radius * u.cos(), radius * u.sin(), 0.4 * v.sin()]
    })
}

fn cylinder() -> TriMesh {
    chart([16, 5], [true, false], |u, v| {
        [(TAU * u).cos(), (TAU * u).sin(), 2.0 * v]
    })
}

fn square() -> TriMesh {
    chart([1, 1], [false, false], |u, v| [u, v, 0.0])
}

/// A cube with every triangle cut in four several times, blown up.
fn sphere(cuts: usize) -> TriMesh {
    let mut sphere = block([2.0; 3]);
    for _ in 0..cuts {
        let mut middles = HashMap::new();
        let mut points = sphere.positions.clone();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push(nalgebra::center(&points[a as usize], &points[b as usize]));
                u32::try_from(points.len() - 1).unwrap()
            })
        };
        let quarters = |&[a, b, c]: &[u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        sphere.triangles = sphere.triangles.iter().flat_map(quarters).collect();
        sphere.positions = points;
    }
    for p in &mut sphere.positions {
        *p = Point3::from((p.coords - Vector3::repeat(1.0)).normalize());
    }
    sphere
}

fn together(parts: &[TriMesh]) -> TriMesh {
    let mut all = TriMesh::default();
    for part in parts {
        let first = u32::try_from(all.positions.len()).unwrap();
        all.positions.extend(&part.positions);
        let moved = part.triangles.iter().map(|t| t.map(|v| v + first));
        all.triangles.extend(moved);
    }
    all
}

fn scaled(mut mesh: TriMesh, scale: f64, shift: [f64; 3]) -> TriMesh {
    for p in &mut mesh.positions {
        *p = *p * scale + Vector3::from(shift);
    }
    mesh
}

fn point(mesh: &TriMesh, place: &OnTriangle) -> Point3<f64> {
    let corners = mesh.corners(place.triangle as usize);
    let parts = corners.iter().zip(place.weights);
    Point3::from(parts.map(|(p, w)| p.coords * w).sum::<Vector3<f64>>())
}

/// What must hold whatever the input.
fn assert_sound(input: &TriMesh, level: &Retiled) {
    assert_eq!(check(&level.mesh), Ok(()));
    assert!(level.mesh.used_vertices().iter().all(|used| *used));
    assert_eq!(level.report.vertices, level.mesh.positions.len());
    assert_eq!(level.places.len(), level.mesh.positions.len());
    let size = crate::mesh::bounding_diagonal(&input.positions);
    for (p, place) in level.mesh.positions.iter().zip(&level.places) {
        assert!(place.weights.iter().all(|w| *w >= 0.0));
        assert!((place.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((p - point(input, place)).norm() <= 1e-14 * size);
    }
}

/// Triangles that face away from the input at their corners.
fn turned(input: &TriMesh, level: &Retiled) -> usize {
    let normal = |v: &u32| {
        let triangle = level.places[*v as usize].triangle as usize;
        triangle_normal(input.corners(triangle)).try_normalize(0.0)
    };
    let faces = level.mesh.triangles.iter().enumerate();
    faces
        .filter(|(f, t)| {
            let around: Vector3<f64> = t.iter().filter_map(normal).sum();
            triangle_normal(level.mesh.corners(*f)).dot(&around) <= 0.0
        })
        .count()
}

/// Levels of a mesh on which every number of vertices can be reached, evenly.
fn assert_even(input: &TriMesh, vertices: &[usize]) {
    let levels = retile(input, vertices);
    assert_eq!(levels.len(), vertices.len());
    for (level, count) in levels.iter().zip(vertices) {
        assert_sound(input, level);
        assert_eq!(topology(&level.mesh), topology(input));
        assert_eq!(level.report.vertices, *count);
        assert!(level.report.edge_variation < 0.2, "{:?}", level.report);
        assert_eq!(turned(input, level), 0);
    }
}

#[test]
fn a_sphere_is_tiled_evenly_by_as_many_vertices_as_asked_for() {
    assert_even(&sphere(2), &[800, 200, 50]);
}

#[test]
fn a_torus_keeps_its_hole() {
    assert_even(&torus(), &[1000, 250, 100]);
}

#[test]
fn a_cube_of_twelve_triangles_gets_vertices_on_its_faces() {
    assert_even(&block([1.0; 3]), &[1200, 300, 75]);
}

#[test]
fn a_tetrahedron_can_be_refined_and_come_back_to_four_vertices() {
    let levels = retile(&tetrahedron(), &[300, 4, 0]);
    for (level, vertices) in levels.iter().zip([300, 4, 4]) {
        assert_sound(&tetrahedron(), level);
        assert_eq!(level.report.vertices, vertices);
        assert_eq!(topology(&level.mesh), (2, 1, 0));
    }
}

#[test]
fn a_square_keeps_its_outline() {
    assert_even(&square(), &[600, 150, 40]);
    for level in retile(&square(), &[600, 150, 40]) {
        let faces = 0..level.mesh.triangles.len();
        let area: f64 = faces.map(|f| triangle_area(level.mesh.corners(f))).sum();
        assert!((area - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_ends_of_a_cylinder_stay_its_ends() {
    assert_even(&cylinder(), &[800, 200, 60]);
    for level in retile(&cylinder(), &[800, 200, 60]) {
        for rim in boundary_loops(&level.mesh, &Adjacency::new(&level.mesh)) {
            let heights: Vec<f64> = (rim.vertices.iter())
                .map(|v| level.mesh.positions[*v as usize].z)
                .collect();
            let end = heights[0];
            assert!(end.abs() < 1e-9 || (end - 2.0).abs() < 1e-9);
            assert!(heights.iter().all(|z| (z - end).abs() < 1e-9));
        }
    }
}

#[test]
fn components_far_below_the_edge_length_survive() {
    let crumb = scaled(sphere(1), 1e-3, [3.0, 0.0, 0.0]);
    let chip = scaled(square(), 1e-3, [0.0, 3.0, 0.0]);
    let input = together(&[sphere(2), crumb, chip]);
    for (level, count) in retile(&input, &[400, 100]).iter().zip([400, 100]) {
        assert_sound(&input, level);
        assert_eq!(topology(&level.mesh), (2 + 2 + 1, 3, 1));
        assert_eq!(level.report.vertices, count);
    }
}

#[test]
fn fans_that_meet_in_a_point_get_a_vertex_each() {
    let fans = mesh(
        &[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [-1.0, -1.0, 0.0],
            [9.0, 9.0, 9.0],
        ],
        &[[0, 1, 2], [0, 3, 4]],
    );
    for level in retile(&fans, &[100, 25]) {
        assert_sound(&fans, &level);
        assert_eq!(topology(&level.mesh), (2, 2, 2));
    }
}

#[test]
fn needles_and_triangles_without_area_do_no_harm() {
    // A fan of needles around the middle of one side, and a strip whose upper vertices lie on its edge.
    let fan = chart([200, 1], [false, false], |u, v| {
        [u, if v > 0.0 { 1.0 } else { 0.0 }, 0.0]
    });
    let flat = chart([10, 2], [false, false], |u, v| {
        [u, if v > 0.6 { 1.0 } else { 0.0 }, 0.0]
    });
    for (input, name) in [(fan, "fan"), (flat, "flat")] {
        for (level, count) in retile(&input, &[200, 50]).iter().zip([200, 50]) {
            assert_sound(&input, level);
            assert_eq!(topology(&level.mesh), (1, 1, 1), "{name}");
            assert_eq!(level.report.vertices, count, "{name}");
            assert!(
                level.report.edge_variation < 0.3,
                "{name}: {:?}",
                level.report
            );
        }
    }
}

#[test]
fn two_triangles_back_to_back_become_a_closed_surface() {
    let pillow = mesh(
        &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        &[[0, 1, 2], [0, 2, 1]],
    );
    for level in retile(&pillow, &[60, 3]) {
        assert_sound(&pillow, &level);
        assert_eq!(topology(&level.mesh), (2, 1, 0));
    }
}

#[test]
fn the_sheets_of_a_thin_slab_are_not_mixed_up() {
    let slab = block([1.0, 1.0, 0.01]);
    for level in retile(&slab, &[900, 225]) {
        assert_sound(&slab, &level);
        assert_eq!(topology(&level.mesh), (2, 1, 0));
        let side = |v: &u32| match level.places[*v as usize].triangle {
            0 | 1 => -1.0,
            2 | 3 => 1.0,
            _ => 0.0,
        };
        for (f, t) in level.mesh.triangles.iter().enumerate() {
            let sides = [0, 1, 2].map(|k| side(&t[k]));
            let up = triangle_normal(level.mesh.corners(f)).z;
            if sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0) {
                assert!(up * sides[0] > 0.0);
            }
        }
        let faces = 0..level.mesh.triangles.len();
        let area: f64 = faces.map(|f| triangle_area(level.mesh.corners(f))).sum();
        // Around the rim, 4 long on both sheets, a third of an edge is cut off; sheets that had mixed would be
        // folded there and inside.
        assert!(area < 2.05 && area > 2.04 - 8.0 * 0.45 * level.report.mean_edge);
    }
}

#[test]
fn levels_are_the_same_for_any_number_of_threads() {
    let input = together(&[torus(), scaled(cylinder(), 0.5, [3.0, 0.0, 0.0])]);
    let [one, two] = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| retile(&input, &[1500, 400]))
    });
    for (one, two) in one.iter().zip(&two) {
        assert_eq!(one.mesh, two.mesh);
        assert_eq!(one.places, two.places);
    }
}

#[test]
fn whatever_the_triangles_levels_come_out_sound() {
    for seed in 0..60 {
        let mut rng = Rng::new(seed, Stage::Synth, 9);
        let vertices = 3 + rng.index(20);
        let scale = 10f64.powi(3 * (i32::try_from(rng.index(5)).unwrap() - 2));
        // On a lattice, so that points coincide and triangles have no area.
        let positions = (0..vertices).map(|_| {
            Point3::from([0; 3].map(|_| scale * f64::from(u32::try_from(rng.index(4)).unwrap())))
        });
        let positions = positions.collect();
        let number = |rng: &mut Rng| u32::try_from(rng.index(vertices)).unwrap();
        let triangles = (0..rng.index(40)).map(|_| [0; 3].map(|_| number(&mut rng)));
        let dirty = TriMesh {
            triangles: triangles.collect(),
            positions,
        };
        for level in retile(&dirty, &[rng.index(150), rng.index(20)]) {
            assert_sound(&dirty, &level);
        }
    }
}

#[test]
fn an_empty_mesh_has_empty_levels() {
    for mesh in [TriMesh::default(), mesh(&[[0.0; 3]], &[])] {
        let levels = retile(&mesh, &[10, 5]);
        assert!(levels.iter().all(|level| level.mesh == TriMesh::default()));
        assert_eq!(levels.len(), 2);
    }
}

#[test]
fn real_meshes_keep_their_topology() {
    let files = [
        "transfer/cow.obj",
        "holes/many_small_holes.ply",
        "relief/scallop_shell_rgb.ply",
    ];
    for file in files {
        let path = Path::new("../shared/data").join(file);
        if !path.exists() {
            println!("skipped: {} is not there", path.display());
            continue;
        }
        let scan = read(&path, &ReadOptions::default()).unwrap();
        let input = repair(scan, &RepairParams::default()).scan.mesh();
        let levels = retile(&input, &[3000, 750]);
        for (level, count) in levels.iter().zip([3000, 750]) {
            assert_sound(&input, level);
            assert_eq!(level.report.vertices, count, "{file}");
            let evenness = level.report.edge_variation;
            assert!(evenness < 0.2, "{file}: {evenness}");
            // Fans that meet in a point in the input are apart in every level.
            assert_eq!(topology(&level.mesh), topology(&levels[0].mesh), "{file}");
        }
    }
}
