//! Pipelines in a file: what to read, what to do with it, what to write.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::{Args, CommandFactory, Parser, Subcommand};
use serde_json::{Map, Value, json};

use super::held::{KEPT, Writing};
use super::reading::Input;
use super::scan_command::ScanCommand;
use super::step_options::{Options, closest, in_one_sentence, whole};

/// What a step's arguments call the scan that comes from the step before.
pub(super) const CURRENT: &str = "\0current";

/// Steps in their order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pipeline {
    /// Seed of all steps without one of their own.
    pub(super) seed: Option<u32>,
    pub(super) steps: Vec<Step>,
}

/// What a step does, and its options as the file gives them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Step {
    /// `read`, `write`, or the name of a command.
    pub(super) kind: String,
    /// Its name in this pipeline: unlike all others.
    pub(super) tag: String,
    pub(super) options: Map<String, Value>,
}

/// A step as if it were a command line.
#[derive(Debug, Parser)]
#[command(
    name = "step",
    no_binary_name = true,
    disable_help_flag = true,
    disable_help_subcommand = true
)]
pub(super) struct StepLine {
    #[command(subcommand)]
    pub(super) action: Action,
    /// Seed of the step's random choices [default: the pipeline's]
    #[arg(long, global = true, value_name = "N")]
    pub(super) seed: Option<u32>,
}

/// What a step can be.
#[derive(Debug, Subcommand)]
pub(super) enum Action {
    /// Read a scan: what the steps after it work on
    Read(Input),
    /// Write the scan, and go on with it
    Write(WriteArguments),
    #[command(flatten)]
    Command(Box<ScanCommand>),
}

#[derive(Debug, Args)]
pub(super) struct WriteArguments {
    /// Where to: .ply, .obj, .off, .stl or .glb; - for PLY on standard output
    #[arg(long, value_name = "FILE")]
    pub(super) path: PathBuf,
    #[command(flatten)]
    pub(super) writing: Writing,
}

/// The definition of all steps, options that they have in common among those of each.
pub(super) fn definition() -> clap::Command {
    let mut definition = StepLine::command();
    definition.build();
    definition
}

impl Pipeline {
    /// Reads a pipeline's JSON: an object with `pipeline` (a list of steps) and perhaps `seed`, a bare list, or what
    /// a command has written with `--json`.
    ///
    /// # Errors
    /// A sentence that names the step.
    pub(super) fn from_json(text: &str) -> Result<Self, String> {
        let value: Value =
            serde_json::from_str(text).map_err(|error| format!("this is no JSON: {error}"))?;
        Self::from_value(&value)
    }

    /// The same of JSON that is read already.
    pub(super) fn from_value(value: &Value) -> Result<Self, String> {
        let expected = "a pipeline is an object with a list of steps, as in {\"pipeline\": [\"scan.ply\", {\"type\": \"complete\"}, \"completed.ply\"]}";
        // The result of a command holds the pipeline that repeats it.
        let value = match value.get("pipeline") {
            Some(inner) if inner.is_object() => inner,
            _ => value,
        };
        let (steps, seed) = match value {
            Value::Array(steps) => (steps, None),
            Value::Object(members) => {
                let known = ["pipeline", "seed", "relievo"];
                if let Some(name) = members.keys().find(|name| !known.contains(&name.as_str())) {
                    return Err(format!("unknown member `{name}`: {expected}"));
                }
                let seed = match members.get("seed") {
                    None | Some(Value::Null) => None,
                    Some(seed) => Some(
                        whole(seed)
                            .and_then(|seed| u32::try_from(seed).ok())
                            .ok_or_else(|| {
                                format!("`seed`: expected a whole number from 0 to 4294967295, not {seed}")
                            })?,
                    ),
                };
                match members.get("pipeline") {
                    Some(Value::Array(steps)) => (steps, seed),
                    _ => return Err(expected.to_owned()),
                }
            }
            _ => return Err(expected.to_owned()),
        };
        let mut pipeline = Self {
            seed,
            steps: Vec::new(),
        };
        for (index, step) in steps.iter().enumerate() {
            let step = Step::from_value(step, index, steps.len())
                .map_err(|what| format!("step {}: {what}", index + 1))?;
            pipeline.steps.push(step);
        }
        pipeline.name_steps()?;
        Ok(pipeline)
    }

    /// Gives each step a tag unlike all others.
    fn name_steps(&mut self) -> Result<(), String> {
        let mut taken = BTreeSet::new();
        for (index, step) in self.steps.iter().enumerate() {
            if !step.tag.is_empty() && !taken.insert(step.tag.clone()) {
                return Err(format!(
                    "step {}: there is a step with the tag `{}` already: give it another one",
                    index + 1,
                    step.tag
                ));
            }
        }
        for step in self.steps.iter_mut().filter(|step| step.tag.is_empty()) {
            let tags = std::iter::once(step.kind.clone())
                .chain((2..).map(|number| format!("{}_{number}", step.kind)));
            step.tag = (tags.into_iter())
                .find(|tag| taken.insert(tag.clone()))
                .unwrap_or_default();
        }
        Ok(())
    }

