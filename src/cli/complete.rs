//! `relievo complete`

mod tiled;

pub use tiled::{TiledCall, grow_tile};

use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::base::{BaseChoice, FitParams};
use crate::completion::{
    self, CompleteParams, Completion, CompletionError, CompletionReport, HoleChoice, HoleLimits,
    Method, Paint, SeamReport, TileError, TileParams, TiledCompletion, Tiling,
};
use crate::report::{self, Completed};
use crate::sampling::SpacingRule;
use crate::scan::Scan;
use crate::stats::{self, MeasureParams};
use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

use super::comparison::{Compared, PIECES, of_completed};
use super::held::{ScanOutput, Writing, is_kept};
use super::left_open::left_open;
use super::messages::Bar;
use super::outcome::{Failure, Reply};
use super::reading::{Input, Preparation};
use super::report::PageOption;
use super::{Common, arguments};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
    #[command(flatten)]
    pub(super) prepare: Preparation,
    /// The completed scan: .ply, .obj, .off, .stl or .glb; - for PLY on standard output
    #[arg(short, long, value_name = "OUT")]
    pub(super) output: PathBuf,
    /// What to fill: interior (gaps, not outer rims), all (rims too, where a base surface closes), largest,
    /// or numbers from `relievo holes`, as in 3,7
    #[arg(long, value_name = "WHICH", default_value = "interior", value_parser = arguments::holes)]
    holes: HoleChoice,
    /// Leave holes open with more edges around them than this
    #[arg(long, value_name = "N")]
    max_edges: Option<usize>,
    /// Leave holes open that are longer than this around, in the scan's unit
    #[arg(long, value_name = "LENGTH", value_parser = arguments::length)]
    max_length: Option<f64>,
    /// Leave holes open that are larger than this, in square units of the scan
    #[arg(long, value_name = "AREA", value_parser = arguments::area)]
    max_area: Option<f64>,
    /// Only holes with a painted vertex at their rim: vertices with the property NAME other than 0, or equal
    /// to VALUE, or of the colour RRGGBB (two hexadecimal digits each)
    #[arg(long, value_name = "NAME|NAME=VALUE|#RRGGBB", value_parser = arguments::paint)]
    mask: Option<Paint>,
    /// Continue over the rest of the base surface: of the sphere, of the cylinder's or cone's wall
    /// between the scan's ends, of the plane's bounding rectangle
    #[arg(long)]
    extend: bool,
    #[command(flatten)]
    pub(super) how: How,
    /// Complete in tiles of at most so many vertices, one after the other, for a scan that is too large for the
    /// memory in one piece; each tile copies from its own surroundings
    #[arg(long, value_name = "N")]
    tile: Option<usize>,
    /// How far around its new vertices a tile sees everything, in the scan's unit [default: twice as far as a
    /// window]
    #[arg(
        long,
        value_name = "LENGTH",
        requires = "tile",
        allow_negative_numbers = true
    )]
    overlap: Option<f64>,
    #[command(flatten)]
    page: PageOption,
    #[command(flatten)]
    pub(super) writing: Writing,
}

