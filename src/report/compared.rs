//! Two parts in figures: the page of the commands `stats` and `compare`, and a section of that of `complete`.

use super::number::{count, counted, number, signed_percent};
use super::words::form;
use super::{Axis, Block, Column, Marks, Page, Part, Plot, Section, Series, Table, View};
use crate::likeness::{CopyIndex, Summary};
use crate::stats::areal::ParameterUnit;
use crate::stats::{Comparison, Histogram, MeasureParams, Natural, Spectrum, Variogram, Verdict};

/// Two parts and how they differ.
#[derive(Debug, Clone, Copy)]
pub struct Compared<'a> {
    /// What the parts are called at the heads of columns: original and completed, or a and b.
    pub headings: [&'a str; 2],
    /// What they are called in a sentence: the original and the completed part, or the names of their files.
    pub names: [&'a str; 2],
    /// Their figures.
    pub comparison: &'a Comparison,
    /// How much of their differences is natural, if that was looked at.
    pub natural: Option<&'a Natural>,
    /// What that amounts to, if it was looked at.
    pub verdict: Option<&'a Verdict>,
}

/// How parts were measured.
#[derive(Debug, Clone, Copy)]
pub struct Measurement<'a> {
    /// What was done to the scans before; a sentence each, without the end mark.
    pub prepared: &'a [String],
    /// How heights were taken.
    pub params: &'a MeasureParams,
    /// Number of pieces asked for that natural variation is taken from.
    pub pieces: usize,
    /// Seed of their places.
    pub seed: u32,
}

/// The page of a comparison of two parts or scans, with views of them.
#[must_use]
pub fn compared(
    title: &str,
    views: Vec<View>,
    parts: &Compared,
    measurement: &Measurement,
) -> Page {
    let mut sections = Vec::new();
    if !views.is_empty() {
        sections.push(Section {
            heading: if views.len() > 1 {
                "The scans"
            } else {
                "The scan"
            }
            .to_owned(),
            blocks: (View::sharing(views).into_iter())
                .map(Block::View)
                .collect(),
        });
    }
    sections.extend(self::sections(parts));
    sections.push(parameters(parts, measurement));
    let lead = match parts.verdict {
        Some(verdict) => verdict.text.clone(),
        None => format!("{}.", in_words(parts)),
    };
    Page {
        title: title.to_owned(),
        lead,
        sections,
    }
}

/// What the mean integrals say.
fn in_words(parts: &Compared) -> String {
    let [first, second] = parts.names;
    format!(
        "the mean integral of {second} differs by {} from that of {first}",
        signed_percent(parts.comparison.mean_integral_difference_percent)
    )
}

/// The sections with all figures: first those that say most.
pub(super) fn sections(parts: &Compared) -> Vec<Section> {
    let [first, second] = parts.headings;
    let comparison = parts.comparison;
    let mut sections = Vec::new();
    if let Some(natural) = parts.natural {
        let [first, second] = parts.names;
        sections.push(Section {
            heading: "Against natural variation".to_owned(),
            blocks: vec![
                Block::Text(format!(
                    "A score says how many times more {second} differs from {first} than pieces of {first} of the same size differ from the rest of it: up to 1 is natural (95 % of {} such pieces have less).",
                    count(natural.calibration_pieces)
                )),
                Block::Table(scores(natural)),
            ],
        });
    }
    let mut blocks = vec![Block::Table(figures(parts))];
    blocks.push(Block::Plot(heights(parts)));
    let colors = comparison.colors.iter().flatten();
    blocks.extend(colors.map(|color| {
        Block::Plot(Plot {
            caption: format!(
                "Histogram of {} (correlation {})",
                color.channel,
                number(color.correlation)
            ),
            x: Axis::linear(&format!("{}, 0 to 1", color.channel)),
            y: Axis::linear("share of vertices"),
            series: histograms(parts, [&color.original, &color.completed], [0.0, 1.0]),
        })
    }));
    blocks.extend((parts.natural).map(|natural| Block::Plot(variogram(parts, &natural.variogram))));
    blocks.extend(
        comparison
            .spectrum
            .as_ref()
            .map(|s| Block::Plot(spectrum(parts, s))),
    );
    blocks.extend(comparison.copies.as_ref().map(|c| Block::Text(copies(c))));
    sections.push(Section {
        heading: format!("{} against {second}", capitalized(first)),
        blocks,
    });
    sections
}

fn scores(natural: &Natural) -> Table {
    let row = |name: &str, scores: &Summary| {
        vec![
            name.to_owned(),
            number(scores.median),
            number(scores.worst),
            format!("{} of {}", count(scores.outside), count(scores.pieces)),
        ]
    };
    let measures = natural.scores.measures.iter();
    let mut rows: Vec<_> = measures.map(|m| row(m.measure.name(), &m.scores)).collect();
    rows.push(row("all together", &natural.scores.overall));
    Table {
        caption: "Scores of the pieces that were looked at".to_owned(),
        columns: vec![
            Column::words("measure"),
            Column::numbers("median"),
            Column::numbers("worst"),
            Column::numbers("pieces above 1"),
        ],
        rows,
    }
}

