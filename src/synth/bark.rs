//! Tree trunk: long, irregular plates along the axis, parted by grooves.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2, Vector3};

use super::fractal::{ValueNoise, blend, smooth_step};
use super::tessellate::{self, rounded};
use super::{Draw, Object, stream};
use crate::rng::Rng;

/// Radius of the trunk, in mm.
const RADIUS: f64 = 150.0;
/// Its height, in mm; about its circumference, so that a hole of half the wall still fits.
const HEIGHT: f64 = 930.0;
/// Number of plates around the trunk.
const AROUND: usize = 15;
/// Length of a plate in units of its width.
const ELONGATION: f64 = 3.6;
/// Depth of the deepest grooves under the ridges, in mm.
const DEPTH: f64 = 16.0;
/// Height of the fine roughness, in mm.
const ROUGHNESS: f64 = 2.6;
const GROOVE_COLOR: [f64; 3] = [42.0, 30.0, 22.0];
const RIDGE_COLOR: [f64; 3] = [164.0, 142.0, 118.0];

pub(super) fn object(vertices: usize, seed: u32) -> Object {
    let mut rng = stream(seed, Draw::Jitter);
    let tessellation = tessellate::cylinder(RADIUS, HEIGHT, vertices, &mut rng);
    let bark = Bark::new(&mut stream(seed, Draw::Relief));
    let (heights, colors) = tessellation
        .wall
        .iter()
        .zip(&tessellation.feet)
        .map(|(wall, foot)| bark.at(*wall, foot.coords))
        .unzip();
    Object {
        tessellation,
        heights,
        colors,
    }
}

/// A plate: the part of the wall nearer to its seed than to any other's.
#[derive(Debug, Clone, Copy)]
struct Plate {
    /// Seed within its cell of the wall, in cells.
    offset: Vector2<f64>,
    /// Height over the mean plate, in units of the depth.
    height: f64,
    /// Brightness of its colour.
    brightness: f64,
}

#[derive(Debug)]
struct Bark {
    /// Width and length of a cell of the wall, in mm.
    cell: Vector2<f64>,
    /// Row by row; `AROUND` each; the first row is below the wall.
    plates: Vec<Plate>,
    noise: ValueNoise,
}

impl Bark {
    fn new(rng: &mut Rng) -> Self {
        let width = TAU * RADIUS / AROUND as f64;
        let cell = Vector2::new(width, width * ELONGATION);
        let rows = rounded(HEIGHT / cell.y) + 5;
        let plates = (0..rows * AROUND)
            .map(|_| Plate {
                offset: Vector2::new(0.5 + 0.7 * (rng.uniform() - 0.5), rng.uniform()),
                height: 0.3 * (rng.uniform() - 0.5),
                brightness: 0.86 + 0.28 * rng.uniform(),
            })
            .collect();
        Self {
            cell,
            plates,
            noise: ValueNoise::new(rng),
        }
    }

    /// Height and colour at a place of the wall; `foot` is the same place in space, where noise has
    /// no seam.
    fn at(&self, wall: Point2<f64>, foot: Vector3<f64>) -> (f64, [u8; 3]) {
        let width = self.cell.x;
        let stretched = |size: f64, stretch: f64| {
            Vector3::new(foot.x / size, foot.y / size, foot.z / (size * stretch))
        };
        // Grooves meander: slowly as a whole, and in small wriggles.
        let meander = Vector2::new(
            0.55 * self.noise.fractal(stretched(1.6 * width, 1.8), 3),
            0.8 * self
                .noise
                .fractal(stretched(width, 1.0).add_scalar(57.0), 3),
        ) * width;
        let (plate, groove, across) = self.nearest(wall + meander);

        // Breaks across the grain are shallower than the grooves along it, and differ.
        let varied = self.noise.at(stretched(1.5 * width, 1.0).add_scalar(23.0));
        let bottom = 1.0 - (0.45 + 0.3 * varied) * smooth_step(0.3, 0.9, across);
        // Steep beside the groove, then gently up to the ridge; round at the bottom, else the
        // lattice cuts steps into it.
        let wall = smooth_step(0.0, 0.3 * width, groove);
        let slope = 0.6 * wall + 0.4 * smooth_step(0.0, 0.5 * width, groove);
        let ridge = 1.0 - bottom * (1.0 - slope);
        let rough = self.noise.fractal(stretched(0.22 * width, 3.0), 3);
        let level = ridge + plate.height * slope;
        let height = DEPTH * level + ROUGHNESS * rough;

        let depth = smooth_step(0.1, 1.05, level + 0.12 * rough);
        let grain = self.noise.at(stretched(0.12 * width, 2.0).add_scalar(91.0));
        let brightness = plate.brightness * (1.0 + 0.12 * grain);
        (height, blend(GROOVE_COLOR, RIDGE_COLOR, depth, brightness))
    }

    /// The plate at a place, its distance to the next plate's border in mm, and how much that
    /// border runs across the axis (0: along it, 1: across).
    fn nearest(&self, place: Point2<f64>) -> (Plate, f64, f64) {
        let (x, y) = (place.x / self.cell.x, place.y / self.cell.y + 2.0);
        let mut found: Vec<(f64, Vector2<f64>, Plate)> = Vec::with_capacity(25);
        let rows = self.plates.len() / AROUND;
        for row in neighborhood(y) {
            for column in neighborhood(x) {
                let inside = row.clamp(0.0, (rows - 1) as f64);
                let around = column.rem_euclid(AROUND as f64);
                let plate = self.plates[rounded(inside) * AROUND + rounded(around) % AROUND];
                // Every other column half a plate up, as bricks are: else breaks line up.
                let stagger = 0.5 * around.rem_euclid(2.0);
                let seed = plate.offset + Vector2::new(column, row + stagger);
                let from = seed - Vector2::new(x, y);
                found.push((from.norm_squared(), from, plate));
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (nearest_sq, nearest, plate) = found[0];
        // Distance to the bisector with each rival, back in mm: the difference of squared
        // distances over the length of its gradient.
        let rivals: Vec<(f64, f64)> = found[1..]
            .iter()
            .map(|(distance_sq, from, _)| {
                let apart = (from - nearest).component_div(&self.cell);
                let distance = 0.5 * (distance_sq - nearest_sq) / apart.norm();
                (distance, apart.y.abs() / apart.norm())
            })
            .collect();
        let groove = rivals.iter().map(|r| r.0).fold(f64::INFINITY, f64::min);
        // A mean over the borders about as near, else the relief jumps where they meet.
        let (mut mean, mut weights) = (0.0, 0.0);
        for (distance, across) in rivals {
            let weight = ((groove - distance) / (0.08 * self.cell.x)).exp();
            mean += weight * across;
            weights += weight;
        }
        (plate, groove, mean / weights)
    }
}

/// The whole numbers next to `floor(x)`, two on either side.
fn neighborhood(x: f64) -> impl Iterator<Item = f64> {
    (-2..=2).map(move |d| x.floor() + f64::from(d))
}
