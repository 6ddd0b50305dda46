//! The process of one scan: it reads an order from standard input and answers on standard output.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Read, Write};
use std::process::ExitCode;

use crate::scan::trace::{self, Notes, Rules};
use crate::scan::{ScanError, abandon_outputs};
use serde_json::{Map, Value, json};

use super::super::outcome::{Failure, Reply, in_one_sentence};
use super::super::pipeline::Pipeline;
use super::super::run::all;
use super::super::watch::{Stopped, caught};
use super::super::{Common, messages};
use super::memory::of_process;
use super::pictures;
use super::protocol::{Answer, Order, Status};

/// Exit code of a process whose batch has ended before it.
const ALONE: i32 = 130;

/// Does what the order says.
pub(in super::super) fn run() -> ExitCode {
    let mut line = String::new();
    let read = std::io::stdin().read_line(&mut line);
    let order = match read.map(|_| serde_json::from_str::<Order>(&line)) {
        Ok(Ok(order)) => order,
        _ => {
            let what = "relievo: error: batch-job is how `relievo batch` calls itself; give it to no one else\n";
            let _ = std::io::stderr().write_all(what.as_bytes());
            return ExitCode::from(2);
        }
    };
    messages::collect();
    end_with_batch();
    let locked = OpenOptions::new().read(true).open(&order.lock);
    // Held until the end of the process; where files cannot be locked, nobody else locks them either.
    let lock = locked.map(|file| (file.try_lock_shared(), file));
    if let Ok((Err(std::fs::TryLockError::WouldBlock), _)) = lock {
        return ExitCode::FAILURE;
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(order.threads.max(1));
    if let Err(error) = pool.build_global() {
        log::warn!("{} threads: {error}", order.threads);
    }
    let answer = answer(order);
    match serde_json::to_string(&answer) {
        Ok(mut text) => {
            text.push('\n');
            let written = std::io::stdout().write_all(text.as_bytes());
            ExitCode::from(u8::from(written.is_err()))
        }
        Err(error) => {
            // What is said last is taken for the reason.
            let what = format!("what was done cannot be told: {error}\n");
            let _ = std::io::stderr().write_all(what.as_bytes());
            ExitCode::FAILURE
        }
    }
}

/// The batch holds the other end of standard input as long as it lives. Without it nobody knows of this process any
/// more, and another batch may be at work in the same folder.
fn end_with_batch() {
    let wait = || {
        let mut rest = [0; 64];
        while !matches!(std::io::stdin().read(&mut rest), Ok(0) | Err(_)) {}
        abandon_outputs();
        std::process::exit(ALONE);
    };
    let thread = std::thread::Builder::new().name("batch".to_owned());
    if let Err(error) = thread.spawn(wait) {
        log::debug!("the end of the batch is not heard of: {error}");
    }
}

fn answer(order: Order) -> Answer {
    trace::begin(Rules {
        replaceable: order.replaceable,
        notes: Some(Notes {
            file: order.notes,
            root: order.folder,
        }),
    });
    let mut answer = Answer::default();
    let done = match &order.pipeline {
        Some(pipeline) => work(pipeline),
        None => Ok(Reply::default()),
    };
    let json = match done {
        Ok(reply) => {
            answer.status = if reply.partly {
                Status::Partly
            } else {
                Status::Done
            };
            reply.json
        }
        Err(failure) => {
            answer.error = Some(in_one_sentence(&failure.error));
            answer.may_pass = may_pass(&failure.error);
            failure.json
        }
    };
    answer.counts = counts(&json);
    if order.report {
        answer.report = json;
    }
    let trace = trace::end();
    answer.read = trace.read;
    answer.changed = trace.changed;
    answer.written = trace.written;
    answer.peak_memory = of_process("self", "VmHWM");
    if let Some(pictures) = order.pictures.filter(|_| answer.status != Status::Failed) {
        pictures::draw(&pictures);
    }
    answer.warnings = messages::collected();
    answer
}

fn work(pipeline: &Value) -> super::super::Result {
    let work = || -> super::super::Result {
        let pipeline = Pipeline::from_value(pipeline).map_err(Failure::usage)?;
        let actions = pipeline.actions().map_err(Failure::usage)?;
        let common = Common {
            seed: 0,
            seed_given: false,
            threads: None,
            json: None,
            quiet: true,
            verbose: false,
            watch: None,
        };
        all(&pipeline, actions, &common).map(|(reply, _)| reply)
    };
    caught(work).unwrap_or_else(|stopped| {
        let what = match stopped {
            Stopped::Panicked(message) => message,
            Stopped::Ended => "it was ended".to_owned(),
        };
        Err(anyhow::anyhow!("a mistake in relievo, please report it: {what}").into())
    })
}

/// Whether it is the system that failed, as file systems on a network do, and not the scan or what was asked for.
fn may_pass(error: &anyhow::Error) -> bool {
    match error.downcast_ref::<ScanError>() {
        Some(ScanError::Read { source, .. } | ScanError::Write { source, .. }) => !matches!(
            source.kind(),
            ErrorKind::PermissionDenied | ErrorKind::NotFound
        ),
        _ => false,
    }
}

/// How many gaps were filled and left open by all steps.
fn counts(json: &Map<String, Value>) -> Map<String, Value> {
    let steps = json.get("steps").and_then(Value::as_array);
    let lengths = |name: &str| -> Option<usize> {
        let of_step = |step: &Value| Some(step.get(name)?.as_array()?.len());
        (steps?.iter().filter_map(of_step)).reduce(|sum, length| sum + length)
    };
    [("filled", "filled"), ("left_open", "skipped")]
        .into_iter()
        .filter_map(|(name, member)| Some((name.to_owned(), json!(lengths(member)?))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_system_failed_at_may_pass() {
        let of = |kind: ErrorKind| {
            let (name, source) = ("a.ply".to_owned(), kind.into());
            may_pass(&anyhow::Error::from(ScanError::Read { name, source }).context("step 1"))
        };
        assert!(of(ErrorKind::TimedOut));
        assert!(!of(ErrorKind::PermissionDenied));
        let name = "a.ply".to_owned();
        assert!(!may_pass(&ScanError::NotFound { name }.into()));
        assert!(!may_pass(&anyhow::anyhow!("no hole could be filled")));
    }

    #[test]
    fn gaps_of_all_steps_are_counted() {
        let json = json!({ "steps": [
            { "type": "read" },
            { "type": "complete", "filled": [1, 2], "skipped": [] },
            { "type": "complete", "filled": [1], "skipped": [3] }
        ]});
        let counted = counts(json.as_object().unwrap());
        assert_eq!(Value::from(counted), json!({ "filled": 3, "left_open": 1 }));
        assert!(counts(&Map::new()).is_empty());
    }
}
