//! Options of commands as JSON: from members to arguments and back. What there is, what values it takes and what they
//! mean is told by the definition of the command line alone.

use std::any::TypeId;
use std::ffi::OsString;
use std::path::PathBuf;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command};
use serde_json::{Map, Value, json};

use super::height_map::OF_MAPS;

/// Options that a step has not: it has its input from the step before, and its results belong to the whole.
const NOT_OF_STEPS: [&str; 8] = [
    "help", "version", "json", "threads", "quiet", "verbose", "scan", "target",
];

/// Names more than this apart (1 is the same) are no slips of the pen.
const ALIKE: f64 = 0.7;

/// The options of one command.
pub(super) struct Options<'a> {
    command: &'a Command,
}

/// What a value may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ValueKind {
    /// There or not.
    Flag,
    /// `yes` or `no`.
    YesOrNo,
    Number,
    Integer,
    /// A file's name.
    Path,
    /// Anything that the command reads out of a text.
    Text,
}

impl<'a> Options<'a> {
    pub(super) fn of(command: &'a Command) -> Self {
        Self { command }
    }

    /// Those that a step of a pipeline may give, in the order of the help.
    pub(super) fn of_steps(&self) -> impl Iterator<Item = &'a Arg> + use<'a> {
        let reads = self.command.get_name() == "read";
        self.command.get_arguments().filter(move |arg| {
            let id = arg.get_id().as_str();
            (!NOT_OF_STEPS.contains(&id) || (reads && id == "scan")) && !OF_MAPS.contains(&id)
        })
    }

    /// The arguments that give these options, in their order, and `scan` in the first place if there is one. `all`
    /// allows those that a step may not give.
    ///
    /// # Errors
    /// A sentence about the first that cannot be.
    pub(super) fn arguments(
        &self,
        options: &Map<String, Value>,
        scan: Option<&str>,
        all: bool,
    ) -> Result<Vec<OsString>, String> {
        let known: Vec<&Arg> = if all {
            self.command.get_arguments().collect()
        } else {
            self.of_steps().collect()
        };
        let mut words = vec![OsString::from(self.command.get_name())];
        let mut places: Vec<_> = (scan.into_iter())
            .map(|scan| (Some(1), scan.to_owned()))
            .collect();
        for (name, value) in options {
            let arg = (known.iter())
                .find(|arg| self.name_of(arg) == name.replace('-', "_"))
                .ok_or_else(|| self.unknown(name, &known))?;
            let Some(word) =
                word(arg, value).map_err(|expected| format!("`{name}`: {expected}"))?
            else {
                continue;
            };
            match (arg.is_positional(), word) {
                (true, Word::Value(text)) => places.push((arg.get_index(), text)),
                (_, Word::Bare) => words.push(format!("--{}", long(arg)).into()),
                (_, Word::Value(text)) => words.push(format!("--{}={text}", long(arg)).into()),
            }
        }
        if !places.is_empty() {
            places.sort();
            words.push("--".into());
            words.extend(places.into_iter().map(|(_, text)| text.into()));
        }
        Ok(words)
    }

    fn unknown(&self, name: &str, known: &[&Arg]) -> String {
        let command = self.command.get_name();
        let names: Vec<String> = known.iter().map(|arg| self.name_of(arg)).collect();
        match closest(name, names.iter().map(String::as_str)) {
            Some(meant) => format!("{command} has no option `{name}`: did you mean `{meant}`?"),
            None => format!(
                "{command} has no option `{name}`: it has {}",
                names.join(", ")
            ),
        }
    }

    /// The options that a command line gave or left at their defaults, as a step gives them.
    pub(super) fn given(&self, matches: &ArgMatches) -> Map<String, Value> {
        let is_given = |arg: &Arg| {
            let source = matches.value_source(arg.get_id().as_str());
            source.is_some_and(|source| source != ValueSource::DefaultValue)
        };
        let given: Vec<&Arg> = self.of_steps().filter(|arg| is_given(arg)).collect();
        // Defaults that are said are as good as given: not beside what excludes them.
        let excludes = |one: &Arg, other: &Arg| {
            let conflicts = self.command.get_arg_conflicts_with(one);
            conflicts.iter().any(|arg| arg.get_id() == other.get_id())
        };
        let is_excluded = |arg: &Arg| {
            !is_given(arg) && (given.iter()).any(|one| excludes(one, arg) || excludes(arg, one))
        };
        self.of_steps()
            .filter(|arg| !is_excluded(arg))
            .filter_map(|arg| Some((self.name_of(arg), value_of(arg, matches)?)))
            .collect()
    }
}

