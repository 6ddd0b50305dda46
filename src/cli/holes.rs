//! `relievo holes`

use std::fmt::Write;

use crate::mesh::{Adjacency, LoopKind, boundary_loops};
use clap::Args;
use serde_json::{Map, Value, json};

use super::Common;
use super::outcome::Reply;
use super::reading::{Input, Preparation};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
    #[command(flatten)]
    prepare: Preparation,
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let mut known = Map::new();
    let surface = arguments
        .prepare
        .surface(&arguments.input, common, &mut known)?;
    let (mesh, _) = surface.scan.mesh().centered();
    let loops = boundary_loops(&mesh, &Adjacency::new(&mesh));
    let mut text = format!(
        "{:>5} {:<5} {:>7} {:>14} {:>14} {:>9}\n",
        "id", "kind", "edges", "length", "area", "component"
    );
    let mut rows = Vec::new();
    for boundary in &loops {
        let kind = match boundary.kind {
            LoopKind::Hole => "hole",
            LoopKind::Rim => "rim",
        };
        let _ = writeln!(
            text,
            "{:>5} {kind:<5} {:>7} {:>14.6} {:>14.6} {:>9}{}{}",
            boundary.id,
            boundary.vertices.len(),
            boundary.length,
            boundary.area,
            boundary.component,
            touching(&boundary.touches),
            boundary
                .defect
                .map_or(String::new(), |[a, b]| format!("  broken at edge {a}-{b}")),
        );
        let mut row = json!(boundary);
        if let Value::Object(members) = &mut row {
            members.insert("edges".into(), json!(boundary.vertices.len()));
        }
        rows.push(row);
    }
    if loops.is_empty() {
        text = "no boundary: the surface is closed\n".into();
    }
    let holes = loops.iter().filter(|l| l.kind == LoopKind::Hole).count();
    let mut reply = Reply {
        text,
        json: known,
        ..Reply::default()
    };
    reply.json.insert("holes".into(), json!(holes));
    reply.json.insert("rims".into(), json!(loops.len() - holes));
    reply.json.insert("loops".into(), json!(rows));
    Ok(reply)
}

/// Which other loops have a vertex in common with one.
fn touching(ids: &[usize]) -> String {
    let ids: Vec<String> = ids.iter().map(ToString::to_string).collect();
    if ids.is_empty() {
        String::new()
    } else {
        format!("  touches {}", ids.join(", "))
    }
}
