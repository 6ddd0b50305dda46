//! Light on a surface: a key light from the upper left that rakes over the relief, a fill light from the
//! right, light from the sky, and a rim light where the surface turns away.

use nalgebra::Vector3;

use super::camera::Camera;
use super::camera::Seen;
use super::paint::Paint;
use super::rasterize::{Hit, Shaded};

/// Directions to the lights in the camera's axes (right, up, towards the camera), not normalised.
const KEY: [f64; 3] = [-0.62, 0.62, 0.55];
const FILL: [f64; 3] = [0.75, -0.05, 0.60];

/// Shares of the light that a surface gets from each where it faces it.
const KEY_LIGHT: f64 = 0.95;
const FILL_LIGHT: f64 = 0.20;
/// From above, and from below.
const SKY_LIGHT: f64 = 0.22;
const GROUND_LIGHT: f64 = 0.09;
/// Added where the surface is seen edge-on, from above.
const RIM_LIGHT: f64 = 0.16;
/// Highlight of the key light, in linear light, and its sharpness.
const HIGHLIGHT: f64 = 0.05;
const SHARPNESS: i32 = 24;

/// How much shading changes colours that stand for values.
const DATA_SHADING: f64 = 0.62;

/// What the colour of a back face is mixed with (linear light), and its share: the far side of a shell, seen
/// through a hole, is dull and reddish.
const BACK: [f64; 3] = [0.30, 0.11, 0.08];
const BACK_SHARE: f64 = 0.75;

/// Edges of a wireframe: width to either side in pixels, and what is left of the light.
const WIRE: f64 = 0.45;
const WIRE_LIGHT: f64 = 0.25;

/// Gives the light of what a sample sees.
pub(super) struct Shader<'a> {
    triangles: &'a [[u32; 3]],
    /// #V, unit, in the camera's axes.
    normals: Vec<Vector3<f64>>,
    seen: &'a [Seen],
    paint: &'a Paint,
    perspective: bool,
    key: Vector3<f64>,
    fill: Vector3<f64>,
    halfway: Vector3<f64>,
    /// Light of a surface that faces the camera.
    facing: f64,
}

impl<'a> Shader<'a> {
    /// `normals` are in the scan's axes.
    pub(super) fn new(
        triangles: &'a [[u32; 3]],
        normals: &[Vector3<f64>],
        seen: &'a [Seen],
        camera: &Camera,
        paint: &'a Paint,
    ) -> Self {
        let key = Vector3::from(KEY).normalize();
        let mut shader = Self {
            triangles,
            normals: normals.iter().map(|n| camera.frame().seen(n)).collect(),
            seen,
            paint,
            perspective: camera.is_perspective(),
            key,
            fill: Vector3::from(FILL).normalize(),
            halfway: (key + Vector3::z()).normalize(),
            facing: 1.0,
        };
        shader.facing = shader.diffuse(&Vector3::z());
        shader
    }

    /// The direction to the key light, in the camera's axes.
    pub(super) fn key(&self) -> Vector3<f64> {
        self.key
    }

    /// How much relief may be strengthened, as a share.
    pub(super) fn detail(&self) -> f64 {
        if self.paint.is_data() {
            DATA_SHADING
        } else {
            1.0
        }
    }

    pub(super) fn shade(&self, hit: &Hit) -> Shaded {
        let corners = self.triangles[hit.triangle];
        let weights = self.on_the_surface(corners, hit.weights);
        let normal = self.normal(corners, weights, hit.front);
        let mut color = self.paint.color(corners, weights);
        if !hit.front {
            for (value, back) in color.iter_mut().zip(BACK) {
                *value += BACK_SHARE * (back - *value);
            }
        }
        let mut diffuse = self.diffuse(&normal);
        let mut highlight = HIGHLIGHT * normal.dot(&self.halfway).max(0.0).powi(SHARPNESS);
        if self.paint.is_data() {
            diffuse = 1.0 + DATA_SHADING * (diffuse / self.facing - 1.0);
            highlight *= 0.5;
        }
        if hit.to_edge < WIRE {
            diffuse *= WIRE_LIGHT;
            highlight = 0.0;
        }
        Shaded {
            light: color.map(|value| value * diffuse + highlight),
            normal: normal.into(),
        }
    }

    /// Weights in space from weights on the picture: a perspective shows what is far smaller.
    fn on_the_surface(&self, corners: [u32; 3], weights: [f64; 3]) -> [f64; 3] {
        if !self.perspective {
            return weights;
        }
        let weighted = [0, 1, 2].map(|k| weights[k] * self.seen[corners[k] as usize].depth);
        let sum: f64 = weighted.iter().sum();
        weighted.map(|weight| weight / sum)
    }

    /// The unit normal on the side that is seen.
    fn normal(&self, corners: [u32; 3], weights: [f64; 3], front: bool) -> Vector3<f64> {
        let mut normal = Vector3::zeros();
        for (v, weight) in corners.iter().zip(weights) {
            normal += self.normals[*v as usize] * weight;
        }
        if !front {
            normal = -normal;
        }
        // Normals are means over several triangles: they may point away from whoever sees this one.
        normal.z = normal.z.max(0.02);
        normal.normalize()
    }

    /// Light on a surface with this normal.
    fn diffuse(&self, normal: &Vector3<f64>) -> f64 {
        let sky = 0.5 + 0.5 * normal.y;
        let edge_on = (1.0 - normal.z).powi(3);
        KEY_LIGHT * normal.dot(&self.key).max(0.0)
            + FILL_LIGHT * normal.dot(&self.fill).max(0.0)
            + GROUND_LIGHT
            + (SKY_LIGHT - GROUND_LIGHT) * sky
            + RIM_LIGHT * edge_on * sky
    }
}
