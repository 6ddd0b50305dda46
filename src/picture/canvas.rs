//! Pixels while they are drawn (in linear light), and when they are done (sRGB).

use std::sync::LazyLock;

use super::params::Background;

/// A pixel in the making.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pixel {
    /// Red, green and blue in linear light, times the coverage.
    pub(super) light: [f32; 3],
    /// Which share of the pixel is covered.
    pub(super) coverage: f32,
    /// Depth in its middle; NaN for the background.
    pub(super) depth: f32,
    /// Sum of the unit normals (in the camera's axes) seen in it.
    pub(super) normal: [f32; 3],
}

impl Pixel {
    pub(super) const EMPTY: Self = Self {
        light: [0.0; 3],
        coverage: 0.0,
        depth: f32::NAN,
        normal: [0.0; 3],
    };
}

/// A picture in the making.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Canvas {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Rows from the top.
    pub(super) pixels: Vec<Pixel>,
}

/// A finished picture: eight bits each of red, green, blue (sRGB, IEC 61966-2-1) and opacity, not
/// premultiplied.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Raster {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Height × width pixels, rows from the top.
    pub pixels: Vec<[u8; 4]>,
}

impl Raster {
    /// A picture of one colour.
    pub(super) fn filled(width: u32, height: u32, background: Background) -> Self {
        let count = width as usize * height as usize;
        Self {
            width,
            height,
            pixels: vec![opaque(background); count],
        }
    }

    /// The pixel in a column and a row, from the left upper corner; `None` beyond the picture.
    #[must_use]
    pub fn pixel(&self, column: u32, row: u32) -> Option<[u8; 4]> {
        let inside = column < self.width && row < self.height;
        inside.then(|| self.pixels[row as usize * self.width as usize + column as usize])
    }

    /// Lays a colour over a pixel, `opacity` from 0 to 1; beyond the picture nothing happens.
    pub(super) fn lay(&mut self, column: u32, row: u32, color: [u8; 3], opacity: f64) {
        if column >= self.width || row >= self.height {
            return;
        }
        let pixel = &mut self.pixels[row as usize * self.width as usize + column as usize];
        let below = f64::from(pixel[3]) / 255.0;
        let all = opacity + below * (1.0 - opacity);
        if all <= 0.0 {
            return;
        }
        for (value, new) in pixel.iter_mut().zip(color) {
            let mixed = f64::from(new) * opacity + f64::from(*value) * below * (1.0 - opacity);
            *value = byte(mixed / all / 255.0);
        }
        pixel[3] = byte(all);
    }

    /// Whether all pixels are opaque.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        self.pixels.iter().all(|pixel| pixel[3] == u8::MAX)
    }
}

impl Canvas {
    /// The picture, over a background.
    pub(super) fn over(&self, background: Background) -> Raster {
        let [width, height] = [self.width, self.height].map(|n| u32::try_from(n).unwrap_or(0));
        let mut raster = Raster::filled(width, height, background);
        let behind = match background {
            Background::Transparent => None,
            Background::Color(color) => Some(color.map(linear)),
        };
        for (pixel, out) in self.pixels.iter().zip(&mut raster.pixels) {
            if pixel.coverage <= 0.0 {
                continue;
            }
            let rest = 1.0 - pixel.coverage;
            *out = match behind {
                Some(behind) => {
                    let mixed = [0, 1, 2].map(|k| encoded(pixel.light[k] + rest * behind[k]));
                    [mixed[0], mixed[1], mixed[2], u8::MAX]
                }
                None => {
                    let [r, g, b] = pixel.light.map(|light| encoded(light / pixel.coverage));
                    [r, g, b, byte(f64::from(pixel.coverage))]
                }
            };
        }
        raster
    }
}

fn opaque(background: Background) -> [u8; 4] {
    match background {
        Background::Transparent => [0; 4],
        Background::Color([r, g, b]) => [r, g, b, u8::MAX],
    }
}

/// From 0 … 1 to 0 … 255, the nearest.
fn byte(share: f64) -> u8 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float cast saturates"
    )]
    let byte = (share * 255.0).round() as u8;
    byte
}

/// The nearest single-precision number.
#[expect(
    clippy::cast_possible_truncation,
    reason = "rounding to the nearest value is what is asked for"
)]
pub(super) fn single(value: f64) -> f32 {
    value as f32
}

/// Linear light of an sRGB intensity from 0 to 1 (IEC 61966-2-1).
pub(super) fn linear_of(intensity: f64) -> f64 {
    if intensity <= 0.040_45 {
        intensity / 12.92
    } else {
        ((intensity + 0.055) / 1.055).powf(2.4)
    }
}

/// sRGB intensity of linear light from 0 to 1 (IEC 61966-2-1).
fn intensity_of(light: f64) -> f64 {
    if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    }
}

/// Linear light of each byte.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|k| single(linear_of(k as f64 / 255.0))));

pub(super) fn linear(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

/// Steps of linear light: fine enough that no byte is missed, even where sRGB is steepest (3295 a unit).
const STEPS: usize = 1 << 14;

static ENCODED: LazyLock<Vec<u8>> = LazyLock::new(|| {
    (0..=STEPS)
        .map(|k| byte(intensity_of(k as f64 / STEPS as f64)))
        .collect()
});

/// sRGB byte of linear light; what is beyond 0 to 1 is clamped.
pub(super) fn encoded(light: f32) -> u8 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float cast saturates, and NaN becomes 0"
    )]
    let step = (f64::from(light) * STEPS as f64).round() as usize;
    ENCODED[step.min(STEPS)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_linear_light() {
        for byte in 0..=u8::MAX {
            assert_eq!(encoded(linear(byte)), byte);
        }
        assert_eq!(encoded(f32::NAN), 0);
        assert_eq!(encoded(-1.0), 0);
        assert_eq!(encoded(7.0), 255);
    }

    #[test]
    fn half_covered_pixels_mix_in_linear_light_and_are_half_transparent() {
        let pixel = Pixel {
            light: [0.5, 0.0, 0.0],
            coverage: 0.5,
            ..Pixel::EMPTY
        };
        let canvas = Canvas {
            width: 2,
            height: 1,
            pixels: vec![pixel, Pixel::EMPTY],
        };
        let black = canvas.over(Background::Color([0; 3]));
        assert_eq!(black.pixels, [[188, 0, 0, 255], [0, 0, 0, 255]]);
        assert!(black.is_opaque());
        let clear = canvas.over(Background::Transparent);
        assert_eq!(clear.pixels, [[255, 0, 0, 128], [0; 4]]);
        assert!(!clear.is_opaque());
    }

    #[test]
    fn colors_are_laid_over_what_is_there() {
        let mut raster = Raster::filled(1, 1, Background::Transparent);
        raster.lay(0, 0, [200, 100, 0], 0.5);
        assert_eq!(raster.pixels, [[200, 100, 0, 128]]);
        raster.lay(0, 0, [0, 0, 0], 1.0);
        assert_eq!(raster.pixels, [[0, 0, 0, 255]]);
        raster.lay(1, 0, [9, 9, 9], 1.0);
        raster.lay(0, 1, [9, 9, 9], 1.0);
        assert_eq!(raster.pixels, [[0, 0, 0, 255]]);
    }
}
