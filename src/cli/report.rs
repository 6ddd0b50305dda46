//! `--report`: the page that a subcommand writes beside its results.

use std::path::{Path, PathBuf};

use crate::report::{Page, ReportError, check_built};
use crate::scan::OutputFile;
use clap::Args;

use super::Common;
use super::outcome::{Failure, opened};

/// The option.
#[derive(Debug, Clone, Args)]
pub(super) struct PageOption {
    /// Write a page for the browser to FILE: what was done and why, tables, plots, and the scan to turn in three
    /// dimensions; it needs no network
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Where the page goes: opened before the work, so that a folder that is missing is noticed then.
#[derive(Debug)]
pub(super) struct PageFile(OutputFile);

impl PageOption {
    /// Whether a page is asked for.
    pub(super) fn is_wanted(&self) -> bool {
        self.report.is_some()
    }

    /// Opens the page's file if one is asked for; it may be none of the inputs, nor where `others` (with their
    /// options) or the JSON go.
    pub(super) fn open(
        &self,
        inputs: &[&Path],
        others: &[(&str, Option<&Path>)],
        common: &Common,
    ) -> Result<Option<PageFile>, Failure> {
        let Some(path) = &self.report else {
            return Ok(None);
        };
        check_built().map_err(|error| Failure {
            usage: true,
            ..error.into()
        })?;
        if path == Path::new("-") {
            return Err(Failure::usage(
                "--report - has no name: give the page a file, as in report.html",
            ));
        }
        let json = [("--json", common.json.as_deref())];
        let others = [others, &json].concat();
        Ok(Some(PageFile(opened("--report", path, inputs, &others)?)))
    }
}

impl PageFile {
    /// Writes the page.
    pub(super) fn write(mut self, page: &Page) -> Result<(), Failure> {
        match page.write(&mut self.0) {
            Ok(()) => Ok(self.0.commit()?),
            Err(ReportError::Write(source)) => Err(self.0.error(source).into()),
            Err(error) => Err(error.into()),
        }
    }
}
