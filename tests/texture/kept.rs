//! Meshes that are kept as they are.

use std::collections::BTreeSet;

use relievo::scan::{Column, read_image};

use crate::common::place::Place;
use crate::common::samples::{
    bytes, checks, colors, put_image, square, torus, with_texture_coordinates,
};
use crate::common::to_scan;
use crate::{TEXTURE, assert_kept, told};

#[test]
fn a_mesh_that_is_kept_gets_colors_and_nothing_else_changes() {
    let mut mesh = to_scan(&torus());
    let rows = mesh.vertices.rows;
    let quality = (0..rows).map(|v| (v as f32).sin()).collect();
    mesh.vertices.set_channel("quality", Column::F32(quality));
    mesh.comments = vec!["of a museum".into()];
    let place = Place::with("mesh.ply", &mesh);
    put_image(&place, "sample.png", &checks());
    place.done(&format!("{TEXTURE} --keep-mesh -o out.ply"));
    let out = place.scan("out.ply");
    assert_kept(&mesh, &out, &[]);
    assert_eq!(out.comments, mesh.comments);
    let found: BTreeSet<[u8; 3]> = colors(&out).into_iter().collect();
    assert!(found.len() > 1);
    for name in ["out.obj", "out.glb", "out.off"] {
        place.done(&format!("{TEXTURE} --keep-mesh -o {name}"));
        let written = place.scan(name);
        assert_eq!(written.faces.len(), mesh.faces.len(), "{name}");
        assert!(written.colors().is_some(), "{name}");
    }
    let few = place.run("texture mesh.ply -e sample.png --vertices 2000 --keep-mesh -o out.ply");
    assert_eq!(few.code, 0);
    assert!(
        few.stderr.contains("leave out --keep-mesh"),
        "{}",
        few.stderr
    );
}

/// The pixel of 64 that is nearest.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped"
)]
fn nearest(at: f64) -> usize {
    at.round().clamp(0.0, 63.0) as usize
}

#[test]
fn texture_coordinates_get_an_image() {
    let mesh = with_texture_coordinates(to_scan(&square()));
    let place = Place::with("mesh.ply", &mesh);
    put_image(&place, "sample.png", &checks());
    place.done(&format!("{TEXTURE} -o vertices.ply"));
    let line = |name: &str| told(&place, &format!("{TEXTURE} --keep-mesh -o {name}"));
    let json = line("a.ply");
    // 10 units over 300 vertices: 17 texels, which the smallest image has room for.
    assert_eq!(
        [&json["image"]["width"], &json["image"]["height"]],
        [64, 64]
    );
    assert_kept(&mesh, &place.scan("a.ply"), &["red", "green", "blue"]);
    let shown = read_image(&place.path("a.png")).expect("it is an image");
    assert_eq!((shown.width, shown.height), (64, 64));
    line("b.obj");
    line("c.glb");
    let expected = [
        "a.ply",
        "a.png",
        "b.mtl",
        "b.obj",
        "b.png",
        "c.glb",
        "mesh.ply",
        "sample.png",
        "vertices.ply",
    ];
    assert_eq!(place.files(), expected);
    assert!(place.bytes("b.png") == place.bytes("a.png"));
    let library = String::from_utf8(place.bytes("b.mtl")).expect("it is text");
    assert!(library.contains("map_Kd b.png"), "{library}");
    assert_eq!(place.scan("c.glb").faces.len(), mesh.faces.len());

    // A pixel at a vertex of the textured mesh has its color.
    let textured = place.scan("vertices.ply");
    let mut same = 0;
    for (p, color) in textured.positions().iter().zip(colors(&textured)) {
        let [column, row] = [6.4 * p.x - 0.5, 63.5 - 6.4 * p.y].map(nearest);
        let pixel = bytes(shown.colors[64 * row + column]);
        // Red is what tells the two apart; between vertices it is mixed.
        same += usize::from((i32::from(pixel[0]) - i32::from(color[0])).abs() < 70);
    }
    assert!(
        same * 100 >= 95 * textured.vertices.rows,
        "{same} of {}",
        textured.vertices.rows
    );
    let limited = told(
        &place,
        &format!("{TEXTURE} --keep-mesh --image-size 32 -o d.glb"),
    );
    assert_eq!(
        [&limited["image"]["width"], &limited["image"]["height"]],
        [32, 32]
    );
}
