//! Sample images on disk, as every program that is compared gets them.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use image::RgbImage;

use crate::texture_measures::{Grid, Source};

/// Longest side of an image that is taken as it is.
const TAKEN: usize = 256;
/// Longest side of what others are made into.
const SHRUNK: usize = 128;

/// Images of a folder by name.
pub(crate) fn images(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = folder.read_dir();
    let entries = entries.with_context(|| format!("cannot list {}", folder.display()))?;
    let mut paths = Vec::new();
    for entry in entries {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "png") {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// Reads an image; what is transparent does not count.
pub(crate) fn read(path: &Path) -> Result<Grid> {
    let image = image::open(path);
    let image = image.with_context(|| format!("cannot read {}", path.display()))?;
    let image = image.to_rgba32f();
    let (width, height) = (image.width() as usize, image.height() as usize);
    let colors = image.pixels().map(|pixel| [0, 1, 2].map(|k| pixel.0[k]));
    let mut grid = Grid::new(width, height, colors.collect());
    let opaque: Vec<bool> = image.pixels().map(|pixel| pixel.0[3] >= 0.5).collect();
    grid.mask = opaque.contains(&false).then_some(opaque);
    Ok(grid)
}

/// Writes all pixels of an image with 8 bits a channel.
pub(crate) fn write(grid: &Grid, path: &Path) -> Result<()> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to 255, and saturating"
    )]
    let bytes = (grid.colors.iter().flatten()).map(|value| (255.0 * value).round() as u8);
    let (width, height) = (u32::try_from(grid.width)?, u32::try_from(grid.height)?);
    let image = RgbImage::from_raw(width, height, bytes.collect());
    let image = image.context("there are three bytes a pixel")?;
    image
        .save(path)
        .with_context(|| format!("cannot write {}", path.display()))
}

/// Writes a sample into `samples`, and into `places` an image of the same size whose colors say where they are.
pub(crate) fn prepare(path: &Path, folder: &Path) -> Result<()> {
    let grid = read(path)?;
    ensure!(
        grid.mask.is_none(),
        "{} has transparent pixels, which not every program leaves out",
        path.display()
    );
    let sample = shrunk(&grid);
    let name = path.file_stem().context("an image has a name")?.display();
    for (kind, grid) in [("samples", &sample), ("places", &places(&sample)?)] {
        let folder = folder.join(kind);
        std::fs::create_dir_all(&folder)?;
        write(grid, &folder.join(format!("{name}.png")))?;
    }
    Ok(())
}

/// Images that are too large for small neighborhoods, made smaller by the least whole factor that brings them
/// to 128 pixels: means of the squares of pixels (of the values as they are stored). What is left over at the right and
/// at the bottom is cut off. Of a wall, more bricks are left so than if it were cropped.
pub(crate) fn shrunk(grid: &Grid) -> Grid {
    let longest = grid.width.max(grid.height);
    if longest <= TAKEN {
        return grid.clone();
    }
    let factor = longest.div_ceil(SHRUNK);
    let (width, height) = (grid.width / factor, grid.height / factor);
    let count = f64::from(u32::try_from(factor * factor).unwrap_or(u32::MAX));
    let mean = |i: usize| {
        let corner = i / width * factor * grid.width + i % width * factor;
        let mut sums = [0.0; 3];
        for pixel in grid.square(corner, factor) {
            for (sum, value) in sums.iter_mut().zip(grid.colors[pixel]) {
                *sum += f64::from(value);
            }
        }
        #[expect(clippy::cast_possible_truncation, reason = "colors are single")]
        sums.map(|sum| (sum / count) as f32)
    };
    Grid::new(width, height, (0..width * height).map(mean).collect())
}

/// Column and row of each pixel as its red and green.
fn places(sample: &Grid) -> Result<Grid> {
    ensure!(
        sample.width.max(sample.height) <= 256,
        "a color has room for 256 columns and rows"
    );
    let value = |i: usize| u8::try_from(i).map(|i| f32::from(i) / 255.0);
    let mut colors = Vec::with_capacity(sample.colors.len());
    for i in 0..sample.colors.len() {
        colors.push([value(i % sample.width)?, value(i / sample.width)?, 0.0]);
    }
    Ok(Grid::new(sample.width, sample.height, colors))
}

/// Where the pixels of a result are from, of an image that was put together from `places` in the same way.
pub(crate) fn read_sources(path: &Path, result: &Grid) -> Result<Vec<Source>> {
    let grid = read(path)?;
    if [grid.width, grid.height] != [result.width, result.height] {
        bail!("{} is not of the size of its result", path.display());
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to 255"
    )]
    let place = |value: f32| (255.0 * value).round() as usize;
    let source = |pixel: usize| {
        let [x, y, _] = grid.colors[pixel];
        grid.counts(pixel).then(|| [place(x), place(y)])
    };
    Ok((0..grid.colors.len()).map(source).collect())
}
