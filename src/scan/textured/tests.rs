#![allow(clippy::float_cmp, reason = "the values are exact in binary")]

use std::fs;

use super::*;
use crate::scan::{Column, ReadOptions, read, read_from, read_image};

/// A tent of two quads and a triangle; the seam between the quads has other texture coordinates on either side.
const TENT: &str = "v 0 0 0 1 0 0\nv 1 0 0.5 0 1 0\nv 2 0 0 0 0 1\nv 2 1 0 1 1 0\nv 1 1 0.5 0 1 1\nv 0 1 0 1 1 1\n\
                    vt 0 0\nvt 0.375 0\nvt 0.375 1\nvt 0 1\nvt 0.625 0\nvt 1 0\nvt 1 1\nvt 0.625 1\n\
                    f 1/1 2/2 5/3 6/4\nf 2/5 3/6 4/7 5/8\nf 1 6 5\n";

fn tent() -> Scan {
    read_from(
        TENT.as_bytes(),
        Format::Obj,
        "tent",
        &ReadOptions::default(),
    )
    .unwrap()
}

/// Left half red, right half blue.
fn image() -> Image {
    let color = |k: usize| {
        if k % 8 < 4 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 0.0, 1.0]
        }
    };
    Image {
        width: 8,
        height: 4,
        colors: (0..32).map(color).collect(),
        opaque: None,
        is_grey: false,
        bits: 8,
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn write(scan: &Scan, path: &Path) -> Result<(), ScanError> {
    TexturedOutput::create(path, &[])?.write(scan, &image(), &WriteOptions::default())
}

/// Positions and texture coordinates of the corners of all triangles that have them.
fn corners(scan: &Scan) -> Vec<[f64; 5]> {
    let mesh = scan.mesh();
    let rows = scan.texture_coordinates().unwrap();
    let all = mesh
        .triangles
        .iter()
        .flatten()
        .zip(rows.into_iter().flatten());
    all.filter(|(_, c)| !c[0].is_nan())
        .map(|(v, [s, t])| {
            let p = mesh.positions[*v as usize];
            [p.x, p.y, p.z, s, t]
        })
        .collect()
}

#[test]
fn obj_comes_with_material_and_image_and_shows_the_image() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tent one.obj");
    write(&tent(), &path).unwrap();
    assert_eq!(
        names(folder.path()),
        ["tent one.mtl", "tent one.obj", "tent one.png"]
    );
    assert_eq!(
        read_image(&folder.path().join("tent one.png")).unwrap(),
        image()
    );
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("mtllib tent one.mtl\nv 0 0 0\n"), "{text}");
    assert!(
        text.ends_with("usemtl texture\nf 1/1 2/2 5/3 6/4\nf 2/5 3/6 4/7 5/8\nf 1 6 5\n"),
        "{text}"
    );
    let back = read(&path, &ReadOptions::default()).unwrap();
    assert_eq!(corners(&back), corners(&tent()));
    // Colors come from the image now, not from the vertices before.
    assert_eq!(back.colors().unwrap()[3], [0.0, 0.0, 1.0]);
}

#[test]
fn ply_comes_with_its_image_in_the_way_of_meshlab() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply");
    let mut scan = tent();
    scan.comments = vec!["TextureFile old.jpg".into(), "kept".into()];
    scan.face_channels
        .set_channel("texnumber", Column::I32(vec![0, 1, 1]));
    write(&scan, &path).unwrap();
    assert_eq!(names(folder.path()), ["a.ply", "a.png"]);
    let back = read(&path, &ReadOptions::default()).unwrap();
    assert_eq!(back.comments, ["kept", "TextureFile a.png"]);
    assert_eq!(back.vertices, scan.vertices);
    assert!(back.face_channels.column("texnumber").is_none());
    assert_eq!(corners(&back), corners(&scan));
    let Some(Column::List(lists)) = back.face_channels.column("texcoord") else {
        unreachable!();
    };
    assert_eq!(lists[2], Column::F32(vec![]));
}

