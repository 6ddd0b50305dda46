//! Wall of bricks in running bond: every course shifted by half a brick.

use nalgebra::{Point2, Vector2, Vector3};

use super::fractal::{ValueNoise, blend, smooth_step};
use super::tessellate::{self, rounded};
use super::{Draw, Object, stream};
use crate::rng::Rng;

/// Size of a brick with half a joint on every side, in mm.
const CELL: [f64; 2] = [225.0, 75.0];
/// Bricks a course, and courses.
const COUNT: [usize; 2] = [4, 10];
/// Width of a joint, in mm: wide and weathered.
const JOINT: f64 = 17.0;
/// Radius of a brick's corners in the wall, in mm.
const CORNER: f64 = 8.0;
/// Width of a brick's rounded edge, in mm.
const EDGE: f64 = 9.0;
/// Depth of the joints behind the mean brick, in mm.
const DEPTH: f64 = 9.0;
/// Largest height of a brick over the mean one, and of its ends by tilt, in mm.
const UNEVEN: f64 = 1.4;
const TILT: f64 = 0.8;
/// Height of the roughness of bricks and mortar, in mm.
const ROUGHNESS: f64 = 0.7;
const MORTAR_COLOR: [f64; 3] = [168.0, 164.0, 156.0];
/// Between these two is the colour of every brick.
const RED: [f64; 3] = [172.0, 78.0, 56.0];
const BROWN: [f64; 3] = [118.0, 58.0, 44.0];

pub(super) fn object(vertices: usize, seed: u32) -> Object {
    let extent = Vector2::new(CELL[0] * COUNT[0] as f64, CELL[1] * COUNT[1] as f64);
    let mut rng = stream(seed, Draw::Jitter);
    let tessellation = tessellate::plane(extent, vertices, &mut rng);
    let wall = Wall::new(&mut stream(seed, Draw::Relief));
    let (heights, colors) = tessellation.wall.iter().map(|w| wall.at(*w)).unzip();
    Object {
        tessellation,
        heights,
        colors,
    }
}

#[derive(Debug, Clone, Copy)]
struct Brick {
    /// Height over the mean brick, in mm.
    height: f64,
    /// Height of its right and its upper end over its middle, in mm.
    tilt: Vector2<f64>,
    /// Its middle's distance from where it should be, in mm.
    shift: Vector2<f64>,
    color: [f64; 3],
}

#[derive(Debug)]
struct Wall {
    /// Course by course; one more a course than fit, for the shifted ones.
    bricks: Vec<Brick>,
    noise: ValueNoise,
}

impl Wall {
    fn new(rng: &mut Rng) -> Self {
        let mut spread = |size: f64| size * (2.0 * rng.uniform() - 1.0);
        let bricks = (0..(COUNT[0] + 1) * COUNT[1])
            .map(|_| {
                let (height, right, up) = (spread(UNEVEN), spread(TILT), spread(TILT));
                let (x, y) = (spread(2.0), spread(1.5));
                let (red, bright) = (0.5 + spread(0.5), 1.0 + spread(0.1));
                Brick {
                    height,
                    tilt: Vector2::new(right, up),
                    shift: Vector2::new(x, y),
                    color: std::array::from_fn(|i| bright * (BROWN[i] + red * (RED[i] - BROWN[i]))),
                }
            })
            .collect();
        Self {
            bricks,
            noise: ValueNoise::new(rng),
        }
    }

    /// Height and colour at a place of the wall.
    fn at(&self, place: Point2<f64>) -> (f64, [u8; 3]) {
        let noise = |size: f64, shift: f64, octaves: u32| {
            let p = Vector3::new(place.x, place.y, 0.0) / size;
            self.noise.fractal(p.add_scalar(shift), octaves)
        };
        let course = (place.y / CELL[1])
            .floor()
            .clamp(0.0, COUNT[1] as f64 - 1.0);
        let shifted = place.x / CELL[0] + 0.5 * course.rem_euclid(2.0);
        let number = shifted.floor().clamp(0.0, COUNT[0] as f64);
        let brick = self.bricks[rounded(course) * (COUNT[0] + 1) + rounded(number)];
        let local = Vector2::new(
            (shifted - number - 0.5) * CELL[0],
            place.y - (course + 0.5) * CELL[1],
        ) - brick.shift;

        // Distance inside the brick's rounded outline, in mm; chipped a little.
        let half = Vector2::new(CELL[0] - JOINT, CELL[1] - JOINT) * 0.5;
        let beyond = local.abs() - half.add_scalar(-CORNER);
        let outside = beyond.sup(&Vector2::zeros()).norm() + beyond.max().min(0.0) - CORNER;
        let inside = 1.6 * noise(22.0, 0.0, 2) - outside;

        let face = brick.height + brick.tilt.dot(&local.component_div(&half));
        let is_brick = smooth_step(-0.3 * EDGE, 0.7 * EDGE, inside);
        let rough = noise(14.0, 41.0, 3);
        let mortar = -DEPTH + 1.2 * noise(40.0, 83.0, 2);
        let height = mortar + is_brick * (face - mortar) + ROUGHNESS * rough;

        let colored = smooth_step(-0.3 * EDGE, 0.2 * EDGE, inside);
        let brightness = 1.0 + 0.1 * rough + 0.06 * noise(6.0, 17.0, 1);
        (
            height,
            blend(MORTAR_COLOR, brick.color, colored, brightness),
        )
    }
}
