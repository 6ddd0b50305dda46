//! Meshes for the tests of this room.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::mesh::{Adjacency, TriMesh};

/// A flat square of `n` by `n` cells from 0 to 1, its inner vertices moved a little, so that it is no lattice.
pub(super) fn plane(n: u32) -> TriMesh {
    let number = |i: u32, j: u32| j * (n + 1) + i;
    let at = |v: u32| {
        let [i, j] = [v % (n + 1), v / (n + 1)];
        let is_inner = |k: u32| k > 0 && k < n;
        let jitter = match is_inner(i) && is_inner(j) {
            true => [(7.0 * f64::from(v)).sin(), (11.0 * f64::from(v)).cos()].map(|x| 0.2 * x),
            false => [0.0; 2],
        };
        let [x, y] =
            [(i, jitter[0]), (j, jitter[1])].map(|(k, by)| (f64::from(k) + by) / f64::from(n));
        Point3::new(x, y, 0.0)
    };
    let cells = (0..n * n).flat_map(|cell| {
        let [i, j] = [cell % n, cell / n];
        let [a, b] = [number(i, j), number(i + 1, j)];
        let [d, c] = [number(i, j + 1), number(i + 1, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriMesh {
        positions: (0..(n + 1) * (n + 1)).map(at).collect(),
        triangles: cells.collect(),
    }
}

/// A slab with this many holes through it, smoothed: a sphere, a torus, a double torus.
pub(super) fn slab(holes: u32) -> TriMesh {
    let holes = i32::try_from(holes).expect("few");
    let size = [3 + 6 * holes.max(1), 9, 3];
    let is_inside = |cell: [i32; 3]| {
        let within = (0..3).all(|k| (0..size[k]).contains(&cell[k]));
        let [along, across] = [(cell[0] - 3).rem_euclid(6), cell[1] - 3];
        let in_hole = cell[0] >= 3 && along < 3 && (0..3).contains(&across);
        within && !(holes > 0 && in_hole)
    };
    let mut mesh = skin(size, is_inside);
    let neighbors = Adjacency::new(&mesh).neighbors;
    for _ in 0..10 {
        let mean = |v: usize| {
            let row = neighbors.row(v);
            let sum: Vector3<f64> = row.iter().map(|u| mesh.positions[*u as usize].coords).sum();
            Point3::from(sum / row.len() as f64)
        };
        mesh.positions = (0..mesh.positions.len()).map(mean).collect();
    }
    mesh
}

/// The surface of cells.
fn skin(size: [i32; 3], is_inside: impl Fn([i32; 3]) -> bool) -> TriMesh {
    let mut numbers = BTreeMap::new();
    let mut mesh = TriMesh::default();
    let cells = (0..size[0] * size[1] * size[2])
        .map(|i| [i % size[0], i / size[0] % size[1], i / size[0] / size[1]]);
    for cell in cells.filter(|cell| is_inside(*cell)) {
        for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
            let mut beyond = cell;
            beyond[axis] += 2 * side - 1;
            if is_inside(beyond) {
                continue;
            }
            let mut corner = |a: i32, b: i32| {
                let mut at = cell;
                at[axis] += side;
                at[(axis + 1) % 3] += a;
                at[(axis + 2) % 3] += b;
                *numbers.entry(at).or_insert_with(|| {
                    mesh.positions.push(Point3::from(at.map(f64::from)));
                    u32::try_from(mesh.positions.len() - 1).expect("few")
                })
            };
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            let quad = if side == 1 {
                [a, b, c, d]
            } else {
                [a, d, c, b]
            };
            let [a, b, c, d] = quad;
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[test]
fn slabs_have_as_many_holes_as_asked_for() {
    for (holes, characteristic) in [(0, 2), (1, 0), (2, -2)] {
        let mesh = slab(holes);
        assert_eq!(crate::mesh::check(&mesh), Ok(()));
        assert_eq!(crate::mesh::euler_characteristic(&mesh), characteristic);
    }
    assert_eq!(crate::mesh::euler_characteristic(&plane(5)), 1);
}
