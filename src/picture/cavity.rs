//! Shade in what lies deeper than its surroundings, by the depths of the picture: dimples, joints and
//! grooves are readable from any side of the light.
//!
//! # Reference
//! The obscurance estimator of M. `McGuire`, B. Osman, M. Bukowski, P. Hennessy: "The Alchemy screen-space
//! ambient obscurance algorithm", High Performance Graphics 2011. Its sample positions are turned by a
//! fixed pattern of 3 by 3 pixels instead of random numbers, and averaged over such a pattern.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::camera::Camera;
use super::canvas::{Canvas, single};

/// Places looked at around a pixel.
const PLACES: usize = 14;
/// Distance of the nearest and of the farthest one; the latter as a share of the shorter side of the picture.
const NEAREST: f64 = 1.5;
const FARTHEST: f64 = 0.03;
/// Sine of the angle over the tangent plane from which on a place takes light away: less is the noise of
/// normals and depths.
const LEAST_ANGLE: f64 = 0.05;
/// Places count up to this many times their distance on the picture: beyond, something else is in front.
const REACH: f64 = 2.5;
/// From the mean obscurance to the share of light that is lost.
const STRENGTH: f64 = 2.2;
/// Most light that is lost.
const DARKEST: f64 = 0.6;
/// Side of the pattern.
const PATTERN: usize = 3;
/// Angle between one place and the next: the golden angle.
const TURN: f64 = 2.399_963_229_728_653;

/// Takes light from cavities.
pub(super) fn darken(canvas: &mut Canvas, camera: &Camera) {
    let offsets = offsets(canvas);
    let width = canvas.width;
    let lost: Vec<f32> = (0..canvas.pixels.len())
        .into_par_iter()
        .with_min_len(width)
        .map(|index| {
            let [x, y] = [index % width, index / width];
            let turn = x % PATTERN + PATTERN * (y % PATTERN);
            single(obscurance(canvas, camera, x, y, &offsets[turn]))
        })
        .collect();
    let height = canvas.height;
    let rows = canvas.pixels.par_chunks_mut(width).enumerate();
    rows.for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            if pixel.coverage <= 0.0 {
                continue;
            }
            let (mut sum, mut count) = (0.0, 0.0);
            for y in y.saturating_sub(1)..(y + 2).min(height) {
                for x in x.saturating_sub(1)..(x + 2).min(width) {
                    let lost = lost[y * width + x];
                    if !lost.is_nan() {
                        sum += lost;
                        count += 1.0;
                    }
                }
            }
            if count > 0.0 {
                let left = 1.0 - (single(STRENGTH) * sum / count).min(single(DARKEST));
                for light in &mut pixel.light {
                    *light *= left;
                }
            }
        }
    });
}

/// Where places are, in pixels, for each of the pattern's turns.
fn offsets(canvas: &Canvas) -> Vec<Vec<[isize; 2]>> {
    let farthest = (FARTHEST * canvas.width.min(canvas.height) as f64).max(2.0 * NEAREST);
    let turns = PATTERN * PATTERN;
    (0..turns)
        .map(|turn| {
            (0..PLACES)
                .map(|place| {
                    // Turns lie between the places' own distances, too.
                    let share = (place as f64 + turn as f64 / turns as f64) / PLACES as f64;
                    let radius = NEAREST * (farthest / NEAREST).powf(share);
                    let angle = TURN * (place * turns + turn) as f64;
                    #[expect(clippy::cast_possible_truncation, reason = "a few pixels")]
                    let pixels = |x: f64| x.round() as isize;
                    [pixels(radius * angle.cos()), pixels(radius * angle.sin())]
                })
                .collect()
        })
        .collect()
}

/// Mean share of the light from around that does not reach a pixel; NaN where nothing is.
fn obscurance(canvas: &Canvas, camera: &Camera, x: usize, y: usize, offsets: &[[isize; 2]]) -> f64 {
    let pixel = &canvas.pixels[y * canvas.width + x];
    if pixel.depth.is_nan() {
        return f64::NAN;
    }
    let point = |x: usize, y: usize, depth: f32| {
        camera.behind(x as f64 + 0.5, y as f64 + 0.5, f64::from(depth))
    };
    let normal = Vector3::from(pixel.normal.map(f64::from)).normalize();
    let here = point(x, y, pixel.depth);
    let unit = camera.pixels_a_unit(f64::from(pixel.depth));
    let mut sum = 0.0;
    for &[right, down] in offsets {
        let [Some(column), Some(row)] = [x.checked_add_signed(right), y.checked_add_signed(down)]
        else {
            continue;
        };
        if column >= canvas.width || row >= canvas.height {
            continue;
        }
        let there = canvas.pixels[row * canvas.width + column].depth;
        if there.is_nan() {
            continue;
        }
        let way = point(column, row, there) - here;
        let length = way.norm();
        let reach = REACH * (right as f64).hypot(down as f64) / unit;
        let near = 1.0 - (length / reach).powi(2);
        if near > 0.0 {
            sum += near * (way.dot(&normal) / length - LEAST_ANGLE).max(0.0);
        }
    }
    sum / offsets.len() as f64
}
