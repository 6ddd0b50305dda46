//! What stays of the target, and what is written.

use relievo::scan::{Column, read_image};

use crate::common::place::Place;
use crate::common::samples::{
    colors, image, put_image, square, together, with_texture_coordinates,
};
use crate::common::{bits, to_scan};
use crate::shapes::{ball, body, colored, hues};
use crate::{TRANSFER, place, told};

#[test]
fn every_channel_of_a_target_that_is_kept_stays() {
    let mut target = to_scan(&ball(8));
    let rows = target.vertices.rows;
    let quality = (0..rows).map(|v| (v as f32).sin()).collect();
    target.vertices.set_channel("quality", Column::F32(quality));
    target.comments = vec!["of a museum".into()];
    let place = place(&ball(8));
    place.put("target.ply", &target);
    place.done(&format!("{TRANSFER} --keep-mesh -o out.ply"));
    let out = place.scan("out.ply");
    assert!(out.faces == target.faces);
    assert_eq!(out.comments, target.comments);
    for before in &target.vertices.channels {
        let after = out
            .vertices
            .column(&before.name)
            .expect("it is still there");
        assert!(
            bits(after, rows) == bits(&before.values, rows),
            "{}",
            before.name
        );
    }
    let names: Vec<&str> = out
        .vertices
        .channels
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    let expected = [
        "x", "y", "z", "quality", "red", "green", "blue", "source", "rotation", "cost",
    ];
    assert_eq!(names, expected);
    // Without it, the property is there at all vertices.
    place.put("source.ply", &colored(&body(12, 0.0), hues));
    let run = place.done(&format!("{TRANSFER} --keep-mesh -o out.ply"));
    assert!(
        run.stderr.contains("leave out --keep-mesh"),
        "{}",
        run.stderr
    );
    place.done(&format!("{TRANSFER} -o finer.ply"));
    let finer = place.scan("finer.ply");
    assert_eq!(finer.vertices.rows, 578);
    let quality = finer.vertices.column("quality").expect("it is there");
    let [now, before] = [
        quality,
        target.vertices.column("quality").expect("it is there"),
    ]
    .map(|column| (0..rows).map(|v| column.get_f64(v)).collect::<Vec<_>>());
    assert_eq!(now, before);
    for name in ["out.obj", "out.glb", "out.off", "out.stl"] {
        place.done(&format!("{TRANSFER} -o {name}"));
        assert_eq!(place.scan(name).faces.len(), finer.faces.len(), "{name}");
    }
}

#[test]
fn colors_that_were_there_keep_their_type() {
    let mut target = to_scan(&ball(6));
    let rows = target.vertices.rows;
    for name in ["red", "green", "blue"] {
        target
            .vertices
            .set_channel(name, Column::F32(vec![0.5; rows]));
    }
    let place = place(&ball(6));
    place.put("target.ply", &target);
    place.done(&format!("{TRANSFER} -o out.ply"));
    let out = place.scan("out.ply");
    assert!(matches!(out.vertices.column("red"), Some(Column::F32(_))));
    let found = out.colors().expect("it has colors");
    assert!(found.iter().any(|c| c[0] < 0.3) && found.iter().any(|c| c[0] > 0.7));
}

