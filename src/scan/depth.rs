//! Depth images: what each pixel of a camera saw is so far away along its axis.
//!
//! 16-bit grey PNG and TIFF, and TIFF of 32- or 64-bit floats. Depths stay in the image's own unit; 0 and
//! negative ones, and floats that are not finite, mean that nothing was measured. The scan is in the camera's
//! frame: x to the right, y down, z away from the camera, which sits at the origin.

use std::io::Cursor;

use image::DynamicImage;
use nalgebra::Point3;
use tiff::decoder::{Decoder, DecodingResult, Limits};

use super::format::load;
use super::image_file::{MOST_MEMORY, check_size, damaged, decode};
use super::range_grid::Grid;
use super::source::{Parsed, Source};
use super::{Column, Intrinsics, Scan, ScanError, Sensor};

/// Reads a depth image; [`super::ReadOptions::intrinsics`] says how the camera saw.
pub(super) fn read(source: &Source) -> Result<Parsed, ScanError> {
    let name = || source.name.to_owned();
    let malformed = |reason: String| ScanError::Malformed {
        name: name(),
        reason,
    };
    let camera = source
        .options
        .intrinsics
        .ok_or_else(|| ScanError::MissingOption {
            name: name(),
            reason: "a depth image needs its camera: give --intrinsics FX,FY,CX,CY in pixels"
                .to_owned(),
        })?;
    let depths = if source.bytes.starts_with(b"\x89PNG") {
        png(source.bytes)
    } else {
        tiff(source.bytes)
    };
    let depths = depths.map_err(malformed)?;
    let colors = match &source.options.color_image {
        Some(path) => Some(colors(path, &depths, source.name)?),
        None => None,
    };
    Ok(seen(&depths, &camera, colors.as_deref()))
}

/// Depths, row by row from the top.
struct Depths {
    width: usize,
    values: Vec<f32>,
}

impl Depths {
    fn height(&self) -> usize {
        self.values.len() / self.width.max(1)
    }
}

fn png(bytes: &[u8]) -> Result<Depths, String> {
    match decode(bytes)? {
        DynamicImage::ImageLuma16(image) => Ok(Depths {
            width: size(image.width()),
            values: image.into_raw().into_iter().map(f32::from).collect(),
        }),
        _ => Err("this is not a depth image, which has 16 bits of grey a pixel".to_owned()),
    }
}

fn tiff(bytes: &[u8]) -> Result<Depths, String> {
    let told = |error: tiff::TiffError| damaged(error);
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(told)?;
    let (width, height) = decoder.dimensions().map_err(told)?;
    let pixels = u64::from(width) * u64::from(height);
    // The largest values are of 8 bytes.
    check_size(width, height, pixels.saturating_mul(8), bytes)?;
    let mut limits = Limits::default();
    let most = usize::try_from(MOST_MEMORY).unwrap_or(usize::MAX);
    limits.decoding_buffer_size = most;
    limits.intermediate_buffer_size = most;
    limits.ifd_value_size = most;
    let mut decoder = decoder.with_limits(limits);
    if !matches!(decoder.colortype().map_err(told)?, tiff::ColorType::Gray(_)) {
        return Err("this is not a depth image: its pixels have several values".to_owned());
    }
    #[expect(
        clippy::cast_possible_truncation,
        reason = "as precise as vertices are"
    )]
    let values: Vec<f32> = match decoder.read_image().map_err(told)? {
        DecodingResult::U16(values) => values.into_iter().map(f32::from).collect(),
        DecodingResult::F32(values) => values,
        DecodingResult::F64(values) => values.into_iter().map(|v| v as f32).collect(),
        _ => {
            return Err(
                "this is not a depth image, which has 16 bits of grey or floats".to_owned(),
            );
        }
    };
    if u64::try_from(values.len()) != Ok(pixels) {
        return Err(format!(
            "it has {} values for {pixels} pixels",
            values.len()
        ));
    }
    Ok(Depths {
        width: size(width),
        values,
    })
}

