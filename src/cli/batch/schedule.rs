//! Which scans are worked on at a time: as many as are asked for, as far as memory goes.

use std::collections::VecDeque;
use std::io::{IsTerminal, Write};
use std::num::NonZero;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Scope;
use std::time::{Duration, Instant};

use crate::progress::Progress;

use super::super::messages::Bar;
use super::super::outcome::Failure;
use super::super::watch::{Stopped, caught};
use super::super::{Common, interrupt};
use super::folder::Locked;
use super::line::{Line, Told};
use super::plan::Job;
use super::process::{Process, Stop};
use super::work::{Batch, Result};
use super::{Arguments, leftovers, memory};

/// How often memory and time are looked at.
const WATCHED: Duration = Duration::from_millis(50);

/// A scan that is worked on.
#[derive(Debug)]
struct Active {
    job: usize,
    since: Instant,
    process: Arc<Process>,
    /// What it is taken to need, in bytes.
    estimate: u64,
}

/// What is worked on now, for whoever must end it all.
#[derive(Debug, Clone, Default)]
struct Running(Arc<Mutex<State>>);

#[derive(Debug, Default)]
struct State {
    active: Vec<Active>,
    is_ending: bool,
}

impl Running {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends all processes, waits for them, and removes what they have left.
    fn end(&self, files: &[PathBuf]) {
        let mut state = self.state();
        state.is_ending = true;
        for active in &state.active {
            active.process.stop(Stop::Interrupted);
        }
        for active in &state.active {
            let _ = active.process.wait();
        }
        let ids: Vec<u32> = (state.active.iter())
            .filter_map(|active| active.process.id())
            .collect();
        leftovers::remove(files, |id| ids.contains(&id));
        let told = "\nrelievo: the batch goes on from here with --resume";
        let _ = std::io::stderr().write_all(told.as_bytes());
        // Stays locked: nobody begins another one, or tells of what was ended.
        std::mem::forget(state);
    }
}

/// A batch at work.
struct Schedule<'scope, 'env> {
    scope: &'scope Scope<'scope, 'env>,
    batch: Batch<'env>,
    jobs: &'env [Job],
    running: Running,
    ended: Sender<(usize, Result)>,
    waiting: VecDeque<usize>,
    /// Those that took too much memory beside others.
    alone: VecDeque<usize>,
    /// Scans at a time.
    most: usize,
    /// Bytes for all, if they are counted.
    budget: Option<u64>,
}

