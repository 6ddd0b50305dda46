//! `relievo texture` on small meshes and samples: what it promises.

#![cfg(feature = "image")]

#[path = "../common/mod.rs"]
mod common;

mod directions;
mod kept;
mod refused;
mod relief;

use std::collections::BTreeSet;

use common::place::Place;
use common::samples::{
    BLUE, RED, bytes, checks, colors, image, put_image, sources, sphere, square, together, torus,
    waves,
};
use common::to_scan;
use nalgebra::Point3;
use relievo::mesh::{ClosestPoints, TriMesh, check, euler_characteristic};
use relievo::scan::{Image, Scan};
use serde_json::Value;

/// A mesh in mesh.ply, a sample in sample.png.
fn place(mesh: &TriMesh, sample: &Image) -> Place {
    let place = Place::with("mesh.ply", &to_scan(mesh));
    put_image(&place, "sample.png", sample);
    place
}

const TEXTURE: &str = "texture mesh.ply -e sample.png --vertices 300";

/// What the JSON on standard output says.
fn told(place: &Place, line: &str) -> Value {
    let run = place.done(&format!("{line} --json -"));
    serde_json::from_slice(&run.stdout).expect("it is JSON")
}

#[test]
fn the_json_tells_what_was_done_and_standard_output_nothing_else() {
    let place = place(&sphere(), &checks());
    let json = told(&place, &format!("{TEXTURE} -o out.ply"));
    assert_eq!(json["command"], "texture");
    assert_eq!(json["status"], "done");
    assert_eq!(json["exemplar"], "sample.png");
    assert_eq!(json["parameters"]["density"]["vertices"], 300);
    assert_eq!(json["parameters"]["seed"], 0);
    let levels = json["levels"].as_array().expect("there are levels");
    assert_eq!(levels[0]["vertices"], 300);
    assert_eq!(levels[1]["vertices"], 75);
    for level in levels {
        assert!(level["edge_variation"].as_f64() < Some(0.2), "{level}");
        let coherent = level["coherent_edges"].as_f64().expect("a share");
        assert!((0.0..=1.0).contains(&coherent), "{level}");
        assert!(level["mean_cost"].as_f64() > Some(0.0), "{level}");
    }
    // Along each axis those 4 to 18, which have all neighbors on both levels: two pixels of the coarser one on either side.
    assert_eq!(levels[0]["sites"], 15 * 15);
    assert_eq!(levels[0]["window"], 7);
    assert_eq!(levels.last().expect("there is one")["coarse_window"], 0);

    let quiet = place.done(&format!("{TEXTURE} -o out.ply -q"));
    assert!(quiet.stdout.is_empty() && quiet.stderr.is_empty());
    let loud = place.done(&format!("{TEXTURE} -o out.ply"));
    assert!(loud.stdout.is_empty());
    assert!(
        loud.stderr.contains("relievo: 300 vertices"),
        "{}",
        loud.stderr
    );
    let piped = place.done(&format!("{TEXTURE} -o -"));
    assert!(
        piped.stdout == place.bytes("out.ply"),
        "nothing but the mesh"
    );
    assert_eq!(place.files(), ["mesh.ply", "out.ply", "sample.png"]);
}

#[test]
fn a_seed_gives_the_same_bytes_for_any_number_of_threads() {
    let place = place(&torus(), &waves());
    let before = [place.bytes("mesh.ply"), place.bytes("sample.png")];
    for method in ["coherent", "wei-levoy"] {
        let line = |name: &str, rest: &str| {
            place.done(&format!("{TEXTURE} --method {method} -o {name} {rest}"));
            place.bytes(name)
        };
        let one = line("one.ply", "--seed 5 --threads 1");
        assert!(one == line("two.ply", "--seed 5 --threads 2"), "{method}");
        assert!(
            one != line("other.ply", "--seed 6"),
            "{method}: the seed has no effect"
        );
    }
    assert!(before == [place.bytes("mesh.ply"), place.bytes("sample.png")]);
}

