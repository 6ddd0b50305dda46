//! `relievo stats` of a height map.

use std::fmt::Write;

use crate::scan::{Format, HeightMap, read_height_map};
use crate::stats::areal::{
    ArealParameters, FormOperation, MaterialRatioCurve, ParameterUnit, Row, SlopeRule,
    SurfaceParams, scale_limited_surface,
};
use anyhow::Context;
use clap::Args;
use serde_json::{Map, Value, json};

use super::Common;
use super::comparison::{Measuring, csv_of, deliver_csv};
use super::messages::Bar;
use super::outcome::{Failure, Reply};
use super::reading::Input;

/// Options that say nothing of a height map.
const OF_SCANS: [&str; 12] = [
    "columns",
    "intrinsics",
    "color_image",
    "join",
    "gap",
    "keep_outliers",
    "no_repair",
    "base",
    "form_wavelength",
    "pieces",
    "whole",
    "report",
];

/// Options that are about height maps only.
pub(super) const OF_MAPS: [&str; 5] = ["step", "unit", "form", "slopes", "smr"];

#[derive(Debug, Args)]
#[command(next_help_heading = "Height maps")]
pub(super) struct Options {
    /// The input is a height map, text with the first row on top: distance of its columns and of its rows
    /// [default for DY: DX]
    #[arg(long, value_name = "DX[,DY]", value_parser = steps, allow_hyphen_values = true, conflicts_with_all = OF_SCANS)]
    step: Option<[f64; 2]>,
    /// Name of the map's unit of length, for the table
    #[arg(long, value_name = "NAME", requires = "step")]
    unit: Option<String>,
    /// What counts as form and is taken away: none, mean, plane, poly2 or poly3 (least squares)
    #[arg(long, value_name = "FORM", default_value = "plane", value_parser = form, requires = "step")]
    form: FormOperation,
    /// Slopes for Sdq: differences of neighbours, or the standard's stencil over seven heights
    #[arg(long, value_name = "differences|stencil", default_value = "differences", value_parser = slopes, requires = "step")]
    slopes: SlopeRule,
    /// Also tell Smr, the material ratio at this height above the mean
    #[arg(
        long,
        value_name = "HEIGHT",
        requires = "step",
        value_parser = height,
        allow_hyphen_values = true
    )]
    smr: Option<f64>,
}

/// The parameters of a height map; `None` if it is not said that the input is one.
pub(super) fn run(
    options: &Options,
    measuring: &Measuring,
    input: &Input,
    common: &Common,
) -> Option<super::Result> {
    let step = options.step?;
    Some(
        read_height_map(&input.path, step)
            .map_err(Failure::from)
            .and_then(|map| reply(options, measuring, &map, input, common)),
    )
}

/// Of a failure with a file that may be a height map, says how to tell so.
pub(super) fn hinted(mut failure: Failure, input: &Input) -> Failure {
    let is_text = Format::of_path(&input.path).is_ok_and(|format| format == Format::Xyz);
    let is_map = |map: HeightMap| map.columns >= 3 && map.rows >= 3;
    if is_text && !failure.usage && read_height_map(&input.path, [1.0; 2]).is_ok_and(is_map) {
        failure.error = anyhow::anyhow!(
            "{:#}; if it is a height map, tell the distance of its columns and rows by --step DX,DY",
            failure.error
        );
    }
    failure
}

