//! Small pictures of results, for the page of the batch.

use std::io::Write;
use std::path::Path;

use crate::completion::COMPLETED;
use crate::picture::{self, RenderParams};
use crate::scan::{self, OutputFile, ReadOptions, Scan};
use anyhow::Context;

use super::protocol::Pictures;

/// Width and height, in pixels.
const SIZE: [u32; 2] = [240, 180];

/// Draws them; the result is there all the same if they cannot be.
pub(super) fn draw(pictures: &Pictures) {
    if let Err(error) = drawn(pictures) {
        log::warn!("no picture for the page: {error:#}");
    }
}

fn drawn(pictures: &Pictures) -> anyhow::Result<()> {
    let scan = scan::read(&pictures.output, &ReadOptions::default())?;
    // An old one would be of another result.
    let _ = std::fs::remove_file(&pictures.before);
    if scan.vertices.column(COMPLETED).is_some() {
        draw_to(&pictures.before, &scan, true)?;
    }
    draw_to(&pictures.after, &scan, false)
}

fn draw_to(path: &Path, scan: &Scan, before: bool) -> anyhow::Result<()> {
    let [width, height] = SIZE;
    let params = RenderParams {
        width,
        height,
        before,
        legend: false,
        ..RenderParams::default()
    };
    let drawn = picture::render(scan, &params).with_context(|| path.display().to_string())?;
    let mut bytes = Vec::new();
    picture::write_png(&drawn.raster, &mut bytes)?;
    let mut output = OutputFile::create(path, None)?;
    output
        .write_all(&bytes)
        .map_err(|error| output.error(error))?;
    output.commit()?;
    Ok(())
}
