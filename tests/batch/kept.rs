//! Files that are somebody else's stay as they are.

use std::fs;

use super::{QUICK, good, lines, refused, results, statuses};
use crate::common::place::Place;

#[test]
fn the_json_and_the_page_are_written_over_nothing_that_a_batch_has_to_do_with() {
    let place = good(2);
    place.text("jobs.json", r#"{"jobs": ["scans/0.ply"]}"#);
    place.text(
        "p.json",
        r#"[{"type": "stats", "whole": true, "csv": "{out}/{stem}.csv"}]"#,
    );
    place.text("wrong.json", r#"{"jobs": ["scans/0.ply""#);
    fs::create_dir(place.path("out")).expect("folders can be made");
    for (line, words) in [
        (
            "scans/*.ply --json scans/0.ply",
            vec!["--json would overwrite the input"],
        ),
        (
            "jobs.json --json jobs.json",
            vec!["--json would overwrite the input"],
        ),
        (
            "jobs.json --json scans/0.ply",
            vec!["--json would overwrite the input"],
        ),
        (
            "scans/*.ply --pipeline p.json --json p.json",
            vec!["--json would overwrite"],
        ),
        (
            "scans/*.ply --pipeline p.json --json out/1.csv",
            vec!["cannot both go there"],
        ),
        ("scans/*.ply --json out/1.ply", vec!["cannot both go there"]),
        (
            "scans/*.ply --report a.html --json ./a.html",
            vec!["--report a.html and --json"],
        ),
        (
            "scans/*.ply --pipeline p.json --report p.json",
            vec!["--report would overwrite"],
        ),
        (
            "scans/*.ply --pipeline p.json --report out/1.csv",
            vec!["cannot both go there"],
        ),
        // The list cannot be read: nobody knows what its scans are.
        ("wrong.json --json scans/1.ply", vec!["no list of jobs"]),
        ("wrong.json --json wrong.json", vec!["no list of jobs"]),
    ] {
        refused(&place, &format!("batch {line} --out out"), &words);
    }
    let missing = place.run("batch wrong.json --json new.json --out out");
    assert_eq!(missing.code, 2, "{}", missing.stderr);
    assert_eq!(place.json("new.json")["status"], "failed");
    assert!(results(&place, "out").is_empty());
}

#[test]
fn a_file_that_takes_the_place_of_a_failed_result_is_kept() {
    let place = good(1);
    let scan = place.bytes("scans/0.ply");
    place.text("scans/0.ply", "ply\n");
    let line = format!("batch scans/*.ply --out out {QUICK}");
    assert_eq!(place.run(&line).code, 1);
    assert!(!place.path("out/.relievo/0.ply.begun").exists());
    // By hand, then.
    place.text("out/0.ply", "mine");
    fs::write(place.path("scans/0.ply"), scan).expect("it can be written");
    refused(
        &place,
        &format!("{line} --resume"),
        &["out/0.ply", "--overwrite"],
    );
    assert_eq!(place.bytes("out/0.ply"), b"mine");
}

#[test]
fn what_a_killed_run_has_noted_is_its_own_as_long_as_it_is_the_same() {
    let place = good(1);
    let line = |folder: &str| format!("batch scans/*.ply --out {folder} {QUICK} --resume");
    place.done(&line("out"));
    // As if it had been killed before it could keep its record.
    fs::remove_file(place.path("out/.relievo/0.ply.json")).expect("it is there");
    let hash = relievo::scan::trace::sha256(&place.bytes("out/0.ply"));
    let note = format!("{{\"path\": \"0.ply\", \"sha256\": \"{hash}\"}}\n");
    place.text("out/.relievo/0.ply.begun", &note);
    fs::rename(place.path("out"), place.path("moved")).expect("it can be moved");
    place.done(&line("moved"));
    assert!(!place.path("moved/.relievo/0.ply.begun").exists());
    fs::remove_file(place.path("moved/.relievo/0.ply.json")).expect("it is there");
    place.text("moved/.relievo/0.ply.begun", &note);
    place.text("moved/0.ply", "mine");
    refused(&place, &line("moved"), &["moved/0.ply", "--overwrite"]);
}

#[test]
fn what_one_job_reads_no_other_writes() {
    let place = good(2);
    let jobs = r#"{"jobs": [
        {"input": "scans/0.ply", "pipeline": [{"type": "stats", "whole": true, "csv": "table.ply"}]},
        {"input": "scans/1.ply", "pipeline": [{"type": "compare", "other": "table.ply"}]}]}"#;
    place.text("jobs.json", jobs);
    refused(
        &place,
        "batch jobs.json --out out",
        &["table.ply would be written over table.ply, which is read by a step of this batch"],
    );
}

#[test]
#[cfg(feature = "image")]
fn results_that_are_named_after_the_scan_are_made_anew_with_its_name() {
    let place = good(1);
    let pipeline = r#"[{"type": "render", "output": "{out}/{name}.png", "size": "64x48"}]"#;
    place.text("p.json", pipeline);
    let job = |input: &str| format!(r#"{{"jobs": [{{"input": "{input}", "output": "a.ply"}}]}}"#);
    let line = "batch jobs.json --out out --pipeline p.json --resume";
    let of = |place: &Place| {
        statuses(&place.done(line))
            .into_values()
            .collect::<Vec<_>>()
    };
    place.text("jobs.json", &job("scans/0.ply"));
    assert_eq!(of(&place), ["done"]);
    assert_eq!(of(&place), ["skipped"]);
    fs::rename(place.path("scans/0.ply"), place.path("scans/b.ply")).expect("it can be renamed");
    place.text("jobs.json", &job("scans/b.ply"));
    assert_eq!(of(&place), ["done"]);
    assert!(place.path("out/b.ply.png").exists());
}

#[test]
#[cfg(target_os = "linux")]
fn folders_whose_names_are_no_unicode_hang_nothing() {
    use std::os::unix::ffi::OsStrExt;
    let place = good(1);
    // As Latin-1 has it.
    let folder = place.0.path().join(std::ffi::OsStr::from_bytes(b"caf\xe9"));
    fs::create_dir(&folder).expect("folders can be made");
    fs::rename(place.path("scans"), folder.join("scans")).expect("it can be moved");
    let run = || {
        std::process::Command::new(env!("CARGO_BIN_EXE_relievo"))
            .args(format!("batch scans/*.ply --out out {QUICK}").split_whitespace())
            .current_dir(&folder)
            .stdin(std::process::Stdio::null())
            .output()
            .expect("the program runs")
    };
    assert_eq!(run().status.code(), Some(0));
    // What it may replace is told by absolute paths, which cannot be said here.
    let again = run();
    let stderr = String::from_utf8_lossy(&again.stderr);
    assert_eq!(again.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("not valid Unicode"), "{stderr}");
}

#[test]
#[cfg(feature = "image")]
fn pictures_of_an_older_result_are_not_kept() {
    let place = good(1);
    let line = format!("batch scans/*.ply --out out {QUICK}");
    place.done(&format!("{line} --report out/index.html"));
    assert!(place.path("out/.relievo/0.ply.after.png").exists());
    place.done(&format!("{line} --seed 2"));
    for picture in ["before", "after"] {
        let path = format!("out/.relievo/0.ply.{picture}.png");
        assert!(!place.path(&path).exists(), "{path}");
    }
    let run = place.done(&format!("{line} --seed 2 --resume --report out/index.html"));
    assert_eq!(lines(&run)["scans/0.ply"]["status"], "skipped");
    assert!(place.path("out/.relievo/0.ply.after.png").exists());
}
