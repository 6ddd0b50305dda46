//! A folder in which the program runs, and what it gave.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use relievo::scan::{ReadOptions, Scan, WriteOptions, read, write};
use serde_json::Value;
use tempfile::TempDir;

/// What a run of the program gave.
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: String,
}

/// A folder in which the program runs.
pub(crate) struct Place(pub(crate) TempDir);

impl Place {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("there is room for a folder"))
    }

    pub(crate) fn with(name: &str, scan: &Scan) -> Self {
        let place = Self::new();
        place.put(name, scan);
        place
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn put(&self, name: &str, scan: &Scan) {
        write(scan, &self.path(name), &WriteOptions::default()).expect("it can be written");
    }

    pub(crate) fn text(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("it can be written");
    }

    pub(crate) fn scan(&self, name: &str) -> Scan {
        read(&self.path(name), &ReadOptions::default()).expect("it is a scan")
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect("it is there")
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).expect("it is JSON")
    }

    /// Runs with blanks between the arguments.
    pub(crate) fn run(&self, line: &str) -> Run {
        self.run_with(line, &[])
    }

    pub(crate) fn run_with(&self, line: &str, stdin: &[u8]) -> Run {
        let mut child = Command::new(env!("CARGO_BIN_EXE_relievo"))
            .args(line.split_whitespace())
            .current_dir(self.0.path())
            .env_remove("CLICOLOR_FORCE")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        // A program that does not read closes the pipe, which is its right.
        let _ = child.stdin.take().expect("it is piped").write_all(stdin);
        let output = child.wait_with_output().expect("the program ends");
        let stderr = String::from_utf8(output.stderr).expect("messages are UTF-8");
        assert!(!stderr.contains("panicked"), "{line}: {stderr}");
        assert!(
            !stderr.contains(['\r', '\x1b']),
            "bars without a terminal: {stderr:?}"
        );
        Run {
            code: output.status.code().expect("no signal ended it"),
            stdout: output.stdout,
            stderr,
        }
    }

    /// Names of all files, in order.
    pub(crate) fn files(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.0.path())
            .expect("the folder is there")
            .map(|entry| entry.expect("and can be read").file_name())
            .map(|name| name.into_string().expect("names are UTF-8"))
            .collect();
        names.sort();
        names
    }

    /// Runs and expects code 0.
    #[track_caller]
    pub(crate) fn done(&self, line: &str) -> Run {
        let run = self.run(line);
        assert_eq!(run.code, 0, "{line}: {}", run.stderr);
        run
    }

    /// Expects the code, one sentence on standard error that has all `words`, nothing on standard
    /// output, and no new file but the JSON, which says the same.
    #[track_caller]
    pub(crate) fn refused(&self, code: i32, line: &str, words: &[&str]) {
        let before = self.files();
        let run = self.run(line);
        assert_eq!(run.code, code, "{line}: {}", run.stderr);
        for word in words {
            assert!(
                run.stderr.contains(word),
                "{line}: no {word:?} in {}",
                run.stderr
            );
        }
        assert_eq!(run.stderr.lines().count(), 1, "{line}: {}", run.stderr);
        assert!(
            run.stderr.starts_with("relievo: error: "),
            "{line}: {}",
            run.stderr
        );
        assert!(run.stdout.is_empty(), "{line}");
        assert_eq!(self.files(), before, "{line} left something behind");

        let again = self.run(&format!("{line} --json -"));
        assert_eq!(again.code, code, "{line} --json -");
        let json: Value = serde_json::from_slice(&again.stdout).expect("it is JSON");
        assert_eq!(json["status"], "failed", "{line}");
        let message = json["error"].as_str().expect("the JSON says why");
        assert_eq!(run.stderr, format!("relievo: error: {message}\n"));
        assert_eq!(
            self.files(),
            before,
            "{line} --json - left something behind"
        );
    }
}
