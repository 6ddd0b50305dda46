//! A comparison of two parts for people, as CSV and as JSON.

use std::borrow::Cow;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::base::{BaseChoice, FitParams};
use crate::completion::COMPLETED;
use crate::report::{self, Page, View};
use crate::scan::{OutputFile, Scan};
use crate::stats::areal::ParameterUnit;
use crate::stats::{
    Comparison, ComparisonRow, MeasureParams, Measured, Natural, NaturalParams, StatsError,
    Verdict, compare_parts, completed_vertices, copied, natural_variation, verdict,
};
use clap::Args;
use serde_json::{Map, Value, json};

use super::height_map::in_digits;
use super::messages::Bar;
use super::outcome::{Failure, Reply, opened, written};
use super::{Common, arguments, scores};

/// How heights are taken, and where the figures go.
#[derive(Debug, Clone, Args)]
pub(super) struct Measuring {
    /// Base surface under the relief: auto, plane, sphere, cylinder, cone or freeform [default: as noted by
    /// complete, else what fits, else freeform]
    #[arg(long, value_name = "KIND", default_value = "auto", value_parser = arguments::form)]
    base: BaseChoice,
    /// Freeform base: what is longer than this is form, what is shorter relief, in the scan's unit
    /// [default: where heights depend on it least]
    #[arg(long, value_name = "LENGTH", value_parser = arguments::length)]
    form_wavelength: Option<f64>,
    /// S-filter: take waves shorter than this off the heights (a half of it at this length)
    #[arg(long, value_name = "LENGTH", value_parser = arguments::length)]
    pub(super) s_filter: Option<f64>,
    /// L-filter: take waves longer than this off the heights
    #[arg(long, value_name = "LENGTH", value_parser = arguments::length)]
    pub(super) l_filter: Option<f64>,
    /// Number of pieces of the original that natural variation is taken from, at least 60; 0 for no scores
    #[arg(long, value_name = "N", default_value_t = PIECES)]
    pub(super) pieces: usize,
    /// Write the table as CSV to FILE, or to standard output (-)
    #[arg(long, value_name = "FILE|-")]
    pub(super) csv: Option<PathBuf>,
}

/// Two parts, compared.
#[derive(Debug)]
pub(super) struct Compared {
    pub(super) comparison: Comparison,
    pub(super) natural: Result<Natural, StatsError>,
    pub(super) verdict: Verdict,
    /// Headings of the two columns.
    pub(super) headings: [&'static str; 2],
    /// What the parts are called in a sentence.
    pub(super) names: [String; 2],
}

impl Measuring {
    pub(super) fn params(&self, seed: u32) -> MeasureParams {
        MeasureParams {
            fit: FitParams {
                base: self.base,
                seed,
                ..FitParams::default()
            },
            form_wavelength: self.form_wavelength,
            s_filter: self.s_filter,
            l_filter: self.l_filter,
        }
    }

    /// # Errors
    /// A failure of usage if an option is out of its range.
    pub(super) fn check(&self, seed: u32) -> Result<(), Failure> {
        let natural = NaturalParams {
            pieces: self.pieces,
            seed,
        };
        let pieces = if self.pieces == 0 {
            Ok(())
        } else {
            natural.check()
        };
        let params = self.params(seed);
        pieces
            .and_then(|()| params.check())
            .map_err(|error| Failure {
                usage: true,
                ..error.into()
            })
    }

    /// Opens the CSV before the work, so that a folder that is missing is noticed then.
    pub(super) fn csv(
        &self,
        inputs: &[&Path],
        common: &Common,
    ) -> Result<Option<OutputFile>, Failure> {
        let others = [("--json", common.json.as_deref())];
        let opened = |path: &PathBuf| opened("--csv", path, inputs, &others);
        self.csv.as_ref().map(opened).transpose()
    }

