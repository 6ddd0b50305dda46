//! Relief made readable: where the surface is turned towards the key light more than its surroundings are, it
//! is drawn lighter, where less, darker. Shallow relief on a curved base shows everywhere, not only where the
//! light happens to rake over it.
//!
//! # Reference
//! After S. Rusinkiewicz, M. Burns, D. `DeCarlo`: "Exaggerated shading for depicting shape and detail", ACM
//! Transactions on Graphics 25(3), 2006, with one scale of surroundings, on the picture.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::canvas::{Canvas, Pixel, single};

/// Side of the blocks that surroundings are made of, in pixels.
const BLOCK: usize = 4;
/// Radius of the surroundings, as a share of the shorter side of the picture.
const SURROUNDINGS: f64 = 0.022;
/// Each pass of a box filter makes three of them more like a Gaussian.
const PASSES: usize = 3;
/// Share of light that relief adds and takes (RMS) …
const CONTRAST: f64 = 0.15;
/// … as far as it does not need to be made steeper than this for that.
const STEEPEST: f64 = 4.0;
/// Most share of light that is added or taken.
const MOST: f64 = 0.5;

/// Sum of unit normals and how many they are, of a block.
type Sum = [f32; 4];

/// Blocks of a picture.
struct Blocks {
    width: usize,
    height: usize,
    sums: Vec<Sum>,
}

impl Blocks {
    fn of(canvas: &Canvas) -> Self {
        let [width, height] = [canvas.width, canvas.height].map(|side| side.div_ceil(BLOCK));
        let sums = (0..width * height)
            .into_par_iter()
            .map(|block| {
                let [left, top] = [block % width, block / width].map(|place| place * BLOCK);
                let mut sum = [0.0; 4];
                for y in top..(top + BLOCK).min(canvas.height) {
                    let row = &canvas.pixels[y * canvas.width..][..canvas.width];
                    for pixel in row.iter().skip(left).take(BLOCK) {
                        if let Some(normal) = unit_normal(pixel) {
                            for (k, value) in normal.iter().enumerate() {
                                sum[k] += single(*value);
                            }
                            sum[3] += 1.0;
                        }
                    }
                }
                sum
            })
            .collect();
        Self {
            width,
            height,
            sums,
        }
    }

    /// Sums over the blocks up to `radius` away in a row or column (`stride` apart).
    fn box_filter(&mut self, radius: usize) {
        let (width, height) = (self.width, self.height);
        let mut filtered = vec![[0.0; 4]; self.sums.len()];
        for y in 0..height {
            slide(&self.sums, &mut filtered, y * width, 1, width, radius);
        }
        for x in 0..width {
            slide(&filtered, &mut self.sums, x, width, height, radius);
        }
    }

    /// The unit normal of what is around a pixel, between the middles of four blocks.
    fn around(&self, x: usize, y: usize) -> Option<Vector3<f64>> {
        let place = |pixel: usize, count: usize| {
            let at = ((pixel as f64 + 0.5) / BLOCK as f64 - 0.5).clamp(0.0, (count - 1) as f64);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "an index that is not negative"
            )]
            let low = at as usize;
            (low, (low + 1).min(count - 1), at - low as f64)
        };
        let (left, right, to_right) = place(x, self.width);
        let (top, bottom, down) = place(y, self.height);
        let mut normal = Vector3::zeros();
        for (column, row, weight) in [
            (left, top, (1.0 - to_right) * (1.0 - down)),
            (right, top, to_right * (1.0 - down)),
            (left, bottom, (1.0 - to_right) * down),
            (right, bottom, to_right * down),
        ] {
            let [x, y, z, _] = self.sums[row * self.width + column].map(f64::from);
            normal += Vector3::new(x, y, z) * weight;
        }
        normal.try_normalize(0.0)
    }
}

/// Sums over a window that slides along a line of `count` places, `stride` apart.
fn slide(from: &[Sum], to: &mut [Sum], first: usize, stride: usize, count: usize, radius: usize) {
    // In double precision, and back: what goes in comes out again exactly enough.
    let mut window = [0.0f64; 4];
    let add = |window: &mut [f64; 4], place: usize, sign: f64| {
        for (sum, value) in window.iter_mut().zip(from[first + place * stride]) {
            *sum += sign * f64::from(value);
        }
    };
    for place in 0..radius.min(count) {
        add(&mut window, place, 1.0);
    }
    for place in 0..count {
        if place + radius < count {
            add(&mut window, place + radius, 1.0);
        }
        if place > radius {
            add(&mut window, place - radius - 1, -1.0);
        }
        to[first + place * stride] = window.map(single);
    }
}

