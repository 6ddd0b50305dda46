//! What `relievo texture` writes: the new mesh, or the texture on the old one.

use crate::repair::Repaired;
use crate::scan::{Format, Image, Scan};
use crate::texture::Textured;
use anyhow::Context;
use serde_json::{Map, Value};

use super::super::mesh_output::{Destination, MeshOutput, restored, warn_of_loss};
use super::super::outcome::Failure;
use super::Arguments;

impl Arguments {
    pub(super) fn destination(&self, format: Option<Format>) -> Destination<'_> {
        Destination {
            path: &self.output,
            format,
            own: self.input.files().collect(),
            writing: &self.writing,
            others: self.others().collect(),
            with_image: self.keep_mesh,
            image_size: self.image_size,
        }
    }

    pub(super) fn write(
        &self,
        (to, output): (&Destination, MeshOutput),
        surface: &Repaired,
        textured: &Textured,
        scale: Option<f64>,
        known: &mut Map<String, Value>,
    ) -> Result<(), Failure> {
        if !self.keep_mesh {
            output.write(textured.scan(scale), None, &to.options())?;
            return Ok(());
        }
        let scan = restored(surface);
        let mut image = None;
        if output.has_image() {
            let drawn = texture_image(to, &scan, textured, known);
            image = Some(drawn.with_context(|| self.input.name())?);
        } else {
            let texels = textured.mesh.positions.len();
            warn_of_loss(&self.input.name(), surface.scan.vertices.rows, texels);
        }
        let scan = textured.lookup().on_scan(&scan, scale);
        output.write(scan, image.as_ref(), &to.options())?;
        Ok(())
    }
}

/// The texture in an image for the mesh's texture coordinates.
fn texture_image(
    to: &Destination,
    scan: &Scan,
    textured: &Textured,
    known: &mut Map<String, Value>,
) -> anyhow::Result<Image> {
    if textured.colors.is_none() {
        anyhow::bail!("the sample has no colors for a texture image: leave out --keep-mesh");
    }
    let finest = textured.report.levels.first();
    let texel = finest.map_or(f64::INFINITY, |level| level.texel);
    let lookup = textured.lookup();
    let color = |point: &_, normal: Option<&_>| lookup.color(point, normal).unwrap_or_default();
    to.image(scan, texel, color, known)
}
