//! Meshes of known shape for tests.

use std::collections::BTreeMap;

use nalgebra::Point3;

use crate::mesh::TriMesh;

/// An icosahedron whose triangles are cut in four `cuts` times, on the unit sphere.
pub(in crate::transfer) fn icosphere(cuts: usize) -> TriMesh {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let mut positions: Vec<Point3<f64>> = [
        [0.0, 1.0, g],
        [0.0, -1.0, g],
        [0.0, 1.0, -g],
        [0.0, -1.0, -g],
    ]
    .iter()
    .flat_map(|&[x, y, z]| [[x, y, z], [y, z, x], [z, x, y]])
    .map(|p| Point3::from(nalgebra::Vector3::from(p).normalize()))
    .collect();
    let mut triangles = Vec::new();
    // Three vertices at the least distance, outwards.
    let edge = |a: u32, b: u32| (positions[a as usize] - positions[b as usize]).norm() < 1.2;
    for a in 0..12u32 {
        for b in a + 1..12 {
            for c in (b + 1..12).filter(|c| edge(a, b) && edge(b, *c) && edge(a, *c)) {
                let [p, q, r] = [a, b, c].map(|v| positions[v as usize].coords);
                triangles.push(if p.cross(&q).dot(&r) > 0.0 {
                    [a, b, c]
                } else {
                    [a, c, b]
                });
            }
        }
    }
    for _ in 0..cuts {
        let mut middles = BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[i, j]: [u32; 2]| {
                *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                    let sum = positions[i as usize].coords + positions[j as usize].coords;
                    positions.push(Point3::from(sum.normalize()));
                    u32::try_from(positions.len() - 1).unwrap()
                })
            });
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    TriMesh {
        positions,
        triangles,
    }
}

/// `columns` by `rows` vertices in rows, each at `place` of its column and row.
pub(in crate::transfer) fn grid(
    columns: u32,
    rows: u32,
    place: impl Fn(f64, f64) -> [f64; 3],
) -> TriMesh {
    let mut mesh = TriMesh::default();
    for i in 0..rows {
        for j in 0..columns {
            mesh.positions
                .push(place(f64::from(j), f64::from(i)).into());
            if i + 1 < rows && j + 1 < columns {
                let [a, b] = [i * columns + j, i * columns + j + 1];
                let [c, d] = [a + columns, b + columns];
                // Diagonals both ways, so that no direction is preferred.
                if (i + j) % 2 == 0 {
                    mesh.triangles.extend([[a, b, d], [a, d, c]]);
                } else {
                    mesh.triangles.extend([[a, b, c], [b, d, c]]);
                }
            }
        }
    }
    mesh
}

/// Both meshes as one, the second's vertices after the first's.
pub(in crate::transfer) fn together(mut first: TriMesh, second: &TriMesh) -> TriMesh {
    let offset = u32::try_from(first.positions.len()).unwrap();
    first.positions.extend_from_slice(&second.positions);
    let moved = second.triangles.iter().map(|t| t.map(|v| v + offset));
    first.triangles.extend(moved);
    first
}