/// How to complete, whatever is to be filled: the options that `evaluate` has as well.
#[derive(Debug, Args)]
pub(super) struct How {
    /// Base surface under the relief: auto, plane, sphere, cylinder, cone or freeform (what auto takes
    /// for holes where none of the others fits)
    #[arg(long, value_name = "KIND", default_value = "auto", value_parser = arguments::form)]
    base: BaseChoice,
    /// Freeform base: what is longer than this is form, what is shorter relief, in the scan's unit
    /// [default: where heights depend on it least]
    #[arg(long, value_name = "LENGTH", value_parser = arguments::length)]
    form_wavelength: Option<f64>,
    /// How to find matches
    #[arg(long, value_enum, default_value_t = MethodName::Coherent)]
    method: MethodName,
    /// Fit copied patches to each other and to the scan where they meet in steps [default: on relief that
    /// hardly changes from vertex to vertex] (not by the paper's method)
    #[arg(
        long,
        value_name = "yes|no",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "yes",
        value_parser = arguments::yes_or_no
    )]
    blend: Option<bool>,
    /// Coherent method: a place that continues a neighbor's source is taken unless another costs less
    /// than 1/(1 + KAPPA) of it, and at once where it fits better than good matches do
    #[arg(
        long,
        value_name = "KAPPA",
        default_value_t = 0.3,
        allow_negative_numbers = true
    )]
    coherence: f64,
    /// Coherent method: number of places, evenly spread over the scan, that are looked at for every new
    /// vertex
    #[arg(long, value_name = "N", default_value_t = 8192)]
    sites: usize,
    /// Coherent method: share of the new vertices that are also searched for exhaustively, so that the
    /// JSON can say how good the matches are; changes nothing else
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    audit: f64,
    /// Most memory that tables of neighborhoods may take, as in 500M or 2GiB; beyond it they hold fewer
    /// places
    #[arg(long, value_name = "SIZE", default_value = "2GiB", value_parser = arguments::memory)]
    memory: usize,
    /// Radius of a neighborhood, in edges; the coherent and the exhaustive method see half as densely from
    /// 4/5 of it to 8/5 [default: by the relief's correlation length; paper: 5]
    #[arg(long, value_name = "W")]
    window: Option<usize>,
    /// Number of rotations in which a neighborhood is tried [default: by the relief's directions;
    /// paper: 4]
    #[arg(long, value_name = "R")]
    rotations: Option<u32>,
    /// Pick at random among matches that cost up to this share more than the best: 0.1 is 10 %
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.1,
        allow_negative_numbers = true
    )]
    tolerance: f64,
    /// Largest normalised cost (0 to 1) of a match that is accepted at first; rises by 10 % when
    /// nothing is [default: by the relief's spread; paper: 0.3]
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    error_threshold: Option<f64>,
    /// μ in (1 − μ)·shape + μ·colour: 0 matches by shape alone, 1 by colour alone [default: by how
    /// height and colour vary; paper: 0.5; 0 without colours]
    #[arg(long, value_name = "MU", allow_negative_numbers = true)]
    shape_weight: Option<f64>,
    /// Distance of new vertices: nyquist (the scan's short edges), scan (its median edge), or a
    /// length in the scan's unit [default: nyquist]
    #[arg(long, value_name = "RULE", value_parser = arguments::spacing)]
    spacing: Option<SpacingRule>,
    /// Do not copy from pieces of surface with fewer vertices than this share of the largest piece's
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.01,
        allow_negative_numbers = true
    )]
    stray: f64,
    /// Let completed vertices become samples
    #[arg(long)]
    bootstrap: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum MethodName {
    /// What continues the source of a new vertex's neighbors, or the best of many places if that is
    /// clearly better: fast, and keeps patches of the scan together
    Coherent,
    /// Every place at every rotation, by differences of height and colour
    Exhaustive,
    /// Breckon & Fisher 2005, step by step: every place at every rotation, by distances in space
    Paper,
}

impl Arguments {
    pub(super) fn params(&self, seed: u32) -> CompleteParams {
        CompleteParams {
            holes: self.holes.clone(),
            limits: HoleLimits {
                max_edges: self.max_edges,
                max_length: self.max_length,
                max_area: self.max_area,
            },
            paint: self.mask.clone(),
            extend: self.extend,
            ..self.how.params(seed)
        }
    }

    /// How to divide the scan, if at all.
    fn tiles(&self) -> Option<TileParams> {
        self.tile.map(|tile| TileParams {
            tile,
            overlap: self.overlap,
        })
    }

    /// What the JSON says before anything is known of the scan.
    fn asked_for(&self, params: &CompleteParams) -> Map<String, Value> {
        let mut known = Map::new();
        if !is_kept(&self.output) {
            known.insert("output".into(), json!(self.output.to_string_lossy()));
        }
        known.insert("method".into(), json!(params.method));
        known.insert("seed".into(), json!(params.seed));
        known.insert("parameters".into(), json!(params));
        known
    }

