//! Commands and pipelines for programs: on scans in memory or in files, with the options, the checks and the messages
//! of the command line.

use std::sync::Arc;

use clap::Parser;
use rayon::ThreadPoolBuilder;
use serde_json::{Map, Value};

use crate::picture::Raster;
use crate::scan::{Scan, ScanError};

use super::Common;
use super::held::{Held, KEPT, Kept};
use super::outcome::{Failure, Reply, in_one_sentence};
use super::pipeline::{Action, Pipeline, StepLine, definition};
use super::run;
use super::scan_command::ScanCommand;
use super::step_options::{self, Options};
use super::watch::{Stopped, Watch, caught};

/// What a program asks for.
///
/// ```
/// use relievo::cli::{Call, Content, Held};
/// use relievo::scan::{ReadOptions, read};
/// use serde_json::json;
///
/// let scan = read("data/scans/golf-ball-half.ply".as_ref(), &ReadOptions::default())?;
/// let mut call = Call::new("complete");
/// call.hold("ball", Held::new("the ball", Content::Scan(scan.into())));
/// call.set("scan", json!("ball"));
/// call.set("extend", json!(true));
/// call.set("sites", json!(64));
/// let done = call.run()?;
/// assert_eq!(done.json["fit"]["base"]["kind"], "sphere");
/// assert!(done.scan.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Call {
    what: String,
    options: Map<String, Value>,
    held: Vec<(String, Held)>,
    threads: Option<usize>,
    watch: Option<Watch>,
}

/// What came of it.
#[derive(Debug, Default)]
pub struct Called {
    /// The scan that the command would have written, if it writes one; of a pipeline, the one it ends with.
    pub scan: Option<Arc<Scan>>,
    /// The picture that was drawn, if it was not written to a file.
    pub picture: Option<Raster>,
    /// The members that the command writes with `--json`.
    pub json: Map<String, Value>,
    /// For people: what the command prints.
    pub text: String,
    /// Whether some of what was asked for could not be done.
    pub partly: bool,
}

/// Why nothing came of it.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct CallError {
    /// Whose fault it is.
    pub kind: CallErrorKind,
    /// One sentence.
    pub message: String,
    /// What is known all the same: what the command writes with `--json`.
    pub json: Map<String, Value>,
}

/// Whose fault it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CallErrorKind {
    /// Something impossible was asked for.
    Usage,
    /// A file that is read does not exist.
    Missing,
    /// A file cannot be read, or is broken.
    Reading,
    /// A file cannot be written.
    Writing,
    /// A scan that nothing comes of.
    Work,
    /// The watch has ended the work.
    Ended,
    /// A mistake in this library.
    Internal,
}

impl Call {
    /// A call of a command that can be a step of a pipeline.
    #[must_use]
    pub fn new(command: impl Into<String>) -> Self {
        Self {
            what: command.into(),
            ..Self::default()
        }
    }

    /// Gives an option of the command, by its long name with `_` for `-`; places on the command line are called `scan`
    /// and `other`. Without an `output` there is no file written, and [`Called`] has the result.
    pub fn set(&mut self, name: impl Into<String>, value: Value) {
        self.options.insert(name.into(), value);
    }

    /// Gives something in memory, that options name by `path`.
    pub fn hold(&mut self, path: impl Into<String>, held: Held) {
        self.held.push((path.into(), held));
    }

    /// Works with so many threads, at least one [default: those of the pool it is called from].
    pub fn threads(&mut self, threads: usize) {
        self.threads = Some(threads.max(1));
    }

    /// Lets `watch` hear how far the work is, and end it.
    pub fn watch(&mut self, watch: Watch) {
        self.watch = Some(watch);
    }

    /// Does it.
    ///
    /// # Errors
    /// [`CallError`] with the command's message.
    pub fn run(self) -> Result<Called, CallError> {
        let threads = self.threads;
        guarded(threads, move || self.command())
    }

    /// Runs a pipeline instead: JSON as `relievo run` takes it, whose paths may name what is held.
    ///
    /// # Errors
    /// [`CallError`] with a message that names the step.
    pub fn run_pipeline(self, pipeline: &Value) -> Result<Called, CallError> {
        let threads = self.threads;
        guarded(threads, move || self.pipeline(pipeline))
    }

    /// How many threads a pool of its own has.
    pub(super) fn pool(&self) -> Option<usize> {
        self.threads
    }

    fn command(self) -> Result<Called, Failure> {
        let (mut command, common) = self.prepared()?;
        let slot = command.keep();
        let mut called = Called::of(command.run(&common)?);
        match slot.and_then(|slot| slot.take()) {
            Some(Kept::Scan(scan)) => called.scan = Some(scan),
            Some(Kept::Picture(picture)) => called.picture = Some(*picture),
            None => {}
        }
        Ok(called)
    }

