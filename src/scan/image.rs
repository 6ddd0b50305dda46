//! Images as such: samples of texture in, texture images out.

use std::io::{self, Write};
use std::path::Path;

use super::ScanError;
use super::channel::Scalar;
use super::png::{self, Samples, Values};

/// An image.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
    /// Height × width intensities of red, green and blue, row by row from the top, as in the file (sRGB
    /// mostly): 0 is none, 1 is full. Grey is three equal ones.
    pub colors: Vec<[f32; 3]>,
    /// Whether each pixel's opacity is one half at least; `None` if all pixels' is.
    pub opaque: Option<Vec<bool>>,
    /// Whether the three intensities of every pixel are equal.
    pub is_grey: bool,
    /// Bits of a value in the file: 8 or 16.
    pub bits: u8,
}

/// Reads a PNG, JPEG or TIFF image of 8 or 16 bits a value, grey or in color, with or without opacity;
/// `-` reads standard input. Fewer bits become 8, palettes their colors.
///
/// # Errors
/// [`ScanError`]: the file cannot be read, is no such image, or claims more pixels than its bytes can hold
/// or memory should; or this build has no images (Cargo feature `image`).
#[cfg(feature = "image")]
pub fn read_image(path: &Path) -> Result<Image, ScanError> {
    let (name, bytes) = super::format::bytes_of(path)?;
    let image = super::image_file::decode(&bytes).and_then(|image| of_pixels(&image));
    image.map_err(|reason| ScanError::Malformed { name, reason })
}

/// Would read an image, in a build with the Cargo feature `image`.
///
/// # Errors
/// `ScanError::NoImagesBuiltIn`, always.
#[cfg(not(feature = "image"))]
pub fn read_image(path: &Path) -> Result<Image, ScanError> {
    Err(ScanError::NoImagesBuiltIn {
        name: path.display().to_string(),
    })
}

