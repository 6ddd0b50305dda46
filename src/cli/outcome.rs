//! What a subcommand gives back, and how it reaches the user: table, JSON, exit code.

use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::scan::{OutputFile, ScanError, same_file};
use serde_json::{Map, Value, json};

/// A subcommand's result.
#[derive(Debug, Default)]
pub(super) struct Reply {
    /// Members of the JSON object, in order.
    pub(super) json: Map<String, Value>,
    /// For people, on standard output; empty for none.
    pub(super) text: String,
    /// Whether some of what was asked for could not be done.
    pub(super) partly: bool,
}

/// What went wrong, and whose fault it is.
#[derive(Debug)]
pub(super) struct Failure {
    /// Whether the command line asked for something impossible.
    pub(super) usage: bool,
    pub(super) error: anyhow::Error,
    /// What is known all the same.
    pub(super) json: Map<String, Value>,
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self {
            usage: false,
            error: error.into(),
            json: Map::new(),
        }
    }
}

impl Failure {
    /// A mistake on the command line.
    pub(super) fn usage(message: impl Into<String>) -> Self {
        Self {
            usage: true,
            error: anyhow::Error::msg(message.into()),
            json: Map::new(),
        }
    }
}

/// The end of a run.
#[derive(Debug)]
pub(super) struct Outcome {
    json: Map<String, Value>,
    text: String,
    code: u8,
}

impl Outcome {
    pub(super) fn of(
        command: &str,
        input: Option<&Path>,
        repeated: Option<Value>,
        reply: super::Result,
    ) -> Self {
        let mut json = Map::new();
        json.insert("command".into(), command.into());
        json.insert("version".into(), env!("CARGO_PKG_VERSION").into());
        let (status, code, text, rest) = match reply {
            Ok(reply) if reply.partly => ("partly", 3, reply.text, reply.json),
            Ok(reply) => ("done", 0, reply.text, reply.json),
            Err(failure) => {
                let message = in_one_sentence(&failure.error);
                log::error!("{message}");
                let mut rest = failure.json;
                rest.insert("error".into(), message.into());
                let code = if failure.usage { 2 } else { 1 };
                ("failed", code, String::new(), rest)
            }
        };
        json.insert("status".into(), status.into());
        if let Some(input) = input {
            json.insert("input".into(), json!(input.to_string_lossy()));
        }
        json.extend(repeated.map(|pipeline| ("pipeline".into(), pipeline)));
        json.extend(rest);
        Self { json, text, code }
    }

    /// Writes JSON and text where they belong.
    pub(super) fn deliver(self, report: Option<Report>) -> ExitCode {
        let to_stdout = report.as_ref().is_some_and(Report::is_stdout);
        let mut code = self.code;
        if let Some(report) = report
            && let Err(error) = report.write(&Value::Object(self.json))
        {
            log::error!("{}", in_one_sentence(&error));
            code = code.max(1);
        }
        if !to_stdout
            && !self.text.is_empty()
            && let Err(error) = std::io::stdout().write_all(self.text.as_bytes())
            && error.kind() != ErrorKind::BrokenPipe
        {
            log::error!("standard output: {error}");
            code = code.max(1);
        }
        ExitCode::from(code)
    }
}

