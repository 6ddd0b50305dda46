//! Scans as they come, from the command line: dirty, of any format, and when something gets in the way.

mod common;

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::place::Place;
use common::{assert_only_appended, cut, holed, synthetic, values};
use nalgebra::Point3;
use relievo::mesh::{Csr, check};
use relievo::scan::{Column, Scan};
use relievo::synth::{Kind, Part};

const QUICK: &str = "--window 2 --rotations 1";

/// A wavy sheet with a small and a large hole.
fn two_holes() -> Scan {
    let scan = synthetic(Kind::Waves, Part::FULL);
    let [small, large] = places(&scan);
    cut(&scan, |p| {
        (p - small).norm() > 0.06 * size(&scan) && (p - large).norm() > 0.12 * size(&scan)
    })
}

fn size(scan: &Scan) -> f64 {
    relievo::mesh::bounding_diagonal(&scan.positions())
}

/// Two places well inside a sheet.
fn places(scan: &Scan) -> [Point3<f64>; 2] {
    let (mut low, mut high) = (scan.positions()[0], scan.positions()[0]);
    for p in scan.positions() {
        low = low.inf(&p);
        high = high.sup(&p);
    }
    [0.25, 0.68].map(|t| low + (high - low) * t)
}

fn filled(place: &Place, options: &str) -> Vec<i64> {
    place.done(&format!(
        "complete in.ply -o out.ply {QUICK} {options} --json report.json"
    ));
    let report = place.json("report.json");
    let filled = report["filled"].as_array().expect("a list");
    let loops = filled
        .iter()
        .flat_map(|hole| hole["loops"].as_array().expect("a list"));
    loops.map(|id| id.as_i64().expect("a number")).collect()
}

#[test]
fn holes_are_chosen_by_size() {
    let place = Place::with("in.ply", &two_holes());
    let listed = place.done("holes in.ply --json -");
    let listed: serde_json::Value = serde_json::from_slice(&listed.stdout).expect("it is JSON");
    let loops = listed["loops"].as_array().expect("a list").clone();
    let told: Vec<_> = loops
        .iter()
        .map(|l| l["kind"].as_str().expect("a word"))
        .collect();
    assert_eq!(told, ["rim", "hole", "hole"]);
    let between = |what: &str| {
        let value = |i: usize| loops[i][what].as_f64().expect("a number");
        (value(1) + value(2)) / 2.0
    };
    for limit in [
        format!("--max-edges {}", between("edges").round()),
        format!("--max-length {}", between("length")),
        format!("--max-area {}", between("area")),
    ] {
        assert_eq!(filled(&place, &limit), [2], "{limit}");
        assert_eq!(
            place.json("report.json")["counts"]["holes_left"],
            1,
            "{limit}"
        );
        assert_eq!(
            filled(&place, &format!("--holes largest {limit}")),
            [2],
            "{limit}"
        );
    }
    assert_eq!(filled(&place, ""), [1, 2]);
    assert_eq!(filled(&place, "--max-edges 1000"), [1, 2]);
    fs::remove_file(place.path("out.ply")).expect("it is there");
    fs::remove_file(place.path("report.json")).expect("it is there");
    let refused = |code, options: &str, words: &[&str]| {
        place.refused(code, &format!("complete in.ply -o x.ply {options}"), words);
    };
    refused(
        1,
        "--max-edges 3",
        &["in.ply", "none of its 2 hole(s)", "relievo holes"],
    );
    refused(2, "--holes 1 --max-edges 3", &["--holes", "limits"]);
    let run = place.run("complete in.ply -o x.ply --max-area 0");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("positive area"), "{}", run.stderr);
}

