//! What `relievo texture` writes: the new mesh, or the texture on the old one.

use std::path::Path;

use anyhow::Context;
use nalgebra::{Point3, Vector3};
use relievo::repair::Repaired;
use relievo::scan::{
    self, Format, Image, OutputFile, Scan, ScanError, TexturedOutput, WriteOptions, same_file,
};
use relievo::texture::Textured;
use serde_json::{Map, Value, json};

use super::super::outcome::{Failure, opened};
use super::Arguments;

/// What is written, opened before the work.
pub(super) enum Output {
    Mesh(OutputFile, Format),
    /// With a texture image.
    Image(Box<TexturedOutput>),
}

impl Output {
    pub(super) fn open(
        arguments: &Arguments,
        format: Format,
        surface: &Repaired,
    ) -> Result<Self, Failure> {
        let path = &arguments.output;
        let others: Vec<&Path> = arguments.others().collect();
        let mut inputs = others.clone();
        if !arguments.overwrite {
            inputs.extend(arguments.input.files());
        }
        let holds_image = matches!(format, Format::Ply | Format::Obj | Format::Gltf);
        let has_coordinates = || restored(surface).texture_coordinates().is_some();
        if arguments.keep_mesh && path != Path::new("-") && holds_image && has_coordinates() {
            let output = TexturedOutput::create(path, &inputs)?;
            return Ok(Self::Image(Box::new(output)));
        }
        if arguments.image_size.is_some() {
            return Err(Failure::usage(format!(
                "{}: --image-size needs a mesh with texture coordinates, and an output of .ply, .obj or .glb",
                arguments.input.name()
            )));
        }
        let output = opened("-o", path, &others, &[])?;
        if inputs.iter().any(|input| same_file(path, input)) {
            let name = path.display().to_string();
            return Err(ScanError::WouldOverwrite { name }.into());
        }
        Ok(Self::Mesh(output, format))
    }

    pub(super) fn write(
        self,
        arguments: &Arguments,
        surface: &Repaired,
        textured: &Textured,
        scale: Option<f64>,
        known: &mut Map<String, Value>,
    ) -> Result<(), Failure> {
        let options = WriteOptions {
            ascii: arguments.ascii,
        };
        match self {
            Self::Mesh(mut output, format) => {
                let scan = if arguments.keep_mesh {
                    warn_of_loss(arguments, surface, textured);
                    textured.lookup().on_scan(&restored(surface), scale)
                } else {
                    textured.scan(scale)
                };
                let name = output.name().to_owned();
                scan::write_to(&scan, &mut output, format, &options, &name)?;
                output.commit()?;
            }
            Self::Image(output) => {
                let scan = restored(surface);
                let image = texture_image(&scan, textured, arguments.image_size, known)
                    .with_context(|| arguments.input.name())?;
                let scan = textured.lookup().on_scan(&scan, scale);
                output.write(&scan, &image, &options)?;
            }
        }
        Ok(())
    }
}

/// The mesh with the vertices that it has in its file.
fn restored(surface: &Repaired) -> Scan {
    surface.restore(surface.scan.clone())
}

/// Colors at the vertices of a mesh cannot show more than there are.
fn warn_of_loss(arguments: &Arguments, surface: &Repaired, textured: &Textured) {
    let (kept, texels) = (surface.scan.vertices.rows, textured.mesh.positions.len());
    if 2 * kept < texels {
        log::warn!(
            "{}: {kept} vertices show little of a texture of {texels} texels; leave out --keep-mesh, or give the mesh texture coordinates and write .ply, .obj or .glb",
            arguments.input.name()
        );
    }
}

/// The texture in an image for the mesh's texture coordinates.
fn texture_image(
    scan: &Scan,
    textured: &Textured,
    side: Option<u32>,
    known: &mut Map<String, Value>,
) -> anyhow::Result<Image> {
    let uv = scan
        .texture_coordinates()
        .context("the mesh has no texture coordinates")?;
    if textured.colors.is_none() {
        anyhow::bail!("the sample has no colors for a texture image: leave out --keep-mesh");
    }
    let mesh = scan.mesh();
    let texel = textured
        .report
        .levels
        .first()
        .map_or(f64::INFINITY, |level| level.texel);
    let [width, height] = scan::image_size(&uv, &mesh, texel);
    let most = side.unwrap_or(u32::MAX).max(1);
    let [width, height] = [width, height].map(|pixels| pixels.min(most));
    let lookup = textured.lookup();
    let color = |triangle: usize, shares: [f64; 3]| {
        let corners = mesh.corners(triangle);
        let point: Vector3<f64> = corners
            .iter()
            .zip(shares)
            .map(|(p, share)| p.coords * share)
            .sum();
        let normal = relievo::mesh::triangle_normal(corners);
        let normal = Some(&normal).filter(|normal| normal.norm() > 0.0);
        lookup
            .color(&Point3::from(point), normal)
            .unwrap_or_default()
    };
    let baked = scan::bake(width, height, &uv, color);
    known.insert(
        "image".into(),
        json!({ "width": width, "height": height, "baked": baked.report }),
    );
    Ok(baked.image)
}
