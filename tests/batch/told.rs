//! What is said at the end when not all can be said.

use std::fs::OpenOptions;
use std::process::{Command, Output, Stdio};

use super::{QUICK, good, results};
use crate::common::place::Place;

/// Runs with standard output as given, closed at once if it is a pipe.
fn run(place: &Place, line: &str, stdout: Stdio) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(line.split_whitespace())
        .current_dir(place.0.path())
        .stdin(Stdio::null())
        .stdout(stdout)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    child.wait_with_output().expect("the program ends")
}

#[test]
fn a_closed_standard_output_changes_nothing() {
    let place = good(3);
    let line = format!("batch scans/*.ply --out out --jobs 1 {QUICK}");
    let output = run(&place, &line, Stdio::piped());
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(results(&place, "out").len(), 3);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
}

#[test]
#[cfg(target_os = "linux")]
fn lines_that_a_full_disk_does_not_take_are_a_failure_of_an_otherwise_good_batch() {
    let place = good(2);
    let full = OpenOptions::new().write(true).open("/dev/full");
    let line = format!("batch scans/*.ply --out out --json all.json {QUICK}");
    let output = run(&place, &line, full.expect("this is Linux").into());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(
        stderr.contains("error: standard output: No space left"),
        "{stderr}"
    );
    assert!(stderr.contains("2 done"), "{stderr}");
    assert_eq!(results(&place, "out").len(), 2);
    let json = place.json("all.json");
    assert_eq!(
        (&json["status"], &json["counts"]["done"]),
        (&"failed".into(), &2.into())
    );
}

#[test]
#[cfg(all(target_os = "linux", feature = "report"))]
fn a_page_that_cannot_be_written_takes_nothing_else_with_it() {
    let place = good(2);
    place.text("scans/empty.ply", "");
    let line = format!("batch scans/*.ply --out out --report /dev/full --json all.json {QUICK}");
    let run = place.run(&line);
    assert_eq!(run.code, 1, "{}", run.stderr);
    for words in [
        "2 done",
        "1 of 3 scans failed",
        "/dev/full",
        "No space left",
    ] {
        assert!(run.stderr.contains(words), "no {words:?} in {}", run.stderr);
    }
    assert_eq!(super::lines(&run).len(), 3);
    assert_eq!(place.json("all.json")["counts"]["failed"], 1);
}
