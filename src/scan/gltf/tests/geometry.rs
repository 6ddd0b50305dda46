//! Primitives and their numbers.

use super::*;

#[test]
fn strips_and_fans_become_triangles_that_face_the_same_way() {
    for (mode, indices, expected) in [
        (4, [0_u16, 1, 2, 2, 1], vec![vec![0, 1, 2]]),
        (5, [0, 1, 2, 3, 3], vec![vec![0, 1, 2], vec![1, 3, 2]]),
        (
            6,
            [0, 1, 3, 2, 0],
            vec![vec![1, 3, 0], vec![3, 2, 0], vec![2, 0, 0]],
        ),
    ] {
        let mut document = Document::square();
        let indices = document.shorts(1, &indices);
        let primitive =
            json!({ "attributes": { "POSITION": 0 }, "indices": indices, "mode": mode });
        document.mesh(&json!([primitive]));
        let scan = document.read();
        assert_eq!(faces(&scan), expected, "{mode}");
        let mesh = scan.mesh();
        for [a, b, c] in mesh.triangles {
            let [a, b, c] = [a, b, c].map(|v| mesh.positions[v as usize]);
            assert!((b - a).cross(&(c - a)).z > 0.0, "{mode}");
        }
    }
}

#[test]
fn primitives_without_indices_take_the_vertices_in_order() {
    for (mode, count) in [(0, 0), (1, 0), (2, 0), (3, 0), (4, 1), (5, 2), (6, 2)] {
        let mut document = Document::square();
        let primitive = json!({ "attributes": { "POSITION": 0 }, "mode": mode });
        document.mesh(&json!([primitive, { "attributes": { "POSITION": 0 }, "mode": 0 }]));
        let scan = document.read();
        assert_eq!(scan.faces.len(), count, "{mode}");
        assert_eq!(scan.vertices.rows, 4, "{mode}");
    }
}

#[test]
fn indices_of_every_type_are_read() {
    for (component, bytes) in [
        (U8, vec![3_u8, 1, 0]),
        (U16, vec![3, 0, 1, 0, 0, 0]),
        (U32, vec![3, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]),
    ] {
        let mut document = Document::square();
        let view = document.view(&bytes);
        let indices = document.accessor(view, component, "SCALAR", 3);
        document.mesh(&json!([{ "attributes": { "POSITION": 0 }, "indices": indices }]));
        assert_eq!(faces(&document.read()), [[3, 1, 0]], "{component}");
    }
}

