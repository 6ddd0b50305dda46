//! `relievo transfer` on small meshes: what it promises.

#![cfg(feature = "image")]

#[path = "../common/mod.rs"]
mod common;

mod kept;
mod refused;
mod relief;
mod shapes;

use common::place::Place;
use common::samples::{colors, sources};
use common::{to_scan, values};
use relievo::mesh::TriMesh;
use relievo::scan::{Column, Scan};
use serde_json::Value;
use shapes::{ball, body, carried, colored, hues, mean_error};

const TRANSFER: &str = "transfer --source source.ply --target target.ply";

/// A colored body in source.ply, another mesh in target.ply.
fn place(target: &TriMesh) -> Place {
    let place = Place::with("source.ply", &colored(&body(8, 0.0), hues));
    place.put("target.ply", &to_scan(target));
    place
}

/// What the JSON on standard output says.
fn told(place: &Place, line: &str) -> Value {
    let run = place.done(&format!("{line} --json -"));
    serde_json::from_slice(&run.stdout).expect("it is JSON")
}

/// Vertices that are written have those of the target first, where they were.
#[track_caller]
fn assert_begins_with(out: &Scan, target: &TriMesh) {
    let positions = out.positions();
    assert!(positions.len() >= target.positions.len());
    for (v, (now, before)) in positions.iter().zip(&target.positions).enumerate() {
        let bits = |p: &nalgebra::Point3<f64>| [p.x, p.y, p.z].map(f64::to_bits);
        assert_eq!(bits(now), bits(before), "vertex {v}");
    }
}

#[test]
fn colors_of_a_body_come_to_a_ball_of_other_vertices() {
    let target = ball(7);
    let place = place(&target);
    let json = told(&place, &format!("{TRANSFER} --audit 40 -o out.ply"));
    assert_eq!(json["command"], "transfer");
    assert_eq!(json["status"], "done");
    assert_eq!(json["input"], "target.ply");
    assert_eq!(json["source"], "source.ply");
    assert_eq!(json["parameters"]["shape"], "heat-kernel");
    assert_eq!(json["parameters"]["seed"], 0);
    assert_eq!(json["displaced"], Value::Null);
    let out = place.scan("out.ply");
    // As many vertices as the source has: those of the target, and others on its edges.
    assert_eq!(out.vertices.rows, 258);
    assert_eq!(json["mesh"]["vertices"], 258);
    assert_eq!(json["mesh"]["made_finer"], true);
    assert_begins_with(&out, &target);
    let levels = json["levels"].as_array().expect("there are levels");
    assert_eq!(levels[0]["vertices"], 258);
    assert!(levels.len() > 1);
    assert_eq!(json["mean_cost"], levels[0]["mean_cost"]);
    assert!(json["mean_cost"].as_f64() > Some(0.0), "{json}");
    // The best matches cost no more than those found.
    let audit = &levels[0]["audit"];
    let audited = audit["vertices"].as_u64().expect("a number");
    assert!((40..80).contains(&audited), "{audit}");
    assert!(audit["least_cost"].as_f64() > Some(0.0), "{audit}");
    assert!(
        audit["mean_cost"].as_f64() >= audit["least_cost"].as_f64(),
        "{audit}"
    );
    let coherent = json["coherent_edges"].as_f64().expect("a share");
    assert!((0.2..=1.0).contains(&coherent), "{coherent}");
    for correlation in json["histogram_correlation"].as_array().expect("three") {
        assert!(correlation.as_f64() > Some(0.3), "{json}");
    }
    // Each vertex has the color of the one that it says it was matched with.
    let source = place.scan("source.ply");
    let (of_source, found) = (colors(&source), colors(&out));
    for (v, source) in sources(&out).into_iter().enumerate() {
        assert_eq!(found[v], of_source[source], "vertex {v}");
    }
    for rotation in values(&out, "rotation") {
        assert!(rotation.abs() <= std::f64::consts::PI + 1e-6);
    }
    assert!(values(&out, "cost").iter().all(|cost| *cost >= 0.0));
}

