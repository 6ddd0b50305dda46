//! Tests of the room as a whole: dirty scans in, clean ones out.

use nalgebra::Point3;

use super::*;
use crate::mesh::{Adjacency, LoopKind, boundary_loops, check};
use crate::scan::{Column, Table};

fn scan(points: &[[f64; 3]], faces: &[&[u32]]) -> Scan {
    let mut scan = Scan::default();
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let values = points.iter().map(|p| p[k]).collect();
        scan.vertices.set_channel(axis, Column::F64(values));
    }
    for face in faces {
        scan.faces.push_row(face);
    }
    let numbers = (0u16..).take(faces.len()).collect();
    scan.face_channels
        .set_channel("number", Column::U16(numbers));
    scan
}

/// A flat grid of `n` by `n` squares of two triangles each.
fn grid(n: u32) -> (Vec<[f64; 3]>, Vec<Vec<u32>>) {
    let points = (0..=n).flat_map(|y| (0..=n).map(move |x| [f64::from(x), f64::from(y), 0.0]));
    let mut faces = Vec::new();
    for y in 0..n {
        for x in 0..n {
            let [a, b, c, d] =
                [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| (y + j) * (n + 1) + x + i);
            faces.push(vec![a, b, c]);
            faces.push(vec![a, c, d]);
        }
    }
    (points.collect(), faces)
}

fn grid_scan(n: u32, change: impl FnOnce(&mut Vec<[f64; 3]>, &mut Vec<Vec<u32>>)) -> Scan {
    let (mut points, mut faces) = grid(n);
    change(&mut points, &mut faces);
    let rows: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    scan(&points, &rows)
}

fn repaired(scan: &Scan) -> Repaired {
    let repaired = repair(scan.clone(), &RepairParams::default());
    assert_eq!(repaired.scan.vertices, scan.vertices);
    assert_eq!(check(&repaired.scan.mesh()), Ok(()));
    assert_eq!(repaired.scan.faces.len(), repaired.scan.face_channels.rows);
    // A second look finds nothing more.
    let again = repair(repaired.scan.clone(), &RepairParams::default());
    assert!(!again.report.changed(), "{:?}", again.report);
    assert_eq!(again.scan, repaired.scan);
    repaired
}

fn kinds(scan: &Scan) -> Vec<LoopKind> {
    let mesh = scan.mesh();
    let loops = boundary_loops(&mesh, &Adjacency::new(&mesh));
    loops.iter().map(|l| l.kind).collect()
}

#[test]
fn a_clean_scan_comes_out_as_it_went_in() {
    let scan = grid_scan(4, |_, _| ());
    let repaired = repaired(&scan);
    assert_eq!(repaired.report, RepairReport::default());
    assert_eq!(repaired.scan, scan);
    assert_eq!(repaired.restore(scan.clone()), scan);
}

#[test]
fn without_steps_nothing_changes() {
    let scan = grid_scan(2, |_, faces| {
        faces.push(faces[0].clone());
        faces.push(vec![0, 0, 1]);
        faces[3].reverse();
    });
    let repaired = repair(scan.clone(), &RepairParams::NONE);
    assert!(!repaired.report.changed());
    assert_eq!(repaired.scan, scan);
}

#[test]
fn degenerate_and_repeated_faces_go_and_the_first_stays() {
    let scan = grid_scan(2, |_, faces| {
        faces.insert(3, vec![4, 4, 4]);
        faces.insert(5, vec![1, 2, 1]);
        faces.push(vec![faces[0][1], faces[0][2], faces[0][0]]);
        faces.push(vec![faces[1][2], faces[1][1], faces[1][0]]);
    });
    let repaired = repaired(&scan);
    assert_eq!(repaired.report.degenerate_faces, 2);
    assert_eq!(repaired.report.duplicate_faces, 2);
    assert_eq!(
        repaired.scan.face_channels.column("number"),
        Some(&Column::U16(vec![0, 1, 2, 4, 6, 7, 8, 9]))
    );
    assert_eq!(kinds(&repaired.scan), [LoopKind::Rim]);
}

