//! Work that is watched, and ended early if whoever watches says so.

use std::fmt;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;

use crate::progress::Progress;

/// Hears how far the work is; gives whether it is to go on.
#[derive(Clone)]
pub struct Watch(Arc<dyn Fn(Progress) -> bool + Send + Sync>);

/// What unwinds the work's stack when it is ended early.
struct Ended;

/// Why watched work gave nothing.
#[derive(Debug)]
pub(super) enum Stopped {
    /// Whoever watched has ended it.
    Ended,
    /// It panicked, with this message.
    Panicked(String),
}

impl Watch {
    /// A watch that calls `hear`; false ends the work.
    pub fn new(hear: impl Fn(Progress) -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(hear))
    }

    /// Says how far the work is. Does not return if it is to end: like a panic, but without a message, so that files
    /// that are not complete are removed on the way.
    pub(super) fn tell(&self, progress: Progress) {
        if !(self.0)(progress) {
            panic::resume_unwind(Box::new(Ended));
        }
    }
}

impl fmt::Debug for Watch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Watch")
    }
}

/// Does work that may be ended by its watch.
pub(super) fn caught<T>(work: impl FnOnce() -> T) -> Result<T, Stopped> {
    // What is left of the work's data is dropped with it.
    panic::catch_unwind(AssertUnwindSafe(work)).map_err(|payload| {
        if payload.is::<Ended>() {
            return Stopped::Ended;
        }
        let text = (payload.downcast_ref::<&str>().copied())
            .or_else(|| payload.downcast_ref::<String>().map(String::as_str));
        Stopped::Panicked(text.unwrap_or("no message").to_owned())
    })
}