#[test]
fn a_mesh_onto_itself_gives_its_own_colors_back() {
    let place = place(&body(8, 0.0));
    place.done(&format!("{TRANSFER} -o out.ply"));
    let source = place.scan("source.ply").colors().expect("it has colors");
    let error = mean_error(&place.scan("out.ply"), |v| source[v]);
    assert!(error < 2.0, "{error} of 255");
}

#[test]
fn a_turned_larger_copy_of_other_triangles_gets_the_colors_of_its_places() {
    // Each vertex has the color of one of the source's: half an edge away, the waves of color differ by about 4 of 255.
    let place = Place::with("source.ply", &colored(&body(24, 0.0), hues));
    let copy = body(23, 0.3);
    place.put("target.ply", &to_scan(&carried(&copy)));
    place.done(&format!("{TRANSFER} -o out.ply --keep-mesh"));
    let error = mean_error(&place.scan("out.ply"), |v| hues(&copy.positions[v]));
    assert!(error < 6.0, "{error} of 255");
}

#[test]
fn a_seed_gives_the_same_bytes_for_any_number_of_threads() {
    let place = place(&ball(9));
    let before = [place.bytes("source.ply"), place.bytes("target.ply")];
    for options in ["", "--rotations search --final vote --channel both"] {
        let line = |name: &str, rest: &str| {
            place.done(&format!("{TRANSFER} {options} -o {name} {rest}"));
            place.bytes(name)
        };
        let one = line("one.ply", "--seed 5 --threads 1");
        assert!(one == line("two.ply", "--seed 5 --threads 2"), "{options}");
        assert!(
            one != line("other.ply", "--seed 6"),
            "{options}: the seed has no effect"
        );
    }
    assert!(before == [place.bytes("source.ply"), place.bytes("target.ply")]);
}

#[test]
fn standard_output_carries_the_mesh_and_messages_go_to_standard_error() {
    let place = place(&ball(5));
    let loud = place.done(&format!("{TRANSFER} -o out.ply"));
    assert!(loud.stdout.is_empty());
    for words in [
        "258 vertices matched with 258",
        "continue the source",
        "color histograms",
    ] {
        assert!(loud.stderr.contains(words), "{}", loud.stderr);
    }
    let quiet = place.done(&format!("{TRANSFER} -o out.ply -q"));
    assert!(quiet.stdout.is_empty() && quiet.stderr.is_empty());
    let piped = place.done(&format!("{TRANSFER} -o -"));
    assert!(piped.stdout == place.bytes("out.ply"));
    let stdin = place.bytes("target.ply");
    let read = place.run_with("transfer --source source.ply --target - -o in.ply", &stdin);
    assert_eq!(read.code, 0, "{}", read.stderr);
    assert!(place.bytes("in.ply") == place.bytes("out.ply"));
}

#[test]
fn what_is_painted_spreads_over_the_rest_and_stays() {
    // Stripes above, grey below.
    let mesh = body(10, 0.0);
    let is_painted = |y: f64| y > -0.1;
    let stripes = |p: &nalgebra::Point3<f64>| match (is_painted(p.y), (6.0 * p.x).sin() > 0.0) {
        (true, true) => [0.8, 0.2, 0.1],
        (true, false) => [0.1, 0.3, 0.8],
        _ => [0.5, 0.5, 0.5],
    };
    let mut scan = colored(&mesh, stripes);
    let painted = mesh.positions.iter().map(|p| u8::from(is_painted(p.y)));
    scan.vertices
        .set_channel("painted", Column::U8(painted.collect()));
    let place = Place::with("source.ply", &scan);
    let before = colors(&scan);
    let grey = before[mesh
        .positions
        .iter()
        .position(|p| !is_painted(p.y))
        .expect("some are")];
    let [r, g, b] = grey;
    let color = format!("--mask #{r:02x}{g:02x}{b:02x}");
    let masks = [
        "--mask painted",
        "--mask painted=1",
        "--target source.ply --mask painted",
        &color,
    ];
    for mask in masks {
        place.done(&format!("transfer --source source.ply {mask} -o out.ply"));
        let out = place.scan("out.ply");
        let found = colors(&out);
        let mut greys = 0;
        for (v, p) in mesh.positions.iter().enumerate() {
            if is_painted(p.y) {
                assert_eq!(found[v], before[v], "{mask}: vertex {v} was painted");
            } else {
                greys += usize::from(found[v] == grey);
            }
        }
        assert_eq!(greys, 0, "{mask}: vertices are left that look unpainted");
        assert_begins_with(&out, &mesh);
    }
}

