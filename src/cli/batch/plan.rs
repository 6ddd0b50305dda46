//! What is to be done: each scan with its pipeline and its result, checked before anything is done.

use std::path::{Component, Path, PathBuf};

use crate::scan::{Format, same_file};
use anyhow::Context;
use serde_json::{Value, json};

use super::super::Common;
use super::super::arguments::output_format;
use super::super::outcome::Failure;
use super::super::pipeline::Pipeline;
use super::Arguments;
use super::clashes;
use super::given::{Given, scans};
use super::recipe::Recipe;
use super::record::Names;

/// Processes of scans have them for what they are told and what they answer.
const NO_STREAMS: &str = "a batch has no standard input or output for scans: give files";

/// A scan and what is done to it.
#[derive(Debug)]
pub(super) struct Job {
    pub(super) input: PathBuf,
    pub(super) output: PathBuf,
    pub(super) pipeline: Pipeline,
    /// What its steps read beside the scan.
    pub(super) reads: Vec<PathBuf>,
    /// What is done, without names.
    pub(super) parameters: Value,
    pub(super) seed: u32,
    /// What tables may take, in bytes.
    pub(super) tables: u64,
}

impl Job {
    /// The names that are left out of its record.
    pub(super) fn names<'a>(&'a self, folder: &'a Path) -> Names<'a> {
        Names {
            input: &self.input,
            output: &self.output,
            folder,
        }
    }

    /// What its pipeline says that it writes.
    pub(super) fn outputs(&self) -> Vec<PathBuf> {
        self.pipeline.outputs()
    }

    /// For whoever does it elsewhere.
    pub(super) fn to_value(&self) -> Value {
        json!({
            "input": self.input.to_string_lossy(),
            "output": self.output.to_string_lossy(),
            "pipeline": self.pipeline.to_value(),
        })
    }

    /// The same, and what is kept of it.
    pub(super) fn files(&self, folder: &Path) -> Vec<PathBuf> {
        let mut files = self.outputs();
        files.extend(self.names(folder).files());
        files
    }
}

/// All jobs, in order.
pub(super) fn jobs(arguments: &Arguments, common: &Common) -> Result<Vec<Job>, Failure> {
    let for_all = recipe_for_all(arguments)?;
    let mut jobs = Vec::new();
    let mut last: Option<(Recipe, Vec<PathBuf>)> = None;
    for given in scans(&arguments.given, &arguments.out)? {
        let name = given.input.display().to_string();
        let wrong = |what: String| Failure::usage(format!("{name}: {what}"));
        let mut recipe = given.recipe.clone().unwrap_or_else(|| for_all.clone());
        for text in &arguments.steps {
            recipe.set_text(text).map_err(wrong)?;
        }
        recipe.set(&given.options).map_err(wrong)?;
        if common.seed_given {
            recipe.set_seed(common.seed);
        }
        if is_stream(&given.input) {
            return Err(wrong(NO_STREAMS.to_owned()));
        }
        let output = arguments
            .out
            .join(below(&given, arguments.format.as_deref())?);
        let [from, to] = [&given.input, &output].map(|path| path.to_str());
        let (Some(from), Some(to)) = (from, to) else {
            return Err(wrong("its name is not valid Unicode: rename it".to_owned()));
        };
        if same_file(&given.input, &output) {
            return Err(clashes::over(&output, &given.input, "a scan of"));
        }
        let pipeline = recipe.pipeline(from, to);
        let reads = match &last {
            // What holds for one scan holds for all with the same options.
            Some((other, reads)) if *other == recipe && !recipe.reads_by_name() => reads.clone(),
            _ => reads(&pipeline).map_err(wrong)?,
        };
        last = Some((recipe.clone(), reads.clone()));
        jobs.push(Job {
            parameters: recipe.parameters(&given.input, &output),
            seed: recipe.seed(),
            tables: recipe.tables(),
            pipeline,
            reads,
            input: given.input,
            output,
        });
    }
    clashes::check(&jobs, arguments)?;
    Ok(jobs)
}

fn is_stream(path: &Path) -> bool {
    ["-", "/dev/stdin", "/dev/stdout", "/dev/stderr"]
        .iter()
        .any(|stream| path == Path::new(stream))
        || path.starts_with("/dev/fd")
}

/// What steps read beside the scan; an error if they cannot be understood, or want standard input or output.
fn reads(pipeline: &Pipeline) -> Result<Vec<PathBuf>, String> {
    let actions = pipeline.actions()?;
    let inputs = actions.iter().flat_map(|line| line.action.inputs());
    if inputs
        .chain(pipeline.outputs())
        .any(|path| is_stream(&path))
    {
        return Err(NO_STREAMS.to_owned());
    }
    let scan = pipeline
        .steps
        .first()
        .and_then(|step| step.options.get("path"));
    let mut reads: Vec<PathBuf> = (actions.iter())
        .flat_map(|line| line.action.reads())
        .collect();
    if let Some(scan) = scan.and_then(Value::as_str) {
        reads.retain(|path| path != Path::new(scan));
    }
    Ok(reads)
}

fn recipe_for_all(arguments: &Arguments) -> Result<Recipe, Failure> {
    let Some(path) = &arguments.pipeline else {
        return Recipe::completing().map_err(Failure::usage);
    };
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| name.clone())?;
    let value: Result<Value, String> =
        serde_json::from_str(&text).map_err(|error| format!("this is no JSON: {error}"));
    (value.and_then(|value| Recipe::of_pipeline(&value)))
        .map_err(|what| Failure::usage(format!("{name}: {what}")))
}

/// The result's path below the folder of results.
fn below(given: &Given, format: Option<&str>) -> Result<PathBuf, Failure> {
    let normal = |part: &Component| matches!(part, Component::Normal(_));
    let mut below: PathBuf = given.below.components().filter(normal).collect();
    if given.named {
        output_format(&below)?;
    } else if let Some(format) = format {
        below.set_extension(format);
    } else {
        let kept = Format::of_path(&below).is_ok_and(Format::can_be_written)
            && below
                .extension()
                .is_some_and(|extension| !extension.eq_ignore_ascii_case("gltf"));
        if !kept {
            below.set_extension("ply");
        }
    }
    Ok(below)
}
