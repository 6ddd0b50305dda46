//! Scans as binary glTF (GLB): one mesh with one primitive.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::{BINARY_CHUNK, JSON_CHUNK, MAGIC};
use crate::mesh::bounding_diagonal;
use crate::scan::channel::Scalar;
use crate::scan::color::{ColorLayout, full_alpha};
use crate::scan::texture_coordinates::of_vertices;
use crate::scan::{Column, Scan, Table};

/// Rounding of positions that is worth a warning, as a part of the diagonal of the scan: coarser than
/// `float` numbers around the origin give it (6e-8), and finer than scanners measure.
const WORTH_WARNING: f64 = 1e-6;

/// Writes triangles (points, if there are no faces) with positions, normals and colours; the other
/// scalar channels become attributes of the application (`completed` is `_COMPLETED`). All numbers are
/// `float`, but colours, which are 8-bit, or 16-bit where the scan's are. Texture coordinates of vertices are
/// `TEXCOORD_0` if there are faces.
///
/// With a texture image, the bytes of a PNG file, the colours of vertices are left out: they would be
/// multiplied with it (*glTF 2.0*, section 3.9.2).
pub(in crate::scan) fn write(
    scan: &Scan,
    texture: Option<&[u8]>,
    out: &mut impl Write,
) -> io::Result<()> {
    let mut file = File::default();
    let attributes = file.attributes(scan, texture.is_none());
    let mut primitive = json!({ "attributes": attributes, "mode": 0 });
    let triangles = scan.triangles();
    if !triangles.is_empty() {
        let indices: Vec<u8> = triangles
            .iter()
            .flatten()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let view = file.view(&indices, Some(34963), None);
        file.accessors.push(json!({
            "bufferView": view, "componentType": 5125, "count": triangles.len() * 3, "type": "SCALAR",
        }));
        primitive["indices"] = json!(file.accessors.len() - 1);
        primitive["mode"] = json!(4);
    }
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "relievo" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [primitive] }],
        "accessors": file.accessors,
    });
    if let Some(png) = texture {
        document["meshes"][0]["primitives"][0]["material"] = json!(0);
        document["materials"] = json!([{ "pbrMetallicRoughness": {
            "baseColorTexture": { "index": 0 }, "metallicFactor": 0, "roughnessFactor": 1,
        }}]);
        document["textures"] = json!([{ "source": 0, "sampler": 0 }]);
        // Linear between pixels and smaller images, which repeat (section 5.26).
        document["samplers"] = json!([
            { "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 },
        ]);
        let view = file.view(png, None, None);
        document["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    }
    document["bufferViews"] = json!(file.views);
    document["buffers"] = json!([{ "byteLength": file.bytes.len() }]);
    let mut json = serde_json::to_vec(&document)?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let too_large = || io::Error::other("the scan is too large for GLB, which ends at 4 GiB");
    let length = |n: usize| u32::try_from(n).map_err(|_| too_large());
    for word in [
        MAGIC,
        2,
        length(28 + json.len() + file.bytes.len())?,
        length(json.len())?,
        JSON_CHUNK,
    ] {
        out.write_all(&word.to_le_bytes())?;
    }
    out.write_all(&json)?;
    out.write_all(&length(file.bytes.len())?.to_le_bytes())?;
    out.write_all(&BINARY_CHUNK.to_le_bytes())?;
    out.write_all(&file.bytes)
}

/// The parts of the file, as they come.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    /// Adds a buffer view, which begins and ends at a multiple of four bytes.
    fn view(&mut self, bytes: &[u8], target: Option<u32>, stride: Option<usize>) -> usize {
        let mut view = json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds an accessor of `float` numbers.
    fn floats(&mut self, kind: &str, rows: usize, values: &[f32]) -> &mut Value {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(34962), None);
        self.push(json!({
            "bufferView": view, "componentType": 5126, "count": rows, "type": kind,
        }))
    }

    fn push(&mut self, accessor: Value) -> &mut Value {
        self.accessors.push(accessor);
        let last = self.accessors.len() - 1;
        &mut self.accessors[last]
    }

    /// Adds the vertices; gives the attributes of the primitive.
    fn attributes(&mut self, scan: &Scan, with_colors: bool) -> Value {
        let table = &scan.vertices;
        let mut attributes = json!({});
        let mut used = vec!["x", "y", "z"];
        let positions = rows_of(table, ["x", "y", "z"]).unwrap_or_default();
        warn_of_rounding(scan, &positions);
        let ends = |pick: fn(f32, f32) -> f32, start: f32| {
            let all = positions.chunks_exact(3);
            all.fold([start; 3], |ends, p| [0, 1, 2].map(|k| pick(ends[k], p[k])))
        };
        let (low, high) = (
            ends(f32::min, f32::INFINITY),
            ends(f32::max, f32::NEG_INFINITY),
        );
        let accessor = self.floats("VEC3", table.rows, &positions);
        accessor["min"] = json!(low);
        accessor["max"] = json!(high);
        attributes["POSITION"] = json!(self.accessors.len() - 1);
        let normals =
            rows_of(table, ["nx", "ny", "nz"]).filter(|n| n.iter().all(|v| v.is_finite()));
        if let Some(mut normals) = normals {
            used.extend(["nx", "ny", "nz"]);
            normals.chunks_exact_mut(3).for_each(to_unit);
            self.floats("VEC3", table.rows, &normals);
            attributes["NORMAL"] = json!(self.accessors.len() - 1);
        }
        if let Some(layout) = ColorLayout::of(table) {
            if with_colors {
                self.colors(scan, &layout);
                attributes["COLOR_0"] = json!(self.accessors.len() - 1);
            }
            let names = layout.channels.map(|c| table.channels[c].name.as_str());
            used.extend(names);
            used.push("alpha");
        }
        if let Some(channels) = of_vertices(table).filter(|_| !scan.faces.is_empty()) {
            used.extend(channels.map(|c| table.channels[c].name.as_str()));
            self.texture_coordinates(table, channels);
            attributes["TEXCOORD_0"] = json!(self.accessors.len() - 1);
        }
        self.others(table, &used, &mut attributes);
        attributes
    }

    /// Adds texture coordinates, whose v runs down; 0 where there are none.
    fn texture_coordinates(&mut self, table: &Table, channels: [usize; 2]) {
        let [u, v] = channels.map(|c| &table.channels[c].values);
        let value = |column: &Column, row| column.get_f64(row).unwrap_or_default();
        let rows = (0..table.rows).flat_map(|row| [value(u, row), 1.0 - value(v, row)]);
        let values: Vec<f32> = (rows.map(Scalar::rounded))
            .map(|c: f32| if c.is_finite() { c } else { 0.0 })
            .collect();
        self.floats("VEC2", table.rows, &values);
    }

    /// Adds the other channels as attributes of the application.
    fn others(&mut self, table: &Table, used: &[&str], attributes: &mut Value) {
        for channel in table
            .channels
            .iter()
            .filter(|c| !used.contains(&c.name.as_str()))
        {
            let values: Option<Vec<f32>> = (0..table.rows)
                .map(|row| channel.values.get_f64(row).map(Scalar::rounded))
                .map(|value| value.filter(|v: &f32| v.is_finite()))
                .collect();
            let key = format!("_{}", channel.name.to_uppercase());
            match values.filter(|_| attributes.get(&key).is_none()) {
                Some(values) => {
                    self.floats("SCALAR", table.rows, &values);
                    attributes[key] = json!(self.accessors.len() - 1);
                }
                None => log::warn!(
                    "channel {} has no place in GLB and is dropped",
                    channel.name
                ),
            }
        }
    }

    fn colors(&mut self, scan: &Scan, layout: &ColorLayout) {
        let table = &scan.vertices;
        let channel = |c: usize| &table.channels[c].values;
        let is_16_bit = layout
            .channels
            .iter()
            .all(|c| matches!(channel(*c), Column::U16(_)));
        let full = if is_16_bit { 65535.0 } else { 255.0 };
        let alpha = table.scalar_index("alpha").map(channel);
        let colors = scan.colors().unwrap_or_default();
        let mut bytes = Vec::new();
        for (row, color) in colors.iter().enumerate() {
            let opacity = alpha.and_then(|a| Some(a.get_f64(row)? / full_alpha(a)));
            for intensity in color.iter().copied().chain(opacity) {
                if is_16_bit {
                    <u16 as Scalar>::rounded(intensity * full).push_le(&mut bytes);
                } else {
                    <u8 as Scalar>::rounded(intensity * full).push_le(&mut bytes);
                }
            }
            // Rows begin at multiples of four bytes (section 3.6.2.4).
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        let stride = bytes.len() / table.rows.max(1);
        let view = self.view(&bytes, Some(34962), Some(stride));
        self.push(json!({
            "bufferView": view,
            "componentType": if is_16_bit { 5123 } else { 5121 },
            "normalized": true,
            "count": table.rows,
            "type": if alpha.is_some() { "VEC4" } else { "VEC3" },
        }));
    }
}

/// Three channels as `float` numbers, row by row.
fn rows_of(table: &Table, names: [&str; 3]) -> Option<Vec<f32>> {
    let columns = table.triple(names)?.map(|c| &table.channels[c].values);
    let row = |row: usize| columns.map(|c| Scalar::rounded(c.get_f64(row).unwrap_or_default()));
    Some((0..table.rows).flat_map(row).collect())
}

/// Normals have length 1 in glTF; one that has none points up.
fn to_unit(normal: &mut [f32]) {
    let length = normal
        .iter()
        .map(|v| f64::from(*v).powi(2))
        .sum::<f64>()
        .sqrt();
    if length > 0.0 {
        for v in normal.iter_mut() {
            // A normal that is of length 1 but for rounding stays as it is.
            if (length - 1.0).abs() > 1e-6 {
                *v = Scalar::rounded(f64::from(*v) / length);
            }
        }
    } else {
        normal.copy_from_slice(&[0.0, 0.0, 1.0]);
    }
}

fn warn_of_rounding(scan: &Scan, rounded: &[f32]) {
    let positions = scan.positions();
    let errors = positions.iter().zip(rounded.chunks_exact(3)).map(|(p, r)| {
        let errors = (0..3).map(|k| (p[k] - f64::from(r[k])).abs());
        errors.fold(0.0, f64::max)
    });
    let most = errors.fold(0.0, f64::max);
    if most > WORTH_WARNING * bounding_diagonal(&positions) {
        log::warn!(
            "GLB rounds coordinates to `float`, here by up to {most:.1e}; move the scan closer to the origin, or write .ply to keep them"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Rng, Stage};
    use crate::scan::{Format, ReadOptions, ScanError, read_from};

    fn scan() -> Scan {
        let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                    property float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
                    property uchar red\nproperty uchar green\nproperty uchar blue\n\
                    property float height\nelement face 2\n\
                    property list uchar int vertex_indices\nend_header\n\
                    0.1 0 0 0 0 1 255 0 51 0.5\n1 0 0 0 0 1 1 2 3 -1\n0 1 0 0 1 0 4 5 6 2\n\
                    1 1 1e-30 0 0 1 7 8 9 1e30\n3 0 1 2\n3 1 3 2\n";
        read_from(
            text.as_bytes(),
            Format::Ply,
            "a.ply",
            &ReadOptions::default(),
        )
        .unwrap()
    }

    fn glb(scan: &Scan) -> Vec<u8> {
        let mut out = Vec::new();
        write(scan, None, &mut out).unwrap();
        out
    }

    fn back(bytes: &[u8]) -> Result<Scan, ScanError> {
        read_from(bytes, Format::Gltf, "a.glb", &ReadOptions::default())
    }

    #[test]
    fn what_is_written_reads_back_the_same() {
        let mut scan = scan();
        assert_eq!(back(&glb(&scan)).unwrap().faces, scan.faces);
        assert_eq!(back(&glb(&scan)).unwrap().vertices, scan.vertices);
        for (k, name) in ["red", "green", "blue", "alpha"].into_iter().enumerate() {
            let k = u16::try_from(k).unwrap();
            let values = vec![k, 65535, 256, 1000 * k];
            scan.vertices.set_channel(name, Column::U16(values));
        }
        scan.faces = crate::mesh::Csr::default();
        let again = back(&glb(&scan)).unwrap();
        assert_eq!(again.faces.len(), 0);
        for name in ["x", "ny", "red", "alpha", "height"] {
            assert_eq!(
                again.vertices.column(name),
                scan.vertices.column(name),
                "{name}"
            );
        }
    }

    #[test]
    fn broken_files_are_scans_or_errors() {
        let good = glb(&scan());
        for length in 0..good.len() {
            assert!(back(&good[..length]).is_err(), "{length}");
        }
        let mut rng = Rng::new(1, Stage::Synth, 0);
        let mut read = 0;
        for _ in 0..20_000 {
            let mut bad = good.clone();
            for _ in 0..=rng.index(3) {
                let at = rng.index(bad.len());
                bad[at] = if rng.index(2) == 0 {
                    b"0123456789,:-[]{}\"e."[rng.index(20)]
                } else {
                    u8::try_from(rng.index(256)).unwrap()
                };
            }
            if let Ok(scan) = back(&bad) {
                assert!(scan.check("a.glb").is_ok());
                read += 1;
            }
        }
        assert!(read > 0);
    }
}
