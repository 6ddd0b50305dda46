//! `relievo run`

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, anyhow};
use clap::Args;
use serde_json::{Map, Value, json};

use crate::scan::{OutputFile, Scan, ScanError};

use super::held::{Content, Held, Kept, ScanOutput, Slot};
use super::messages::Bar;
use super::outcome::{Failure, Reply};
use super::pipeline::{Action, CURRENT, Pipeline, StepLine, WriteArguments};
use super::reading::Input;
use super::{Common, arguments};

/// Shown below the options.
const USES: &str = "\
A pipeline is a list of steps; paths stand for reading and writing:
  {\"pipeline\": [
    \"scan.ply\",
    {\"type\": \"complete\", \"holes\": \"largest\"},
    {\"type\": \"stats\", \"csv\": \"figures.csv\"},
    {\"type\": \"render\", \"output\": \"completed.png\", \"look_at\": \"completed\"},
    \"completed.ply\"
  ]}
Steps are read, write, compare, complete, fit, holes, info, render, stats, texture and transfer; \
their options are those of the commands, with _ for -. `relievo schema` tells all of them. \
What any of these commands writes with --json can be run again.";

#[derive(Debug, Args)]
#[command(after_help = USES)]
pub(super) struct Arguments {
    /// The pipeline: JSON
    #[arg(
        value_name = "PIPELINE.json",
        required_unless_present = "stdin",
        conflicts_with = "stdin"
    )]
    pub(super) pipeline: Option<PathBuf>,
    /// Read the pipeline from standard input
    #[arg(long)]
    stdin: bool,
    /// Only say whether the pipeline can be understood; no scan is read
    #[arg(long)]
    validate: bool,
    /// Another value for an option of the step TAG, whose tag is its type if it has no other; also written
    /// --step.TAG.OPTION=VALUE
    #[arg(long = "step", value_name = "TAG.OPTION=VALUE")]
    steps: Vec<String>,
}

/// `--step.TAG.OPTION=VALUE` as the parser knows it.
pub(super) fn in_one_word(argument: std::ffi::OsString) -> std::ffi::OsString {
    match argument
        .to_str()
        .and_then(|text| text.strip_prefix("--step."))
    {
        Some(rest) => format!("--step={rest}").into(),
        None => argument,
    }
}

/// A pipeline that was read and checked; nothing is done yet.
#[derive(Debug)]
pub(super) struct Plan {
    /// Where it comes from, for messages.
    name: String,
    pipeline: Pipeline,
    actions: Vec<StepLine>,
    /// Whether that is all that is wanted.
    validate: bool,
}

pub(super) fn plan(arguments: &Arguments, common: &Common) -> Result<Plan, Failure> {
    let name = match &arguments.pipeline {
        Some(path) if path != Path::new("-") => path.display().to_string(),
        _ => "standard input".to_owned(),
    };
    let wrong = |what: String| Failure::usage(format!("{name}: {what}"));
    let mut pipeline = Pipeline::from_json(&arguments.text(&name)?).map_err(wrong)?;
    for text in &arguments.steps {
        pipeline.set(text).map_err(Failure::usage)?;
    }
    if common.seed_given {
        pipeline.seed = Some(common.seed);
    }
    let actions = pipeline.actions().map_err(wrong)?;
    Ok(Plan {
        name,
        pipeline,
        actions,
        validate: arguments.validate,
    })
}

impl Plan {
    pub(super) fn reads(&self) -> Vec<PathBuf> {
        let actions = self.actions.iter();
        actions.flat_map(|line| line.action.reads()).collect()
    }

    pub(super) fn writes(&self) -> Vec<PathBuf> {
        self.pipeline.outputs()
    }

    pub(super) fn run(self, common: &Common) -> super::Result {
        if self.validate {
            let mut json = Map::new();
            json.insert("pipeline".into(), self.pipeline.to_value());
            return Ok(Reply {
                text: format!(
                    "{}: {} steps, nothing wrong\n",
                    self.name,
                    self.actions.len()
                ),
                json,
                partly: false,
            });
        }
        all(&self.pipeline, self.actions, common).map(|(reply, _)| reply)
    }
}

impl Arguments {
    fn text(&self, name: &str) -> Result<String, Failure> {
        let read = match &self.pipeline {
            Some(path) if path != Path::new("-") => std::fs::read(path),
            _ => {
                let mut bytes = Vec::new();
                std::io::stdin().read_to_end(&mut bytes).map(|_| bytes)
            }
        };
        let bytes = read.with_context(|| name.to_owned())?;
        Ok(String::from_utf8(bytes).map_err(|_| anyhow!("{name}: this is no text"))?)
    }
}

