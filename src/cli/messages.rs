//! Messages and progress bars on standard error.

use std::io::{IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use crate::progress::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use log::{Level, LevelFilter, Log, Metadata, Record};

use super::Common;
use super::watch::Watch;

struct StandardError;

impl Log for StandardError {
    fn enabled(&self, metadata: &Metadata) -> bool {
        metadata.level() <= log::max_level()
    }

    fn log(&self, record: &Record) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let label = match record.level() {
            Level::Error => "error: ",
            Level::Warn => "warning: ",
            _ => "",
        };
        // Nowhere is left to report that standard error is closed.
        let _ = writeln!(std::io::stderr(), "relievo: {label}{}", record.args());
    }

    fn flush(&self) {}
}

/// Keeps the messages of a process that has nobody to tell them to.
struct Collected;

static COLLECTED: Mutex<Vec<String>> = Mutex::new(Vec::new());

impl Log for Collected {
    fn enabled(&self, metadata: &Metadata) -> bool {
        metadata.level() <= Level::Warn
    }

    fn log(&self, record: &Record) {
        if self.enabled(record.metadata()) {
            let mut collected = COLLECTED.lock().unwrap_or_else(PoisonError::into_inner);
            collected.push(record.args().to_string());
        }
    }

    fn flush(&self) {}
}

/// Keeps the library's warnings instead of sending them anywhere.
pub(super) fn collect() {
    if log::set_logger(&Collected).is_ok() {
        log::set_max_level(LevelFilter::Warn);
    }
}

/// The warnings that were kept, in their order.
pub(super) fn collected() -> Vec<String> {
    std::mem::take(&mut COLLECTED.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Sends the library's messages to standard error.
pub(super) fn install(common: &Common) {
    let level = if common.quiet {
        LevelFilter::Error
    } else if common.verbose {
        LevelFilter::Debug
    } else {
        LevelFilter::Warn
    };
    if log::set_logger(&StandardError).is_ok() {
        log::set_max_level(level);
    }
}

/// A progress bar on a terminal, nothing elsewhere: the stage, the share that is done and the time that is
/// left, or the time that it has taken where that is not known.
pub(super) struct Bar {
    bar: ProgressBar,
    stage: &'static str,
    watch: Option<Watch>,
}

impl Bar {
    pub(super) fn new(common: &Common) -> Self {
        let shown = !common.quiet && std::io::stderr().is_terminal();
        let bar = if shown {
            ProgressBar::no_length()
        } else {
            ProgressBar::hidden()
        };
        bar.enable_steady_tick(Duration::from_millis(500));
        Self {
            bar,
            stage: "",
            watch: common.watch.clone(),
        }
    }

    /// A bar that says what is being done, for what cannot tell how far it is.
    pub(super) fn doing(common: &Common, stage: &'static str) -> Self {
        let mut bar = Self::new(common);
        bar.show(Progress {
            stage,
            done: 0,
            total: 0,
        });
        bar
    }

    pub(super) fn show(&mut self, progress: Progress) {
        if let Some(watch) = &self.watch {
            watch.tell(progress);
        }
        if self.stage != progress.stage {
            self.stage = progress.stage;
            self.bar.set_message(progress.stage);
            self.bar.reset();
            let template = if progress.total > 0 {
                "{msg} [{bar:40}] {percent} %, {eta} left"
            } else {
                "{msg} {spinner} {elapsed}"
            };
            if let Ok(style) = ProgressStyle::with_template(template) {
                self.bar.set_style(style.progress_chars("=> "));
            }
        }
        if progress.total == 0 {
            return;
        }
        self.bar.set_length(progress.total as u64);
        self.bar.set_position(progress.done as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
