//! Scans for the tests, and what every completed scan must keep.
#![allow(dead_code, reason = "each test crate uses its own share")]

pub(crate) mod place;
#[cfg(feature = "image")]
pub(crate) mod samples;

use std::f64::consts::TAU;
use std::io::Write;
use std::path::PathBuf;

use nalgebra::Point3;
use relievo::completion::{COMPLETED, COST, CompleteParams, Completion, HEIGHT, SOURCE, complete};
use relievo::mesh::{Adjacency, BoundaryLoop, Csr, TriMesh, boundary_loops, check};
use relievo::scan::{Channel, Column, Scan, Table};
use relievo::synth::{Kind, Part, SynthParams, scan as synthesize};

/// A synthetic scan of about 1000 vertices before cutting.
pub(crate) fn synthetic(kind: Kind, part: Part) -> Scan {
    let params = SynthParams {
        kind,
        vertices: 1000,
        part,
        ..SynthParams::default()
    };
    synthesize(&params)
        .expect("the parameters are in range")
        .scan
}

/// A golf ball, wall, … with one small hole.
pub(crate) fn holed(kind: Kind) -> Scan {
    synthetic(kind, Part::hole(0.03))
}

/// Radii of the torus: of its middle line, and of the tube without its bumps.
pub(crate) const MAJOR: f64 = 30.0;
pub(crate) const MINOR: f64 = 12.0;

/// A torus with bumps: no kind of base fits it.
pub(crate) fn torus() -> TriMesh {
    let (around, along) = (110u32, 44u32);
    let mut mesh = TriMesh::default();
    for i in 0..along {
        for j in 0..around {
            let angle = TAU * f64::from(j) / f64::from(around);
            let minor = TAU * f64::from(i) / f64::from(along);
            let bump = 0.25 * (22.0 * angle).sin() * (9.0 * minor).cos();
            let radius = MAJOR + (MINOR + bump) * minor.cos();
            let z = (MINOR + bump) * minor.sin();
            mesh.positions
                .push(Point3::new(radius * angle.cos(), radius * angle.sin(), z));
            let v = |i, j| i % along * around + j % around;
            let [a, b, c, d] = [v(i, j), v(i, j + 1), v(i + 1, j), v(i + 1, j + 1)];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    mesh
}

/// A scan of `double` coordinates and triangles.
pub(crate) fn to_scan(mesh: &TriMesh) -> Scan {
    let mut scan = Scan::default();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let values = mesh.positions.iter().map(|p| p[axis]).collect();
        scan.vertices.set_channel(name, Column::F64(values));
    }
    for triangle in &mesh.triangles {
        scan.faces.push_row(triangle);
    }
    scan.face_channels.rows = scan.faces.len();
    scan
}

/// The vertices for which `keep` holds, with all their channels, and the triangles between them.
pub(crate) fn cut(scan: &Scan, keep: impl Fn(&Point3<f64>) -> bool) -> Scan {
    let positions = scan.positions();
    let rows: Vec<usize> = (0..positions.len())
        .filter(|v| keep(&positions[*v]))
        .collect();
    let mut renamed = vec![None; positions.len()];
    for (new, old) in (0u32..).zip(&rows) {
        renamed[*old] = Some(new);
    }
    let mut faces = Csr::default();
    for triangle in scan.triangles() {
        if let [Some(a), Some(b), Some(c)] = triangle.map(|v| renamed[v as usize]) {
            faces.push_row(&[a, b, c]);
        }
    }
    let channels = (scan.vertices.channels.iter())
        .map(|channel| Channel {
            name: channel.name.clone(),
            values: taken(&channel.values, &rows),
        })
        .collect();
    Scan {
        vertices: Table {
            channels,
            rows: rows.len(),
        },
        face_channels: Table {
            channels: Vec::new(),
            rows: faces.len(),
        },
        faces,
        comments: scan.comments.clone(),
        ..Scan::default()
    }
}

fn taken(column: &Column, rows: &[usize]) -> Column {
    match column {
        Column::U8(values) => Column::U8(rows.iter().map(|r| values[*r]).collect()),
        Column::I32(values) => Column::I32(rows.iter().map(|r| values[*r]).collect()),
        Column::F32(values) => Column::F32(rows.iter().map(|r| values[*r]).collect()),
        Column::F64(values) => Column::F64(rows.iter().map(|r| values[*r]).collect()),
        _ => unreachable!("no other types are made here"),
    }
}

/// The scan with every face turned over: the inside of a wall.
pub(crate) fn turned_over(scan: &Scan) -> Scan {
    let mut faces = Csr::default();
    for [a, b, c] in scan.triangles() {
        faces.push_row(&[a, c, b]);
    }
    Scan {
        faces,
        ..scan.clone()
    }
}

pub(crate) fn moved(scan: &Scan, by: [f64; 3]) -> Scan {
    let mut scan = scan.clone();
    let positions = scan.positions();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let values = positions.iter().map(|p| p[axis] + by[axis]).collect();
        scan.vertices.set_channel(name, Column::F64(values));
    }
    scan
}