/// The error and its causes, those left out that the text before them names already.
pub(super) fn in_one_sentence(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain() {
        let cause = cause.to_string();
        if text.is_empty() {
            text = cause;
        } else if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// Where the JSON goes: opened before the work, so that a folder that is missing is noticed then.
#[derive(Debug)]
pub(super) struct Report(OutputFile);

impl Report {
    /// Opens the report if one is asked for; it may be neither an input nor one of the outputs, which have the names of
    /// their options.
    pub(super) fn open(
        path: Option<&Path>,
        inputs: &[&Path],
        outputs: &[(&str, Option<&Path>)],
    ) -> Result<Option<Self>, Failure> {
        let opened = |path| opened("--json", path, inputs, outputs);
        Ok(path.map(opened).transpose()?.map(Self))
    }

    /// The same where nobody knows all inputs yet: a file that is there already is left alone, it may be one of them.
    pub(super) fn open_new(path: Option<&Path>, inputs: &[&Path]) -> Option<Self> {
        let path = path.filter(|path| *path == Path::new("-") || !path.exists());
        // Of two mistakes the first one is told.
        Self::open(path, inputs, &[]).ok().flatten()
    }

    fn is_stdout(&self) -> bool {
        self.0.is_stdout()
    }

    fn write(self, value: &Value) -> anyhow::Result<()> {
        let mut text = serde_json::to_string_pretty(value)?;
        text.push('\n');
        Ok(written(self.0, text.as_bytes())?)
    }
}

/// Opens what an option writes beside the command's output, before the work, so that a folder that is missing is
/// noticed then. It may be none of the inputs, by whatever name or link, nor where `others` (with their options)
/// go.
pub(super) fn opened(
    option: &str,
    path: &Path,
    inputs: &[&Path],
    others: &[(&str, Option<&Path>)],
) -> Result<OutputFile, Failure> {
    let shown = path.display();
    for (other_option, other) in others {
        if let Some(other) = other.filter(|other| same_place(other, path)) {
            return Err(Failure::usage(format!(
                "{other_option} {} and {option} {shown} cannot both go there: give one of them another name",
                other.display()
            )));
        }
    }
    // As an input - is something else than as an output.
    let stream = Path::new("-");
    let is_input = |input: &&Path| **input != *stream && same_place(input, path);
    if path != stream && inputs.iter().any(is_input) {
        return Err(Failure::usage(format!(
            "{shown}: {option} would overwrite the input: give it another name"
        )));
    }
    Ok(OutputFile::create(path, None)?)
}

/// Writes all of an output. Whoever stops reading a pipe has read what they want.
pub(super) fn written(mut output: OutputFile, bytes: &[u8]) -> Result<(), ScanError> {
    let result = match output.write_all(bytes) {
        Ok(()) => output.commit(),
        Err(error) => Err(output.error(error)),
    };
    match result {
        Err(ScanError::ClosedPipe { .. }) => Ok(()),
        result => result,
    }
}

/// Whether two paths name one file, which need not exist.
pub(super) fn same_place(a: &Path, b: &Path) -> bool {
    a == b || same_file(a, b) || place(a) == place(b)
}

/// The path of a file, which need not exist, without links as far as that goes.
pub(super) fn place(path: &Path) -> PathBuf {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let file = path.file_name().unwrap_or_default().to_owned();
    std::fs::canonicalize(path)
        .or_else(|_| std::fs::canonicalize(folder).map(|folder| folder.join(file)))
        .or_else(|_| std::path::absolute(path))
        .unwrap_or_else(|_| path.to_owned())
}

/// Writes the JSON for a command line that could not be understood, if it asks for one. A file that
/// is there already is left alone: it may be the scan.
pub(super) fn report_usage_error(arguments: &[OsString], error: &clap::Error) {
    let mut words = arguments.iter().map(|word| word.to_string_lossy());
    let path = words.find_map(|word| match word.strip_prefix("--json") {
        Some("") => Some(None),
        Some(rest) => rest.strip_prefix('=').map(|path| Some(path.to_owned())),
        None => None,
    });
    let path = match path {
        Some(Some(path)) => path,
        Some(None) => match words.next() {
            Some(path) => path.into_owned(),
            None => return,
        },
        None => return,
    };
    let value = json!({
        "command": Value::Null,
        "version": env!("CARGO_PKG_VERSION"),
        "status": "failed",
        "error": error.to_string().trim(),
    });
    if let Some(report) = Report::open_new(Some(Path::new(&path)), &[])
        && let Err(error) = report.write(&value)
    {
        log::error!("{error:#}");
    }
}
