//! Which scans there are, under which names.

use serde_json::Value;

use super::{good, mixed, refused};
use crate::common::place::Place;

/// The inputs and outputs of a batch that only says what it would do.
fn planned(place: &Place, line: &str) -> Vec<[String; 2]> {
    let run = place.done(&format!("batch {line} --out out --dry-run"));
    let text = String::from_utf8(run.stdout).expect("lines are UTF-8");
    let of_line = |line: &str| {
        let job: Value = serde_json::from_str(line).expect("each line is JSON");
        ["input", "output"].map(|name| job[name].as_str().expect("a path").to_owned())
    };
    text.lines().map(of_line).collect()
}

#[test]
fn the_same_pattern_from_here_gives_the_same_results() {
    let place = mixed();
    let plain = planned(&place, "scans/**/*.ply");
    assert_eq!(plain[0], ["scans/ball.ply", "out/ball.ply"]);
    assert_eq!(planned(&place, "./scans/**/*.ply"), plain);
}

#[test]
fn files_from_the_root_and_from_here_have_a_folder_in_common() {
    let place = good(2);
    let here = std::fs::canonicalize(place.0.path()).expect("the folder is there");
    let first = here.join("scans/0.ply").display().to_string();
    let found = planned(&place, &format!("{first} scans/1.ply"));
    let expected = [[first.as_str(), "out/0.ply"], ["scans/1.ply", "out/1.ply"]];
    assert_eq!(found, expected);
}

#[test]
fn a_scan_with_other_options_needs_another_result() {
    let place = good(1);
    place.text(
        "jobs.json",
        r#"{"jobs": ["scans/0.ply", {"input": "scans/0.ply", "options": {"complete": {"window": 4}}}]}"#,
    );
    refused(
        &place,
        "batch jobs.json --out out",
        &[
            "out/scans/0.ply",
            "both scans/0.ply and scans/0.ply",
            "an output of its own",
        ],
    );
    place.text("jobs.json", r#"{"jobs": ["scans/0.ply", "scans/0.ply"]}"#);
    assert_eq!(planned(&place, "jobs.json").len(), 1);
}

#[test]
fn there_is_no_standard_input_or_output_for_scans() {
    let place = good(1);
    place.text("jobs.json", r#"{"jobs": ["-"]}"#);
    for (name, steps) in [
        (
            "csv.json",
            r#"[{"type": "stats", "whole": true, "csv": "-"}]"#,
        ),
        (
            "write.json",
            r#"[{"type": "write", "path": "-"}, {"type": "complete"}]"#,
        ),
        ("other.json", r#"[{"type": "compare", "other": "-"}]"#),
        (
            "read.json",
            r#"[{"type": "fit"}, {"type": "read", "path": "-"}]"#,
        ),
    ] {
        place.text(name, steps);
        let line = format!("batch scans/*.ply --out out --pipeline {name}");
        refused(
            &place,
            &line,
            &["scans/0.ply: a batch has no standard input", "give files"],
        );
    }
    for given in ["-", "jobs.json", "/dev/stdin"] {
        let line = format!("batch {given} --out out");
        refused(
            &place,
            &line,
            &["a batch has no standard input", "give files"],
        );
    }
}
