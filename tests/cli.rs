//! The command line as other programs see it: exit codes, standard output, JSON, files.

mod common;

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::place::Place;
use common::{assert_only_appended, cut, holed, moved, synthetic, to_scan, values};
use nalgebra::{Point3, Vector3};
use relievo::mesh::{TriMesh, check};
use relievo::scan::{Column, Scan};
use relievo::synth::{Kind, Part};
use serde_json::Value;

const QUICK: &str = "--window 2 --rotations 1";

/// Header of an ASCII PLY with `float` coordinates.
fn header(vertices: u64, faces: u64) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

#[test]
fn a_hole_is_completed_and_nothing_else_is_touched() {
    let scan = holed(Kind::Bricks);
    let place = Place::with("in.ply", &scan);
    let run = place.done(&format!(
        "complete in.ply -o out.ply {QUICK} --json report.json"
    ));
    assert!(run.stdout.is_empty());
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    let out = place.scan("out.ply");
    assert_only_appended(&scan, &out);
    assert_eq!(check(&out.mesh()), Ok(()));
    assert_eq!(place.files(), ["in.ply", "out.ply", "report.json"]);
    let report = place.json("report.json");
    assert_eq!(report["status"], "done");
    assert_eq!(report["command"], "complete");
    assert_eq!(
        report["counts"]["completed_vertices"],
        out.vertices.rows - scan.vertices.rows
    );
    assert_eq!(report["filled"].as_array().map(Vec::len), Some(1));
    assert_eq!(report["skipped"].as_array().map(Vec::len), Some(0));
}

#[test]
fn unknown_channels_comments_and_types_survive() {
    let mut scan = holed(Kind::GolfBall);
    let rows = scan.vertices.rows;
    let small: Vec<i16> = (0i16..).take(rows).map(|v| v % 331 - 165).collect();
    let quality: Vec<f32> = (0u16..).take(rows).map(|v| 0.1 * f32::from(v)).collect();
    let mut time: Vec<f64> = quality.iter().map(|q| f64::from(*q) / 3.0).collect();
    time[3] = f64::NAN;
    time[4] = -0.0;
    scan.vertices.set_channel("small", Column::I16(small));
    scan.vertices.set_channel("quality", Column::F32(quality));
    scan.vertices.set_channel("gps_time", Column::F64(time));
    scan.vertices
        .set_channel("label", Column::U32(vec![4_000_000_000; rows]));
    scan.comments = vec!["made by hand".into(), "  two  blanks".into()];
    scan.obj_info = vec!["is_cyberware_data 1".into()];
    let faces = scan.faces.len();
    scan.face_channels
        .set_channel("material", Column::U8(vec![7; faces]));
    let place = Place::with("in.ply", &scan);
    for options in ["", "--ascii"] {
        place.done(&format!("complete in.ply -o out.ply {QUICK} {options}"));
        let out = place.scan("out.ply");
        assert_only_appended(&scan, &out);
        let material = out.face_channels.column("material").unwrap();
        assert_eq!(material.len(), out.faces.len());
        assert_eq!(material.get_f64(0), Some(7.0));
        let label = values(&out, "label");
        assert!(
            label[rows..].iter().all(|l| (l - 4e9).abs() < 1.0),
            "labels are copied"
        );
    }
}

#[test]
fn channels_of_our_names_that_mean_something_else_are_kept() {
    let mut scan = holed(Kind::Waves);
    let heights: Vec<f64> = values(&scan, "z").iter().map(|z| z * 3.0).collect();
    scan.vertices
        .set_channel("height", Column::F64(heights.clone()));
    let place = Place::with("in.ply", &scan);
    let run = place.done(&format!("complete in.ply -o out.ply {QUICK}"));
    assert!(run.stderr.contains("input_height"), "{}", run.stderr);
    let kept = values(&place.scan("out.ply"), "input_height");
    approx::assert_abs_diff_eq!(kept[..heights.len()], heights[..], epsilon = 0.0);
}

