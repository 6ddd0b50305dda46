//! `relievo convert`

use std::path::PathBuf;

use clap::Args;
use serde_json::{Map, json};

use super::Common;
use super::held::{ScanOutput, Writing};
use super::outcome::Reply;
use super::reading::{Input, Preparation};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
    /// Where to: .ply, .obj, .off, .stl or .glb; - for PLY on standard output
    #[arg(value_name = "OUT")]
    pub(super) output: PathBuf,
    /// Make points a surface and repair it first, as for completion
    #[arg(long)]
    surface: bool,
    #[command(flatten)]
    prepare: Preparation,
    #[command(flatten)]
    writing: Writing,
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let mut known = Map::new();
    known.insert("output".into(), json!(arguments.output.to_string_lossy()));
    let output = ScanOutput::open(&arguments.output, &arguments.input.path, &arguments.writing)?;
    let scan = if arguments.surface {
        let surface = arguments
            .prepare
            .surface(&arguments.input, common, &mut known)?;
        surface.scan
    } else {
        arguments.input.scan()?
    };
    let scan = output.write(scan)?;
    known.insert("vertices".into(), json!(scan.vertices.rows));
    known.insert("faces".into(), json!(scan.faces.len()));
    Ok(Reply {
        json: known,
        ..Reply::default()
    })
}
