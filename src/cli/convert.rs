//! `relievo convert`

use std::path::PathBuf;

use clap::Args;
use relievo::scan::{self, OutputFile, WriteOptions};
use serde_json::{Map, json};

use super::Common;
use super::arguments;
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
    /// Write PLY as text
    #[arg(long)]
    ascii: bool,
    /// Allow OUT to be the same file as the input
    #[arg(long)]
    overwrite: bool,
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let mut known = Map::new();
    known.insert("output".into(), json!(arguments.output.to_string_lossy()));
    let format = arguments::output_format(&arguments.output)?;
    let protected = (!arguments.overwrite).then_some(arguments.input.path.as_path());
    let mut output = OutputFile::create(&arguments.output, protected)?;
    let scan = if arguments.surface {
        let surface = arguments
            .prepare
            .surface(&arguments.input, common, &mut known)?;
        surface.scan
    } else {
        arguments.input.scan()?
    };
    let options = WriteOptions {
        ascii: arguments.ascii,
    };
    let name = output.name().to_owned();
    scan::write_to(&scan, &mut output, format, &options, &name)?;
    output.commit()?;
    known.insert("vertices".into(), json!(scan.vertices.rows));
    known.insert("faces".into(), json!(scan.faces.len()));
    Ok(Reply {
        json: known,
        ..Reply::default()
    })
}
