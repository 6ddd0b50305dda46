//! Documents made here, part by part, and read.
#![allow(clippy::float_cmp, reason = "the values are exact in binary")]

use serde_json::{Value, json};

use crate::scan::testing::{damaged, source, truncated};
use crate::scan::{Column, Format, ReadOptions, Scan, ScanError, read_from};

mod broken;
#[cfg(feature = "image")]
mod colors;
mod geometry;
mod scenes;

const U8: u32 = 5121;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// A document in the making.
struct Document {
    json: Value,
    bytes: Vec<u8>,
}

impl Document {
    fn new() -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "meshes": [], "nodes": [], "accessors": [],
            "bufferViews": [], "buffers": [],
        });
        Self {
            json,
            bytes: Vec::new(),
        }
    }

    /// Four vertices at the corners of a unit square, and nothing else: a strip of two triangles
    /// that face up.
    fn square() -> Self {
        let mut document = Self::new();
        document.floats(
            3,
            &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0],
        );
        document
    }

    /// Adds to one of the lists; gives its index.
    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = &mut self.json[list];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        self.push("bufferViews", view)
    }

    fn accessor(&mut self, view: usize, component: u32, kind: &str, count: usize) -> usize {
        let accessor = json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count,
        });
        self.push("accessors", accessor)
    }

    fn floats(&mut self, width: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][width];
        self.accessor(view, F32, kind, values.len() / width)
    }

    fn shorts(&mut self, width: usize, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][width];
        self.accessor(view, U16, kind, values.len() / width)
    }

    fn mesh(&mut self, primitives: &Value) -> usize {
        self.push("meshes", json!({ "primitives": primitives }))
    }

    fn buffer(&self) -> Value {
        json!({ "byteLength": self.bytes.len() })
    }

    /// The binary form, with its bytes as the first buffer.
    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"] == json!([]) {
            json["buffers"] = json!([self.buffer()]);
        }
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend(length(28 + text.len() + self.bytes.len()));
        glb.extend(length(text.len()));
        glb.extend(b"JSON");
        glb.extend(text);
        glb.extend(length(self.bytes.len()));
        glb.extend(b"BIN\0");
        glb.extend(&self.bytes);
        glb
    }

    fn read(&self) -> Scan {
        read(&self.glb()).unwrap()
    }

    fn error(&self) -> String {
        read(&self.glb()).unwrap_err().to_string()
    }
}

fn read(bytes: &[u8]) -> Result<Scan, ScanError> {
    read_from(bytes, Format::Gltf, "a.glb", &ReadOptions::default())
}

fn faces(scan: &Scan) -> Vec<Vec<u32>> {
    scan.faces.rows().map(<[u32]>::to_vec).collect()
}

fn positions(scan: &Scan) -> Vec<[f64; 3]> {
    scan.positions().into_iter().map(Into::into).collect()
}

fn normals(scan: &Scan) -> Vec<[f64; 3]> {
    let columns = ["nx", "ny", "nz"].map(|name| scan.vertices.column(name).unwrap());
    let row = |row: usize| columns.map(|c| c.get_f64(row).unwrap());
    (0..scan.vertices.rows).map(row).collect()
}

fn bytes_of(scan: &Scan, name: &str) -> Vec<u8> {
    match scan.vertices.column(name).unwrap() {
        Column::U8(values) => values.clone(),
        other => panic!("{name} is {other:?}"),
    }
}

/// Red, green and blue of each vertex.
fn rgb(scan: &Scan) -> Vec<[u8; 3]> {
    let [r, g, b] = ["red", "green", "blue"].map(|name| bytes_of(scan, name));
    (0..r.len()).map(|k| [r[k], g[k], b[k]]).collect()
}