    /// Sets an option of a step, given as `TAG.OPTION=VALUE`, or `TAG.OPTION` for what needs no value.
    ///
    /// # Errors
    /// A sentence that says what is expected.
    pub(super) fn set(&mut self, text: &str) -> Result<(), String> {
        let (place, value) = match text.split_once('=') {
            Some((place, value)) => (place, of_text(value)),
            None => (text, Value::Bool(true)),
        };
        let expected = || {
            format!(
                "--step.{text}: expected the tag and the option of a step, as in --step.complete.window=4"
            )
        };
        let (tag, option) = place.rsplit_once('.').ok_or_else(expected)?;
        if tag.is_empty() || option.is_empty() {
            return Err(expected());
        }
        let tags: Vec<String> = self.steps.iter().map(|step| step.tag.clone()).collect();
        let Some(step) = self.steps.iter_mut().find(|step| step.tag == tag) else {
            let tags = tags.iter().map(String::as_str);
            return Err(match closest(tag, tags.clone()) {
                Some(meant) => {
                    format!("--step.{text}: no step has the tag `{tag}`: did you mean `{meant}`?")
                }
                None => format!(
                    "--step.{text}: no step has the tag `{tag}`: there are {}",
                    tags.collect::<Vec<_>>().join(", ")
                ),
            });
        };
        step.options.insert(option.replace('-', "_"), value);
        Ok(())
    }

    /// The actions of all steps, their options read.
    ///
    /// # Errors
    /// A sentence that names the step.
    pub(super) fn actions(&self) -> Result<Vec<StepLine>, String> {
        let definition = definition();
        let mut actions: Vec<StepLine> = Vec::new();
        let mut has_scan = false;
        for (index, step) in self.steps.iter().enumerate() {
            let called = step.called(index);
            let action = step
                .action(&definition)
                .map_err(|what| format!("{called}: {what}"))?;
            let reads = matches!(action.action, Action::Read(_));
            if !reads && !has_scan {
                return Err(format!(
                    "{called}: there is no scan yet: begin with the path of one, or with {{\"type\": \"read\", \"path\": …}}"
                ));
            }
            has_scan |= reads;
            actions.push(action);
        }
        if !has_scan {
            return Err("there are no steps: begin with the path of a scan".to_owned());
        }
        self.check_files(&actions)?;
        Ok(actions)
    }

    /// The pipeline with everything said that may be left out.
    pub(super) fn to_value(&self) -> Value {
        let steps: Vec<Value> = self.steps.iter().map(Step::to_value).collect();
        json!({
            "relievo": env!("CARGO_PKG_VERSION"),
            "seed": self.seed.unwrap_or(0),
            "pipeline": steps,
        })
    }
}

/// A value of a text on the command line: as it is, but for what would have no meaning as text.
fn of_text(text: &str) -> Value {
    match text {
        "true" => Value::Bool(true),
        "false" => Value::Bool(false),
        "null" => Value::Null,
        _ => match serde_json::from_str(text) {
            Ok(list @ Value::Array(_)) => list,
            _ => Value::String(text.to_owned()),
        },
    }
}

impl Step {
    fn from_value(value: &Value, index: usize, count: usize) -> Result<Self, String> {
        let mut members = match value {
            Value::String(path) => {
                let kind = if index == 0 {
                    "read"
                } else if index + 1 == count {
                    "write"
                } else {
                    return Err(
                        "only the first and the last step may be a path: give it a type".to_owned(),
                    );
                };
                let mut members = Map::new();
                members.insert("type".into(), json!(kind));
                members.insert("path".into(), json!(path));
                members
            }
            Value::Object(members) => members.clone(),
            _ => return Err("expected a path, or an object with a type".to_owned()),
        };
        let kind = match members.remove("type") {
            Some(Value::String(kind)) => kind,
            Some(other) => return Err(format!("`type`: expected a name, not {other}")),
            None => {
                return Err("it has no `type`: give one, as in {\"type\": \"complete\"}".to_owned());
            }
        };
        let tag = match members.remove("tag") {
            None => String::new(),
            Some(Value::String(tag)) if !tag.is_empty() && !tag.contains(['.', '=']) => tag,
            Some(other) => {
                return Err(format!(
                    "`tag`: expected a name without dots and equals signs, not {other}"
                ));
            }
        };
        let options = (members.into_iter())
            .map(|(name, value)| (name.replace('-', "_"), value))
            .collect();
        Ok(Self { kind, tag, options })
    }

    fn to_value(&self) -> Value {
        let mut members = Map::new();
        members.insert("type".into(), json!(self.kind));
        if self.tag != self.kind {
            members.insert("tag".into(), json!(self.tag));
        }
        members.extend(self.options.clone());
        Value::Object(members)
    }

    /// What messages call the step at a place.
    pub(super) fn called(&self, index: usize) -> String {
        format!("step {} ({})", index + 1, self.tag)
    }

    fn action(&self, definition: &clap::Command) -> Result<StepLine, String> {
        let commands = || definition.get_subcommands().map(clap::Command::get_name);
        let Some(command) = definition.find_subcommand(&self.kind) else {
            return Err(match closest(&self.kind, commands()) {
                Some(meant) => format!(
                    "there is no step of type `{}`: did you mean `{meant}`?",
                    self.kind
                ),
                None => format!(
                    "there is no step of type `{}`: there are {}",
                    self.kind,
                    commands().collect::<Vec<_>>().join(", ")
                ),
            });
        };
        let given = |name: &str| self.options.get(name).is_some_and(|value| !value.is_null());
        let keeps = ["complete", "texture", "transfer"].contains(&self.kind.as_str());
        let mut more = Vec::new();
        if keeps && !given("output") {
            more.push(format!("--output={KEPT}"));
        }
        let scan = match self.kind.as_str() {
            "read" | "write" => None,
            "transfer" if given("mask") => {
                more.push(format!("--source={CURRENT}"));
                None
            }
            "transfer" => {
                more.push(format!("--target={CURRENT}"));
                None
            }
            _ => Some(CURRENT),
        };
        let mut words = Options::of(command).arguments(&self.options, scan, false)?;
        words.splice(1..1, more.into_iter().map(Into::into));
        StepLine::try_parse_from(words).map_err(|error| in_one_sentence(&error))
    }
}