/// Does all jobs; a line for each, in their order, and whether all could be told.
pub(super) fn all(
    arguments: &Arguments,
    common: &Common,
    jobs: &[Job],
    locked: &Locked,
) -> (Vec<Line>, std::result::Result<(), Failure>) {
    let threads = common.threads.map_or_else(cores, usize::from);
    let most = arguments
        .jobs
        .map_or(threads, usize::from)
        .min(jobs.len())
        .max(1);
    let batch = Batch {
        arguments,
        working: &locked.working,
        threads: (threads / most).max(1),
        reports: false,
    };
    let running = Running::default();
    let all = running.clone();
    let files: Vec<_> = jobs
        .iter()
        .flat_map(|job| job.files(&arguments.out))
        .collect();
    interrupt::also(move || all.end(&files));
    let (ended, ends) = channel();
    std::thread::scope(|scope| {
        Schedule {
            scope,
            batch,
            jobs,
            running,
            ended,
            waiting: (0..jobs.len()).collect(),
            alone: VecDeque::new(),
            most,
            budget: (arguments.memory.map(|bytes| bytes as u64)).or_else(memory::available),
        }
        .run(&ends, common)
    })
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

impl<'env> Schedule<'_, 'env> {
    fn run(
        mut self,
        ends: &Receiver<(usize, Result)>,
        common: &Common,
    ) -> (Vec<Line>, std::result::Result<(), Failure>) {
        let mut lines: Vec<Option<Line>> = self.jobs.iter().map(|_| None).collect();
        let mut told = Told::default();
        // Lines of JSON and a bar on the same terminal would be in each other's way.
        let mut bar = (!std::io::stdout().is_terminal()).then(|| Bar::new(common));
        let mut left = self.jobs.len();
        while left > 0 {
            self.begin();
            match ends.recv_timeout(WATCHED) {
                Ok((job, result)) => {
                    self.running
                        .state()
                        .active
                        .retain(|active| active.job != job);
                    match result {
                        Result::Told(line) => {
                            left -= 1;
                            told.tell(&line);
                            lines[job] = Some(*line);
                        }
                        Result::Again => self.alone.push_back(job),
                        // Whoever has interrupted it ends the program.
                        Result::Interrupted => {}
                    }
                }
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
            }
            self.watch();
            if let Some(bar) = &mut bar {
                bar.show(Progress {
                    stage: "scans",
                    done: self.jobs.len() - left,
                    total: self.jobs.len(),
                });
            }
        }
        (lines.into_iter().flatten().collect(), told.end())
    }

    /// Begins what there is room for, in order.
    fn begin(&mut self) {
        loop {
            let (count, used) = self.used();
            let next = if let Some(job) = self.waiting.front() {
                let estimate = self.estimate(*job);
                let fits =
                    (self.budget).is_none_or(|budget| used.saturating_add(estimate) <= budget);
                if count > 0 && (count >= self.most || !fits) {
                    return;
                }
                self.waiting.pop_front()
            } else if count == 0 {
                self.alone.pop_front()
            } else {
                return;
            };
            let Some(job) = next else {
                return;
            };
            self.start(job);
        }
    }

    /// How many are worked on, and the memory that they have or are taken to need.
    fn used(&self) -> (usize, u64) {
        let state = self.running.state();
        let need = |active: &Active| active.estimate.max(active.process.memory());
        (state.active.len(), state.active.iter().map(need).sum())
    }

    fn estimate(&self, job: usize) -> u64 {
        memory::estimate(&self.jobs[job].input, self.jobs[job].tables)
    }

    fn start(&self, job: usize) {
        let process = Arc::new(Process::default());
        let mut state = self.running.state();
        if state.is_ending {
            return;
        }
        state.active.push(Active {
            job,
            since: Instant::now(),
            process: Arc::clone(&process),
            estimate: self.estimate(job),
        });
        drop(state);
        let (batch, jobs, ended) = (self.batch, self.jobs, self.ended.clone());
        let work = move || {
            let result = caught(|| batch.work(&jobs[job], &process)).unwrap_or_else(|stopped| {
                process.end();
                let how = match stopped {
                    Stopped::Panicked(message) => {
                        format!("a mistake in relievo, please report it: {message}")
                    }
                    Stopped::Ended => "it was ended".to_owned(),
                };
                Result::broken(&jobs[job], how)
            });
            // The other end lives as long as there are scans.
            let _ = ended.send((job, result));
        };
        let thread = std::thread::Builder::new().name("scan".to_owned());
        if let Err(error) = thread.spawn_scoped(self.scope, work) {
            let how = format!("there is no thread for it ({error}): give fewer jobs (--jobs)");
            let _ = self.ended.send((job, Result::broken(&jobs[job], how)));
        }
    }

    /// Ends what takes too much memory or time.
    fn watch(&self) {
        let state = self.running.state();
        if let Some(timeout) = self.batch.arguments.timeout {
            for active in state
                .active
                .iter()
                .filter(|active| active.since.elapsed() > timeout)
            {
                active.process.stop(Stop::Timeout);
            }
        }
        let living: Vec<&Active> = (state.active.iter())
            .filter(|active| !active.process.is_stopped())
            .collect();
        let used: u64 = living.iter().map(|active| active.process.memory()).sum();
        if self.budget.is_none_or(|budget| used <= budget) {
            return;
        }
        match living.as_slice() {
            [] => {}
            [only] => only.process.stop(Stop::Memory(used)),
            [.., youngest] => youngest.process.stop(Stop::Again),
        }
    }
}
