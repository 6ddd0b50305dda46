//! PNG out: the one encoder of this crate.

use std::io::{self, Write};

/// Pixels as PNG takes them.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(
    not(feature = "image"),
    expect(dead_code, reason = "nothing encodes them")
)]
pub(crate) struct Samples<'a> {
    /// Pixels from left to right.
    pub(crate) width: u32,
    /// Pixels from top to bottom.
    pub(crate) height: u32,
    /// Values a pixel: 1 grey, 2 grey and opacity, 3 color, 4 color and opacity.
    pub(crate) channels: u8,
    /// The values, row by row from the top.
    pub(crate) values: Values<'a>,
}

/// Values of one of the depths of PNG.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(
    not(feature = "image"),
    expect(dead_code, reason = "nothing encodes them")
)]
pub(crate) enum Values<'a> {
    /// 8 bits.
    Bytes(&'a [u8]),
    /// 16 bits.
    Words(&'a [u16]),
}

/// Writes a PNG file (ISO/IEC 15948). The same pixels give the same bytes.
#[cfg(feature = "image")]
pub(crate) fn encode(samples: &Samples<'_>, out: &mut dyn Write) -> io::Result<()> {
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    use image::{ExtendedColorType, ImageEncoder, ImageError};

    let (bytes, is_16_bit) = match samples.values {
        Values::Bytes(bytes) => (std::borrow::Cow::Borrowed(bytes), false),
        // The encoder takes words as the machine holds them.
        Values::Words(words) => {
            let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_ne_bytes()).collect();
            (bytes.into(), true)
        }
    };
    let color = match (samples.channels, is_16_bit) {
        (1, false) => ExtendedColorType::L8,
        (2, false) => ExtendedColorType::La8,
        (3, false) => ExtendedColorType::Rgb8,
        (1, true) => ExtendedColorType::L16,
        (2, true) => ExtendedColorType::La16,
        (3, true) => ExtendedColorType::Rgb16,
        (_, false) => ExtendedColorType::Rgba8,
        (_, true) => ExtendedColorType::Rgba16,
    };
    let encoder = PngEncoder::new_with_quality(out, CompressionType::Default, FilterType::Adaptive);
    let written = encoder.write_image(&bytes, samples.width, samples.height, color);
    written.map_err(|error| match error {
        ImageError::IoError(error) => error,
        other => io::Error::other(other.to_string()),
    })
}

/// Says what this build lacks.
#[cfg(not(feature = "image"))]
pub(crate) fn encode(_samples: &Samples<'_>, _out: &mut dyn Write) -> io::Result<()> {
    Err(io::Error::new(
        io::ErrorKind::Unsupported,
        "this relievo was built without images; build it with `--features image`",
    ))
}
