//! A batch whose scans are worked on by workers elsewhere, which have the same folders: the same processes, results and
//! records as those of `relievo batch`.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::{CommandFactory, FromArgMatches};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::super::call::{CallError, guarded};
use super::super::outcome::Failure;
use super::super::pipeline::{Pipeline, definition};
use super::super::repeated::is_given;
use super::super::step_options::{Options, ValueKind, in_one_sentence, kind_of};
use super::super::{Cli, Command, Common};
use super::folder::{Locked, locked};
use super::line::Line;
use super::plan::{Job, jobs};
use super::process::{Process, Stop};
use super::work::{Batch, blank};
use super::{Arguments, leftovers, memory};

/// How often it is looked whether a scan is still wanted, and how much memory it has.
const WATCHED: Duration = Duration::from_millis(10);

/// A batch that is planned and whose folder of results is locked for as long as this lives; the work is done by
/// [`work_for_batch`].
#[derive(Debug)]
pub struct SharedBatch {
    arguments: Arguments,
    /// All their paths are absolute: workers have working folders of their own.
    jobs: Vec<Job>,
    /// Scans and results as they were given.
    names: Vec<(PathBuf, PathBuf)>,
    locked: Locked,
}

/// A scan for a worker.
#[derive(Debug, Serialize, Deserialize)]
struct Task {
    input: PathBuf,
    output: PathBuf,
    pipeline: Value,
    parameters: Value,
    seed: u32,
    folder: PathBuf,
    working: PathBuf,
    overwrite: bool,
}

impl SharedBatch {
    /// Plans what `relievo batch` does with these arguments (without the program's name), makes the folder of results
    /// and locks it.
    ///
    /// # Errors
    /// [`CallError`] as the command gives it: for options that cannot be, two scans with one result, a result that is
    /// there and was not written by a batch, or a folder where another batch is at work.
    pub fn new(arguments: impl IntoIterator<Item = OsString>) -> Result<Self, CallError> {
        let words = ["relievo", "batch"].map(OsString::from);
        let words: Vec<OsString> = words.into_iter().chain(arguments).collect();
        guarded(None, || {
            let matches = (Cli::command().try_get_matches_from(words))
                .map_err(|error| Failure::usage(in_one_sentence(&error)))?;
            let cli = Cli::from_arg_matches(&matches)?;
            let common = Common {
                seed_given: is_given(&matches, "seed"),
                ..cli.common
            };
            let Command::Batch(mut arguments) = cli.command else {
                return Err(Failure::usage("only batch works on many scans"));
            };
            let mut jobs = jobs(&arguments, &common)?;
            let names = jobs
                .iter()
                .map(|job| (job.input.clone(), job.output.clone()));
            let names = names.collect();
            arguments.out = from_root(&arguments.out);
            for job in &mut jobs {
                job.input = from_root(&job.input);
                job.output = from_root(&job.output);
                name_from_root(&mut job.pipeline);
            }
            let locked = locked(&arguments.out)?;
            let files = jobs.iter().flat_map(|job| job.files(&arguments.out));
            let files: Vec<PathBuf> = files.collect();
            leftovers::remove(&files, leftovers::is_gone);
            Ok(Self {
                arguments,
                jobs,
                names,
                locked,
            })
        })
    }

    /// The scans and their results, in order, as they were given.
    pub fn scans(&self) -> impl Iterator<Item = (&Path, &Path)> {
        (self.names.iter()).map(|(input, output)| (input.as_path(), output.as_path()))
    }

    /// What is told of a scan whose results are there, made of the same content with the same options: `None` if it is
    /// to be done, which all are without `--resume`.
    #[must_use]
    pub fn found(&self, job: usize) -> Option<Value> {
        let job = self.jobs.get(job).filter(|_| self.arguments.resume)?;
        let names = job.names(&self.arguments.out);
        let record = names.recorded()?;
        let holds = record.holds(&job.parameters, &names);
        holds.then(|| json!(self.batch().found(job, &names, record)))
    }

    /// What a worker gets to do a scan: text for [`work_for_batch`]; `None` if there is no such scan.
    #[must_use]
    pub fn task(&self, job: usize) -> Option<String> {
        let job = self.jobs.get(job)?;
        let task = Task {
            input: job.input.clone(),
            output: job.output.clone(),
            pipeline: job.pipeline.to_value(),
            parameters: job.parameters.clone(),
            seed: job.seed,
            folder: self.arguments.out.clone(),
            working: self.locked.working.clone(),
            overwrite: self.arguments.overwrite,
        };
        Some(json!(task).to_string())
    }

    fn batch(&self) -> Batch<'_> {
        Batch {
            arguments: &self.arguments,
            working: &self.locked.working,
            threads: 1,
            reports: true,
        }
    }
}