#[test]
fn sparse_accessors_replace_some_elements() {
    let mut document = Document::square();
    let places = document.view(&[1, 3]);
    let values: Vec<u8> = [5.0_f32, 6.0, 7.0, 8.0, 9.0, 10.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let values = document.view(&values);
    let sparse = json!({
        "count": 2,
        "indices": { "bufferView": places, "componentType": U8 },
        "values": { "bufferView": values },
    });
    document.json["accessors"][0]["sparse"] = sparse.clone();
    document.mesh(&json!([{ "attributes": { "POSITION": 0 }, "mode": 0 }]));
    let corners = [[0.0, 0.0, 0.0], [5.0, 6.0, 7.0], [0.0, 1.0, 0.0]];
    assert_eq!(positions(&document.read())[..3], corners);
    assert_eq!(positions(&document.read())[3], [8.0, 9.0, 10.0]);
    // Without a view the others are zero.
    document.json["accessors"][0] =
        json!({ "componentType": F32, "type": "VEC3", "count": 4, "sparse": sparse });
    assert_eq!(positions(&document.read())[1], [5.0, 6.0, 7.0]);
    assert_eq!(positions(&document.read())[2], [0.0; 3]);
    document.json["accessors"][0]["count"] = json!(3);
    assert!(document.error().contains("sparse index"));
    document.json["accessors"][0]["count"] = json!(u32::MAX);
    assert!(
        document
            .error()
            .contains("4294967295 elements without data")
    );
}

#[test]
fn interleaved_vertices_are_told_apart() {
    let mut document = Document::new();
    let rows: Vec<u8> = (0..3_u8)
        .flat_map(|k| {
            let position = [f32::from(k), 1.0, 2.0].map(f32::to_le_bytes).concat();
            let normal = [0.0_f32, 0.0, 1.0].map(f32::to_le_bytes).concat();
            [position, normal, vec![10 * k, 1, 2, 0]].concat()
        })
        .collect();
    let view = document.view(&rows);
    document.json["bufferViews"][view]["byteStride"] = json!(28);
    for (offset, component, kind) in [(0, F32, "VEC3"), (12, F32, "VEC3"), (24, U8, "VEC3")] {
        let accessor = document.accessor(view, component, kind, 3);
        document.json["accessors"][accessor]["byteOffset"] = json!(offset);
    }
    document.json["accessors"][2]["normalized"] = json!(true);
    document.mesh(&json!([{ "attributes": { "POSITION": 0, "NORMAL": 1, "COLOR_0": 2 } }]));
    let scan = document.read();
    assert_eq!(positions(&scan)[2], [2.0, 1.0, 2.0]);
    assert_eq!(normals(&scan), [[0.0, 0.0, 1.0]; 3]);
    assert_eq!(rgb(&scan), [[0, 1, 2], [10, 1, 2], [20, 1, 2]]);
    document.json["bufferViews"][view]["byteStride"] = json!(8);
    assert!(document.error().contains("12 bytes every 8 bytes"));
}

#[test]
fn quantized_positions_are_spread_by_their_node() {
    let mut document = Document::new();
    let steps = [0_u16, 65535, 0, 0, 13107, 0, 32768, 0, 0];
    document.shorts(3, &steps);
    document.mesh(&json!([{ "attributes": { "POSITION": 0 } }]));
    document.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    document.json["nodes"] = json!([{ "mesh": 0, "scale": [2, 2, 2], "translation": [1, 0, 0] }]);
    assert_eq!(positions(&document.read())[0], [1.0, 131_070.0, 0.0]);
    document.json["accessors"][0]["normalized"] = json!(true);
    let found = positions(&document.read());
    assert_eq!(found[0], [1.0, 2.0, 0.0]);
    assert!((found[1][1] - 0.4).abs() < 1e-15, "{found:?}");
    assert_eq!(faces(&document.read()), [[0, 1, 2]]);
}

#[test]
fn positions_that_no_node_moves_stay_floats() {
    let mut document = Document::square();
    document.mesh(&json!([{ "attributes": { "POSITION": 0 } }]));
    document.json["nodes"] = json!([{ "mesh": 0, "rotation": [0, 0, 0, 1], "scale": [1, 1, 1] }]);
    let scan = document.read();
    assert!(matches!(scan.vertices.column("x"), Some(Column::F32(_))));
    document.json["nodes"] = json!([{ "mesh": 0, "translation": [0.1, 0, 0] }]);
    let scan = document.read();
    assert!(matches!(scan.vertices.column("x"), Some(Column::F64(_))));
}

#[test]
fn primitives_of_a_mesh_share_vertices_only_if_they_are_the_same() {
    let mut document = Document::square();
    let first = document.shorts(1, &[0, 1, 2]);
    let second = document.shorts(1, &[2, 1, 3]);
    let moved = document.floats(3, &[5.0; 9]);
    let last = document.shorts(1, &[2, 0, 1]);
    document.mesh(&json!([
        { "attributes": { "POSITION": 0 }, "indices": first },
        { "attributes": { "POSITION": moved }, "indices": last },
        { "attributes": { "POSITION": 0 }, "indices": second },
    ]));
    let scan = document.read();
    assert_eq!(scan.vertices.rows, 7);
    assert_eq!(faces(&scan), [[0, 1, 2], [6, 4, 5], [2, 1, 3]]);
}

#[test]
fn attributes_of_the_application_become_channels_if_all_vertices_have_them() {
    let mut document = Document::square();
    let heights = document.floats(1, &[1.5, 2.5, 3.5, 4.5]);
    let classes = document.shorts(1, &[1, 2, 3, 65535]);
    document.mesh(&json!([
        { "attributes": { "POSITION": 0, "_HEIGHT": heights, "_CLASS": classes }, "mode": 0 }
    ]));
    let scan = document.read();
    let column = |name| scan.vertices.column(name).unwrap();
    assert_eq!(*column("height"), Column::F32(vec![1.5, 2.5, 3.5, 4.5]));
    assert_eq!(*column("class"), Column::U16(vec![1, 2, 3, 65535]));
    document.mesh(&json!([{ "attributes": { "POSITION": 0, "_CLASS": classes }, "mode": 0 }]));
    let scan = document.read();
    assert_eq!(scan.vertices.column("height"), None);
    assert_eq!(scan.vertices.column("class").unwrap().len(), 8);
}

#[test]
fn texture_coordinates_run_up_and_may_be_missing() {
    let mut document = Document::square();
    let places = document.floats(2, &[0.0, 0.0, 0.5, 0.25, 0.75, 1.0, 1.5, -1.0]);
    document.mesh(&json!([
        { "attributes": { "POSITION": 0 }, "mode": 5 },
        { "attributes": { "POSITION": 0, "TEXCOORD_0": places }, "mode": 5 },
        { "attributes": { "POSITION": 0 }, "material": 0, "mode": 5 }
    ]));
    let scan = document.read();
    let rows = scan.texture_coordinates().unwrap();
    assert_eq!(rows.len(), 6);
    let finite: Vec<bool> = rows
        .iter()
        .map(|row| row.as_flattened()[0].is_finite())
        .collect();
    assert_eq!(finite, [false, false, true, true, false, false]);
    assert_eq!(rows[2], [[0.0, 1.0], [0.5, 0.75], [0.75, 0.0]]);
    assert!(rows[3].contains(&[1.5, 2.0]));
}
