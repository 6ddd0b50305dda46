//! `relievo info`

use std::fmt::Write;

use crate::mesh::{Adjacency, LoopKind, boundary_loops, bounding_diagonal, edge_lengths};
use crate::repair::{self, RepairParams, RepairReport};
use crate::scan::{Channel, Column, Scan};
use clap::Args;
use serde_json::{Map, Value, json};

use super::outcome::Reply;
use super::reading::{Input, in_words};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
}

pub(super) fn run(arguments: &Arguments) -> super::Result {
    let scan = arguments.input.scan()?;
    let mut told = Told::default();
    told.contents(&scan);
    told.extent(&scan);
    if !scan.faces.is_empty() {
        let repaired = repair::repair(scan, &RepairParams::default());
        told.surface(&repaired.scan);
        told.repair(&repaired.report);
    }
    Ok(Reply {
        json: told.json,
        text: told.text,
        partly: false,
    })
}

/// What is known so far, for programs and for people.
#[derive(Default)]
struct Told {
    json: Map<String, Value>,
    text: String,
}

impl Told {
    fn line(&mut self, label: &str, value: impl std::fmt::Display) {
        let _ = writeln!(self.text, "{label:<12} {value}");
    }

    fn add(&mut self, name: &str, value: Value) {
        self.json.insert(name.to_owned(), value);
    }

    /// What the file holds.
    fn contents(&mut self, scan: &Scan) {
        self.line("vertices", scan.vertices.rows);
        self.add("vertices", json!(scan.vertices.rows));
        let mut by_corners: Vec<(usize, usize)> = Vec::new();
        let mut corners: Vec<usize> = scan.faces.rows().map(<[u32]>::len).collect();
        corners.sort_unstable();
        for same in corners.chunk_by(|a, b| a == b) {
            by_corners.push((same[0], same.len()));
        }
        let shapes: Vec<String> = by_corners
            .iter()
            .map(|(corners, count)| format!("{count} with {corners} corners"))
            .collect();
        let faces = scan.faces.len();
        self.line(
            "faces",
            if faces == 0 {
                "none: a point cloud".to_owned()
            } else {
                shapes.join(", ")
            },
        );
        self.add("faces", json!(faces));
        self.add(
            "corners",
            json!(
                by_corners
                    .iter()
                    .map(|(corners, count)| json!({"corners": corners, "faces": count}))
                    .collect::<Vec<_>>()
            ),
        );
        self.channels("channels", &scan.vertices.channels);
        if !scan.face_channels.channels.is_empty() {
            self.channels("face_channels", &scan.face_channels.channels);
        }
        let has = |names: [&str; 3]| names.iter().all(|n| scan.vertices.column(n).is_some());
        self.add("colors", json!(scan.colors().is_some()));
        self.add("normals", json!(has(["nx", "ny", "nz"])));
        let others: Vec<Value> = (scan.other_elements.iter())
            .map(|(name, table)| json!({"name": name, "rows": table.rows}))
            .collect();
        for (name, table) in &scan.other_elements {
            self.line("element", format!("{name}, {} rows", table.rows));
        }
        self.add("other_elements", json!(others));
        for sensor in &scan.sensors {
            let [x, y, z]: [f64; 3] = sensor.position.coords.into();
            let rows = &sensor.vertices;
            let text = format!(
                "at ({x}, {y}, {z}), saw vertices {} to {}",
                rows.start,
                rows.end.saturating_sub(1)
            );
            self.line("sensor", text);
        }
        let sensors: Vec<Value> = (scan.sensors.iter())
            .map(
                |s| json!({"position": s.position, "vertices": [s.vertices.start, s.vertices.end]}),
            )
            .collect();
        self.add("sensors", json!(sensors));
        for comment in &scan.comments {
            self.line("comment", comment);
        }
        self.add("comments", json!(scan.comments));
        self.add("obj_info", json!(scan.obj_info));
    }