#[test]
fn the_number_of_threads_does_not_change_a_byte() {
    let place = Place::with("in.ply", &synthetic(Kind::Bark, Part::hole(0.05)));
    for threads in [1, 2, 8] {
        let out = format!("{threads}.ply");
        place.done(&format!(
            "complete in.ply -o {out} --window 3 --threads {threads} --seed 5"
        ));
        assert!(
            place.bytes(&out) == place.bytes("1.ply"),
            "{threads} threads"
        );
    }
    place.done("complete in.ply -o other.ply --window 3 --seed 6");
    assert!(
        place.bytes("other.ply") != place.bytes("1.ply"),
        "the seed has no effect"
    );
}

#[test]
fn large_offsets_cost_nothing() {
    let scan = holed(Kind::Bark);
    let by = [1e6, 5e6, -2e6];
    let place = Place::with("near.ply", &scan);
    place.put("far.ply", &moved(&scan, by));
    for name in ["near", "far"] {
        place.done(&format!("complete {name}.ply -o {name}-out.ply {QUICK}"));
    }
    let (near, far) = (place.scan("near-out.ply"), place.scan("far-out.ply"));
    assert!(near.faces == far.faces);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let back: Vec<f64> = values(&far, name).iter().map(|x| x - by[axis]).collect();
        approx::assert_abs_diff_eq!(values(&near, name)[..], back[..], epsilon = 1e-6);
    }
    approx::assert_abs_diff_eq!(
        values(&near, "height")[..],
        values(&far, "height")[..],
        epsilon = 1e-4
    );
    approx::assert_abs_diff_eq!(
        values(&near, "source")[..],
        values(&far, "source")[..],
        epsilon = 0.0
    );
}

#[test]
fn scans_pass_through_pipes() {
    let place = Place::with("in.ply", &holed(Kind::GolfBall));
    place.done(&format!("complete in.ply -o out.ply {QUICK}"));
    let piped = place.run_with(&format!("complete - -o - {QUICK}"), &place.bytes("in.ply"));
    assert_eq!(piped.code, 0, "{}", piped.stderr);
    assert!(piped.stdout == place.bytes("out.ply"));
    let holes = place.run_with("holes - --json -", &piped.stdout);
    let json: Value = serde_json::from_slice(&holes.stdout).unwrap();
    assert_eq!(json["loops"].as_array().map(Vec::len), Some(0));
    assert_eq!(place.files(), ["in.ply", "out.ply"]);
}

#[test]
fn quiet_is_silent_and_verbose_tells_the_steps() {
    let place = Place::with("in.ply", &holed(Kind::Waves));
    assert_eq!(
        place
            .done(&format!("complete in.ply -o out.ply {QUICK} -q"))
            .stderr,
        ""
    );
    let verbose = place.done(&format!("complete in.ply -o out.ply {QUICK} -v"));
    assert!(verbose.stderr.lines().count() > 4, "{}", verbose.stderr);
    assert!(verbose.stdout.is_empty());
}

#[test]
fn other_formats_are_written() {
    let place = Place::with("in.ply", &holed(Kind::Bricks));
    for name in ["out.obj", "out.stl", "OUT.PLY"] {
        place.done(&format!("complete in.ply -o {name} {QUICK}"));
        assert!(place.scan(name).faces.len() > 1800, "{name}");
    }
    place.refused(
        2,
        "complete in.ply -o x.pcd",
        &["x.pcd", ".ply, .obj, .off, .stl or .glb"],
    );
    place.refused(2, "complete in.ply -o x.xyz", &["x.xyz", ".ply"]);
}

#[test]
fn the_input_is_never_overwritten_unasked() {
    let place = Place::with("in.ply", &holed(Kind::Waves));
    let before = place.bytes("in.ply");
    place.refused(1, "complete in.ply -o in.ply", &["in.ply", "overwr"]);
    place.refused(1, "complete in.ply -o ./in.ply", &["in.ply", "overwr"]);
    assert!(place.bytes("in.ply") == before);
    place.done(&format!("complete in.ply -o in.ply --overwrite {QUICK}"));
    assert!(place.bytes("in.ply") != before);
    assert_eq!(place.files(), ["in.ply"]);
}

#[test]
fn a_failure_leaves_an_earlier_output_alone() {
    let place = Place::with("in.ply", &synthetic(Kind::GolfBall, Part::FULL));
    place.text("out.ply", "from yesterday");
    place.refused(1, "complete in.ply -o out.ply", &["in.ply", "closed"]);
    assert_eq!(place.bytes("out.ply"), b"from yesterday");
}

