//! `relievo holes`

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use relievo::mesh::{Adjacency, LoopKind, boundary_loops};
use relievo::scan;
use serde_json::{Value, json};

use super::outcome::Reply;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The scan: PLY, OBJ, OFF or STL; - for PLY on standard input
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> super::Result {
    // Centered as for completion, so that the numbers are the same to the last bit.
    let (mesh, _) = scan::read(&arguments.input)?.mesh().centered();
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
            "{:>5} {kind:<5} {:>7} {:>14.6} {:>14.6} {:>9}{}",
            boundary.id,
            boundary.vertices.len(),
            boundary.length,
            boundary.area,
            boundary.component,
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
        ..Reply::default()
    };
    reply.json.insert("holes".into(), json!(holes));
    reply.json.insert("rims".into(), json!(loops.len() - holes));
    reply.json.insert("loops".into(), json!(rows));
    Ok(reply)
}
