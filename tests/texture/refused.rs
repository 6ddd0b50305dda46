//! What no texture comes of: one clear sentence that says which file, and what to do.

use std::fs;

use crate::common::place::Place;
use crate::common::samples::{checks, image, put_image, sphere, square};
use crate::common::to_scan;
use nalgebra::Point3;
use relievo::mesh::TriMesh;
use relievo::scan::{Column, Scan};

/// A square in mesh.ply, checks in checks.png.
fn place() -> Place {
    let place = Place::with("mesh.ply", &to_scan(&square()));
    put_image(&place, "checks.png", &checks());
    place
}

const TEXTURE: &str = "texture mesh.ply -e checks.png -o out.ply";

#[test]
fn images_that_hold_no_neighborhood_are_named() {
    let place = place();
    put_image(&place, "one.png", &image(1, 1, |_, _| [0.5; 3]));
    put_image(
        &place,
        "small.png",
        &image(6, 40, |x, _| [x as f32 / 6.0; 3]),
    );
    let mut clear = checks();
    clear.opaque = Some(vec![false; clear.colors.len()]);
    put_image(&place, "clear.png", &clear);
    let mut holes = checks();
    holes.opaque = Some((0..24 * 24).map(|i| i % 6 != 0).collect());
    put_image(&place, "holes.png", &holes);
    for method in ["coherent", "wei-levoy"] {
        for (name, size) in [
            ("one.png", "1 by 1"),
            ("small.png", "6 by 40"),
            ("clear.png", "24 by 24"),
            ("holes.png", "24 by 24"),
        ] {
            let line = format!("texture mesh.ply -e {name} -o out.ply --method {method}");
            let words = [
                &format!("{name}: "),
                size,
                "7 by 7",
                "transparent",
                "larger",
            ];
            place.refused(1, &line, &words);
        }
    }
}

#[test]
fn files_that_are_no_images_are_named() {
    let place = place();
    place.text("text.png", "no image\n");
    let bytes = place.bytes("checks.png");
    fs::write(place.path("cut.png"), &bytes[..bytes.len() / 2]).expect("it can be written");
    for (name, words) in [
        ("text.png", ["text.png: ", "not a PNG"]),
        ("cut.png", ["cut.png: ", "damaged"]),
        ("none.png", ["none.png: ", "no such file"]),
    ] {
        let line = format!("texture mesh.ply -e {name} -o out.ply");
        place.refused(1, &line, &words);
    }
}

#[test]
fn meshes_without_area_are_named() {
    let place = place();
    let line = |name: &str| format!("texture {name} -e checks.png -o out.ply -q");
    let on_a_line = TriMesh {
        positions: (0..4)
            .map(|i| Point3::new(f64::from(i), 0.0, 0.0))
            .collect(),
        triangles: vec![[0, 1, 2], [3, 2, 1]],
    };
    place.put("line.ply", &to_scan(&on_a_line));
    place.refused(1, &line("line.ply"), &["line.ply: ", "degenerate"]);
    let one = TriMesh {
        positions: vec![Point3::origin()],
        triangles: Vec::new(),
    };
    place.put("one.ply", &to_scan(&one));
    place.refused(1, &line("one.ply"), &["one.ply: "]);
    place.refused(1, &line("none.ply"), &["none.ply: ", "no such file"]);
}

#[test]
fn numbers_out_of_range_are_usage_errors() {
    let place = place();
    for (options, words) in [
        ("--symmetry 0", ["--symmetry", "from 1 to 16, not 0"]),
        ("--symmetry 17", ["--symmetry", "not 17"]),
        ("--vertices 0", ["--vertices", "from 4 to 4000000, not 0"]),
        ("--vertices 3", ["--vertices", "not 3"]),
        ("--vertices 1000000000", ["--vertices", "not 1000000000"]),
        ("--texel 1e-9", ["--texel", "4 to 4000000"]),
        ("--texel 1000", ["--texel", "0 vertices"]),
        ("--texel 0", ["--texel", "above 0"]),
        ("--texel -1", ["--texel", "not -1"]),
        ("--texel nan", ["--texel", "not NaN"]),
        ("--texel inf", ["--texel", "not inf"]),
        ("--levels 0", ["--levels", "from 1 to 12, not 0"]),
        ("--levels 99", ["--levels", "not 99"]),
        ("--displace nan", ["--displace", "not NaN"]),
        ("--displace inf", ["--displace", "not inf"]),
        ("--orientation 0,0,0", ["--orientation", "not zero"]),
        ("--orientation nan,0,1", ["--orientation", "finite"]),
        (
            "--keep-mesh --image-size 64",
            ["--image-size", "texture coordinates"],
        ),
    ] {
        place.refused(2, &format!("{TEXTURE} {options}"), &words);
    }
    // What is no number at all, and what excludes each other, is the parser's.
    for options in [
        "--vertices many",
        "--symmetry -1",
        "--vertices 600 --texel 1",
        "--image-size 64",
    ] {
        let run = place.run(&format!("{TEXTURE} {options}"));
        assert_eq!(run.code, 2, "{options}: {}", run.stderr);
        assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
        assert_eq!(place.files(), ["checks.png", "mesh.ply"]);
    }
}