#[test]
fn a_missing_output_folder_is_noticed_before_the_work() {
    let place = Place::new();
    // The input is not even looked at.
    place.refused(
        1,
        "complete none.ply -o no/out.ply",
        &["no/out.ply", "folder no", "make it"],
    );
    place.refused(
        1,
        "synth waves --vertices 100000 -o no/out.ply",
        &["no/out.ply", "make it"],
    );
}

#[test]
fn files_that_are_no_scans_are_refused() {
    let place = Place::with("good.ply", &holed(Kind::GolfBall));
    let refused = |name: &str, words: &[&str]| {
        let line = format!("complete {name} -o out.ply");
        place.refused(1, &line, &[&[name], words].concat());
        for command in ["fit", "holes"] {
            place.refused(1, &format!("{command} {name}"), &[name]);
        }
    };
    refused("none.ply", &["no such file", "check the path"]);
    fs::write(place.path("cut.ply"), &place.bytes("good.ply")[..9000]).unwrap();
    refused("cut.ply", &["cut off", "copy or export"]);
    let body = [(0, "0 0 0\n"), (1, "0 nan 0\n"), (2, "inf 0 0\n")];
    for (kind, line) in &body[1..] {
        let name = format!("bad{kind}.ply");
        place.text(
            &name,
            &format!("{}0 0 0\n1 0 0\n{line}3 0 1 2\n", header(3, 1)),
        );
        refused(&name, &["vertex 2", "not a finite number", "remove"]);
    }
    place.text("bare.ply", &header(0, 0));
    refused("bare.ply", &["no vertices"]);
    place.text("empty.ply", "");
    refused("empty.ply", &["ply"]);
    place.text(
        "index.ply",
        &format!("{}0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", header(3, 1)),
    );
    refused("index.ply", &["vertex 7", "only 3"]);
    place.text("scan.docx", "not read");
    refused("scan.docx", &["extension", ".ply"]);
}

#[test]
fn a_header_that_promises_too_much_is_refused_at_once() {
    let place = Place::new();
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let header = header(4_000_000_000, 4_000_000_000).replace("ascii", format);
        place.text("huge.ply", &format!("{header}0 0 0\n1 0 0\n"));
        let start = Instant::now();
        place.refused(
            1,
            "complete huge.ply -o out.ply",
            &["huge.ply", "4000000000", "cut off"],
        );
        assert!(start.elapsed() < Duration::from_secs(5), "{format}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn memory_follows_the_file_and_not_its_header() {
    let place = Place::new();
    let header = header(4_000_000_000, 4_000_000_000).replace("ascii", "binary_little_endian");
    place.text("huge.ply", &header);
    let output = Command::new("sh")
        .args(["-c", "ulimit -v 1000000 && exec \"$0\" holes huge.ply"])
        .arg(env!("CARGO_BIN_EXE_relievo"))
        .current_dir(place.0.path())
        .output()
        .unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("cut off"), "{stderr}");
}

#[test]
fn scans_without_a_surface_are_refused() {
    let place = Place::new();
    place.text("points.ply", &format!("{}0 0 0\n1 0 0\n", header(2, 0)));
    place.refused(
        1,
        "complete points.ply -o out.ply",
        &["points.ply", "too few", "export"],
    );
    let line: String = (0..5).map(|i| format!("{i} {i} 0\n")).collect();
    place.text(
        "line.ply",
        &format!("{}{line}3 0 1 2\n3 2 3 4\n", header(5, 2)),
    );
    place.refused(1, "complete line.ply -o out.ply", &["line.ply", "one line"]);
    place.refused(1, "fit line.ply", &["line.ply", "one line"]);
    let same = "1 2 3\n".repeat(3);
    place.text("dot.ply", &format!("{}{same}3 0 1 2\n", header(3, 1)));
    place.refused(1, "complete dot.ply -o out.ply", &["dot.ply"]);
}

