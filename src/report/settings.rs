//! The parameters of a completion, and why they are what they are.

use serde_json::Value;

use super::number::number;
use super::{Block, Column, Section, Table};
use crate::completion::{Chosen, CompleteParams, CompletionReport, Method};

/// The section with all parameters.
pub(super) fn section(params: &CompleteParams, report: &CompletionReport) -> Section {
    let mut blocks = Vec::new();
    if !report.chosen.is_empty() {
        blocks.push(Block::Table(Table {
            caption: "Parameters that follow from the scan unless they are given".to_owned(),
            columns: vec![
                Column::words("parameter"),
                Column::numbers("value"),
                Column::words("why"),
            ],
            rows: chosen(&report.chosen),
        }));
    }
    blocks.push(Block::Table(Table {
        caption: "All others".to_owned(),
        columns: vec![Column::words("parameter"), Column::words("value")],
        rows: others(params, &report.chosen),
    }));
    Section {
        heading: "Parameters".to_owned(),
        blocks,
    }
}

fn chosen(chosen: &[Chosen]) -> Vec<Vec<String>> {
    let row = |(index, one): (usize, &Chosen)| {
        let again = chosen[..index].iter().any(|c| c.name == one.name);
        // Those of the scan's own base surface come before those of free form.
        let name = match again {
            true => format!("{} (on free form)", one.name),
            false => one.name.to_owned(),
        };
        let value = match one.name {
            "blend" if one.value > 0.5 => "yes".to_owned(),
            "blend" => "no".to_owned(),
            "window" | "rotations" => format!("{:.0}", one.value),
            _ => number(one.value),
        };
        vec![name, value, one.reason.clone()]
    };
    chosen.iter().enumerate().map(row).collect()
}

/// Parameters that do not follow from the scan, by the names of their options.
fn others(params: &CompleteParams, chosen: &[Chosen]) -> Vec<Vec<String>> {
    let limits = &params.limits;
    let from_paper = "as in the paper".to_owned();
    let given = |value: Option<f64>| value.map_or(from_paper.clone(), number);
    let mut rows = vec![
        ("base", plain(&params.fit.base)),
        ("method", plain(&params.method)),
        ("holes", plain(&params.holes)),
    ];
    let limits = [
        ("max-edges", limits.max_edges.map(|edges| edges.to_string())),
        ("max-length", limits.max_length.map(number)),
        ("max-area", limits.max_area.map(number)),
        ("mask", params.paint.as_ref().map(plain)),
        ("form-wavelength", params.form_wavelength.map(number)),
    ];
    rows.extend((limits.into_iter()).filter_map(|(name, value)| Some((name, value?))));
    // Where none was chosen, the paper's or those given hold.
    let suited = [
        (
            "spacing",
            params.spacing.as_ref().map_or("nyquist".to_owned(), plain),
        ),
        ("window", given(params.window.map(|window| window as f64))),
        ("rotations", given(params.rotations.map(f64::from))),
        ("shape-weight", given(params.mu)),
        ("error-threshold", given(params.error_threshold)),
    ];
    let is_chosen = |name: &str| chosen.iter().any(|chosen| chosen.name == name);
    if params.method == Method::Paper {
        rows.extend(suited.into_iter().filter(|(name, _)| !is_chosen(name)));
    }
    rows.extend([
        ("extend", yes_or_no(params.extend)),
        ("bootstrap", yes_or_no(params.bootstrap)),
        ("tolerance", number(params.tolerance)),
        ("stray", number(params.stray)),
    ]);
    if params.method == Method::Coherent {
        rows.extend([
            ("coherence", number(params.coherence)),
            ("sites", params.sites.to_string()),
            ("audit", number(params.audit)),
        ]);
    }
    if params.method != Method::Paper {
        rows.push(("memory", format!("{} bytes", params.memory)));
    }
    rows.push(("seed", params.seed.to_string()));
    (rows.into_iter())
        .map(|(name, value)| vec![name.to_owned(), value])
        .collect()
}

fn yes_or_no(value: bool) -> String {
    if value { "yes" } else { "no" }.to_owned()
}

/// A parameter as the JSON has it, without its punctuation.
pub(super) fn plain<T: serde::Serialize>(value: &T) -> String {
    fn words(value: &Value) -> String {
        match value {
            Value::String(text) => text.clone(),
            Value::Array(items) => (items.iter().map(words).collect::<Vec<_>>()).join(", "),
            Value::Object(members) => (members.iter())
                .map(|(name, value)| format!("{name} {}", words(value)))
                .collect::<Vec<_>>()
                .join(", "),
            other => other.to_string(),
        }
    }
    serde_json::to_value(value).map_or_else(|error| error.to_string(), |value| words(&value))
}
