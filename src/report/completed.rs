//! The page of the command `complete`.

use super::number::{count, counted, number};
use super::words::{form, loops};
use super::{
    Axis, Block, Column, Compared, Marks, Page, Part, Plot, Section, Series, Table, View, compared,
    settings,
};
use crate::base::Form;
use crate::completion::{CompleteParams, CompletionReport, FreeFormReport};
use crate::scan::Scan;

/// What the command `complete` was given, and what came out.
#[derive(Debug, Clone, Copy)]
pub struct Completed<'a> {
    /// The scan's file, as the user knows it.
    pub input: &'a str,
    /// What was done to the scan before: points joined, faces repaired; a sentence each, without the end mark.
    pub prepared: &'a [String],
    /// What was asked for.
    pub params: &'a CompleteParams,
    /// The completed scan.
    pub scan: &'a Scan,
    /// What was done.
    pub report: &'a CompletionReport,
    /// The completed part in figures, if they were taken.
    pub compared: Option<Compared<'a>>,
}

/// The page of a completion.
///
/// It tells no times: the same scan and parameters give the same bytes.
#[must_use]
pub fn completed(done: &Completed) -> Page {
    let mut sections = Vec::new();
    let caption = format!("{}, before and after completion", done.input);
    if let Some(view) = View::of_scan(&caption, done.scan, Vec::new()) {
        sections.push(Section {
            heading: "The scan".to_owned(),
            blocks: vec![Block::View(view)],
        });
    }
    sections.extend(done.compared.iter().flat_map(compared::sections));
    sections.push(work(done));
    sections.push(base(done.report));
    sections.push(settings::section(done.params, done.report));
    Page {
        title: format!("{}, completed", done.input),
        lead: lead(done),
        sections,
    }
}

/// What came out, and what that amounts to.
fn lead(done: &Completed) -> String {
    let report = done.report;
    let (filled, all) = (
        report.filled.len(),
        report.filled.len() + report.skipped.len(),
    );
    let gaps = if filled == all {
        match all {
            1 => "The gap is filled".to_owned(),
            _ => format!("All {} gaps are filled", count(all)),
        }
    } else {
        format!(
            "{} of {} are filled",
            count(filled),
            counted(all, "gap", "gaps")
        )
    };
    let counts = &report.counts;
    let added = format!(
        "{gaps}: {} and {} were added to the {} and {} of the scan",
        counted(counts.completed_vertices, "vertex", "vertices"),
        counted(counts.completed_faces, "face", "faces"),
        counted(counts.original_vertices, "vertex", "vertices"),
        counted(counts.original_faces, "face", "faces"),
    );
    match done.compared.and_then(|compared| compared.verdict) {
        Some(verdict) => format!("{added}. {}", verdict.text),
        None => format!("{added}."),
    }
}

/// What was repaired, filled and left open.
fn work(done: &Completed) -> Section {
    let report = done.report;
    let mut blocks = Vec::new();
    for sentence in done.prepared {
        blocks.push(Block::Text(format!("Before: {sentence}.")));
    }
    if report.counts.stray_vertices > 0 {
        blocks.push(Block::Text(format!(
            "{} on stray pieces of surface were kept, but neither fitted to nor copied from.",
            counted(report.counts.stray_vertices, "vertex", "vertices")
        )));
    }
    blocks.push(Block::Table(filled(report)));
    if !report.skipped.is_empty() {
        blocks.push(Block::Table(left_open(report)));
    }
    let left = [
        (report.counts.holes_left, "hole", "holes"),
        (report.counts.rims_left, "outer rim", "outer rims"),
    ];
    for (left, one, many) in left.into_iter().filter(|(left, ..)| *left > 0) {
        let was = if left == 1 { "was" } else { "were" };
        blocks.push(Block::Text(format!(
            "{} {was} not chosen to be filled and stayed open.",
            counted(left, one, many)
        )));
    }
    blocks.extend(matches(report));
    Section {
        heading: "What was filled".to_owned(),
        blocks,
    }
}

fn filled(report: &CompletionReport) -> Table {
    let row = |hole: &crate::completion::FilledHole| {
        vec![
            loops(&hole.loops),
            count(hole.vertices),
            count(hole.faces),
            number(hole.mean_cost),
            number(hole.worst_cost),
            hole.own_base
                .as_ref()
                .map_or("the scan\u{2019}s base".to_owned(), form),
        ]
    };
    Table {
        caption: "Gaps that are filled; costs of matches from 0 (fits exactly) to 1".to_owned(),
        columns: vec![
            Column::words("loops around it"),
            Column::numbers("new vertices"),
            Column::numbers("new faces"),
            Column::numbers("mean cost"),
            Column::numbers("worst cost"),
            Column::words("filled on"),
        ],
        rows: report.filled.iter().map(row).collect(),
    }
}

