use std::f64::consts::TAU;

use super::super::shape::test_shapes::{grid, icosphere, together};
use super::*;
use crate::mesh::{Adjacency, boundary_loops, check, euler_characteristic};

/// A torus of 40 by 20 vertices, of radii 1 and 0.4.
fn torus() -> TriMesh {
    let number = |i: u32, j: u32| (i % 40) * 20 + j % 20;
    let place = |v: u32| {
        let [a, b] = [f64::from(v / 20) / 40.0, f64::from(v % 20) / 20.0].map(|x| TAU * x);
        let radius = 1.0 + 0.4 * b.cos();
        Point3::new(radius * a.cos(), radius * a.sin(), 0.4 * b.sin())
    };
    let cells = (0..800).flat_map(|cell| {
        let [i, j] = [cell / 20, cell % 20];
        let [a, b] = [number(i, j), number(i + 1, j)];
        let [c, d] = [number(i, j + 1), number(i + 1, j + 1)];
        [[a, b, d], [a, d, c]]
    });
    TriMesh {
        positions: (0..800).map(place).collect(),
        triangles: cells.collect(),
    }
}

/// A flat square with a square hole.
fn disc_with_a_hole() -> TriMesh {
    let mut mesh = grid(24, 24, |x, y| [x, y, 0.0]);
    let is_hole = |v: &u32| [v % 24, v / 24].iter().all(|k| (9..15).contains(k));
    mesh.triangles.retain(|t| !t.iter().all(is_hole));
    // Vertices without faces are no part of it.
    let mut number = vec![GONE; 24 * 24];
    let mut used = TriMesh::default();
    for triangle in &mesh.triangles {
        for v in triangle {
            if number[*v as usize] == GONE {
                number[*v as usize] = u32::try_from(used.positions.len()).unwrap();
                used.positions.push(mesh.positions[*v as usize]);
            }
        }
        used.triangles.push(triangle.map(|v| number[v as usize]));
    }
    used
}

fn topology(mesh: &TriMesh) -> (i64, usize, usize) {
    let adjacency = Adjacency::new(mesh);
    let loops = boundary_loops(mesh, &adjacency).len();
    (euler_characteristic(mesh), loops, adjacency.components().1)
}

fn collapsed(mesh: &TriMesh, count: usize) -> (TriMesh, Vec<u32>) {
    let mut collapse = Collapse::new(mesh);
    collapse.to(count);
    let (coarse, standing) = collapse.now();
    assert_eq!(coarse.positions.len(), collapse.count());
    (coarse, standing)
}

#[test]
fn topology_stays_as_it_is_and_every_mesh_is_a_manifold() {
    let sphere = icosphere(3);
    let mut other = sphere.clone();
    other.positions.iter_mut().for_each(|p| p.x += 3.0);
    let shapes = [
        (sphere.clone(), (2, 0, 1)),
        (torus(), (0, 0, 1)),
        (disc_with_a_hole(), (0, 2, 1)),
        (together(sphere, &other), (4, 0, 2)),
    ];
    for (mesh, truth) in shapes {
        assert_eq!(topology(&mesh), truth);
        for count in [2, 4, 8].map(|by| mesh.positions.len() / by) {
            let (coarse, _) = collapsed(&mesh, count);
            assert_eq!(coarse.positions.len(), count);
            assert_eq!(topology(&coarse), truth, "{count} vertices");
            assert_eq!(check(&coarse), Ok(()));
            assert!(coarse.used_vertices().iter().all(|used| *used));
        }
    }
}

#[test]
fn as_far_down_as_it_goes_topology_still_stays() {
    for (mesh, truth) in [
        (icosphere(2), (2, 0, 1)),
        (torus(), (0, 0, 1)),
        (disc_with_a_hole(), (0, 2, 1)),
    ] {
        let (coarse, standing) = collapsed(&mesh, 0);
        assert_eq!(topology(&coarse), truth);
        assert_eq!(check(&coarse), Ok(()));
        assert!(coarse.positions.len() < 60, "{}", coarse.positions.len());
        let count = u32::try_from(coarse.positions.len()).unwrap();
        assert!((0..count).all(|v| standing.contains(&v)));
        assert!(standing.iter().all(|v| *v < count));
    }
}

