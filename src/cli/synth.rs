//! `relievo synth`

use std::path::PathBuf;

use crate::scan::{self, OutputFile, WriteOptions};
use crate::synth::{self, Kind, Part, SynthParams};
use clap::Args;
use nalgebra::Vector3;
use serde_json::json;

use super::outcome::{Failure, Reply};
use super::{Common, arguments};

/// Share of the vertices that the hole takes where nothing else is asked for.
const DEFAULT_HOLE: f64 = 0.1;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// waves, noise, golf-ball, bark, column or bricks
    #[arg(value_name = "KIND", value_parser = arguments::kind)]
    kind: Kind,
    /// The scan: .ply, .obj, .off, .stl or .glb; - for PLY on standard output
    #[arg(short, long, value_name = "OUT")]
    pub(super) output: PathBuf,
    /// Number of vertices of the complete object
    #[arg(long, value_name = "N", default_value_t = 12_000)]
    vertices: usize,
    /// Only what a scanner in this direction sees (from the object to the scanner)
    #[arg(long, value_name = "x,y,z", value_parser = arguments::vector, allow_hyphen_values = true)]
    view: Option<Vector3<f64>>,
    /// Cut out a hole with this share of the vertices, up to 0.5 [default without --view and --full:
    /// 0.1]
    #[arg(long, value_name = "FRACTION")]
    hole: Option<f64>,
    /// Standard deviation of the noise along the normal, in the object's unit (mm)
    #[arg(
        long,
        value_name = "SIGMA",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    noise: f64,
    /// The complete object: what a completed scan may be compared with
    #[arg(long, conflicts_with_all = ["view", "hole"])]
    full: bool,
    /// Write PLY as text
    #[arg(long)]
    ascii: bool,
}

impl Arguments {
    pub(super) fn params(&self, seed: u32) -> SynthParams {
        let hole = if self.full || self.view.is_some() {
            self.hole
        } else {
            Some(self.hole.unwrap_or(DEFAULT_HOLE))
        };
        SynthParams {
            kind: self.kind,
            vertices: self.vertices,
            part: Part {
                view: self.view,
                hole,
            },
            noise: self.noise,
            seed,
        }
    }
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let format = arguments::output_format(&arguments.output)?;
    let params = arguments.params(common.seed);
    let mut output = OutputFile::create(&arguments.output, None)?;
    let made = synth::scan(&params).map_err(|error| Failure {
        usage: true,
        ..error.into()
    })?;
    let name = output.name().to_owned();
    let options = WriteOptions {
        ascii: arguments.ascii,
    };
    scan::write_to(&made.scan, &mut output, format, &options, &name)?;
    output.commit()?;
    let mut reply = Reply::default();
    reply
        .json
        .insert("output".into(), json!(arguments.output.to_string_lossy()));
    reply.json.insert("parameters".into(), json!(params));
    reply.json.insert("base".into(), json!(made.base));
    reply
        .json
        .insert("vertices".into(), json!(made.scan.vertices.rows));
    reply
        .json
        .insert("faces".into(), json!(made.scan.faces.len()));
    Ok(reply)
}
