//! PNG, JPEG and TIFF images, decoded within limits.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

/// Largest width and height, in pixels.
const LARGEST_SIDE: u32 = 1 << 16;

/// Most pixels: 16384 by 16384, the largest texture of today's graphics cards.
const MOST_PIXELS: u64 = 1 << 28;

/// Most memory of a decoded image, in bytes.
pub(super) const MOST_MEMORY: u64 = 1 << 30;

/// Most decoded bytes a byte of the file. Deflate gives at most 1032 (a code of two bits for 258
/// bytes), JPEG 1024 (a bit a block of 64 in each of its scans, at two bytes), the LZW of TIFF, with
/// codes of 12 bits, about 2600 for images of one value; more is a header that lies.
const MOST_EXPANSION: u64 = 4096;

/// Decodes an image; the error is a clause about it.
pub(super) fn decode(bytes: &[u8]) -> Result<DynamicImage, String> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let mut reader = reader.map_err(|error| error.to_string())?;
    let known = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff];
    if !reader
        .format()
        .is_some_and(|format| known.contains(&format))
    {
        return Err("it is not a PNG, JPEG or TIFF image".to_owned());
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    limits.max_alloc = Some(MOST_MEMORY);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let size = decoder.total_bytes();
    let (width, height) = decoder.dimensions();
    check_size(width, height, size, bytes)?;
    DynamicImage::from_decoder(decoder).map_err(damaged)
}

/// What the decoder says is for its authors.
pub(super) fn damaged(error: impl std::fmt::Display) -> String {
    log::debug!("the image decoder says: {error}");
    "the image is damaged, cut off or too large".to_owned()
}

/// Whether an image that takes `size` bytes when decoded may be in a file of these bytes.
pub(super) fn check_size(width: u32, height: u32, size: u64, bytes: &[u8]) -> Result<(), String> {
    let length = u64::try_from(bytes.len()).unwrap_or(u64::MAX);
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MOST_PIXELS || size > MOST_MEMORY || size > length.saturating_mul(MOST_EXPANSION) {
        return Err(format!(
            "its {width} by {height} pixels are more than {} bytes can hold or memory should",
            bytes.len()
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Rng, Stage};
    use image::{Rgb, RgbImage};

    fn encoded(format: ImageFormat) -> Vec<u8> {
        let image = RgbImage::from_fn(9, 7, |x, y| {
            Rgb([x * 20, y * 30, 255 - x * y].map(|v| u8::try_from(v).unwrap()))
        });
        let mut out = Cursor::new(Vec::new());
        image.write_to(&mut out, format).unwrap();
        out.into_inner()
    }

    const FORMATS: [ImageFormat; 3] = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff];

    #[test]
    fn images_of_each_format_are_decoded() {
        for format in FORMATS {
            let image = decode(&encoded(format)).unwrap();
            assert_eq!((image.width(), image.height()), (9, 7), "{format:?}");
        }
        assert!(decode(b"GIF89a").unwrap_err().contains("not a PNG"));
        assert!(decode(b"").unwrap_err().contains("not a PNG"));
    }

    #[test]
    fn broken_images_are_errors() {
        let mut rng = Rng::new(1, Stage::Synth, 0);
        for format in FORMATS {
            let good = encoded(format);
            for length in 0..good.len() {
                // A decoder may be content without the last bytes; it must only come back.
                let _ = decode(&good[..length]);
            }
            for _ in 0..3000 {
                let mut bad = good.clone();
                for _ in 0..=rng.index(4) {
                    let at = rng.index(bad.len());
                    bad[at] = u8::try_from(rng.index(256)).unwrap();
                }
                if let Ok(image) = decode(&bad) {
                    assert!(image.width() > 0 && image.height() > 0);
                }
            }
        }
    }

    #[test]
    fn a_header_that_claims_too_much_is_refused() {
        let mut png = encoded(ImageFormat::Png);
        png[16..24].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x40, 0]);
        // The checksum of the changed header, so that nothing else is wrong with the file.
        let checksum = crc32(&png[12..29]);
        png[29..33].copy_from_slice(&checksum.to_be_bytes());
        let error = decode(&png).unwrap_err();
        assert!(error.contains("16384 by 16384"), "{error}");
    }

    fn crc32(bytes: &[u8]) -> u32 {
        let update = |crc: u32, byte: &u8| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
                (crc >> 1) ^ (0xEDB8_8320 * (crc & 1))
            })
        };
        !bytes.iter().fold(u32::MAX, update)
    }
}
