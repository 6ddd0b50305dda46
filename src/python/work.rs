//! Work in a thread of its own, while Python runs on and listens to Ctrl-C.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use pyo3::prelude::*;

use super::{error, messages};
use crate::scan::abandon_outputs;

/// How long an interrupt may go unnoticed.
const PATIENCE: Duration = Duration::from_millis(50);

/// Room for a working thread's calls: as much as a program's first thread has.
const STACK: usize = 8 << 20;

/// The threads that work, also those whose result nobody waits for any more.
static WORKING: AtomicUsize = AtomicUsize::new(0);

/// The process that has worked, 0 before that.
static PROCESS: AtomicU32 = AtomicU32::new(0);

/// Whether work should go on.
#[derive(Clone, Default)]
pub(super) struct Wish(Arc<AtomicBool>);

impl Wish {
    pub(super) fn is_over(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Ends the work when nobody waits for it any more, for whatever reason.
struct Awaited(Option<Wish>);

impl Awaited {
    /// The work has ended by itself; who planned with its wish may go on.
    fn has_come(mut self) {
        self.0 = None;
    }
}

impl Drop for Awaited {
    fn drop(&mut self) {
        if let Some(wish) = &self.0 {
            wish.0.store(true, Ordering::Relaxed);
        }
    }
}

/// Counts a thread that works.
struct Counted;

impl Counted {
    fn new() -> Self {
        WORKING.fetch_add(1, Ordering::Relaxed);
        Self
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        WORKING.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Works without Python's lock. An interrupt ends the wait at once, and the work as soon as it looks at the wish.
///
/// # Errors
/// What a handler of a signal raises, as `KeyboardInterrupt`; that the process is a fork of one that has worked, which
/// has lost its threads; or that the work panicked.
pub(super) fn work<T: Send + 'static>(
    py: Python<'_>,
    doing: impl FnOnce(&Wish) -> T + Send + 'static,
) -> PyResult<T> {
    work_while(py, doing, || Ok(true))
}

/// The same, as long as `is_wanted`: the work is told when it no longer is, and may give something all the same.
///
/// # Errors
/// As [`work`]; and those of `is_wanted`.
pub(super) fn work_while<T: Send + 'static>(
    py: Python<'_>,
    doing: impl FnOnce(&Wish) -> T + Send + 'static,
    is_wanted: impl Fn() -> PyResult<bool>,
) -> PyResult<T> {
    if !is_first_process(true) {
        let message = "relievo was used before this process was forked, and its threads are lost: start processes by \
                       multiprocessing.get_context(\"spawn\") instead";
        return Err(error::usage(py, message));
    }
    messages::listen();
    let wish = Wish::default();
    let awaited = Awaited(Some(wish.clone()));
    let (sender, mut receiver) = mpsc::sync_channel(1);
    let begun = {
        let counted = Counted::new();
        let thread = std::thread::Builder::new()
            .name("relievo".to_owned())
            .stack_size(STACK);
        thread.spawn(move || {
            let result = doing(&wish);
            drop(counted);
            // Nobody waits for it any more after an interrupt.
            let _ = sender.send(result);
        })
    };
    begun?;
    loop {
        let result;
        (result, receiver) = py.detach(move || (receiver.recv_timeout(PATIENCE), receiver));
        messages::pass_on(py)?;
        match result {
            Ok(result) => {
                awaited.has_come();
                return Ok(result);
            }
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals()?;
                if let Some(wish) = awaited.0.as_ref().filter(|wish| !wish.is_over())
                    && !is_wanted()?
                {
                    wish.0.store(true, Ordering::Relaxed);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                let message = "relievo has failed by a mistake of its own; please report it";
                return Err(error::exception(py, "WorkError", message, "{}"));
            }
        }
    }
}

/// Whether this process is the one that has worked first, and no fork of it; `begins` to work if none has.
fn is_first_process(begins: bool) -> bool {
    let process = std::process::id();
    let first = if begins {
        match PROCESS.compare_exchange(0, process, Ordering::Relaxed, Ordering::Relaxed) {
            Ok(_) => process,
            Err(first) => first,
        }
    } else {
        PROCESS.load(Ordering::Relaxed)
    };
    first == process
}

/// Takes away what is half written if a thread still works on something that nobody waits for: when the interpreter ends.
#[pyfunction]
pub(super) fn abandon() {
    // A fork has the names of its parent's files, and not its threads.
    if is_first_process(false) && WORKING.load(Ordering::Relaxed) > 0 {
        abandon_outputs();
    }
}