/// Red, green and blue of each pixel.
fn colors(path: &std::path::Path, depths: &Depths, depth: &str) -> Result<Vec<u8>, ScanError> {
    let name = path.display().to_string();
    let bytes = load(path, &name)?;
    let malformed = |reason: String| ScanError::Malformed {
        name: name.clone(),
        reason,
    };
    let image = decode(&bytes).map_err(malformed)?.into_rgb8();
    let found = [image.width(), image.height()].map(size);
    if found != [depths.width, depths.height()] {
        return Err(ScanError::MissingOption {
            name: name.clone(),
            reason: format!(
                "this colour image has {} by {} pixels, but {depth} has {} by {}: give one of the same size",
                found[0],
                found[1],
                depths.width,
                depths.height()
            ),
        });
    }
    Ok(image.into_raw())
}

/// The points, and the pixels as their grid.
fn seen(depths: &Depths, camera: &Intrinsics, colors: Option<&[u8]>) -> Parsed {
    let mut points: Vec<[f32; 3]> = Vec::new();
    let mut rgb: [Vec<u8>; 3] = Default::default();
    let mut cells = Vec::with_capacity(depths.values.len());
    for (pixel, depth) in depths.values.iter().enumerate() {
        let z = f64::from(*depth);
        let u = (pixel % depths.width) as f64;
        let v = (pixel / depths.width) as f64;
        let place = [
            (u - camera.cx) / camera.fx * z,
            (v - camera.cy) / camera.fy * z,
            z,
        ];
        #[expect(
            clippy::cast_possible_truncation,
            reason = "as precise as the depth is"
        )]
        let place = place.map(|x| x as f32);
        if z <= 0.0 || !place.iter().all(|x| x.is_finite()) {
            cells.push(None);
            continue;
        }
        cells.push(u32::try_from(points.len()).ok());
        points.push(place);
        if let Some(colors) = colors {
            for (k, channel) in rgb.iter_mut().enumerate() {
                channel.push(colors[3 * pixel + k]);
            }
        }
    }
    let mut scan = Scan::default();
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let values = points.iter().map(|p| p[k]).collect();
        scan.vertices.set_channel(axis, Column::F32(values));
    }
    if colors.is_some() {
        for (name, values) in ["red", "green", "blue"].into_iter().zip(rgb) {
            scan.vertices.set_channel(name, Column::U8(values));
        }
    }
    scan.sensors = vec![Sensor {
        vertices: 0..points.len(),
        position: Point3::origin(),
    }];
    let grid = Grid {
        columns: depths.width,
        cells,
        sensor: Some(Point3::origin()),
    };
    Parsed {
        scan,
        grids: vec![grid],
    }
}

