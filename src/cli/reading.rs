//! How every subcommand reads its scan: formats that need options, repair, points to surface.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::cloud::{self, CloudParams, CloudReport, JoinChoice, Joined, OutlierParams};
use crate::repair::{self, RepairParams, RepairReport, Repaired};
use crate::scan::{self, ColorMap, Format, Image, Intrinsics, ReadOptions, Scan};
use anyhow::Context;
use clap::Args;
use serde_json::{Map, Value, json};

use super::held::{Content, Shelf};
use super::messages::Bar;
use super::outcome::Failure;
use super::{Common, arguments};

/// The input and how to read it.
#[derive(Debug, Clone, Args)]
pub(super) struct Input {
    /// The scan: PLY, OBJ, STL, OFF, GLB, glTF, XYZ, PTS, TXT, CSV, PTX, PCD, E57, LAS, LAZ, or a depth image
    /// (PNG, TIFF); - for standard input
    #[arg(id = "scan", value_name = "SCAN")]
    pub(super) path: PathBuf,
    #[command(flatten)]
    pub(super) reading: Reading,
}

/// What files do not tell of themselves.
#[derive(Debug, Clone, Args)]
pub(super) struct Reading {
    /// Text files without a line of names: what their columns are, with commas between, as in
    /// x,y,z,intensity,red,green,blue; - skips one [default: guessed]
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        help_heading = "Reading"
    )]
    columns: Option<Vec<String>>,
    /// Depth images: the camera's focal lengths and principal point in pixels
    #[arg(
        long,
        value_name = "FX,FY,CX,CY",
        value_parser = arguments::intrinsics,
        allow_hyphen_values = true,
        help_heading = "Reading"
    )]
    intrinsics: Option<Intrinsics>,
    /// Depth images: a colour image of the same size
    #[arg(long, value_name = "FILE", help_heading = "Reading")]
    color_image: Option<PathBuf>,
    /// What is in memory instead of in files.
    #[arg(skip)]
    pub(super) shelf: Shelf,
}

impl Reading {
    pub(super) fn options(&self) -> ReadOptions {
        ReadOptions {
            columns: self.columns.clone(),
            intrinsics: self.intrinsics,
            color_image: self.color_image.clone(),
        }
    }

    /// The image of colours beside a depth image.
    pub(super) fn color_image(&self) -> Option<&Path> {
        self.color_image.as_deref()
    }

    /// The files behind a path: itself, or those that what is in memory comes from.
    pub(super) fn files<'a>(&'a self, path: &'a Path) -> impl Iterator<Item = &'a Path> {
        let held = self.shelf.get(path);
        let itself = held.is_none().then_some(path);
        let behind = held.into_iter().flat_map(|held| &held.files);
        itself.into_iter().chain(behind.map(PathBuf::as_path))
    }

    /// A file that is read like this.
    pub(super) fn of(&self, path: &Path) -> Input {
        Input {
            path: path.to_owned(),
            reading: self.clone(),
        }
    }
}

impl Input {
    /// The scan as it is in the file.
    pub(super) fn scan(&self) -> Result<Scan, Failure> {
        match self.reading.shelf.get(&self.path) {
            Some(held) => held.scan(),
            None => Ok(scan::read(&self.path, &self.reading.options())?),
        }
    }

    /// The image that it is.
    pub(super) fn image(&self) -> Result<Arc<Image>, Failure> {
        match self.reading.shelf.get(&self.path) {
            Some(held) => held.image(),
            None => Ok(Arc::new(scan::read_image(&self.path)?)),
        }
    }

    /// Whether it is an image; of a file its name tells.
    pub(super) fn is_image(&self) -> bool {
        match self.reading.shelf.get(&self.path) {
            Some(held) => matches!(held.content, Content::Image(_)),
            None if self.path == Path::new("-") => true,
            None => !matches!(Format::of_path(&self.path), Ok(format) if format != Format::Depth),
        }
    }

    /// The colors between its vertices, if the file has a texture image.
    pub(super) fn color_map(&self) -> Result<Option<ColorMap>, Failure> {
        match self.reading.shelf.get(&self.path) {
            Some(held) => held.color_map(),
            None => Ok(scan::read_color_map(&self.path, &self.reading.options())?),
        }
    }

    /// All files that are read: the scan first.
    pub(super) fn files(&self) -> impl Iterator<Item = &Path> {
        (self.reading.files(&self.path)).chain(self.reading.color_image())
    }

    /// Another file, read in the same way.
    pub(super) fn with_path(&self, path: &Path) -> Self {
        self.reading.of(path)
    }

    /// The file's name in messages.
    pub(super) fn name(&self) -> String {
        if let Some(held) = self.reading.shelf.get(&self.path) {
            held.name.clone()
        } else if self.path == Path::new("-") {
            "standard input".to_owned()
        } else {
            self.path.display().to_string()
        }
    }
}