#[test]
fn a_map_to_start_from_is_taken_in_every_form() {
    let place = place(&body(8, 0.0));
    let rows = place.scan("target.ply").vertices.rows;
    let lines: String = (0..rows).map(|v| format!("{v}\n")).collect();
    let list: Vec<Value> = (0..rows)
        .map(|v| if v % 3 == 1 { Value::Null } else { v.into() })
        .collect();
    place.text("map.txt", &lines);
    place.text("map.json", &Value::from(list).to_string());
    let mut mapped = to_scan(&body(8, 0.0));
    mapped
        .vertices
        .set_channel("source", Column::I32((0..).take(rows).collect()));
    place.put("map.ply", &mapped);
    let line = |map: &str| format!("{TRANSFER} --shape none --up none --init {map} -o out.ply");
    let mut outputs = Vec::new();
    for map in ["map.txt", "map.ply", "map.json"] {
        let json = told(&place, &line(map));
        // On a body that is alike nowhere else, nothing is better than where each vertex began.
        assert!(json["coherent_edges"].as_f64() > Some(0.9), "{map}: {json}");
        let source = place.scan("source.ply").colors().expect("it has colors");
        let error = mean_error(&place.scan("out.ply"), |v| source[v]);
        assert!(error < 2.0, "{map}: {error} of 255");
        outputs.push(place.bytes("out.ply"));
    }
    assert!(outputs[0] == outputs[1]);
}

#[test]
fn what_was_written_before_is_a_map_even_if_it_has_more_vertices() {
    let place = place(&ball(6));
    place.done(&format!("{TRANSFER} -o first.ply"));
    assert!(place.scan("first.ply").vertices.rows > place.scan("target.ply").vertices.rows);
    place.done(&format!("{TRANSFER} --init first.ply -o second.ply"));
    // Other meshes with more vertices are none.
    place.put("other.ply", &{
        let mut other = to_scan(&ball(8));
        let rows = other.vertices.rows;
        other
            .vertices
            .set_channel("source", Column::U32(vec![0; rows]));
        other
    });
    let line = format!("{TRANSFER} --init other.ply -o out.ply -q");
    place.refused(1, &line, &["other.ply: ", "258 entries"]);
}

#[test]
fn correspondences_tell_what_is_where() {
    let place = place(&carried(&body(7, 0.2)));
    // The ends of the limbs, as points and as vertices.
    let source = place.scan("source.ply").positions();
    let target = place.scan("target.ply").positions();
    let end = |points: &[nalgebra::Point3<f64>], axis: [f64; 3]| {
        let axis = nalgebra::Vector3::from(axis);
        let along = |v: &usize| points[*v].coords.dot(&axis);
        (0..points.len())
            .max_by(|a, b| along(a).total_cmp(&along(b)))
            .expect("there are some")
    };
    let turn = nalgebra::Rotation3::from_axis_angle(
        &nalgebra::Vector3::y_axis(),
        std::f64::consts::TAU / 5.0,
    );
    let axes = [[0.0, 1.0, 0.2], [1.0, -0.3, 0.1], [-0.5, -0.4, -1.0]];
    let pairs: Vec<Value> = axes
        .iter()
        .enumerate()
        .map(|(k, axis)| {
            let of_source = end(&source, *axis);
            let of_target = end(&target, (turn * nalgebra::Vector3::from(*axis)).into());
            let p = source[of_source];
            match k {
                0 => serde_json::json!([of_source, of_target]),
                _ => serde_json::json!([[p.x, p.y, p.z], of_target]),
            }
        })
        .collect();
    place.text("pairs.json", &Value::from(pairs).to_string());
    let json = told(
        &place,
        &format!("{TRANSFER} --correspondences pairs.json --keep-mesh -o out.ply"),
    );
    assert_eq!(json["parameters"]["shape"]["affinities"], 3);
    let copy = body(7, 0.2);
    let error = mean_error(&place.scan("out.ply"), |v| hues(&copy.positions[v]));
    assert!(error < 30.0, "{error} of 255");
}
