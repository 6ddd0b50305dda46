//! A sample of texture: an image, or a scanned surface with its relief.

use nalgebra::Vector3;

use crate::base::{self, BaseChoice, FitParams};
use crate::mesh::TriMesh;
use crate::relief::{self, Relief};
use crate::scan::{Image, Scan};

use super::TextureError;
use super::canvas::texel;
use super::pyramid::Grid;

/// A height that varies by less than this share of the surface's extent is rounding.
const LEAST_RELIEF: f64 = 1e-9;

/// What is copied from.
#[derive(Debug, Clone)]
pub struct Sample {
    pub(super) channels: Channels,
    pub(super) kind: Kind,
}

/// The values of a texel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channels {
    /// Number of color values: 3, 1 for grey, or 0.
    pub(super) colors: usize,
    /// What heights are multiplied with, so that they count as much as the colors; `None` without heights. They come
    /// last.
    pub(super) height_scale: Option<f64>,
}

impl Channels {
    pub(super) fn count(&self) -> usize {
        self.colors + usize::from(self.height_scale.is_some())
    }
}

#[derive(Debug, Clone)]
pub(super) enum Kind {
    Image(Grid),
    Surface(SampleSurface),
}

/// A scan's base surface, and what is on it.
#[derive(Debug, Clone)]
pub(super) struct SampleSurface {
    /// The feet of the scan's vertices.
    pub(super) base: TriMesh,
    /// #V by C.
    pub(super) values: Vec<f32>,
    /// #V: whether the vertex has relief, and does not belong to another surface.
    pub(super) known: Vec<bool>,
    /// Length of a texel: the side of a square of a vertex's area.
    pub(super) texel: f64,
    /// The texture's first axis, as far as it is tangent.
    pub(super) axis: Vector3<f64>,
}

impl Sample {
    /// Of an image. Pixels that are more than half transparent are not copied; where all pixels are grey, one value
    /// stands for the three.
    #[must_use]
    pub fn of_image(image: &Image) -> Self {
        let colors = if image.is_grey { 1 } else { 3 };
        let values = (image.colors.iter()).flat_map(|color| color[..colors].iter().copied());
        Self {
            channels: Channels {
                colors,
                height_scale: None,
            },
            kind: Kind::Image(Grid {
                width: image.width as usize,
                height: image.height as usize,
                channels: colors,
                values: values.collect(),
                known: match &image.opaque {
                    Some(opaque) => opaque.clone(),
                    None => vec![true; image.colors.len()],
                },
            }),
        }
    }

    /// Of a scanned surface: its relief over the base surface that fits best, or over free form, and its colors.
    /// Heights and colors count the same when neighborhoods are compared. The texture's first axis is the coordinate axis
    /// that lies flattest on the surface.
    ///
    /// # Errors
    /// [`TextureError`] if the scan has no faces, no base can be found, or it is smooth and without colors.
    ///
    /// # Reference
    /// [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001), §6: displacements as textures.
    pub fn of_scan(scan: &Scan, fit: &FitParams) -> Result<Self, TextureError> {
        let (mesh, _) = scan.mesh().centered();
        if mesh.triangles.is_empty() {
            return Err(TextureError::SampleWithoutFaces);
        }
        let (relief, reach) = relief_of(&mesh, fit)?;
        let known: Vec<bool> = relief.heights.iter().map(|h| h.abs() <= reach).collect();
        let colors = scan.colors();
        let deviation = deviation(&relief.heights, &known);
        let extent = crate::mesh::bounding_diagonal(&mesh.positions);
        let has_heights = deviation > LEAST_RELIEF * extent;
        if !has_heights && colors.is_none() {
            return Err(TextureError::SampleEmpty);
        }
        let channels = Channels {
            colors: if colors.is_some() { 3 } else { 0 },
            height_scale: has_heights.then(|| {
                let of_colors = colors
                    .as_ref()
                    .map_or(1.0, |colors| color_deviation(colors, &known));
                of_colors.max(1e-3) / deviation
            }),
        };
        let base = TriMesh {
            positions: relief.feet,
            triangles: mesh.triangles,
        };
        Ok(Self {
            kind: Kind::Surface(SampleSurface {
                values: values(&channels, colors.as_deref(), &relief.heights),
                known,
                texel: texel(&base),
                axis: flattest(&base),
                base,
            }),
            channels,
        })
    }

    /// Whether the sample has heights.
    #[must_use]
    pub fn has_heights(&self) -> bool {
        self.channels.height_scale.is_some()
    }

    /// Whether the sample has colors.
    #[must_use]
    pub fn has_colors(&self) -> bool {
        self.channels.colors > 0
    }

