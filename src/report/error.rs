//! Why a page cannot be written.

use std::io;

use thiserror::Error;

/// Why a page could not be written.
#[derive(Debug, Error)]
pub enum ReportError {
    /// The build carries plotly.js.
    #[error(
        "this relievo was built without reports; build it with `--features report`, or leave out --report"
    )]
    NotBuiltIn,
    /// The output takes what is written.
    #[error(transparent)]
    Write(#[from] io::Error),
}
