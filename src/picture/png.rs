//! Pictures as PNG files.

use std::io::Write;

use super::{PictureError, Raster};
#[cfg(feature = "image")]
use crate::scan::png::{self, Samples, Values};

/// Writes a picture as PNG (ISO/IEC 15948), 8 bits a channel, sRGB; with opacity only where a pixel is not
/// opaque. The same picture gives the same bytes.
///
/// # Errors
/// [`PictureError::Encode`] with what `out` says, or that this build cannot write PNG (Cargo feature `image`).
#[cfg(feature = "image")]
pub fn write_png(raster: &Raster, out: &mut dyn Write) -> Result<(), PictureError> {
    let pixels = &raster.pixels;
    let (bytes, channels): (Vec<u8>, u8) = if raster.is_opaque() {
        let opaque = pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]);
        (opaque.collect(), 3)
    } else {
        (pixels.iter().flatten().copied().collect(), 4)
    };
    let samples = Samples {
        width: raster.width,
        height: raster.height,
        channels,
        values: Values::Bytes(&bytes),
    };
    png::encode(&samples, out).map_err(|error| PictureError::Encode(error.to_string()))
}

/// Would write a picture as PNG, in a build with the Cargo feature `image`.
///
/// # Errors
/// `PictureError::NotBuilt`, always.
#[cfg(not(feature = "image"))]
pub fn write_png(_raster: &Raster, _out: &mut dyn Write) -> Result<(), PictureError> {
    Err(PictureError::NotBuilt)
}

/// Whether this build can write PNG: worth asking before long work.
///
/// # Errors
/// `PictureError::NotBuilt` if it cannot (Cargo feature `image`).
#[cfg(feature = "image")]
pub fn check_built() -> Result<(), PictureError> {
    Ok(())
}

/// Says what this build lacks.
///
/// # Errors
/// `PictureError::NotBuilt`, always.
#[cfg(not(feature = "image"))]
pub fn check_built() -> Result<(), PictureError> {
    Err(PictureError::NotBuilt)
}

#[cfg(all(test, feature = "image"))]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let opaque = Raster {
            width: 3,
            height: 2,
            pixels: (0..6).map(|k| [k, 40 * k, 255 - k, 255]).collect(),
        };
        let mut clear = opaque.clone();
        clear.pixels[4] = [1, 2, 3, 4];
        for (raster, channels) in [(opaque, 3), (clear, 4)] {
            let mut bytes = Vec::new();
            write_png(&raster, &mut bytes).unwrap();
            let read = image::load_from_memory(&bytes).unwrap();
            assert_eq!(read.color().channel_count(), channels);
            let pixels: Vec<[u8; 4]> = read.to_rgba8().pixels().map(|p| p.0).collect();
            assert_eq!(pixels, raster.pixels);
        }
    }
}
