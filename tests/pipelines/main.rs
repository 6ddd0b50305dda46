//! Pipelines in a file: the same as the commands one after another, mistakes found before any work.
#![cfg(feature = "image")]

#[path = "../common/mod.rs"]
mod common;

mod files;
mod schema;

use common::place::Place;
use common::{holed, synthetic};
use relievo::cli::{Call, CallErrorKind, Content, Held, TiledCall, Watch, grow_tile};
use relievo::scan::Scan;
use relievo::synth::{Kind, Part};
use serde_json::{Value, json};

fn place() -> Place {
    Place::with("in.ply", &holed(Kind::Bricks))
}

fn pipeline(steps: &Value) -> String {
    json!({ "seed": 5, "pipeline": steps }).to_string()
}

/// Four steps that take a moment.
fn steps() -> Value {
    json!([
        "in.ply",
        { "type": "complete", "window": 2, "rotations": 1 },
        { "type": "stats", "pieces": 0, "csv": "figures.csv" },
        { "type": "write", "path": "text.ply", "ascii": true },
        { "type": "render", "size": "64x48", "output": "picture.png" },
        "out.obj"
    ])
}

#[test]
fn a_pipeline_gives_what_the_commands_give_one_after_another() {
    let place = place();
    let original = place.bytes("in.ply");
    place.text("p.json", &pipeline(&steps()));
    let run = place.done("run p.json --json run.json");
    assert_eq!(place.bytes("in.ply"), original);

    place.done("complete in.ply -o by_hand.ply --window 2 --rotations 1 --seed 5");
    place.done("complete in.ply -o by_hand.obj --window 2 --rotations 1 --seed 5");
    place.done("convert by_hand.ply by_hand_text.ply --ascii");
    let table = place.done("stats by_hand.ply --pieces 0 --seed 5 --csv by_hand.csv");
    place.done("render by_hand.ply -o by_hand.png --size 64x48 --seed 5");
    for (one, other) in [
        ("out.obj", "by_hand.obj"),
        ("text.ply", "by_hand_text.ply"),
        ("figures.csv", "by_hand.csv"),
        ("picture.png", "by_hand.png"),
    ] {
        assert!(place.bytes(one) == place.bytes(other), "{one} and {other}");
    }
    let table = String::from_utf8(table.stdout).unwrap();
    assert_eq!(
        String::from_utf8(run.stdout).unwrap(),
        format!("stats:\n{table}\n")
    );

    let report = place.json("run.json");
    assert_eq!(report["status"], "done");
    let told: Vec<&str> = (report["steps"].as_array().unwrap().iter())
        .map(|step| step["tag"].as_str().unwrap())
        .collect();
    assert_eq!(
        told,
        ["read", "complete", "stats", "write", "render", "write_2"]
    );
    assert_eq!(report["steps"][1]["parameters"]["window"], 2);
    assert_eq!(report["steps"][1]["seed"], 5);
}

#[test]
fn what_a_command_writes_as_json_can_be_run_again() {
    let place = place();
    place.put("plain.ply", &holed(Kind::GolfBall));
    place.put("copy.ply", &holed(Kind::Bricks));
    for (line, output) in [
        (
            "complete in.ply --window 2 --rotations 1 --seed 7 --blend --no-repair=weld -o out.ply",
            "out.ply",
        ),
        (
            "texture plain.ply --exemplar in.ply --vertices 600 --levels 1 -o out.ply --ascii",
            "out.ply",
        ),
        (
            "transfer --source in.ply --target plain.ply --shape none --up none --vertices 700 --rounds 1 -o out.ply",
            "out.ply",
        ),
        (
            "render in.ply --size 64x48 --view 30,-20 -o out.png",
            "out.png",
        ),
    ] {
        place.done(&format!("{line} --json said.json"));
        let first = place.bytes(output);
        std::fs::remove_file(place.path(output)).unwrap();
        place.done("run said.json --json again.json");
        assert!(place.bytes(output) == first, "{line}");
        assert_eq!(
            place.json("again.json")["pipeline"],
            place.json("said.json")["pipeline"],
            "{line}"
        );
    }
    for line in [
        "fit in.ply",
        "holes in.ply",
        "info in.ply",
        "stats in.ply --whole",
        "compare in.ply copy.ply --pieces 0",
    ] {
        let first = place.done(&format!("{line} --json said.json"));
        let again = place.done("run said.json");
        let tag = line.split(' ').next().unwrap();
        let first = String::from_utf8(first.stdout).unwrap();
        assert_eq!(
            String::from_utf8(again.stdout).unwrap(),
            format!("{tag}:\n{first}\n")
        );
    }
    // A height map is no scan, and what makes scans is no step.
    place.text("map.txt", "0 1 0\n1 0 1\n0 1 1\n");
    place.done("stats map.txt --step 1 --json map.json");
    assert!(place.json("map.json").get("pipeline").is_none());
}