pub(crate) fn loops(mesh: &TriMesh) -> Vec<BoundaryLoop> {
    boundary_loops(mesh, &Adjacency::new(mesh))
}

/// The rows of a column as bits, so that NaN equals itself and 0 is not -0.
pub(crate) fn bits(column: &Column, rows: usize) -> Vec<String> {
    match column {
        Column::F32(values) => (values[..rows].iter())
            .map(|x| format!("float {:x}", x.to_bits()))
            .collect(),
        Column::F64(values) => (values[..rows].iter())
            .map(|x| format!("double {:x}", x.to_bits()))
            .collect(),
        Column::List(lists) => (lists[..rows].iter())
            .map(|list| format!("{list:?}"))
            .collect(),
        _ => (0..rows)
            .map(|row| format!("{:?}", column.get_f64(row)))
            .collect(),
    }
}

/// The values of a scalar channel.
pub(crate) fn values(scan: &Scan, name: &str) -> Vec<f64> {
    let column = scan.vertices.column(name).expect("the channel is there");
    (0..scan.vertices.rows)
        .map(|row| column.get_f64(row).expect("the channel is scalar"))
        .collect()
}

/// Originals come first, bit for bit, with every channel, line of text and face; the added channels
/// tell original and completed vertices apart.
#[track_caller]
pub(crate) fn assert_only_appended(before: &Scan, after: &Scan) {
    let rows = before.vertices.rows;
    for old in &before.vertices.channels {
        let new = after.vertices.column(&old.name);
        let new = new.unwrap_or_else(|| panic!("channel {} is lost", old.name));
        assert_eq!(
            std::mem::discriminant(new),
            std::mem::discriminant(&old.values),
            "type of {}",
            old.name
        );
        assert!(
            bits(new, rows) == bits(&old.values, rows),
            "values of {} have changed",
            old.name
        );
    }
    assert!(
        before
            .faces
            .rows()
            .eq(after.faces.rows().take(before.faces.len())),
        "original faces have changed"
    );
    for line in &before.comments {
        assert!(after.comments.contains(line), "comment {line:?} is lost");
    }
    assert_eq!(before.obj_info, after.obj_info);
    assert_eq!(before.other_elements, after.other_elements);
    assert_eq!(
        after.check("the completed scan").map_err(|e| e.to_string()),
        Ok(())
    );
    assert_added_channels(after, rows);
}

#[track_caller]
fn assert_added_channels(after: &Scan, originals: usize) {
    let completed = after.vertices.column(COMPLETED);
    assert!(
        matches!(completed, Some(Column::U8(_))),
        "completed is uchar"
    );
    let heights = after.vertices.column(HEIGHT);
    assert!(matches!(heights, Some(Column::F32(_))), "height is float");
    let sources = after.vertices.column(SOURCE);
    assert!(matches!(sources, Some(Column::I32(_))), "source is int");
    let costs = after.vertices.column(COST);
    assert!(matches!(costs, Some(Column::F32(_))), "cost is float");
    let (completed, sources) = (values(after, COMPLETED), values(after, SOURCE));
    let costs = values(after, COST);
    for row in 0..after.vertices.rows {
        let (mark, source) = (completed[row], sources[row]);
        if row < originals {
            assert!(
                mark < 0.5 && source < -0.5 && costs[row].is_nan(),
                "vertex {row}: {mark}, {source}"
            );
        } else {
            let known = source >= 0.0 && source < originals as f64;
            assert!(mark > 0.5 && known, "vertex {row}: {mark}, {source}");
            assert!(
                (0.0..=1.0).contains(&costs[row]),
                "vertex {row}: {}",
                costs[row]
            );
        }
    }
}

/// A file of the real data, or `None` with a message that says so.
pub(crate) fn real(name: &str) -> Option<Scan> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/data")
        .join(name);
    if path.exists() {
        return Some(
            relievo::scan::read(&path, &relievo::scan::ReadOptions::default())
                .expect("the file can be read"),
        );
    }
    say_skipped(&format!("{} is not there", path.display()));
    None
}

/// Says that a test is skipped, past the test harness, which would hide it.
pub(crate) fn say_skipped(why: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED: {why}");
}

/// Completes all that is chosen, and checks what holds for every completion.
#[track_caller]
pub(crate) fn completed(scan: &Scan, params: &CompleteParams) -> (Completion, TriMesh) {
    let completion = complete(scan, params, &mut |_| {}).expect("it can be completed");
    assert!(
        completion.report.skipped.is_empty(),
        "{:?}",
        completion.report.skipped
    );
    assert_only_appended(scan, &completion.scan);
    let mesh = completion.scan.mesh();
    assert_eq!(check(&mesh), Ok(()));
    (completion, mesh)
}
