#![allow(clippy::float_cmp, reason = "the values are exact in binary")]

use std::fs;

use image::{Rgb, RgbImage};

use super::*;
use crate::mesh::{surface_area, triangle_normal};
use crate::rng::{Rng, Stage};
use crate::scan::{Scan, TexturedOutput, WriteOptions, bake, read, read_from, read_image, testing};

const BLACK: [f64; 3] = [0.0; 3];
const RED: [f64; 3] = [1.0, 0.0, 0.0];
const GREEN: [f64; 3] = [0.0, 1.0, 0.0];
const BLUE: [f64; 3] = [0.0, 0.0, 1.0];

/// A unit square of two triangles, the whole image on it.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

/// Two by two pixels, the upper ones black and red, the lower ones green and blue; and one that is all red.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut image = RgbImage::new(2, 2);
    image.put_pixel(1, 0, Rgb([255, 0, 0]));
    image.put_pixel(0, 1, Rgb([0, 255, 0]));
    image.put_pixel(1, 1, Rgb([0, 0, 255]));
    image.save(folder.path().join("four.png")).unwrap();
    let red = RgbImage::from_pixel(1, 1, Rgb([255, 0, 0]));
    red.save(folder.path().join("all red.png")).unwrap();
    folder
}

fn map_of(path: &Path) -> Option<ColorMap> {
    read_color_map(path, &ReadOptions::default()).unwrap()
}

/// The map of a file of this text, with this library of materials.
fn map_of_text(folder: &Path, name: &str, text: &str, materials: &str) -> Option<ColorMap> {
    fs::write(folder.join("look.mtl"), materials).unwrap();
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    map_of(&path)
}

fn at(map: &ColorMap, x: f64, y: f64) -> [f64; 3] {
    map.color(&Point3::new(x, y, 0.0), None).unwrap()
}