    /// The command with its options and what is held.
    pub(super) fn prepared(self) -> Result<(ScanCommand, Common), Failure> {
        let definition = definition();
        let command = (definition.find_subcommand(&self.what))
            .filter(|command| !["read", "write"].contains(&command.get_name()))
            .ok_or_else(|| Failure::usage(format!("there is no command `{}`", self.what)))?;
        let mut words = Options::of(command)
            .arguments(&self.options, None, true)
            .map_err(Failure::usage)?;
        let has_output = (command.get_arguments()).any(|arg| arg.get_id() == "output");
        if has_output && self.options.get("output").is_none_or(Value::is_null) {
            words.insert(1, format!("--output={KEPT}").into());
        }
        let line = StepLine::try_parse_from(words)
            .map_err(|error| Failure::usage(step_options::in_one_sentence(&error)))?;
        let common = self.common(line.seed.unwrap_or(0));
        let Action::Command(mut command) = line.action else {
            return Err(Failure::usage(format!(
                "there is no command `{}`",
                self.what
            )));
        };
        for (path, held) in self.held {
            command.hold(&path, held);
        }
        Ok((*command, common))
    }

    fn pipeline(self, pipeline: &Value) -> Result<Called, Failure> {
        let pipeline = Pipeline::from_value(pipeline).map_err(Failure::usage)?;
        let mut actions = pipeline.actions().map_err(Failure::usage)?;
        for line in &mut actions {
            for (path, held) in &self.held {
                line.action.hold(path, held);
            }
        }
        let (reply, scan) = run::all(&pipeline, actions, &self.common(0))?;
        Ok(Called {
            scan,
            ..Called::of(reply)
        })
    }

    fn common(&self, seed: u32) -> Common {
        Common {
            seed,
            seed_given: false,
            threads: None,
            json: None,
            quiet: true,
            verbose: false,
            watch: self.watch.clone(),
        }
    }
}

impl Called {
    fn of(reply: Reply) -> Self {
        Self {
            json: reply.json,
            text: reply.text,
            partly: reply.partly,
            ..Self::default()
        }
    }
}

impl CallErrorKind {
    fn of(failure: &Failure) -> Self {
        match failure.error.downcast_ref::<ScanError>() {
            _ if failure.usage => Self::Usage,
            Some(ScanError::NotFound { .. }) => Self::Missing,
            Some(error) if error.is_of_writing() => Self::Writing,
            Some(_) => Self::Reading,
            None => Self::Work,
        }
    }
}

impl CallError {
    fn of(failure: Failure) -> Self {
        Self {
            kind: CallErrorKind::of(&failure),
            message: in_one_sentence(&failure.error),
            json: failure.json,
        }
    }

    fn without_json(kind: CallErrorKind, message: String) -> Self {
        Self {
            kind,
            message,
            json: Map::new(),
        }
    }
}

/// Work in a pool of its own, if so many threads are asked for, whose panics are errors.
pub(super) fn guarded<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, CallError> {
    let work = || match caught(work) {
        Ok(done) => done.map_err(CallError::of),
        Err(Stopped::Ended) => Err(CallError::without_json(
            CallErrorKind::Ended,
            "the work was ended early".to_owned(),
        )),
        Err(Stopped::Panicked(message)) => Err(CallError::without_json(
            CallErrorKind::Internal,
            format!("a mistake in relievo, please report it: {message}"),
        )),
    };
    match threads {
        None => work(),
        Some(threads) => match ThreadPoolBuilder::new().num_threads(threads).build() {
            Ok(pool) => pool.install(work),
            Err(error) => Err(CallError::without_json(
                CallErrorKind::Work,
                format!("{threads} threads: {error}"),
            )),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn kind(command: &str, options: &[(&str, Value)]) -> CallErrorKind {
        let mut call = Call::new(command);
        for (name, value) in options {
            call.set(*name, value.clone());
        }
        call.run().unwrap_err().kind
    }

    #[test]
    fn errors_tell_whose_fault_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| json!(folder.path().join(name).to_str());
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text);
        write("broken.ply", "ply\nformat ascii 1.0\nend_header\n").unwrap();
        write("points.xyz", "0 0 0\n1 0 0\n").unwrap();
        let of = |name: &str| [("scan", path(name))];
        assert_eq!(kind("fit", &of("missing.ply")), CallErrorKind::Missing);
        assert_eq!(kind("fit", &of("broken.ply")), CallErrorKind::Reading);
        assert_eq!(kind("fit", &of("points.xyz")), CallErrorKind::Work);
        let nowhere = ("output", path("no/such/folder.ply"));
        let [scan] = of("points.xyz");
        assert_eq!(
            kind("complete", &[scan.clone(), nowhere]),
            CallErrorKind::Writing
        );
        assert_eq!(
            kind("fit", &[scan.clone(), ("base", json!("cube"))]),
            CallErrorKind::Usage
        );
        assert_eq!(kind("fti", &[scan]), CallErrorKind::Usage);
    }
}
