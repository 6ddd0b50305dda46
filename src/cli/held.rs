//! Scans and images in memory where commands have files: between the steps of a pipeline, and for programs that call
//! commands.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use clap::Args;

use crate::picture::Raster;
use crate::scan::{self, ColorMap, Format, Image, OutputFile, ReadOptions, Scan, WriteOptions};

use super::arguments;
use super::outcome::Failure;

/// The output of a command whose result is kept in memory. No file can have this name.
pub(super) const KEPT: &str = "\0kept.ply";

/// What a command gets instead of a file.
#[derive(Debug, Clone)]
pub struct Held {
    /// What messages call it.
    pub name: String,
    /// What there would be in the file.
    pub content: Content,
    /// The file that it was read from, if it is as there, and how.
    pub(super) origin: Option<(PathBuf, ReadOptions)>,
    /// Files that are not to be written over.
    pub(super) files: Vec<PathBuf>,
}

/// What would be in a file.
#[derive(Debug, Clone)]
pub enum Content {
    /// A scan.
    Scan(Arc<Scan>),
    /// An image.
    Image(Arc<Image>),
}

impl Held {
    /// A scan or an image that is in no file.
    #[must_use]
    pub fn new(name: impl Into<String>, content: Content) -> Self {
        Self {
            name: name.into(),
            content,
            origin: None,
            files: Vec::new(),
        }
    }

    pub(super) fn scan(&self) -> Result<Scan, Failure> {
        match &self.content {
            Content::Scan(scan) => Ok(Scan::clone(scan)),
            Content::Image(_) => Err(self.is_not("a scan")),
        }
    }

    pub(super) fn image(&self) -> Result<Arc<Image>, Failure> {
        match &self.content {
            Content::Image(image) => Ok(Arc::clone(image)),
            Content::Scan(_) => Err(self.is_not("an image")),
        }
    }

    /// The colors between its vertices, if it comes from a file that has them.
    pub(super) fn color_map(&self) -> Result<Option<ColorMap>, Failure> {
        match &self.origin {
            Some((path, options)) => Ok(scan::read_color_map(path, options)?),
            None => Ok(None),
        }
    }

    fn is_not(&self, wanted: &str) -> Failure {
        Failure::usage(format!("{}: give {wanted} here", self.name))
    }
}

/// What is held, each under the path that arguments give for it.
#[derive(Debug, Clone, Default)]
pub(super) struct Shelf(Vec<(PathBuf, Held)>);

impl Shelf {
    pub(super) fn put(&mut self, path: impl Into<PathBuf>, held: Held) {
        self.0.push((path.into(), held));
    }

    pub(super) fn get(&self, path: &Path) -> Option<&Held> {
        (self.0.iter()).find_map(|(held, what)| (held == path).then_some(what))
    }
}

/// Where the result of a command is kept.
#[derive(Debug, Clone, Default)]
pub(super) struct Slot(Arc<Mutex<Option<Kept>>>);

/// The result of a command.
#[derive(Debug)]
pub(super) enum Kept {
    Scan(Arc<Scan>),
    Picture(Box<Raster>),
}

impl Slot {
    pub(super) fn put(&self, kept: Kept) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(kept);
    }

    pub(super) fn take(&self) -> Option<Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// How a scan is written.
#[derive(Debug, Clone, Args)]
pub(super) struct Writing {
    /// Write PLY as text
    #[arg(long)]
    pub(super) ascii: bool,
    /// Allow OUT to be the same file as the input
    #[arg(long)]
    pub(super) overwrite: bool,
    #[arg(skip)]
    pub(super) slot: Option<Slot>,
}

impl Writing {
    pub(super) fn options(&self) -> WriteOptions {
        WriteOptions { ascii: self.ascii }
    }
}

/// Where a command's scan goes: a file, opened before the work, a slot, or both.
#[derive(Debug)]
pub(super) struct ScanOutput {
    file: Option<(OutputFile, Format)>,
    options: WriteOptions,
    slot: Option<Slot>,
}

impl ScanOutput {
    /// Opens the output, which may not be `input` unless it may be written over.
    pub(super) fn open(path: &Path, input: &Path, writing: &Writing) -> Result<Self, Failure> {
        let file = if is_kept(path) {
            None
        } else {
            let format = arguments::output_format(path)?;
            let protected = (!writing.overwrite).then_some(input);
            Some((OutputFile::create(path, protected)?, format))
        };
        Ok(Self::new(file, writing))
    }

    pub(super) fn new(file: Option<(OutputFile, Format)>, writing: &Writing) -> Self {
        Self {
            file,
            options: writing.options(),
            slot: writing.slot.clone(),
        }
    }

    /// Writes the scan, and lets the slot have it.
    pub(super) fn write(self, scan: Scan) -> Result<Arc<Scan>, Failure> {
        let scan = Arc::new(scan);
        if let Some((mut output, format)) = self.file {
            let name = output.name().to_owned();
            scan::write_to(&scan, &mut output, format, &self.options, &name)?;
            output.commit()?;
        }
        if let Some(slot) = self.slot {
            slot.put(Kept::Scan(Arc::clone(&scan)));
        }
        Ok(scan)
    }
}

/// Whether an output is kept in memory only.
pub(super) fn is_kept(path: &Path) -> bool {
    path == Path::new(KEPT)
}