/// What is done to a scan before it is worked on.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Points and repair")]
pub(super) struct Preparation {
    /// Points without faces: how to join them, in the chart of the base surface that fits, or each with
    /// those around it [default: in the chart if one fits]
    #[arg(long, value_name = "auto|chart|local", default_value = "auto", value_parser = arguments::join)]
    join: JoinChoice,
    /// Points without faces: gaps wider than this many times the points' own distance stay open
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 4.0,
        allow_negative_numbers = true
    )]
    gap: f64,
    /// Points without faces: join stray points, too
    #[arg(long)]
    keep_outliers: bool,
    /// Leave the scan's faces as they are, or leave out some steps of their repair: degenerate, duplicates,
    /// weld, manifold, orient, spikes, with commas between
    #[arg(
        long,
        value_name = "STEPS",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "all",
        value_parser = arguments::no_repair
    )]
    no_repair: Option<RepairParams>,
}

impl Preparation {
    pub(super) fn cloud_params(&self, seed: u32) -> CloudParams {
        let outliers = (!self.keep_outliers).then(OutlierParams::default);
        CloudParams {
            join: self.join,
            gap: self.gap,
            outliers,
            seed,
            ..CloudParams::default()
        }
    }

    /// Reads and prepares a scan; what was done is said, and goes into the JSON.
    pub(super) fn surface(
        &self,
        input: &Input,
        common: &Common,
        known: &mut Map<String, Value>,
    ) -> Result<Repaired, Failure> {
        Ok(self.told_surface(input, common, known)?.0)
    }

    /// The same, with what was done in sentences.
    pub(super) fn told_surface(
        &self,
        input: &Input,
        common: &Common,
        known: &mut Map<String, Value>,
    ) -> Result<(Repaired, Vec<String>), Failure> {
        let mut told = Vec::new();
        let params = self.cloud_params(common.seed);
        params.check().map_err(|error| Failure {
            usage: true,
            ..error.into()
        })?;
        let bar = Bar::doing(common, "reading");
        let mut scan = input.scan()?;
        drop(bar);
        if scan.faces.is_empty() {
            let bar = Bar::doing(common, "joining points");
            let joined = cloud::triangulate(&scan, &params).with_context(|| input.name())?;
            drop(bar);
            let what = of_points(&joined.report);
            log::warn!("{}: {what}", input.name());
            told.push(what);
            known.insert("cloud".into(), json!(joined.report));
            scan = joined.scan;
        }
        let steps = self.no_repair.unwrap_or_default();
        let bar = Bar::doing(common, "repair");
        let repaired = repair::repair(scan, &steps);
        drop(bar);
        known.insert("repair".into(), json!(repaired.report));
        for (what, step) in in_words(&repaired.report) {
            let otherwise = step.map_or(String::new(), |s| format!(" (not with --no-repair={s})"));
            log::warn!("{}: {what}{otherwise}", input.name());
            told.push(what);
        }
        Ok((repaired, told))
    }
}

/// What was made of points.
fn of_points(report: &CloudReport) -> String {
    let how = match report.joined {
        Joined::Chart(kind) => format!("over a {kind}"),
        Joined::Local => "locally".to_owned(),
    };
    let mut text = format!(
        "{} points at a distance of {:.6} (median) joined {how} to {} triangles",
        report.points, report.spacing, report.triangles
    );
    for (count, what) in [
        (report.outliers, "stray"),
        (report.duplicates, "at the place of another"),
        (report.left_over, "without neighbors that agree"),
    ] {
        if count > 0 {
            text.push_str(&format!("; {count} left out, {what}"));
        }
    }
    text
}

/// What was repaired, and the step's name if there is one to switch off.
pub(super) fn in_words(report: &RepairReport) -> Vec<(String, Option<&'static str>)> {
    let steps = [
        (
            report.degenerate_faces,
            "face(s) with fewer than three different vertices left out",
            "degenerate",
        ),
        (
            report.duplicate_faces,
            "face(s) left out that are there twice",
            "duplicates",
        ),
        (
            report.welded_vertices,
            "vertices taken for the others at their places, so that seams are no holes",
            "weld",
        ),
        (
            report.non_manifold_faces,
            "face(s) left out where more than two meet in an edge",
            "manifold",
        ),
        (
            report.flipped_faces,
            "face(s) turned that were oriented against their surroundings",
            "orient",
        ),
        (
            report.spike_faces,
            "face(s) left out that stick out of the rim",
            "spikes",
        ),
    ];
    let done = steps.into_iter().filter(|(count, ..)| *count > 0);
    let mut lines: Vec<_> = done
        .map(|(count, what, step)| (format!("{count} {what}"), Some(step)))
        .collect();
    if report.unorientable_edges > 0 {
        let what = format!(
            "the surface is one-sided: at {} edge(s) its faces cannot agree on a side",
            report.unorientable_edges
        );
        lines.push((what, None));
    }
    lines
}
