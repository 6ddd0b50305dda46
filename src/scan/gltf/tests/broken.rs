//! What is refused, and what is damaged.

use super::*;

/// Changes one part of a square of two triangles.
fn error_with(change: impl FnOnce(&mut Value)) -> String {
    let mut document = square();
    change(&mut document.json);
    document.error()
}

fn square() -> Document {
    let mut document = Document::square();
    let indices = document.shorts(1, &[0, 1, 2, 2, 1, 3]);
    document.mesh(&json!([{ "attributes": { "POSITION": 0 }, "indices": indices }]));
    document.push("nodes", json!({ "mesh": 0 }));
    document
}

#[test]
fn what_is_missing_or_too_long_is_named() {
    assert_eq!(square().read().faces.len(), 2);
    let primitive = |json: &mut Value, key: &str, value: Value| {
        json["meshes"][0]["primitives"][0][key] = value;
    };
    for (reason, error) in [
        (
            "there is no accessor 9",
            error_with(|j| primitive(j, "indices", json!(9))),
        ),
        (
            "there is no accessor 8",
            error_with(|j| {
                primitive(j, "attributes", json!({ "POSITION": 8 }));
            }),
        ),
        (
            "it has no POSITION",
            error_with(|j| primitive(j, "attributes", json!({}))),
        ),
        (
            "there is no mode 7",
            error_with(|j| primitive(j, "mode", json!(7))),
        ),
        (
            "an index exceeds its 3 vertices",
            error_with(|j| j["accessors"][0]["count"] = json!(3)),
        ),
        (
            "5 elements of 12 bytes exceed buffer view 0",
            error_with(|j| {
                j["accessors"][0]["count"] = json!(5);
            }),
        ),
        (
            "exceed buffer view 0",
            error_with(|j| j["accessors"][0]["count"] = json!(u64::MAX)),
        ),
        (
            "exceed buffer view 0",
            error_with(|j| {
                j["accessors"][0]["byteOffset"] = json!(u64::MAX);
            }),
        ),
        (
            "there is no buffer view 5",
            error_with(|j| {
                j["accessors"][0]["bufferView"] = json!(5);
            }),
        ),
    ] {
        assert!(error.contains(reason), "{reason}: {error}");
    }
}

#[test]
fn wrong_buffers_and_types_are_named() {
    for (reason, error) in [
        (
            "buffer view 0 exceeds its buffer",
            error_with(|j| {
                j["bufferViews"][0]["byteOffset"] = json!(u64::MAX);
            }),
        ),
        (
            "buffer view 0 exceeds its buffer",
            error_with(|j| {
                j["bufferViews"][0]["buffer"] = json!(1);
            }),
        ),
        (
            "buffer 0 has 60 bytes instead of 61",
            error_with(|j| {
                j["buffers"] = json!([{ "byteLength": 61 }]);
            }),
        ),
        (
            "buffer 1 has no bytes",
            error_with(|j| {
                j["buffers"] = json!([{ "byteLength": 60 }, { "byteLength": 1 }]);
            }),
        ),
        (
            "there is no type of component 5124",
            error_with(|j| {
                j["accessors"][0]["componentType"] = json!(5124);
            }),
        ),
        (
            "the type MAT4",
            error_with(|j| j["accessors"][0]["type"] = json!("MAT4")),
        ),
        (
            "2 numbers an element",
            error_with(|j| j["accessors"][0]["type"] = json!("VEC2")),
        ),
        ("its JSON is wrong", error_with(|j| j["meshes"] = json!(7))),
        (
            "holds no vertices",
            error_with(|j| j["meshes"][0]["primitives"] = json!([])),
        ),
    ] {
        assert!(error.contains(reason), "{reason}: {error}");
    }
}

#[test]
fn what_is_compressed_or_instanced_only_is_refused() {
    let draco = json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": {} } });
    for extension in [
        "KHR_draco_mesh_compression",
        "EXT_meshopt_compression",
        "KHR_meshopt_compression",
    ] {
        let error = error_with(|j| {
            j["extensionsRequired"] = json!([extension]);
            // A buffer that only the uncompressed form has bytes for.
            j["buffers"] = json!([{ "byteLength": 60 }, { "byteLength": 1000 }]);
        });
        assert!(
            error.contains(extension) && error.contains("compressed"),
            "{error}"
        );
    }
    let error = error_with(|j| {
        j["meshes"][0]["primitives"][0]["extensions"] = draco.clone();
        j["accessors"][0] = json!({ "componentType": F32, "type": "VEC3", "count": 4 });
    });
    assert!(error.contains("turn the compression off"), "{error}");
    let error = error_with(|j| {
        j["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": {} } });
    });
    assert!(error.contains("node 0 repeats its mesh"), "{error}");
    // A compression that is not required leaves the mesh as it is.
    let mut document = square();
    document.json["meshes"][0]["primitives"][0]["extensions"] = draco;
    document.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    assert_eq!(document.read().faces.len(), 2);
}

#[test]
fn positions_that_overflow_are_refused() {
    let huge = [1e308, 1e308, 1e308];
    let mut document = square();
    document.json["nodes"][0]["scale"] = json!(huge);
    assert!(document.read().check("a").is_ok());
    document.json["nodes"][0]["translation"] = json!([1e308, 1e308, 0]);
    assert!(document.error().contains("not a finite number"));
}

#[test]
fn damaged_documents_are_scans_or_errors() {
    let options = ReadOptions::default();
    let read = |bytes: &[u8]| super::super::read(&source(bytes, &options)).map(Into::into);
    let mut document = square();
    let colors = document.shorts(4, &[7; 16]);
    document.json["accessors"][colors]["normalized"] = json!(true);
    let normals = document.floats(3, &[0.0, 0.0, 1.0].repeat(4));
    let attributes = json!({ "POSITION": 0, "NORMAL": normals, "COLOR_0": colors });
    document.json["meshes"][0]["primitives"][0]["attributes"] = attributes;
    document.json["nodes"][0]["scale"] = json!([1, -2, 3]);
    let good = document.glb();
    truncated(&good, read);
    damaged(&good, read);
}