fn size(pixels: u32) -> usize {
    usize::try_from(pixels).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Rng, Stage};
    use crate::scan::{Format, ReadOptions, read_from};
    use image::{ImageBuffer, ImageFormat, Luma, Rgb};
    use tiff::encoder::{TiffEncoder, colortype};

    const CAMERA: Intrinsics = Intrinsics {
        fx: 2.0,
        fy: 4.0,
        cx: 1.0,
        cy: 0.5,
    };

    fn options() -> ReadOptions {
        ReadOptions {
            intrinsics: Some(CAMERA),
            ..ReadOptions::default()
        }
    }

    fn grey(depths: &[u16]) -> Vec<u8> {
        let image = ImageBuffer::<Luma<u16>, _>::from_vec(3, 2, depths.to_vec()).unwrap();
        let mut out = Cursor::new(Vec::new());
        image.write_to(&mut out, ImageFormat::Png).unwrap();
        out.into_inner()
    }

    fn floats(depths: &[f32]) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut out).unwrap();
        encoder
            .write_image::<colortype::Gray32Float>(3, 2, depths)
            .unwrap();
        out.into_inner()
    }

    fn scan(bytes: &[u8], options: &ReadOptions) -> Result<Scan, String> {
        read_from(bytes, Format::Depth, "a.png", options).map_err(|e| e.to_string())
    }

    #[test]
    fn pixels_become_points_along_their_rays() {
        let depths = [4u16, 4, 4, 0, 8, 4];
        let as_floats = [4.0f32, 4.0, 4.0, f32::NAN, 8.0, 4.0];
        for bytes in [grey(&depths), floats(&as_floats)] {
            let scan = scan(&bytes, &options()).unwrap();
            let expected = [
                [-2.0, -0.5, 4.0],
                [0.0, -0.5, 4.0],
                [2.0, -0.5, 4.0],
                [0.0, 1.0, 8.0],
                [2.0, 0.5, 4.0],
            ];
            let points: Vec<[f64; 3]> = scan.positions().iter().map(|p| p.coords.into()).collect();
            assert_eq!(points, expected);
            assert_eq!(scan.sensors[0].position, Point3::origin());
        }
    }

    #[test]
    fn surfaces_face_the_camera() {
        let scan = scan(&grey(&[40; 6]), &options()).unwrap();
        assert_eq!(scan.faces.len(), 4);
        let mesh = scan.mesh();
        for f in 0..4 {
            assert!(crate::mesh::triangle_normal(mesh.corners(f)).z < 0.0);
        }
    }

    #[test]
    fn colors_come_from_an_image_of_the_same_size() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("color.png");
        let pixel = |x: u32, y: u32| Rgb([x, y, 9].map(|v| u8::try_from(v).unwrap()));
        image::RgbImage::from_fn(3, 2, pixel).save(&path).unwrap();
        let with = |path: &std::path::Path| ReadOptions {
            color_image: Some(path.to_owned()),
            ..options()
        };
        let colored = scan(&grey(&[4, 4, 4, 0, 8, 4]), &with(&path)).unwrap();
        assert_eq!(
            colored.vertices.column("red"),
            Some(&Column::U8(vec![0, 1, 2, 1, 2]))
        );
        assert_eq!(
            colored.vertices.column("green"),
            Some(&Column::U8(vec![0, 0, 0, 1, 1]))
        );
        image::RgbImage::from_fn(2, 3, pixel).save(&path).unwrap();
        let error = scan(&grey(&[4; 6]), &with(&path)).unwrap_err();
        assert!(
            error.contains("2 by 3") && error.contains("3 by 2"),
            "{error}"
        );
        let error = scan(&grey(&[4; 6]), &with(&folder.path().join("none.png"))).unwrap_err();
        assert!(error.contains("no such file"), "{error}");
    }

    #[test]
    fn what_is_no_depth_image_is_refused() {
        let error = scan(&grey(&[4; 6]), &ReadOptions::default()).unwrap_err();
        assert!(error.contains("--intrinsics"), "{error}");
        let mut color = Cursor::new(Vec::new());
        let image = image::RgbImage::new(3, 2);
        image.write_to(&mut color, ImageFormat::Png).unwrap();
        let error = scan(&color.into_inner(), &options()).unwrap_err();
        assert!(error.contains("16 bits of grey"), "{error}");
        let mut color = Cursor::new(Vec::new());
        image.write_to(&mut color, ImageFormat::Tiff).unwrap();
        let error = scan(&color.into_inner(), &options()).unwrap_err();
        assert!(error.contains("several values"), "{error}");
        let error = scan(&grey(&[0; 6]), &options()).unwrap_err();
        assert!(error.contains("no vertices"), "{error}");
    }

    #[test]
    fn broken_images_are_errors() {
        let mut rng = Rng::new(3, Stage::Synth, 0);
        for good in [grey(&[1, 2, 3, 4, 5, 6]), floats(&[1.0; 6])] {
            for length in 0..good.len() {
                let _ = scan(&good[..length], &options());
            }
            for _ in 0..2000 {
                let mut bad = good.clone();
                for _ in 0..=rng.index(4) {
                    let at = rng.index(bad.len());
                    bad[at] = u8::try_from(rng.index(256)).unwrap();
                }
                if let Ok(scan) = scan(&bad, &options()) {
                    assert_eq!(scan.check("bad").map_err(|e| e.to_string()), Ok(()));
                }
            }
        }
    }
}