#[test]
fn options_are_overridden_by_tag_and_the_seed_by_its_own_option() {
    let place = place();
    place.text(
        "p.json",
        &pipeline(&json!([
            "in.ply",
            { "type": "complete", "tag": "fill", "rotations": 1 },
            "out.ply"
        ])),
    );
    place.done("run p.json --step.fill.window=2 --step.fill.bootstrap --seed 9 --step write.path=other.ply");
    place.done("complete in.ply -o by_hand.ply --rotations 1 --window 2 --bootstrap --seed 9");
    assert!(place.bytes("other.ply") == place.bytes("by_hand.ply"));
    assert!(!place.path("out.ply").exists());
}

#[test]
fn a_pipeline_comes_from_standard_input_too() {
    let place = place();
    let text = pipeline(&json!(["in.ply", { "type": "fit" }]));
    let run = place.run_with("run --stdin", text.as_bytes());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stdout.starts_with(b"fit:\nplane"),
        "{}",
        String::from_utf8_lossy(&run.stdout)
    );
    // And scans go to standard output, alone.
    let text = pipeline(&json!(["in.ply", { "type": "fit" }, "-"]));
    let run = place.run_with("run -", text.as_bytes());
    assert_eq!(run.stdout, place.bytes("in.ply"));
}

#[test]
fn validation_reads_no_scan_and_writes_nothing() {
    let place = Place::new();
    place.text("p.json", &pipeline(&steps()));
    let run = place.done("run p.json --validate");
    assert_eq!(run.stdout, b"p.json: 6 steps, nothing wrong\n");
    assert_eq!(place.files(), ["p.json"]);
}

fn completing_with(options: &Value) -> Value {
    let mut step = json!({ "type": "complete" });
    let members = step.as_object_mut().expect("it is one");
    members.extend(options.as_object().expect("options are members").clone());
    json!(["in.ply", step, "out.ply"])
}

#[test]
fn options_that_cannot_be_are_named_with_their_step_before_anything_is_done() {
    let place = place();
    for (options, words) in [
        (
            json!({ "windw": 2 }),
            "step 2 (complete): complete has no option `windw`: did you mean `window`?",
        ),
        (json!({ "json": "x.json" }), "complete has no option `json`"),
        (json!({ "window": -2 }), "`window`: \"-2\" cannot be"),
        (
            json!({ "window": { "a": 1 } }),
            "`window`: expected a whole number from 0",
        ),
        (
            json!({ "extend": "perhaps" }),
            "`extend`: expected true or false",
        ),
        (
            json!({ "holes": "some" }),
            "`holes`: \"some\" cannot be: expected interior",
        ),
        (
            json!({ "method": "papr" }),
            "expected one of coherent, exhaustive, paper",
        ),
        (
            json!({ "max_edges": true }),
            "`max_edges`: expected a whole number from 0, not true",
        ),
        (
            json!({ "tag": "a.b" }),
            "`tag`: expected a name without dots",
        ),
    ] {
        place.text("p.json", &pipeline(&completing_with(&options)));
        place.refused(2, "run p.json", &["p.json: ", words]);
    }
}