#[test]
fn holes_are_chosen_by_paint() {
    let mut scan = two_holes();
    let [small, _] = places(&scan);
    let reach = 0.1 * size(&scan);
    let near: Vec<bool> = scan
        .positions()
        .iter()
        .map(|p| (p - small).norm() < reach)
        .collect();
    let number = |on: i32, off: i32| near.iter().map(|n| if *n { on } else { off }).collect();
    scan.vertices
        .set_channel("paint", Column::I32(number(1, 0)));
    scan.vertices
        .set_channel("label", Column::I32(number(7, 3)));
    for (name, on) in [("red", 250), ("green", 4), ("blue", 3)] {
        let values = near.iter().map(|n| if *n { on } else { 120 }).collect();
        scan.vertices.set_channel(name, Column::U8(values));
    }
    let place = Place::with("in.ply", &scan);
    for mask in ["paint", "label=7", "#ff0000", "#FA0403"] {
        assert_eq!(filled(&place, &format!("--mask {mask}")), [2], "{mask}");
    }
    assert_eq!(filled(&place, "--mask label"), [1, 2]);
    assert_eq!(filled(&place, "--mask label=3"), [1]);
    fs::remove_file(place.path("out.ply")).expect("it is there");
    fs::remove_file(place.path("report.json")).expect("it is there");
    let refused = |options: &str, words: &[&str]| {
        place.refused(2, &format!("complete in.ply -o x.ply {options}"), words);
    };
    refused(
        "--mask painted",
        &["in.ply", "`painted`", "they have x, y, z", "paint"],
    );
    refused("--mask label=4", &["in.ply", "no vertex is painted"]);
    refused("--mask #00ff00", &["in.ply", "no vertex is painted"]);
    for (mask, words) in [
        ("#red", "six hexadecimal digits"),
        ("label=x", "expected a number behind ="),
    ] {
        let run = place.run(&format!("complete in.ply -o x.ply --mask {mask}"));
        assert_eq!(run.code, 2);
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
}

#[test]
fn a_hole_that_touches_the_rim_is_filled_and_a_notch_is_not() {
    // A pattern of squares, one of which touches the rim in a point.
    let n = 12u32;
    let mut scan = Scan::default();
    let grid = || (0..=n).flat_map(|i| (0..=n).map(move |j| (f64::from(i), f64::from(j))));
    scan.vertices
        .set_channel("x", Column::F64(grid().map(|(x, _)| x).collect()));
    scan.vertices
        .set_channel("y", Column::F64(grid().map(|(_, y)| y).collect()));
    let height = |(x, y): (f64, f64)| 0.1 * (2.1 * x).sin() * (1.7 * y).cos();
    scan.vertices
        .set_channel("z", Column::F64(grid().map(height).collect()));
    let id = |i: u32, j: u32| i * (n + 1) + j;
    let missing = [[0, 6], [1, 5], [1, 4], [5, 11], [6, 11]];
    for i in 0..n {
        for j in 0..n {
            if !missing.contains(&[i, j]) {
                scan.faces
                    .push_row(&[id(i, j), id(i + 1, j), id(i + 1, j + 1)]);
                scan.faces
                    .push_row(&[id(i, j), id(i + 1, j + 1), id(i, j + 1)]);
            }
        }
    }
    let place = Place::with("in.ply", &scan);
    let listed = place.done("holes in.ply");
    let text = String::from_utf8(listed.stdout).expect("it is text");
    assert!(
        text.lines()
            .any(|l| l.contains("hole") && l.ends_with("touches 0")),
        "{text}"
    );
    assert_eq!(filled(&place, ""), [1]);
    let out = place.scan("out.ply");
    assert_eq!(check(&out.mesh()), Ok(()));
    assert_eq!(place.json("report.json")["counts"]["rims_left"], 1);
}

/// The scan with its faces cut apart along a column of vertices, which are there twice then.
fn with_seam(scan: &Scan) -> Scan {
    let positions = scan.positions();
    let middle = positions.iter().map(|p| p.x).sum::<f64>() / positions.len() as f64;
    let right: Vec<bool> = scan
        .faces
        .rows()
        .map(|f| f.iter().map(|v| positions[*v as usize].x).sum::<f64>() > middle * f.len() as f64)
        .collect();
    let mut sides = vec![[false; 2]; positions.len()];
    for (face, right) in scan.faces.rows().zip(&right) {
        for v in face {
            sides[*v as usize][usize::from(*right)] = true;
        }
    }
    let both: Vec<u32> = (0u32..)
        .zip(&sides)
        .filter(|(_, s)| s[0] && s[1])
        .map(|(v, _)| v)
        .collect();
    assert!(both.len() > 10);
    let mut rows: Vec<u32> = (0u32..).take(positions.len()).collect();
    rows.extend(&both);
    let first = u32::try_from(positions.len()).expect("a small scan");
    let mut apart = Scan::default();
    for channel in &scan.vertices.channels {
        let values = rows
            .iter()
            .map(|r| channel.values.get_f64(*r as usize).expect("a number"));
        apart
            .vertices
            .set_channel(&channel.name, Column::F64(values.collect()));
    }
    let mut faces = Csr::default();
    for (face, right) in scan.faces.rows().zip(&right) {
        let copy = |v: &u32| match both.binary_search(v) {
            Ok(k) if *right => first + u32::try_from(k).expect("a small scan"),
            _ => *v,
        };
        faces.push_row(&face.iter().map(copy).collect::<Vec<_>>());
    }
    apart.faces = faces;
    apart
}

#[test]
fn seams_are_no_holes_and_stay_as_they_are() {
    let whole = holed(Kind::Waves);
    let scan = with_seam(&whole);
    let place = Place::with("in.ply", &scan);
    place.put("whole.ply", &whole);
    let run = place.done("holes in.ply --json with.json");
    assert!(
        run.stderr.contains("at seams") || run.stderr.contains("seams are no holes"),
        "{}",
        run.stderr
    );
    place.done("holes whole.ply --json without.json");
    let counted = |name: &str| {
        let json = place.json(name);
        (json["holes"].clone(), json["rims"].clone())
    };
    assert_eq!(counted("with.json"), counted("without.json"));
    place.done(&format!("complete in.ply -o out.ply {QUICK}"));
    let out = place.scan("out.ply");
    assert_only_appended(&scan, &out);
    // Every new vertex is as it would be without the seam.
    place.done(&format!("complete whole.ply -o whole_out.ply {QUICK}"));
    let new = |scan: &Scan, name: &str| -> Vec<f64> {
        let marks = values(scan, "completed");
        let column = values(scan, name);
        (column.iter().zip(marks))
            .filter(|(_, m)| *m > 0.5)
            .map(|(v, _)| *v)
            .collect()
    };
    let reference = place.scan("whole_out.ply");
    for channel in &reference.vertices.channels {
        let [new, expected] = [&out, &reference].map(|scan| new(scan, &channel.name));
        assert!(!expected.is_empty());
        assert_eq!(new, expected, "{}", channel.name);
    }
    place.done("holes in.ply --no-repair=weld --json apart.json");
    assert_ne!(counted("apart.json"), counted("without.json"));
}

#[test]
fn dirt_is_repaired_and_named_and_can_be_left() {
    let clean = holed(Kind::Bricks);
    let mut scan = clean.clone();
    let rows: Vec<Vec<u32>> = clean.faces.rows().map(<[u32]>::to_vec).collect();
    scan.faces = Csr::default();
    for (f, row) in rows.iter().enumerate() {
        let mut row = row.clone();
        if f % 50 == 7 {
            row.reverse();
        }
        scan.faces.push_row(&row);
    }
    scan.faces.push_row(&rows[3]);
    scan.faces.push_row(&[rows[5][0], rows[5][1], rows[5][1]]);
    let place = Place::with("in.ply", &scan);
    let run = place.done(&format!(
        "complete in.ply -o out.ply {QUICK} --json report.json"
    ));
    for words in [
        "1 face(s) with fewer than three",
        "1 face(s) left out that are there twice",
        "turned",
    ] {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
    let out = place.scan("out.ply");
    assert_eq!(check(&out.mesh()), Ok(()));
    let positions = out.positions();
    assert_eq!(positions[..scan.vertices.rows], scan.positions());
    let report = place.json("report.json");
    assert_eq!(report["repair"]["degenerate_faces"], 1);
    assert_eq!(report["repair"]["duplicate_faces"], 1);
    // Repaired, it has as many faces as the clean scan.
    assert_eq!(report["counts"]["original_faces"], clean.faces.len());
    let quiet = place.done(&format!("complete in.ply -o out.ply {QUICK} -q"));
    assert!(quiet.stderr.is_empty(), "{}", quiet.stderr);
    let left = place.done("holes in.ply --no-repair --json left.json");
    assert!(left.stderr.is_empty(), "{}", left.stderr);
    assert_eq!(place.json("left.json")["repair"]["duplicate_faces"], 0);
    let some = place.done("holes in.ply --no-repair=orient,degenerate --json some.json");
    assert!(
        some.stderr.contains("there twice") && !some.stderr.contains("turned"),
        "{}",
        some.stderr
    );
    let run = place.run("holes in.ply --no-repair=everything");
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("expected degenerate, duplicates"),
        "{}",
        run.stderr
    );
}

#[test]
fn what_is_converted_comes_back() {
    let scan = synthetic(Kind::GolfBall, Part::hole(0.05));
    let place = Place::with("in.ply", &scan);
    let formats = ["obj", "off", "stl", "glb"];
    for format in formats {
        place.done(&format!("convert in.ply a.{format}"));
        place.done(&format!("convert a.{format} b.ply --json report.json"));
        let back = place.scan("b.ply");
        assert_eq!(back.faces.len(), scan.faces.len(), "{format}");
        if format != "stl" {
            // STL has no vertices without triangles, and numbers them as they come.
            assert_eq!(back.vertices.rows, scan.vertices.rows, "{format}");
            let worst = (back.positions().iter().zip(scan.positions()))
                .map(|(a, b)| (a - b).norm())
                .fold(0.0, f64::max);
            assert!(worst < 1e-5 * size(&scan), "{format}: {worst}");
            assert_eq!(back.colors().is_some(), scan.colors().is_some(), "{format}");
        }
        assert_eq!(place.json("report.json")["faces"], scan.faces.len());
    }
    place.refused(2, "convert in.ply a.xyz", &["a.xyz", ".glb"]);
    place.refused(1, "convert in.ply in.ply", &["in.ply", "overwr"]);
}

#[test]
fn info_tells_what_is_there() {
    let mut scan = holed(Kind::GolfBall);
    let quality = vec![2.5; scan.vertices.rows];
    scan.vertices.set_channel("quality", Column::F32(quality));
    scan.comments.push("made by hand".into());
    let place = Place::with("in.ply", &scan);
    let text = String::from_utf8(place.done("info in.ply").stdout).expect("it is text");
    for words in [
        "quality (float), 2.5 to 2.5",
        "made by hand",
        "1, and 0 outer rims",
        "in the scan's unit",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    place.done("info in.ply --json info.json");
    let info = place.json("info.json");
    assert_eq!(info["vertices"], scan.vertices.rows);
    assert_eq!(info["faces"], scan.faces.len());
    assert_eq!(info["holes"], 1);
    assert_eq!(info["colors"], scan.colors().is_some());
}

/// Waits until the program has begun its output, sends it the signals, and gives its exit code. All but
/// the last must leave it running; `before` is what its shell does first.
#[cfg(unix)]
fn interrupted(place: &Place, before: &str, signals: &[&str]) -> (Option<i32>, String) {
    let program = env!("CARGO_BIN_EXE_relievo");
    let mut child = Command::new("sh")
        .args(["-c", &format!("{before} exec \"$0\" \"$@\""), program])
        .args("complete in.ply -o out.ply --method paper --json report.json".split(' '))
        .current_dir(place.0.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let start = Instant::now();
    while !place.files().iter().any(|name| name.contains("out.ply.")) {
        assert!(
            start.elapsed() < Duration::from_secs(60),
            "no output is begun"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    for (k, signal) in signals.iter().enumerate() {
        if k > 0 {
            std::thread::sleep(Duration::from_millis(300));
            let ended = child.try_wait().expect("it can be asked");
            assert_eq!(ended, None, "{} ended it", signals[k - 1]);
        }
        let sent = Command::new("kill")
            .args([*signal, &child.id().to_string()])
            .status();
        assert!(sent.expect("there is kill").success());
    }
    let output = child.wait_with_output().expect("the program ends");
    let said = String::from_utf8(output.stderr).expect("messages are UTF-8");
    (output.status.code(), said)
}

/// A scan that takes some time.
#[cfg(unix)]
fn large() -> Scan {
    let made = relievo::synth::scan(&relievo::synth::SynthParams {
        vertices: 20_000,
        part: Part::hole(0.2),
        ..relievo::synth::SynthParams::default()
    });
    made.expect("the parameters are in range").scan
}

#[test]
#[cfg(unix)]
fn an_interrupt_leaves_nothing_half_written() {
    let place = Place::with("in.ply", &large());
    for (signal, number) in [("-INT", 2), ("-TERM", 15), ("-HUP", 1)] {
        // Tests in the background of a shell are not to hear Ctrl-C, and what they start is not, either.
        if ignored_signals() >> (number - 1) & 1 == 1 {
            let _ = writeln!(std::io::stderr(), "SKIPPED: {signal} is ignored here");
            continue;
        }
        let (code, said) = interrupted(&place, "", &[signal]);
        assert_eq!(code, Some(130), "{signal}: {said}");
        assert!(said.contains("interrupted"), "{signal}: {said}");
        assert_eq!(place.files(), ["in.ply"], "{signal}");
    }
}

/// The signals that the tests themselves ignore: bit n − 1 for signal n.
fn ignored_signals() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = (status.lines()).find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

#[test]
#[cfg(target_os = "linux")]
fn a_hang_up_that_is_ignored_already_stays_so() {
    let place = Place::with("in.ply", &large());
    // As `nohup` does.
    let (code, said) = interrupted(&place, "trap '' HUP;", &["-HUP", "-TERM"]);
    assert_eq!(code, Some(130), "{said}");
    assert_eq!(place.files(), ["in.ply"]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_named() {
    let place = Place::with("in.ply", &holed(Kind::Waves));
    std::os::unix::fs::symlink("/dev/full", place.path("full.ply")).expect("links can be made");
    let run = place.run(&format!("complete in.ply -o full.ply {QUICK}"));
    assert_eq!(run.code, 1);
    for words in ["full.ply", "No space left", "the space left"] {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
}

#[test]
fn a_closed_pipe_is_named_and_no_panic() {
    let place = Place::with("in.ply", &holed(Kind::Waves));
    let mut child = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(format!("complete in.ply -o - {QUICK}").split(' '))
        .current_dir(place.0.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("the program ends");
    let said = String::from_utf8(output.stderr).expect("messages are UTF-8");
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write standard output"), "{said}");
    assert_eq!(place.files(), ["in.ply"]);
}

#[test]
fn a_file_that_ends_while_it_is_read_is_named() {
    let scan = holed(Kind::Waves);
    let place = Place::with("in.ply", &scan);
    let bytes = place.bytes("in.ply");
    let run = place.run_with(
        &format!("complete - -o out.ply {QUICK}"),
        &bytes[..bytes.len() / 2],
    );
    assert_eq!(run.code, 1);
    for words in ["standard input", "cut off", "promises"] {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
    assert_eq!(place.files(), ["in.ply"]);
}
