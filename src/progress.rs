//! What a long computation says while it runs, and how long its stages took.

use std::time::Instant;

use serde::Serialize;

/// How far a stage has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Name of the stage.
    pub stage: &'static str,
    /// Units done, of `total`.
    pub done: usize,
    /// Units in all; 0 if not known.
    pub total: usize,
}

/// Seconds that a stage took.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StageTime {
    /// Name of the stage.
    pub stage: &'static str,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// Stage times, and the way to tell progress.
pub(crate) struct Clock<'a> {
    pub(crate) since: Instant,
    pub(crate) stages: Vec<StageTime>,
    pub(crate) progress: &'a mut dyn FnMut(Progress),
}

impl<'a> Clock<'a> {
    pub(crate) fn new(progress: &'a mut dyn FnMut(Progress)) -> Self {
        Self {
            since: Instant::now(),
            stages: Vec::new(),
            progress,
        }
    }

    /// Says what comes next and cannot tell how far it is.
    pub(crate) fn begin(&mut self, stage: &'static str) {
        (self.progress)(Progress {
            stage,
            done: 0,
            total: 0,
        });
    }

    /// Ends a stage; one that comes again adds up.
    pub(crate) fn end(&mut self, stage: &'static str) {
        let seconds = self.since.elapsed().as_secs_f64();
        self.since = Instant::now();
        log::debug!("{stage}: {seconds:.2} s");
        match self.stages.iter_mut().find(|s| s.stage == stage) {
            Some(known) => known.seconds += seconds,
            None => self.stages.push(StageTime { stage, seconds }),
        }
    }
}