/// The grid cut in two along the column x = 2, whose vertices are there twice, as at a texture seam.
fn with_seam() -> Scan {
    grid_scan(4, |points, faces| {
        let copies: Vec<u32> = (0..5).map(|y| y * 5 + 2).collect();
        let first = u32::try_from(points.len()).unwrap();
        points.extend(
            copies
                .clone()
                .into_iter()
                .map(|v| points[v as usize])
                .collect::<Vec<_>>(),
        );
        for face in faces.iter_mut() {
            let right = face.iter().any(|v| v % 5 > 2);
            for v in face.iter_mut().filter(|_| right) {
                if let Some(copy) = (first..).zip(&copies).find(|(_, of)| *of == v) {
                    *v = copy.0;
                }
            }
        }
    })
}

#[test]
fn a_seam_is_joined_and_comes_apart_again() {
    let scan = with_seam();
    assert_eq!(kinds(&scan), [LoopKind::Rim; 2]);
    let repaired = repaired(&scan);
    assert_eq!(repaired.report.welded_vertices, 5);
    assert_eq!(kinds(&repaired.scan), [LoopKind::Rim]);
    let mut completed = repaired.scan.clone();
    completed.faces.push_row(&[0, 1, 2]);
    let restored = repaired.restore(completed);
    let rows: Vec<&[u32]> = restored.faces.rows().collect();
    let before: Vec<&[u32]> = scan.faces.rows().collect();
    assert_eq!(rows[..32], before);
    assert_eq!(rows[32], [0, 1, 2]);
}

