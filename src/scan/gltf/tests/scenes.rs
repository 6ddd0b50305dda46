//! Nodes, and buffers outside of the document.

use super::*;
use crate::scan;

/// A square in the plane x + z = 0 with its normal, shown by one node.
fn slope(node: Value) -> Document {
    let mut document = Document::new();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    document.floats(3, &[0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0]);
    document.floats(3, &[half, 0.0, half].repeat(3));
    document.mesh(&json!([{ "attributes": { "POSITION": 0, "NORMAL": 1 } }]));
    document.push("nodes", node);
    document
}

/// The scan's normals, which must be those of its triangle.
fn check_normals(scan: &Scan) -> [f64; 3] {
    let mesh = scan.mesh();
    let [a, b, c] = mesh.triangles[0].map(|v| mesh.positions[v as usize]);
    let expected: [f64; 3] = (b - a).cross(&(c - a)).normalize().into();
    for normal in normals(scan) {
        for k in 0..3 {
            assert!((normal[k] - expected[k]).abs() < 1e-6, "{normal:?}");
        }
    }
    expected
}

#[test]
fn normals_stay_perpendicular_under_uneven_scales() {
    let normal = check_normals(&slope(json!({ "mesh": 0, "scale": [1, 1, 3] })).read());
    assert!((normal[0] / normal[2] - 3.0).abs() < 1e-12);
    let shear = [1, 0, 0, 0, 2, 1, 0, 0, 0, -1, 1, 0, 4, 5, 6, 1];
    check_normals(&slope(json!({ "mesh": 0, "matrix": shear })).read());
}

#[test]
fn mirrored_meshes_keep_their_outside() {
    for scale in [[-1, 1, 1], [1, -2, 3], [-1, -1, -1], [-1, -1, 2]] {
        let scan = slope(json!({ "mesh": 0, "scale": scale })).read();
        let normal = check_normals(&scan);
        // The outside is where it was, in the mirror.
        assert!(normal[2] * f64::from(scale[2]) > 0.0, "{scale:?}");
        let turned = scale.iter().product::<i32>() < 0;
        let expected = if turned { [0, 2, 1] } else { [0, 1, 2] };
        assert_eq!(faces(&scan), [expected], "{scale:?}");
    }
}

#[test]
fn a_flat_scale_still_gives_a_scan() {
    let scan = slope(json!({ "mesh": 0, "scale": [1, 1, 0] })).read();
    assert!(scan.check("a").is_ok());
    assert!(normals(&scan).iter().flatten().all(|v| v.is_finite()));
}

#[test]
fn a_mesh_of_several_nodes_is_there_several_times() {
    let mut document = slope(json!({ "mesh": 0, "children": [1, 2] }));
    document.push("nodes", json!({ "mesh": 0, "translation": [10, 0, 0] }));
    let turn = [0.0, 0.0, 0.0, 0.0];
    document.push(
        "nodes",
        json!({ "children": [3], "scale": [2, 2, 2], "rotation": turn }),
    );
    document.push("nodes", json!({ "mesh": 0, "translation": [0, 1, 0] }));
    document.push("nodes", json!({ "mesh": 0 }));
    document.json["scenes"] = json!([{ "nodes": [4] }, { "nodes": [0] }]);
    document.json["scene"] = json!(1);
    let scan = document.read();
    let found = positions(&scan);
    assert_eq!(found.len(), 9);
    assert_eq!(found[1], [1.0, 0.0, -1.0]);
    assert_eq!(found[4], [11.0, 0.0, -1.0]);
    assert_eq!(found[7], [2.0, 2.0, -2.0]);
    assert_eq!(faces(&scan)[2], [6, 7, 8]);
    document.json["scene"] = json!(2);
    assert!(document.error().contains("there is no scene 2"));
    document.json["scene"] = json!(1);
    document.json["nodes"][3]["children"] = json!([0]);
    assert!(document.error().contains("more than once"));
    document.json["nodes"][3] = json!({ "mesh": 7 });
    assert!(document.error().contains("there is no mesh 7"));
}

#[test]
fn a_scene_cannot_repeat_a_mesh_without_end() {
    // Three hundred nodes of a few bytes each would be twenty million vertices.
    let mut document = Document::new();
    let count = 1 << 16;
    document.floats(3, &vec![0.0; 3 * count]);
    document.mesh(&json!([{ "attributes": { "POSITION": 0 }, "mode": 0 }]));
    document.json["nodes"] = json!(vec![json!({ "mesh": 0 }); 300]);
    assert!(document.error().contains("too often"));
}

#[test]
fn buffers_are_found_beside_the_document_and_in_data_uris() {
    let mut document = Document::square();
    document.mesh(&json!([{ "attributes": { "POSITION": 0 } }]));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.gltf");
    std::fs::write(folder.path().join("all points.bin"), &document.bytes).unwrap();
    let mut buffer = document.buffer();
    buffer["uri"] = json!("all%20points.bin");
    document.json["buffers"] = json!([buffer]);
    std::fs::write(&path, format!("\u{feff}{}\n", document.json)).unwrap();
    let scan = scan::read(&path, &ReadOptions::default()).unwrap();
    assert_eq!(positions(&scan)[3], [1.0, 1.0, 0.0]);
    // Where the folder is unknown, nothing is looked for.
    let text = document.json.to_string();
    let error = read(text.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("all%20points.bin"), "{error}");
    std::fs::write(folder.path().join("all points.bin"), &document.bytes[..40]).unwrap();
    let error = scan::read(&path, &ReadOptions::default()).unwrap_err();
    let error = error.to_string();
    assert!(error.contains("40 bytes instead of 48"), "{error}");
    // Three vertices of zeros: 36 bytes are 48 times the letter A.
    let uri = format!("data:application/octet-stream;base64,{}", "A".repeat(48));
    document.json["accessors"][0]["count"] = json!(3);
    document.json["bufferViews"][0]["byteLength"] = json!(36);
    document.json["buffers"] = json!([{ "uri": uri, "byteLength": 36 }]);
    let scan = read(document.json.to_string().as_bytes()).unwrap();
    assert_eq!(positions(&scan), [[0.0; 3]; 3]);
}