    /// Colors of the texels that may be copied.
    #[must_use]
    pub fn colors(&self) -> Option<Vec<[f64; 3]>> {
        let (values, known) = match &self.kind {
            Kind::Image(grid) => (&grid.values, &grid.known),
            Kind::Surface(surface) => (&surface.values, &surface.known),
        };
        let all = self.colors_of(values)?;
        Some(
            all.into_iter()
                .zip(known)
                .filter(|(_, k)| **k)
                .map(|(c, _)| c)
                .collect(),
        )
    }

    /// Whether the sample is a scanned surface.
    #[must_use]
    pub fn is_surface(&self) -> bool {
        matches!(self.kind, Kind::Surface(_))
    }

    /// Where each texel (pixel or vertex, numbered as sources are) is on the sample: from −1 to 1 along its longest
    /// side, 0 in the middle. Images lie in the first two coordinates, with their top where the second is largest.
    #[must_use]
    pub fn places(&self) -> Vec<[f64; 3]> {
        let points: Vec<Vector3<f64>> = match &self.kind {
            Kind::Image(grid) => grid.mesh(1.0).positions.iter().map(|p| p.coords).collect(),
            Kind::Surface(surface) => surface.base.positions.iter().map(|p| p.coords).collect(),
        };
        let Some(first) = points.first() else {
            return Vec::new();
        };
        let low = points.iter().fold(*first, |low, p| low.inf(p));
        let high = points.iter().fold(*first, |high, p| high.sup(p));
        let (middle, reach) = ((low + high) * 0.5, (high - low).max() * 0.5);
        let place = |p: &Vector3<f64>| ((p - middle) / reach.max(f64::MIN_POSITIVE)).into();
        points.iter().map(place).collect()
    }

    /// Number of texels.
    pub(super) fn texels(&self) -> usize {
        match &self.kind {
            Kind::Image(grid) => grid.known.len(),
            Kind::Surface(surface) => surface.known.len(),
        }
    }

    /// As many levels as leave the coarsest at least 8 texels wide.
    pub(super) fn levels(&self) -> usize {
        let side = match &self.kind {
            Kind::Image(grid) => grid.width.min(grid.height),
            Kind::Surface(surface) => surface.known.len().isqrt(),
        };
        (0..).take_while(|k| side >> k >= 8).count()
    }

    /// Colors of values (n by C).
    pub(super) fn colors_of(&self, values: &[f32]) -> Option<Vec<[f64; 3]>> {
        let rows = values.chunks_exact(self.channels.count());
        match self.channels.colors {
            0 => None,
            1 => Some(rows.map(|row| [f64::from(row[0]); 3]).collect()),
            _ => Some(
                rows.map(|row| [row[0], row[1], row[2]].map(f64::from))
                    .collect(),
            ),
        }
    }

    /// Heights of values (n by C) on a mesh with texels of this length: as much larger or smaller as the texels are.
    pub(super) fn heights_of(&self, values: &[f32], texel: f64) -> Option<Vec<f64>> {
        let own = self.texel().unwrap_or(texel);
        let scale = self.channels.height_scale? * own / texel;
        let count = self.channels.count();
        let rows = values.chunks_exact(count);
        Some(rows.map(|row| f64::from(row[count - 1]) / scale).collect())
    }

    /// Length of a texel in the scan's unit, of a sample that has one.
    pub(super) fn texel(&self) -> Option<f64> {
        match &self.kind {
            Kind::Image(_) => None,
            Kind::Surface(surface) => Some(surface.texel),
        }
    }
}

fn relief_of(mesh: &TriMesh, fit: &FitParams) -> Result<(Relief, f64), TextureError> {
    if fit.base != BaseChoice::FreeForm {
        let report = base::fit(mesh, fit)?;
        if report.fits() {
            return Ok((relief::extract(mesh, &report.base), relief::reach(&report)));
        }
    }
    let (relief, _) = relief::on_free_form(mesh, None, &[])?;
    let reach = relief::reach_of(&relief.heights);
    Ok((relief, reach))
}

#[expect(clippy::cast_possible_truncation, reason = "values are single")]
fn values(channels: &Channels, colors: Option<&[[f64; 3]]>, heights: &[f64]) -> Vec<f32> {
    let mut values = Vec::with_capacity(heights.len() * channels.count());
    for (v, height) in heights.iter().enumerate() {
        if let Some(colors) = colors {
            values.extend(colors[v].map(|c| c as f32));
        }
        values.extend(channels.height_scale.map(|scale| (scale * height) as f32));
    }
    values
}

