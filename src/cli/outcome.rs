//! What a subcommand gives back, and how it reaches the user: table, JSON, exit code.

use std::io::{ErrorKind, Write};
use std::process::ExitCode;

use relievo::scan::OutputFile;
use serde_json::{Map, Value, json};

use super::Common;

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
    pub(super) fn of(command: &str, reply: super::Result) -> Self {
        let mut json = Map::new();
        json.insert("command".into(), command.into());
        json.insert("version".into(), env!("CARGO_PKG_VERSION").into());
        let (status, code, text, rest) = match reply {
            Ok(reply) if reply.partly => ("partly", 3, reply.text, reply.json),
            Ok(reply) => ("done", 0, reply.text, reply.json),
            Err(failure) => {
                log::error!("{:#}", failure.error);
                let mut rest = failure.json;
                rest.insert("error".into(), json!(format!("{:#}", failure.error)));
                let code = if failure.usage { 2 } else { 1 };
                ("failed", code, String::new(), rest)
            }
        };
        json.insert("status".into(), status.into());
        json.extend(rest);
        Self { json, text, code }
    }

    /// Writes JSON and text where they belong.
    pub(super) fn deliver(self, common: &Common) -> ExitCode {
        let to_stdout = common.json.as_deref() == Some("-".as_ref());
        let mut code = self.code;
        if let Some(path) = &common.json
            && let Err(error) = write_json(path, &Value::Object(self.json))
        {
            log::error!("{error}");
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

fn write_json(path: &std::path::Path, value: &Value) -> anyhow::Result<()> {
    let mut output = OutputFile::create(path, None)?;
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    match output.write_all(text.as_bytes()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => return Ok(()),
        result => result.map_err(|source| output.error(source))?,
    }
    output.commit()?;
    Ok(())
}