#[test]
fn texture_coordinates_get_an_image() {
    let flat = |p: &nalgebra::Point3<f64>| [p.x / 10.0, p.y / 10.0, 0.5];
    let place = Place::with("source.ply", &colored(&square(), flat));
    place.put("target.ply", &with_texture_coordinates(to_scan(&square())));
    let line = |name: &str, options: &str| {
        told(
            &place,
            &format!("{TRANSFER} --shape position --up none -o {name} {options}"),
        )
    };
    let json = line("a.ply", "");
    assert_eq!(
        [&json["image"]["width"], &json["image"]["height"]],
        [64, 64]
    );
    assert_eq!(json["mesh"]["made_finer"], false);
    let target = place.scan("target.ply");
    let out = place.scan("a.ply");
    assert!(out.faces == target.faces);
    let shown = read_image(&place.path("a.png")).expect("it is an image");
    // The image shows what vertices have: red rises to the right, green to the top.
    let vertices = place.scan("source.ply").colors().expect("it has colors");
    assert_eq!(vertices.len(), 169);
    let mean: f32 = (0..64 * 64)
        .map(|i| {
            let expected = [(i % 64) as f32 / 63.0, 1.0 - (i / 64) as f32 / 63.0, 0.5];
            (0..3)
                .map(|k| (shown.colors[i][k] - expected[k]).abs())
                .sum::<f32>()
                / 3.0
        })
        .sum::<f32>()
        / 4096.0;
    assert!(mean < 0.02, "{mean}");
    line("b.obj", "--vertices 600");
    line("c.glb", "--vertices 600 --image-size 32");
    assert_eq!(
        place.files(),
        [
            "a.ply",
            "a.png",
            "b.mtl",
            "b.obj",
            "b.png",
            "c.glb",
            "source.ply",
            "target.ply"
        ]
    );
    // With relief there are more vertices, and the image stays where it is.
    let json = line("d.ply", "--vertices 600 --channel both");
    assert_eq!(json["mesh"]["vertices"], 600);
    let finer = place.scan("d.ply");
    let uv = finer.texture_coordinates().expect("it has them");
    for (triangle, corners) in finer.mesh().triangles.iter().zip(uv) {
        for (v, [u, _]) in triangle.iter().zip(corners) {
            let x = finer.positions()[*v as usize].x;
            assert!((u - x / 10.0).abs() < 0.02, "{u} at {x}");
        }
    }
    assert!(place.files().contains(&"d.png".to_owned()));
}

#[test]
fn detail_of_a_sources_texture_image_is_not_lost() {
    // Two triangles, 16 stripes.
    let stripes = image(64, 64, |x, _| {
        if (x / 4) % 2 == 0 {
            [1.0, 0.2, 0.0]
        } else {
            [0.0, 0.2, 1.0]
        }
    });
    let place = Place::new();
    put_image(&place, "stripes.png", &stripes);
    place.text("source.mtl", "newmtl a\nmap_Kd stripes.png\n");
    place.text(
        "source.obj",
        "mtllib source.mtl\nusemtl a\nv 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
    );
    place.put("target.ply", &to_scan(&square()));
    let json = told(
        &place,
        "transfer --source source.obj --target target.ply --shape position --up none --vertices 2500 -o out.ply",
    );
    assert_eq!(json["source_made_finer"], 2500);
    let out = place.scan("out.ply");
    let found = colors(&out);
    let reds = found.iter().filter(|c| c[0] > 200).count();
    let blues = found.iter().filter(|c| c[2] > 200).count();
    assert!(reds > 700 && blues > 700, "{reds} and {blues}");
    // Sources are vertices of the file.
    assert!(crate::common::samples::sources(&out).iter().all(|s| *s < 4));
}

#[test]
fn pieces_holes_and_three_faces_are_targets_as_well() {
    let mut far = body(6, 0.2);
    for p in &mut far.positions {
        p.x += 9.0;
    }
    let mut holed = ball(8);
    holed.triangles.drain(20..60);
    let tent = relievo::mesh::TriMesh {
        positions: [
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.0, 2.0, 0.0],
            [0.0, 0.0, 2.0],
        ]
        .map(nalgebra::Point3::from)
        .to_vec(),
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2]],
    };
    // Three faces at an edge; one of them goes.
    let mut fins = ball(8);
    let [a, b, _] = fins.triangles[0];
    fins.positions.push(nalgebra::Point3::new(3.0, 3.0, 3.0));
    fins.triangles
        .push([a, b, u32::try_from(fins.positions.len() - 1).expect("few")]);
    for (what, target) in [
        ("pieces", together(&[body(7, 0.1), far])),
        ("holes", holed),
        ("three faces", tent),
        ("an edge of three faces", fins),
    ] {
        let place = place(&target);
        let json = told(&place, &format!("{TRANSFER} -o out.ply"));
        assert_eq!(json["status"], "done", "{what}");
        let out = place.scan("out.ply");
        out.check(what).expect("it is whole");
        crate::assert_begins_with(&out, &target);
        let found: std::collections::BTreeSet<[u8; 3]> = colors(&out).into_iter().collect();
        assert!(found.len() > 50, "{what}: {} colors", found.len());
    }
}