    /// Judges two parts by natural variation. `names` are those of the parts in a sentence.
    pub(super) fn judged(
        &self,
        measured: &Measured,
        parts: [&[bool]; 2],
        comparison: Comparison,
        names: [&str; 2],
        headings: [&'static str; 2],
        common: &Common,
    ) -> Compared {
        let natural = natural(measured, parts, self.pieces, common);
        Compared {
            verdict: verdict(&comparison, &natural, names),
            comparison,
            natural,
            headings,
            names: names.map(str::to_owned),
        }
    }

    /// The page, with views of what was compared.
    pub(super) fn page(
        &self,
        title: &str,
        views: Vec<View>,
        compared: &Compared,
        prepared: &[String],
        seed: u32,
    ) -> Page {
        let measurement = report::Measurement {
            prepared,
            params: &self.params(seed),
            pieces: self.pieces,
            seed,
        };
        report::compared(title, views, &compared.parts(), &measurement)
    }

    /// The reply: a table and the verdict, or the CSV; and all figures as JSON.
    pub(super) fn reply(
        &self,
        compared: &Compared,
        csv: Option<OutputFile>,
        mut known: Map<String, Value>,
    ) -> super::Result {
        let csv_to_stdout = deliver_csv(csv, &compared.csv())?;
        known.extend(compared.json());
        Ok(Reply {
            text: if csv_to_stdout {
                String::new()
            } else {
                compared.table()
            },
            json: known,
            ..Reply::default()
        })
    }
}

/// Number of pieces that natural variation is taken from unless another is given.
pub(super) const PIECES: usize = 128;

/// The original against the completed part of a scan, judged by natural variation.
pub(super) fn of_completed(
    scan: &Scan,
    params: &MeasureParams,
    pieces: usize,
    common: &Common,
) -> Result<Compared, StatsError> {
    if scan.vertices.channel(COMPLETED).is_none() {
        return Err(StatsError::NotCompleted);
    }
    let bar = Bar::doing(common, "heights");
    let measured = Measured::new(scan, params)?;
    let completed = completed_vertices(scan);
    let original: Vec<bool> = completed.iter().map(|completed| !completed).collect();
    let mut comparison = compare_parts(&measured, &original, &completed)?;
    comparison.copies = copied(scan, &measured);
    drop(bar);
    let natural = natural(&measured, [&original, &completed], pieces, common);
    let names = ["the original", "the completed part"];
    Ok(Compared {
        verdict: verdict(&comparison, &natural, names),
        comparison,
        natural,
        headings: ["original", "completed"],
        names: names.map(str::to_owned),
    })
}

/// How much of the difference of two parts is natural, if that is asked for.
fn natural(
    measured: &Measured,
    [first, second]: [&[bool]; 2],
    pieces: usize,
    common: &Common,
) -> Result<Natural, StatsError> {
    if pieces == 0 {
        return Err(StatsError::NotAsked);
    }
    let params = NaturalParams {
        pieces,
        seed: common.seed,
    };
    let mut bar = Bar::new(common);
    natural_variation(measured, first, second, &params, &mut |p| bar.show(p))
}

/// Writes a CSV if one was asked for; whether it went to standard output.
pub(super) fn deliver_csv(csv: Option<OutputFile>, text: &str) -> Result<bool, Failure> {
    let Some(csv) = csv else {
        return Ok(false);
    };
    let to_stdout = csv.is_stdout();
    written(csv, text.as_bytes())?;
    Ok(to_stdout)
}

/// The figures of one surface as CSV: names, units and values.
pub(super) fn csv_of(rows: &[(&str, &str, Option<f64>)]) -> String {
    let mut text = "name,unit,value\n".to_owned();
    for (name, unit, value) in rows {
        let (name, unit, value) = (quoted(name), quoted(unit), cell(*value));
        let _ = writeln!(text, "{name},{unit},{value}");
    }
    text
}

/// A text in a CSV, in quotation marks if it needs them (RFC 4180, section 2).
fn quoted(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\"")).into()
    } else {
        text.into()
    }
}

/// A number in a CSV, with all its digits; empty for none.
fn cell(value: Option<f64>) -> String {
    let value = value.filter(|value| value.is_finite());
    value.map_or_else(String::new, |value| value.to_string())
}