#[test]
fn the_tree_finds_hardly_worse_matches_than_comparing_all() {
    let place = place(&sphere(), &waves());
    let [tree, exhaustive] = ["tree", "exhaustive"].map(|search| {
        let name = format!("{search}.ply");
        place.done(&format!(
            "{TEXTURE} --method wei-levoy --search {search} -o {name}"
        ));
        let scan = place.scan(&name);
        let costs = &scan.vertices.channel("cost").unwrap().values;
        let sum: f64 = (0..scan.vertices.rows)
            .filter_map(|v| costs.get_f64(v))
            .sum();
        sum / scan.vertices.rows as f64
    });
    assert!(
        exhaustive > 0.0 && tree < 1.1 * exhaustive,
        "{tree} {exhaustive}"
    );
}

#[test]
fn the_mesh_has_as_many_vertices_as_asked_for_and_keeps_its_shape() {
    for (mesh, characteristic) in [(sphere(), 2), (torus(), 0), (square(), 1)] {
        let place = place(&mesh, &checks());
        for count in [200, 501] {
            let line = format!("texture mesh.ply -e sample.png --vertices {count} -o out.ply");
            place.done(&line);
            let found = place.scan("out.ply").mesh();
            assert_eq!(found.positions.len(), count);
            assert_eq!(check(&found), Ok(()));
            assert_eq!(euler_characteristic(&found), characteristic);
            let surface = ClosestPoints::new(&mesh);
            for p in &found.positions {
                let (_, _, distance_sq) = surface.closest(p, None).expect("there are faces");
                assert!(
                    distance_sq.sqrt() < 1e-7,
                    "{p} is {} off",
                    distance_sq.sqrt()
                );
            }
        }
    }
    // By the length of a texel: an area of 100 in squares of 0.4.
    let place = place(&square(), &checks());
    place.done("texture mesh.ply -e sample.png --texel 0.4 -o out.ply");
    assert_eq!(place.scan("out.ply").vertices.rows, 625);
}

/// The colors of an image, as bytes.
fn palette(sample: &Image) -> BTreeSet<[u8; 3]> {
    let opaque = |i: &usize| sample.opaque.as_ref().is_none_or(|opaque| opaque[*i]);
    let pixels = (0..sample.colors.len()).filter(opaque);
    pixels.map(|i| bytes(sample.colors[i])).collect()
}

#[test]
fn all_colors_are_the_samples_and_as_frequent() {
    for (sample, mesh) in [(waves(), torus()), (checks(), square())] {
        let place = place(&mesh, &sample);
        let line = "texture mesh.ply -e sample.png --vertices 1000 -o out.ply";
        let json = told(&place, line);
        let palette = palette(&sample);
        let out = place.scan("out.ply");
        let found = colors(&out);
        assert!(found.iter().all(|color| palette.contains(color)));
        for correlation in json["histogram_correlation"].as_array().expect("three") {
            assert!(correlation.as_f64() >= Some(0.95), "{json}");
        }
        // Each vertex has the color of the pixel that it says it was copied from.
        for (v, source) in sources(&out).into_iter().enumerate() {
            let pixel = sample.colors[source];
            assert_eq!(bytes(pixel), found[v], "vertex {v}");
        }
    }
}

#[test]
fn grey_stays_grey_in_8_and_16_bits() {
    for bits in [8, 16] {
        let mut sample = image(24, 24, |x, y| [((x * 5 + y * 3) % 24) as f32 / 24.0; 3]);
        sample.bits = bits;
        let place = place(&sphere(), &sample);
        place.done(&format!("{TEXTURE} -o out.ply"));
        let found = colors(&place.scan("out.ply"));
        assert!(
            found.iter().all(|[r, g, b]| r == g && g == b),
            "{bits} bits"
        );
        let palette = palette(&sample);
        assert!(
            found.iter().all(|color| palette.contains(color)),
            "{bits} bits"
        );
        assert!(
            found.iter().collect::<BTreeSet<_>>().len() > 12,
            "{bits} bits"
        );
    }
    // 16 bits in color.
    let mut sample = waves();
    sample.bits = 16;
    let place = place(&sphere(), &sample);
    place.done(&format!("{TEXTURE} -o out.ply"));
    let palette = palette(&sample);
    assert!(
        colors(&place.scan("out.ply"))
            .iter()
            .all(|c| palette.contains(c))
    );
}

