//! Colours of glTF primitives: of vertices, of textures, of materials.

use super::accessor::{self, Component, Numbers};
use super::buffers::{self, Buffers};
use super::json::{Document, Material, Primitive, TextureInfo, TextureTransform};
use crate::scan::channel::Scalar;
use crate::scan::source::Source;
use crate::scan::texture::{Textures, Wrap};
use crate::scan::{Column, Table};

/// Colours in the making, in the order of the vertices.
pub(super) struct Colors<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    source: &'a Source<'a>,
    textures: Textures,
    /// Red, green, blue and alpha, 0 to 1.
    values: Vec<[f64; 4]>,
    /// The widest type among those of `COLOR_0`.
    component: Component,
    /// Whether some vertices have colours of their own, or of an image.
    colored: bool,
    /// Whether all have an alpha of their own.
    alpha: bool,
    /// The colour of the first primitive that has one of its material only.
    factor: Option<[u64; 3]>,
}

impl<'a> Colors<'a> {
    pub(super) fn new(
        document: &'a Document,
        buffers: &'a Buffers<'a>,
        source: &'a Source<'a>,
    ) -> Self {
        Self {
            document,
            buffers,
            source,
            textures: Textures::default(),
            values: Vec::new(),
            component: Component::U8,
            colored: false,
            alpha: true,
            factor: None,
        }
    }

    /// The material, if the colours of a primitive's vertices depend on it.
    pub(super) fn look(&self, primitive: &Primitive) -> Option<usize> {
        let colored = primitive.attributes.contains_key("COLOR_0");
        primitive.material.filter(|_| !colored)
    }

    /// Takes the values of `COLOR_0`.
    pub(super) fn keep(&mut self, numbers: &Numbers) {
        let wider = match numbers.component {
            Component::U8 => self.component,
            Component::U16 if self.component != Component::F32 => Component::U16,
            _ => Component::F32,
        };
        self.component = wider;
        self.colored = true;
        self.alpha &= numbers.width == 4;
        // Integers that are not marked as normalized still are (section 3.7.2.1).
        let over = numbers.component != Component::F32 && numbers.values.iter().any(|v| *v > 1.0);
        let full = if over { numbers.component.full() } else { 1.0 };
        let rows = numbers.values.chunks_exact(numbers.width);
        self.values.extend(rows.map(|row| {
            let alpha = row.get(3).copied().unwrap_or(full);
            [row[0], row[1], row[2], alpha].map(|v| v / full)
        }));
    }

    /// Gives vertices colours of the primitive's material if they have none of their own.
    pub(super) fn paint(&mut self, primitive: &Primitive, count: usize) -> Result<(), String> {
        if primitive.attributes.contains_key("COLOR_0") {
            return Ok(());
        }
        self.alpha = false;
        let document = self.document;
        let material = primitive.material.and_then(|m| document.materials.get(m));
        let pbr = material.map(|m: &Material| &m.pbr_metallic_roughness);
        let factor = pbr.and_then(|p| p.base_color_factor).unwrap_or([1.0; 4]);
        let factor = [factor[0], factor[1], factor[2]];
        let texture = pbr.and_then(|p| p.base_color_texture.as_ref());
        if let Some(info) = texture {
            let moved = info.extensions.transform;
            let set = moved.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
            let name = format!("TEXCOORD_{set}");
            let coordinates = primitive.attributes.get(&name);
            let image = coordinates.and_then(|_| self.image(info));
            if let (Some((image, wrap)), Some(accessor)) = (image, coordinates) {
                let accessors = &document.accessors;
                let numbers = accessor::read(accessors, *accessor, self.buffers)?;
                let moved = moved.unwrap_or_default();
                self.sample(&numbers, moved, (image, wrap), factor);
                return Ok(());
            }
        }
        let color = factor.map(to_srgb);
        let bits = color.map(f64::to_bits);
        // One colour for everything tells nothing about the surface.
        self.colored |= self.factor.is_some_and(|known| known != bits);
        self.factor = Some(bits);
        let [r, g, b] = color;
        self.values
            .extend(std::iter::repeat_n([r, g, b, 1.0], count));
        Ok(())
    }

    fn sample(
        &mut self,
        numbers: &Numbers,
        moved: TextureTransform,
        (image, wrap): (usize, [Wrap; 2]),
        factor: [f64; 3],
    ) {
        let Some(texture) = self.textures.get(image) else {
            return;
        };
        self.colored = true;
        let is_white = factor.iter().all(|f| *f >= 1.0);
        for at in numbers.values.chunks_exact(2) {
            let at = moved.apply([at[0], at[1]]);
            let sample = texture.sample(at, wrap).map(|v| v / 255.0);
            let [r, g, b] = if is_white {
                sample
            } else {
                [0, 1, 2].map(|k| to_srgb(to_linear(sample[k]) * factor[k]))
            };
            self.values.push([r, g, b, 1.0]);
        }
    }

    /// The number of a texture's image, and how it goes on beyond its borders.
    fn image(&mut self, info: &TextureInfo) -> Option<(usize, [Wrap; 2])> {
        let (document, buffers, source) = (self.document, self.buffers, self.source);
        let texture = document.textures.get(info.index)?;
        let Some(number) = texture.source else {
            // Loaded in vain, so that the warning comes only once.
            let label = format!("of texture {}", info.index);
            let none = || Err("it has no image in PNG or JPEG".to_owned());
            self.textures.load(&label, source.name, none);
            return None;
        };
        let image = document.images.get(number)?;
        let bytes = || match (&image.uri, image.buffer_view) {
            (Some(uri), _) => buffers::resolve(uri, source),
            (None, Some(view)) => Ok(buffers.view(view)?.0.to_vec()),
            (None, None) => Err("it has no bytes".to_owned()),
        };
        let label = match &image.uri {
            Some(uri) if !uri.starts_with("data:") => uri.clone(),
            _ => format!("number {number}"),
        };
        let image = self.textures.load(&label, source.name, bytes)?;
        let sampler = texture.sampler.and_then(|s| document.samplers.get(s));
        // Section 5.26.
        let wrap = |code: Option<u32>| match code {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let wrap = sampler.map_or([Wrap::Repeat; 2], |s| [wrap(s.wrap_s), wrap(s.wrap_t)]);
        Some((image, wrap))
    }

    /// Adds the channels to a table.
    pub(super) fn finish(self, table: &mut Table, name: &str) {
        if !self.colored {
            return;
        }
        if self.values.len() != table.rows {
            log::warn!("{name}: colours dropped, since not all vertices have one");
            return;
        }
        let channels = ["red", "green", "blue", "alpha"];
        let width = if self.alpha { 4 } else { 3 };
        for (k, channel) in channels.into_iter().enumerate().take(width) {
            let values = self.values.iter().map(|v| v[k]);
            let column = match self.component {
                Component::U8 => Column::U8(values.map(|v| Scalar::rounded(v * 255.0)).collect()),
                Component::U16 => {
                    Column::U16(values.map(|v| Scalar::rounded(v * 65535.0)).collect())
                }
                _ => Column::F32(values.map(Scalar::rounded).collect()),
            };
            table.set_channel(channel, column);
        }
    }
}

/// IEC 61966-2-1.
fn to_srgb(linear: f64) -> f64 {
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
