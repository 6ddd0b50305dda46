//! The native module `relievo._relievo` of the Python package, whose typed and documented face is `python/relievo`.
//!
//! Nothing is computed here: scans go in and out as arrays, and the work is done by [`crate::cli`] and
//! [`crate::scan`], in threads of their own while Python runs on.

mod array;
mod batch;
mod call;
mod command;
mod error;
mod files;
mod held;
mod messages;
mod tiles;
mod work;

use pyo3::pymodule;

/// What the Python package is built on; not for use by itself.
#[pymodule]
mod _relievo {
    #[pymodule_export]
    use super::array::Array;
    #[pymodule_export]
    use super::batch::{Batch, work_for_batch};
    #[pymodule_export]
    use super::call::{call, run, schema};
    #[pymodule_export]
    use super::command::{main, version};
    #[pymodule_export]
    use super::files::{Output, read};
    #[pymodule_export]
    use super::held::{HeldImage, HeldScan};
    #[pymodule_export]
    use super::tiles::{Tiles, grow_tile};
    #[pymodule_export]
    use super::work::abandon;
}
