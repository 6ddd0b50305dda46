//! What nothing comes of: one clear sentence that says which file, and what to do.

use relievo::mesh::TriMesh;
use relievo::scan::Column;

use crate::common::place::Place;
use crate::common::samples::{square, with_texture_coordinates};
use crate::common::to_scan;
use crate::shapes::{ball, body, colored, hues};
use crate::{TRANSFER, place as with_target};

fn place() -> Place {
    with_target(&ball(4))
}

const OUT: &str = "-o out.ply -q";

#[test]
fn a_source_without_colors_is_named() {
    let place = place();
    place.put("bare.ply", &to_scan(&ball(4)));
    let line = format!("transfer --source bare.ply --target target.ply {OUT}");
    place.refused(1, &line, &["bare.ply: ", "no colors", "--channel height"]);
}

#[test]
fn meshes_without_faces_or_area_are_named() {
    let place = place();
    let on_a_line = TriMesh {
        positions: (0..4)
            .map(|i| nalgebra::Point3::new(f64::from(i), 0.0, 0.0))
            .collect(),
        triangles: vec![[0, 1, 2], [3, 2, 1]],
    };
    place.put("line.ply", &colored(&on_a_line, hues));
    let mut points = colored(&on_a_line, hues);
    points.faces = relievo::mesh::Csr::default();
    points.face_channels.rows = 0;
    place.put("points.ply", &points);
    for name in ["line.ply", "points.ply", "none.ply"] {
        let line = format!("transfer --source {name} --target target.ply {OUT}");
        place.refused(1, &line, &[&format!("{name}: ")]);
        let line = format!("transfer --source source.ply --target {name} {OUT}");
        place.refused(1, &line, &[&format!("{name}: ")]);
    }
    let line = format!("transfer --source line.ply --target target.ply {OUT}");
    place.refused(1, &line, &["degenerate"]);
}

#[test]
fn numbers_out_of_range_are_usage_errors() {
    let place = place();
    for (options, words) in [
        ("--vertices 2", ["--vertices", "2 vertices"]),
        ("--vertices 1000000000", ["--vertices", "1000000000"]),
        ("--scale 0", ["--scale", "scale of 0"]),
        ("--scale nan", ["--scale", "NaN"]),
        ("--scale -1", ["--scale", "-1"]),
        ("--shape-weight 1.5", ["--shape-weight", "1.5"]),
        ("--rounds 0", ["--rounds", "0 rounds"]),
        ("--coherence 1", ["--coherence", "below 1"]),
        ("--overuse -1", ["--overuse", "-1"]),
        ("--up 0,0,0", ["--up", "not zero"]),
        ("--source-up nan,0,0", ["--up", "finite"]),
    ] {
        place.refused(2, &format!("{TRANSFER} {OUT} {options}"), &words);
    }
    // What is no number at all, and what excludes each other, is the parser's.
    for options in [
        "--vertices many",
        "--up w",
        "--shape round",
        "--correspondences a.json --shape none",
        "--mask red --init a.txt",
        "--mask red --correspondences a.json",
    ] {
        let run = place.run(&format!("{TRANSFER} {OUT} {options}"));
        assert_eq!(run.code, 2, "{options}: {}", run.stderr);
        assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
        assert_eq!(place.files(), ["source.ply", "target.ply"]);
    }
    let run = place.run("transfer --source source.ply -o out.ply");
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("--target"), "{}", run.stderr);
}

#[test]
fn correspondences_that_cannot_be_are_named() {
    let place = place();
    for (name, text, words) in [
        ("text.json", "no JSON", ["not JSON", "line 1"]),
        ("empty.json", "[]", ["empty", "at least one"]),
        (
            "beyond.json",
            "[[0, 99999]]",
            ["target has no vertex 99999", "correspondence 1"],
        ),
        (
            "source.json",
            "[[0, 1], [258, 2]]",
            ["source has no vertex 258", "correspondence 2"],
        ),
        ("twice.json", "[[0, 5], [9, 5]]", ["contradict", "vertex 5"]),
        ("shape.json", "{\"a\": 1}", ["list of pairs", "pairs"]),
    ] {
        place.text(name, text);
        let line = format!("{TRANSFER} --correspondences {name} {OUT}");
        let [first, second] = words;
        place.refused(1, &line, &[&format!("{name}: "), first, second]);
    }
    let line = format!("{TRANSFER} --correspondences none.json {OUT}");
    place.refused(1, &line, &["none.json: "]);
}

