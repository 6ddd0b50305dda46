//! Colours between the vertices of a textured scan.

use std::path::Path;

use nalgebra::{Point3, Vector3};

use super::format::opened;
use super::paint::{Paint, Painted, WHITE};
use super::source::Source;
use super::texture::Textures;
use super::texture_coordinates::{Coordinates, is_proper};
use super::{Format, ReadOptions, ScanError, gltf, obj, ply};
use crate::mesh::{SurfaceLookup, SurfacePlace, TriMesh};

/// The colours of a textured scan at any point of its surface: finer than [`Scan::colors`](super::Scan::colors),
/// which has them at the vertices only.
#[derive(Debug)]
pub struct ColorMap {
    surface: SurfaceLookup,
    faces: Vec<Face>,
    paints: Vec<Paint>,
    textures: Textures,
    /// #V: the file's own.
    colors: Option<Vec<[f64; 3]>>,
}

/// A triangle.
#[derive(Debug)]
struct Face {
    /// Texture coordinates of the corners as the file has them, NaN without any.
    coordinates: [[f64; 2]; 3],
    /// The number of its paint, if there is one of that number.
    paint: u32,
}

/// Reads the colours between the vertices of a scan whose faces have a texture: an OBJ file with `map_Kd`, a
/// glTF file with `baseColorTexture`, or a PLY file with comments `TextureFile` (an image each, chosen by the
/// faces' `texnumber`, or the first). `None` if no face has an image with texture coordinates, or none that can be
/// read, which a warning says; and for `-`, since standard input is read only once.
///
/// # Errors
/// As [`read`](super::read()).
pub fn read_color_map(path: &Path, options: &ReadOptions) -> Result<Option<ColorMap>, ScanError> {
    if path == Path::new("-") {
        return Ok(None);
    }
    let (name, bytes, format) = opened(path)?;
    let source = Source {
        bytes: &bytes,
        name: &name,
        folder: path.parent(),
        options,
    };
    let painted = match format {
        Format::Obj => obj::read_painted(&source)?,
        Format::Gltf => gltf::read_painted(&source)?,
        Format::Ply => match ply::read_painted(&source)? {
            Some(painted) => painted,
            None => return Ok(None),
        },
        _ => return Ok(None),
    };
    painted.scan.check(&name)?;
    Ok(ColorMap::new(painted))
}

impl ColorMap {
    /// `None` if no face shows an image. The scan has passed its check.
    pub(super) fn new(painted: Painted) -> Option<Self> {
        let Painted {
            scan,
            coordinates,
            of_faces,
            paints,
            textures,
        } = painted;
        let coordinates = match &coordinates {
            Some([u, v]) => Coordinates::Vertices([u, v]),
            None => Coordinates::of(&scan)?,
        };
        let mut faces = Vec::with_capacity(scan.faces.len());
        let mut triangles = Vec::with_capacity(scan.faces.len());
        coordinates.triangles(&scan, |number, vertices, coordinates| {
            // Others are no part of the mesh.
            if is_proper(&vertices) {
                triangles.push(vertices);
                faces.push(Face {
                    coordinates,
                    paint: of_faces.get(number).copied().unwrap_or(u32::MAX),
                });
            }
        });
        let mesh = TriMesh {
            positions: scan.positions(),
            triangles,
        };
        let map = Self {
            surface: SurfaceLookup::new(&mesh),
            colors: scan.colors(),
            faces,
            paints,
            textures,
        };
        let shows = |face: &Face| map.image_color(face, face.coordinates[0]).is_some();
        map.faces.iter().any(shows).then_some(map)
    }

    /// Intensities of red, green and blue, from 0 to 1 as those of [`Scan::colors`](super::Scan::colors), at the
    /// point of the surface that is closest to `point`: of the face's image there, interpolated linearly between
    /// its pixels. Faces without an image have the colours of their vertices, if the file has any, or that of their
    /// material, or white; where they have an image, colours of vertices do not count.
    ///
    /// With a `normal` only triangles count that do not face away from it, as in [`SurfaceLookup::place`].
    /// `None` for a point that is not finite.
    #[must_use]
    pub fn color(&self, point: &Point3<f64>, normal: Option<&Vector3<f64>>) -> Option<[f64; 3]> {
        let place = self.surface.place(point, normal)?;
        let face = self.faces.get(place.triangle as usize)?;
        let color = self.image_color(face, place.mixed(face.coordinates));
        Some(color.unwrap_or_else(|| self.plain_color(face, &place)))
    }

    /// The color of a face's image at texture coordinates.
    fn image_color(&self, face: &Face, at: [f64; 2]) -> Option<[f64; 3]> {
        let is_known = face.coordinates.iter().flatten().all(|c| c.is_finite());
        let paint = self.paints.get(face.paint as usize)?;
        let color = paint.image_color(is_known.then_some(at), &self.textures)?;
        Some(color.map(|value| value / 255.0))
    }

    fn plain_color(&self, face: &Face, place: &SurfacePlace) -> [f64; 3] {
        if let Some(colors) = &self.colors {
            return place.of_vertices(colors);
        }
        let paint = self.paints.get(face.paint as usize);
        let color = paint.map_or(WHITE, Paint::plain_color);
        color.map(|value| value / 255.0)
    }
}

#[cfg(test)]
#[cfg(feature = "image")]
mod tests;