fn reply(
    options: &Options,
    measuring: &Measuring,
    map: &HeightMap,
    input: &Input,
    common: &Common,
) -> super::Result {
    let csv = measuring.csv(&input.files().collect::<Vec<_>>(), common)?;
    let name = input.name();
    let params = SurfaceParams {
        form: options.form,
        s_filter: measuring.s_filter,
        l_filter: measuring.l_filter,
    };
    let finest = 2.0 * map.dx.min(map.dy);
    for (option, cutoff) in [
        ("--s-filter", params.s_filter),
        ("--l-filter", params.l_filter),
    ] {
        if let Some(cutoff) = cutoff.filter(|cutoff| *cutoff < finest) {
            log::warn!(
                "{option} {cutoff}: the map holds no waves below two steps, {finest}; give a longer cut-off"
            );
        }
    }
    let bar = Bar::doing(common, "areal parameters");
    let surface = scale_limited_surface(map, &params).with_context(|| name.clone())?;
    let (Some(areal), Some(curve)) = (
        ArealParameters::of_map(&surface, options.slopes),
        MaterialRatioCurve::of_map(&surface),
    ) else {
        // A surface that was made has heights.
        return Err(Failure::from(anyhow::anyhow!("{name} has no heights")));
    };
    drop(bar);
    let mut members = match json!(areal) {
        Value::Object(members) => members,
        _ => Map::new(),
    };
    let smr = options
        .smr
        .map(|height| (height, 100.0 * curve.ratio_at(height)));
    if let Some((_, ratio)) = smr {
        members.insert("Smr".into(), json!(ratio));
    }
    let json = [
        ("areal", Value::Object(members)),
        ("form", json!(options.form)),
        ("s_filter", json!(params.s_filter)),
        ("l_filter", json!(params.l_filter)),
        ("slopes", json!(options.slopes)),
        ("smr_height", json!(options.smr)),
        ("columns", json!(map.columns)),
        ("rows", json!(map.rows)),
        ("missing", json!(map.missing())),
        ("step", json!([map.dx, map.dy])),
        ("unit", json!(options.unit)),
    ];
    let mut rows: Vec<(&str, &str, Option<f64>)> = (areal.rows().iter())
        .map(|row| (row.name, unit_of(row, options), row.value))
        .collect();
    rows.extend(smr.map(|(_, ratio)| ("Smr", "%", Some(ratio))));
    let to_stdout = deliver_csv(csv, &csv_of(&rows))?;
    Ok(Reply {
        text: if to_stdout {
            String::new()
        } else {
            table(options, &params, map, &areal, smr)
        },
        json: json
            .into_iter()
            .map(|(key, value)| (key.to_owned(), value))
            .collect(),
        ..Reply::default()
    })
}

fn table(
    options: &Options,
    params: &SurfaceParams,
    map: &HeightMap,
    areal: &ArealParameters,
    smr: Option<(f64, f64)>,
) -> String {
    let unit = options.unit.as_deref().unwrap_or_default();
    let filter = |name: &str, cutoff: Option<f64>| {
        cutoff.map_or_else(String::new, |cutoff| {
            format!(", {name}-filter {cutoff} {unit}")
                .trim_end()
                .to_owned()
        })
    };
    let mut text = format!(
        "{} columns by {} rows, {} missing; form taken away: {}{}{}\n\n",
        map.columns,
        map.rows,
        map.missing(),
        name_of(params.form),
        filter("S", params.s_filter),
        filter("L", params.l_filter),
    );
    for row in areal.rows() {
        line(&mut text, &row, unit, row.meaning);
    }
    if let Some((height, ratio)) = smr {
        let row = Row {
            name: "Smr",
            value: Some(ratio),
            unit: ParameterUnit::Percent,
            meaning: "",
        };
        let meaning = format!("material ratio at {height} {unit}");
        line(&mut text, &row, unit, meaning.trim_end());
    }
    text
}

fn line(text: &mut String, row: &Row, unit: &str, meaning: &str) {
    let value = row.value.map_or_else(|| "-".to_owned(), in_digits);
    let unit = match row.unit {
        ParameterUnit::Height | ParameterUnit::Length => unit.to_owned(),
        ParameterUnit::VolumeOverArea if unit.is_empty() => String::new(),
        ParameterUnit::VolumeOverArea => format!("{unit}\u{b3}/{unit}\u{b2}"),
        ParameterUnit::Area => format!("{unit}\u{b2}"),
        ParameterUnit::Percent => "%".to_owned(),
        ParameterUnit::Degrees => "\u{b0}".to_owned(),
        ParameterUnit::One => String::new(),
    };
    let _ = writeln!(text, "{:<5}{value:>14} {unit:<10} {meaning}", row.name);
}

