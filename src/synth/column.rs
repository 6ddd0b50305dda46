//! Round column with rows of arched niches, a moulding around each and a band between the rows.

use std::f64::consts::{PI, TAU};

use nalgebra::Point2;

use super::fractal::smooth_step;
use super::{Draw, Object, stream, tessellate};

/// Radius, in mm.
const RADIUS: f64 = 200.0;
/// Height, in mm; about the circumference, so that a hole of half the wall still fits.
const HEIGHT: f64 = 1230.0;
/// Niches in a row.
const AROUND: f64 = 8.0;
/// Rows of niches.
const ROWS: f64 = 3.0;
/// Half the width of a niche, as a share of the width it stands in.
const HALF_WIDTH: f64 = 0.3;
/// Sill and top of a niche, as shares of the row's height.
const SILL: f64 = 0.14;
const TOP: f64 = 0.86;
/// Depth of a niche behind the wall, in mm, at its sides and further at its middle.
const SIDE_DEPTH: f64 = 12.0;
const MIDDLE_DEPTH: f64 = 10.0;
/// Width of the wall's fall into the niche, in mm.
const FALL: f64 = 20.0;
/// Width and height of the moulding around a niche, in mm.
const MOULDING: [f64; 2] = [22.0, 5.0];
/// Half the height of the band between rows, and how far it stands out, in mm.
const BAND: [f64; 2] = [26.0, 10.0];

pub(super) fn object(vertices: usize, seed: u32) -> Object {
    let mut rng = stream(seed, Draw::Jitter);
    let tessellation = tessellate::cylinder(RADIUS, HEIGHT, vertices, &mut rng);
    Object {
        heights: tessellation.wall.iter().map(height).collect(),
        tessellation,
        colors: Vec::new(),
    }
}

/// Height of the relief at a place of the unrolled wall.
fn height(wall: &Point2<f64>) -> f64 {
    let (width, row) = (TAU * RADIUS / AROUND, HEIGHT / ROWS);
    let x = wall.x.rem_euclid(width) - 0.5 * width;
    let y = wall.y.rem_euclid(row);

    let half = HALF_WIDTH * width;
    let spring = TOP * row - half;
    // Distance inside the arch's outline, in mm; negative outside.
    let inside = if y > spring {
        half - x.hypot(y - spring)
    } else {
        (half - x.abs()).min(y - SILL * row)
    };
    let niche = if inside > 0.0 {
        let middle = (1.0 - (x / half).powi(2)).max(0.0);
        smooth_step(0.0, FALL, inside) * (SIDE_DEPTH + MIDDLE_DEPTH * middle)
    } else {
        0.0
    };
    let moulding = bump((inside + 0.5 * MOULDING[0]) / (0.5 * MOULDING[0])) * MOULDING[1];
    let band = bump(y.min(row - y) / BAND[0]) * BAND[1];
    moulding + band - niche
}

/// Round bump of height 1 over [-1, 1].
fn bump(x: f64) -> f64 {
    if x.abs() < 1.0 {
        0.5 + 0.5 * (PI * x).cos()
    } else {
        0.0
    }
}
