//! Errors as Python's exceptions, which `relievo._errors` defines.

use pyo3::prelude::*;

use crate::scan::ScanError;

/// An exception of `relievo._errors`, with a sentence and what is known all the same, as JSON.
pub(super) fn exception(py: Python<'_>, class: &str, message: &str, details: &str) -> PyErr {
    let made = || {
        let details = py.import("json")?.call_method1("loads", (details,))?;
        let made = py.import("relievo._errors")?.getattr("made")?;
        made.call1((class, message, details))
    };
    made().map_or_else(|error| error, PyErr::from_value)
}

/// Something impossible was asked for.
pub(super) fn usage(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "UsageError", message, "{}")
}

/// A file could not be read or written.
pub(super) fn of_file(py: Python<'_>, error: &ScanError) -> PyErr {
    let class = match error {
        ScanError::NotFound { .. } => "MissingFileError",
        error if error.is_of_writing() => "WriteError",
        _ => "ReadError",
    };
    exception(py, class, &error.to_string(), "{}")
}
