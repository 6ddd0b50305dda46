//! Commands and pipelines of [`crate::cli`], on what Python holds.

use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::{Map, Value};

use super::array::{Array, Numbers};
use super::error;
use super::held::{HeldImage, HeldScan};
use super::work::{Wish, work};
use crate::cli::{self, Call, CallError, CallErrorKind, Called, Content, Held, Watch};
use crate::picture::Raster;

/// A scan or an image that options name.
#[derive(FromPyObject)]
pub(super) enum InMemory<'py> {
    Scan(PyRef<'py, HeldScan>),
    Image(PyRef<'py, HeldImage>),
}

/// What is held: what options call it, what messages call it, and itself.
pub(super) type Shelf<'py> = Vec<(String, String, InMemory<'py>)>;

/// What a command gives: a scan, a picture, its report as JSON, and whether it is done partly only.
type Given = (Option<HeldScan>, Option<Array>, String, bool);

/// Runs a command: `options` is a JSON object.
#[pyfunction]
pub(super) fn call(
    py: Python<'_>,
    command: &str,
    options: &str,
    held: Shelf<'_>,
    threads: Option<usize>,
) -> PyResult<Given> {
    let call = prepared_with(py, Call::new(command), options, held, threads)?;
    done(py, call, Call::run)
}

/// Runs a pipeline: JSON as `relievo run` takes it, of a file with this name if it is of one.
#[pyfunction]
pub(super) fn run(
    py: Python<'_>,
    pipeline: &str,
    name: Option<String>,
    held: Shelf<'_>,
    threads: Option<usize>,
) -> PyResult<Given> {
    let pipeline: Value = of_json(py, name.as_deref().unwrap_or("the pipeline"), pipeline)?;
    let call = prepared(Call::default(), held, threads);
    done(py, call, move |call| {
        let done = call.run_pipeline(&pipeline);
        done.map_err(|error| match &name {
            Some(name) if error.kind == CallErrorKind::Usage => CallError {
                message: format!("{name}: {}", error.message),
                ..error
            },
            _ => error,
        })
    })
}

/// The JSON schema of pipelines.
#[pyfunction]
pub(super) fn schema() -> String {
    cli::schema().to_string()
}

/// A call with options from a JSON object.
pub(super) fn prepared_with(
    py: Python<'_>,
    call: Call,
    options: &str,
    held: Shelf<'_>,
    threads: Option<usize>,
) -> PyResult<Call> {
    let mut call = prepared(call, held, threads);
    let options: Map<String, Value> = of_json(py, "the options", options)?;
    for (name, value) in options {
        call.set(name, value);
    }
    Ok(call)
}

fn prepared(mut call: Call, held: Shelf<'_>, threads: Option<usize>) -> Call {
    for (path, name, what) in held {
        let content = match what {
            InMemory::Scan(scan) => Content::Scan(Arc::clone(&scan.0)),
            InMemory::Image(image) => Content::Image(Arc::clone(&image.0)),
        };
        call.hold(path, Held::new(name, content));
    }
    if let Some(threads) = threads {
        call.threads(threads);
    }
    call
}

fn done(
    py: Python<'_>,
    mut call: Call,
    run: impl FnOnce(Call) -> Result<Called, CallError> + Send + 'static,
) -> PyResult<Given> {
    let called = work(py, move |wish: &Wish| {
        let wish = wish.clone();
        call.watch(Watch::new(move |_| !wish.is_over()));
        run(call)
    })?;
    let called = called.map_err(|error| failed(py, &error))?;
    let picture = called.picture.map(|picture| pixels(&picture).into());
    let json = Value::Object(called.json).to_string();
    Ok((called.scan.map(HeldScan), picture, json, called.partly))
}

pub(super) fn failed(py: Python<'_>, error: &CallError) -> PyErr {
    let class = match error.kind {
        CallErrorKind::Usage => "UsageError",
        CallErrorKind::Missing => "MissingFileError",
        CallErrorKind::Reading => "ReadError",
        CallErrorKind::Writing => "WriteError",
        CallErrorKind::Work | CallErrorKind::Ended | CallErrorKind::Internal => "WorkError",
    };
    let details = Value::Object(error.json.clone()).to_string();
    error::exception(py, class, &error.message, &details)
}

/// Red, green and blue, and opacity where some of the picture lets through what is behind it.
fn pixels(picture: &Raster) -> Numbers {
    let size = [picture.height as usize, picture.width as usize];
    if picture
        .pixels
        .iter()
        .any(|[.., opacity]| *opacity < u8::MAX)
    {
        return Numbers::Translucent(size, picture.pixels.clone());
    }
    let opaque = picture.pixels.iter().map(|[r, g, b, _]| [*r, *g, *b]);
    Numbers::Pixels(size, opaque.collect())
}

fn of_json<T: serde::de::DeserializeOwned>(py: Python<'_>, what: &str, text: &str) -> PyResult<T> {
    serde_json::from_str(text)
        .map_err(|problem| error::usage(py, &format!("{what}: this is no JSON: {problem}")))
}