    /// Whether all numbers are in their ranges.
    fn check(&self, params: &CompleteParams) -> Result<(), Failure> {
        let tiles = self.tiles().map_or(Ok(()), |tiles| tiles.check());
        params.check().and(tiles).map_err(|error| Failure {
            usage: true,
            ..error.into()
        })
    }
}

impl How {
    pub(super) fn params(&self, seed: u32) -> CompleteParams {
        CompleteParams {
            fit: FitParams {
                base: self.base,
                seed,
                ..FitParams::default()
            },
            form_wavelength: self.form_wavelength,
            stray: self.stray,
            window: self.window,
            rotations: self.rotations,
            tolerance: self.tolerance,
            error_threshold: self.error_threshold,
            mu: self.shape_weight,
            spacing: self.spacing,
            bootstrap: self.bootstrap,
            method: match self.method {
                MethodName::Coherent => Method::Coherent,
                MethodName::Exhaustive => Method::Exhaustive,
                MethodName::Paper => Method::Paper,
            },
            blend: self.blend,
            coherence: self.coherence,
            sites: self.sites,
            audit: self.audit,
            memory: self.memory,
            seed,
            ..CompleteParams::default()
        }
    }
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let params = arguments.params(common.seed);
    let mut known = arguments.asked_for(&params);
    work(arguments, common, &params, &mut known).map_err(|failure| Failure {
        json: known,
        ..failure
    })
}

fn work(
    arguments: &Arguments,
    common: &Common,
    params: &CompleteParams,
    known: &mut Map<String, Value>,
) -> super::Result {
    arguments.check(params)?;
    if !is_kept(&arguments.output) {
        arguments::output_format(&arguments.output)?;
    }
    let inputs: Vec<&Path> = arguments.input.files().collect();
    let page = arguments
        .page
        .open(&inputs, &[("-o", Some(&arguments.output))], common)?;
    let output = ScanOutput::open(&arguments.output, &arguments.input.path, &arguments.writing)?;
    let (surface, prepared) = (arguments.prepare).told_surface(&arguments.input, common, known)?;
    let mut bar = Bar::new(common);
    let completed = match arguments.tiles() {
        None => completion::complete(&surface.scan, params, &mut |progress| bar.show(progress))
            .map(Done::from),
        Some(tiles) => completion::complete_tiled(&surface.scan, params, &tiles, &mut |progress| {
            bar.show(progress);
        })
        .map(Done::from),
    };
    drop(bar);
    let done = completed.map_err(|error| failed(error, arguments))?;
    done.describe(arguments, known)?;
    let report = &done.report;
    let finished = surface.restore(done.scan);
    let bar = Bar::doing(common, "writing");
    let finished = output.write(finished)?;
    drop(bar);
    // After the scan is safe: they take time and memory of their own.
    let judged = page.as_ref().and_then(|_| judged(&finished, common));
    match &judged {
        Some(judged) => {
            known.insert("statistics".into(), json!(judged.comparison));
            known.insert("natural".into(), json!(judged.natural.as_ref().ok()));
            known.insert("verdict".into(), json!(judged.verdict));
        }
        None => known.extend(statistics(report, &finished)),
    }
    if let Some(page) = page {
        page.write(&report::completed(&Completed {
            input: &arguments.input.name(),
            prepared: &prepared,
            params,
            scan: &finished,
            report,
            compared: judged.as_ref().map(Compared::parts),
        }))?;
    }
    tell(report, common);
    Ok(Reply {
        partly: !report.skipped.is_empty(),
        json: std::mem::take(known),
        text: String::new(),
    })
}

/// What came of it, in one piece or in tiles.
struct Done {
    scan: Scan,
    report: CompletionReport,
    tiles: Option<(Tiling, SeamReport)>,
}

impl From<Completion> for Done {
    fn from(done: Completion) -> Self {
        Self {
            scan: done.scan,
            report: done.report,
            tiles: None,
        }
    }
}

impl From<TiledCompletion> for Done {
    fn from(done: TiledCompletion) -> Self {
        Self {
            scan: done.scan,
            report: done.report,
            tiles: Some((done.tiling, done.seams)),
        }
    }
}

