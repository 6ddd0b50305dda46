//! Which files a pipeline is kept from.

use serde_json::{Value, json};

use super::{pipeline, place};

#[test]
fn the_json_is_written_over_nothing_that_the_pipeline_has_to_do_with() {
    let place = place();
    let steps = json!(["in.ply", { "type": "stats", "csv": "figures.csv" }, "out.ply"]);
    let good = pipeline(&steps);
    place.text("p.json", &good);
    place.text("notes.json", "mine");
    let scan = place.bytes("in.ply");
    for (json, words) in [
        ("in.ply", "--json would overwrite the input"),
        ("p.json", "--json would overwrite the input"),
        (
            "./out.ply",
            "out.ply and --json ./out.ply cannot both go there",
        ),
        (
            "figures.csv",
            "figures.csv and --json figures.csv cannot both go there",
        ),
    ] {
        let run = place.run(&format!("run p.json --json {json}"));
        assert_eq!(run.code, 2, "{json}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{json}: {}", run.stderr);
    }
    // What is wrong with a pipeline is not written over what it may read or write.
    place.text("p.json", "[\"in.ply\", ");
    for json in ["in.ply", "p.json", "notes.json"] {
        let run = place.run(&format!("run p.json --json {json}"));
        assert_eq!(run.code, 2, "{json}: {}", run.stderr);
        assert!(run.stderr.contains("this is no JSON"), "{}", run.stderr);
    }
    assert!(place.bytes("in.ply") == scan);
    assert_eq!(place.bytes("p.json"), b"[\"in.ply\", ");
    assert_eq!(place.bytes("notes.json"), b"mine");
    assert_eq!(place.files(), ["in.ply", "notes.json", "p.json"]);
    assert_eq!(place.run("run p.json --json new.json").code, 2);
    assert_eq!(place.json("new.json")["status"], "failed");
    assert_eq!(place.run("run none.json --json none.json").code, 1);
    assert!(!place.path("none.json").exists());
}

#[test]
fn standard_output_has_the_json_or_a_scan() {
    let place = place();
    let text = pipeline(&json!(["in.ply", { "type": "info" }, "-"]));
    place.text("p.json", &text);
    let run = place.run("run p.json --json -");
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(
        run.stderr.contains("cannot both go there"),
        "{}",
        run.stderr
    );
    assert!(run.stdout.is_empty());
    // With figures on it, there is no other text.
    let steps =
        json!(["in.ply", { "type": "info" }, { "type": "stats", "whole": true, "csv": "-" }]);
    place.text("p.json", &pipeline(&steps));
    let run = place.done("run p.json");
    let alone = place.done("stats in.ply --whole --csv - --seed 5");
    assert!(
        run.stdout == alone.stdout,
        "{}",
        String::from_utf8_lossy(&run.stdout)
    );
    let json: Value =
        serde_json::from_slice(&place.done("info in.ply --json -").stdout).expect("it is JSON");
    assert_eq!(json["status"], "done");
}
