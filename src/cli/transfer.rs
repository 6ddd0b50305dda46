//! `relievo transfer`

mod given;
mod options;
mod output;
mod source;

use std::fmt::Write;
use std::path::Path;

use crate::report::{self, TransferredPage};
use crate::scan::same_file;
use crate::stats::ColorComparison;
use crate::transfer::{self, TransferError, TransferParams, Transferred};
use serde_json::{Map, Value, json};

use super::mesh_output::{MeshOutput, output_format};
use super::messages::Bar;
use super::outcome::{Failure, Reply};
use super::{Common, histograms};
use given::Painted;
pub(super) use options::Arguments;
use output::Onto;
use source::FromSource;

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let mut known = Map::new();
    known.insert("output".into(), json!(arguments.output.to_string_lossy()));
    known.insert("source".into(), json!(arguments.source_input().name()));
    work(arguments, common, &mut known).map_err(|failure| Failure {
        json: known,
        ..failure
    })
}

fn work(arguments: &Arguments, common: &Common, known: &mut Map<String, Value>) -> super::Result {
    let mut params = arguments.params(common.seed);
    arguments.check()?;
    params.check().map_err(|error| failed(error, arguments))?;
    let format = output_format(&arguments.output)?;
    let to = arguments.destination(format);
    let target = arguments.target_input();
    let inputs: Vec<&Path> = arguments.files().collect();
    let page = (arguments.page).open(&inputs, &[("-o", Some(&arguments.output))], common)?;
    let (surface, mut prepared) = (arguments.prepare).told_surface(&target, common, known)?;
    let output = MeshOutput::open(&to, &surface, &target.name())?;
    let mut source = FromSource::read(arguments, &surface, common, known)?;
    let onto = Onto::new(arguments, &surface, &source);
    let painted = Painted::new(arguments, &surface, &source)?;
    if let Some(path) = &arguments.correspondences {
        params.shape = given::correspondences(path, &source.mesh, &onto.mesh)?;
    }
    let map = (arguments.init.as_deref())
        .map(|path| given::map(path, &source.mesh, &onto.mesh))
        .transpose()?;
    known.insert("parameters".into(), json!(params));
    known.insert("displaced".into(), json!(arguments.displacement()));
    source.measure(arguments, common, known)?;
    let done = transferred(
        arguments,
        &source,
        &onto,
        map.as_deref(),
        painted.as_ref(),
        &params,
        common,
    )?;
    let colors = (source.colors.as_deref().zip(done.colors.as_deref()))
        .map(|(from, found)| compared(from, found, painted.as_ref()));
    let correlation = colors.as_ref().map(histograms::correlations);
    tell_json(&done, correlation, known);
    let bar = Bar::doing(common, "writing");
    let positions = onto.write((&to, output), &source, &done, painted.as_ref(), known)?;
    drop(bar);
    if let Some(page) = page {
        prepared.extend_from_slice(&source.prepared);
        page.write(&report::transferred(&TransferredPage {
            source: &arguments.source_input().name(),
            target: &target.name(),
            prepared: &prepared,
            params: &params,
            mesh: source.fine_mesh(),
            mesh_colors: source.colors.as_deref(),
            done: &done,
            positions: &positions,
            scale: arguments.displacement(),
            colors: colors.as_ref(),
        }))?;
    }
    tell(&done, correlation, common);
    Ok(Reply {
        json: std::mem::take(known),
        ..Reply::default()
    })
}

fn transferred(
    arguments: &Arguments,
    source: &FromSource,
    onto: &Onto,
    map: Option<&[Option<u32>]>,
    painted: Option<&Painted>,
    params: &TransferParams,
    common: &Common,
) -> Result<Transferred, Failure> {
    let from = transfer::Source {
        mesh: source.fine_mesh(),
        colors: source.colors.as_deref(),
        heights: source.heights.as_deref(),
    };
    let mut bar = Bar::new(common);
    let mut show = |progress| bar.show(progress);
    let done = match painted {
        Some(painted) => transfer::spread(&from, &painted.fine, params, &mut show),
        None => transfer::transfer(&from, &onto.mesh, map, params, &mut show),
    };
    done.map_err(|error| failed(error, arguments))
}

