//! Scans from files, and into files.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;

use super::error;
use super::held::HeldScan;
use super::work::work;
use crate::cli::format_to_write;
use crate::scan::{self, Format, Intrinsics, OutputFile, ReadOptions, ScanError, WriteOptions};

/// Reads a scan.
#[pyfunction]
pub(super) fn read(
    py: Python<'_>,
    path: PathBuf,
    columns: Option<Vec<String>>,
    intrinsics: Option<[f64; 4]>,
    color_image: Option<PathBuf>,
) -> PyResult<HeldScan> {
    let options = ReadOptions {
        columns,
        intrinsics: intrinsics.map(|[fx, fy, cx, cy]| Intrinsics { fx, fy, cx, cy }),
        color_image,
    };
    let scan = work(py, move |_| scan::read(&path, &options))?;
    let scan = scan.map_err(|error| error::of_file(py, &error))?;
    Ok(HeldScan(Arc::new(scan)))
}

/// A file that a scan is written to: opened before the work, it appears whole, or not at all.
#[pyclass(frozen, module = "relievo._relievo")]
pub(super) struct Output(Mutex<Option<(OutputFile, Format)>>);

#[pymethods]
impl Output {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let format = format_to_write(&path).map_err(|message| error::usage(py, &message))?;
        let opened = py.detach(move || OutputFile::create(&path, None));
        let file = opened.map_err(|error| error::of_file(py, &error))?;
        Ok(Self(Mutex::new(Some((file, format)))))
    }

    /// Writes a scan, and lets the file appear.
    fn write(&self, py: Python<'_>, scan: &HeldScan, ascii: bool) -> PyResult<()> {
        let Some((mut output, format)) = self.taken() else {
            return Err(error::usage(py, "the output is closed"));
        };
        let scan = Arc::clone(&scan.0);
        let written = work(py, move |wish| {
            let name = output.name().to_owned();
            scan::write_to(&scan, &mut output, format, &WriteOptions { ascii }, &name)?;
            // After an interrupt nothing appears any more.
            if !wish.is_over() {
                output.commit()?;
            }
            Ok::<(), ScanError>(())
        })?;
        written.map_err(|error| error::of_file(py, &error))
    }

    /// Leaves nothing behind if nothing was written.
    fn close(&self) {
        drop(self.taken());
    }
}

impl Output {
    fn taken(&self) -> Option<(OutputFile, Format)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}