#[test]
fn a_closed_surface_is_refused() {
    let place = Place::new();
    place.done("synth golf-ball --full --vertices 1000 -o full.ply");
    place.refused(
        1,
        "complete full.ply -o out.ply",
        &["full.ply", "closed", "nothing is missing"],
    );
}

#[test]
fn an_outer_rim_alone_is_refused_with_advice() {
    let place = Place::with(
        "half.ply",
        &synthetic(Kind::GolfBall, Part::view(Vector3::z())),
    );
    place.refused(
        1,
        "complete half.ply -o out.ply",
        &["half.ply", "--extend", "--holes"],
    );
}

#[test]
fn an_outer_rim_alone_is_refused() {
    let place = Place::with(
        "half.ply",
        &synthetic(Kind::GolfBall, Part::view(Vector3::z())),
    );
    place.refused(1, "complete half.ply -o out.ply", &["half.ply"]);
    place.refused(
        1,
        "complete half.ply -o out.ply --holes largest",
        &["--extend", "--holes"],
    );
}

#[test]
fn parameters_out_of_range_are_wrong_usage() {
    let place = Place::with("in.ply", &holed(Kind::GolfBall));
    for (option, words) in [
        ("--holes 99", ["99", "holes"]),
        ("--window 0", ["--window", "1"]),
        ("--window 51", ["--window", "50"]),
        ("--rotations 0", ["--rotations", "1"]),
        ("--shape-weight 2", ["--shape-weight", "0 to 1"]),
        ("--shape-weight nan", ["--shape-weight", "0 to 1"]),
        ("--tolerance=-1", ["--tolerance", "0 or more"]),
        ("--error-threshold 0", ["--error-threshold", "above 0"]),
    ] {
        place.refused(2, &format!("complete in.ply -o out.ply {option}"), &words);
    }
}

#[test]
fn words_that_the_command_line_does_not_know_are_wrong_usage() {
    let place = Place::with("in.ply", &holed(Kind::GolfBall));
    let before = place.files();
    for line in [
        "",
        "frobnicate",
        "complete in.ply",
        "complete -o out.ply",
        "complete in.ply -o out.ply --base torus",
        "complete in.ply -o out.ply --holes 1,a",
        "complete in.ply -o out.ply --spacing 0",
        "complete in.ply -o out.ply --spacing=-1",
        "complete in.ply -o out.ply --method fast",
        "complete in.ply -o out.ply --threads 0",
        "complete in.ply -o out.ply --seed x",
        "complete in.ply -o out.ply -q -v",
        "synth teapot -o out.ply",
        "synth waves -o out.ply --view 1,2",
        "synth waves -o out.ply --full --hole 0.1",
    ] {
        let run = place.run(line);
        assert_eq!(run.code, 2, "{line}: {}", run.stderr);
        assert!(run.stdout.is_empty(), "{line}");
        assert!(!run.stderr.is_empty(), "{line}");
        assert_eq!(place.files(), before, "{line}");
    }
}

#[test]
fn synthetic_scans_that_cannot_be_made_are_wrong_usage() {
    let place = Place::new();
    for (line, words) in [
        ("golf-ball --vertices 3", ["1000", "3"]),
        ("waves --hole 0.9", ["0.5", "0.9"]),
        ("waves --view 0,0,0", ["view", "zero"]),
        ("waves --view 0,0,-1", ["waves", "faces"]),
        ("waves --noise=-1", ["noise", "-1"]),
        ("waves --vertices 400000000000", ["400000000000", "many"]),
    ] {
        place.refused(2, &format!("synth {line} -o out.ply"), &words);
    }
}

#[test]
fn standard_output_takes_one_thing_only() {
    let place = Place::with("in.ply", &holed(Kind::GolfBall));
    let run = place.run("complete in.ply -o - --json -");
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("-o -") && run.stderr.contains("--json -"),
        "{}",
        run.stderr
    );
    assert!(!run.stdout.starts_with(b"ply"));
}

#[test]
fn too_many_new_vertices_are_refused() {
    let place = Place::with("in.ply", &holed(Kind::GolfBall));
    let line = "complete in.ply -o out.ply --spacing 1e-9";
    place.refused(1, line, &["in.ply", "larger --spacing"]);
}

