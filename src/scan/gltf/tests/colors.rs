//! Colours of vertices, textures and materials.

use std::io::Cursor;

use image::{ImageFormat, Rgb, RgbImage};

use super::*;
use crate::scan::ColorMap;
use crate::scan::gltf::json::TextureTransform;

const RED: [u8; 3] = [200, 0, 0];
const GREEN: [u8; 3] = [0, 150, 0];
const BLUE: [u8; 3] = [0, 0, 100];
const WHITE: [u8; 3] = [255, 255, 255];

/// An image of two by two pixels: red and green above blue and white.
fn png() -> Vec<u8> {
    let image = RgbImage::from_fn(2, 2, |x, y| match (x, y) {
        (0, 0) => Rgb(RED),
        (1, 0) => Rgb(GREEN),
        (0, _) => Rgb(BLUE),
        _ => Rgb(WHITE),
    });
    let mut out = Cursor::new(Vec::new());
    image.write_to(&mut out, ImageFormat::Png).unwrap();
    out.into_inner()
}

/// A square whose vertices are at the centres of the image's pixels, row by row, and above them in
/// the order red, green, blue, white.
fn textured(image: &Value) -> Document {
    let mut document = Document::square();
    let places = [0.25, 0.25, 0.75, 0.25, 0.25, 0.75, 0.75, 0.75];
    let places = document.floats(2, &places);
    document.mesh(&json!([
        { "attributes": { "POSITION": 0, "TEXCOORD_0": places }, "material": 0, "mode": 5 }
    ]));
    document.json["materials"] =
        json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    document.json["textures"] = json!([{ "source": 0 }]);
    document.json["images"] = json!([image]);
    document
}

fn embedded() -> Document {
    let mut document = textured(&json!({ "bufferView": 2, "mimeType": "image/png" }));
    assert_eq!(document.view(&png()), 2);
    document
}

/// RFC 4648, section 4, without padding.
fn base64(bytes: &[u8]) -> String {
    const SYMBOLS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let bits = (0..3).fold(0_usize, |bits, k| {
            (bits << 8) | usize::from(three.get(k).copied().unwrap_or_default())
        });
        for k in 0..=three.len() {
            text.push(char::from(SYMBOLS[(bits >> (18 - 6 * k)) & 63]));
        }
    }
    text
}

#[test]
fn textures_color_the_vertices() {
    let colors = [RED, GREEN, BLUE, WHITE];
    assert_eq!(rgb(&embedded().read()), colors);
    let uri = format!("data:image/png;base64,{}", base64(&png()));
    assert_eq!(rgb(&textured(&json!({ "uri": uri })).read()), colors);
    // Beside the document.
    let mut document = textured(&json!({ "uri": "Wood.png" }));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.glb");
    std::fs::write(folder.path().join("Wood.png"), png()).unwrap();
    std::fs::write(&path, document.glb()).unwrap();
    let scan = crate::scan::read(&path, &ReadOptions::default()).unwrap();
    assert_eq!(rgb(&scan), colors);
    // An image that is not there, or none, costs the colours and no more.
    assert_eq!(document.read().vertices.column("red"), None);
    document.json["textures"] = json!([{}]);
    assert_eq!(document.read().vertices.column("red"), None);
    document.json["textures"] = json!([]);
    assert_eq!(document.read().faces.len(), 2);
}

#[test]
fn factors_of_materials_dim_textures_in_linear_light() {
    let mut document = embedded();
    document.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] =
        json!([0.5, 1, 0, 1]);
    // Half the light of 200 and of 255 (IEC 61966-2-1).
    let expected = [[146, 0, 0], GREEN, [0, 0, 0], [188, 255, 0]];
    assert_eq!(rgb(&document.read()), expected);
}

#[test]
fn texture_coordinates_go_on_as_the_sampler_says() {
    let mut document = embedded();
    let beyond = document.floats(2, &[1.25, 0.25, -0.25, 0.25, 0.25, 1.75, 0.75, 3.75]);
    document.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(beyond);
    assert_eq!(rgb(&document.read()), [RED, GREEN, BLUE, WHITE]);
    document.json["textures"][0]["sampler"] = json!(0);
    document.json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33648 }]);
    assert_eq!(rgb(&document.read()), [GREEN, RED, RED, GREEN]);
}

#[test]
fn texture_transforms_move_the_coordinates() {
    let quarter = std::f64::consts::FRAC_PI_2;
    for (transform, expected) in [
        (json!({ "offset": [0.5, 0] }), [GREEN, RED, WHITE, BLUE]),
        (
            json!({ "offset": [0, 1], "scale": [1, -1] }),
            [BLUE, WHITE, RED, GREEN],
        ),
        // Counterclockwise as one sees the image: what was read at the right is read at the top.
        (
            json!({ "rotation": quarter, "offset": [0, 1] }),
            [BLUE, RED, WHITE, GREEN],
        ),
        (json!({ "texCoord": 1 }), [WHITE; 4]),
        (json!({}), [RED, GREEN, BLUE, WHITE]),
    ] {
        let mut document = embedded();
        let other = document.floats(2, &[0.75; 8]);
        document.json["extensionsRequired"] = json!(["KHR_texture_transform"]);
        document.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(other);
        document.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
            json!({ "KHR_texture_transform": transform });
        assert_eq!(rgb(&document.read()), expected, "{transform}");
    }
}