impl Compared {
    /// For a page.
    pub(super) fn parts(&self) -> report::Compared<'_> {
        report::Compared {
            headings: self.headings,
            names: [&self.names[0], &self.names[1]],
            comparison: &self.comparison,
            natural: self.natural.as_ref().ok(),
            verdict: Some(&self.verdict),
        }
    }

    /// Members of the JSON object.
    pub(super) fn json(&self) -> Map<String, Value> {
        let mut members = match json!(self.comparison) {
            Value::Object(members) => members,
            _ => Map::new(),
        };
        match &self.natural {
            Ok(natural) => members.insert("natural".into(), json!(natural)),
            Err(_) => members.insert("natural".into(), Value::Null),
        };
        members.insert("verdict".into(), json!(self.verdict));
        let mut members = Value::Object(members);
        self.rename(&mut members);
        match members {
            Value::Object(members) => members,
            _ => Map::new(),
        }
    }

    /// What is said of the original and the completed part of a scan is said of the parts by their headings.
    fn rename(&self, value: &mut Value) {
        match value {
            Value::Object(members) => {
                let old = std::mem::take(members).into_iter();
                let renamed = old.map(|(key, mut value)| {
                    self.rename(&mut value);
                    match key.as_str() {
                        "original" => (self.headings[0].to_owned(), value),
                        "completed" => (self.headings[1].to_owned(), value),
                        _ => (key, value),
                    }
                });
                *members = renamed.collect();
            }
            Value::Array(values) => values.iter_mut().for_each(|value| self.rename(value)),
            _ => {}
        }
    }

    fn rows(&self) -> Vec<ComparisonRow> {
        self.comparison.rows(self.natural.as_ref().ok())
    }

    fn table(&self) -> String {
        let [first, second] = self.headings;
        let mut text = format!(
            "{:<38} {first:>12} {second:>12} {:>9} {:>6}\n",
            "", "change", "score"
        );
        let dash = || "-".to_owned();
        for row in self.rows() {
            let name = titled(row.name, row.meaning);
            let [old, new] = [row.original, row.completed].map(|v| v.map_or_else(dash, in_digits));
            let change = row
                .change_percent
                .map_or_else(String::new, |c| format!("{c:+.2} %"));
            let score = row.score.map_or_else(String::new, |s| format!("{s:.2}"));
            let row = format!("{name:<38} {old:>12} {new:>12} {change:>9} {score:>6}");
            let _ = writeln!(text, "{}", row.trim_end());
        }
        let mut correlation = |name: &str, value: f64| {
            let _ = writeln!(
                text,
                "{:<38} {value:>25.4}",
                format!("{name} histogram correlation")
            );
        };
        correlation("height", self.comparison.heights.correlation);
        for color in self.comparison.colors.iter().flatten() {
            correlation(color.channel, color.correlation);
        }
        if let Ok(natural) = &self.natural {
            text.push('\n');
            scores::table(&mut text, &natural.scores.measures, &natural.scores.overall);
        }
        let _ = writeln!(text, "\n{}", self.verdict.text);
        text
    }

    fn csv(&self) -> String {
        let [first, second] = self.headings;
        let mut text = format!("name,unit,{first},{second},change_percent,score\n");
        for row in self.rows() {
            let [old, new] = [row.original, row.completed].map(cell);
            let (change, score) = (cell(row.change_percent), cell(row.score));
            let unit = unit(row.unit);
            let _ = writeln!(text, "{},{unit},{old},{new},{change},{score}", row.name);
        }
        let mut measure = |name: &str, value: Option<f64>, score: Option<f64>| {
            let _ = writeln!(text, "{name},,,{},,{}", cell(value), cell(score));
        };
        let heights = &self.comparison.heights;
        measure(
            "height histogram correlation",
            Some(heights.correlation),
            None,
        );
        for color in self.comparison.colors.iter().flatten() {
            let name = format!("{} histogram correlation", color.channel);
            measure(&name, Some(color.correlation), None);
        }
        if let Ok(natural) = &self.natural {
            for of in &natural.scores.measures {
                measure(of.measure.name(), None, Some(of.scores.median));
            }
            measure("all together", None, Some(natural.scores.overall.median));
        }
        text
    }
}

/// A figure's name with what it is.
pub(super) fn titled(name: &str, meaning: &str) -> String {
    match meaning {
        "" => name.to_owned(),
        meaning => format!("{name:<4} {meaning}"),
    }
}

/// The unit's name where lengths are in the scan's.
pub(super) fn unit(unit: ParameterUnit) -> &'static str {
    match unit {
        ParameterUnit::Height | ParameterUnit::Length | ParameterUnit::VolumeOverArea => "unit",
        ParameterUnit::Area => "unit^2",
        ParameterUnit::Percent => "%",
        ParameterUnit::Degrees => "degrees",
        ParameterUnit::One => "1",
    }
}