impl Done {
    /// Tells what was done; a failure if that is nothing.
    fn describe(
        &self,
        arguments: &Arguments,
        known: &mut Map<String, Value>,
    ) -> Result<(), Failure> {
        if let Value::Object(members) = json!(self.report) {
            known.extend(members);
        }
        if let Some((tiling, seams)) = &self.tiles {
            known.insert("tiling".into(), json!(tiling));
            known.insert("seams".into(), json!(seams));
        }
        if self.report.filled.is_empty() {
            let message = format!(
                "{}: no hole could be filled; {}",
                arguments.input.name(),
                left_open(&self.report, "").join("; ")
            );
            return Err(anyhow::Error::msg(message).into());
        }
        Ok(())
    }
}

/// The completed part in figures, as a member of the JSON. On free form they would take another solve as long as all the
/// rest: `relievo stats` has them.
fn statistics(report: &CompletionReport, finished: &Scan) -> Option<(String, Value)> {
    if !report.base_fits {
        return None;
    }
    // A fill without new vertices has nothing to compare.
    let figures = stats::compare(finished)
        .inspect_err(|error| log::info!("no statistics: {error}"))
        .ok()?;
    Some(("statistics".into(), json!(figures)))
}

/// The same with scores, for the page.
fn judged(finished: &Scan, common: &Common) -> Option<Compared> {
    of_completed(finished, &MeasureParams::default(), PIECES, common)
        .inspect_err(|error| log::info!("no statistics: {error}"))
        .ok()
}

fn failed(error: CompletionError, arguments: &Arguments) -> Failure {
    let usage = matches!(
        error,
        CompletionError::NoSuchLoop { .. }
            | CompletionError::NoSuchChannel { .. }
            | CompletionError::NoColors
            | CompletionError::NothingPainted
            | CompletionError::Tile(
                TileError::ByPaper | TileError::Bootstrap | TileError::TooSmall { .. }
            )
    );
    let file = arguments.input.name();
    Failure {
        usage,
        ..anyhow::Error::new(error).context(file).into()
    }
}

/// A summary for people, on standard error: standard output may carry the scan.
fn tell(report: &CompletionReport, common: &Common) {
    if common.quiet {
        return;
    }
    let counts = &report.counts;
    let mut text = format!(
        "relievo: {}; {} of {} chosen gap(s) filled with {} vertices and {} faces",
        base_in_words(report),
        report.filled.len(),
        report.filled.len() + report.skipped.len(),
        counts.completed_vertices,
        counts.completed_faces,
    );
    if report.searched.thinned_by_memory {
        let _ = write!(
            text,
            "; the memory held {} of {} places to copy from",
            report.searched.sites, report.searched.sites_offered
        );
    }
    if report.counts.rims_left > 0 {
        let _ = write!(
            text,
            "; {} outer rim(s) left alone",
            report.counts.rims_left
        );
    }
    if report.counts.holes_left > 0 {
        let _ = write!(
            text,
            "; {} hole(s) left open that were not chosen",
            report.counts.holes_left
        );
    }
    for words in left_open(report, " left open") {
        let _ = write!(text, "\nrelievo: {words}");
    }
    text.push('\n');
    // Nowhere is left to report that standard error is closed.
    let _ = std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes());
}

fn base_in_words(report: &CompletionReport) -> String {
    match &report.free_form {
        Some(form) if report.base_fits => format!(
            "{} base, relief {:.4} (RMS); off it free form (wavelength {:.4})",
            report.fit.base.kind(),
            report.fit.inlier_rms,
            form.wavelength
        ),
        Some(form) => format!(
            "free-form base (wavelength {:.4}), relief {:.4} (RMS)",
            form.wavelength, form.rms
        ),
        None if report.base_fits => format!(
            "{} base, relief {:.4} (RMS)",
            report.fit.base.kind(),
            report.fit.inlier_rms
        ),
        None => "no single base surface fits".to_owned(),
    }
}
