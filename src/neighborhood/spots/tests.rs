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

/// What is read at the offsets of all fans, of values at the vertices.
fn fans(mesh: &TriMesh, spacing: f32, values: &[f32]) -> (Surface, Charts, Vec<Vec<f32>>) {
    let surface = Surface::new(mesh.clone());
    let charts = Charts::new(&surface);
    let fans = Spots::fans(&surface, &charts, [3, 18], spacing);
    assert_eq!(fans.offsets(), 1 + 3 * 18);
    let rows = (0..mesh.positions.len()).map(|v| {
        let mut row = vec![0.0; fans.offsets()];
        fans.read(v, values, &[f32::NAN], &mut row);
        row
    });
    let rows = rows.collect();
    (surface, charts, rows)
}

/// The direction in space of a spoke, on a plane: the angle 0 turned.
fn spoke_direction(surface: &Surface, charts: &Charts, v: u32, spoke: usize) -> Vector3<f64> {
    let first = surface.axis(&charts.place(surface, v, 0.0).unwrap());
    let (sin, cos) = (std::f64::consts::TAU * spoke as f64 / 18.0).sin_cos();
    first * cos + Vector3::z().cross(&first) * sin
}

#[test]
fn fans_read_a_linear_function_exactly() {
    let mesh = chart(12, |x, y| [x, y, 0.0]);
    let value = |p: &Point3<f64>| 3.0 * p.x - 2.0 * p.y + 0.5;
    #[expect(clippy::cast_possible_truncation, reason = "as values of textures are")]
    let values: Vec<f32> = mesh.positions.iter().map(|p| value(p) as f32).collect();
    let (surface, charts, rows) = fans(&mesh, 0.08, &values);
    let mut inner = 0;
    for (v, p) in (0u32..).zip(&mesh.positions) {
        let row = &rows[v as usize];
        assert!((f64::from(row[0]) - value(p)).abs() < 1e-5);
        if [p.x, p.y].iter().any(|x| !(0.25..0.75).contains(x)) {
            continue;
        }
        inner += 1;
        for spoke in 0..18 {
            let direction = spoke_direction(&surface, &charts, v, spoke);
            for ring in 1..=3usize {
                let at = p + direction * (0.08 * ring as f64);
                let read = row[1 + (ring - 1) * 18 + spoke];
                assert!(
                    (f64::from(read) - value(&at)).abs() < 1e-4,
                    "{read} at {at}"
                );
            }
        }
    }
    assert!(inner > 20);
}

#[test]
fn beyond_the_rim_a_spoke_stays_where_it_was_last() {
    let mesh = chart(12, |x, y| [x, y, 0.0]);
    let read = |value: fn(&Point3<f64>) -> f64| {
        #[expect(clippy::cast_possible_truncation, reason = "as values of textures are")]
        let values: Vec<f32> = mesh.positions.iter().map(|p| value(p) as f32).collect();
        fans(&mesh, 0.08, &values)
    };
    let (surface, charts, xs) = read(|p| p.x);
    let (_, _, ys) = read(|p| p.y);
    let mut beyond = 0;
    for (v, p) in (0u32..).zip(&mesh.positions) {
        for spoke in 0..18 {
            let direction = spoke_direction(&surface, &charts, v, spoke);
            let mut last = *p;
            for ring in 1..=3usize {
                let at = p + direction * (0.08 * ring as f64);
                let margin = [at.x, at.y].map(|x| x.min(1.0 - x));
                let margin = margin[0].min(margin[1]);
                let number = 1 + (ring - 1) * 18 + spoke;
                let [x, y] = [&xs, &ys].map(|rows| f64::from(rows[v as usize][number]));
                let found = Point3::new(x, y, 0.0);
                let on = (found - at).norm() < 1e-5;
                let stays = (found - last).norm() < 1e-5;
                // Just on the rim, rounding may take it for either.
                assert!(on || margin < 1e-5, "{found} instead of {at}");
                assert!(stays || margin > -1e-5, "{found} instead of {last}");
                beyond += usize::from(margin < -1e-5);
                last = found;
            }
        }
    }
    assert!(beyond > 500);
}

#[test]
fn fans_of_a_mesh_that_was_turned_are_shifted_by_whole_spokes() {
    // Regular triangles: the angle 0 is along one of six edges, three spokes apart.
    let row = 3f64.sqrt() / 2.0;
    let lattice = |turn: f64| {
        let number = |i: u32, j: u32| j * 13 + i;
        let positions = (0..13 * 13).map(|v| {
            let [i, j] = [v % 13, v / 13].map(|k| f64::from(k) - 6.0);
            let (sin, cos) = turn.sin_cos();
            let [x, y] = [i + 0.5 * j, row * j];
            Point3::new(x * cos - y * sin, x * sin + y * cos, 0.0)
        });
        let cells = (0..12 * 12).flat_map(|cell| {
            let [i, j] = [cell % 12, cell / 12];
            let [a, b] = [number(i, j), number(i + 1, j)];
            let [c, d] = [number(i, j + 1), number(i + 1, j + 1)];
            [[a, b, c], [b, d, c]]
        });
        TriMesh {
            positions: positions.collect(),
            triangles: cells.collect(),
        }
    };
    let mut rng = Rng::new(3, Stage::Transfer, 0);
    #[expect(clippy::cast_possible_truncation, reason = "as values of textures are")]
    let values: Vec<f32> = (0..13 * 13).map(|_| rng.uniform() as f32).collect();
    let turn = std::f64::consts::FRAC_PI_3;
    let [
        (surface, charts, rows),
        (turned, turned_charts, turned_rows),
    ] = [0.0, turn].map(|turn| fans(&lattice(turn), 0.9, &values));
    let mut shifts = [0; 18];
    for v in (0..13 * 13u32).filter(|v| (3..10).contains(&(v % 13)) && (3..10).contains(&(v / 13)))
    {
        let own = spoke_direction(&surface, &charts, v, 0);
        let theirs = spoke_direction(&turned, &turned_charts, v, 0);
        // By how many spokes the other fan begins later, seen from the mesh.
        let later = theirs.y.atan2(theirs.x) - turn - own.y.atan2(own.x);
        let spokes = (later / std::f64::consts::TAU).rem_euclid(1.0) * 18.0;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to 18"
        )]
        let shift = spokes.round() as usize % 18;
        assert!((spokes - spokes.round()).abs() < 1e-3);
        shifts[shift] += 1;
        for ring in 0..3 {
            for spoke in 0..18 {
                let there = turned_rows[v as usize][1 + ring * 18 + spoke];
                let here = rows[v as usize][1 + ring * 18 + (spoke + shift) % 18];
                assert!((there - here).abs() < 1e-4, "{there}, {here}");
            }
        }
    }
    assert!(shifts[1..].iter().sum::<u32>() > 0, "some begin elsewhere");
}