#[test]
fn a_base_that_does_not_fit_is_refused() {
    let place = Place::with("in.ply", &holed(Kind::GolfBall));
    let line = "complete in.ply -o out.ply --base plane";
    place.refused(1, line, &["in.ply", "does not fit", "another --base"]);
}

#[test]
fn what_stays_open_makes_the_result_partial() {
    let place = Place::with("in.ply", &holed(Kind::Bricks));
    let run = place.run(&format!(
        "complete in.ply -o out.ply --holes 0,1 {QUICK} --json j.json"
    ));
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(run.stderr.contains("loop 0 left open"), "{}", run.stderr);
    let json = place.json("j.json");
    assert_eq!(json["status"], "partly");
    assert_eq!(json["filled"][0]["loops"][0], 1);
    assert_eq!(json["skipped"][0]["loops"][0], 0);
    assert!(
        json["skipped"][0]["reason"]
            .as_str()
            .is_some_and(|r| r.contains("--extend"))
    );
    assert_only_appended(&place.scan("in.ply"), &place.scan("out.ply"));
}

/// A golf ball with a hole around +z, at whose rim a fin stands on an edge; with `two` another, clean
/// hole around -z.
fn with_fin(two: bool) -> Scan {
    let full = synthetic(Kind::GolfBall, Part::FULL);
    let scan = cut(&full, |p| {
        p.coords.angle(&Vector3::z()) > 0.4 && (!two || p.coords.angle(&-Vector3::z()) > 0.3)
    });
    let mut mesh: TriMesh = scan.mesh();
    let loops = common::loops(&mesh);
    let rim = loops
        .iter()
        .find(|l| mesh.positions[l.vertices[0] as usize].z > 0.0);
    let rim = &rim.expect("the hole is there").vertices;
    let (a, b) = (rim[0], rim[1]);
    let tip = u32::try_from(mesh.positions.len()).expect("it is small");
    let [p, q] = [a, b].map(|v| mesh.positions[v as usize].coords);
    mesh.positions
        .extend([1.1, 1.2].map(|s| Point3::from((p + q) * (s / 2.0))));
    // The hole is on the rim's left: its triangle has a and b in the opposite order.
    mesh.triangles.extend([[a, b, tip], [a, b, tip + 1]]);
    to_scan(&mesh)
}

#[test]
fn a_hole_with_a_broken_rim_stays_open() {
    let place = Place::with("one.ply", &with_fin(false));
    place.put("two.ply", &with_fin(true));
    let run = place.run(&format!("complete one.ply -o out.ply --no-repair {QUICK}"));
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("repair"), "{}", run.stderr);
    assert_eq!(place.files(), ["one.ply", "two.ply"]);
    let run = place.run(&format!("complete two.ply -o out.ply --no-repair {QUICK}"));
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(run.stderr.contains("repair"), "{}", run.stderr);
    assert_only_appended(&place.scan("two.ply"), &place.scan("out.ply"));
    // Repaired, which is what happens unless it is switched off, both are filled.
    for name in ["one.ply", "two.ply"] {
        let run = place.done(&format!("complete {name} -o out.ply {QUICK}"));
        assert!(run.stderr.contains("more than two meet"), "{}", run.stderr);
    }
}

#[test]
fn fit_tells_the_base_and_how_the_others_compare() {
    let place = Place::with("in.ply", &holed(Kind::GolfBall));
    let run = place.done("fit in.ply");
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(text.starts_with("sphere around ("), "{text}");
    assert_eq!(run.stderr, "");
    let json: Value = serde_json::from_slice(&place.done("fit in.ply --json -").stdout).unwrap();
    assert_eq!(json["base"]["kind"], "sphere");
    assert_eq!(json["fits"], true);
    assert_eq!(json["ranking"].as_array().map(Vec::len), Some(4));
    assert!((json["base"]["radius"].as_f64().unwrap() - 21.35).abs() < 0.2);
    let plane: Value =
        serde_json::from_slice(&place.done("fit in.ply --base plane --json -").stdout).unwrap();
    assert_eq!(plane["base"]["kind"], "plane");
    assert_eq!(plane["fits"], false);
}

