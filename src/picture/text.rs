//! Words on a picture, in Noto Sans Mono.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::canvas::Raster;

/// What is written for a character that the font does not have.
const UNKNOWN: char = '?';

/// A size of type.
#[derive(Debug, Clone, Copy)]
pub(super) struct Type {
    raster: RasterHeight,
    /// Pixels of the picture a pixel of the font.
    scale: u32,
}

impl Type {
    /// The size nearest to one line in 45 of a picture of this height, from 16 pixels on.
    pub(super) fn for_picture(height: u32) -> Self {
        let wanted = height / 45;
        let (raster, scale) = match wanted {
            0..18 => (RasterHeight::Size16, 1),
            18..22 => (RasterHeight::Size20, 1),
            22..28 => (RasterHeight::Size24, 1),
            _ => (RasterHeight::Size32, (wanted / 32).max(1)),
        };
        Self { raster, scale }
    }

    /// Height of a line in pixels.
    pub(super) fn height(&self) -> u32 {
        u32::try_from(self.raster.val()).unwrap_or(0) * self.scale
    }

    /// Width of a text in pixels.
    pub(super) fn width(&self, text: &str) -> u32 {
        let character = get_raster_width(FontWeight::Regular, self.raster);
        let width = character * text.chars().count();
        u32::try_from(width).unwrap_or(u32::MAX / 64) * self.scale
    }

    /// Writes a text, its left upper corner at a pixel.
    pub(super) fn write(
        &self,
        raster: &mut Raster,
        text: &str,
        left: u32,
        top: u32,
        color: [u8; 3],
    ) {
        let mut x = left;
        for character in text.chars() {
            let glyph = |c| get_raster(c, FontWeight::Regular, self.raster);
            let Some(glyph) = glyph(character).or_else(|| glyph(UNKNOWN)) else {
                continue;
            };
            let mut y = top;
            for row in glyph.rows() {
                let mut column = x;
                for value in row {
                    self.dot(raster, column, y, color, f64::from(*value) / 255.0);
                    column += self.scale;
                }
                y += self.scale;
            }
            x += u32::try_from(glyph.width()).unwrap_or(0) * self.scale;
        }
    }

    fn dot(&self, raster: &mut Raster, left: u32, top: u32, color: [u8; 3], opacity: f64) {
        if opacity > 0.0 {
            for down in 0..self.scale {
                for right in 0..self.scale {
                    raster.lay(left + right, top + down, color, opacity);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Background;

    #[test]
    fn text_is_within_its_width_and_height() {
        for height in [100, 900, 1200, 3000, 9000] {
            let kind = Type::for_picture(height);
            let [width, line] = [kind.width("0.25 height"), kind.height()];
            let mut raster = Raster::filled(width + 20, line + 20, Background::Color([255; 3]));
            kind.write(&mut raster, "0.25 height", 10, 10, [0; 3]);
            let mut dark = 0u32;
            for y in 0..raster.height {
                for x in 0..raster.width {
                    let inside = (10..10 + width).contains(&x) && (10..10 + line).contains(&y);
                    let is_dark = raster.pixel(x, y).is_some_and(|pixel| pixel[0] < 128);
                    assert!(inside || !is_dark);
                    dark += u32::from(is_dark);
                }
            }
            assert!(
                dark > width * line / 30 && dark < width * line / 3,
                "{dark}"
            );
        }
    }

    #[test]
    fn unknown_characters_are_question_marks() {
        let kind = Type::for_picture(600);
        let written = |text| {
            let mut raster = Raster::filled(40, 30, Background::Transparent);
            kind.write(&mut raster, text, 2, 2, [0; 3]);
            raster
        };
        assert_eq!(written("\u{4e00}"), written("?"));
        assert_ne!(written("a"), written("?"));
    }
}
