//! What is done to each scan: pipelines, options, files of jobs.

use relievo::scan::{ReadOptions, WriteOptions, read, write};
use serde_json::json;

use super::{QUICK, good, lines, results};

#[test]
#[cfg(feature = "image")]
fn a_pipeline_names_its_further_outputs_after_the_scan() {
    let place = good(2);
    let pipeline = json!({ "seed": 4, "pipeline": [
        "any.ply",
        { "type": "complete", "window": 2, "rotations": 1 },
        { "type": "render", "output": "{out}/{stem}.png", "size": "64x48" },
        "any.ply"
    ]});
    place.text("p.json", &pipeline.to_string());
    let run = place.done("batch scans/*.ply --out out --pipeline p.json");
    let names: Vec<String> = results(&place, "out").into_keys().collect();
    assert_eq!(names, ["0.ply", "0.png", "1.ply", "1.png"]);
    assert_eq!(lines(&run)["scans/0.ply"]["seed"], 4);
    // By itself, the same.
    let alone = json!({ "seed": 4, "pipeline": [
        "scans/1.ply", { "type": "complete", "window": 2, "rotations": 1 }, "alone.ply"
    ]});
    place.text("alone.json", &alone.to_string());
    place.done("run alone.json");
    assert!(place.bytes("alone.ply") == place.bytes("out/1.ply"));
    // Without the picture, it is there no more to be skipped.
    std::fs::remove_file(place.path("out/1.png")).expect("it is there");
    let run = place.done("batch scans/*.ply --out out --pipeline p.json --resume");
    let statuses: Vec<_> = lines(&run)
        .values()
        .map(|line| line["status"].clone())
        .collect();
    assert_eq!(statuses, ["skipped", "done"]);
    assert!(place.path("out/1.png").exists());
}

#[test]
fn a_file_of_jobs_gives_each_scan_its_own_options_and_place() {
    let place = good(3);
    let jobs = json!({
        "pipeline": [{ "type": "complete", "window": 2, "rotations": 1 }],
        "jobs": [
            "0.ply",
            { "input": "1.ply", "output": "deep/one.off", "options": { "complete": { "window": 3 } } },
            { "input": "2.ply", "pipeline": [{ "type": "stats", "whole": true }] }
        ]
    });
    place.text("scans/jobs.json", &jobs.to_string());
    let run = place.done("batch scans/jobs.json --out out --seed 7");
    let names: Vec<String> = results(&place, "out").into_keys().collect();
    assert_eq!(names, ["0.ply", "2.ply", "deep/one.off"]);
    assert!(lines(&run).values().all(|line| line["seed"] == 7));
    place.done("complete scans/0.ply -o 0.ply --window 2 --rotations 1 --seed 7");
    place.done("complete scans/1.ply -o 1.off --window 3 --rotations 1 --seed 7");
    assert!(place.bytes("0.ply") == place.bytes("out/0.ply"));
    assert!(place.bytes("1.off") == place.bytes("out/deep/one.off"));
    assert_eq!(place.scan("out/2.ply"), place.scan("scans/2.ply"));
}

#[test]
fn results_are_written_in_the_scans_format_or_in_the_one_asked_for() {
    let place = good(2);
    let scan = read(&place.path("scans/0.ply"), &ReadOptions::default()).expect("it is a scan");
    write(&scan, &place.path("scans/c.stl"), &WriteOptions::default()).expect("it can be written");
    place.done(&format!("batch scans/0.ply scans/c.stl --out out {QUICK}"));
    place.done(&format!(
        "batch scans/0.ply scans/c.stl --out off {QUICK} --format off"
    ));
    let names = |folder| results(&place, folder).into_keys().collect::<Vec<String>>();
    assert_eq!(names("out"), ["0.ply", "c.stl"]);
    assert_eq!(names("off"), ["0.off", "c.off"]);
}
