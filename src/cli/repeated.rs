//! A command line as the pipeline that does the same again.

use clap::ArgMatches;
use clap::parser::ValueSource;
use serde_json::{Map, Value, json};

use super::pipeline::{Pipeline, Step, definition};
use super::step_options::Options;

/// Options that say how the file of a scan is read.
const OF_READING: [&str; 3] = ["columns", "intrinsics", "color_image"];

/// Options that say how a scan is written.
const OF_WRITING: [&str; 3] = ["output", "ascii", "overwrite"];

/// The pipeline; `None` for commands that are no steps, and for what is no scan.
pub(super) fn repeated(matches: &ArgMatches, seed: u32) -> Option<Value> {
    let (kind, of_command) = matches.subcommand()?;
    let definition = definition();
    let command = definition.find_subcommand(kind)?;
    if of_command.try_get_raw("step").ok().flatten().is_some() {
        return None;
    }
    let mut options = Options::of(command).given(of_command);
    // It is the whole pipeline's.
    options.remove("seed");
    // Of a mask's two names for one mesh one is enough.
    let path = |id: &str| {
        let raw = of_command.try_get_raw(id).ok().flatten()?.next()?;
        Some(raw.to_string_lossy().into_owned())
    };
    let read_from = if kind == "transfer" {
        let source = path("source");
        if options.contains_key("mask") {
            options.remove("source");
            source
        } else {
            path("target")
        }
    } else {
        path("scan")
    };
    let mut read = Map::new();
    read.insert("path".into(), json!(read_from?));
    for name in OF_READING {
        if let Some(value) = options.get(name) {
            read.insert(name.into(), value.clone());
        }
    }
    // These read other files in the same way.
    if !["compare", "texture", "transfer"].contains(&kind) {
        options.retain(|name, _| !OF_READING.contains(&name.as_str()));
    }
    let mut steps = vec![step("read", read)];
    let mut write = Map::new();
    // The others may write images beside the scan, or pictures.
    if kind == "complete" {
        for name in OF_WRITING {
            if let Some(value) = options.remove(name) {
                let name = if name == "output" { "path" } else { name };
                write.insert(name.into(), value);
            }
        }
    }
    steps.push(step(kind, options));
    if !write.is_empty() {
        steps.push(step("write", write));
    }
    let pipeline = Pipeline {
        seed: Some(seed),
        steps,
    };
    Some(pipeline.to_value())
}

fn step(kind: &str, options: Map<String, Value>) -> Step {
    Step {
        kind: kind.to_owned(),
        tag: kind.to_owned(),
        options,
    }
}

/// Whether an option of every command was given.
pub(super) fn is_given(matches: &ArgMatches, id: &str) -> bool {
    let of = |matches: &ArgMatches| matches.value_source(id) == Some(ValueSource::CommandLine);
    of(matches) || matches.subcommand().is_some_and(|(_, matches)| of(matches))
}
