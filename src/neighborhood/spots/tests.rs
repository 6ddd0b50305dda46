use nalgebra::{Point3, Vector3};

use super::*;
use crate::mesh::{TriMesh, vertex_normals};
use crate::rng::{Rng, Stage};

/// A chart of `n` by `n` cells, its inner vertices moved a little.
fn chart(n: u32, at: impl Fn(f64, f64) -> [f64; 3]) -> TriMesh {
    let mut rng = Rng::new(2, Stage::Texture, 0);
    let number = |i: u32, j: u32| j * (n + 1) + i;
    let positions = (0..(n + 1) * (n + 1)).map(|v| {
        let [x, y] = [v % (n + 1), v / (n + 1)].map(|k| {
            let by = if k > 0 && k < n {
                0.4 * rng.uniform() - 0.2
            } else {
                0.0
            };
            (f64::from(k) + by) / f64::from(n)
        });
        Point3::from(at(x, y))
    });
    let triangles = (0..n * n).flat_map(|cell| {
        let [i, j] = [cell % n, cell / n];
        let [a, b] = [number(i, j), number(i + 1, j)];
        let [d, c] = [number(i, j + 1), number(i + 1, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriMesh {
        positions: positions.collect(),
        triangles: triangles.collect(),
    }
}

/// Both ways of looking at the same function: for each place and offset the two values.
fn both(mesh: &TriMesh, spacing: f64, value: impl Fn(&Point3<f64>) -> f64) -> Vec<Vec<[f32; 2]>> {
    let normals = vertex_normals(mesh);
    #[expect(clippy::cast_possible_truncation, reason = "as values of textures are")]
    let values: Vec<f32> = mesh.positions.iter().map(|p| value(p) as f32).collect();
    let surface = Surface::new(mesh.clone());
    let mut rng = Rng::new(4, Stage::Texture, 0);
    let mut direction = || Vector3::from([0, 1, 2].map(|_| rng.uniform() - 0.5));
    let places: Vec<Option<Place>> = (0u32..)
        .take(normals.len())
        .map(|v| surface.at_vertex(v, &direction()))
        .collect();
    let stencil = Stencil::square(2, spacing);
    let all = [
        Spots::walked(&surface, &stencil, &places),
        Spots::flattened(&surface, &stencil, &places, &normals),
    ];
    let read = |spots: &Spots, v: usize| {
        let mut row = vec![0.0; stencil.len()];
        spots.read(v, &values, &[f32::NAN], &mut row);
        row
    };
    (0..normals.len())
        .map(|v| {
            let [walked, flattened] = [read(&all[0], v), read(&all[1], v)];
            walked
                .into_iter()
                .zip(flattened)
                .map(|(a, b)| [a, b])
                .collect()
        })
        .collect()
}

#[test]
fn on_a_plane_walking_and_flattening_see_the_same() {
    let mesh = chart(16, |x, y| [x, y, 0.0]);
    // Farther than this from the border, all offsets are on the surface.
    let spacing = 0.05;
    let reach = 2.0 * spacing * std::f64::consts::SQRT_2;
    let rows = both(&mesh, spacing, |p| 3.0 * p.x - 2.0 * p.y);
    let mut inner = 0;
    for (row, p) in rows.iter().zip(&mesh.positions) {
        if [p.x, p.y].iter().all(|x| (reach..1.0 - reach).contains(x)) {
            inner += 1;
            for [walked, flattened] in row {
                assert!(
                    (walked - flattened).abs() < 2e-4,
                    "{p}: {walked} and {flattened}"
                );
            }
            // A linear function is read without error: opposite offsets are as far above as below.
            let mean: f32 = row.iter().map(|[_, flattened]| flattened).sum::<f32>() / 25.0;
            assert!(
                (f64::from(mean) - (3.0 * p.x - 2.0 * p.y)).abs() < 1e-4,
                "{p}"
            );
        }
    }
    assert!(inner > 80, "{inner}");
    // At a corner both miss something.
    for side in [0, 1] {
        assert!(rows[0].iter().any(|pair| pair[side].is_nan()));
    }
}

#[test]
fn on_a_sphere_they_see_nearly_the_same() {
    // Most of a hemisphere of radius 1.
    let mesh = chart(40, |x, y| {
        let [x, y] = [x, y].map(|x| 1.2 * (x - 0.5));
        [x, y, (1.0 - x * x - y * y).sqrt()]
    });
    let spacing = 0.05;
    let reach = 2.0 * spacing * std::f64::consts::SQRT_2;
    let rows = both(&mesh, spacing, |p| p.x + 0.5 * p.y - p.z);
    // Straight down and along the surface, an offset r comes to places r³/6 apart, but for the facets.
    let bound = 1.5 * (reach.powi(3) / 6.0 + 1.2 / 40.0 * 0.02);
    let mut inner = 0;
    for (row, p) in rows.iter().zip(&mesh.positions) {
        if [p.x, p.y].iter().all(|x| x.abs() < 0.6 - 2.0 * reach) {
            inner += 1;
            for [walked, flattened] in row {
                let apart = f64::from((walked - flattened).abs());
                assert!(apart < bound, "{p}: {walked} and {flattened}");
            }
        }
    }
    assert!(inner > 200, "{inner}");
}
