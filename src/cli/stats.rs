//! `relievo stats`

use std::fmt::Write;
use std::path::Path;

use crate::report::View;
use crate::scan::OutputFile;
use crate::stats::{Measured, figures};
use anyhow::Context;
use clap::Args;
use serde_json::{Map, json};

use super::comparison::{Measuring, csv_of, deliver_csv, of_completed, titled, unit};
use super::height_map::in_digits;
use super::outcome::Reply;
use super::reading::{Input, Preparation};
use super::report::PageOption;
use super::{Common, height_map};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
    #[command(flatten)]
    prepare: Preparation,
    #[command(flatten)]
    measuring: Measuring,
    #[command(flatten)]
    page: PageOption,
    #[command(flatten)]
    map: height_map::Options,
    /// Figures of the scan as a whole, completed or not, without comparing its parts
    #[arg(long, conflicts_with_all = ["pieces", "step", "report"])]
    whole: bool,
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let (map, measuring) = (&arguments.map, &arguments.measuring);
    if let Some(reply) = height_map::run(map, measuring, &arguments.input, common) {
        return reply;
    }
    parts(arguments, common).map_err(|failure| height_map::hinted(failure, &arguments.input))
}

/// The original against the completed part of a scan.
fn parts(arguments: &Arguments, common: &Common) -> super::Result {
    let mut known = Map::new();
    arguments.measuring.check(common.seed)?;
    let inputs: Vec<&Path> = arguments.input.files().collect();
    let csv = (arguments.measuring).csv(&inputs, common)?;
    let page = arguments.page.open(
        &inputs,
        &[("--csv", arguments.measuring.csv.as_deref())],
        common,
    )?;
    let (surface, prepared) =
        (arguments.prepare).told_surface(&arguments.input, common, &mut known)?;
    let scan = &surface.scan;
    let params = arguments.measuring.params(common.seed);
    if arguments.whole {
        let measured = Measured::new(scan, &params).with_context(|| arguments.input.name())?;
        return whole(arguments, &measured, csv, known);
    }
    let pieces = arguments.measuring.pieces;
    let compared =
        of_completed(scan, &params, pieces, common).with_context(|| arguments.input.name())?;
    if let Some(page) = page {
        let title = format!("{}, original against completed", arguments.input.name());
        let views = View::of_scan(&arguments.input.name(), scan, Vec::new());
        page.write(&arguments.measuring.page(
            &title,
            views.into_iter().collect(),
            &compared,
            &prepared,
            common.seed,
        ))?;
    }
    arguments.measuring.reply(&compared, csv, known)
}

/// Figures of one surface.
fn whole(
    arguments: &Arguments,
    measured: &Measured,
    csv: Option<OutputFile>,
    mut known: Map<String, serde_json::Value>,
) -> super::Result {
    let all = vec![true; measured.vertices()];
    let part = figures(measured, &all).with_context(|| arguments.input.name())?;
    known.insert("base".into(), json!(measured.base()));
    known.insert("whole".into(), json!(part));
    let rows = part.rows();
    let mut text = String::new();
    for row in &rows {
        let value = row.value.map_or_else(|| "-".to_owned(), in_digits);
        let _ = writeln!(text, "{:<38} {value:>12}", titled(row.name, row.meaning));
    }
    let rows: Vec<_> = (rows.iter())
        .map(|row| (row.name, unit(row.unit), row.value))
        .collect();
    let to_stdout = deliver_csv(csv, &csv_of(&rows))?;
    Ok(Reply {
        text: if to_stdout { String::new() } else { text },
        json: known,
        ..Reply::default()
    })
}