#[test]
fn steps_that_cannot_be_are_named_before_anything_is_done() {
    let place = place();
    for (steps, words) in [
        (
            json!(["in.ply", { "type": "smooth" }]),
            "there is no step of type `smooth`: there are",
        ),
        (
            json!(["in.ply", { "type": "complet" }]),
            "did you mean `complete`?",
        ),
        (
            json!(["in.ply", { "holes": "all" }]),
            "step 2: it has no `type`",
        ),
        (
            json!(["in.ply", "a.ply", "b.ply"]),
            "step 2: only the first and the last step may be a path",
        ),
        (
            json!([{ "type": "complete" }, "out.ply"]),
            "there is no scan yet",
        ),
        (json!([]), "begin with the path of a scan"),
        (
            json!(["in.ply", { "type": "fit", "tag": "a" }, { "type": "fit", "tag": "a" }]),
            "step 3: there is a step with the tag `a` already",
        ),
        (
            json!(["in.ply", { "type": "render" }]),
            "`output` is missing",
        ),
        (
            json!(["in.ply", { "type": "texture" }]),
            "`exemplar` is missing",
        ),
        (
            json!(["in.ply", "in.ply"]),
            "step 2 (write): in.ply is what a step reads",
        ),
        (
            json!(["in.ply", { "type": "stats", "csv": "./in.ply" }]),
            "in.ply is what a step reads",
        ),
        (
            json!(["in.ply", { "type": "write", "path": "a.ply" }, "a.ply"]),
            "step 3 (write_2): a.ply is written by another step",
        ),
        (
            json!(["in.ply", { "type": "stats", "report": "page.html", "csv": "page.html" }]),
            "is written by another step",
        ),
        (
            json!(["in.ply", { "type": "write", "path": "-" }, { "type": "stats", "csv": "-" }]),
            "step 3 (stats): - is written by another step",
        ),
        (
            json!(["in.ply",
                { "type": "texture", "exemplar": "e.png", "keep_mesh": true, "output": "a.obj" },
                { "type": "render", "output": "a.png" }]),
            "step 3 (render): a.png is written by another step",
        ),
    ] {
        place.text("p.json", &pipeline(&steps));
        place.refused(2, "run p.json", &["p.json: ", words]);
    }
}

#[test]
fn files_that_are_no_pipelines_and_cannot_be_read_or_written_are_named() {
    let place = place();
    for (text, words) in [
        ("{\"pipeline\": [", "this is no JSON"),
        ("3", "a pipeline is an object with a list of steps"),
        ("{\"steps\": []}", "unknown member `steps`"),
        (
            "{\"pipeline\": [\"in.ply\"], \"seed\": -1}",
            "`seed`: expected a whole number",
        ),
    ] {
        place.text("p.json", text);
        place.refused(2, "run p.json", &["p.json: ", words]);
    }
    place.text("p.json", &pipeline(&json!(["in.ply", "out.ply"])));
    place.refused(
        2,
        "run p.json --step.fill.window=2",
        &["no step has the tag `fill`"],
    );
    place.refused(
        2,
        "run p.json --step.write=2",
        &["expected the tag and the option"],
    );
    place.refused(1, "run nothing.json", &["nothing.json"]);
    place.text(
        "p.json",
        &pipeline(&json!(["in.ply", { "type": "render", "output": "no/a.png" }])),
    );
    place.refused(
        1,
        "run p.json",
        &["step 2 (render): cannot write no/a.png", "make it first"],
    );
    place.text("p.json", &pipeline(&json!(["nothing.ply", "out.ply"])));
    place.refused(1, "run p.json", &["step 1 (read)", "nothing.ply"]);
}

#[test]
fn a_step_that_fails_keeps_what_was_written_whole_before_it() {
    let place = place();
    place.text(
        "p.json",
        &pipeline(&json!([
            "in.ply",
            { "type": "write", "path": "first.ply" },
            { "type": "stats", "pieces": 0 },
            "last.ply"
        ])),
    );
    let run = place.run("run p.json --json run.json");
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(
        run.stderr.contains("step 3 (stats): in.ply: "),
        "{}",
        run.stderr
    );
    assert_eq!(place.files(), ["first.ply", "in.ply", "p.json", "run.json"]);
    assert_eq!(place.bytes("first.ply"), place.bytes("in.ply"));
    let report = place.json("run.json");
    let statuses: Vec<&Value> = report["steps"]
        .as_array()
        .unwrap()
        .iter()
        .map(|s| &s["status"])
        .collect();
    assert_eq!(statuses, ["done", "done", "failed"]);
}

fn completing(scan: &Scan) -> Call {
    let mut call = Call::new("complete");
    call.hold(
        "wall",
        Held::new("the wall", Content::Scan(scan.clone().into())),
    );
    for (name, value) in [
        ("scan", json!("wall")),
        ("window", json!(2)),
        ("rotations", json!(1)),
        ("seed", json!(5)),
    ] {
        call.set(name, value);
    }
    call
}