impl Options<'_> {
    /// The member that gives an option: its long name with `_` for `-`, or what stands for a place on the command
    /// line.
    pub(super) fn name_of(&self, arg: &Arg) -> String {
        match arg.get_long() {
            Some(long) => long.replace('-', "_"),
            None if self.command.get_name() == "read" => "path".to_owned(),
            None => arg.get_id().as_str().to_owned(),
        }
    }
}

/// The name that is most like one, if it is like one at all.
pub(super) fn closest<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    names
        .map(|known| (strsim::jaro_winkler(&name.replace('-', "_"), known), known))
        .filter(|(alike, _)| *alike > ALIKE)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, known)| known)
}

fn long(arg: &Arg) -> &str {
    arg.get_long().unwrap_or_default()
}

pub(super) fn kind_of(arg: &Arg) -> ValueKind {
    if matches!(arg.get_action(), ArgAction::SetTrue) {
        return ValueKind::Flag;
    }
    let parsed = arg.get_value_parser().type_id();
    let is = |kind: TypeId| parsed == kind;
    // A size such as 2GiB is a number only once it is read.
    let has_units = (arg.get_default_values().first())
        .and_then(|value| value.to_str())
        .is_some_and(|value| value.parse::<f64>().is_err());
    if is(TypeId::of::<bool>()) {
        ValueKind::YesOrNo
    } else if is(TypeId::of::<PathBuf>()) {
        ValueKind::Path
    } else if has_units {
        ValueKind::Text
    } else if is(TypeId::of::<f64>()) {
        ValueKind::Number
    } else if [
        TypeId::of::<usize>(),
        TypeId::of::<u32>(),
        TypeId::of::<u64>(),
    ]
    .into_iter()
    .any(is)
    {
        ValueKind::Integer
    } else {
        ValueKind::Text
    }
}

/// Whether an option may stand without a value.
pub(super) fn may_be_bare(arg: &Arg) -> bool {
    arg.get_num_args()
        .is_some_and(|range| range.min_values() == 0)
}

/// An option on the command line.
enum Word {
    Bare,
    Value(String),
}

/// `None` where the option is as if it were not given.
fn word(arg: &Arg, value: &Value) -> Result<Option<Word>, String> {
    let kind = kind_of(arg);
    let given = match value {
        Value::Null => return Ok(None),
        Value::Bool(given) => Some(*given),
        Value::String(text) if kind == ValueKind::Flag => match text.as_str() {
            "true" => Some(true),
            "false" => Some(false),
            _ => None,
        },
        _ => None,
    };
    if let Some(given) = given {
        return match kind {
            ValueKind::YesOrNo => Ok(Some(Word::Value(if given { "yes" } else { "no" }.into()))),
            ValueKind::Flag => Ok(given.then_some(Word::Bare)),
            _ if may_be_bare(arg) => Ok(given.then_some(Word::Bare)),
            _ => Err(format!("expected {}, not {given}", expected(arg, kind))),
        };
    }
    let text = match value {
        Value::String(text) => Some(text.clone()),
        _ if kind == ValueKind::Path => None,
        Value::Number(number) => Some(in_digits(number)),
        Value::Array(items) => (items.iter())
            .map(|item| match item {
                Value::String(text) => Some(text.clone()),
                Value::Number(number) => Some(in_digits(number)),
                _ => None,
            })
            .collect::<Option<Vec<String>>>()
            .map(|items| items.join(",")),
        _ => None,
    };
    match text {
        Some(text) if kind != ValueKind::Flag => Ok(Some(Word::Value(text))),
        _ => Err(format!("expected {}, not {value}", expected(arg, kind))),
    }
}