/// The unit's name for a table that other programs read.
fn unit_of<'a>(row: &Row, options: &'a Options) -> &'a str {
    match row.unit {
        ParameterUnit::Height | ParameterUnit::Length | ParameterUnit::VolumeOverArea => {
            options.unit.as_deref().unwrap_or("unit")
        }
        // No parameter of a map is an area.
        ParameterUnit::Area => "unit^2",
        ParameterUnit::Percent => "%",
        ParameterUnit::Degrees => "degrees",
        ParameterUnit::One => "1",
    }
}

/// Six digits, whatever the size.
pub(super) fn in_digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e6).contains(&size) {
        let decimals = [1e5, 1e4, 1e3, 1e2, 1e1, 1.0, 1e-1, 1e-2]
            .iter()
            .filter(|limit| size < **limit)
            .count();
        format!("{value:.decimals$}")
    } else {
        format!("{value:.5e}")
    }
}

fn name_of(form: FormOperation) -> String {
    match json!(form) {
        Value::String(name) => name,
        _ => String::new(),
    }
}

fn steps(text: &str) -> Result<[f64; 2], String> {
    let expected = || "expected one length above 0, or two with a comma between".to_owned();
    let lengths = text.split(',').map(length).collect::<Result<Vec<_>, _>>();
    match lengths.map_err(|_| expected())?.as_slice() {
        [both] => Ok([*both; 2]),
        [dx, dy] => Ok([*dx, *dy]),
        _ => Err(expected()),
    }
}

fn length(text: &str) -> Result<f64, String> {
    let length = text.trim().parse().ok();
    length
        .filter(|length: &f64| *length > 0.0 && length.is_finite())
        .ok_or_else(|| "expected a length above 0".to_owned())
}

fn height(text: &str) -> Result<f64, String> {
    let height = text.trim().parse().ok();
    height
        .filter(|height: &f64| height.is_finite())
        .ok_or_else(|| "expected a height".to_owned())
}

fn form(text: &str) -> Result<FormOperation, String> {
    Ok(match text {
        "none" => FormOperation::None,
        "mean" => FormOperation::Mean,
        "plane" => FormOperation::Plane,
        "poly2" => FormOperation::Poly2,
        "poly3" => FormOperation::Poly3,
        _ => return Err("expected none, mean, plane, poly2 or poly3".into()),
    })
}

fn slopes(text: &str) -> Result<SlopeRule, String> {
    match text {
        "differences" => Ok(SlopeRule::Differences),
        "stencil" => Ok(SlopeRule::Stencil),
        _ => Err("expected differences or stencil".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_options_of_height_maps_are_listed() {
        let command = Options::augment_args(clap::Command::new("map"));
        let ids: Vec<&str> = (command.get_arguments())
            .map(|arg| arg.get_id().as_str())
            .collect();
        assert_eq!(ids, OF_MAPS);
    }

    #[test]
    fn numbers_have_six_digits() {
        let shown = [1.0, -123_456.7, 0.004_847_398, 12.5, 1e7, -3e-5, 0.0].map(in_digits);
        let expected = [
            "1.00000",
            "-123457",
            "0.00484740",
            "12.5000",
            "1.00000e7",
            "-3.00000e-5",
            "0",
        ];
        assert_eq!(shown, expected);
    }

    #[test]
    fn steps_are_one_or_two_lengths() {
        assert_eq!(steps("0.5"), Ok([0.5, 0.5]));
        assert_eq!(steps("0.5, 2"), Ok([0.5, 2.0]));
        for text in ["", "0", "-1", "1,2,3", "1,x", "inf", "nan", "1,"] {
            assert!(steps(text).is_err(), "{text}");
        }
    }

    #[test]
    fn heights_are_finite() {
        assert_eq!(height("-0.5"), Ok(-0.5));
        for text in ["", "nan", "inf", "-inf", "x"] {
            assert!(height(text).is_err(), "{text}");
        }
    }
}