#[test]
fn triangles_without_common_vertices_become_a_surface() {
    let (points, faces) = grid(5);
    let soup: Vec<[f64; 3]> = faces
        .iter()
        .flatten()
        .map(|v| points[*v as usize])
        .collect();
    let rows: Vec<Vec<u32>> = (0..50).map(|f| vec![3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let rows: Vec<&[u32]> = rows.iter().map(Vec::as_slice).collect();
    let repaired = repaired(&scan(&soup, &rows));
    assert_eq!(repaired.report.welded_vertices, 150 - 36);
    assert_eq!(kinds(&repaired.scan), [LoopKind::Rim]);
}

#[test]
fn a_face_with_two_corners_at_one_place_is_not_sewn_to_itself() {
    let scan = scan(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], &[&[0, 1, 2]]);
    let repaired = repaired(&scan);
    assert_eq!(repaired.report, RepairReport::default());
    assert_eq!(repaired.scan, scan);
}

/// Texture coordinates of the faces of a repaired scan.
fn repaired_rows(scan: &Scan) -> Vec<Column> {
    let repaired = repaired(scan);
    match repaired.scan.face_channels.column("texcoord") {
        Some(Column::List(lists)) => lists.clone(),
        other => unreachable!("{other:?}"),
    }
}

#[test]
fn channels_of_corners_are_turned_with_their_face() {
    let mut scan = grid_scan(4, |_, faces| {
        faces[7][1..].reverse();
    });
    let faces: Vec<Vec<u32>> = scan.faces.rows().map(<[u32]>::to_vec).collect();
    // Two numbers a corner that tell its vertex, and a list of another length in every face.
    let coordinate = |v: &u32| [*v as f32, 0.5];
    let coordinates = |f: &Vec<u32>| Column::F32(f.iter().flat_map(coordinate).collect());
    let texture = faces.iter().map(coordinates).collect();
    let tags: Vec<Column> = (0..faces.len())
        .map(|f| Column::U8([1, 2, 3, 4, 5, 6, 7][..1 + f % 7].to_vec()))
        .collect();
    scan.face_channels
        .set_channel("texcoord", Column::List(texture));
    scan.face_channels
        .set_channel("tags", Column::List(tags.clone()));
    let repaired = repaired(&scan);
    assert_eq!(repaired.report.flipped_faces, 1);
    assert_ne!(repaired.scan.faces.row(7), scan.faces.row(7));
    let turned: Vec<Vec<u32>> = repaired.scan.faces.rows().map(<[u32]>::to_vec).collect();
    let expected: Vec<Column> = turned.iter().map(coordinates).collect();
    let channel = |name: &str| repaired.scan.face_channels.column(name);
    assert_eq!(channel("texcoord"), Some(&Column::List(expected.clone())));
    assert_eq!(channel("tags"), Some(&Column::List(tags)));
    // Texture coordinates are known by their name, even if some faces have none or too many.
    let mut partial = scan.clone();
    let Some(Column::List(lists)) = (partial.face_channels.channels.iter_mut())
        .find(|c| c.name == "texcoord")
        .map(|c| &mut c.values)
    else {
        unreachable!();
    };
    lists[0] = Column::F32(vec![]);
    lists[1] = Column::F32(vec![0.25; 5]);
    let rows = repaired_rows(&partial);
    assert_eq!(rows[7], expected[7]);
    assert_eq!(rows[1], Column::F32(vec![0.25; 5]));
}

#[test]
fn two_sheets_upon_each_other_are_not_sewn_together() {
    let with_second = |reversed: bool| {
        grid_scan(3, |points, faces| {
            let n = u32::try_from(points.len()).unwrap();
            points.extend(points.clone());
            let mut second: Vec<Vec<u32>> = faces.clone();
            for face in &mut second {
                face.iter_mut().for_each(|v| *v += n);
                if reversed {
                    face.reverse();
                }
            }
            faces.extend(second);
        })
    };
    for reversed in [false, true] {
        let repaired = repaired(&with_second(reversed));
        assert_eq!(repaired.report.duplicate_faces, 18);
        assert_eq!(repaired.report.welded_vertices, 0);
        assert_eq!(kinds(&repaired.scan), [LoopKind::Rim]);
    }
}

#[test]
fn a_fin_goes_and_the_surface_stays() {
    let scan = grid_scan(4, |points, faces| {
        points.push([1.0, 1.0, 1.0]);
        points.push([2.0, 1.0, 1.0]);
        // Upright on the edge from (1, 1) to (2, 1), which is 6 to 7, and further up.
        faces.insert(0, vec![6, 7, 25]);
        faces.insert(1, vec![7, 26, 25]);
    });
    let repaired = repaired(&scan);
    assert_eq!(repaired.report.non_manifold_edges, 1);
    assert_eq!(repaired.report.non_manifold_faces, 1);
    // What stood on it is a piece of its own now.
    assert_eq!(repaired.scan.faces.len(), 33);
    assert_eq!(kinds(&repaired.scan), [LoopKind::Rim; 2]);
}

#[test]
fn the_minority_is_turned() {
    for turned in [[3, 8, 9].as_slice(), &[0], &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]] {
        let scan = grid_scan(4, |_, faces| {
            for f in turned {
                faces[*f].reverse();
            }
        });
        let repaired = repaired(&scan);
        assert_eq!(repaired.report.flipped_faces, turned.len());
        let mesh = repaired.scan.mesh();
        for f in 0..mesh.triangles.len() {
            assert!(crate::mesh::triangle_normal(mesh.corners(f)).z > 0.0);
        }
    }
}

#[test]
fn a_one_sided_surface_is_reported() {
    // A Moebius strip of five squares.
    let points: Vec<[f64; 3]> = (0..10)
        .map(|i| {
            let turn = f64::from(i / 2) * std::f64::consts::TAU / 5.0;
            let r = if i % 2 == 0 { 2.0 } else { 3.0 };
            [
                r * turn.cos(),
                r * turn.sin(),
                (turn / 2.0).sin() * f64::from(i % 2),
            ]
        })
        .collect();
    let mut faces: Vec<Vec<u32>> = Vec::new();
    for i in 0..5u32 {
        let (a, b) = (2 * i, 2 * i + 1);
        let (c, d) = if i == 4 {
            (1, 0)
        } else {
            (2 * i + 2, 2 * i + 3)
        };
        faces.push(vec![a, c, b]);
        faces.push(vec![b, c, d]);
    }
    let rows: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    let repaired = repair(scan(&points, &rows), &RepairParams::default());
    assert_eq!(repaired.report.unorientable_edges, 1);
}

