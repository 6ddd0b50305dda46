use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use super::*;
use crate::mesh::TriMesh;

fn charts(mesh: &TriMesh) -> (Surface, Charts) {
    let surface = Surface::new(mesh.clone());
    let charts = Charts::new(&surface);
    (surface, charts)
}

fn numbers(mesh: &TriMesh) -> std::ops::Range<u32> {
    0..u32::try_from(mesh.positions.len()).unwrap()
}

/// A flat square of `n` by `n` cells from 0 to 1, its inner vertices moved a little.
fn square(n: u32) -> TriMesh {
    let number = |i: u32, j: u32| j * (n + 1) + i;
    let place = |v: u32| {
        let [i, j] = [v % (n + 1), v / (n + 1)];
        let by = |k: u32, wave: f64| if k > 0 && k < n { 0.2 * wave } else { 0.0 };
        let [x, y] = [
            f64::from(i) + by(i, (7.0 * f64::from(v)).sin()),
            f64::from(j) + by(j, (11.0 * f64::from(v)).cos()),
        ];
        Point3::new(x / f64::from(n), y / f64::from(n), 0.0)
    };
    let cells = (0..n * n).flat_map(|cell| {
        let [i, j] = [cell % n, cell / n];
        let [a, b] = [number(i, j), number(i + 1, j)];
        let [d, c] = [number(i, j + 1), number(i + 1, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriMesh {
        positions: (0..(n + 1) * (n + 1)).map(place).collect(),
        triangles: cells.collect(),
    }
}

/// The cube from 0 to `n` in cells of size 1, outwards; its first vertex is the corner in the origin.
fn cube(n: i32) -> TriMesh {
    let mut mesh = TriMesh::default();
    let mut known = BTreeMap::new();
    known.insert([0, 0, 0], 0);
    mesh.positions.push(Point3::origin());
    for axis in 0..3 {
        for (level, is_top) in [(0, false), (n, true)] {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let [a, b, c, d] =
                    [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| {
                        let mut at = [0; 3];
                        (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (level, i, j);
                        *known.entry(at).or_insert_with(|| {
                            mesh.positions.push(Point3::from(at.map(f64::from)));
                            u32::try_from(mesh.positions.len() - 1).unwrap()
                        })
                    });
                let cell = [[a, b, c], [a, c, d]];
                mesh.triangles.extend(cell.map(
                    |[a, b, c]| {
                        if is_top { [a, b, c] } else { [a, c, b] }
                    },
                ));
            }
        }
    }
    mesh
}

/// The angle between -π and π that is as good.
fn least(angle: f32) -> f32 {
    let angle = angle.rem_euclid(TAU);
    if angle > PI { angle - TAU } else { angle }
}

/// The angle of a direction in the plane.
fn in_plane(direction: &Vector3<f64>) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "angles are single")]
    let angle = direction.y.atan2(direction.x) as f32;
    angle
}

#[test]
fn the_wedges_around_an_inner_vertex_join_and_add_up_to_a_whole_turn() {
    for mesh in [cube(1), cube(4), square(6)] {
        let (_, charts) = charts(&mesh);
        let mut inner = 0;
        for v in numbers(&mesh) {
            let wedges = charts.wedges(v);
            assert!(wedges[0].from.abs() < 1e-6);
            for pair in wedges.windows(2) {
                assert!((pair[0].to - pair[1].from).abs() < 1e-5);
                assert_eq!(pair[0].ends[1], pair[1].ends[0], "counterclockwise");
            }
            let last = wedges[wedges.len() - 1];
            if charts.is_inside[v as usize] {
                inner += 1;
                assert!((last.to - TAU).abs() < 1e-5, "{v}: {}", last.to);
                assert_eq!(last.ends[1], wedges[0].ends[0]);
            } else {
                // Flat: a half turn along a side, a quarter at a corner.
                let at = mesh.positions[v as usize];
                let sides = [at.x, at.y]
                    .iter()
                    .filter(|x| x.fract().abs() < 1e-12)
                    .count();
                let all = PI / [1.0, 2.0][sides - 1];
                assert!((last.to - all).abs() < 1e-5, "{v}: {}", last.to);
            }
        }
        assert!(inner > 0);
    }
}

#[test]
fn the_angle_of_the_place_in_a_direction_is_that_of_the_direction() {
    for mesh in [cube(1), cube(3), square(6)] {
        let (surface, charts) = charts(&mesh);
        let mut found = 0;
        for v in numbers(&mesh) {
            for step in 0..40u8 {
                let angle = TAU * (f32::from(step) + 0.3) / 40.0;
                let Some(place) = charts.place(&surface, v, angle) else {
                    assert!(!charts.is_inside[v as usize]);
                    continue;
                };
                let corners = surface.corners(place.triangle);
                let corner = corners.iter().position(|c| *c == v).unwrap();
                let again = charts.angle(&surface, &place, corner);
                assert!(least(again - angle).abs() < 1e-4, "{v}: {angle}, {again}");
                let start = surface.position(&place) - mesh.positions[v as usize];
                assert!(start.norm() < 1e-6);
                found += 1;
            }
        }
        assert!(found > mesh.positions.len() * 15);
    }
}

#[test]
fn in_a_plane_angles_are_the_true_ones_but_for_where_they_begin() {
    let mesh = square(6);
    let (surface, charts) = charts(&mesh);
    for v in numbers(&mesh) {
        let first = in_plane(&surface.axis(&charts.place(&surface, v, 0.0).unwrap()));
        for step in 1..36u8 {
            let angle = TAU * f32::from(step) / 36.0;
            if let Some(place) = charts.place(&surface, v, angle) {
                let truth = in_plane(&surface.axis(&place));
                assert!(least(truth - first - angle).abs() < 1e-4);
            }
        }
        for next in charts.next(v) {
            let way = mesh.positions[next.vertex as usize] - mesh.positions[v as usize];
            assert!(least(in_plane(&way) - first - next.angle).abs() < 1e-4);
            assert!((f64::from(next.length) - way.norm()).abs() < 1e-6);
        }
    }
}

#[test]
fn carried_over_a_plane_a_direction_stays_what_it_is() {
    let mesh = square(6);
    let (surface, charts) = charts(&mesh);
    let first = |v: u32| in_plane(&surface.axis(&charts.place(&surface, v, 0.0).unwrap()));
    let mut edges = 0;
    for v in numbers(&mesh) {
        for next in charts.next(v) {
            // The angle a at v is the direction a + first(v).
            let there = first(v) - first(next.vertex);
            assert!(least(next.transport - there).abs() < 1e-4);
            edges += 1;
        }
    }
    assert_eq!(edges, 2 * (6 * 7 * 2 + 36), "each edge from both ends");
}

#[test]
fn carried_around_a_corner_of_a_cube_a_direction_turns_by_the_angle_that_is_missing_there() {
    let mesh = cube(4);
    let (_, charts) = charts(&mesh);
    let ring: Vec<u32> = charts.next(0).map(|next| next.vertex).collect();
    assert!(ring.len() >= 3);
    let mut turned = 0.0;
    for (k, v) in ring.iter().enumerate() {
        let to = ring[(k + 1) % ring.len()];
        turned += charts
            .next(*v)
            .find(|next| next.vertex == to)
            .unwrap()
            .transport;
    }
    // Three right angles instead of four.
    assert!(least(turned - 0.5 * PI).abs() < 1e-4, "{}", least(turned));
    // Around a vertex in the middle of a face nothing is missing.
    let middle = (mesh.positions.iter()).position(|p| *p == Point3::new(0.0, 2.0, 2.0));
    let middle = u32::try_from(middle.unwrap()).unwrap();
    let ring: Vec<u32> = charts.next(middle).map(|next| next.vertex).collect();
    let turned: f32 = (ring.iter().zip(ring.iter().cycle().skip(1)))
        .map(|(v, to)| {
            charts
                .next(*v)
                .find(|next| next.vertex == *to)
                .unwrap()
                .transport
        })
        .sum();
    assert!(least(turned).abs() < 1e-4, "{}", least(turned));
}

#[test]
fn a_direction_off_the_surface_is_none() {
    let mesh = square(6);
    let (surface, charts) = charts(&mesh);
    let [mut on, mut off] = [0, 0];
    for v in numbers(&mesh).filter(|v| !charts.is_inside[*v as usize]) {
        let first = in_plane(&surface.axis(&charts.place(&surface, v, 0.0).unwrap()));
        for step in 0..36u8 {
            // No side lies in such a direction.
            let angle = TAU * (f32::from(step) + 0.5) / 36.0;
            let (sin, cos) = f64::from(angle + first).sin_cos();
            let at = mesh.positions[v as usize] + Vector3::new(cos, sin, 0.0) * 1e-3;
            let is_on = [at.x, at.y].iter().all(|x| (0.0..=1.0).contains(x));
            assert_eq!(charts.place(&surface, v, angle).is_some(), is_on, "{at}");
            *if is_on { &mut on } else { &mut off } += 1;
        }
    }
    assert_eq!([on, off], [20 * 18 + 4 * 9, 20 * 18 + 4 * 27]);
}