/// All parameters of both parts.
fn figures(parts: &Compared) -> Table {
    let value = |value: Option<f64>| number(value.unwrap_or(f64::NAN));
    let mut rows: Vec<Vec<String>> = (parts.comparison.rows(parts.natural).iter())
        .map(|row| {
            vec![
                format!("{} {}", row.name, row.meaning)
                    .trim_end()
                    .to_owned(),
                value(row.original),
                value(row.completed),
                row.change_percent.map_or_else(String::new, signed_percent),
                row.score.map_or_else(String::new, number),
                unit(row.unit).to_owned(),
            ]
        })
        .collect();
    let [first, second] = parts.headings;
    let mut columns = vec![
        Column::words("figure"),
        Column::numbers(first),
        Column::numbers(second),
        Column::numbers("change"),
        Column::numbers("score"),
        Column::words("unit"),
    ];
    if parts.natural.is_none() {
        columns.remove(SCORES);
        for row in &mut rows {
            row.remove(SCORES);
        }
    }
    Table {
        caption: "Figures of the relief over the base surface; those named S\u{2026} and V\u{2026} as in ISO 25178-2, \u{201c}unit\u{201d} is the scan\u{2019}s".to_owned(),
        columns,
        rows,
    }
}

/// The column that is missing where there are no scores.
const SCORES: usize = 4;

fn unit(unit: ParameterUnit) -> &'static str {
    match unit {
        ParameterUnit::Height | ParameterUnit::Length | ParameterUnit::VolumeOverArea => "unit",
        ParameterUnit::Area => "unit\u{b2}",
        ParameterUnit::Percent => "%",
        ParameterUnit::Degrees => "\u{b0}",
        ParameterUnit::One => "",
    }
}

fn heights(parts: &Compared) -> Plot {
    let heights = &parts.comparison.heights;
    let [first, _] = parts.names;
    Plot {
        caption: format!(
            "Histogram of height (correlation {})",
            number(heights.correlation)
        ),
        x: Axis::linear(&format!(
            "height over the mean of {first}, in the scan\u{2019}s unit"
        )),
        y: Axis::linear("share of area"),
        series: histograms(
            parts,
            [&heights.original, &heights.completed],
            [heights.lowest, heights.highest],
        ),
    }
}

/// Both parts' shares at the middles of their common bins.
fn histograms(parts: &Compared, both: [&Histogram; 2], [low, high]: [f64; 2]) -> Vec<Series> {
    let kinds = [Part::Original, Part::Completed];
    let series = |((histogram, name), part): ((&Histogram, &str), Part)| {
        let width = (high - low) / histogram.shares.len() as f64;
        Series {
            name: name.to_owned(),
            part,
            marks: Marks::Bars,
            x: (0..histogram.shares.len())
                .map(|bin| low + (bin as f64 + 0.5) * width)
                .collect(),
            y: histogram.shares.clone(),
        }
    };
    (both.into_iter().zip(parts.headings).zip(kinds))
        .map(series)
        .collect()
}

fn variogram(parts: &Compared, variogram: &Variogram) -> Plot {
    Plot {
        caption: "Variogram: how much heights differ by distance".to_owned(),
        x: Axis::logarithmic("distance, in the scan\u{2019}s unit"),
        y: Axis::logarithmic("half the mean squared difference"),
        series: lines(
            parts,
            &variogram.distances,
            [&variogram.original, &variogram.completed],
        ),
    }
}

fn spectrum(parts: &Compared, spectrum: &Spectrum) -> Plot {
    Plot {
        caption: "Power spectrum: how much relief there is by wavelength".to_owned(),
        x: Axis::logarithmic("wavelength, in the scan\u{2019}s unit"),
        y: Axis::logarithmic("power spectral density"),
        series: lines(
            parts,
            &spectrum.wavelengths,
            [&spectrum.original, &spectrum.completed],
        ),
    }
}

fn lines(parts: &Compared, x: &[f64], both: [&Vec<f64>; 2]) -> Vec<Series> {
    let kinds = [Part::Original, Part::Completed];
    (both.into_iter().zip(parts.headings).zip(kinds))
        .map(|((y, name), part)| Series {
            name: name.to_owned(),
            part,
            marks: Marks::Points,
            x: x.to_vec(),
            y: y.clone(),
        })
        .collect()
}

fn copies(copies: &CopyIndex) -> String {
    let verdict = match (copies.is_paste, copies.is_garbage) {
        (true, _) => "Most of it is one verbatim copy",
        (_, true) => "Much of it is copied from one vertex",
        _ => "It is neither one verbatim copy nor grown from a single vertex",
    };
    format!(
        "Copies: the completed part hangs together in {}, the largest with {} % of its vertices; the source used most was copied {}. {verdict}.",
        counted(
            copies.pieces,
            "piece of surface copied as it was",
            "pieces of surface copied as they were"
        ),
        number(100.0 * copies.largest_piece),
        counted(copies.most_reused, "time", "times"),
    )
}

fn parameters(parts: &Compared, measurement: &Measurement) -> Section {
    let params = measurement.params;
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let mut rows = vec![row("base surface", form(&parts.comparison.base))];
    let lengths = [
        ("form-wavelength", params.form_wavelength),
        ("s-filter", params.s_filter),
        ("l-filter", params.l_filter),
    ];
    rows.extend(
        (lengths.into_iter()).filter_map(|(name, length)| Some(row(name, number(length?)))),
    );
    rows.push(row("pieces", measurement.pieces.to_string()));
    rows.push(row("seed", measurement.seed.to_string()));
    let mut blocks: Vec<Block> = (measurement.prepared.iter())
        .map(|sentence| Block::Text(format!("Before: {sentence}.")))
        .collect();
    blocks.push(Block::Table(Table {
        caption: "How heights were taken and judged; lengths in the scan\u{2019}s unit".to_owned(),
        columns: vec![Column::words("parameter"), Column::words("value")],
        rows,
    }));
    Section {
        heading: "Parameters".to_owned(),
        blocks,
    }
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}