/// Writes an image as PNG: grey if it is, with opacity (full or none) if some pixels have none, of 16 bits a
/// value if [`Image::bits`] is 16, else of 8. Intensities are rounded to the nearest value and clamped to 0
/// and 1. The same image gives the same bytes.
///
/// # Errors
/// What `out` says; that the image has no pixels or not height × width of them; or that this build has no
/// images (Cargo feature `image`).
pub fn write_png(image: &Image, out: &mut dyn Write) -> io::Result<()> {
    let pixels = u64::from(image.width) * u64::from(image.height);
    let count = |n: usize| u64::try_from(n) == Ok(pixels);
    let complete =
        count(image.colors.len()) && image.opaque.as_ref().is_none_or(|o| count(o.len()));
    if !complete || pixels == 0 {
        let (width, height, found) = (image.width, image.height, image.colors.len());
        let problem = format!("an image of {width} by {height} pixels has {found} of them");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    let color_values = if image.is_grey { 1 } else { 3 };
    let samples = |values| Samples {
        width: image.width,
        height: image.height,
        channels: if image.is_grey { 1 } else { 3 } + u8::from(image.opaque.is_some()),
        values,
    };
    if image.bits == 16 {
        let values = whole_numbers(image, color_values, f32::from(u16::MAX));
        png::encode(&samples(Values::Words(&values)), out)
    } else {
        let values = whole_numbers(image, color_values, f32::from(u8::MAX));
        png::encode(&samples(Values::Bytes(&values)), out)
    }
}

/// The first `count` intensities of each pixel, and its opacity if there is one, as numbers up to `full`.
fn whole_numbers<T: Scalar>(image: &Image, count: usize, full: f32) -> Vec<T> {
    let mut values = Vec::with_capacity(image.colors.len() * (count + 1));
    for (row, color) in image.colors.iter().enumerate() {
        let whole = |intensity: f32| T::rounded(f64::from(intensity.clamp(0.0, 1.0) * full));
        values.extend(color.iter().take(count).map(|intensity| whole(*intensity)));
        let opacity = image.opaque.as_ref().map(|opaque| opaque[row]);
        values.extend(opacity.map(|opaque| whole(if opaque { 1.0 } else { 0.0 })));
    }
    values
}

/// An image of decoded pixels; the error is a clause about it.
#[cfg(feature = "image")]
fn of_pixels(image: &image::DynamicImage) -> Result<Image, String> {
    use image::DynamicImage as Pixels;
    let (colors, opaque, bits) = match image {
        Pixels::ImageLuma8(image) => intensities(image.as_raw(), 1, u8::MAX),
        Pixels::ImageLumaA8(image) => intensities(image.as_raw(), 2, u8::MAX),
        Pixels::ImageRgb8(image) => intensities(image.as_raw(), 3, u8::MAX),
        Pixels::ImageRgba8(image) => intensities(image.as_raw(), 4, u8::MAX),
        Pixels::ImageLuma16(image) => intensities(image.as_raw(), 1, u16::MAX),
        Pixels::ImageLumaA16(image) => intensities(image.as_raw(), 2, u16::MAX),
        Pixels::ImageRgb16(image) => intensities(image.as_raw(), 3, u16::MAX),
        Pixels::ImageRgba16(image) => intensities(image.as_raw(), 4, u16::MAX),
        _ => return Err("its pixels are not of 8 or 16 bits a value".to_owned()),
    };
    if colors.is_empty() {
        return Err("it has no pixels".to_owned());
    }
    let equal = |[r, g, b]: &[f32; 3]| r.to_bits() == g.to_bits() && g.to_bits() == b.to_bits();
    Ok(Image {
        width: image.width(),
        height: image.height(),
        is_grey: colors.iter().all(equal),
        opaque: opaque.filter(|opaque| !opaque.iter().all(|o| *o)),
        colors,
        bits,
    })
}

/// Colors and, if there is an even number of values a pixel, whether the last one is half of `full` at
/// least; and the bits of a value.
#[cfg(feature = "image")]
fn intensities<T: Copy + Into<f32>>(
    values: &[T],
    channels: usize,
    full: T,
) -> (Vec<[f32; 3]>, Option<Vec<bool>>, u8) {
    let full: f32 = full.into();
    let pixels = || values.chunks_exact(channels);
    let intensity = |value: T| value.into() / full;
    let color = |pixel: &[T]| match *pixel {
        [r, g, b] | [r, g, b, _] => [r, g, b].map(intensity),
        [grey, ..] => [intensity(grey); 3],
        [] => [0.0; 3],
    };
    let has_opacity = channels.is_multiple_of(2);
    let is_opaque = |pixel: &[T]| pixel.last().is_some_and(|a| 2.0 * (*a).into() >= full);
    (
        pixels().map(color).collect(),
        has_opacity.then(|| pixels().map(is_opaque).collect()),
        if size_of::<T>() == 1 { 8 } else { 16 },
    )
}

#[cfg(test)]
#[cfg(feature = "image")]
mod tests {
    use super::*;
    use image::{DynamicImage, ImageFormat};

    fn read_back(pixels: &DynamicImage, format: ImageFormat) -> Result<Image, ScanError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.image");
        pixels.save_with_format(&path, format).unwrap();
        read_image(&path)
    }

    /// 3 by 2 pixels of 16 bits with opacity: grey first, then color.
    fn rgba() -> image::ImageBuffer<image::Rgba<u16>, Vec<u16>> {
        image::ImageBuffer::from_fn(3, 2, |x, y| {
            let grey = u16::try_from(1000 * x + 20_000 * y).unwrap();
            let opacity = [65535, 32768, 32767][usize::try_from(x).unwrap()];
            image::Rgba([grey, grey, grey + u16::from(y > 0), opacity])
        })
    }

    #[test]
    fn every_kind_of_pixel_is_read() {
        let all = DynamicImage::ImageRgba16(rgba());
        let opacity = Some([true, true, false, true, true, false].to_vec());
        for (pixels, bits, opaque) in [
            (DynamicImage::ImageLuma8(all.to_luma8()), 8, None),
            (
                DynamicImage::ImageLumaA8(all.to_luma_alpha8()),
                8,
                opacity.clone(),
            ),
            (DynamicImage::ImageRgb8(all.to_rgb8()), 8, None),
            (DynamicImage::ImageRgba8(all.to_rgba8()), 8, opacity.clone()),
            (DynamicImage::ImageLuma16(all.to_luma16()), 16, None),
            (
                DynamicImage::ImageLumaA16(all.to_luma_alpha16()),
                16,
                opacity.clone(),
            ),
            (DynamicImage::ImageRgb16(all.to_rgb16()), 16, None),
            (all.clone(), 16, opacity),
        ] {
            let kind = pixels.color();
            let image = read_back(&pixels, ImageFormat::Png).unwrap();
            assert_eq!(
                (image.width, image.height, image.bits),
                (3, 2, bits),
                "{kind:?}"
            );
            // 127 and 128 of 255 are on either side of one half, as 32767 and 32768 of 65535 are.
            assert_eq!(image.opaque, opaque, "{kind:?}");
            assert_eq!(image.is_grey, bits == 8 || !kind.has_color(), "{kind:?}");
            for (pixel, color) in rgba().pixels().zip(&image.colors) {
                for (value, intensity) in pixel.0.iter().zip(color) {
                    let error = (f32::from(*value) / 65535.0 - intensity).abs();
                    assert!(
                        error < if bits == 8 { 0.003 } else { 2e-5 },
                        "{kind:?} {error}"
                    );
                }
            }
        }
    }

    #[test]
    fn jpeg_and_tiff_are_read_and_floats_are_not() {
        let grey = DynamicImage::ImageLuma8(image::GrayImage::from_pixel(9, 5, image::Luma([51])));
        for format in [ImageFormat::Jpeg, ImageFormat::Tiff] {
            let image = read_back(&grey, format).unwrap();
            assert_eq!((image.width, image.height, image.is_grey), (9, 5, true));
            assert!(image.colors.iter().all(|c| (c[0] - 0.2).abs() < 0.01));
        }
        let floats = DynamicImage::ImageRgb32F(grey.to_rgb32f());
        let error = read_back(&floats, ImageFormat::Tiff)
            .unwrap_err()
            .to_string();
        assert!(error.contains("8 or 16 bits"), "{error}");
    }

    #[test]
    fn what_is_no_image_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let error = read_image(&path).unwrap_err();
        assert!(matches!(error, ScanError::NotFound { .. }), "{error}");
        std::fs::write(&path, "GIF89a").unwrap();
        let error = read_image(&path).unwrap_err().to_string();
        assert!(error.contains("a.png: it is not a PNG"), "{error}");
    }

    #[test]
    fn images_survive_the_way_out_and_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for (grey, bits, hole) in [
            (true, 8, false),
            (true, 16, true),
            (false, 8, true),
            (false, 16, false),
        ] {
            let full = if bits == 8 { 255.0 } else { 65535.0 };
            let value = |k: usize| (k * 37 % 256) as f32 / full;
            let color = |k| {
                if grey {
                    [value(k); 3]
                } else {
                    [value(k), value(k + 1), 1.0]
                }
            };
            let image = Image {
                width: 7,
                height: 5,
                colors: (0..35).map(color).collect(),
                opaque: hole.then(|| (0..35).map(|k| k != 4).collect()),
                is_grey: grey,
                bits,
            };
            let mut bytes = Vec::new();
            write_png(&image, &mut bytes).unwrap();
            std::fs::write(&path, &bytes).unwrap();
            assert_eq!(read_image(&path).unwrap(), image);
        }
    }

    #[test]
    fn intensities_are_clamped_and_wrong_sizes_are_refused() {
        let mut image = Image {
            width: 2,
            height: 1,
            colors: vec![[-1.0, 2.0, f32::NAN], [0.5, 0.25, 1.0]],
            opaque: None,
            is_grey: false,
            bits: 8,
        };
        let mut bytes = Vec::new();
        write_png(&image, &mut bytes).unwrap();
        let pixels = image::load_from_memory(&bytes).unwrap().into_rgb8();
        assert_eq!(pixels.as_raw(), &[0, 255, 0, 128, 64, 255]);
        image.height = 2;
        assert!(write_png(&image, &mut bytes).is_err());
        image.height = 0;
        image.colors.clear();
        assert!(write_png(&image, &mut bytes).is_err());
    }
}