#[test]
fn holes_lists_every_loop() {
    let place = Place::with("in.ply", &holed(Kind::Bricks));
    let text = String::from_utf8(place.done("holes in.ply").stdout).unwrap();
    let kinds: Vec<&str> = (text.lines().skip(1))
        .filter_map(|line| line.split_whitespace().nth(1))
        .collect();
    assert_eq!(kinds, ["rim", "hole"]);
    let json: Value = serde_json::from_slice(&place.done("holes in.ply --json -").stdout).unwrap();
    assert_eq!(
        (&json["holes"], &json["rims"]),
        (&Value::from(1), &Value::from(1))
    );
    for (id, row) in json["loops"].as_array().unwrap().iter().enumerate() {
        assert_eq!(row["id"], id);
        for name in ["edges", "length", "area", "component"] {
            assert!(row[name].is_number(), "{name}");
        }
    }
}

#[test]
fn stats_compares_what_complete_wrote() {
    let place = Place::with("in.ply", &holed(Kind::Bricks));
    place.refused(1, "stats in.ply", &["in.ply", "completed", "complete"]);
    place.done(&format!(
        "complete in.ply -o out.ply {QUICK} --json complete.json"
    ));
    let text = String::from_utf8(place.done("stats out.ply").stdout).unwrap();
    assert!(text.contains("mean integral"), "{text}");
    place.done("stats out.ply --json stats.json");
    let stats = place.json("stats.json");
    assert!(
        stats["original"]["mean_integral"]
            .as_f64()
            .is_some_and(|m| m > 0.0)
    );
    assert_eq!(stats["colors"].as_array().map(Vec::len), Some(3));
    let seen = &place.json("complete.json")["statistics"]["completed"]["mean_integral"];
    let again = stats["completed"]["mean_integral"].as_f64().unwrap();
    approx::assert_relative_eq!(seen.as_f64().unwrap(), again, max_relative = 1e-6);
}

#[test]
fn synth_makes_every_kind_again_and_again_the_same() {
    let place = Place::new();
    for kind in Kind::ALL {
        let run = place.done(&format!("synth {kind} -o a.ply --vertices 1000 --seed 3"));
        assert!(run.stdout.is_empty() && run.stderr.is_empty(), "{kind}");
        place.done(&format!(
            "synth {kind} -o b.ply --vertices 1000 --seed 3 --threads 1"
        ));
        assert!(place.bytes("a.ply") == place.bytes("b.ply"), "{kind}");
        let holes = place.done("holes a.ply --json -");
        let json: Value = serde_json::from_slice(&holes.stdout).unwrap();
        assert_eq!(json["holes"], 1, "{kind}");
    }
    place.done("synth bark -o full.ply --vertices 1000 --full");
    place.done("synth bark -o view.ply --vertices 1000 --view -1,0,0");
    assert!(place.scan("view.ply").vertices.rows < place.scan("full.ply").vertices.rows * 2 / 3);
}

#[test]
fn half_a_golf_ball_is_closed_from_the_command_line() {
    let place = Place::new();
    place.done("synth golf-ball --vertices 1000 --view 0,0,1 -o half.ply");
    for options in ["--extend", "--holes all", "--holes 0"] {
        place.done(&format!("complete half.ply -o whole.ply {QUICK} {options}"));
        let text = String::from_utf8(place.done("holes whole.ply").stdout).unwrap();
        assert!(text.contains("closed"), "{options}: {text}");
    }
}

#[test]
fn nothing_in_the_output_depends_on_place_or_time() {
    let scan = holed(Kind::Waves);
    let (here, there) = (
        Place::with("in.ply", &scan),
        Place::with("other.ply", &scan),
    );
    here.done(&format!("complete in.ply -o out.ply {QUICK}"));
    there.done(&format!("complete other.ply -o result.ply {QUICK}"));
    assert!(here.bytes("out.ply") == there.bytes("result.ply"));
}

#[test]
fn help_and_version_are_results() {
    let place = Place::new();
    for line in [
        "--help",
        "-h",
        "--version",
        "complete --help",
        "synth -h",
        "stats --version",
        "transfer --help",
    ] {
        let run = place.done(line);
        assert!(!run.stdout.is_empty() && run.stderr.is_empty(), "{line}");
    }
    let help = String::from_utf8(place.done("--help").stdout).unwrap();
    assert!(help.contains("Exit codes"), "{help}");
    let uses = String::from_utf8(place.done("transfer --help").stdout).unwrap();
    for option in ["--mask painted", "--shape position", "--channel height"] {
        assert!(uses.contains(option), "{uses}");
    }
}

