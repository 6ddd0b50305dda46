//! `relievo stats`

use std::fmt::Write;

use anyhow::Context;
use clap::Args;
use relievo::stats::{self, Comparison};
use serde_json::{Map, Value, json};

use super::outcome::Reply;
use super::reading::{Input, Preparation};
use super::{Common, height_map};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
    #[command(flatten)]
    prepare: Preparation,
    #[command(flatten)]
    map: height_map::Options,
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    if let Some(reply) = height_map::run(&arguments.map, &arguments.input) {
        return reply;
    }
    parts(arguments, common).map_err(|failure| height_map::hinted(failure, &arguments.input))
}

/// The original against the completed part of a scan.
fn parts(arguments: &Arguments, common: &Common) -> super::Result {
    let mut known = Map::new();
    let surface = arguments
        .prepare
        .surface(&arguments.input, common, &mut known)?;
    let comparison = stats::compare(&surface.scan).with_context(|| arguments.input.name())?;
    let mut reply = Reply {
        text: table(&comparison),
        json: known,
        ..Reply::default()
    };
    if let Value::Object(members) = json!(comparison) {
        reply.json.extend(members);
    }
    Ok(reply)
}

fn table(comparison: &Comparison) -> String {
    let (old, new) = (&comparison.original, &comparison.completed);
    let mut text = format!(
        "{:<24} {:>14} {:>14} {:>9}\n",
        "", "original", "completed", "change"
    );
    let rows = [
        ("base area", old.area, new.area),
        ("mean integral", old.mean_integral, new.mean_integral),
        ("mean height", old.mean_height, new.mean_height),
        ("RMS roughness", old.rms_roughness, new.rms_roughness),
    ];
    for (name, old, new) in rows {
        let change = if name == "mean integral" || name == "RMS roughness" {
            let percent = 100.0 * (new / old - 1.0);
            if percent.is_finite() {
                format!("{percent:+.2} %")
            } else {
                "-".to_owned()
            }
        } else {
            String::new()
        };
        let _ = writeln!(text, "{name:<24} {old:>14.6} {new:>14.6} {change:>9}");
    }
    for color in comparison.colors.iter().flatten() {
        let _ = writeln!(
            text,
            "{:<24} {:>29.4}",
            format!("{} histogram corr.", color.channel),
            color.correlation
        );
    }
    text
}