/// Does all steps; gives the scan that there is at the end, too.
pub(super) fn all(
    pipeline: &Pipeline,
    actions: Vec<StepLine>,
    common: &Common,
) -> Result<(Reply, Option<Arc<Scan>>), Failure> {
    let mut run = Run::new(pipeline, &actions)?;
    let mut told = Vec::new();
    let mut reply = Reply::default();
    let to_stdout = (pipeline.outputs().iter()).any(|path| path == Path::new("-"));
    for (index, (step, line)) in pipeline.steps.iter().zip(actions).enumerate() {
        let since = Instant::now();
        let common = Common {
            seed: line.seed.or(pipeline.seed).unwrap_or(0),
            ..common.clone()
        };
        let mut about = Map::new();
        about.insert("type".into(), json!(step.kind));
        about.insert("tag".into(), json!(step.tag));
        let done = run.step(index, line.action, &common);
        about.insert("seconds".into(), json!(since.elapsed().as_secs_f64()));
        match done {
            Ok(done) => {
                let status = if done.partly { "partly" } else { "done" };
                about.insert("status".into(), json!(status));
                about.extend(done.json);
                told.push(Value::Object(about));
                reply.partly |= done.partly;
                if !done.text.is_empty() && !to_stdout {
                    reply
                        .text
                        .push_str(&format!("{}:\n{}\n", step.tag, done.text));
                }
            }
            Err(failure) => {
                about.insert("status".into(), json!("failed"));
                about.extend(failure.json);
                told.push(Value::Object(about));
                return Err(Failure {
                    usage: failure.usage,
                    error: failure.error.context(step.called(index)),
                    json: members(pipeline, told),
                });
            }
        }
    }
    reply.json = members(pipeline, told);
    let last = match run.current.map(|held| held.content) {
        Some(Content::Scan(scan)) => Some(scan),
        _ => None,
    };
    Ok((reply, last))
}

fn members(pipeline: &Pipeline, steps: Vec<Value>) -> Map<String, Value> {
    let mut json = Map::new();
    json.insert("pipeline".into(), pipeline.to_value());
    json.insert("steps".into(), Value::Array(steps));
    json
}

/// A pipeline at work.
struct Run {
    /// What the next step gets.
    current: Option<Held>,
    /// By step: what it will write, opened before the work.
    outputs: Vec<Option<ScanOutput>>,
    /// All files that are read.
    reads: Vec<PathBuf>,
}

impl Run {
    fn new(pipeline: &Pipeline, actions: &[StepLine]) -> Result<Self, Failure> {
        let mut outputs = Vec::new();
        for (index, (step, line)) in pipeline.steps.iter().zip(actions).enumerate() {
            let opened = match &line.action {
                Action::Write(write) => open(write).map(Some),
                action => check_folders(&step.writes(action)).map(|()| None),
            };
            outputs.push(opened.map_err(|failure| Failure {
                error: failure.error.context(step.called(index)),
                ..failure
            })?);
        }
        Ok(Self {
            current: None,
            outputs,
            reads: (actions.iter())
                .flat_map(|line| line.action.reads())
                .collect(),
        })
    }

    fn step(&mut self, index: usize, action: Action, common: &Common) -> super::Result {
        match action {
            Action::Read(input) => self.read(&input, common),
            Action::Write(write) => self.write(index, &write, common),
            Action::Command(mut command) => {
                let current = self.current()?.clone();
                command.hold(CURRENT, current);
                let slot = command.keep();
                let reply = command.run(common)?;
                self.take(slot.as_ref());
                Ok(reply)
            }
        }
    }

    fn current(&self) -> Result<&Held, Failure> {
        // The pipeline was checked: it begins with reading.
        (self.current.as_ref()).ok_or_else(|| Failure::usage("there is no scan yet"))
    }

    fn read(&mut self, input: &Input, common: &Common) -> super::Result {
        let bar = Bar::doing(common, "reading");
        let scan = input.scan()?;
        drop(bar);
        let mut json = Map::new();
        json.insert("path".into(), json!(input.name()));
        json.insert("vertices".into(), json!(scan.vertices.rows));
        json.insert("faces".into(), json!(scan.faces.len()));
        let is_file =
            input.path != Path::new("-") && input.reading.shelf.get(&input.path).is_none();
        self.current = Some(Held {
            name: input.name(),
            content: Content::Scan(Arc::new(scan)),
            origin: is_file.then(|| (input.path.clone(), input.reading.options())),
            files: self.reads.clone(),
        });
        Ok(Reply {
            json,
            ..Reply::default()
        })
    }

    fn write(&mut self, index: usize, write: &WriteArguments, common: &Common) -> super::Result {
        let scan = self.current()?.scan()?;
        let bar = Bar::doing(common, "writing");
        let mut json = Map::new();
        json.insert("path".into(), json!(write.path.to_string_lossy()));
        json.insert("vertices".into(), json!(scan.vertices.rows));
        json.insert("faces".into(), json!(scan.faces.len()));
        if let Some(output) = self.outputs.get_mut(index).and_then(Option::take) {
            output.write(scan)?;
        }
        drop(bar);
        Ok(Reply {
            json,
            ..Reply::default()
        })
    }

    /// What a step has made is what the next one gets.
    fn take(&mut self, slot: Option<&Slot>) {
        let Some(Kept::Scan(scan)) = slot.and_then(Slot::take) else {
            return;
        };
        if let Some(current) = &mut self.current {
            current.content = Content::Scan(scan);
            current.origin = None;
        }
    }
}

fn open(write: &WriteArguments) -> Result<ScanOutput, Failure> {
    let format = arguments::output_format(&write.path)?;
    // Whether it is read by a step was checked before.
    let file = OutputFile::create(&write.path, None)?;
    Ok(ScanOutput::new(Some((file, format)), &write.writing))
}

/// That there are the folders to write to is noticed before the work.
fn check_folders(writes: &[(PathBuf, bool)]) -> Result<(), Failure> {
    for (path, _) in writes.iter().filter(|(path, _)| path != Path::new("-")) {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(ScanError::NoFolder {
                name: path.display().to_string(),
                folder: folder.display().to_string(),
            }
            .into());
        }
    }
    Ok(())
}
