//! `relievo evaluate`

use std::fmt::Write;

use crate::completion::CompletionError;
use crate::evaluation::{
    self, Evaluation, EvaluationError, EvaluationParams, FillKind, HeightsOver, Repeat,
};
use crate::likeness::Judgement;
use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

use super::complete::How;
use super::messages::Bar;
use super::outcome::{Failure, Reply};
use super::reading::{Input, Preparation};
use super::{Common, scores};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
    #[command(flatten)]
    prepare: Preparation,
    /// Share of the scan's area that each hole takes, up to 0.25
    #[arg(
        long,
        value_name = "FRACTION",
        default_value_t = 0.04,
        allow_negative_numbers = true
    )]
    hole: f64,
    /// Number of holes, each cut out of the whole scan
    #[arg(long, value_name = "N", default_value_t = 3)]
    repeat: usize,
    /// Number of true pieces that figures are calibrated with, at least 60
    #[arg(long, value_name = "N", default_value_t = 128)]
    pieces: usize,
    /// What the holes are filled with
    #[arg(long, value_enum, default_value_t = FillName::Completed)]
    fill: FillName,
    #[command(flatten)]
    how: How,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum FillName {
    /// What `relievo complete` fills them with
    Completed,
    /// The base surface alone, in colours blended from the rim, for comparison
    Smooth,
}

impl Arguments {
    pub(super) fn params(&self, seed: u32) -> EvaluationParams {
        EvaluationParams {
            hole: self.hole,
            repeat: self.repeat,
            pieces: self.pieces,
            fill: match self.fill {
                FillName::Completed => FillKind::Completed,
                FillName::Smooth => FillKind::Smooth,
            },
            complete: self.how.params(seed),
            seed,
        }
    }
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let params = arguments.params(common.seed);
    let mut known = Map::new();
    known.insert("parameters".into(), json!(params));
    work(arguments, common, &params, &mut known).map_err(|failure| Failure {
        json: known,
        ..failure
    })
}

fn work(
    arguments: &Arguments,
    common: &Common,
    params: &EvaluationParams,
    known: &mut Map<String, Value>,
) -> super::Result {
    params.check().map_err(|error| Failure {
        usage: true,
        ..error.into()
    })?;
    let surface = arguments.prepare.surface(&arguments.input, common, known)?;
    let mut bar = Bar::new(common);
    let evaluated = evaluation::evaluate(&surface.scan, params, &mut |progress| bar.show(progress));
    drop(bar);
    let evaluation = evaluated.map_err(|error| failed(error, arguments))?;
    if let Value::Object(members) = json!(evaluation) {
        known.extend(members);
    }
    Ok(Reply {
        partly: !evaluation.failed.is_empty(),
        text: told(&evaluation),
        json: std::mem::take(known),
    })
}

fn failed(error: EvaluationError, arguments: &Arguments) -> Failure {
    let usage = matches!(
        error,
        EvaluationError::Completion(CompletionError::NoSuchLoop { .. })
    );
    let file = arguments.input.name();
    Failure {
        usage,
        ..anyhow::Error::new(error).context(file).into()
    }
}

/// A table for people, and what it means in words.
fn told(evaluation: &Evaluation) -> String {
    let mut text = String::new();
    scores::table(&mut text, &evaluation.measures, &evaluation.overall);
    text.push('\n');
    figures(&mut text, &evaluation.repeats);
    text.push('\n');
    in_words(&mut text, evaluation);
    text
}

/// Plain figures, hole by hole.
fn figures(text: &mut String, repeats: &[Repeat]) {
    /// A row: its name, and how to read it off a hole.
    type Row = (&'static str, fn(&Repeat) -> Option<f64>);
    let rows: [Row; 9] = [
        ("Sq, completed/original", Repeat::sq_ratio),
        ("Sdq, completed/original", Repeat::sdq_ratio),
        ("RMSE to truth/Sq", Repeat::rmse_over_sq),
        ("mean integral - truth, %", |r| {
            Some(r.against_truth?.mean_integral_difference_percent)
        }),
        ("least colour hist. corr.", |r| {
            r.color_correlation?.into_iter().reduce(f64::min)
        }),
        ("copied with neighbors", |r| {
            Some(r.copies?.neighboring_edges)
        }),
        ("largest piece copied", |r| Some(r.copies?.largest_piece)),
        ("most re-used source", |r| {
            Some(r.copies?.most_reused as f64)
        }),
        ("seconds", |r| Some(r.seconds)),
    ];
    let _ = write!(text, "{:<24}", "hole");
    for number in 1..=repeats.len() {
        let _ = write!(text, " {number:>9}");
    }
    text.push('\n');
    for (name, get) in rows {
        let values: Vec<Option<f64>> = repeats.iter().map(get).collect();
        if values.iter().all(Option::is_none) {
            continue;
        }
        let _ = write!(text, "{name:<24}");
        for value in values {
            let value = value.map_or("-".to_owned(), |value| format!("{value:.3}"));
            let _ = write!(text, " {value:>9}");
        }
        text.push('\n');
    }
}

fn in_words(text: &mut String, evaluation: &Evaluation) {
    let judgements: Vec<&Judgement> = evaluation.repeats.iter().map(|r| &r.judgement).collect();
    let outside = scores::outside(&evaluation.measures, &judgements);
    let _ = if outside.is_empty() {
        writeln!(
            text,
            "All measures are within this surface's natural variation."
        )
    } else {
        writeln!(
            text,
            "Outside of this surface's natural variation: {outside}."
        )
    };
    let copies = || evaluation.repeats.iter().filter_map(|r| r.copies);
    let (pastes, garbage) = (
        copies().filter(|c| c.is_paste).count(),
        copies().filter(|c| c.is_garbage).count(),
    );
    if pastes > 0 {
        let _ = writeln!(text, "Most of {pastes} fill(s) is one verbatim copy.");
    }
    if garbage > 0 {
        let _ = writeln!(text, "Much of {garbage} fill(s) is copied from one vertex.");
    }
    let uncut = |r: &&Repeat| r.heights_over == HeightsOver::Uncut;
    let count = evaluation.repeats.iter().filter(uncut).count();
    if count > 0 {
        let _ = writeln!(
            text,
            "No base surface fits the whole scan: in {count} hole(s) heights are over the one that comes nearest, form included."
        );
    }
    for reason in &evaluation.failed {
        let _ = writeln!(text, "A hole was left open: {reason}.");
    }
}