/// A whole number from 0, also as 4.0: JSON and its schemas do not tell it from 4.
pub(super) fn whole(value: &Value) -> Option<u64> {
    /// Above this not all whole numbers can be told apart.
    const MOST: f64 = 9_007_199_254_740_992.0;
    let float = || {
        let float = value.as_f64().filter(|float| float.fract() == 0.0)?;
        ((0.0..=MOST).contains(&float))
            .then(|| format!("{float:.0}"))?
            .parse()
            .ok()
    };
    value.as_u64().or_else(float)
}

/// A number as the command line reads it.
fn in_digits(number: &serde_json::Number) -> String {
    match whole(&Value::Number(number.clone())) {
        Some(whole) => whole.to_string(),
        None => number.to_string(),
    }
}

fn expected(arg: &Arg, kind: ValueKind) -> String {
    match kind {
        ValueKind::Flag | ValueKind::YesOrNo => "true or false".to_owned(),
        ValueKind::Number => "a number".to_owned(),
        ValueKind::Integer => "a whole number from 0".to_owned(),
        ValueKind::Path => "a path".to_owned(),
        ValueKind::Text => {
            let values: Vec<String> = (arg.get_possible_values().iter())
                .map(|value| value.get_name().to_owned())
                .collect();
            if values.is_empty() {
                "a text, a number, or a list of them".to_owned()
            } else {
                values.join(", ")
            }
        }
    }
}

/// The value of an option, as JSON has it; `None` if it has none.
fn value_of(arg: &Arg, matches: &ArgMatches) -> Option<Value> {
    let id = arg.get_id().as_str();
    let kind = kind_of(arg);
    if kind == ValueKind::Flag {
        return matches.get_flag(id).then_some(Value::Bool(true));
    }
    let raw = matches.try_get_raw(id).ok().flatten()?;
    let texts: Vec<_> = raw.map(|text| text.to_string_lossy()).collect();
    let text = texts.join(",");
    Some(match kind {
        ValueKind::YesOrNo => Value::Bool(text == "yes"),
        ValueKind::Number | ValueKind::Integer => {
            (text.parse::<serde_json::Number>()).map_or_else(|_| json!(text), Value::Number)
        }
        _ => Value::String(text),
    })
}

/// What the command line says of options, in one sentence without its dashes.
pub(super) fn in_one_sentence(error: &clap::Error) -> String {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        Some(ContextValue::Strings(texts)) => Some(texts.join(", ")),
        _ => None,
    };
    let option = text(ContextKind::InvalidArg).map(|arg| plain(&arg));
    let value = text(ContextKind::InvalidValue).unwrap_or_default();
    match (error.kind(), option) {
        (ErrorKind::ValueValidation, Some(option)) => {
            let source = std::error::Error::source(error).map(ToString::to_string);
            format!(
                "{option}: {value:?} cannot be: {}",
                source.unwrap_or_else(|| "no such value".to_owned())
            )
        }
        (ErrorKind::InvalidValue, Some(option)) => format!(
            "{option}: {value:?} cannot be: expected one of {}",
            text(ContextKind::ValidValue).unwrap_or_default()
        ),
        (ErrorKind::ArgumentConflict, Some(option)) => format!(
            "{option} and {} cannot both be given",
            text(ContextKind::PriorArg).map_or_else(|| "the others".to_owned(), |arg| plain(&arg))
        ),
        (ErrorKind::MissingRequiredArgument, Some(option)) => format!("{option} is missing"),
        _ => {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            first.trim_start_matches("error: ").to_owned()
        }
    }
}

/// `--max-edges <N>` as `max_edges`.
fn plain(arg: &str) -> String {
    let options = arg.split(", ").map(|arg| {
        let name = arg.split([' ', '=']).next().unwrap_or(arg);
        let name = name
            .trim_start_matches("--")
            .trim_matches(['<', '>', '[', ']']);
        format!("`{}`", name.replace('-', "_").to_lowercase())
    });
    options.collect::<Vec<_>>().join(", ")
}