    fn channels(&mut self, member: &str, channels: &[Channel]) {
        let mut rows = Vec::new();
        for channel in channels {
            let kind = type_name(&channel.values);
            let range = range(&channel.values);
            let place = if member == "channels" {
                "property"
            } else {
                "of faces"
            };
            self.line(
                place,
                match range {
                    Some([low, high]) => format!("{} ({kind}), {low} to {high}", channel.name),
                    None => format!("{} ({kind})", channel.name),
                },
            );
            rows.push(json!({
                "name": channel.name,
                "type": kind,
                "range": range,
            }));
        }
        self.add(member, json!(rows));
    }

    /// Where it is and how large.
    fn extent(&mut self, scan: &Scan) {
        let positions = scan.positions();
        let corner = |pick: fn(f64, f64) -> f64, start: f64| {
            positions.iter().fold([start; 3], |known, p| {
                [
                    pick(known[0], p.x),
                    pick(known[1], p.y),
                    pick(known[2], p.z),
                ]
            })
        };
        let low = corner(f64::min, f64::INFINITY);
        let high = corner(f64::max, f64::NEG_INFINITY);
        let text = |p: [f64; 3]| format!("({}, {}, {})", p[0], p[1], p[2]);
        self.line(
            "extent",
            format!("{} to {}, in the scan's unit", text(low), text(high)),
        );
        let diagonal = bounding_diagonal(&positions);
        self.line("diagonal", format!("{diagonal:.6}"));
        self.add("extent", json!([low, high]));
        self.add("diagonal", json!(diagonal));
    }

    /// What the faces make, once they are repaired.
    fn surface(&mut self, scan: &Scan) {
        let (mesh, _) = scan.mesh().centered();
        let mut lengths = edge_lengths(&mesh);
        lengths.sort_by(f64::total_cmp);
        if let (Some(shortest), Some(longest)) = (lengths.first(), lengths.last()) {
            let median = lengths[lengths.len() / 2];
            self.line(
                "edges",
                format!("{shortest:.6} to {longest:.6}, median {median:.6}"),
            );
            self.add(
                "edges",
                json!({"shortest": shortest, "median": median, "longest": longest}),
            );
        }
        let adjacency = Adjacency::new(&mesh);
        let (components, _) = adjacency.components();
        let mut pieces: Vec<u32> = (components.iter().zip(mesh.used_vertices()))
            .filter_map(|(component, used)| used.then_some(*component))
            .collect();
        let used = pieces.len();
        pieces.sort_unstable();
        pieces.dedup();
        self.line("pieces", pieces.len());
        self.add("pieces", json!(pieces.len()));
        let loose = scan.vertices.rows - used;
        if loose > 0 {
            self.line("loose", format!("{loose} vertices without a face"));
        }
        self.add("loose_vertices", json!(loose));
        let loops = boundary_loops(&mesh, &adjacency);
        let holes = loops.iter().filter(|l| l.kind == LoopKind::Hole).count();
        self.line(
            "holes",
            format!("{holes}, and {} outer rims", loops.len() - holes),
        );
        self.add("holes", json!(holes));
        self.add("rims", json!(loops.len() - holes));
    }

    /// What would be repaired.
    fn repair(&mut self, report: &RepairReport) {
        self.add("repair", json!(report));
        for (what, _) in in_words(report) {
            self.line("repair", what);
        }
    }
}

fn type_name(column: &Column) -> String {
    let name = match column {
        Column::I8(_) => "char",
        Column::U8(_) => "uchar",
        Column::I16(_) => "short",
        Column::U16(_) => "ushort",
        Column::I32(_) => "int",
        Column::U32(_) => "uint",
        Column::F32(_) => "float",
        Column::F64(_) => "double",
        Column::List(lists) => {
            let item = lists.first().map_or("int".to_owned(), type_name);
            return format!("list of {item}");
        }
    };
    name.to_owned()
}

/// Smallest and largest value; `None` for lists and where there is no number.
fn range(column: &Column) -> Option<[f64; 2]> {
    let values = (0..column.len()).filter_map(|row| column.get_f64(row));
    values.filter(|v| !v.is_nan()).fold(None, |known, v| {
        Some(known.map_or([v; 2], |[low, high]: [f64; 2]| [low.min(v), high.max(v)]))
    })
}
