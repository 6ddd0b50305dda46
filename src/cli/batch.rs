//! `relievo batch`: the same for many scans, each in a process of its own.

mod child;
mod clashes;
mod elsewhere;
mod folder;
mod given;
mod leftovers;
mod line;
mod memory;
mod page;
mod pattern;
mod pictures;
mod plan;
mod process;
mod protocol;
mod recipe;
mod record;
mod schedule;
mod work;

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::{Map, json};

use super::outcome::{Failure, Reply, in_one_sentence, opened};
use super::{Common, arguments};
pub(super) use child::run as child;
pub use elsewhere::{SharedBatch, work_for_batch};
use line::{Counts, Line, summary};
use plan::Job;
pub use process::called_again_by;

/// The command that a batch gives to itself for each scan.
pub(super) const CHILD: &str = "batch-job";

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The scans: files, patterns in quotes such as 'scans/**/*.ply', or files of jobs (.json)
    #[arg(value_name = "JOBS.json|GLOB|SCAN", required = true)]
    given: Vec<PathBuf>,
    /// Folder of the results, under the scans' names; made if it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What is done to each scan: a pipeline as of `relievo run`, which reads the scan first and writes the result last,
    /// whatever paths it has there; {out}, {stem} and {name} in its strings are the result's folder, its name without
    /// extension, and the scan's name [default: complete]
    #[arg(long, value_name = "PIPELINE.json")]
    pipeline: Option<PathBuf>,
    /// An option of a step for all scans, as in --step.complete.window=4
    #[arg(long = "step", value_name = "TAG.OPTION=VALUE")]
    steps: Vec<String>,
    /// Format of the results [default: the scan's if it can be written, or ply]
    #[arg(long, value_name = "ply|obj|off|stl|glb", value_parser = ["ply", "obj", "off", "stl", "glb"])]
    format: Option<String>,
    /// Number of scans at a time [default: number of threads]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Leave out scans whose results are there, made of the same content with the same options
    #[arg(long)]
    resume: bool,
    /// Most memory for all scans that are worked on at a time, as in 500M or 4GiB [default: nine tenths of what is
    /// free]; the results do not depend on it
    #[arg(long, value_name = "SIZE", value_parser = arguments::memory)]
    memory: Option<usize>,
    /// Most time for a scan; what takes longer has failed
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    timeout: Option<Duration>,
    /// Write a page for the browser to FILE: failures first, then all scans in figures and pictures; it needs no network
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write over files in DIR that no batch has written
    #[arg(long)]
    overwrite: bool,
    /// Only say what would be done: a line of JSON for each scan with its input, its output and its pipeline
    #[arg(long)]
    dry_run: bool,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let expected = || "expected a number of seconds above 0".to_owned();
    let seconds: f64 = text.parse().map_err(|_| expected())?;
    let duration = Duration::try_from_secs_f64(seconds).map_err(|_| expected())?;
    if duration.is_zero() {
        return Err(expected());
    }
    Ok(duration)
}

/// All jobs, checked; nothing is done yet.
pub(super) struct Plan<'a> {
    arguments: &'a Arguments,
    jobs: Vec<Job>,
}

pub(super) fn plan<'a>(arguments: &'a Arguments, common: &Common) -> Result<Plan<'a>, Failure> {
    if common.json.as_deref() == Some(Path::new("-")) {
        return Err(Failure::usage(
            "--json -: standard output has a line of JSON for each scan; give a file",
        ));
    }
    let jobs = plan::jobs(arguments, common)?;
    Ok(Plan { arguments, jobs })
}

impl Arguments {
    /// The files that tell what to do.
    pub(super) fn files(&self) -> impl Iterator<Item = &Path> {
        let files = self.given.iter().chain(&self.pipeline);
        files.map(PathBuf::as_path)
    }
}

