//! Areal parameters of height maps, as whole commands, and against what other programs say of the same maps.

mod common;

use std::fmt::Write;
use std::fs;
use std::path::Path;

use common::place::Place;
use common::say_skipped;
use relievo::rng::{Rng, Stage};
use serde_json::Value;

const REFERENCE: &str = "../shared/data/metrology";

/// A text of heights by column and row.
fn text(columns: usize, rows: usize, mut height: impl FnMut(f64, f64) -> f64) -> String {
    let mut text = String::new();
    for row in 0..rows {
        for column in 0..columns {
            let separator = if column == 0 { "" } else { "," };
            let _ = write!(text, "{separator}{}", height(column as f64, row as f64));
        }
        text.push('\n');
    }
    text
}

fn wave(column: f64, row: f64) -> f64 {
    5.0 + 0.02 * column + (column / 3.0).sin() + (row / 5.0).cos()
}

/// The JSON of a command that goes well.
fn json(place: &Place, line: &str) -> Value {
    let run = place.done(&format!("{line} --json -"));
    assert!(run.stderr.is_empty(), "{line}: {}", run.stderr);
    serde_json::from_slice(&run.stdout).expect("it is JSON")
}

fn number(json: &Value, name: &str) -> f64 {
    json["areal"][name].as_f64().unwrap_or(f64::NAN)
}

#[test]
fn a_height_map_has_all_parameters_by_their_names() {
    let place = Place::new();
    place.text("map.csv", &text(120, 90, wave));
    let report = json(&place, "stats map.csv --step 0.5 --unit mm");
    let names = [
        "Sa", "Sq", "Ssk", "Sku", "Sp", "Sv", "Sz", "Sdq", "Sdr", "Sal", "Str", "Std", "Sk", "Spk",
        "Svk", "Smr1", "Smr2", "Sxp", "Vmp", "Vmc", "Vvc", "Vvv",
    ];
    for name in names {
        assert!(number(&report, name).is_finite(), "{name}: {report}");
    }
    assert_eq!(
        report["areal"].as_object().map(serde_json::Map::len),
        Some(names.len())
    );
    assert_eq!(report["command"], "stats");
    assert_eq!(report["form"], "plane");
    assert_eq!(report["s_filter"], Value::Null);
    assert_eq!(report["columns"], 120);
    assert_eq!(report["rows"], 90);
    assert_eq!(report["missing"], 0);
    assert_eq!(report["step"], serde_json::json!([0.5, 0.5]));
    // Variance of a wave is half its square: 1/2 + 1/2.
    assert!((number(&report, "Sq") - 1.0).abs() < 0.03, "{report}");
    let table = String::from_utf8(place.done("stats map.csv --step 0.5 --unit mm").stdout);
    let table = table.expect("tables are UTF-8");
    assert!(
        table.contains("120 columns by 90 rows, 0 missing; form taken away: plane"),
        "{table}"
    );
    assert!(table.contains("root mean square height"), "{table}");
    assert!(table.contains("mm³/mm²"), "{table}");
}

#[test]
fn form_filters_and_heights_change_what_they_are_asked_to() {
    let place = Place::new();
    place.text("map.csv", &text(120, 90, wave));
    let sq = |options: &str| {
        number(
            &json(&place, &format!("stats map.csv --step 1 {options}")),
            "Sq",
        )
    };
    let plane = sq("--form plane");
    assert!(sq("--form none") > plane && sq("--form poly2") < plane);
    assert!((sq("--form mean") / sq("--form none") - 1.0).abs() < 1e-12);
    // The waves are 19 and 31 long.
    assert!(sq("--s-filter 60") < 0.3 * plane);
    assert!(sq("--l-filter 10") < 0.4 * plane);
    assert!(sq("--l-filter 80") > 0.8 * plane);
    let report = json(
        &place,
        "stats map.csv --step 1 --s-filter 2 --l-filter 80 --smr 0 --slopes stencil",
    );
    assert_eq!(report["s_filter"], 2.0);
    assert_eq!(report["l_filter"], 80.0);
    assert_eq!(report["slopes"], "stencil");
    assert!((number(&report, "Smr") - 50.0).abs() < 5.0, "{report}");
    let warned = place.done("stats map.csv --step 1 --s-filter 1.5");
    assert!(
        warned.stderr.contains("no waves below two steps"),
        "{}",
        warned.stderr
    );
    let steep = json(&place, "stats map.csv --step 0.5,0.25");
    let flat = json(&place, "stats map.csv --step 1");
    assert!(number(&steep, "Sdq") > 2.0 * number(&flat, "Sdq"));
}

