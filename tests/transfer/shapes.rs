//! Meshes and colors of them.

use std::f64::consts::TAU;

use nalgebra::{Point3, Rotation3, Vector3};
use relievo::mesh::TriMesh;
use relievo::scan::Scan;

use crate::common::to_scan;

/// A sphere of radius 1: an octahedron, each face cut into `cuts` by `cuts` triangles.
pub(crate) fn ball(cuts: u32) -> TriMesh {
    let mut numbers = std::collections::BTreeMap::new();
    let mut mesh = TriMesh::default();
    let whole = f64::from(cuts);
    for [x, y, z] in [
        [1i32, 1, 1],
        [-1, 1, 1],
        [-1, -1, 1],
        [1, -1, 1],
        [1, 1, -1],
        [-1, 1, -1],
        [-1, -1, -1],
        [1, -1, -1],
    ] {
        let mut vertex = |i: u32, j: u32| {
            let parts = [cuts - i - j, i, j].map(|part| i32::try_from(part).expect("few"));
            let place = [x * parts[0], y * parts[1], z * parts[2]];
            *numbers.entry(place).or_insert_with(|| {
                let p = Vector3::from(place.map(f64::from)) / whole;
                mesh.positions.push(Point3::from(p.normalize()));
                u32::try_from(mesh.positions.len() - 1).expect("few")
            })
        };
        let mut triangles = Vec::new();
        for i in 0..cuts {
            for j in 0..cuts - i {
                triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                if i + j + 2 <= cuts {
                    triangles.push([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
                }
            }
        }
        let turned = x * y * z < 0;
        let facing = |[a, b, c]: [u32; 3]| if turned { [a, c, b] } else { [a, b, c] };
        mesh.triangles.extend(triangles.into_iter().map(facing));
    }
    mesh
}

/// What lies in a direction from the middle of a body with three limbs, no two alike.
fn limbed(direction: &Vector3<f64>) -> Point3<f64> {
    let limbs = [
        ([0.0, 1.0, 0.2], 0.9, 0.10),
        ([1.0, -0.3, 0.1], 0.6, 0.14),
        ([-0.5, -0.4, -1.0], 0.4, 0.08),
    ];
    let radius: f64 = (limbs.iter())
        .map(|(axis, length, width)| {
            let axis = Vector3::from(*axis).normalize();
            length * (-(1.0 - axis.dot(direction)) / width).exp()
        })
        .sum();
    Point3::from(direction * (1.0 + radius))
}

/// A body with three limbs, of a ball that is cut like that after a turn.
pub(crate) fn body(cuts: u32, turn: f64) -> TriMesh {
    let turn = Rotation3::from_euler_angles(turn, 2.0 * turn, 3.0 * turn);
    let ball = ball(cuts);
    TriMesh {
        positions: (ball.positions.iter())
            .map(|p| limbed(&(turn * p.coords)))
            .collect(),
        triangles: ball.triangles,
    }
}

/// Turned about the y axis, by a fifth of a whole turn, and half as large again.
pub(crate) fn carried(mesh: &TriMesh) -> TriMesh {
    let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), TAU / 5.0);
    TriMesh {
        positions: mesh.positions.iter().map(|p| turn * p * 1.5).collect(),
        triangles: mesh.triangles.clone(),
    }
}

/// Colors of a body's places: waves about as long as a limb is thick.
pub(crate) fn hues(p: &Point3<f64>) -> [f64; 3] {
    [
        0.5 + 0.4 * (3.0 * p.x + 1.0).sin(),
        0.5 + 0.4 * (2.5 * p.y - p.z).cos(),
        0.5 + 0.4 * (3.5 * p.z + 0.5 * p.x).sin(),
    ]
}

/// A scan of a mesh with colors.
pub(crate) fn colored(mesh: &TriMesh, color: impl Fn(&Point3<f64>) -> [f64; 3]) -> Scan {
    let mut scan = to_scan(mesh);
    let colors: Vec<[f64; 3]> = mesh.positions.iter().map(color).collect();
    scan.vertices.set_colors(&colors);
    scan
}

/// Mean distance of colors (of 255), over all channels.
pub(crate) fn mean_error(found: &Scan, expected: impl Fn(usize) -> [f64; 3]) -> f64 {
    let colors = found.colors().expect("it has colors");
    let errors = colors.iter().enumerate().map(|(v, color)| {
        let pairs = color.iter().zip(expected(v));
        pairs.map(|(a, b)| 255.0 * (a - b).abs()).sum::<f64>() / 3.0
    });
    errors.sum::<f64>() / colors.len() as f64
}

/// A flat open square of side 1 around the origin, facing z, of so many cells a side.
pub(crate) fn plate(cells: u32, height: impl Fn(f64, f64) -> f64) -> TriMesh {
    let at = |i: u32| f64::from(i) / f64::from(cells) - 0.5;
    let row = cells + 1;
    let points = (0..row * row).map(|v| {
        let (x, y) = (at(v % row), at(v / row));
        Point3::new(x, y, height(x, y))
    });
    let triangles = (0..cells * cells).flat_map(|cell| {
        let a = cell / cells * row + cell % cells;
        [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]
    });
    TriMesh {
        positions: points.collect(),
        triangles: triangles.collect(),
    }
}
