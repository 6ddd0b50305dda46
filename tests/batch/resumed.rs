//! What is skipped with `--resume`, and what is not: by content, not by name or time.

use std::fs;

use super::{QUICK, counted, good, lines, results, statuses};
use crate::common::place::Place;
use crate::common::synthetic;
use relievo::synth::{Kind, Part};

fn line() -> String {
    format!("batch scans/*.ply --out out {QUICK} --resume")
}

/// How each scan ends when the batch is resumed, in order.
fn again(place: &Place, line: &str) -> Vec<String> {
    statuses(&place.done(line)).into_values().collect()
}

#[test]
fn what_is_done_is_skipped_unless_content_or_options_change() {
    let place = good(3);
    assert_eq!(again(&place, &line()), ["done", "done", "done"]);
    let first = results(&place, "out");
    assert_eq!(again(&place, &line()), ["skipped", "skipped", "skipped"]);
    assert!(results(&place, "out") == first);
    // Written anew, with the same content.
    let bytes = place.bytes("scans/0.ply");
    fs::write(place.path("scans/0.ply"), &bytes).expect("it can be written");
    assert_eq!(again(&place, &line()), ["skipped", "skipped", "skipped"]);
    // Other content.
    place.put("scans/1.ply", &synthetic(Kind::Bricks, Part::hole(0.05)));
    assert_eq!(again(&place, &line()), ["skipped", "done", "skipped"]);
    assert!(results(&place, "out")["1.ply"] != first["1.ply"]);
    // A result that was changed or is gone.
    place.text("out/2.ply", "changed");
    fs::remove_file(place.path("out/0.ply")).expect("it is there");
    let run = place.done(&line());
    let ends: Vec<String> = statuses(&run).into_values().collect();
    assert_eq!(ends, ["done", "skipped", "done"]);
    assert!(results(&place, "out")["2.ply"] == first["2.ply"]);
    let warned = lines(&run)["scans/2.ply"]["warnings"].to_string();
    assert!(
        warned.contains("out/2.ply") && warned.contains("changed"),
        "{warned}"
    );
    // Another option, another seed; and back.
    let other = line().replace("window=2", "window=3");
    assert_eq!(again(&place, &other), ["done", "done", "done"]);
    assert_eq!(
        again(&place, &format!("{other} --seed 3")),
        ["done", "done", "done"]
    );
    assert_eq!(
        again(&place, &format!("{other} --seed 3")),
        ["skipped", "skipped", "skipped"]
    );
    // How many at a time is no matter.
    let slow = format!("{other} --seed 3 --jobs 1 --threads 1 --memory 1GiB");
    assert_eq!(again(&place, &slow), ["skipped", "skipped", "skipped"]);
    // Without --resume everything is done again.
    let all = format!("batch scans/*.ply --out out {QUICK}");
    assert_eq!(counted(&place.done(&all))["done"], 3);
}

#[test]
fn a_scan_with_another_name_is_done_again_and_two_that_swap_names_too() {
    let place = good(2);
    let first = place.done(&line());
    let keys = |run| -> Vec<_> {
        lines(run)
            .values()
            .map(|line| line["key"].clone())
            .collect()
    };
    fs::rename(place.path("scans/0.ply"), place.path("scans/9.ply")).expect("it can be renamed");
    let run = place.done(&line());
    let expected: Vec<String> = ["skipped", "done"].map(str::to_owned).to_vec();
    assert_eq!(statuses(&run).into_values().collect::<Vec<_>>(), expected);
    // The key is that of the content.
    let (before, after) = (keys(&first), keys(&run));
    assert_eq!([&before[0], &before[1]], [&after[1], &after[0]]);
    assert!(place.bytes("out/9.ply") == place.bytes("out/0.ply"));
    fs::rename(place.path("scans/1.ply"), place.path("scans/tmp")).expect("it can be renamed");
    fs::rename(place.path("scans/9.ply"), place.path("scans/1.ply")).expect("it can be renamed");
    fs::rename(place.path("scans/tmp"), place.path("scans/9.ply")).expect("it can be renamed");
    assert_eq!(again(&place, &line()), ["done", "done"]);
}

#[test]
fn a_moved_scan_with_the_same_result_is_skipped() {
    let place = good(1);
    let job = |input: &str| format!(r#"{{"jobs": [{{"input": "{input}", "output": "a.ply"}}]}}"#);
    let line = format!("batch jobs.json --out out {QUICK} --resume");
    place.text("jobs.json", &job("scans/0.ply"));
    assert_eq!(again(&place, &line), ["done"]);
    fs::rename(place.path("scans/0.ply"), place.path("moved.ply")).expect("it can be moved");
    place.text("jobs.json", &job("moved.ply"));
    assert_eq!(again(&place, &line), ["skipped"]);
}

#[test]
fn the_folders_of_scans_and_results_can_be_moved_together() {
    let place = good(2);
    fs::create_dir(place.path("here")).expect("folders can be made");
    fs::rename(place.path("scans"), place.path("here/scans")).expect("it can be moved");
    let line =
        |folder: &str| format!("batch {folder}/scans/*.ply --out {folder}/out {QUICK} --resume");
    assert_eq!(again(&place, &line("here")), ["done", "done"]);
    fs::rename(place.path("here"), place.path("there")).expect("it can be moved");
    assert_eq!(again(&place, &line("there")), ["skipped", "skipped"]);
}

#[test]
#[cfg(feature = "image")]
fn files_that_a_scan_refers_to_belong_to_its_content() {
    let place = good(1);
    let obj = "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
    place.text("scans/a.obj", obj);
    let pipeline = r#"[{"type": "info"}]"#;
    place.text("p.json", pipeline);
    let line = "batch scans/a.obj --out out --pipeline p.json --resume";
    // The material is missing at first.
    assert_eq!(again(&place, line), ["done"]);
    assert_eq!(again(&place, line), ["skipped"]);
    place.text("scans/a.mtl", "newmtl m\nKd 1 0 0\n");
    assert_eq!(again(&place, line), ["done"]);
    assert_eq!(again(&place, line), ["skipped"]);
    place.text("scans/a.mtl", "newmtl m\nKd 0 1 0\n");
    assert_eq!(again(&place, line), ["done"]);
}

#[test]
fn records_that_are_damaged_are_no_records() {
    let place = good(1);
    place.done(&line());
    place.text("out/.relievo/0.ply.json", "{\"key\":");
    let run = place.run(&line());
    assert_eq!(
        run.code, 2,
        "what is there may be anybody's: {}",
        run.stderr
    );
    place.done(&format!("{} --overwrite", line()));
    assert_eq!(again(&place, &line()), ["skipped"]);
}
