//! `relievo schema`: the JSON schema of pipelines.

use clap::{Arg, Command};
use serde_json::{Map, Value, json};

use super::outcome::Reply;
use super::pipeline::definition;
use super::step_options::{Options, ValueKind, kind_of, may_be_bare};

#[expect(
    clippy::unnecessary_wraps,
    reason = "what every command gives back; this one cannot fail"
)]
pub(super) fn run() -> super::Result {
    let schema = schema();
    Ok(Reply {
        text: format!("{schema:#}\n"),
        json: match schema {
            Value::Object(members) => members,
            _ => Map::new(),
        },
        partly: false,
    })
}

/// The JSON schema (draft 2020-12) of pipelines: each type of step with its options, their types, defaults and what
/// they mean.
#[must_use]
pub fn schema() -> Value {
    let definition = definition();
    let mut kinds = Map::new();
    for command in definition.get_subcommands() {
        kinds.insert(command.get_name().to_owned(), of_step(command));
    }
    let references: Vec<Value> = (kinds.keys())
        .map(|kind| json!({ "$ref": format!("#/$defs/{kind}") }))
        .collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "relievo pipeline",
        "description": "What to read, what to do with it, what to write. A path stands for reading in the first place, for writing in the last.",
        "type": "object",
        "required": ["pipeline"],
        "additionalProperties": false,
        "properties": {
            "relievo": {
                "type": "string",
                "description": "Version of the program that wrote the pipeline",
            },
            "seed": {
                "type": ["integer", "null"],
                "minimum": 0,
                "maximum": u32::MAX,
                "default": 0,
                "description": "Seed of all random choices: the same seed gives the same bytes",
            },
            "pipeline": {
                "type": "array",
                "minItems": 1,
                "items": { "anyOf": [{ "type": "string" }, { "oneOf": references }] },
            },
        },
        "$defs": kinds,
    })
}

fn of_step(command: &Command) -> Value {
    let mut properties = Map::new();
    properties.insert("type".into(), json!({ "const": command.get_name() }));
    properties.insert(
        "tag".into(),
        json!({
            "type": "string",
            "pattern": "^[^.=]+$",
            "description": "Name of the step in this pipeline, for --step.TAG.OPTION=VALUE [default: its type]",
        }),
    );
    let mut required = vec![json!("type")];
    let options = Options::of(command);
    for arg in options.of_steps() {
        let name = options.name_of(arg);
        // A mask takes the place of a source; what is written nowhere goes on to the next step.
        let has_substitute =
            name == "source" || (name == "output" && command.get_name() != "render");
        let mut option = of_option(arg);
        if arg.is_required_set() && !has_substitute {
            required.push(json!(name));
        } else {
            allow_null(&mut option);
        }
        properties.insert(name, option);
    }
    json!({
        "description": command.get_about().map(ToString::to_string),
        "type": "object",
        "required": required,
        "additionalProperties": false,
        "properties": properties,
    })
}

fn of_option(arg: &Arg) -> Value {
    let kind = kind_of(arg);
    let values: Vec<Value> = (arg.get_possible_values().iter())
        .map(|value| json!(value.get_name()))
        .collect();
    let mut schema = match kind {
        ValueKind::Flag | ValueKind::YesOrNo => json!({ "type": "boolean" }),
        ValueKind::Number => json!({ "type": "number" }),
        ValueKind::Integer => json!({ "type": "integer", "minimum": 0 }),
        ValueKind::Path => json!({ "type": "string" }),
        ValueKind::Text if !values.is_empty() => json!({ "enum": values }),
        ValueKind::Text if may_be_bare(arg) => json!({ "type": ["string", "array", "boolean"] }),
        ValueKind::Text => json!({ "type": ["string", "number", "array"] }),
    };
    if let Value::Object(members) = &mut schema {
        if let Some(help) = arg.get_help() {
            members.insert("description".into(), json!(help.to_string()));
        }
        let default = arg.get_default_values().first();
        if let Some(text) = default.and_then(|value| value.to_str()) {
            members.insert("default".into(), default_of(kind, text));
        } else if kind == ValueKind::Flag {
            members.insert("default".into(), json!(false));
        }
    }
    schema
}

/// What need not be given may be given as null.
fn allow_null(option: &mut Value) {
    if let Some(Value::Array(values)) = option.get_mut("enum") {
        values.push(Value::Null);
    }
    match option.get_mut("type") {
        Some(Value::Array(kinds)) => kinds.push(json!("null")),
        Some(kind) => *kind = json!([kind, "null"]),
        None => {}
    }
}

fn default_of(kind: ValueKind, text: &str) -> Value {
    match kind {
        ValueKind::Number | ValueKind::Integer => {
            (text.parse::<serde_json::Number>()).map_or_else(|_| json!(text), Value::Number)
        }
        ValueKind::Flag | ValueKind::YesOrNo => json!(text == "true" || text == "yes"),
        ValueKind::Path | ValueKind::Text => json!(text),
    }
}