#[test]
fn json_that_cannot_be_written_is_a_failure() {
    let place = Place::with("in.ply", &holed(Kind::Waves));
    let run = place.run("holes in.ply --json no/report.json");
    assert_eq!(run.code, 1);
    assert!(run.stderr.contains("no/report.json"), "{}", run.stderr);
}

#[test]
fn the_json_never_replaces_the_scan() {
    let place = Place::with("in.ply", &holed(Kind::Waves));
    let before = place.bytes("in.ply");
    for line in [
        "complete in.ply -o out.ply --json in.ply",
        "holes in.ply --json in.ply",
        "fit in.ply --json in.ply",
    ] {
        let run = place.run(line);
        assert!(place.bytes("in.ply") == before, "{line}");
        assert_eq!(run.code, 2, "{line}: {}", run.stderr);
    }
    let run = place.run(&format!(
        "complete in.ply -o out.ply --json out.ply {QUICK}"
    ));
    assert_eq!(run.code, 2, "both cannot have one file: {}", run.stderr);
}

#[test]
fn a_missing_folder_of_the_json_is_noticed_before_the_work() {
    let place = Place::with("in.ply", &holed(Kind::Waves));
    let run = place.run(&format!(
        "complete in.ply -o out.ply --json no/report.json {QUICK}"
    ));
    assert_ne!(run.code, 0);
    assert_eq!(place.files(), ["in.ply"], "{}", run.stderr);
}

#[test]
fn wrong_usage_is_in_the_json_too() {
    let place = Place::with("in.ply", &holed(Kind::Waves));
    let run = place.run("complete in.ply -o out.ply --base torus --json report.json");
    assert_eq!(run.code, 2);
    assert_eq!(place.json("report.json")["status"], "failed");
}

#[test]
fn a_closed_pipe_is_no_panic() {
    let place = Place::with("in.ply", &holed(Kind::Waves));
    for line in [
        "complete in.ply -o - -q --window 2 --rotations 1",
        "fit in.ply --json -",
        "holes in.ply",
    ] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_relievo"))
            .args(line.split_whitespace())
            .current_dir(place.0.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(!stderr.contains("panicked"), "{line}: {stderr}");
        assert!(output.status.code().is_some_and(|code| code < 2), "{line}");
    }
}

#[test]
fn evaluate_tells_scores_in_a_table_in_words_and_as_json() {
    let place = Place::with("scan.ply", &synthetic(Kind::Noise, Part::default()));
    let line = "evaluate scan.ply --fill smooth --hole 0.1 --repeat 2 --window 2 --rotations 1";
    let run = place.done(&format!("{line} --pieces 60"));
    let text = String::from_utf8(run.stdout).expect("a table is text");
    for word in [
        "laplacian",
        "all together",
        "RMSE to truth/Sq",
        "Outside of this surface's natural variation: laplacian",
    ] {
        assert!(text.contains(word), "{word} is missing in {text}");
    }
    place.done(&format!("{line} --pieces 60 --json report.json"));
    let report = place.json("report.json");
    assert_eq!(report["repeats"].as_array().map(Vec::len), Some(2));
    // A scan of 1000 vertices has no room for 60 away from its rims.
    let pieces = report["repeats"][0]["calibration_pieces"].as_u64();
    assert!((Some(20)..=Some(60)).contains(&pieces), "{pieces:?}");
    assert_eq!(report["measures"][0]["measure"], "laplacian");
    assert!(report["overall"]["median"].as_f64() > Some(1.0));
    place.refused(
        2,
        "evaluate scan.ply --hole 0.6",
        &["--hole", "0.25", "0.6"],
    );
    place.refused(2, "evaluate scan.ply --pieces 5", &["--pieces", "60"]);
    place.text("points.off", "OFF\n2 0 0\n0 0 0\n1 0 0\n");
    place.refused(1, "evaluate points.off", &["points.off", "too few"]);
}