#[test]
fn missing_heights_are_counted_and_left_out() {
    let place = Place::new();
    let mut rng = Rng::new(5, Stage::Synth, 0);
    let some = |column: f64, row: f64| {
        if rng.uniform() < 0.1 {
            f64::NAN
        } else {
            wave(column, row)
        }
    };
    place.text("some.csv", &text(120, 90, some));
    place.text("all.csv", &text(120, 90, wave));
    let (some, all) = (
        json(&place, "stats some.csv --step 1"),
        json(&place, "stats all.csv --step 1"),
    );
    let missing = some["missing"].as_u64().expect("a count");
    assert!((900..1300).contains(&missing), "{missing}");
    for name in ["Sa", "Sq", "Sdq", "Sdr", "Sal", "Sk", "Vmc", "Vvc"] {
        let ratio = number(&some, name) / number(&all, name);
        assert!((ratio - 1.0).abs() < 0.03, "{name}: {ratio}");
    }
    // The same from semicolons, decimal commas and stars.
    let other = fs::read_to_string(place.path("some.csv")).expect("it is there");
    let other = other
        .replace(',', ";")
        .replace('.', ",")
        .replace("NaN", "***");
    place.text("other.txt", &other);
    assert_eq!(
        json(&place, "stats other.txt --step 1")["areal"],
        some["areal"]
    );
}

#[test]
fn the_result_depends_on_no_number_of_threads() {
    let place = Place::new();
    place.text("map.csv", &text(90, 70, wave));
    let line = "stats map.csv --step 1 --l-filter 40 --json -";
    let one = place.done(&format!("{line} --threads 1")).stdout;
    assert_eq!(one, place.done(&format!("{line} --threads 3")).stdout);
    let piped = place.run_with(
        "stats - --step 1 --l-filter 40 --json -",
        &fs::read(place.path("map.csv")).expect("it is there"),
    );
    let [file, pipe]: [Value; 2] =
        [one, piped.stdout].map(|bytes| serde_json::from_slice(&bytes).expect("it is JSON"));
    assert_eq!(file["areal"], pipe["areal"]);
}

#[test]
fn the_csv_has_every_parameter_and_quotes_what_needs_it() {
    let place = Place::new();
    place.text("map.csv", &text(60, 40, wave));
    let run = place.run("stats map.csv --step 1 --smr -0.5 --unit a,\"b --csv out.csv --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report: Value = serde_json::from_slice(&run.stdout).expect("it is JSON");
    let csv = fs::read_to_string(place.path("out.csv")).expect("it is there");
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("name,unit,value"));
    let mut names = Vec::new();
    for line in lines {
        let (name, rest) = line.split_once(',').expect("it has cells");
        let (unit, value) = rest.rsplit_once(',').expect("it has cells");
        let known = ["\"a,\"\"b\"", "%", "degrees", "1"].contains(&unit);
        assert!(known, "{line}");
        let value: f64 = value.parse().expect("it is a number");
        // Shortest digits of one number, read back by two readers.
        let apart = (value - number(&report, name)).abs();
        assert!(apart <= 1e-15 * value.abs(), "{line}");
        names.push(name.to_owned());
    }
    assert!(names.len() == 23 && names[22] == "Smr", "{names:?}");
    assert_eq!(
        Some(names.len()),
        report["areal"].as_object().map(serde_json::Map::len)
    );
}

#[test]
fn options_that_say_nothing_of_a_height_map_are_refused() {
    let place = Place::new();
    place.text("map.csv", &text(30, 20, wave));
    for option in [
        "--base plane",
        "--form-wavelength 3",
        "--pieces 10",
        "--join chart",
        "--gap 2",
        "--keep-outliers",
        "--no-repair",
        "--columns x,y,z",
        "--whole",
        "--report out.html",
        "--smr nan",
        "--smr inf",
    ] {
        let run = place.run(&format!("stats map.csv --step 1 {option}"));
        assert_eq!(run.code, 2, "{option}: {}", run.stderr);
        let name = option.split(' ').next().expect("it has a name");
        assert!(run.stderr.contains(name), "{option}: {}", run.stderr);
    }
}

#[test]
fn a_flat_map_has_no_texture() {
    let place = Place::new();
    place.text(
        "flat.csv",
        &text(20, 20, |column, row| 3.0 + 0.1 * column - row),
    );
    let report = json(&place, "stats flat.csv --step 1");
    assert_eq!(report["areal"]["Sq"], 0.0);
    for name in ["Ssk", "Sku", "Sal", "Str", "Std"] {
        assert_eq!(report["areal"][name], Value::Null, "{name}");
    }
}