#[test]
fn transparent_pixels_are_never_copied() {
    // Green, but not to be seen.
    let mut sample = checks();
    let is_opaque = |i: usize| i % 24 >= 4 || i / 24 >= 6;
    for (i, color) in sample.colors.iter_mut().enumerate() {
        if !is_opaque(i) {
            *color = [0.0, 1.0, 0.0];
        }
    }
    sample.opaque = Some((0..24 * 24).map(is_opaque).collect());
    let place = place(&torus(), &sample);
    for method in ["coherent", "wei-levoy"] {
        place.done(&format!("{TEXTURE} --method {method} -o out.ply"));
        let out = place.scan("out.ply");
        let found: BTreeSet<[u8; 3]> = colors(&out).into_iter().collect();
        assert_eq!(found, BTreeSet::from([RED, BLUE]), "{method}");
        for source in sources(&out) {
            assert!(is_opaque(source), "{method}: pixel {source}");
        }
    }
}

#[test]
fn odd_meshes_are_textured() {
    let square = square();
    let mut far = square.clone();
    for p in &mut far.positions {
        p.x += 30.0;
    }
    let mut unused = square.clone();
    unused
        .positions
        .extend([Point3::new(99.0, 0.0, 0.0), Point3::new(0.0, -99.0, 7.0)]);
    let mut degenerate = square.clone();
    degenerate.triangles.extend([[0, 0, 1], [5, 9, 9]]);
    let corner = |x: f64, y: f64| Point3::new(x, y, 0.0);
    let bow_tie = TriMesh {
        positions: vec![
            corner(0.0, 0.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
            corner(-1.0, -1.0),
        ],
        triangles: vec![[0, 1, 2], [0, 3, 4]],
    };
    let triangle = TriMesh {
        positions: vec![corner(0.0, 0.0), corner(3.0, 0.0), corner(1.0, 2.0)],
        triangles: vec![[0, 1, 2]],
    };
    let points = TriMesh {
        triangles: Vec::new(),
        ..square.clone()
    };
    for (name, mesh, characteristics) in [
        ("two pieces", together(&[square.clone(), far]), [2, 2]),
        (
            "a closed and an open piece",
            together(&[sphere(), unused.clone()]),
            [3, 3],
        ),
        ("unused vertices", unused, [1, 1]),
        ("degenerate faces", degenerate, [1, 1]),
        // The wings may part.
        ("a bow tie", bow_tie, [1, 2]),
        ("a triangle", triangle, [1, 1]),
        ("points", points, [1, 1]),
    ] {
        let place = place(&mesh, &checks());
        place.done(&format!("{TEXTURE} -o out.ply"));
        let out = place.scan("out.ply");
        assert_eq!(out.vertices.rows, 300, "{name}");
        assert_eq!(check(&out.mesh()), Ok(()), "{name}");
        let found = euler_characteristic(&out.mesh());
        assert!(characteristics.contains(&found), "{name}: {found}");
        let found: BTreeSet<[u8; 3]> = colors(&out).into_iter().collect();
        assert_eq!(found, BTreeSet::from([RED, BLUE]), "{name}");
    }
}

/// The input's channels are those of the output, bit for bit.
#[track_caller]
fn assert_kept(before: &Scan, after: &Scan, but: &[&str]) {
    let rows = before.vertices.rows;
    assert_eq!(after.vertices.rows, rows);
    assert!(before.faces == after.faces, "faces have changed");
    for old in before
        .vertices
        .channels
        .iter()
        .filter(|c| !but.contains(&c.name.as_str()))
    {
        let new = after.vertices.column(&old.name).expect("it is still there");
        assert!(
            common::bits(new, rows) == common::bits(&old.values, rows),
            "{} has changed",
            old.name
        );
    }
}
