//! The commands that do something with a scan: on the command line, and as steps of a pipeline.

use std::path::Path;

use clap::Subcommand;

use super::held::{Held, Slot};
use super::reading::{Input, Reading};
use super::{Common, Files, compare, complete, fit, holes, info, render, stats, texture, transfer};

/// A command about one scan.
#[derive(Debug, Subcommand)]
pub(super) enum ScanCommand {
    /// Compare two scans, or two parts of one, in figures and in units of natural variation
    Compare(compare::Arguments),
    /// Complete the missing parts of a scan
    Complete(complete::Arguments),
    /// Fit a base surface: parameters, residuals, how the other kinds compare
    Fit(fit::Arguments),
    /// List every boundary loop: id, edges, length, area estimate, hole or outer rim
    Holes(holes::Arguments),
    /// Tell what is in a file: vertices, faces, properties, extent, pieces, holes, what would be repaired
    Info(info::Arguments),
    /// Draw a scan or one of its channels as a PNG picture, without a display
    Render(render::Arguments),
    /// Compare the original part of a completed scan with the completed part, or tell the areal parameters of a
    /// height map (--step)
    Stats(stats::Arguments),
    /// Put the texture of a sample, an image or a scan, all over a mesh: in colour, or as relief
    Texture(texture::Arguments),
    /// Copy colours or relief from one mesh onto another, following its shape, or from a part of a mesh onto the rest
    Transfer(transfer::Arguments),
}

impl ScanCommand {
    /// Does it.
    pub(super) fn run(&self, common: &Common) -> super::Result {
        match self {
            Self::Compare(arguments) => compare::run(arguments, common),
            Self::Complete(arguments) => complete::run(arguments, common),
            Self::Fit(arguments) => fit::run(arguments, common),
            Self::Holes(arguments) => holes::run(arguments, common),
            Self::Info(arguments) => info::run(arguments),
            Self::Render(arguments) => render::run(arguments, common),
            Self::Stats(arguments) => stats::run(arguments, common),
            Self::Texture(arguments) => texture::run(arguments, common),
            Self::Transfer(arguments) => transfer::run(arguments, common),
        }
    }

    /// What it reads and writes.
    pub(super) fn files(&self) -> Files<'_> {
        let (command, input, output) = match self {
            Self::Compare(a) => ("compare", Some(&a.input), None),
            Self::Complete(a) => ("complete", Some(&a.input), Some(&a.output)),
            Self::Fit(a) => ("fit", Some(&a.input), None),
            Self::Holes(a) => ("holes", Some(&a.input), None),
            Self::Info(a) => ("info", Some(&a.input), None),
            Self::Render(a) => ("render", Some(&a.input), Some(&a.output)),
            Self::Stats(a) => ("stats", Some(&a.input), None),
            Self::Texture(a) => ("texture", Some(&a.input), Some(&a.output)),
            Self::Transfer(a) => ("transfer", None, Some(&a.output)),
        };
        let mut inputs: Vec<&Path> = input.into_iter().flat_map(Input::files).collect();
        match self {
            Self::Compare(a) => inputs.extend(a.other.as_deref()),
            Self::Texture(a) => inputs.extend(a.others()),
            Self::Transfer(a) => inputs.extend(a.files()),
            _ => {}
        }
        Files {
            command,
            inputs,
            output: output.map(std::path::PathBuf::as_path),
        }
    }

    /// Whether its output may be a file that is read.
    pub(super) fn may_overwrite(&self) -> bool {
        match self {
            Self::Complete(a) => a.writing.overwrite,
            Self::Texture(a) => a.writing.overwrite,
            Self::Transfer(a) => a.writing.overwrite,
            Self::Render(a) => a.overwrite,
            Self::Compare(_) | Self::Fit(_) | Self::Holes(_) | Self::Info(_) | Self::Stats(_) => {
                false
            }
        }
    }

    /// Gives it something in memory that its arguments name by `path`.
    pub(super) fn hold(&mut self, path: &str, held: Held) {
        self.reading().shelf.put(path, held);
    }

    fn reading(&mut self) -> &mut Reading {
        match self {
            Self::Compare(a) => &mut a.input.reading,
            Self::Complete(a) => &mut a.input.reading,
            Self::Fit(a) => &mut a.input.reading,
            Self::Holes(a) => &mut a.input.reading,
            Self::Info(a) => &mut a.input.reading,
            Self::Render(a) => &mut a.input.reading,
            Self::Stats(a) => &mut a.input.reading,
            Self::Texture(a) => &mut a.input.reading,
            Self::Transfer(a) => &mut a.reading,
        }
    }

    /// Has its scan or picture put into a slot, too; where its output is [`KEPT`](super::held::KEPT), only there.
    pub(super) fn keep(&mut self) -> Option<Slot> {
        let slot = match self {
            Self::Complete(a) => &mut a.writing.slot,
            Self::Texture(a) => &mut a.writing.slot,
            Self::Transfer(a) => &mut a.writing.slot,
            Self::Render(a) => &mut a.slot,
            Self::Compare(_) | Self::Fit(_) | Self::Holes(_) | Self::Info(_) | Self::Stats(_) => {
                return None;
            }
        };
        Some(slot.insert(Slot::default()).clone())
    }
}
