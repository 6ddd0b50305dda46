//! Completion in tiles, which workers grow.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::Value;

use super::call::{Shelf, failed, prepared_with};
use super::error;
use super::held::HeldScan;
use super::work::{Wish, work};
use crate::cli::{self, Call, TiledCall, Watch};

/// A completion whose tiles are grown elsewhere.
#[pyclass(frozen, name = "Tiles", module = "relievo._relievo")]
pub(super) struct Tiles {
    call: Mutex<Option<TiledCall>>,
    /// Of whoever waits for the plan now.
    wish: Arc<Mutex<Wish>>,
}

#[pymethods]
impl Tiles {
    /// Plans a completion: `options` of the command complete as a JSON object, `tile` among them.
    #[new]
    fn new(
        py: Python<'_>,
        options: &str,
        held: Shelf<'_>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let mut call = prepared_with(py, Call::new("complete"), options, held, threads)?;
        let current = Arc::new(Mutex::new(Wish::default()));
        let heard = Arc::clone(&current);
        let planned = work(py, move |wish: &Wish| {
            *locked(&heard) = wish.clone();
            call.watch(Watch::new(move |_| !locked(&heard).is_over()));
            TiledCall::new(call)
        })?;
        let planned = planned.map_err(|error| failed(py, &error))?;
        Ok(Self {
            call: Mutex::new(Some(planned)),
            wish: current,
        })
    }

    /// The tiles, round after round.
    fn rounds(&self, py: Python<'_>) -> PyResult<Vec<Vec<usize>>> {
        self.with(py, |tiles| Ok(tiles.rounds()))
    }

    /// What a worker needs to grow a tile.
    fn task<'py>(&self, py: Python<'py>, tile: usize) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.with(py, |tiles| tiles.task(tile))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Takes what a worker has grown.
    fn put(&self, py: Python<'_>, tile: usize, grown: &[u8]) -> PyResult<()> {
        self.with(py, |tiles| tiles.put(tile, grown))
    }

    /// Puts the tiles together: the scan, its report as JSON, and whether it is done partly only.
    fn finish(&self, py: Python<'_>) -> PyResult<(Option<HeldScan>, String, bool)> {
        // While tiles are missing the plan stays.
        let taken = py.detach(|| {
            let mut tiles = locked(&self.call);
            tiles.as_ref().map(TiledCall::check).transpose()?;
            Ok::<_, cli::CallError>(tiles.take())
        });
        let Some(tiles) = taken.map_err(|error| failed(py, &error))? else {
            return Err(over(py));
        };
        let current = Arc::clone(&self.wish);
        let called = work(py, move |wish: &Wish| {
            *locked(&current) = wish.clone();
            tiles.finish()
        })?;
        let called = called.map_err(|error| failed(py, &error))?;
        let json = Value::Object(called.json).to_string();
        Ok((called.scan.map(HeldScan), json, called.partly))
    }
}

impl Tiles {
    /// Does something with the plan without Python's lock.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        doing: impl FnOnce(&mut TiledCall) -> Result<T, cli::CallError> + Send,
    ) -> PyResult<T> {
        let done = py.detach(|| locked(&self.call).as_mut().map(doing));
        match done {
            Some(done) => done.map_err(|error| failed(py, &error)),
            None => Err(over(py)),
        }
    }
}

/// What a thread that panicked has left is still right: each change is a single step.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn over(py: Python<'_>) -> PyErr {
    error::usage(py, "the tiles have been put together already")
}

/// Grows the tile of a task: bytes that the plan takes back.
#[pyfunction]
pub(super) fn grow_tile<'py>(
    py: Python<'py>,
    task: &[u8],
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyBytes>> {
    let task = task.to_vec();
    let grown = work(py, move |wish: &Wish| {
        let wish = wish.clone();
        let watch = Watch::new(move |_| !wish.is_over());
        cli::grow_tile(&task, threads, Some(&watch))
    })?;
    let grown = grown.map_err(|error| failed(py, &error))?;
    Ok(PyBytes::new(py, &grown))
}