#[test]
fn a_square_shows_the_pixels_of_its_image_inside() {
    let folder = folder();
    let text = format!("mtllib look.mtl\n{SQUARE}usemtl a\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
    let materials = "newmtl a\nKd 0.5 0.5 0.5\nmap_Kd four.png\n";
    let map = map_of_text(folder.path(), "a.obj", &text, materials).unwrap();
    for (x, y, color) in [
        (0.25, 0.25, GREEN),
        (0.75, 0.25, BLUE),
        (0.75, 0.75, RED),
        (0.25, 0.75, BLACK),
        (0.5, 0.25, [0.0, 0.5, 0.5]),
        (0.5, 0.5, [0.25; 3]),
        // Not mixed with the other side of the image.
        (0.0, 0.0, GREEN),
        (-7.0, 0.25, GREEN),
    ] {
        assert_eq!(at(&map, x, y), color, "{x} {y}");
        let above = Point3::new(x, y, 3.0);
        assert_eq!(map.color(&above, Some(&Vector3::z())), Some(color));
    }
    assert_eq!(map.color(&Point3::new(f64::NAN, 0.0, 0.0), None), None);
}

#[test]
fn each_face_shows_the_image_of_its_material() {
    let folder = folder();
    // Five squares of one size, side by side: two images, a color, nothing known, and no coordinates.
    let mut text = "mtllib look.mtl\nvt 0 0\nvt 2 0\nvt 2 2\nvt 0 2\n".to_owned();
    for x in 0..5 {
        for (x, y) in [(x, 0), (x + 1, 0), (x + 1, 1), (x, 1)] {
            text += &format!("v {x} {y} 0\n");
        }
    }
    text += "f 13/1 14/2 15/3 16/4\nusemtl four\nf 1/1 2/2 3/3 4/4\nusemtl red\nf 5/1 6/2 7/3 8/4\n\
             usemtl plain\nf 9/1 10/2 11/3 12/4\nusemtl four\nf 17 18 19 20\n";
    let materials = "newmtl plain\nKd 0.25 0.5 0.75\nnewmtl red\nmap_Kd all red.png\n\
                     newmtl four\nKd 0 0 1\nmap_Kd -clamp on -o 0.25 0 -s 1 1 1 four.png\n";
    let map = map_of_text(folder.path(), "a.obj", &text, materials).unwrap();
    assert_eq!(at(&map, 0.25, 0.125), BLUE);
    assert_eq!(at(&map, 0.0625, 0.125), [0.0, 0.75, 0.25]);
    // Beyond its border.
    assert_eq!(at(&map, 0.875, 0.875), RED);
    assert_eq!(at(&map, 1.5, 0.5), RED);
    assert_eq!(at(&map, 2.5, 0.5), [0.25, 0.5, 0.75]);
    assert_eq!(at(&map, 3.5, 0.5), [1.0; 3]);
    assert_eq!(at(&map, 4.5, 0.5), BLUE);
}

#[test]
fn colors_of_vertices_stand_in_where_there_is_no_image() {
    let folder = folder();
    let text = "mtllib look.mtl\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 0 0 1\nv 0 1 0 0 1 0\n\
                vt 0.25 0.25\nvt 0.25 0.25\nvt 0.25 0.25\nusemtl a\nf 1/1 2/2 3/3\nf 1 3 4\n";
    let materials = "newmtl a\nKd 1 1 0\nmap_Kd four.png\n";
    let map = map_of_text(folder.path(), "a.obj", text, materials).unwrap();
    assert_eq!(at(&map, 0.75, 0.25), GREEN);
    assert_eq!(at(&map, 0.0, 0.5), [0.5, 0.5, 0.0]);
}

/// The square as PLY with these comments, and a number of the image for each face if given.
fn ply(comments: &str, numbers: Option<[i32; 2]>) -> String {
    let property = numbers.map_or("", |_| "property int texnumber\n");
    let number = |k: usize| numbers.map_or(String::new(), |numbers| format!(" {}", numbers[k]));
    format!(
        "ply\nformat ascii 1.0\n{comments}element vertex 4\nproperty float x\nproperty float y\n\
         property float z\nelement face 2\nproperty list uchar int vertex_indices\n\
         property list uchar float texcoord\n{property}end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n\
         3 0 1 2 6 0 0 1 0 1 1{}\n3 0 2 3 6 0 0 1 1 0 1{}\n",
        number(0),
        number(1)
    )
}

#[test]
fn ply_shows_the_images_that_its_comments_name() {
    let folder = folder();
    let map = |text: &str| map_of_text(folder.path(), "a.ply", text, "");
    let one = map(&ply("comment made\ncomment TextureFile four.png\n", None)).unwrap();
    assert_eq!(at(&one, 0.75, 0.25), BLUE);
    assert_eq!(at(&one, 0.25, 0.75), BLACK);
    let two = "comment TextureFile all red.png\ncomment TextureFile four.png\n";
    let swapped = map(&ply(two, Some([1, 0]))).unwrap();
    assert_eq!(at(&swapped, 0.75, 0.25), BLUE);
    assert_eq!(at(&swapped, 0.25, 0.75), RED);
    let first = map(&ply(two, None)).unwrap();
    assert_eq!(at(&first, 0.75, 0.25), RED);
    let none = map(&ply(two, Some([1, -1]))).unwrap();
    assert_eq!(at(&none, 0.75, 0.25), BLUE);
    assert_eq!(at(&none, 0.25, 0.75), [1.0; 3]);
    assert!(map(&ply(two, Some([-1, 7]))).is_none());
    let missing = "comment TextureFile none.png\ncomment TextureFile four.png\n";
    let missing = map(&ply(missing, Some([0, 1]))).unwrap();
    assert_eq!(at(&missing, 0.75, 0.25), [1.0; 3]);
}

#[test]
fn without_an_image_on_faces_there_is_no_map() {
    let folder = folder();
    let file = |name: &str| folder.path().join(name);
    fs::write(
        file("broken.png"),
        &fs::read(file("four.png")).unwrap()[..40],
    )
    .unwrap();
    let faces = "usemtl a\nf 1/1 2/2 3/3\n";
    let textured = format!("mtllib look.mtl\n{SQUARE}{faces}");
    for (name, text, materials) in [
        (
            "a.obj",
            format!("{SQUARE}{faces}"),
            "newmtl a\nmap_Kd four.png\n",
        ),
        ("a.obj", textured.clone(), "newmtl a\nKd 1 0 0\n"),
        ("a.obj", textured.clone(), "newmtl a\nmap_Kd broken.png\n"),
        ("a.obj", textured.clone(), "newmtl a\nmap_Kd none.png\n"),
        (
            "a.obj",
            format!("{textured}usemtl b\n"),
            "newmtl b\nmap_Kd four.png\n",
        ),
        (
            "a.obj",
            format!("mtllib look.mtl\n{SQUARE}usemtl a\nf 1 2 3\n"),
            "newmtl a\nmap_Kd four.png\n",
        ),
        ("a.obj", "v 0 0 0\n".to_owned(), ""),
        ("a.ply", ply("", None), ""),
        ("a.ply", ply("comment TextureFile\n", None), ""),
        ("a.ply", ply("comment TextureFile broken.png\n", None), ""),
        ("a.off", "OFF\n1 0 0\n0 0 0\n".to_owned(), ""),
    ] {
        let map = map_of_text(folder.path(), name, &text, materials);
        assert!(map.is_none(), "{text}{materials}");
    }
    assert!(map_of(Path::new("-")).is_none());
    let error = |path: &Path| {
        let error = read_color_map(path, &ReadOptions::default()).unwrap_err();
        let plainly = read(path, &ReadOptions::default()).unwrap_err();
        assert_eq!(error.to_string(), plainly.to_string());
    };
    error(&file("no such file.obj"));
    fs::write(file("bad.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    error(&file("bad.obj"));
    fs::write(
        file("bad.ply"),
        ply("comment TextureFile four.png\n", None).replace("3 0 1 2", "3 0 1 9"),
    )
    .unwrap();
    error(&file("bad.ply"));
}

/// A color that changes smoothly.
fn smooth(p: &Point3<f64>) -> [f64; 3] {
    [
        0.5 + 0.3 * p.x.sin(),
        0.5 + 0.4 * (2.0 * p.y).cos(),
        0.5 + 0.3 * p.z,
    ]
}

/// Two quads with a seam of texture coordinates between them.
fn tent() -> Scan {
    let text = "v 0 0 0\nv 1 0 0.5\nv 2 0 0\nv 2 1 0\nv 1 1 0.5\nv 0 1 0\n\
                vt 0.0625 0.125\nvt 0.4375 0.125\nvt 0.4375 0.875\nvt 0.0625 0.875\n\
                vt 0.5625 0.125\nvt 0.9375 0.125\nvt 0.9375 0.875\nvt 0.5625 0.875\n\
                f 1/1 2/2 5/3 6/4\nf 2/5 3/6 4/7 5/8\n";
    read_from(
        text.as_bytes(),
        Format::Obj,
        "tent",
        &ReadOptions::default(),
    )
    .unwrap()
}

#[test]
fn what_is_baked_and_written_in_any_format_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let (scan, mesh) = (tent(), tent().mesh());
    let uv = scan.texture_coordinates().unwrap();
    let point = |triangle: usize, shares: [f64; 3]| {
        let corners = mesh.corners(triangle).map(|p| p.coords.into());
        Point3::from(mixed::<3>(corners, shares))
    };
    let baked = bake(128, 128, &uv, |triangle, shares| {
        smooth(&point(triangle, shares))
    });
    let mut rng = Rng::new(3, Stage::Synth, 0);
    for name in ["a.ply", "b.obj", "c.glb"] {
        let path = folder.path().join(name);
        let output = TexturedOutput::create(&path, &[]).unwrap();
        (output.write(&scan, &baked.image, &WriteOptions::default())).unwrap();
        let map = map_of(&path).unwrap();
        let mut most: f64 = 0.0;
        for _ in 0..2000 {
            let triangle = rng.index(mesh.triangles.len());
            let (s, t) = (rng.uniform(), rng.uniform());
            let (s, t) = if s + t > 1.0 {
                (1.0 - s, 1.0 - t)
            } else {
                (s, t)
            };
            let point = point(triangle, [1.0 - s - t, s, t]);
            let normal = triangle_normal(mesh.corners(triangle));
            let color = map.color(&(point + 1e-3 * normal), Some(&normal)).unwrap();
            let differences = color.iter().zip(smooth(&point)).map(|(a, b)| (a - b).abs());
            most = differences.fold(most, f64::max);
        }
        // Half a step of 8 bits, and what the pixels beyond the rim of a chart are off.
        assert!(most < 1.5 / 255.0, "{name}: {most}");
    }
}

#[test]
fn damaged_files_give_a_map_or_an_error() {
    let folder = folder();
    let obj = format!("mtllib look.mtl\n{SQUARE}usemtl a\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
    fs::write(
        folder.path().join("look.mtl"),
        "newmtl a\nmap_Kd four.png\n",
    )
    .unwrap();
    let ply = ply("comment TextureFile four.png\n", Some([0, 0]));
    let glb = {
        let path = folder.path().join("a.glb");
        let output = TexturedOutput::create(&path, &[]).unwrap();
        let image = read_image(&folder.path().join("four.png")).unwrap();
        (output.write(&tent(), &image, &WriteOptions::default())).unwrap();
        fs::read(path).unwrap()
    };
    let options = ReadOptions::default();
    for (format, bytes) in [
        (Format::Obj, obj.as_bytes()),
        (Format::Ply, ply.as_bytes()),
        (Format::Gltf, &glb),
    ] {
        let maps = std::cell::Cell::new(0);
        testing::damaged(bytes, |bytes| {
            let source = Source {
                bytes,
                name: "a",
                folder: Some(folder.path()),
                options: &options,
            };
            let painted = match format {
                Format::Obj => obj::read_painted(&source)?,
                Format::Gltf => gltf::read_painted(&source)?,
                _ => ply::read_painted(&source)?.unwrap_or_default(),
            };
            if painted.scan.check("a").is_ok()
                && let Some(map) = ColorMap::new(painted)
                && let Some(color) = map.color(&Point3::new(0.3, 0.2, 0.1), None)
            {
                assert!(color.iter().all(|c| (0.0..=1.0).contains(c)));
                maps.set(maps.get() + 1);
            }
            Ok(Scan::default().into())
        });
        assert!(maps.get() > 0, "{format}");
    }
}

#[test]
fn real_scans_show_their_images_between_vertices() {
    let data = Path::new("../shared/data/transfer");
    if !data.join("zebra.obj").exists() {
        println!("skipped: no {}", data.join("zebra.obj").display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(data.join("spot_triangulated.obj")).unwrap();
    let spot = folder.path().join("spot.obj");
    fs::write(&spot, format!("mtllib a.mtl\nusemtl a\n{text}")).unwrap();
    let png = fs::canonicalize(data.join("spot_texture.png")).unwrap();
    let materials = format!("newmtl a\nmap_Kd {}\n", png.display());
    fs::write(folder.path().join("a.mtl"), materials).unwrap();
    for (path, image) in [
        (data.join("zebra.obj"), data.join("zebra-atlas.jpg")),
        (spot, png),
    ] {
        let scan = read(&path, &ReadOptions::default()).unwrap();
        let (mesh, uv) = (scan.mesh(), scan.texture_coordinates().unwrap());
        let image = read_image(&image).unwrap();
        let map = map_of(&path).unwrap();
        let (mut sum, mut count, mut beyond) = (0.0, 0.0, 0);
        for (f, corners) in uv.iter().enumerate() {
            let shares = [0.5, 0.3, 0.2];
            let point = mixed(mesh.corners(f).map(|p| p.coords.into()), shares);
            let normal = triangle_normal(mesh.corners(f));
            let color = map.color(&Point3::from(point), Some(&normal)).unwrap();
            // The nearest pixel, looked up by other means.
            let [u, v]: [f64; 2] = mixed(*corners, shares);
            let side = |c: f64, pixels: u32| {
                let place = (c.rem_euclid(1.0) * f64::from(pixels)).floor();
                (0..pixels)
                    .find(|k| f64::from(*k) >= place)
                    .unwrap_or(pixels - 1)
            };
            let (column, row) = (side(u, image.width), side(1.0 - v, image.height));
            let pixel = image.colors[(row * image.width + column) as usize];
            for (a, b) in color.into_iter().zip(pixel) {
                sum += (a - f64::from(b)).abs() * 255.0;
                count += 1.0;
                beyond += usize::from((a - f64::from(b)).abs() * 255.0 > 64.0);
            }
        }
        let mean = sum / count;
        println!(
            "{}: mean {mean:.3}, {beyond} of {count} beyond 64, area {:.3}",
            path.display(),
            surface_area(&mesh)
        );
        assert!(mean < 4.0, "{}: {mean}", path.display());
    }
}

/// Values at a point between three corners.
fn mixed<const N: usize>(corners: [[f64; N]; 3], shares: [f64; 3]) -> [f64; N] {
    let place = SurfacePlace {
        triangle: 0,
        corners: [0, 1, 2],
        shares,
    };
    place.mixed(corners)
}
