//! Colours of glTF primitives: of vertices, of textures, of materials.

use super::accessor::{self, Component, Numbers};
use super::buffers::{self, Buffers};
use super::json::{Document, Material, Primitive, TextureInfo};
use super::looks::Looks;
use crate::scan::channel::Scalar;
use crate::scan::paint::{Paint, Pattern, to_srgb};
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
    /// Of the faces, if they are asked for.
    looks: Option<Looks>,
}

/// An image, and where vertices are on it.
type OnVertices = (Pattern, Vec<[f64; 2]>);

impl<'a> Colors<'a> {
    pub(super) fn new(
        document: &'a Document,
        buffers: &'a Buffers<'a>,
        source: &'a Source<'a>,
        with_faces: bool,
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
            looks: with_faces.then(Looks::default),
        }
    }

    /// The material, if the colours of a primitive's vertices depend on it, or those of its faces are asked for.
    pub(super) fn look(&self, primitive: &Primitive) -> Option<usize> {
        let colored = primitive.attributes.contains_key("COLOR_0");
        (primitive.material).filter(|_| !colored || self.looks.is_some())
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
        let has_own = primitive.attributes.contains_key("COLOR_0");
        if has_own && self.looks.is_none() {
            return Ok(());
        }
        let document = self.document;
        let material = primitive.material.and_then(|m| document.materials.get(m));
        let pbr = material.map(|m: &Material| &m.pbr_metallic_roughness);
        let factor = pbr.and_then(|p| p.base_color_factor).unwrap_or([1.0; 4]);
        let factor = [factor[0], factor[1], factor[2]];
        let paint = Paint {
            diffuse: Some(factor.map(to_srgb)),
            pattern: None,
        };
        let texture = pbr.and_then(|p| p.base_color_texture.as_ref());
        let textured = texture.map(|info| self.pattern(info, factor, primitive));
        let (pattern, places) = textured.transpose()?.flatten().unzip();
        let paint = Paint { pattern, ..paint };
        if !has_own {
            self.alpha = false;
            self.color(&paint, places.as_deref(), count);
        }
        if let Some(looks) = &mut self.looks {
            looks.push(paint, places, count);
        }
        Ok(())
    }

    /// The image of a texture, and where the vertices are on it.
    fn pattern(
        &mut self,
        info: &TextureInfo,
        factor: [f64; 3],
        primitive: &Primitive,
    ) -> Result<Option<OnVertices>, String> {
        let moved = info.extensions.transform.unwrap_or_default();
        let set = moved.tex_coord.unwrap_or(info.tex_coord);
        let name = format!("TEXCOORD_{set}");
        let Some(accessor) = primitive.attributes.get(&name) else {
            return Ok(None);
        };
        let Some((image, wrap)) = self.image(info) else {
            return Ok(None);
        };
        let numbers = accessor::read(&self.document.accessors, *accessor, self.buffers)?;
        let pattern = Pattern {
            image,
            wrap,
            placement: moved.placement(),
            factor: Some(factor).filter(|factor| factor.iter().any(|f| *f < 1.0)),
        };
        let places = numbers.values.chunks_exact(2).map(|at| [at[0], at[1]]);
        Ok(Some((pattern, places.collect())))
    }

    /// Adds colours of vertices.
    fn color(&mut self, paint: &Paint, places: Option<&[[f64; 2]]>, count: usize) {
        if let Some(places) = places {
            self.colored = true;
            for place in places {
                let color = paint.image_color(Some(*place), &self.textures);
                let [r, g, b] = color.unwrap_or_default().map(|value| value / 255.0);
                self.values.push([r, g, b, 1.0]);
            }
            return;
        }
        let [r, g, b] = paint.diffuse.unwrap_or([1.0; 3]);
        let bits = [r, g, b].map(f64::to_bits);
        // One colour for everything tells nothing about the surface.
        self.colored |= self.factor.is_some_and(|known| known != bits);
        self.factor = Some(bits);
        self.values
            .extend(std::iter::repeat_n([r, g, b, 1.0], count));
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

    /// Adds the channels to a table; gives what the faces look like.
    pub(super) fn finish(mut self, table: &mut Table, name: &str) -> Looks {
        let mut looks = self.looks.take().unwrap_or_default();
        looks.textures = std::mem::take(&mut self.textures);
        self.add_channels(table, name);
        looks
    }

    fn add_channels(self, table: &mut Table, name: &str) {
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
