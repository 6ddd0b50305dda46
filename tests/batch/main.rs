//! Many scans: what is said of each, what is there at the end, whatever happens in between.

#[path = "../common/mod.rs"]
mod common;

mod given;
mod interrupted;
mod kept;
mod limits;
#[cfg(all(feature = "image", feature = "report"))]
mod page;
mod refused;
mod resumed;
mod steps;
mod told;

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use common::place::{Place, Run};
use common::{holed, synthetic};
use relievo::synth::{Kind, Part};
use serde_json::Value;

/// Options of a completion that takes a moment only.
const QUICK: &str = "--step.complete.window=2 --step.complete.rotations=1";

/// Scans in `scans`: two good ones, one of them in a folder of its own; one to repair; two that cannot be read.
fn mixed() -> Place {
    let place = Place::new();
    fs::create_dir_all(place.path("scans/deep")).expect("folders can be made");
    place.put("scans/ball.ply", &holed(Kind::GolfBall));
    place.put("scans/deep/wall.obj", &holed(Kind::Bricks));
    let mut dirty = holed(Kind::Waves);
    let face: Vec<u32> = dirty.faces.row(5).to_vec();
    dirty.faces.push_row(&face);
    dirty.faces.push_row(&[face[0], face[0], face[1]]);
    dirty.face_channels.rows = dirty.faces.len();
    place.put("scans/dirty.ply", &dirty);
    place.text(
        "scans/broken.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\n",
    );
    place.text("scans/empty.ply", "");
    place
}

/// Good scans of about so many vertices, in `scans`.
fn good(count: usize) -> Place {
    let place = Place::new();
    fs::create_dir_all(place.path("scans")).expect("folders can be made");
    let kinds = [Kind::GolfBall, Kind::Bricks, Kind::Waves, Kind::Bark];
    for index in 0..count {
        let scan = synthetic(
            kinds[index % 4],
            Part::hole(0.03 + 0.01 * (index / 4) as f64),
        );
        place.put(&format!("scans/{index}.ply"), &scan);
    }
    place
}

/// The lines on standard output, by input.
fn lines(run: &Run) -> BTreeMap<String, Value> {
    let text = String::from_utf8(run.stdout.clone()).expect("lines are UTF-8");
    let parsed = text.lines().map(|line| {
        let value: Value = serde_json::from_str(line).expect("each line is JSON");
        (
            value["input"]
                .as_str()
                .expect("it names its scan")
                .to_owned(),
            value,
        )
    });
    let lines: BTreeMap<String, Value> = parsed.collect();
    assert_eq!(lines.len(), text.lines().count(), "one line a scan: {text}");
    lines
}

/// How each scan ended, by input.
fn statuses(run: &Run) -> BTreeMap<String, String> {
    let status = |line: &Value| line["status"].as_str().expect("it says how").to_owned();
    lines(run)
        .iter()
        .map(|(input, line)| (input.clone(), status(line)))
        .collect()
}

/// How often each status is there.
fn counted(run: &Run) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for status in statuses(run).into_values() {
        *counts.entry(status).or_default() += 1;
    }
    counts
}

/// All files below a folder but those of the batch itself, by path.
fn results(place: &Place, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    collect(&place.path(folder), "", &mut found);
    found.retain(|name, _| !name.starts_with(".relievo/"));
    found
}

fn collect(folder: &Path, prefix: &str, found: &mut BTreeMap<String, Vec<u8>>) {
    for entry in fs::read_dir(folder).expect("the folder is there") {
        let entry = entry.expect("and can be read");
        let name = format!(
            "{prefix}{}",
            entry.file_name().to_str().expect("names are UTF-8")
        );
        if entry.path().is_dir() {
            collect(&entry.path(), &format!("{name}/"), found);
            continue;
        }
        match fs::read(entry.path()) {
            Ok(bytes) => _ = found.insert(name, bytes),
            // A process that ends takes its temporary file with it, also while this looks.
            Err(error) if error.kind() == ErrorKind::NotFound && name.ends_with(".tmp") => {}
            Err(error) => panic!("{name}: {error}"),
        }
    }
}

/// No temporary file is anywhere in the folder.
#[track_caller]
fn assert_clean(place: &Place, folder: &str) {
    let mut found = BTreeMap::new();
    collect(&place.path(folder), "", &mut found);
    let left: Vec<&String> = found.keys().filter(|name| name.ends_with(".tmp")).collect();
    assert!(left.is_empty(), "{left:?}");
}

/// Refused as wrong usage, in one sentence with these words, and nothing new is there.
#[track_caller]
fn refused(place: &Place, line: &str, words: &[&str]) {
    let before = place.files();
    let run = place.run(line);
    assert_eq!(run.code, 2, "{line}: {}", run.stderr);
    for word in words {
        assert!(
            run.stderr.contains(word),
            "{line}: no {word:?} in {}",
            run.stderr
        );
    }
    assert_eq!(run.stderr.lines().count(), 1, "{line}: {}", run.stderr);
    assert!(run.stdout.is_empty(), "{line}");
    assert_eq!(place.files(), before, "{line}");
}