fn from_root(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Makes all paths of a pipeline absolute.
fn name_from_root(pipeline: &mut Pipeline) {
    let definition = definition();
    let files = directions(pipeline);
    for step in &mut pipeline.steps {
        let Some(command) = definition.find_subcommand(&step.kind) else {
            continue;
        };
        let options = Options::of(command);
        for arg in command.get_arguments() {
            let name = options.name_of(arg);
            if let Some(Value::String(path)) = step.options.get_mut(&name)
                && (kind_of(arg) == ValueKind::Path
                    || (name == DIRECTIONS && files.contains(Path::new(path))))
                && path != "-"
                // Nobody can give a path that is no text here.
                && let Some(absolute) = from_root(Path::new(path)).to_str()
            {
                *path = absolute.to_owned();
            }
        }
    }
}

/// The option that may name a file, or something else.
const DIRECTIONS: &str = "orientation";

/// The files that are read by steps with that option, if there are any.
fn directions(pipeline: &Pipeline) -> BTreeSet<PathBuf> {
    let steps = &pipeline.steps;
    if !(steps.iter()).any(|step| step.options.contains_key(DIRECTIONS)) {
        return BTreeSet::new();
    }
    // It was planned, and can be.
    let actions = pipeline.actions().unwrap_or_default();
    (steps.iter().zip(actions))
        .filter(|(step, _)| step.options.contains_key(DIRECTIONS))
        .flat_map(|(_, line)| line.action.reads())
        .collect()
}

/// Does a scan of a [`SharedBatch`] in a process of its own, with so many threads, as long as `is_wanted`, and with no
/// more than `most` bytes of memory, where the system tells; its results are recorded beside them.
///
/// What comes back is a line of `relievo batch` with two members more: `report`, what `relievo run --json` tells, and
/// `may_pass`, whether what went wrong may go well another time.
///
/// # Errors
/// [`CallError`] if `task` is none, or the scan is not wanted any more. What goes wrong with the scan is in the line.
pub fn work_for_batch(
    task: &str,
    threads: usize,
    most: Option<u64>,
    is_wanted: impl Fn() -> bool,
) -> Result<Value, CallError> {
    let (job, task) = guarded(None, || Ok(job_of(task)?))?;
    let arguments = Arguments {
        given: Vec::new(),
        out: task.folder,
        pipeline: None,
        steps: Vec::new(),
        format: None,
        jobs: None,
        resume: false,
        memory: None,
        timeout: None,
        report: None,
        overwrite: task.overwrite,
        dry_run: false,
    };
    let batch = Batch {
        arguments: &arguments,
        working: &task.working,
        threads,
        reports: true,
    };
    let names = job.names(&arguments.out);
    let process = Process::default();
    let since = Instant::now();
    let mut taken = 0;
    let done = std::thread::scope(|scope| {
        let working = scope.spawn(|| batch.done(&job, &names, &process));
        while !working.is_finished() {
            let now = process.memory();
            if !is_wanted() {
                process.stop(Stop::Interrupted);
            } else if most.is_some_and(|most| now > most) {
                taken = now;
                process.stop(Stop::Again);
            }
            std::thread::sleep(WATCHED);
        }
        working.join()
    });
    guarded(None, || {
        let mut line = match done {
            Ok(Ok(line)) => line,
            Ok(Err(Stop::Again)) => Line {
                error: Some(format!(
                    "it had taken {}, more than a thread of the worker may, and was ended: give workers more memory, or the scan smaller tables (--memory)",
                    memory::in_words(taken)
                )),
                ..blank(&job)
            },
            Ok(Err(_)) => return Err(anyhow::anyhow!("the work was ended early").into()),
            Err(panic) => std::panic::resume_unwind(panic),
        };
        line.seconds = since.elapsed().as_secs_f64();
        Ok(told(&line))
    })
}

fn job_of(task: &str) -> anyhow::Result<(Job, Task)> {
    let mut task: Task = serde_json::from_str(task)?;
    let pipeline = Pipeline::from_value(&task.pipeline.take()).map_err(anyhow::Error::msg)?;
    let job = Job {
        input: task.input.clone(),
        output: task.output.clone(),
        pipeline,
        reads: Vec::new(),
        parameters: task.parameters.take(),
        seed: task.seed,
        tables: 0,
    };
    Ok((job, task))
}

fn told(line: &Line) -> Value {
    let mut told = json!(line);
    told["report"] = line.report.clone().into();
    told["may_pass"] = line.may_pass.into();
    told
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_paths_of_a_pipeline_become_absolute_and_nothing_else() {
        let given = json!([
            { "type": "read", "path": "a.ply", "color_image": "sub/a.png" },
            { "type": "complete", "holes": "largest", "report": "a.html" },
            { "type": "stats", "csv": "/figures.csv" },
            { "type": "compare", "other": "b.ply", "part": "completed=0" },
            { "type": "texture", "exemplar": "c.png", "output": "d.ply" },
            { "type": "texture", "tag": "x", "exemplar": "c.png", "orientation": "x", "output": "e.ply" },
            { "type": "texture", "tag": "f", "exemplar": "c.png", "orientation": "g.ply", "output": "f.ply" },
            { "type": "write", "path": "out/a.ply" }
        ]);
        let mut pipeline = Pipeline::from_value(&given).unwrap();
        name_from_root(&mut pipeline);
        let here = std::env::current_dir().unwrap();
        let at = |path: &str| json!(here.join(path));
        let made: Vec<Value> = (pipeline.steps.into_iter())
            .map(|step| step.options.into())
            .collect();
        let expected = [
            json!({ "path": at("a.ply"), "color_image": at("sub/a.png") }),
            json!({ "holes": "largest", "report": at("a.html") }),
            json!({ "csv": from_root(Path::new("/figures.csv")) }),
            json!({ "other": at("b.ply"), "part": "completed=0" }),
            json!({ "exemplar": at("c.png"), "output": at("d.ply") }),
            json!({ "exemplar": at("c.png"), "orientation": "x", "output": at("e.ply") }),
            json!({ "exemplar": at("c.png"), "orientation": at("g.ply"), "output": at("f.ply") }),
            json!({ "path": at("out/a.ply") }),
        ];
        assert_eq!(made, expected);
    }

    #[test]
    fn what_is_no_task_is_an_error() {
        let wrong = work_for_batch("{}", 1, None, || true);
        assert!(wrong.unwrap_err().message.contains("missing field"));
    }
}
