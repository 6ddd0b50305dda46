//! glTF 2.0, as text (`.gltf`) and binary (`.glb`).
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, version 2.0.1.

mod accessor;
mod buffers;
mod colors;
mod json;
mod looks;
mod nodes;
mod primitive;
mod write;

use super::paint::Painted;
use super::source::Source;
use super::{Scan, ScanError};
use buffers::{Buffers, is_compression};
use json::Document;
use nodes::Placed;
use primitive::Builder;

pub(super) use self::write::write;

/// First bytes of a binary file, and the kinds of its chunks (section 4.4).
pub(super) const MAGIC: u32 = u32::from_le_bytes(*b"glTF");
pub(super) const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
pub(super) const BINARY_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// Extensions that can be required of a reader without changing what is read here.
const HARMLESS: [&str; 4] = [
    "KHR_mesh_quantization",
    "KHR_materials_",
    "KHR_lights_",
    "KHR_texture_transform",
];

/// Reads all meshes of the default scene, each placed by its nodes.
///
/// Positions are `float` if no node moves them, and else `double`. `COLOR_0` keeps its type and its
/// values (which are linear intensities by the specification, though many programs write sRGB); where
/// it is missing, textures and factors of materials become `uchar` colours in sRGB. `TEXCOORD_0` becomes the
/// channels `s` and `t`, from the lower left of the image.
pub(super) fn read(source: &Source) -> Result<Scan, ScanError> {
    build(source, false)
        .map(|painted| painted.scan)
        .map_err(|reason| malformed(source, reason))
}

/// Reads a file with the materials of its faces. Vertices are not shared by primitives of different materials here.
pub(super) fn read_painted(source: &Source) -> Result<Painted, ScanError> {
    build(source, true).map_err(|reason| malformed(source, reason))
}

fn malformed(source: &Source, reason: String) -> ScanError {
    ScanError::Malformed {
        name: source.name.to_owned(),
        reason,
    }
}

/// What the faces look like is there if it is asked for.
fn build(source: &Source, with_faces: bool) -> Result<Painted, String> {
    let (json, binary) = if source.bytes.starts_with(b"glTF") {
        chunks(source.bytes)?
    } else {
        (source.bytes, None)
    };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let json = json.trim_ascii_end();
    let document: Document =
        serde_json::from_slice(json).map_err(|error| format!("its JSON is wrong ({error})"))?;
    for extension in &document.extensions_required {
        if is_compression(extension) {
            return Err(buffers::compressed(extension));
        }
        if !HARMLESS.iter().any(|known| extension.starts_with(known)) {
            let name: String = extension.chars().take(40).collect();
            log::warn!("{}: needs {name}, which relievo passes over", source.name);
        }
    }
    let loaded = buffers::load(&document, source)?;
    let buffers = Buffers::new(&document, binary, &loaded)?;
    let mut builder = Builder::new(&document, &buffers, source, with_faces);
    for Placed { mesh, transform } in nodes::meshes(&document)? {
        let missing = || format!("there is no mesh {mesh}");
        let primitives = &document.meshes.get(mesh).ok_or_else(missing)?.primitives;
        builder
            .mesh(primitives, &transform)
            .map_err(|reason| format!("mesh {mesh}: {reason}"))?;
    }
    Ok(builder.finish())
}

/// The JSON and the binary chunk of a GLB file.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| {
        let word = bytes.get(at..)?.first_chunk::<4>()?;
        usize::try_from(u32::from_le_bytes(*word)).ok()
    };
    let chunk = |at: usize, kind: u32| {
        let length = word(at)?;
        let is_kind = word(at.checked_add(4)?)? == usize::try_from(kind).ok()?;
        let start = at.checked_add(8)?;
        let content = bytes.get(start..start.checked_add(length)?);
        content.filter(|_| is_kind)
    };
    if let Some(version) = word(4).filter(|version| *version != 2) {
        return Err(format!("it is glTF {version}, and relievo reads glTF 2"));
    }
    let json = chunk(12, JSON_CHUNK).ok_or("it is cut off within its JSON")?;
    let behind = 20 + json.len();
    let binary = chunk(behind, BINARY_CHUNK);
    if binary.is_none() && word(behind + 4) == usize::try_from(BINARY_CHUNK).ok() {
        return Err("it is cut off within its binary chunk".to_owned());
    }
    Ok((json, binary))
}

#[cfg(test)]
mod tests;