#[test]
fn what_cannot_be_told_is_refused_in_a_sentence() {
    let place = Place::new();
    place.text("map.csv", &text(30, 20, wave));
    place.text("small.csv", "1,2\n3,4\n5,6\n");
    place.text("unknown.csv", "1,2,,\n,,,\n3,,4,\n,,,5\n");
    place.text("words.csv", "a,b,c\n1,2,3\n");
    place.text("ragged.csv", "1,2,3,4\n4,5,6,7\n7,8\n");
    place.text(
        "line.csv",
        &text(
            30,
            20,
            |column, row| if row > 0.0 { f64::NAN } else { column },
        ),
    );
    place.text("scan.ply", "ply\nformat ascii 1.0\n");
    place.refused(1, "stats map.csv", &["map.csv", "--step"]);
    place.refused(
        1,
        "stats small.csv --step 1",
        &["small.csv", "at least 3 by 3"],
    );
    place.refused(
        1,
        "stats unknown.csv --step 1",
        &["5 known", "at least 3 by 3"],
    );
    place.refused(
        1,
        "stats words.csv --step 1",
        &["words.csv", "line 1", "header"],
    );
    place.refused(
        1,
        "stats ragged.csv --step 1",
        &["ragged.csv", "line 3", "line 1 has 4"],
    );
    place.refused(
        1,
        "stats line.csv --step 1",
        &["line.csv", "do not determine", "simpler"],
    );
    place.refused(
        1,
        "stats scan.ply --step 1",
        &["scan.ply", "PLY", "leave out --step"],
    );
    place.refused(1, "stats none.csv --step 1", &["none.csv", "no such file"]);
    place.refused(
        1,
        "stats map.csv --step 1 --s-filter 40",
        &["S-filter", "longer than the map"],
    );
    place.refused(
        1,
        "stats map.csv --step 1 --s-filter 9 --l-filter 8",
        &["nothing would be left"],
    );
    for line in [
        "--step -1",
        "--step 0",
        "--step 1,2,3",
        "--step x",
        "--form plane",
        "--step 1 --l-filter -3",
        "--step 1 --form cone",
    ] {
        let run = place.run(&format!("stats map.csv {line}"));
        assert_eq!(run.code, 2, "{line}: {}", run.stderr);
        assert!(run.stderr.contains("--"), "{line}: {}", run.stderr);
    }
}

/// How far a value may be from another program's, for each parameter; why: see the table in BENCHMARKS.md.
fn is_close(name: &str, ours: f64, theirs: f64) -> bool {
    let apart = (ours - theirs).abs();
    match name {
        "Sa" | "Sq" | "Sp" | "Sv" | "Sz" | "Ssk" | "Sku" => apart <= 1e-9 * theirs.abs(),
        "Sdr" => apart <= 1e-5 * theirs,
        "Sdq" => apart <= 3e-3 * theirs,
        "Sal" | "Str" => apart <= f64::max(0.05 * theirs, 1e-3),
        // In percent.
        "Smr1" | "Smr2" => apart <= 0.3,
        _ => apart <= 0.01 * theirs,
    }
}

#[test]
fn parameters_match_other_programs() {
    let Ok(reference) = fs::read(Path::new(REFERENCE).join("iso25178_reference.json")) else {
        say_skipped(&format!("{REFERENCE}/iso25178_reference.json is not there"));
        return;
    };
    let reference: Value = serde_json::from_slice(&reference).expect("it is JSON");
    let place = Place::new();
    let mut far = Vec::new();
    for (surface, said) in reference.as_object().expect("one member a map") {
        let file = said["file"].as_str().expect("a name");
        fs::copy(Path::new(REFERENCE).join(file), place.path(file)).expect("it is there");
        let line = format!("stats {file} --step {},{}", said["dx_um"], said["dy_um"]);
        let ours = json(&place, &line);
        assert_eq!(
            [&ours["columns"], &ours["rows"]],
            [&said["nx"], &said["ny"]]
        );
        println!(
            "\n{surface}\n{:<6}{:>16}{:>16}{:>12}",
            "", "ours", "theirs", "apart"
        );
        for program in ["numpy_after_lsq_plane", "surfalize_0.19.2_after_level"] {
            println!("{program}");
            for (name, theirs) in said[program].as_object().expect("its values") {
                let Some(theirs) = theirs.as_f64() else {
                    println!("{name:<6}{:>16}{:>16}", ours["areal"][name], "undefined");
                    assert_eq!(ours["areal"][name], Value::Null, "{surface} {name}");
                    continue;
                };
                let value = number(&ours, name);
                println!(
                    "{name:<6}{value:>16.9}{theirs:>16.9}{:>12.2e}",
                    value / theirs - 1.0
                );
                if !is_close(name, value, theirs) {
                    far.push(format!("{surface} {name}: {value}, {theirs}"));
                }
            }
        }
        let program = "SurfaceTopography_1.27.1_after_lsq_plane";
        let theirs = said[program]["Sdq(rms_gradient)"]
            .as_f64()
            .expect("a number");
        let value = number(&ours, "Sdq");
        println!(
            "{program}\nSdq   {value:>16.9}{theirs:>16.9}{:>12.2e}",
            value / theirs - 1.0
        );
        if !is_close("Sdq", value, theirs) {
            far.push(format!("{surface} Sdq: {value}, {theirs}"));
        }
        let stencil = number(&json(&place, &format!("{line} --slopes stencil")), "Sdq");
        println!(
            "Sdq by the stencil {stencil:.9}, Std {:.2}",
            number(&ours, "Std")
        );
    }
    assert_eq!(far, Vec::<String>::new());
}
