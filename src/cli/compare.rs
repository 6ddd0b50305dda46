//! `relievo compare`

use std::path::{Path, PathBuf};

use crate::base::{BaseChoice, Form};
use crate::completion::Paint;
use crate::report::{Channel, View};
use crate::scan::Scan;
use crate::stats::{MeasureParams, Measured, StatsError, compare_parts};
use anyhow::Context;
use clap::Args;
use serde_json::{Map, Value};

use super::comparison::Measuring;
use super::outcome::Failure;
use super::reading::{Input, Preparation};
use super::report::PageOption;
use super::{Common, arguments};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
    /// The scan to compare with it [default: the same, to compare two parts of it]
    #[arg(value_name = "OTHER")]
    pub(super) other: Option<PathBuf>,
    /// Of the first scan only vertices with the property NAME other than 0, or equal to VALUE, or of the colour
    /// RRGGBB
    #[arg(long, value_name = "NAME|NAME=VALUE|#RRGGBB", value_parser = arguments::paint)]
    part: Option<Paint>,
    /// The same of the other scan
    #[arg(long, value_name = "NAME|NAME=VALUE|#RRGGBB", value_parser = arguments::paint)]
    other_part: Option<Paint>,
    #[command(flatten)]
    prepare: Preparation,
    #[command(flatten)]
    measuring: Measuring,
    #[command(flatten)]
    page: PageOption,
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let other_path = arguments.other.as_deref();
    if other_path.is_none() && arguments.part.is_none() && arguments.other_part.is_none() {
        return Err(Failure::usage(
            "there is nothing to compare: give a second scan, or parts of the first by --part and --other-part",
        ));
    }
    let inputs: Vec<&Path> = (arguments.input.files()).chain(other_path).collect();
    arguments.measuring.check(common.seed)?;
    let csv = arguments.measuring.csv(&inputs, common)?;
    let csv_path = arguments.measuring.csv.as_deref();
    let page = (arguments.page).open(&inputs, &[("--csv", csv_path)], common)?;
    let mut known = Map::new();
    let sides = match other_path {
        None => Sides::of_one(arguments, common, &mut known)?,
        Some(path) => Sides::of_two(arguments, path, common, &mut known)?,
    };
    let [first, second] = &sides.parts;
    let names = [sides.names[0].as_str(), sides.names[1].as_str()];
    let comparison = compare_parts(&sides.measured, first, second)
        .map_err(of_parts)
        .with_context(|| {
            let other = other_path.map(|path| arguments.input.with_path(path).name());
            let names: Vec<String> = std::iter::once(arguments.input.name())
                .chain(other)
                .collect();
            names.join(" and ")
        })?;
    let (parts, headings) = ([&first[..], &second[..]], ["a", "b"]);
    let compared =
        (arguments.measuring).judged(&sides.measured, parts, comparison, names, headings, common);
    if let Some(page) = page {
        let title = format!("{} against {}", names[1], names[0]);
        let (views, prepared) = (sides.views, &sides.prepared);
        page.write(&(arguments.measuring).page(&title, views, &compared, prepared, common.seed))?;
    }
    arguments.measuring.reply(&compared, csv, known)
}

/// An error in words that fit two parts of any kind.
fn of_parts(error: StatsError) -> StatsError {
    match error {
        StatsError::EmptyPart("original") => StatsError::EmptyPart("first part's"),
        StatsError::EmptyPart(_) => StatsError::EmptyPart("second part's"),
        other => other,
    }
}

/// What is compared.
struct Sides {
    measured: Measured,
    /// #V each.
    parts: [Vec<bool>; 2],
    names: [String; 2],
    /// For the page, if one is asked for.
    views: Vec<View>,
    /// What was done before, in sentences.
    prepared: Vec<String>,
}

impl Sides {
    /// Two parts of one scan.
    fn of_one(
        arguments: &Arguments,
        common: &Common,
        known: &mut Map<String, Value>,
    ) -> Result<Self, Failure> {
        let paint = arguments.part.as_ref();
        let side = Side::read(arguments, &arguments.input, paint, common, known)?;
        let params = arguments.measuring.params(common.seed);
        let measured = Measured::new(&side.scan, &params).with_context(|| side.name.clone())?;
        let second: Vec<bool> = match &arguments.other_part {
            Some(paint) => painted(&side.scan, paint, &side.name)?,
            None => side.part.iter().map(|of_first| !of_first).collect(),
        };
        let first: Vec<bool> = match &arguments.part {
            Some(_) => side.part,
            None => second.iter().map(|of_second| !of_second).collect(),
        };
        if first.iter().zip(&second).any(|(a, b)| *a && *b) {
            return Err(Failure::usage(format!(
                "{}: --part and --other-part share vertices: a vertex can be of one part only",
                side.name
            )));
        }
        let names = ["the first part".to_owned(), "the other part".to_owned()];
        let view = || {
            let channel = Channel::of_parts([&first, &second], [&names[0], &names[1]]);
            View::of_scan(&side.name, &side.scan, vec![channel])
        };
        Ok(Self {
            views: arguments
                .page
                .is_wanted()
                .then(view)
                .flatten()
                .into_iter()
                .collect(),
            measured,
            parts: [first, second],
            names,
            prepared: side.prepared,
        })
    }

