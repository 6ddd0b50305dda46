//! Colours of a texture image at texture coordinates.

use std::collections::BTreeMap;

/// Images of one scan that are looked for at most; scans in many tiles have hundreds.
const MOST_IMAGES: usize = 2_000;

/// Memory of all of them together, in bytes.
const MOST_MEMORY: usize = 2 << 30;

/// What is seen beyond the borders of an image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored.
    Mirror,
    /// The pixels at the border.
    Clamp,
}

/// An image in 8-bit red, green and blue.
#[derive(Debug)]
pub(super) struct Texture {
    width: usize,
    height: usize,
    /// Red, green and blue of each pixel, row by row from the top.
    values: Vec<u8>,
}

impl Texture {
    /// Decodes a PNG, JPEG or TIFF image; transparency is dropped. The error is a clause about it.
    #[cfg(feature = "image")]
    pub(super) fn decode(bytes: &[u8]) -> Result<Self, String> {
        let image = super::image_file::decode(bytes)?.into_rgb8();
        let [width, height] =
            [image.width(), image.height()].map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        let values = image.into_raw();
        if values.is_empty() {
            return Err("it has no pixels".to_owned());
        }
        Ok(Self {
            width,
            height,
            values,
        })
    }

    #[cfg(not(feature = "image"))]
    pub(super) fn decode(_bytes: &[u8]) -> Result<Self, String> {
        Err("this relievo was built without images; build it with `--features image`".to_owned())
    }

    /// Red, green and blue, 0 to 255, interpolated linearly between the centres of the four nearest
    /// pixels. u runs from 0 at the left border to 1 at the right one, v from 0 at the top to 1 at the
    /// bottom.
    ///
    /// Coordinates that are not finite are taken as 0.
    pub(super) fn sample(&self, [u, v]: [f64; 2], [wrap_u, wrap_v]: [Wrap; 2]) -> [f64; 3] {
        // At its borders an image that is not repeated is not mixed with the other side.
        let within = |c: f64, wrap: Wrap| match wrap {
            Wrap::Repeat if (0.0..=1.0).contains(&c) => Wrap::Clamp,
            wrap => wrap,
        };
        let (wrap_u, wrap_v) = (within(u, wrap_u), within(v, wrap_v));
        let (left, right, x) = neighbors(u, self.width, wrap_u);
        let (top, bottom, y) = neighbors(v, self.height, wrap_v);
        let pixel = |row: usize, column: usize| &self.values[3 * (row * self.width + column)..];
        let rows = [top, bottom].map(|row| {
            let (a, b) = (pixel(row, left), pixel(row, right));
            [0, 1, 2].map(|k| f64::from(a[k]) * (1.0 - x) + f64::from(b[k]) * x)
        });
        [0, 1, 2].map(|k| rows[0][k] * (1.0 - y) + rows[1][k] * y)
    }
}

/// Images by the names that materials give them.
#[derive(Debug, Default)]
pub(super) struct Textures {
    numbers: BTreeMap<String, Option<usize>>,
    textures: Vec<Texture>,
    memory: usize,
}

impl Textures {
    /// The number of an image, which is loaded once; `None`, with a warning, if it cannot be read.
    pub(super) fn load(
        &mut self,
        image: &str,
        scan: &str,
        bytes: impl FnOnce() -> Result<Vec<u8>, String>,
    ) -> Option<usize> {
        if let Some(known) = self.numbers.get(image) {
            return *known;
        }
        let texture = if self.numbers.len() >= MOST_IMAGES || self.memory > MOST_MEMORY {
            Err("the images before it are too many or too large".to_owned())
        } else {
            bytes().and_then(|bytes| Texture::decode(&bytes))
        };
        let number = match texture {
            Ok(texture) => {
                self.memory += texture.values.len();
                self.textures.push(texture);
                Some(self.textures.len() - 1)
            }
            Err(reason) => {
                log::warn!("{scan}: goes on without the texture {image}: {reason}");
                None
            }
        };
        self.numbers.insert(image.to_owned(), number);
        number
    }

    /// The image of a number.
    pub(super) fn get(&self, number: usize) -> Option<&Texture> {
        self.textures.get(number)
    }
}

/// The two pixels along an axis whose centres are around a coordinate, and how far it is from the
/// first to the second.
fn neighbors(coordinate: f64, size: usize, wrap: Wrap) -> (usize, usize, f64) {
    let coordinate = if coordinate.is_finite() {
        coordinate
    } else {
        0.0
    };
    // Folding first keeps large coordinates from losing the place within the image.
    let folded = match wrap {
        Wrap::Repeat => coordinate.rem_euclid(1.0),
        Wrap::Mirror => {
            let twice = coordinate.rem_euclid(2.0);
            twice.min(2.0 - twice)
        }
        Wrap::Clamp => coordinate.clamp(0.0, 1.0),
    };
    let place = folded * size as f64 - 0.5;
    let floor = place.floor();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0, and at most the number of pixels"
    )]
    let second = ((floor + 1.0).max(0.0) as usize).min(size);
    let beyond = match wrap {
        Wrap::Repeat => [size - 1, 0],
        Wrap::Mirror | Wrap::Clamp => [0, size - 1],
    };
    let first = second.checked_sub(1).unwrap_or(beyond[0]);
    let second = if second == size { beyond[1] } else { second };
    (first, second, place - floor)
}

/// A colour of 0 to 255 in whole numbers.
pub(super) fn rounded(color: [f64; 3]) -> [u8; 3] {
    color.map(super::channel::Scalar::rounded)
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "the values are exact in binary")]
mod tests {
    use super::*;

    fn texture() -> Texture {
        Texture {
            width: 2,
            height: 2,
            values: vec![0, 0, 0, 100, 0, 0, 0, 200, 0, 100, 200, 50],
        }
    }

    #[test]
    fn centers_of_pixels_give_their_color() {
        let wrap = [Wrap::Repeat; 2];
        for (place, color) in [
            ([0.25, 0.25], [0.0, 0.0, 0.0]),
            ([0.75, 0.25], [100.0, 0.0, 0.0]),
            ([0.25, 0.75], [0.0, 200.0, 0.0]),
            ([0.5, 0.5], [50.0, 100.0, 12.5]),
            ([-1.25, 3.75], [100.0, 200.0, 50.0]),
        ] {
            assert_eq!(texture().sample(place, wrap), color, "{place:?}");
        }
    }

    #[test]
    fn borders_repeat_mirror_or_stay() {
        let at = |u: f64, wrap: Wrap| texture().sample([u, 0.25], [wrap; 2])[0];
        for (u, repeat, mirror, clamp) in [
            (0.0, 0.0, 0.0, 0.0),
            (1.0, 100.0, 100.0, 100.0),
            (2.0, 50.0, 0.0, 100.0),
            (1.25, 0.0, 100.0, 100.0),
            (-0.75, 0.0, 100.0, 0.0),
        ] {
            assert_eq!(at(u, Wrap::Repeat), repeat, "{u}");
            assert_eq!(at(u, Wrap::Mirror), mirror, "{u}");
            assert_eq!(at(u, Wrap::Clamp), clamp, "{u}");
        }
    }

    #[test]
    fn any_coordinate_is_in_the_image() {
        let extremes = [
            f64::NAN,
            f64::INFINITY,
            f64::MAX,
            -f64::MAX,
            -1e-300,
            1.0 - f64::EPSILON / 2.0,
            f64::MIN_POSITIVE,
        ];
        for u in extremes {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                let color = texture().sample([u, u], [wrap; 2]);
                assert!(color.iter().all(|c| (0.0..=200.0).contains(c)), "{u}");
            }
        }
    }
}
