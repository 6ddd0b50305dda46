//! Batches whose scans Python gives to workers.

use std::ffi::OsString;
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;

use super::call::failed;
use super::work::{Wish, work, work_while};
use super::{command, error};
use crate::cli::{self, SharedBatch};

/// A planned batch, which holds its folder of results until it is closed.
#[pyclass(frozen, name = "Batch", module = "relievo._relievo")]
pub(super) struct Batch(Mutex<Option<SharedBatch>>);

#[pymethods]
impl Batch {
    /// Plans what `relievo batch` does with these arguments.
    #[new]
    fn new(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<Self> {
        let planned = work(py, move |_| SharedBatch::new(arguments))?;
        let planned = planned.map_err(|error| failed(py, &error))?;
        Ok(Self(Mutex::new(Some(planned))))
    }

    /// The scans and their results, as they were given.
    fn scans(&self, py: Python<'_>) -> PyResult<Vec<(String, String)>> {
        self.with(py, |batch| {
            let scans = batch.scans();
            scans
                .map(|(input, output)| (input.display().to_string(), output.display().to_string()))
                .collect()
        })
    }

    /// What is told of a scan whose results are there, as JSON.
    fn found(&self, py: Python<'_>, job: usize) -> PyResult<Option<String>> {
        self.with(py, |batch| batch.found(job).map(|line| line.to_string()))
    }

    /// What a worker gets to do a scan.
    fn task(&self, py: Python<'_>, job: usize) -> PyResult<String> {
        let task = self.with(py, |batch| batch.task(job))?;
        task.ok_or_else(|| error::usage(py, "there is no such scan in this batch"))
    }

    /// Lets others have the folder of results.
    fn close(&self) {
        drop(self.0.lock().unwrap_or_else(PoisonError::into_inner).take());
    }
}

impl Batch {
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        asking: impl FnOnce(&SharedBatch) -> T + Send,
    ) -> PyResult<T> {
        let told = py.detach(|| {
            let batch = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            batch.as_ref().map(asking)
        });
        told.ok_or_else(|| error::usage(py, "the batch is over"))
    }
}

/// Does a scan of a batch in a process of its own, as long as `is_wanted` gives true; the line of `relievo batch`, as
/// JSON.
#[pyfunction]
pub(super) fn work_for_batch(
    py: Python<'_>,
    task: String,
    threads: usize,
    memory: Option<u64>,
    is_wanted: &Bound<'_, PyAny>,
) -> PyResult<String> {
    command::call_again(py)?;
    let working =
        move |wish: &Wish| cli::work_for_batch(&task, threads, memory, || !wish.is_over());
    let line = work_while(py, working, || is_wanted.call0()?.is_truthy())?;
    let line = line.map_err(|error| failed(py, &error))?;
    Ok(line.to_string())
}