#[test]
fn directions_that_point_nowhere_are_named() {
    let place = place();
    let mut scan = to_scan(&square());
    let line = |name: &str| format!("{TEXTURE} --orientation {name}");
    place.refused(1, &line("mesh.ply"), &["mesh.ply: ", "tx, ty and tz"]);
    place.refused(1, &line("none.ply"), &["none.ply: ", "no such file"]);
    let rows = scan.vertices.rows;
    for (name, value) in [("zero.ply", 0.0), ("nan.ply", f64::NAN)] {
        for axis in ["tx", "ty", "tz"] {
            scan.vertices
                .set_channel(axis, Column::F64(vec![value; rows]));
        }
        place.put(name, &scan);
        place.refused(1, &line(name), &[&format!("{name}: "), "direction"]);
    }
}

#[test]
fn no_input_is_overwritten() {
    let place = place();
    place.put("sample.ply", &to_scan(&sphere()));
    place.put("where.ply", &to_scan(&sphere()));
    let before: Vec<Vec<u8>> = (place.files().iter())
        .map(|name| place.bytes(name))
        .collect();
    place.refused(
        1,
        "texture mesh.ply -e checks.png -o mesh.ply",
        &["mesh.ply", "--overwrite"],
    );
    place.refused(
        1,
        "texture mesh.ply -e checks.png -o ./mesh.ply",
        &["mesh.ply", "--overwrite"],
    );
    place.refused(
        2,
        "texture mesh.ply -e sample.ply -o ./sample.ply --overwrite",
        &["sample.ply", "another name"],
    );
    let after: Vec<Vec<u8>> = (place.files().iter())
        .map(|name| place.bytes(name))
        .collect();
    assert!(before == after);
    for name in ["out.png", "out.pcd", "out"] {
        let line = format!("texture mesh.ply -e checks.png -o {name}");
        place.refused(2, &line, &[name, ".ply, .obj, .off, .stl or .glb"]);
    }
    let line = "texture mesh.ply -e checks.png -o none/out.ply";
    place.refused(1, line, &["none/out.ply", "folder"]);
}

/// A square of two triangles with colors.
fn two_triangles() -> Scan {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut scan = to_scan(&TriMesh {
        positions: corners.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    });
    for name in ["red", "green", "blue"] {
        scan.vertices
            .set_channel(name, Column::U8(vec![0, 50, 200, 100]));
    }
    scan
}

#[test]
fn scans_with_nothing_to_copy_are_named() {
    let place = place();
    place.put("smooth.ply", &to_scan(&sphere()));
    place.put("tiny.ply", &two_triangles());
    let line = |sample: &str| format!("texture mesh.ply -e {sample} -o out.ply --vertices 600");
    place.refused(
        1,
        &line("smooth.ply"),
        &["smooth.ply: ", "smooth", "no colors"],
    );
    place.refused(
        1,
        &line("tiny.ply"),
        &["tiny.ply: ", "7 by 7", "larger piece"],
    );
    // Texels of the sample's own size: none fits onto the mesh.
    let mut large = two_triangles();
    for name in ["x", "y"] {
        let values = crate::common::values(&large, name)
            .iter()
            .map(|x| 1e3 * x)
            .collect();
        large.vertices.set_channel(name, Column::F64(values));
    }
    place.put("large.ply", &large);
    place.refused(
        2,
        "texture mesh.ply -e large.ply -o out.ply",
        &["(1000)", "its unit", "--vertices"],
    );
}