#[test]
fn glb_holds_its_image_and_splits_vertices_at_seams() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    write(&tent(), &path).unwrap();
    assert_eq!(names(folder.path()), ["a.glb"]);
    let back = read(&path, &ReadOptions::default()).unwrap();
    // Two of the seam, and three of the triangle without coordinates but for one that is at 0 anyway.
    assert_eq!(back.vertices.rows, 6 + 2 + 2);
    assert_eq!(back.positions()[..6], tent().positions());
    let with_zeros = corners(&back);
    for corner in corners(&tent()) {
        assert!(with_zeros.contains(&corner), "{corner:?}");
    }
    assert_eq!(back.triangles().len(), 5);
    assert_eq!(back.colors().unwrap()[3], [0.0, 0.0, 1.0]);
    // Without an image: coordinates of vertices stay, under the name of the format.
    let bytes = fs::read(&path).unwrap();
    assert!(bytes.windows(9).any(|w| w == b"image/png"));
    let plain = folder.path().join("plain.glb");
    crate::scan::write(&back, &plain, &WriteOptions::default()).unwrap();
    let again = read(&plain, &ReadOptions::default()).unwrap();
    assert_eq!(again.texture_coordinates(), back.texture_coordinates());
    assert_eq!(again.colors(), back.colors());
}

#[test]
fn coordinates_of_vertices_become_those_of_corners() {
    let folder = tempfile::tempdir().unwrap();
    write(&tent(), &folder.path().join("a.glb")).unwrap();
    let scan = read(&folder.path().join("a.glb"), &ReadOptions::default()).unwrap();
    for name in ["b.ply", "b.obj"] {
        let path = folder.path().join(name);
        // The image of the one before.
        let _ = fs::remove_file(folder.path().join("b.png"));
        write(&scan, &path).unwrap();
        let back = read(&path, &ReadOptions::default()).unwrap();
        assert!(back.face_channels.column("texcoord").is_some());
        assert_eq!(corners(&back), corners(&scan));
    }
}

#[test]
fn nothing_is_overwritten_that_should_not_be() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    fs::write(file("wood.png"), "exemplar").unwrap();
    let create = |name: &str, protected: &[&Path]| TexturedOutput::create(&file(name), protected);
    let error = create("wood.obj", &[&file("wood.png")]).unwrap_err();
    assert!(matches!(error, ScanError::WouldOverwrite { .. }), "{error}");
    // Nobody says that it is an input, but there is no mesh that it belongs to.
    let error = create("wood.ply", &[]).unwrap_err();
    assert!(matches!(error, ScanError::Foreign { .. }), "{error}");
    assert_eq!(names(folder.path()), ["wood.png"]);
    assert!(create("wood.glb", &[&file("wood.png")]).is_ok());
    fs::write(file("mesh.glb"), "input").unwrap();
    let error = create("mesh.glb", &[&file("wood.png"), &file("mesh.glb")]).unwrap_err();
    assert!(matches!(error, ScanError::WouldOverwrite { .. }), "{error}");
    // Again to the same name is fine.
    write(&tent(), &file("a.obj")).unwrap();
    write(&tent(), &file("a.obj")).unwrap();
    assert_eq!(fs::read(file("wood.png")).unwrap(), b"exemplar");
}

#[test]
fn what_cannot_be_written_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let plain = read_from(
        &b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"[..],
        Format::Obj,
        "a",
        &ReadOptions::default(),
    );
    let plain = plain.unwrap();
    for name in ["a.obj", "a.ply", "a.glb"] {
        let error = write(&plain, &file(name)).unwrap_err();
        assert!(
            matches!(error, ScanError::NoTextureCoordinates { .. }),
            "{error}"
        );
        let output = TexturedOutput::create(&file(name), &[]).unwrap();
        let broken = Image {
            width: 9,
            ..image()
        };
        assert!(
            output
                .write(&tent(), &broken, &WriteOptions::default())
                .is_err()
        );
    }
    for (path, part) in [
        (PathBuf::from("-"), "standard output"),
        (file("a.stl"), "a.stl: cannot write a texture image"),
        (file("a"), "choose .ply, .obj or .glb"),
        (file("a\nb.obj"), "without line breaks"),
    ] {
        let error = TexturedOutput::create(&path, &[]).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    assert!(names(folder.path()).is_empty());
}
