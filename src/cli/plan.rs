//! Commands that are told by files what to do: read and checked before the JSON is opened, which may be none of the files
//! that they read or write.

use std::path::{Path, PathBuf};

use super::outcome::{Failure, Reply};
use super::{Command, Common, batch, run};

/// What is to be done.
pub(super) enum Plan<'a> {
    Run(run::Plan),
    Batch(batch::Plan<'a>),
    /// What the command line says.
    Plain,
}

impl Command {
    pub(super) fn plan(&self, common: &Common) -> Result<Plan<'_>, Failure> {
        Ok(match self {
            Self::Run(arguments) => Plan::Run(run::plan(arguments, common)?),
            Self::Batch(arguments) => Plan::Batch(batch::plan(arguments, common)?),
            _ => Plan::Plain,
        })
    }

    /// The files that tell what to do.
    pub(super) fn protected(&self) -> Vec<&Path> {
        match self {
            Self::Run(arguments) => arguments.pipeline.iter().map(PathBuf::as_path).collect(),
            Self::Batch(arguments) => arguments.files().collect(),
            _ => Vec::new(),
        }
    }
}

impl Plan<'_> {
    /// What is read, and what is written, with what messages call it.
    pub(super) fn files(&self) -> (Vec<PathBuf>, Vec<(&'static str, PathBuf)>) {
        match self {
            Self::Run(plan) => {
                let writes = plan.writes().into_iter();
                (
                    plan.reads(),
                    writes.map(|path| ("a step's output", path)).collect(),
                )
            }
            Self::Batch(plan) => plan.files(),
            Self::Plain => (Vec::new(), Vec::new()),
        }
    }

    pub(super) fn run(self, common: &Common) -> super::Result {
        match self {
            Self::Run(plan) => plan.run(common),
            Self::Batch(plan) => plan.run(common),
            Self::Plain => Ok(Reply::default()),
        }
    }
}