#[test]
fn a_call_gives_the_scan_that_the_command_writes() {
    let place = place();
    place.done("complete in.ply -o out.ply --window 2 --rotations 1 --seed 5");
    let scan = place.scan("in.ply");
    let mut with_threads = completing(&scan);
    with_threads.threads(1);
    for call in [completing(&scan), with_threads] {
        let done = call.run().unwrap();
        place.put("called.ply", &done.scan.unwrap());
        assert!(place.bytes("called.ply") == place.bytes("out.ply"));
        assert_eq!(done.json["filled"].as_array().map(Vec::len), Some(1));
    }
    let mut call = Call::default();
    call.hold("wall", Held::new("the wall", Content::Scan(scan.into())));
    let steps = json!({ "seed": 5, "pipeline": ["wall", { "type": "complete", "window": 2, "rotations": 1 }] });
    let done = call.run_pipeline(&steps).unwrap();
    place.put("called.ply", &done.scan.unwrap());
    assert!(place.bytes("called.ply") == place.bytes("out.ply"));
}

#[test]
fn a_call_can_be_ended_and_its_mistakes_are_told_apart() {
    let scan = holed(Kind::Bricks);
    let mut call = completing(&scan);
    call.watch(Watch::new(|progress| progress.stage != "growth"));
    assert_eq!(call.run().unwrap_err().kind, CallErrorKind::Ended);

    let mut call = completing(&scan);
    call.set("windw", json!(3));
    let error = call.run().unwrap_err();
    assert_eq!(error.kind, CallErrorKind::Usage);
    assert_eq!(
        error.message,
        "complete has no option `windw`: did you mean `window`?"
    );

    let mut call = Call::new("stats");
    call.hold("wall", Held::new("the wall", Content::Scan(scan.into())));
    call.set("scan", json!("wall"));
    let error = call.run().unwrap_err();
    assert_eq!(error.kind, CallErrorKind::Work);
    assert!(error.message.starts_with("the wall: "), "{}", error.message);
    assert_eq!(
        Call::new("read").run().unwrap_err().message,
        "there is no command `read`"
    );
}

#[test]
fn tiles_that_workers_grow_give_what_the_command_gives() {
    let place = Place::with("in.ply", &synthetic(Kind::Bricks, Part::hole(0.4)));
    place.done(
        "complete in.ply -o out.ply --window 2 --rotations 1 --seed 5 --tile 600 --json out.json",
    );
    let report = place.json("out.json");
    let mut tiled = TiledCall::new({
        let mut call = completing(&place.scan("in.ply"));
        call.set("tile", json!(600));
        call
    })
    .unwrap();
    let rounds = tiled.rounds();
    assert_eq!(report["tiling"]["tiles"], rounds.iter().flatten().count());
    assert!(rounds.len() > 1, "one round shows nothing: {rounds:?}");
    let first = rounds[0][0];
    let late = tiled.task(rounds[1][0]).unwrap_err();
    assert!(late.message.contains("too early"), "{}", late.message);
    for round in &rounds {
        let missing = tiled.check().unwrap_err();
        assert!(missing.message.contains("put back"), "{}", missing.message);
        // In whatever order, and some of them twice, as after a worker has died.
        for tile in round.iter().rev() {
            let task = tiled.task(*tile).unwrap();
            let grown = grow_tile(&task, Some(1), None).unwrap();
            assert!(grown == grow_tile(&task, None, None).unwrap());
            tiled.put(*tile, &grown).unwrap();
            if *tile != first {
                let foreign = tiled.put(first, &grown).unwrap_err();
                assert!(
                    foreign.message.contains("another tile"),
                    "{}",
                    foreign.message
                );
            }
        }
    }
    let done = tiled.finish().unwrap();
    // What was read is the nearest number, or one next to it.
    let told: Value = serde_json::from_str(&Value::Object(done.json).to_string()).unwrap();
    for figures in ["seams", "tiling", "statistics", "counts", "filled"] {
        assert!(!report[figures].is_null(), "{figures}");
        assert_eq!(told[figures], report[figures], "{figures}");
    }
    place.put("tiled.ply", &done.scan.unwrap());
    assert!(place.bytes("tiled.ply") == place.bytes("out.ply"));
    let broken = grow_tile(b"relievo", None, None).unwrap_err();
    assert!(
        broken.message.contains("cannot be read"),
        "{}",
        broken.message
    );
    place.refused(
        2,
        "complete in.ply -o x.ply --tile 400 --method paper",
        &["cannot be tiled"],
    );
    place.refused(2, "complete in.ply -o x.ply --tile 20", &["--tile", "100"]);
    let alone = place.run("complete in.ply -o x.ply --overlap 3");
    assert_eq!(alone.code, 2);
    assert!(alone.stderr.contains("--tile"), "{}", alone.stderr);
}