    /// Two scans, or a part of each.
    fn of_two(
        arguments: &Arguments,
        path: &Path,
        common: &Common,
        known: &mut Map<String, Value>,
    ) -> Result<Self, Failure> {
        let (input, mut of_other) = (&arguments.input, Map::new());
        let first = Side::read(arguments, input, arguments.part.as_ref(), common, known)?;
        let paint = arguments.other_part.as_ref();
        let other = Side::read(
            arguments,
            &input.with_path(path),
            paint,
            common,
            &mut of_other,
        )?;
        known.insert("other".into(), Value::from(other.name.clone()));
        if !of_other.is_empty() {
            known.insert("other_input".into(), Value::Object(of_other));
        }
        for (own, others) in [(&first, &other), (&other, &first)] {
            if own.scan.colors().is_some() && others.scan.colors().is_none() {
                log::warn!("{} has no colours: colours are not compared", others.name);
            }
        }
        let params = arguments.measuring.params(common.seed);
        let measured = Measured::new(&first.scan, &params).with_context(|| first.name.clone())?;
        let params = alike(&measured, &params);
        let second = Measured::new(&other.scan, &params).with_context(|| other.name.clone())?;
        let mut views = Vec::new();
        if arguments.page.is_wanted() {
            views.extend([first.view(), other.view()].into_iter().flatten());
        }
        let (count, others) = (measured.vertices(), second.vertices());
        let names = [first.called(arguments.part.as_ref()), other.called(paint)];
        Ok(Self {
            measured: measured.beside(second),
            parts: [
                [first.part, vec![false; others]].concat(),
                [vec![false; count], other.part].concat(),
            ],
            names,
            views,
            prepared: [first.prepared, other.prepared].concat(),
        })
    }
}

/// A scan and the part of it that is compared.
struct Side {
    name: String,
    scan: Scan,
    /// #V.
    part: Vec<bool>,
    /// What was done to it before, in sentences that name it.
    prepared: Vec<String>,
}

impl Side {
    /// The scan's name, and which part of it is meant.
    fn called(&self, part: Option<&Paint>) -> String {
        match part {
            Some(paint) => format!("{} ({})", self.name, arguments::paint_in_words(paint)),
            None => self.name.clone(),
        }
    }

    fn read(
        arguments: &Arguments,
        input: &Input,
        part: Option<&Paint>,
        common: &Common,
        known: &mut Map<String, Value>,
    ) -> Result<Self, Failure> {
        let (surface, told) = arguments.prepare.told_surface(input, common, known)?;
        let scan = surface.scan;
        let name = input.name();
        let prepared = (told.iter())
            .map(|what| format!("{name}: {what}"))
            .collect();
        let part = match part {
            Some(paint) => painted(&scan, paint, &name)?,
            None => vec![true; scan.vertices.rows],
        };
        Ok(Self {
            name,
            scan,
            part,
            prepared,
        })
    }

    /// The scan, its part marked if it is not all of it.
    fn view(&self) -> Option<View> {
        let rest: Vec<bool> = self.part.iter().map(|part| !part).collect();
        let marks = Channel::of_parts([&self.part, &rest], ["compared", "left out"]);
        let channels = Vec::from_iter(rest.contains(&true).then_some(marks));
        View::of_scan(&self.name, &self.scan, channels)
    }
}

fn painted(scan: &Scan, paint: &Paint, name: &str) -> Result<Vec<bool>, Failure> {
    paint.vertices(scan).map_err(|error| Failure {
        usage: true,
        ..anyhow::Error::new(error).context(name.to_owned()).into()
    })
}

/// Heights can be compared over the same kind of base: that of the first scan, unless one is asked for.
fn alike(measured: &Measured, params: &MeasureParams) -> MeasureParams {
    let mut params = params.clone();
    match measured.base() {
        Form::Primitive(surface) => params.fit.base = BaseChoice::Kind(surface.kind()),
        Form::Free(form) => {
            params.fit.base = BaseChoice::FreeForm;
            params.form_wavelength = Some(form.wavelength);
        }
    }
    params
}