impl Plan<'_> {
    /// What is read, and what is written, with what messages call it.
    pub(super) fn files(&self) -> (Vec<PathBuf>, Vec<(&'static str, PathBuf)>) {
        let page = self.arguments.report.iter();
        let results = self.jobs.iter().flat_map(Job::outputs);
        let writes = (page.map(|path| ("--report", path.clone())))
            .chain(results.map(|path| ("the result", path)));
        (self.reads(), writes.collect())
    }

    fn reads(&self) -> Vec<PathBuf> {
        let of_job = |job: &Job| [vec![job.input.clone()], job.reads.clone()].concat();
        // Most of what steps read beside the scans is the same for all.
        let files: BTreeSet<PathBuf> = self.jobs.iter().flat_map(of_job).collect();
        files.into_iter().collect()
    }

    pub(super) fn run(self, common: &Common) -> super::Result {
        let since = Instant::now();
        let Self { arguments, jobs } = &self;
        if arguments.dry_run {
            return Ok(Reply {
                text: jobs
                    .iter()
                    .map(|job| format!("{}\n", job.to_value()))
                    .collect(),
                ..Reply::default()
            });
        }
        let report = self.opened_page()?;
        let locked = folder::locked(&arguments.out)?;
        let files = jobs.iter().flat_map(|job| job.files(&arguments.out));
        let files: Vec<PathBuf> = files.chain(arguments.report.clone()).collect();
        leftovers::remove(&files, leftovers::is_gone);
        let (lines, told) = schedule::all(arguments, common, jobs, &locked);
        let seconds = since.elapsed().as_secs_f64();
        let page = match (report, &arguments.report) {
            (Some(output), Some(path)) => page::write(output, path, &arguments.out, jobs, &lines),
            _ => Ok(()),
        };
        if !common.quiet {
            let text = summary(&lines, seconds);
            // Nowhere is left to report that standard error is closed.
            let _ = std::io::stderr().write_all(text.as_bytes());
        }
        reply(&lines, seconds, told.and(page))
    }

    fn opened_page(&self) -> Result<Option<crate::scan::OutputFile>, Failure> {
        let arguments = self.arguments;
        let Some(path) = &arguments.report else {
            return Ok(None);
        };
        if path == Path::new("-") {
            return Err(Failure::usage(
                "--report - has no name: give the page a file, as in index.html",
            ));
        }
        // The page may be in the folder of results, which may not be there yet.
        if let Some(folder) = path.parent().filter(|folder| *folder == arguments.out) {
            std::fs::create_dir_all(folder)?;
        }
        let reads = self.reads();
        let mut inputs: Vec<&Path> = reads.iter().map(PathBuf::as_path).collect();
        inputs.extend(arguments.files());
        let outputs: Vec<PathBuf> = self.jobs.iter().flat_map(Job::outputs).collect();
        let others: Vec<_> = outputs
            .iter()
            .map(|path| ("the result", Some(path.as_path())))
            .collect();
        opened("--report", path, &inputs, &others).map(Some)
    }
}

/// How many ended how; a failure if any failed, or if not all could be `told`.
fn reply(lines: &[Line], seconds: f64, told: Result<(), Failure>) -> super::Result {
    let counts = Counts::of(lines);
    let mut known = Map::new();
    known.insert("seconds".into(), json!(seconds));
    known.insert(
        "counts".into(),
        json!({
            "scans": counts.all,
            "failed": counts.failed,
            "partly": counts.partly,
            "done": counts.done,
            "skipped": counts.skipped,
        }),
    );
    known.insert("scans".into(), json!(lines));
    let failed = (counts.failed > 0)
        .then(|| anyhow::anyhow!("{} of {} scans failed", counts.failed, counts.all));
    let failure = match (told, failed) {
        (Err(failure), Some(failed)) => Failure {
            error: anyhow::anyhow!("{failed}; {}", in_one_sentence(&failure.error)),
            ..failure
        },
        (Err(failure), None) => failure,
        (Ok(()), Some(failed)) => failed.into(),
        (Ok(()), None) => {
            return Ok(Reply {
                json: known,
                partly: counts.partly > 0,
                ..Reply::default()
            });
        }
    };
    Err(Failure {
        json: known,
        ..failure
    })
}
