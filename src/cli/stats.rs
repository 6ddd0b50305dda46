//! `relievo stats`

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use relievo::scan;
use relievo::stats::{self, Comparison};
use serde_json::{Value, json};

use super::outcome::Reply;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A scan that `relievo complete` wrote as PLY; - for standard input
    #[arg(value_name = "COMPLETED")]
    pub(super) input: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> super::Result {
    let completed = scan::read(&arguments.input)?;
    let comparison =
        stats::compare(&completed).with_context(|| arguments.input.display().to_string())?;
    let mut reply = Reply {
        text: table(&comparison),
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