#[test]
fn a_texture_transform_keeps_to_the_part_that_its_example_tells() {
    // The example of the extension: the lower left quarter of the image.
    let transform =
        json!({ "offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5] });
    let transform: TextureTransform = serde_json::from_value(transform).unwrap();
    for at in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
        let [u, v] = transform.placement().apply(at);
        assert!((-1e-12..=0.5 + 1e-12).contains(&u), "{u}");
        assert!((0.5 - 1e-12..=1.0 + 1e-12).contains(&v), "{v}");
    }
}

#[test]
fn colors_of_vertices_keep_their_type_and_go_before_textures() {
    let mut document = embedded();
    let colors = document.shorts(4, &[1, 2, 3, 65535].repeat(4));
    document.json["accessors"][colors]["normalized"] = json!(true);
    document.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    let scan = document.read();
    let column = |name| scan.vertices.column(name);
    assert_eq!(column("blue"), Some(&Column::U16(vec![3; 4])));
    assert_eq!(column("alpha"), Some(&Column::U16(vec![65535; 4])));
    // Integers that are not marked as fractions are fractions all the same.
    document.json["accessors"][colors]["normalized"] = json!(false);
    assert_eq!(document.read().vertices, scan.vertices);
    let colors = document.floats(3, &[0.0, 0.25, 1.5].repeat(4));
    document.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    let scan = document.read();
    let green = Column::F32(vec![0.25; 4]);
    assert_eq!(scan.vertices.column("green"), Some(&green));
    assert_eq!(scan.vertices.column("alpha"), None);
}

#[test]
fn several_materials_color_their_vertices_and_one_alone_does_not() {
    let mut document = Document::square();
    let indices = document.shorts(1, &[0, 1, 2]);
    let primitive = |material| json!({ "attributes": { "POSITION": 0 }, "indices": indices, "material": material });
    let factor = |rgba| json!({ "pbrMetallicRoughness": { "baseColorFactor": rgba } });
    document.json["materials"] =
        json!([factor([1.0, 0.0, 0.5, 1.0]), factor([0.0, 1.0, 0.0, 0.5])]);
    document.mesh(&json!([primitive(0), primitive(0)]));
    let scan = document.read();
    assert_eq!((scan.vertices.rows, scan.faces.len()), (4, 2));
    assert_eq!(scan.vertices.column("red"), None);
    document.mesh(&json!([primitive(1)]));
    let scan = document.read();
    assert_eq!(scan.vertices.rows, 8);
    assert_eq!(rgb(&scan)[3..5], [[255, 0, 188], [0, 255, 0]]);
}

#[test]
fn damaged_textures_are_scans_or_errors() {
    let options = ReadOptions::default();
    let read = |bytes: &[u8]| super::super::read(&source(bytes, &options)).map(Into::into);
    let good = embedded().glb();
    truncated(&good, read);
    damaged(&good, read);
}

#[test]
fn images_show_between_vertices_whatever_color_these_have() {
    let mut document = embedded();
    let green = document.floats(3, &[0.0, 1.0, 0.0].repeat(4));
    let other = document.floats(2, &[0.75; 8]);
    let [low, high] = [[0, 1, 2], [1, 3, 2]].map(|corners| document.shorts(1, &corners));
    // Vertices that the primitives share, and two materials.
    let attributes =
        json!({ "POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": other, "COLOR_0": green });
    document.json["meshes"][0]["primitives"] = json!([
        { "attributes": attributes, "indices": low, "material": 0 },
        { "attributes": attributes, "indices": high, "material": 1 },
    ]);
    document.push(
        "materials",
        json!({ "pbrMetallicRoughness": {
            "baseColorTexture": { "index": 0, "texCoord": 1 }, "baseColorFactor": [0.5, 1, 0, 1],
        }}),
    );
    document.mesh(&json!([{ "attributes": { "POSITION": 0, "COLOR_0": green }, "mode": 5 }]));
    document.mesh(&json!([{ "attributes": { "POSITION": 0 }, "mode": 5 }]));
    document.json["nodes"] = json!([
        { "mesh": 0 },
        { "mesh": 1, "translation": [5, 0, 0] },
        { "mesh": 2, "translation": [9, 0, 0] },
    ]);
    let (bytes, options) = (document.glb(), ReadOptions::default());
    let painted = crate::scan::gltf::read_painted(&source(&bytes, &options)).unwrap();
    let map = ColorMap::new(painted).unwrap();
    let at = |x: f64, y: f64| {
        let color = map.color(&nalgebra::Point3::new(x, y, 0.0), None).unwrap();
        color.map(|intensity| (intensity * 255.0).round())
    };
    assert_eq!(at(0.0, 0.0), RED.map(f64::from));
    assert_eq!(at(0.5, 0.0), [100.0, 75.0, 0.0]);
    assert_eq!(at(0.25, 0.25), [128.0, 44.0, 35.0]);
    assert_eq!(at(0.9, 0.9), [188.0, 255.0, 0.0]);
    assert_eq!(at(5.5, 0.2), [0.0, 255.0, 0.0]);
    assert_eq!(at(9.5, 0.2), [255.0; 3]);
    // Colors of vertices are their own, as before.
    assert_eq!(document.read().colors().unwrap()[0], [0.0, 1.0, 0.0]);
}