#[test]
fn one_failing_scan_never_stops_the_rest() {
    let place = mixed();
    let run = place.run(&format!(
        "batch scans/**/* --out out {QUICK} --json all.json"
    ));
    assert_eq!(run.code, 1, "{}", run.stderr);
    let found = statuses(&run);
    let expected = [
        ("scans/ball.ply", "done"),
        ("scans/broken.ply", "failed"),
        ("scans/deep/wall.obj", "done"),
        ("scans/dirty.ply", "done"),
        ("scans/empty.ply", "failed"),
    ];
    let expected: BTreeMap<String, String> = (expected.iter())
        .map(|(input, status)| ((*input).to_owned(), (*status).to_owned()))
        .collect();
    assert_eq!(found, expected, "{}", run.stderr);
    let written: Vec<String> = results(&place, "out").into_keys().collect();
    assert_eq!(written, ["ball.ply", "deep/wall.obj", "dirty.ply"]);
    assert_clean(&place, "out");
    let told = lines(&run);
    let ball = &told["scans/ball.ply"];
    assert_eq!(ball["output"], "out/ball.ply");
    assert_eq!(ball["counts"]["filled"], 1);
    assert_eq!(ball["counts"]["left_open"], 0);
    assert_eq!(ball["seed"], 0);
    assert_eq!(ball["error"], Value::Null);
    assert_eq!(ball["key"].as_str().map(str::len), Some(64));
    assert!(
        ball["seconds"]
            .as_f64()
            .is_some_and(|seconds| seconds > 0.0)
    );
    if cfg!(target_os = "linux") {
        assert!(
            ball["peak_memory"]
                .as_u64()
                .is_some_and(|bytes| bytes > 1 << 20)
        );
    }
    let repaired = told["scans/dirty.ply"]["warnings"].to_string();
    assert!(repaired.contains("left out"), "{repaired}");
    let broken = told["scans/broken.ply"]["error"]
        .as_str()
        .expect("it says why");
    assert!(broken.contains("scans/broken.ply"), "{broken}");
    // Failures come first in the summary.
    let first: Vec<&str> = run.stderr.lines().take(2).collect();
    assert!(
        first
            .iter()
            .all(|line| line.starts_with("relievo: failed: ")),
        "{}",
        run.stderr
    );
    assert!(run.stderr.contains("2 of 5 scans failed"), "{}", run.stderr);
    assert_eq!(place.json("all.json")["counts"]["failed"], 2);
    // The very bytes that the command by itself writes.
    place.done("complete scans/ball.ply -o ball.ply --window 2 --rotations 1");
    assert!(place.bytes("ball.ply") == place.bytes("out/ball.ply"));
}

#[test]
fn the_number_of_jobs_and_the_memory_do_not_change_a_byte() {
    let place = good(4);
    let first = place.done(&format!("batch scans/*.ply --out 1 {QUICK} --jobs 1"));
    let second = place.done(&format!(
        "batch scans/*.ply --out 2 {QUICK} --jobs 2 --threads 4"
    ));
    let third = place.done(&format!(
        "batch scans/*.ply --out 3 {QUICK} --jobs 4 --memory 100M"
    ));
    let expected = results(&place, "1");
    assert_eq!(expected.len(), 4);
    assert!(results(&place, "2") == expected);
    assert!(results(&place, "3") == expected);
    let keys = |run: &Run| -> Vec<Value> {
        lines(run)
            .values()
            .map(|line| line["key"].clone())
            .collect()
    };
    assert_eq!(keys(&first), keys(&second));
    assert_eq!(keys(&first), keys(&third));
}

#[test]
fn gaps_that_stay_open_are_told_by_the_exit_code_also_when_resumed() {
    let place = Place::new();
    fs::create_dir(place.path("scans")).expect("folders can be made");
    place.put("scans/wall.ply", &holed(Kind::Bricks));
    // The wall's outer rim cannot be closed.
    let line = format!("batch scans/*.ply --out out {QUICK} --step.complete.holes=0,1 --resume");
    let run = place.run(&line);
    let again = place.run(&line);
    assert_eq!((run.code, again.code), (3, 3), "{}", again.stderr);
    let [first, second] = [&run, &again].map(|run| lines(run)["scans/wall.ply"].clone());
    assert_eq!(first["status"], "partly");
    assert_eq!(second["status"], "skipped");
    assert_eq!(second["was"], "partly");
    assert_eq!(first["counts"]["left_open"], 1);
    assert_eq!(first["counts"], second["counts"]);
    assert!(
        again.stderr.contains("1 gap(s) left open"),
        "{}",
        again.stderr
    );
}
