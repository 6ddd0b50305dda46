//! The program `relievo`, for installations that have the Python package alone.

use std::ffi::OsString;
use std::process::ExitCode;

use pyo3::prelude::*;

use crate::cli;

/// Runs the command line as the program `relievo` does, and gives its exit code.
#[pyfunction]
pub(super) fn main(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    call_again(py)?;
    let code = py.detach(|| cli::run(arguments.into_iter()));
    // An exit code does not tell its number.
    let is_it = |number: &u8| ExitCode::from(*number) == code;
    Ok((0..=u8::MAX).find(is_it).unwrap_or(1))
}

/// Lets a batch call the command line again: this process is Python.
pub(super) fn call_again(py: Python<'_>) -> PyResult<()> {
    let python: OsString = py.import("sys")?.getattr("executable")?.extract()?;
    // Nothing is imported from the working folder, which is the user's.
    let words = ["-P", "-m", "relievo._command_line"].map(OsString::from);
    cli::called_again_by(std::iter::once(python).chain(words).collect());
    Ok(())
}

/// The library's version.
#[pyfunction]
pub(super) fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}
