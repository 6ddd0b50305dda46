//! What is refused before anything is done, or never written over.

use super::{QUICK, assert_clean, good, mixed, refused, results, statuses};

#[test]
fn mistakes_are_told_before_anything_is_done() {
    let place = mixed();
    place.text(
        "p.json",
        r#"[{"type": "complete"}, {"type": "render", "output": "x.png"}]"#,
    );
    place.text("wrong.json", r#"[{"type": "fill"}]"#);
    place.text(
        "jobs.json",
        r#"{"jobs": [{"input": "scans/ball.ply", "options": {"fill": {"window": 3}}}]}"#,
    );
    place.text(
        "jobs2.json",
        r#"{"jobs": [{"input": "scans/ball.ply", "output": "b.ply"}, "scans/b.ply"]}"#,
    );
    std::fs::copy(place.path("scans/ball.ply"), place.path("scans/b.ply"))
        .expect("it can be copied");
    for (line, words) in [
        (
            "batch scans/*.xyz --out out",
            vec!["scans/*.xyz", "no file"],
        ),
        (
            "batch scans --out out",
            vec!["scans is a folder", "scans/*.ply"],
        ),
        (
            "batch scans/*.ply --out out --pipeline wrong.json",
            vec!["step 2", "fill"],
        ),
        (
            "batch scans/*.ply --out out --pipeline p.json",
            vec!["x.png", "both", "{stem}"],
        ),
        (
            "batch scans/*.ply --out out --step.complete.windows=3",
            vec!["windows", "window"],
        ),
        (
            "batch scans/*.ply --out out --step.fill.window=3",
            vec!["fill", "complete"],
        ),
        (
            "batch jobs.json --out out",
            vec!["scans/ball.ply", "fill", "complete"],
        ),
        (
            "batch scans/*.ply --out scans",
            vec!["scans/*.ply", "folder of results"],
        ),
        (
            "batch scans/ball.ply --out scans",
            vec!["written over", "another folder"],
        ),
        (
            "batch jobs2.json --out scans",
            vec!["scans/b.ply would be written over", "another folder"],
        ),
        (
            "batch scans/*.ply --out out --report scans/ball.ply",
            vec!["--report", "overwrite"],
        ),
        (
            "batch scans/*.ply --out out --report -",
            vec!["--report", "name"],
        ),
    ] {
        refused(&place, line, &words);
    }
}

#[test]
fn the_json_of_all_does_not_go_where_that_of_each_goes() {
    let place = good(1);
    let run = place.run("batch scans/*.ply --out out --json -");
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("a line of JSON"), "{}", run.stderr);
    let json: serde_json::Value = serde_json::from_slice(&run.stdout).expect("it is JSON");
    assert_eq!(json["status"], "failed");
    assert_eq!(place.files(), ["scans"]);
}

#[test]
fn two_scans_with_one_result_are_refused() {
    let place = good(1);
    std::fs::copy(place.path("scans/0.ply"), place.path("scans/0.xyz")).expect("it can be copied");
    refused(
        &place,
        "batch scans/0.* --out out",
        &["scans/0.ply", "scans/0.xyz", "out/0.ply"],
    );
}

#[test]
fn files_that_no_batch_has_written_are_kept_unless_told_otherwise() {
    let place = good(2);
    std::fs::create_dir(place.path("out")).expect("folders can be made");
    place.text("out/1.ply", "mine");
    let line = format!("batch scans/*.ply --out out {QUICK}");
    refused(&place, &line, &["out/1.ply", "--overwrite"]);
    assert_eq!(place.bytes("out/1.ply"), b"mine");
    place.done(&format!("{line} --overwrite"));
    assert!(place.bytes("out/1.ply") != b"mine");
    // What it has written itself it writes again.
    place.done(&line);
}

#[test]
#[cfg(feature = "image")]
fn further_outputs_are_not_written_over_either() {
    let place = good(2);
    place.text(
        "p.json",
        r#"[{"type": "complete", "window": 2, "rotations": 1}, {"type": "render", "output": "{out}/{stem}.png", "size": "64x48"}]"#,
    );
    std::fs::create_dir(place.path("out")).expect("folders can be made");
    place.text("out/1.png", "mine");
    let run = place.run("batch scans/*.ply --out out --pipeline p.json");
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert_eq!(statuses(&run)["scans/1.ply"], "failed");
    assert!(
        run.stderr.contains("out/1.png") && run.stderr.contains("--overwrite"),
        "{}",
        run.stderr
    );
    assert_eq!(place.bytes("out/1.png"), b"mine");
    assert_clean(&place, "out");
}

#[test]
fn a_scan_that_changes_its_name_into_a_result_is_never_written_over() {
    let place = good(1);
    std::fs::create_dir(place.path("out")).expect("folders can be made");
    std::fs::rename(place.path("scans/0.ply"), place.path("out/0.ply")).expect("it can be moved");
    let before = place.bytes("out/0.ply");
    let line = "batch out/0.ply --out out --overwrite";
    refused(&place, line, &["out/0.ply", "written over"]);
    assert!(place.bytes("out/0.ply") == before);
    assert_eq!(results(&place, "out").len(), 1);
}
