//! What faces look like: colours and images of their materials.

use super::texture::{Texture, Textures, Wrap};
use super::{Column, Scan};

/// Colour, 0 to 255, of faces of which a file says nothing: the default of all formats is white.
pub(super) const WHITE: [f64; 3] = [255.0; 3];

/// A material as it is looked up.
#[derive(Debug, Clone, Default)]
pub(super) struct Paint {
    /// Colour where there is no image: sRGB, 0 to 1.
    pub(super) diffuse: Option<[f64; 3]>,
    pub(super) pattern: Option<Pattern>,
}

/// An image on faces.
#[derive(Debug, Clone)]
pub(super) struct Pattern {
    /// Its number among the [`Textures`].
    pub(super) image: usize,
    pub(super) wrap: [Wrap; 2],
    pub(super) placement: Placement,
    /// Linear intensities that those of the image are multiplied with, if they are not all 1.
    pub(super) factor: Option<[f64; 3]>,
}

/// Rows of factors of u, v and 1: they give the place in an image, from its upper left, of a texture coordinate of
/// the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placement(pub(super) [[f64; 3]; 2]);

impl Placement {
    /// Of coordinates from the lower left, after these factors and what is then added.
    pub(super) fn upwards(scale: [f64; 2], offset: [f64; 2]) -> Self {
        Self([
            [scale[0], 0.0, offset[0]],
            [0.0, -scale[1], 1.0 - offset[1]],
        ])
    }

    pub(super) fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        (self.0).map(|[of_u, of_v, moved]| of_u * u + of_v * v + moved)
    }
}

impl Paint {
    /// The colour at a texture coordinate, 0 to 255; `None` without an image or a coordinate.
    pub(super) fn image_color(
        &self,
        coordinate: Option<[f64; 2]>,
        textures: &Textures,
    ) -> Option<[f64; 3]> {
        let pattern = self.pattern.as_ref()?;
        Some(pattern.sample(coordinate?, textures.get(pattern.image)?))
    }

    /// The colour without an image, 0 to 255.
    pub(super) fn plain_color(&self) -> [f64; 3] {
        self.diffuse.map_or(WHITE, |d| d.map(|v| v * 255.0))
    }
}

impl Pattern {
    fn sample(&self, at: [f64; 2], texture: &Texture) -> [f64; 3] {
        let color = texture.sample(self.placement.apply(at), self.wrap);
        self.factor.map_or(color, |factor| {
            [0, 1, 2].map(|k| 255.0 * to_srgb(to_linear(color[k] / 255.0) * factor[k]))
        })
    }
}

/// IEC 61966-2-1.
pub(super) fn to_srgb(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

fn to_linear(srgb: f64) -> f64 {
    if srgb <= 0.040_45 {
        srgb / 12.92
    } else {
        ((srgb + 0.055) / 1.055).powf(2.4)
    }
}

/// The faces of a scan and what each looks like.
#[derive(Debug, Default)]
pub(super) struct Painted {
    /// Vertices, faces and, unless they are below, texture coordinates. Its colours of vertices are those of
    /// faces, or parts of them, without an image; without any, the materials' are.
    pub(super) scan: Scan,
    /// Texture coordinates of the vertices as the file has them.
    pub(super) coordinates: Option<[Column; 2]>,
    /// #F: the number of each face's paint; one that is none stands for none.
    pub(super) of_faces: Vec<u32>,
    pub(super) paints: Vec<Paint>,
    pub(super) textures: Textures,
}
