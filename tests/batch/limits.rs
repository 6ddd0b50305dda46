//! Limits of time and memory.

use relievo::synth::{Kind, Part, SynthParams, scan};

use super::{QUICK, assert_clean, good, lines, results, statuses};
use crate::common::place::Place;

/// A scan of so many vertices.
fn large(place: &Place, name: &str, vertices: usize) {
    let params = SynthParams {
        kind: Kind::Bricks,
        vertices,
        part: Part::hole(0.02),
        ..SynthParams::default()
    };
    place.put(
        name,
        &scan(&params).expect("the parameters are in range").scan,
    );
}

#[test]
fn what_takes_too_long_has_failed_and_the_rest_is_done() {
    let place = good(1);
    large(&place, "slow.ply", 20_000);
    // What is not slow is only read and written: it is done in time on any machine.
    let jobs = r#"{"jobs": [
        {"input": "slow.ply", "pipeline": [{"type": "complete", "method": "paper"}]},
        {"input": "scans/0.ply", "pipeline": [{"type": "info"}]}]}"#;
    place.text("jobs.json", jobs);
    let run = place.run("batch jobs.json --out out --jobs 2 --timeout 8");
    assert_eq!(run.code, 1, "{}", run.stderr);
    let told = lines(&run);
    let error = told["slow.ply"]["error"].as_str().expect("it says why");
    assert!(
        error.contains("longer than 8 s") && error.contains("--timeout"),
        "{error}"
    );
    assert_eq!(told["scans/0.ply"]["status"], "done");
    assert_eq!(results(&place, "out").len(), 1);
    assert_clean(&place, "out");
}

#[test]
#[cfg(target_os = "linux")]
fn what_needs_more_memory_than_all_may_have_fails_with_what_it_needed() {
    let place = good(1);
    large(&place, "large.ply", 150_000);
    // Tables of all places: some hundred megabytes.
    let run = place.run(&format!(
        "batch scans/0.ply large.ply --out out --jobs 2 --memory 90M {QUICK}"
    ));
    assert_eq!(run.code, 1, "{}", run.stderr);
    let found = statuses(&run);
    assert_eq!(found["scans/0.ply"], "done", "{}", run.stderr);
    assert_eq!(found["large.ply"], "failed", "{}", run.stderr);
    let told = lines(&run);
    let error = told["large.ply"]["error"].as_str().expect("it says why");
    assert!(
        error.contains("MiB") && error.contains("--memory"),
        "{error}"
    );
    assert!(
        told["large.ply"]["peak_memory"]
            .as_u64()
            .is_some_and(|bytes| bytes > 90_000_000)
    );
    assert_clean(&place, "out");
}

#[test]
#[cfg(all(target_os = "linux", feature = "image"))]
fn scans_that_are_too_much_together_are_all_done() {
    let place = good(3);
    // What large pictures take is not known beforehand.
    place.text(
        "p.json",
        r#"[{"type": "render", "output": "{out}/{stem}.png", "size": "2400x1800"}]"#,
    );
    let line = "batch scans/*.ply --pipeline p.json";
    let free = place.done(&format!("{line} --out free --jobs 1"));
    let lines = lines(&free);
    let peaks = lines
        .values()
        .filter_map(|line| line["peak_memory"].as_u64());
    // Room for one, not for two.
    let budget = peaks.max().expect("there are scans") * 3 / 2;
    let tight = place.done(&format!("{line} --out tight --jobs 3 --memory {budget}"));
    assert!(results(&place, "tight") == results(&place, "free"));
    assert!(!tight.stderr.contains("failed: "), "{}", tight.stderr);
    assert_clean(&place, "tight");
}