#[test]
fn maps_that_do_not_fit_are_named() {
    let place = place();
    let all = |entry: &str| format!("{entry}\n").repeat(66);
    for (name, text, words) in [
        (
            "short.txt",
            "0\n1\n".to_owned(),
            ["2 entries", "66 vertices"],
        ),
        (
            "beyond.txt",
            all("258"),
            ["vertex 258 of the source", "258 vertices"],
        ),
        ("nothing.txt", all("-1"), ["no entry", "vertex"]),
        ("word.txt", "0\nzero\n".to_owned(), ["line 2", "zero"]),
        (
            "word.json",
            "[0, \"a\"]".to_owned(),
            ["entry 1", "whole number"],
        ),
        ("cut.json", "[0, 1".to_owned(), ["JSON list", "line 1"]),
    ] {
        place.text(name, &text);
        let [first, second] = words;
        let line = format!("{TRANSFER} --init {name} {OUT}");
        place.refused(1, &line, &[&format!("{name}: "), first, second]);
    }
    let line = format!("{TRANSFER} --init target.ply {OUT}");
    place.refused(1, &line, &["target.ply: ", "no property source"]);
    let mut mapped = to_scan(&ball(4));
    mapped
        .vertices
        .set_channel("source", Column::F32(vec![0.5; 66]));
    place.put("half.ply", &mapped);
    place.refused(
        1,
        &format!("{TRANSFER} --init half.ply {OUT}"),
        &["half.ply: ", "whole number"],
    );
    place.refused(
        1,
        &format!("{TRANSFER} --init none.txt {OUT}"),
        &["none.txt: "],
    );
}

#[test]
fn masks_that_leave_nothing_to_copy_or_to_fill_are_named() {
    let place = place();
    let mut scan = colored(&body(4, 0.0), hues);
    for (name, value) in [("none", 0), ("all", 1)] {
        scan.vertices.set_channel(name, Column::U8(vec![value; 66]));
    }
    place.put("source.ply", &scan);
    let spread = |mask: &str| format!("transfer --source source.ply --mask {mask} {OUT}");
    place.refused(
        1,
        &spread("paint"),
        &["source.ply: ", "`paint`", "none, all"],
    );
    place.refused(1, &spread("none"), &["source.ply: ", "--mask"]);
    place.refused(1, &spread("all"), &["source.ply: ", "no vertex is left"]);
    place.refused(
        1,
        &spread("#010203"),
        &["source.ply: ", "no vertex is left"],
    );
    place.put("grey.ply", &colored(&body(4, 0.0), |_| [0.2; 3]));
    let line = format!("transfer --source grey.ply --mask #333333 {OUT}");
    place.refused(1, &line, &["grey.ply: ", "nothing is painted"]);
    place.put("bare.ply", &to_scan(&ball(4)));
    let line = format!("transfer --source bare.ply --mask #333333 --channel height {OUT}");
    place.refused(1, &line, &["bare.ply: ", "no colours", "vertex property"]);
    let line = format!("{TRANSFER} --mask all {OUT}");
    place.refused(2, &line, &["target.ply: ", "--mask", "leave out"]);
}

#[test]
fn no_input_is_overwritten_and_formats_are_named() {
    let place = place();
    let before = [place.bytes("source.ply"), place.bytes("target.ply")];
    place.refused(
        1,
        &format!("{TRANSFER} -o target.ply"),
        &["target.ply", "--overwrite"],
    );
    place.refused(
        1,
        &format!("{TRANSFER} -o ./target.ply"),
        &["target.ply", "--overwrite"],
    );
    let line = format!("{TRANSFER} -o ./source.ply --overwrite");
    place.refused(2, &line, &["source.ply", "another name"]);
    place.text("map.ply", "anything");
    let line = format!("{TRANSFER} --init map.ply -o map.ply --overwrite");
    place.refused(2, &line, &["map.ply", "another name"]);
    assert!(before == [place.bytes("source.ply"), place.bytes("target.ply")]);
    for name in ["out.png", "out.pcd", "out"] {
        let line = format!("{TRANSFER} -o {name}");
        place.refused(2, &line, &[name, ".ply, .obj, .off, .stl or .glb"]);
    }
    place.refused(
        1,
        &format!("{TRANSFER} -o none/out.ply"),
        &["none/out.ply", "folder"],
    );
    let line = format!("{TRANSFER} {OUT} --image-size 64");
    place.refused(2, &line, &["--image-size", "texture coordinates"]);
    let line = "transfer --source - --target - -o out.ply";
    place.refused(2, line, &["standard input", "once"]);
    place.done(&format!("{TRANSFER} -o target.ply --overwrite"));
    assert!(place.bytes("target.ply") != before[1]);
    // Texture images beside the mesh are outputs, too.
    place.put("flat.ply", &with_texture_coordinates(to_scan(&square())));
    place.text("other.png", "mine");
    let line = "transfer --source source.ply --target flat.ply -o other.ply";
    place.refused(1, line, &["other.png"]);
    assert_eq!(place.bytes("other.png"), b"mine");
}
