//! What commands write that put something on a mesh: the mesh, or the mesh with a texture image.

use std::path::Path;
use std::sync::Arc;

use crate::repair::Repaired;
use crate::scan::{self, Format, Image, Scan, ScanError, TexturedOutput, WriteOptions, same_file};
use anyhow::Context;
use nalgebra::{Point3, Vector3};
use serde_json::{Map, Value, json};

use super::arguments;
use super::held::{Kept, ScanOutput, Slot, Writing, is_kept};
use super::outcome::{Failure, opened};

/// Where to, and what is asked for there.
#[derive(Debug)]
pub(super) struct Destination<'a> {
    pub(super) path: &'a Path,
    /// `None` where it is kept in memory only.
    pub(super) format: Option<Format>,
    /// The files of the mesh, which may be written over if `writing` says so.
    pub(super) own: Vec<&'a Path>,
    pub(super) writing: &'a Writing,
    /// What else is read: never written over.
    pub(super) others: Vec<&'a Path>,
    /// Whether there is to be a texture image if mesh and format have room for one.
    pub(super) with_image: bool,
    /// Largest side of the image.
    pub(super) image_size: Option<u32>,
}

/// What is written, opened before the work.
#[derive(Debug)]
pub(super) enum MeshOutput {
    Mesh(ScanOutput),
    /// With a texture image.
    Image(Box<TexturedOutput>, Option<Slot>),
}

impl MeshOutput {
    /// `name` is the mesh's in messages.
    pub(super) fn open(to: &Destination, surface: &Repaired, name: &str) -> Result<Self, Failure> {
        let path = to.path;
        let mut inputs = to.others.clone();
        if !to.writing.overwrite {
            inputs.extend(&to.own);
        }
        let holds_image = matches!(to.format, Some(Format::Ply | Format::Obj | Format::Gltf));
        let has_coordinates = || restored(surface).texture_coordinates().is_some();
        if to.with_image && path != Path::new("-") && holds_image && has_coordinates() {
            let output = TexturedOutput::create(path, &inputs)?;
            return Ok(Self::Image(Box::new(output), to.writing.slot.clone()));
        }
        if to.image_size.is_some() {
            return Err(Failure::usage(format!(
                "{name}: --image-size needs a mesh with texture coordinates, and an output of .ply, .obj or .glb"
            )));
        }
        let Some(format) = to.format else {
            return Ok(Self::Mesh(ScanOutput::new(None, to.writing)));
        };
        let output = opened("-o", path, &to.others, &[])?;
        if inputs.iter().any(|input| same_file(path, input)) {
            let name = path.display().to_string();
            return Err(ScanError::WouldOverwrite { name }.into());
        }
        Ok(Self::Mesh(ScanOutput::new(
            Some((output, format)),
            to.writing,
        )))
    }

    /// Whether there is a texture image.
    pub(super) fn has_image(&self) -> bool {
        matches!(self, Self::Image(..))
    }

    /// Writes the mesh and, if there is one, its image.
    pub(super) fn write(
        self,
        scan: Scan,
        image: Option<&Image>,
        options: &WriteOptions,
    ) -> Result<Arc<Scan>, Failure> {
        let (output, slot) = match self {
            Self::Mesh(output) => return output.write(scan),
            Self::Image(output, slot) => (output, slot),
        };
        let Some(image) = image else {
            let name = output.name().to_owned();
            return Err(anyhow::anyhow!("{name}: there is no texture image to write").into());
        };
        let scan = Arc::new(scan);
        output.write(&scan, image, options)?;
        if let Some(slot) = slot {
            slot.put(Kept::Scan(Arc::clone(&scan)));
        }
        Ok(scan)
    }
}

/// The format to write in; `None` where it is kept in memory only.
pub(super) fn output_format(path: &Path) -> Result<Option<Format>, Failure> {
    if is_kept(path) {
        return Ok(None);
    }
    arguments::output_format(path).map(Some)
}

impl Destination<'_> {
    pub(super) fn options(&self) -> WriteOptions {
        self.writing.options()
    }

    /// The colors of a surface in an image for the texture coordinates of a scan; what it holds goes into the JSON.
    pub(super) fn image(
        &self,
        scan: &Scan,
        texel: f64,
        color: impl Fn(&Point3<f64>, Option<&Vector3<f64>>) -> [f64; 3] + Sync,
        known: &mut Map<String, Value>,
    ) -> anyhow::Result<Image> {
        let baked = scan::bake_surface(scan, texel, self.image_size, color)
            .context("the mesh has no texture coordinates")?;
        let (width, height) = (baked.image.width, baked.image.height);
        known.insert(
            "image".into(),
            json!({ "width": width, "height": height, "baked": baked.report }),
        );
        Ok(baked.image)
    }
}

/// The mesh with the vertices that its faces have in its file.
pub(super) fn restored(surface: &Repaired) -> Scan {
    surface.restore(surface.scan.clone())
}

/// Says that colors at the vertices of a mesh show less than there is.
pub(super) fn warn_of_loss(name: &str, kept: usize, texels: usize) {
    if 2 * kept < texels {
        log::warn!(
            "{name}: {kept} vertices show little of a texture of {texels} texels; leave out --keep-mesh, or give the mesh texture coordinates and write .ply, .obj or .glb"
        );
    }
}
