//! One scan: whether it is to be done, what came of it, and what is kept of that.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use serde_json::Value;

use super::super::outcome::in_one_sentence;
use super::line::Line;
use super::plan::Job;
use super::process::{Ended, Process, Stop};
use super::protocol::{Answer, Order, Pictures, Status};
use super::record::{Names, Record, key};
use super::{Arguments, leftovers, memory};

/// What all scans have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct Batch<'a> {
    pub(super) arguments: &'a Arguments,
    /// A file that processes of scans lock together.
    pub(super) working: &'a Path,
    /// Threads of each process.
    pub(super) threads: usize,
    /// Whether lines are to have the scans' reports.
    pub(super) reports: bool,
}

/// A scan's end.
#[derive(Debug)]
pub(super) enum Result {
    Told(Box<Line>),
    /// It is to be done again when no others are.
    Again,
    /// The batch is to end.
    Interrupted,
}

impl Result {
    /// Of a scan that could not be worked on.
    pub(super) fn broken(job: &Job, how: String) -> Self {
        Self::Told(Box::new(broken(job, how)))
    }
}

impl Batch<'_> {
    /// Does a scan in `process`, or finds its results.
    pub(super) fn work(&self, job: &Job, process: &Process) -> Result {
        let since = Instant::now();
        let names = job.names(&self.arguments.out);
        let found = (self.arguments.resume)
            .then(|| names.recorded())
            .flatten()
            .filter(|record| record.holds(&job.parameters, &names));
        let mut line = match found {
            Some(record) => {
                let line = self.found(job, &names, record);
                self.draw_missing(job, &names, process);
                line
            }
            None => match self.done(job, &names, process) {
                Ok(line) => line,
                Err(Stop::Again) => return Result::Again,
                Err(_) => return Result::Interrupted,
            },
        };
        line.seconds = since.elapsed().as_secs_f64();
        Result::Told(Box::new(line))
    }

    /// The line of a result that is there already.
    pub(super) fn found(&self, job: &Job, names: &Names, record: Record) -> Line {
        Line {
            status: Status::Skipped,
            was: Some(record.status),
            written: record.outputs(names),
            peak_memory: record.peak_memory,
            key: Some(record.key),
            counts: record.counts,
            warnings: record.warnings,
            ..blank(job)
        }
    }

    /// Pictures for the page of a result that was there already.
    fn draw_missing(&self, job: &Job, names: &Names, process: &Process) {
        let Some(pictures) = self
            .pictures(names)
            .filter(|pictures| !pictures.after.exists())
        else {
            return;
        };
        let order = Order {
            pictures: Some(pictures),
            ..self.order(names)
        };
        if !matches!(process.run(&order), Ended::Answered(_)) {
            log::info!("{}: no picture for the page", job.output.display());
        }
    }

    fn pictures(&self, names: &Names) -> Option<Pictures> {
        let [before, after] = names.pictures();
        (self.arguments.report.is_some() && crate::picture::check_built().is_ok()).then(|| {
            Pictures {
                output: names.output.to_owned(),
                before,
                after,
            }
        })
    }

    fn order(&self, names: &Names) -> Order {
        Order {
            threads: self.threads,
            notes: names.notes().file,
            folder: names.folder.to_owned(),
            lock: self.working.to_owned(),
            ..Order::default()
        }
    }

    /// Does a scan in `process`; what came of it is recorded.
    pub(super) fn done(
        &self,
        job: &Job,
        names: &Names,
        process: &Process,
    ) -> std::result::Result<Line, Stop> {
        let failed = |error: String| broken(job, error);
        let order = Order {
            pipeline: Some(job.pipeline.to_value()),
            replaceable: (!self.arguments.overwrite).then(|| names.own_files()),
            pictures: self.pictures(names),
            report: self.reports,
            ..self.order(names)
        };
        if let Err(error) = make_folders(&[names.output.to_owned(), names.notes().file]) {
            return Ok(failed(in_one_sentence(&error)));
        }
        let recorded = names.recorded();
        let changed = recorded.map_or(Vec::new(), |record| record.changed(names));
        for picture in names.pictures() {
            // They are of an older result; there may be none.
            let _ = fs::remove_file(picture);
        }
        let ended = process.run(&order);
        if !matches!(ended, Ended::Answered(_))
            && let Some(id) = process.id()
        {
            // It was killed, and could take nothing away.
            leftovers::remove(&job.files(&self.arguments.out), |other| other == id);
        }
        let mut line = match ended {
            Ended::Answered(answer) => told(job, names, &answer),
            Ended::Broken(how) => Line {
                may_pass: true,
                ..failed(how)
            },
            Ended::Stopped(Stop::Timeout) => failed(self.too_long()),
            Ended::Stopped(Stop::Memory(needed)) => failed(self.too_much(needed)),
            Ended::Stopped(stop) => return Err(stop),
        };
        if line.status == Status::Failed {
            names.forget();
        }
        line.peak_memory = line.peak_memory.max(process.peak());
        line.warnings.extend(changed.iter().map(|path| {
            let shown = path.display();
            format!(
                "{shown}: somebody had changed this file since it was written; it was written anew"
            )
        }));
        Ok(line)
    }

    fn too_long(&self) -> String {
        let limit = self.arguments.timeout.unwrap_or_default().as_secs_f64();
        format!("it took longer than {limit} s and was ended: give it more time (--timeout)")
    }

    fn too_much(&self, needed: u64) -> String {
        format!(
            "it had taken {} by itself, more than all scans may (--memory), and was ended: give it more, or smaller tables (--step.complete.memory)",
            memory::in_words(needed)
        )
    }
}

