//! The library's messages, for Python's `logging`.
//!
//! Threads that work only put their messages in a line; whoever waits for the work, and may run Python, passes them on.
//! So no thread that works ever waits for Python's lock, which may be held by one that waits for it, or by an
//! interpreter that is about to end.

use std::collections::VecDeque;
use std::sync::{Mutex, Once, PoisonError};

use log::{Level, LevelFilter, Log, Metadata, Record};
use pyo3::prelude::*;

/// A message and its level as a number of Python's.
type Message = (u8, String);

static WAITING: Mutex<VecDeque<Message>> = Mutex::new(VecDeque::new());

struct Line;

impl Log for Line {
    fn enabled(&self, metadata: &Metadata) -> bool {
        metadata.level() <= log::max_level() && metadata.target().starts_with("relievo")
    }

    fn log(&self, record: &Record) {
        if self.enabled(record.metadata()) {
            let message = (level(record.level()), record.args().to_string());
            let mut waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
            waiting.push_back(message);
        }
    }

    fn flush(&self) {}
}

/// The level's number in Python's `logging`.
fn level(level: Level) -> u8 {
    match level {
        Level::Error => 40,
        Level::Warn => 30,
        Level::Info => 20,
        Level::Debug | Level::Trace => 10,
    }
}

/// Listens to the library's messages from now on, unless the command line does.
pub(super) fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        if log::set_logger(&Line).is_ok() {
            log::set_max_level(LevelFilter::Debug);
        }
    });
}

/// Passes on what there is to say, to the logger `relievo`.
pub(super) fn pass_on(py: Python<'_>) -> PyResult<()> {
    let next = || {
        let mut waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.pop_front()
    };
    while let Some((level, message)) = next() {
        py.import("relievo._messages")?
            .call_method1("told", (level, message))?;
    }
    Ok(())
}