fn unit_normal(pixel: &Pixel) -> Option<Vector3<f64>> {
    Vector3::from(pixel.normal.map(f64::from)).try_normalize(0.0)
}

/// Strengthens the light of relief; `key` is the direction to the key light, `share` scales the effect.
pub(super) fn strengthen(canvas: &mut Canvas, key: &Vector3<f64>, share: f64) {
    let mut blocks = Blocks::of(canvas);
    let side = canvas.width.min(canvas.height) as f64;
    let radius = SURROUNDINGS * side / BLOCK as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few blocks"
    )]
    let radius = radius.round().max(1.0) as usize;
    for _ in 0..PASSES {
        blocks.box_filter(radius);
    }
    let width = canvas.width;
    let turned: Vec<f64> = (canvas.pixels.par_iter().enumerate())
        .map(|(index, pixel)| {
            let around = || blocks.around(index % width, index / width);
            match (unit_normal(pixel), pixel.coverage > 0.0) {
                (Some(normal), true) => around().map_or(f64::NAN, |n| (normal - n).dot(key)),
                _ => f64::NAN,
            }
        })
        .collect();
    let known = || turned.iter().filter(|turn| !turn.is_nan());
    let count = known().count();
    let squares: f64 = known().map(|turn| turn * turn).sum();
    if count == 0 || squares <= 0.0 {
        return;
    }
    let rms = (squares / count as f64).sqrt();
    let gain = share * (CONTRAST / rms).min(STEEPEST);
    for (pixel, turn) in canvas.pixels.iter_mut().zip(&turned) {
        if !turn.is_nan() {
            let change = gain * turn;
            let factor = single(1.0 + change / (1.0 + change.abs() / MOST));
            for light in &mut pixel.light {
                *light *= factor;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn canvas(normal: impl Fn(usize, usize) -> [f32; 3]) -> Canvas {
        let (width, height) = (83, 61);
        let pixels = (0..width * height)
            .map(|k| Pixel {
                light: [0.5; 3],
                coverage: 1.0,
                depth: 0.0,
                normal: normal(k % width, k / width),
            })
            .collect();
        Canvas {
            width,
            height,
            pixels,
        }
    }

    #[test]
    fn a_plane_keeps_its_light() {
        let mut canvas = canvas(|_, _| [0.1, 0.2, 0.9]);
        strengthen(&mut canvas, &Vector3::new(0.6, 0.0, 0.8), 1.0);
        assert!(
            canvas
                .pixels
                .iter()
                .all(|pixel| (pixel.light[0] - 0.5).abs() < 0.01)
        );
    }

    #[test]
    fn what_is_turned_to_the_light_is_lighter() {
        let mut canvas = canvas(|x, _| [if x % 8 < 4 { 0.1 } else { -0.1 }, 0.0, 1.0]);
        strengthen(&mut canvas, &Vector3::new(0.6, 0.0, 0.8), 1.0);
        let at = |x: usize| canvas.pixels[30 * 83 + x].light[0];
        assert!(at(41) > 0.54 && at(46) < 0.46, "{} {}", at(41), at(46));
    }

    #[test]
    fn sums_are_those_of_the_window() {
        let sums: Vec<Sum> = (0..7u8)
            .map(|k| [f32::from(k * k), 1.0, 0.0, 0.0])
            .collect();
        for radius in [1, 2, 6, 9] {
            let mut to = sums.clone();
            slide(&sums, &mut to, 0, 1, 7, radius);
            for (place, sum) in to.iter().enumerate() {
                let window = place.saturating_sub(radius)..(place + radius + 1).min(7);
                let expected: f32 = sums[window.clone()].iter().map(|sum| sum[0]).sum();
                assert!((sum[0] - expected).abs() < 1e-6);
                assert!((sum[1] - window.len() as f32).abs() < 1e-6);
            }
        }
    }
}