fn make_folders(files: &[PathBuf]) -> anyhow::Result<()> {
    for folder in files.iter().map(|file| leftovers::folder(file)) {
        fs::create_dir_all(&folder)
            .with_context(|| format!("{}: this folder cannot be made", folder.display()))?;
    }
    Ok(())
}

/// A line in which nothing has come of the scan, and why.
fn broken(job: &Job, how: String) -> Line {
    Line {
        error: Some(how),
        ..blank(job)
    }
}

/// A line in which nothing has come of the scan.
pub(super) fn blank(job: &Job) -> Line {
    Line {
        input: job.input.to_string_lossy().into_owned(),
        output: job.output.to_string_lossy().into_owned(),
        status: Status::Failed,
        was: None,
        seconds: 0.0,
        peak_memory: None,
        seed: job.seed,
        key: None,
        counts: Value::Object(serde_json::Map::new()),
        warnings: Vec::new(),
        error: None,
        written: Vec::new(),
        report: serde_json::Map::new(),
        may_pass: false,
    }
}

/// What a process has answered; what came of a scan is recorded, once it is there.
fn told(job: &Job, names: &Names, answer: &Answer) -> Line {
    let mut line = Line {
        status: answer.status,
        peak_memory: answer.peak_memory,
        key: (!answer.read.is_empty()).then(|| key(&job.parameters, answer, names)),
        counts: answer.counts.clone().into(),
        warnings: answer.warnings.clone(),
        error: answer.error.clone(),
        written: answer.written.iter().cloned().collect(),
        report: answer.report.clone(),
        may_pass: answer.may_pass,
        ..blank(job)
    };
    if line.status == Status::Failed {
        return line;
    }
    let recorded = match answer.changed.first() {
        Some(path) => Err(anyhow::anyhow!(
            "{} has changed while the scan was worked on: do it again (--resume)",
            path.display()
        )),
        None => record(job, names, answer, line.key.clone().unwrap_or_default()),
    };
    if let Err(error) = recorded {
        line.status = Status::Failed;
        line.error = Some(in_one_sentence(&error));
    }
    line
}

fn record(job: &Job, names: &Names, answer: &Answer, key: String) -> anyhow::Result<()> {
    let record = Record::new(&job.parameters, key, answer, names)
        .with_context(|| format!("{}: the result cannot be read again", job.output.display()))?;
    Ok(record.keep(names)?)
}