/// The colors beside those that could be copied: of what is painted, those that were not.
fn compared(
    from: &[[f64; 3]],
    found: &[[f64; 3]],
    painted: Option<&Painted>,
) -> [ColorComparison; 3] {
    let chosen = |colors: &[[f64; 3]], wanted: bool| -> Vec<[f64; 3]> {
        match painted {
            Some(painted) => (colors.iter().zip(&painted.fine))
                .filter(|(_, painted)| **painted == wanted)
                .map(|(color, _)| *color)
                .collect(),
            None => colors.to_vec(),
        }
    };
    histograms::beside_source(chosen(from, true), &chosen(found, false))
}

/// A mistake on the command line, or files that nothing comes of.
fn failed(error: TransferError, arguments: &Arguments) -> Failure {
    let option = match error {
        TransferError::Vertices { .. } => Some("--vertices"),
        TransferError::Scale(_) => Some("--scale"),
        TransferError::ShapeWeight(_) => Some("--shape-weight"),
        TransferError::Coherence(_) => Some("--coherence"),
        TransferError::Overuse(_) => Some("--overuse"),
        TransferError::Rounds(_) => Some("--rounds"),
        TransferError::Up => Some("--up"),
        _ => None,
    };
    if let Some(option) = option {
        return Failure::usage(format!("{option}: {error}"));
    }
    let map = || {
        arguments
            .init
            .as_ref()
            .map(|path| path.display().to_string())
    };
    let file = match error {
        TransferError::NoFaces { of_source: false }
        | TransferError::NoArea { of_source: false } => arguments.target_input().name(),
        TransferError::MapLength { .. }
        | TransferError::MapRange { .. }
        | TransferError::MapEmpty => map().unwrap_or_default(),
        _ => arguments.source_input().name(),
    };
    anyhow::Error::new(error).context(file).into()
}

fn tell_json(done: &Transferred, correlation: Option<[f64; 3]>, known: &mut Map<String, Value>) {
    if let Value::Object(members) = json!(done.report) {
        known.extend(members);
    }
    if let Some(finest) = done.report.levels.first() {
        known.insert("mean_cost".into(), json!(finest.mean_cost));
        known.insert("coherent_edges".into(), json!(finest.coherent_edges));
    }
    known.insert("histogram_correlation".into(), json!(correlation));
}

/// A summary for people, on standard error: standard output may carry the mesh.
fn tell(done: &Transferred, correlation: Option<[f64; 3]>, common: &Common) {
    let report = &done.report;
    let Some(finest) = report.levels.first().filter(|_| !common.quiet) else {
        return;
    };
    let mut text = format!(
        "relievo: {} vertices matched with {} of the source, on {} level(s)\n",
        finest.vertices,
        finest.source_vertices,
        report.levels.len()
    );
    let _ = writeln!(
        text,
        "relievo: {:.1} % of the edges continue the source; mean cost {:.3}, where 1 is what has nothing in common",
        100.0 * finest.coherent_edges,
        finest.mean_cost
    );
    if let Some(correlation) = correlation {
        let _ = writeln!(
            text,
            "relievo: {}",
            histograms::in_words(correlation, "source")
        );
    }
    if let Some(audit) = &finest.audit {
        let _ = writeln!(
            text,
            "relievo: {} matches cost {:.3} on average, the best ones that there are {:.3}",
            audit.vertices, audit.mean_cost, audit.least_cost
        );
    }
    // Nowhere is left to report that standard error is closed.
    let _ = std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes());
}

/// Whether two paths name one file.
fn is_same(a: &Path, b: &Path) -> bool {
    a == b || same_file(a, b)
}