#[test]
fn nothing_is_folded_over() {
    type Outward = fn(Vector3<f64>) -> Vector3<f64>;
    let outwards: [(TriMesh, Outward); 3] = [
        (icosphere(3), |p| p),
        (torus(), |p| {
            let ring = Vector3::new(p.x, p.y, 0.0).normalize();
            p - ring
        }),
        (disc_with_a_hole(), |_| Vector3::z()),
    ];
    for (mesh, outward) in outwards {
        let (coarse, _) = collapsed(&mesh, mesh.positions.len() / 4);
        for f in 0..coarse.triangles.len() {
            let corners = coarse.corners(f);
            let middle = (corners[0].coords + corners[1].coords + corners[2].coords) / 3.0;
            let normal = triangle_normal(corners).normalize();
            let cosine = normal.dot(&outward(middle).normalize());
            assert!(cosine > 0.2, "triangle {f}: {cosine}");
        }
    }
}

#[test]
fn the_shortest_edge_is_the_first_and_its_ends_meet_in_the_middle() {
    let mut mesh = grid(12, 12, |x, y| [x, y, 0.0]);
    let [a, b] = [5 * 12 + 5, 5 * 12 + 6];
    mesh.positions[a].x += 0.8;
    let (coarse, standing) = collapsed(&mesh, 143);
    assert_eq!(standing[a], standing[b]);
    let merged = coarse.positions[standing[a] as usize];
    assert!((merged - Point3::new(5.9, 5.0, 0.0)).norm() < 1e-12);
    let mut others: Vec<u32> = standing.clone();
    others.sort_unstable();
    others.dedup();
    assert_eq!(others.len(), 143, "no other vertices have become one");
}

#[test]
fn an_edge_to_the_rim_is_drawn_to_the_rim() {
    let mut mesh = grid(12, 12, |x, y| [x, y, 0.0]);
    let [rim, inner] = [5, 12 + 5];
    mesh.positions[inner].y = 0.1;
    let (coarse, standing) = collapsed(&mesh, 143);
    assert_eq!(standing[rim], standing[inner]);
    let merged = coarse.positions[standing[rim] as usize];
    assert_eq!(merged, mesh.positions[rim]);
}

#[test]
fn half_of_a_lattice_of_equal_edges_has_edges_of_like_lengths() {
    let (coarse, _) = collapsed(&icosphere(3), 321);
    let lengths = crate::mesh::edge_lengths(&coarse);
    let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    assert!(longest < 2.5 * mean, "{longest} of {mean}");
}

#[test]
fn the_least_meshes_stay_as_they_are() {
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let least = |triangles: &[[u32; 3]], count: usize| TriMesh {
        positions: points[..count].iter().map(|p| Point3::from(*p)).collect(),
        triangles: triangles.to_vec(),
    };
    let tetrahedron = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    for mesh in [least(&tetrahedron, 4), least(&[[0, 1, 2]], 3)] {
        let (coarse, standing) = collapsed(&mesh, 1);
        assert_eq!(coarse, mesh);
        assert!((0u32..).zip(&standing).all(|(v, own)| v == *own));
    }
    // Without its floor the tetrahedron is a cap with a rim.
    let cap = least(&tetrahedron[1..], 4);
    let (coarse, _) = collapsed(&cap, 1);
    assert_eq!(topology(&coarse), (1, 1, 1));
    assert_eq!(check(&coarse), Ok(()));
}

#[test]
fn steps_on_the_way_make_no_difference() {
    let mesh = torus();
    let mut in_steps = Collapse::new(&mesh);
    for count in [700, 431, 100] {
        in_steps.to(count);
    }
    let mut at_once = Collapse::new(&mesh);
    at_once.to(100);
    assert_eq!(in_steps.now(), at_once.now());
}