/// Standard deviation of those that count.
fn deviation(values: &[f64], counts: &[bool]) -> f64 {
    let of_those = || {
        (values.iter().zip(counts))
            .filter(|(_, c)| **c)
            .map(|(v, _)| *v)
    };
    let count = of_those().count().max(1) as f64;
    let mean = of_those().sum::<f64>() / count;
    (of_those().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// Root of the summed variances of the three colors.
fn color_deviation(colors: &[[f64; 3]], counts: &[bool]) -> f64 {
    let of_channel = |k: usize| {
        let values: Vec<f64> = colors.iter().map(|c| c[k]).collect();
        deviation(&values, counts).powi(2)
    };
    (of_channel(0) + of_channel(1) + of_channel(2)).sqrt()
}

/// The coordinate axis that is tangent to most of a surface, by area.
fn flattest(mesh: &TriMesh) -> Vector3<f64> {
    let mut upright = Vector3::zeros();
    for f in 0..mesh.triangles.len() {
        let normal = crate::mesh::triangle_normal(mesh.corners(f));
        let length = normal.norm();
        if length > 0.0 {
            upright += normal.component_mul(&normal) / length;
        }
    }
    let mut axis = Vector3::zeros();
    axis[upright.imin()] = 1.0;
    axis
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(is_grey: bool, opaque: Option<Vec<bool>>) -> Image {
        let color = |i: u8| match (f32::from(i) / 12.0, is_grey) {
            (value, true) => [value; 3],
            (value, false) => [value, 1.0 - value, 0.25],
        };
        Image {
            width: 4,
            height: 3,
            colors: (0..12).map(color).collect(),
            opaque,
            is_grey,
            bits: 16,
        }
    }

    fn grid(sample: &Sample) -> &Grid {
        match &sample.kind {
            Kind::Image(grid) => grid,
            Kind::Surface(_) => panic!("it is an image"),
        }
    }

    #[test]
    fn grey_images_have_one_value_a_texel() {
        let sample = Sample::of_image(&image(true, None));
        assert_eq!(
            (sample.channels.count(), grid(&sample).values.len()),
            (1, 12)
        );
        assert!(sample.has_colors() && !sample.has_heights());
        assert_eq!((sample.texels(), sample.texel()), (12, None));
        let colors = sample.colors().unwrap();
        assert_eq!(colors.len(), 12);
        for (i, [r, g, b]) in (0u8..).zip(colors) {
            assert!(r.to_bits() == g.to_bits() && g.to_bits() == b.to_bits());
            assert!((r - f64::from(i) / 12.0).abs() < 1e-6);
        }
    }

    #[test]
    fn colored_images_have_three() {
        let sample = Sample::of_image(&image(false, None));
        let grid = grid(&sample);
        assert_eq!((grid.channels, grid.width, grid.height), (3, 4, 3));
        assert_eq!(grid.values.len(), 36);
        assert!(grid.known.iter().all(|known| *known));
        let colors = sample.colors_of(&grid.values).unwrap();
        for (color, expected) in colors.iter().zip(&image(false, None).colors) {
            assert!((0..3).all(|k| (color[k] - f64::from(expected[k])).abs() < 1e-12));
        }
        assert_eq!(sample.heights_of(&grid.values, 1.0), None);
    }

    #[test]
    fn transparent_pixels_are_not_copied() {
        let opaque: Vec<bool> = (0..12).map(|i| i % 5 != 0).collect();
        let sample = Sample::of_image(&image(false, Some(opaque.clone())));
        assert_eq!(grid(&sample).known, opaque);
        let expected: Vec<f64> = (0..12u8)
            .filter(|i| i % 5 != 0)
            .map(|i| f64::from(f32::from(i) / 12.0))
            .collect();
        let reds: Vec<f64> = sample.colors().unwrap().iter().map(|c| c[0]).collect();
        approx::assert_abs_diff_eq!(reds[..], expected[..], epsilon = 1e-9);
    }

    #[test]
    fn flat_surfaces_without_colors_are_no_samples() {
        let mut scan = Scan::default();
        let xyz: [[f64; 4]; 3] = [[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0], [0.0; 4]];
        for (name, values) in ["x", "y", "z"].into_iter().zip(xyz) {
            scan.vertices
                .set_channel(name, crate::scan::Column::F64(values.to_vec()));
        }
        scan.vertices.rows = 4;
        let fit = FitParams::default();
        let error = Sample::of_scan(&scan, &fit).unwrap_err();
        assert!(matches!(error, TextureError::SampleWithoutFaces), "{error}");
        scan.faces.push_row(&[0, 1, 2]);
        scan.faces.push_row(&[0, 2, 3]);
        let error = Sample::of_scan(&scan, &fit).unwrap_err();
        assert!(matches!(error, TextureError::SampleEmpty), "{error}");
        for name in ["red", "green", "blue"] {
            scan.vertices
                .set_channel(name, crate::scan::Column::U8(vec![51, 102, 0, 255]));
        }
        let sample = Sample::of_scan(&scan, &fit).unwrap();
        assert!(sample.has_colors() && !sample.has_heights());
        assert!(
            (sample.texel().unwrap() - 1.0).abs() < 1e-9,
            "a square of two triangles"
        );
    }
}
