//! What is said of each scan, and of all.

use std::io::{ErrorKind, Write};
use std::path::PathBuf;

use serde::Serialize;
use serde_json::{Map, Value};

use super::super::outcome::Failure;
use super::memory;
use super::protocol::Status;

/// What is said of a scan, in the order of its members.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Line {
    pub(super) input: String,
    pub(super) output: String,
    pub(super) status: Status,
    /// How a scan ended whose results were there already.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) was: Option<Status>,
    pub(super) seconds: f64,
    /// In bytes.
    pub(super) peak_memory: Option<u64>,
    pub(super) seed: u32,
    pub(super) key: Option<String>,
    pub(super) counts: Value,
    pub(super) warnings: Vec<String>,
    pub(super) error: Option<String>,
    /// All files that were written; for the page.
    #[serde(skip)]
    pub(super) written: Vec<PathBuf>,
    /// What `relievo run --json` tells; for workers elsewhere.
    #[serde(skip)]
    pub(super) report: Map<String, Value>,
    /// Whether what went wrong may go well another time; for workers elsewhere.
    #[serde(skip)]
    pub(super) may_pass: bool,
}

impl Line {
    /// How its results are.
    pub(super) fn result(&self) -> Status {
        self.was.unwrap_or(self.status)
    }
}

/// Standard output, as long as somebody reads it.
#[derive(Debug, Default)]
pub(super) struct Told {
    is_closed: bool,
    /// Why the lines from some scan on are nowhere.
    error: Option<std::io::Error>,
}

impl Told {
    /// Writes a line at once, so that whoever reads can go on with it.
    pub(super) fn tell(&mut self, line: &Line) {
        if self.is_closed {
            return;
        }
        // By way of a `Value` its members would be in another order.
        let Ok(mut text) = serde_json::to_string(line) else {
            return;
        };
        text.push('\n');
        let mut stdout = std::io::stdout().lock();
        let written = stdout
            .write_all(text.as_bytes())
            .and_then(|()| stdout.flush());
        if let Err(error) = written {
            self.is_closed = true;
            // Whoever closes a pipe has read what they want.
            if error.kind() != ErrorKind::BrokenPipe {
                log::warn!("standard output: {error}; the scans are done all the same");
                self.error = Some(error);
            }
        }
    }

    /// An error if a line could not be written to somebody who wanted it.
    pub(super) fn end(self) -> Result<(), Failure> {
        match self.error {
            Some(error) => {
                Err(anyhow::anyhow!("standard output: {error}: not all scans are told").into())
            }
            None => Ok(()),
        }
    }
}

/// How many scans ended how.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) all: usize,
    pub(super) failed: usize,
    /// Some of them may have been there already.
    pub(super) partly: usize,
    pub(super) done: usize,
    pub(super) skipped: usize,
}

impl Counts {
    pub(super) fn of(lines: &[Line]) -> Self {
        let count = |is: &dyn Fn(&Line) -> bool| lines.iter().filter(|line| is(line)).count();
        Self {
            all: lines.len(),
            failed: count(&|line| line.status == Status::Failed),
            partly: count(&|line| line.result() == Status::Partly),
            done: count(&|line| line.status == Status::Done),
            skipped: count(&|line| line.status == Status::Skipped),
        }
    }
}

/// For people: failures first, then what was done in part, then numbers.
pub(super) fn summary(lines: &[Line], seconds: f64) -> String {
    let counts = Counts::of(lines);
    let mut text = String::new();
    for line in lines.iter().filter(|line| line.status == Status::Failed) {
        let error = line.error.as_deref().unwrap_or("no reason was given");
        text.push_str(&format!("relievo: failed: {}\n", about(&line.input, error)));
    }
    for line in lines.iter().filter(|line| line.result() == Status::Partly) {
        let left = line.counts["left_open"].as_u64().unwrap_or(0);
        text.push_str(&format!(
            "relievo: partly: {}: {left} gap(s) left open\n",
            line.input
        ));
    }
    let most = lines.iter().filter_map(|line| line.peak_memory).max();
    let most = most.map_or(String::new(), |bytes| {
        format!("; the largest took {}", memory::in_words(bytes))
    });
    text.push_str(&format!(
        "relievo: {} scan(s) in {seconds:.1} s: {} failed, {} done in part, {} done, {} there already{most}\n",
        counts.all,
        counts.failed,
        lines.iter().filter(|line| line.status == Status::Partly).count(),
        counts.done,
        counts.skipped,
    ));
    text
}

/// An error with the scan's name, which it may have already.
fn about(input: &str, error: &str) -> String {
    if error.contains(input) {
        error.to_owned()
    } else {
        format!("{input}: {error}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn line(input: &str, status: Status, was: Option<Status>) -> Line {
        Line {
            input: input.to_owned(),
            output: format!("out/{input}"),
            status,
            was,
            seconds: 1.0,
            peak_memory: Some(1 << 30),
            seed: 0,
            key: None,
            counts: json!({ "filled": 1, "left_open": 2 }),
            warnings: Vec::new(),
            error: (status == Status::Failed).then(|| "cut off".to_owned()),
            written: Vec::new(),
            report: Map::new(),
            may_pass: false,
        }
    }

    #[test]
    fn failures_come_first_and_what_was_there_keeps_how_it_was() {
        let lines = [
            line("a.ply", Status::Done, None),
            line("b.ply", Status::Skipped, Some(Status::Partly)),
            line("c.ply", Status::Failed, None),
        ];
        let text = summary(&lines, 2.0);
        let said: Vec<&str> = text.lines().collect();
        assert_eq!(said[0], "relievo: failed: c.ply: cut off");
        assert_eq!(said[1], "relievo: partly: b.ply: 2 gap(s) left open");
        assert!(
            said[2].contains("1 failed, 0 done in part, 1 done, 1 there already"),
            "{text}"
        );
        assert_eq!(Counts::of(&lines).partly, 1);
    }

    #[test]
    fn lines_have_their_members_in_order() {
        let text = serde_json::to_string(&line("a.ply", Status::Done, None)).unwrap();
        assert!(
            text.starts_with(r#"{"input":"a.ply","output":"out/a.ply","status":"done","seconds""#)
        );
    }
}