fn left_open(report: &CompletionReport) -> Table {
    let row = |hole: &crate::completion::SkippedHole| vec![loops(&hole.loops), hole.reason.clone()];
    Table {
        caption: "Gaps that were chosen but stayed open".to_owned(),
        columns: vec![Column::words("loops around it"), Column::words("reason")],
        rows: report.skipped.iter().map(row).collect(),
    }
}

/// Where the matches came from; nothing by the paper's method, which has one way only.
fn matches(report: &CompletionReport) -> Option<Block> {
    let searched = &report.searched;
    let copied = searched.continued + searched.similar + searched.global;
    if copied == 0 {
        return None;
    }
    let mut text = format!(
        "{} continue what a neighbor was copied from, {} come from a place like one that does, {} from the best of {} places all over the scan.",
        counted(searched.continued, "new vertex", "new vertices"),
        count(searched.similar),
        count(searched.global),
        count(searched.sites)
    );
    if searched.thinned_by_memory {
        text.push_str(&format!(
            " The memory allowed held {} of {} places to copy from.",
            count(searched.sites),
            count(searched.sites_offered)
        ));
    }
    if let Some(recall) = &searched.recall {
        text.push_str(&format!(
            " Of {} searched for exhaustively as well, {} % were matched at most 1.1 times as dearly as by the best place there is.",
            counted(recall.audited, "new vertex", "new vertices"),
            number(100.0 * recall.all)
        ));
    }
    Some(Block::Text(text))
}

/// The base surface and the relief over it.
fn base(report: &CompletionReport) -> Section {
    let fit = &report.fit;
    let mut blocks = Vec::new();
    if report.base_fits {
        blocks.push(Block::Text(format!(
            "The base surface under the relief is {}; the relief over it is {} high (root mean square), {} % of the scan\u{2019}s diagonal.",
            form(&Form::Primitive(fit.base)),
            number(fit.inlier_rms),
            number(100.0 * fit.relief_share())
        )));
    } else {
        blocks.push(Block::Text(
            "Heights are not over a plane, sphere, cylinder or cone: none was asked for, or none fits all of the scan.".to_owned(),
        ));
    }
    blocks.push(Block::Table(ranking(report)));
    if let Some(free) = &report.free_form {
        blocks.push(Block::Text(free_form(free)));
        blocks.extend(free.choice.as_ref().map(|choice| {
            let tried = choice.tried.iter();
            Block::Plot(wavelengths(
                tried.map(|t| (t.wavelength, t.height)).unzip(),
                free.wavelength,
            ))
        }));
    }
    Section {
        heading: "Base surface".to_owned(),
        blocks,
    }
}

fn ranking(report: &CompletionReport) -> Table {
    let row = |candidate: &crate::base::Candidate| {
        vec![
            candidate.kind().to_string(),
            number(candidate.rms),
            number(candidate.criterion),
            match candidate.degenerate {
                Some(_) => "left out: a simpler kind says the same".to_owned(),
                None => String::new(),
            },
        ]
    };
    Table {
        caption: "Kinds of base surface that were fitted, the best first".to_owned(),
        columns: vec![
            Column::words("kind"),
            Column::numbers("RMS height"),
            Column::numbers("criterion (lower is better)"),
            Column::words("note"),
        ],
        rows: report.fit.ranking.iter().map(row).collect(),
    }
}

fn free_form(free: &FreeFormReport) -> String {
    let reason = match &free.choice {
        Some(choice) => format!("chosen since {}", choice.reason),
        None => "given".to_owned(),
    };
    format!(
        "Gaps off the base surface are filled on free form: what is longer than {} is form, what is shorter is relief ({reason}). The relief over it is {} high (root mean square).",
        number(free.wavelength),
        number(free.rms)
    )
}

/// What the wavelength was chosen from.
fn wavelengths((x, y): (Vec<f64>, Vec<f64>), chosen: f64) -> Plot {
    let highest = y.iter().copied().fold(0.0, f64::max);
    Plot {
        caption: "Median height by wavelength between form and relief".to_owned(),
        x: Axis::logarithmic("wavelength, in the scan\u{2019}s unit"),
        y: Axis::linear("median height"),
        series: vec![
            Series {
                name: "tried".to_owned(),
                part: Part::Original,
                marks: Marks::Points,
                x,
                y,
            },
            Series {
                name: "chosen".to_owned(),
                part: Part::Neither,
                marks: Marks::Dashes,
                x: vec![chosen, chosen],
                y: vec![0.0, highest],
            },
        ],
    }
}