#[test]
fn needles_and_folded_ears_at_the_rim_go_and_plain_ears_stay() {
    let (points, _) = grid(4);
    let with_ear = |tip: [f64; 3]| {
        // Beyond the edge from (4, 1) to (4, 2), which is 9 to 14.
        grid_scan(4, |points, faces| {
            points.push(tip);
            faces.push(vec![14, 9, 25]);
        })
    };
    assert_eq!(points.len(), 25);
    for (tip, faces) in [
        ([4.7, 1.5, 0.0], 0),
        ([4.7, 1.5, 0.6], 0),
        ([9.5, 1.5, 0.0], 1),
        ([4.1, 1.5, 9.0], 1),
        ([3.4, 1.5, 0.1], 1),
    ] {
        assert_eq!(
            repaired(&with_ear(tip)).report.spike_faces,
            faces,
            "{tip:?}"
        );
    }
}

#[test]
fn a_needle_of_several_faces_goes() {
    let scan = grid_scan(4, |points, faces| {
        // The vertex (4, 2) at the rim was mixed with what is far behind.
        points[14] = [4.0, 2.0, 50.0];
        assert_eq!(faces.iter().filter(|f| f.contains(&14)).count(), 3);
    });
    let repaired = repaired(&scan);
    assert_eq!(repaired.report.spike_faces, 3);
    assert!(!repaired.scan.mesh().used_vertices()[14]);
    assert_eq!(repaired.scan.positions()[14], Point3::new(4.0, 2.0, 50.0));
}

#[test]
fn a_vertex_with_very_many_faces_is_soon_done() {
    // A disc of one fan, in which every vertex of the rim could be a tip, and one is.
    let count = 40_000u32;
    let mut points = vec![[0.0; 3]];
    for k in 0..count {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(count);
        let radius = if k == 1000 { 50.0 } else { 1.0 };
        points.push([radius * angle.cos(), radius * angle.sin(), 0.0]);
    }
    let faces: Vec<[u32; 3]> = (0..count)
        .map(|k| [0, k + 1, (k + 1) % count + 1])
        .collect();
    let rows: Vec<&[u32]> = faces.iter().map(<[u32; 3]>::as_slice).collect();
    let mut scan = scan(&points, &rows);
    scan.face_channels = Table::default();
    let repaired = repair(scan, &RepairParams::default());
    assert_eq!(repaired.report.spike_faces, 2);
    assert_eq!(kinds(&repaired.scan), [LoopKind::Rim]);
}

#[test]
fn rims_that_touch_are_counted_and_left() {
    // Two squares missing that share the vertex (2, 2).
    let scan = grid_scan(4, |_, faces| {
        let missing = |f: &Vec<u32>| {
            [[6, 7, 12], [6, 12, 11], [12, 13, 18], [12, 18, 17]]
                .iter()
                .any(|m| f == m)
        };
        faces.retain(|f| !missing(f));
    });
    let repaired = repaired(&scan);
    assert_eq!(repaired.report.touching_vertices, 1);
    assert!(!repaired.report.changed());
    assert_eq!(
        kinds(&repaired.scan),
        [LoopKind::Rim, LoopKind::Hole, LoopKind::Hole]
    );
}

#[test]
fn the_order_of_faces_decides_only_which_twin_stays() {
    let scan = with_seam();
    let mut turned = scan.clone();
    let rows: Vec<Vec<u32>> = scan.faces.rows().map(<[u32]>::to_vec).collect();
    turned.faces = Csr::default();
    for row in rows.iter().rev() {
        turned.faces.push_row(row);
    }
    let (a, b) = (repaired(&scan), repaired(&turned));
    assert_eq!(a.report, b.report);
    let sorted = |r: &Repaired| {
        let mut rows: Vec<Vec<u32>> = r.scan.faces.rows().map(<[u32]>::to_vec).collect();
        rows.sort();
        rows
    };
    assert_eq!(sorted(&a), sorted(&b));
}
