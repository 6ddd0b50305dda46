//! Synthesized textures against their samples.
//!
//!     cargo bench --bench texture -- times [IMAGE]
//!     cargo bench --bench texture -- prepare [IMAGE…]
//!     cargo bench --bench texture -- flat [SEED]
//!     cargo bench --bench texture -- seams
//!     cargo bench --bench texture -- judge FOLDER…
//!
//! `times` tells how long the paper's sphere takes. `prepare` writes the samples that all programs get into target/texture-synthesis/samples (default: the images in
//! ../shared/data/textures). `flat` puts each on a flat square, into target/texture-synthesis/{coherent,wei-levoy,retiled}.
//! `seams` tells whether colors change more across the input's own seam than elsewhere. `judge` prints a Markdown table: for each of these samples, how far its own halves are
//! from each other, and how far NAME.png in each folder is from it. Where there is sources/NAME.png in a
//! folder, made from places/NAME.png as NAME.png was from the sample, it says how much is copied in pieces.
//! `scripts/synthesize_2d.sh` makes such a folder by another program.
#![expect(clippy::print_stdout, reason = "the table is what this is for")]

mod texture_images;
mod texture_measures;
mod texture_runs;

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use texture_images::{images, prepare, read, read_sources};
use texture_measures::{
    Copies, Grid, between_halves, coarse_sliced_wasserstein, copies, gradient_distance,
    least_histogram_correlation, sliced_wasserstein, spectrum_distance,
};

/// Where everything is put.
const FOLDER: &str = "target/texture-synthesis";
/// Where the images are from.
const IMAGES: &str = "../shared/data/textures";

fn main() -> Result<()> {
    // Cargo adds `--bench`.
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| word != "--bench")
        .collect();
    let paths = || words.iter().skip(1).map(PathBuf::from).collect();
    match words.first().map(String::as_str) {
        Some("prepare") => prepare_all(paths()),
        Some("times") => texture_runs::times(words.get(1).map(Path::new)),
        Some("flat") => flat_all(words.get(1).map_or(Ok(0), |seed| seed.parse())?),
        Some("seams") => seams(),
        Some("judge") if words.len() > 1 => judge_all(&paths()),
        None => {
            println!(
                "nothing to do: say `-- times [IMAGE]`, `-- prepare [IMAGE…]`, `-- flat [SEED]`, `-- seams` or `-- judge FOLDER…`"
            );
            Ok(())
        }
        _ => bail!(
            "say `times [IMAGE]`, `prepare [IMAGE…]`, `flat [SEED]`, `seams` or `judge FOLDER…`, not `{}`",
            words.join(" ")
        ),
    }
}

/// Writes the samples of these images, or of all that are there.
fn prepare_all(mut paths: Vec<PathBuf>) -> Result<()> {
    if paths.is_empty() {
        if !Path::new(IMAGES).is_dir() {
            println!("SKIPPED: {IMAGES} is not there");
            return Ok(());
        }
        paths = images(Path::new(IMAGES))?;
    }
    paths
        .iter()
        .try_for_each(|path| prepare(path, Path::new(FOLDER)))
}

/// The samples, if they are there.
fn samples() -> Result<Option<Vec<PathBuf>>> {
    let folder = Path::new(FOLDER).join("samples");
    if !folder.is_dir() {
        println!(
            "SKIPPED: {} is not there; `-- prepare` makes it",
            folder.display()
        );
        return Ok(None);
    }
    images(&folder).map(Some)
}

/// Puts each sample on a flat square.
fn flat_all(seed: u32) -> Result<()> {
    let Some(samples) = samples()? else {
        return Ok(());
    };
    (samples.iter()).try_for_each(|path| texture_runs::flat(path, Path::new(FOLDER), seed))
}

/// Compares color differences across a seam of the input with those elsewhere.
fn seams() -> Result<()> {
    let Some(samples) = samples()? else {
        return Ok(());
    };
    println!("| sample | across the seam | elsewhere | ratio |");
    println!("|---|---|---|---|");
    samples.iter().try_for_each(|path| texture_runs::seam(path))
}

/// Prints the table.
fn judge_all(folders: &[PathBuf]) -> Result<()> {
    let Some(samples) = samples()? else {
        return Ok(());
    };
    println!(
        "| sample | image | histogram corr. | spectrum | SWD | coarse SWD | gradient | copied with neighbors | largest piece |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for path in samples {
        let sample = read(&path)?;
        let name = path.file_stem().unwrap_or_default().display();
        println!(
            "| {name} | its own halves | {} | | |",
            Judged::halves(&sample).cells()
        );
        for folder in folders {
            let cells = result_cells(&sample, folder, &path)?;
            println!("| {name} | {} | {cells} |", folder.display());
        }
    }
    Ok(())
}

/// What is said of a sample's result in a folder.
fn result_cells(sample: &Grid, folder: &Path, path: &Path) -> Result<String> {
    let name = path.file_name().unwrap_or_default();
    let image = folder.join(name);
    if !image.exists() {
        return Ok("not there | | | | | |".to_owned());
    }
    let result = read(&image)?;
    let sources = folder.join("sources").join(name);
    let copies = match sources.exists() {
        true => copies(&read_sources(&sources, &result)?, result.width),
        false => None,
    };
    let share = |share: fn(&Copies) -> f64| {
        let percent = copies.as_ref().map(|copies| 100.0 * share(copies));
        percent.map_or_else(String::new, |percent| format!("{percent:.1} %"))
    };
    Ok(format!(
        "{} | {} | {}",
        Judged::new(sample, &result).cells(),
        share(|copies| copies.continued),
        share(|copies| copies.largest)
    ))
}

/// What the measures say; `None` of images too small for them.
struct Judged {
    histogram: Option<f64>,
    spectrum: Option<f64>,
    patches: Option<f64>,
    coarse_patches: Option<f64>,
    gradient: Option<f64>,
}

impl Judged {
    /// Of a result.
    fn new(sample: &Grid, result: &Grid) -> Self {
        Self {
            histogram: least_histogram_correlation(sample, result),
            spectrum: spectrum_distance(sample, result),
            patches: sliced_wasserstein(sample, result),
            coarse_patches: coarse_sliced_wasserstein(sample, result),
            gradient: gradient_distance(sample, result),
        }
    }

    /// Of the sample itself: what may be asked of a result.
    fn halves(sample: &Grid) -> Self {
        Self {
            histogram: between_halves(sample, least_histogram_correlation),
            spectrum: between_halves(sample, spectrum_distance),
            patches: between_halves(sample, sliced_wasserstein),
            coarse_patches: between_halves(sample, coarse_sliced_wasserstein),
            gradient: between_halves(sample, gradient_distance),
        }
    }

    fn cells(&self) -> String {
        let cell = |value: Option<f64>, digits: usize| {
            value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
        };
        let Self {
            histogram,
            spectrum,
            patches,
            coarse_patches,
            gradient,
        } = *self;
        let values = [histogram, spectrum, patches, coarse_patches, gradient];
        (values.into_iter().zip([3, 3, 4, 4, 3]))
            .map(|(value, digits)| cell(value, digits))
            .collect::<Vec<String>>()
            .join(" | ")
    }
}
