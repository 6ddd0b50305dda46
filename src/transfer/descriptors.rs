//! What is compared: values on geodesic fans, and what the shape is there.

use rayon::prelude::*;

use crate::matching::tree::distance_sq;

use super::ground::{FAN, Ground};

const RINGS: usize = FAN[0];
pub(super) const SPOKES: usize = FAN[1];

/// Rows of all vertices of a level, scaled so that squared differences add up to the cost:
/// C values at the vertex, on each ring 18 C, then K of its shape; and K gradients of these, which turn with the fan.
#[derive(Debug)]
pub(super) struct Descriptors {
    /// Number C of values.
    values: usize,
    /// Number K of features.
    features: usize,
    rows: Vec<f32>,
}

/// How much the parts count: factors of the values and features.
#[derive(Debug, Clone)]
pub(super) struct Factors {
    /// By channel.
    pub(super) values: Vec<f32>,
    /// By feature.
    pub(super) features: Vec<f32>,
    /// By feature.
    pub(super) gradients: Vec<f32>,
}

/// Weights of the vertex and of each ring all together: their sum is 1.
fn ring_weights() -> [f32; RINGS + 1] {
    // A Gaussian whose standard deviation is two rings, times the area that a ring stands for.
    let mut weights = [0.0f32; RINGS + 1];
    for (r, weight) in weights.iter_mut().enumerate() {
        let area = if r == 0 { 0.25 } else { 2.0 * r as f32 };
        *weight = area * (-((r * r) as f32) / 8.0).exp();
    }
    let sum: f32 = weights.iter().sum();
    weights.map(|w| w / sum)
}

impl Descriptors {
    /// Of values (n by C) and features (n by K) at the vertices of a level.
    pub(super) fn new(
        ground: &Ground,
        values: &[f32],
        features: &[f32],
        gradients: &[[f32; 2]],
        factors: &Factors,
    ) -> Self {
        let (of_values, of_features) = (factors.values.len(), factors.features.len());
        let mut descriptors = Self {
            values: of_values,
            features: of_features,
            rows: Vec::new(),
        };
        let (width, fan) = (descriptors.width(), descriptors.fan());
        descriptors.rows = vec![0.0; width * ground.len()];
        (descriptors.rows.par_chunks_mut(width).enumerate()).for_each(|(v, row)| {
            let (_, shape) = row.split_at_mut(fan);
            let (own, turning) = shape.split_at_mut(of_features);
            let features = &features[v * of_features..][..of_features];
            for ((out, f), factor) in own.iter_mut().zip(features).zip(&factors.features) {
                *out = f * factor;
            }
            let gradients = &gradients[v * of_features..][..of_features];
            let turning = turning.chunks_exact_mut(2);
            for ((out, g), factor) in turning.zip(gradients).zip(&factors.gradients) {
                out.copy_from_slice(&g.map(|g| g * factor));
            }
        });
        descriptors.set_values(ground, values, factors);
        descriptors
    }

    /// The same with other values.
    pub(super) fn set_values(&mut self, ground: &Ground, values: &[f32], factors: &Factors) {
        let count = self.values;
        if count == 0 {
            return;
        }
        let weights = ring_weights();
        let unknown = vec![0.0; count];
        let (width, fan) = (self.width(), self.fan());
        (self.rows.par_chunks_mut(width).enumerate()).for_each(|(v, row)| {
            let row = &mut row[..fan];
            ground.fans.read(v, values, &unknown, row);
            for (j, sample) in row.chunks_exact_mut(count).enumerate() {
                let weight = match j.checked_sub(1) {
                    None => weights[0],
                    Some(j) => weights[1 + j / SPOKES] / SPOKES as f32,
                };
                for (out, factor) in sample.iter_mut().zip(&factors.values) {
                    *out *= factor * weight.sqrt();
                }
            }
        });
    }

    fn fan(&self) -> usize {
        self.values * (1 + RINGS * SPOKES)
    }

    /// Number of entries of a row.
    pub(super) fn width(&self) -> usize {
        self.fan() + 3 * self.features
    }

    fn row(&self, v: u32) -> &[f32] {
        &self.rows[v as usize * self.width()..][..self.width()]
    }
}

/// A row that others are compared with in all rotations.
#[derive(Debug, Default)]
pub(super) struct Query {
    values: usize,
    features: usize,
    center: Vec<f32>,
    /// The rings twice around.
    rings: Vec<f32>,
    shape: Vec<f32>,
    gradients: Vec<f32>,
    gradients_sq: f32,
}

impl Query {
    pub(super) fn set(&mut self, descriptors: &Descriptors, v: u32) {
        let (c, k) = (descriptors.values, descriptors.features);
        (self.values, self.features) = (c, k);
        let row = descriptors.row(v);
        self.center.clear();
        self.center.extend_from_slice(&row[..c]);
        self.rings.clear();
        for ring in row[c..descriptors.fan()].chunks_exact(SPOKES * c.max(1)) {
            self.rings.extend_from_slice(ring);
            self.rings.extend_from_slice(ring);
        }
        let shape = &row[descriptors.fan()..];
        self.shape.clear();
        self.shape.extend_from_slice(&shape[..k]);
        self.gradients.clear();
        self.gradients.extend_from_slice(&shape[k..]);
        self.gradients_sq = self.gradients.iter().map(|g| g * g).sum();
    }

    /// What comparing with a row in any rotation has in common, and how the shape's part follows from the rotation:
    /// sum − 2 Re(e^{iρ} turning).
    #[inline(always)]
    fn shape_with(&self, shape: &[f32]) -> (f32, [f32; 2]) {
        let (own, gradients) = shape.split_at(self.features);
        let mut sum = distance_sq(&self.shape, own) + self.gradients_sq;
        let mut turning = [0.0f32; 2];
        let pairs = (self.gradients.as_chunks::<2>().0.iter()).zip(gradients.as_chunks::<2>().0);
        for ([tx, ty], [sx, sy]) in pairs {
            sum += sx * sx + sy * sy;
            // Of the target's times the conjugate of the source's.
            turning[0] += tx * sx + ty * sy;
            turning[1] += ty * sx - tx * sy;
        }
        (sum, turning)
    }

    /// The cost of a vertex in one rotation, or what is above `limit` if it is.
    #[inline(always)]
    pub(super) fn cost(&self, others: &Descriptors, source: u32, turn: usize, limit: f32) -> f32 {
        let row = others.row(source);
        let (values, shape) = row.split_at(others.fan());
        let (sum, turning) = self.shape_with(shape);
        let (center, rings) = values.split_at(self.values);
        let common = sum + distance_sq(&self.center, center);
        self.turned(rings, common, turning, turn, limit)
    }

    /// The rotation in which a vertex costs least, and the cost; above `limit` if all do.
    #[inline(always)]
    pub(super) fn best(&self, others: &Descriptors, source: u32, limit: f32) -> (usize, f32) {
        let row = others.row(source);
        let (values, shape) = row.split_at(others.fan());
        let (sum, turning) = self.shape_with(shape);
        let (center, rings) = values.split_at(self.values);
        let common = sum + distance_sq(&self.center, center);
        let most = 2.0 * (turning[0] * turning[0] + turning[1] * turning[1]).sqrt();
        let mut best = (0, f32::INFINITY);
        if common - most >= limit {
            return best;
        }
        for turn in 0..SPOKES {
            let cost = self.turned(rings, common, turning, turn, limit.min(best.1));
            if cost < best.1 {
                best = (turn, cost);
            }
        }
        best
    }

    #[inline(always)]
    fn turned(
        &self,
        rings: &[f32],
        common: f32,
        [re, im]: [f32; 2],
        turn: usize,
        limit: f32,
    ) -> f32 {
        let [cos, sin] = TURNS[turn];
        let mut cost = (common - 2.0 * (cos * re - sin * im)).max(0.0);
        let length = SPOKES * self.values;
        if length == 0 {
            return cost;
        }
        let shift = (SPOKES - turn) % SPOKES * self.values;
        // Where the rings are longest, most is to be lost.
        for (ring, own) in (rings.chunks_exact(length))
            .zip(self.rings.chunks_exact(2 * length))
            .rev()
        {
            if cost >= limit {
                return cost;
            }
            cost += distance_sq(&own[shift..][..length], ring);
        }
        cost
    }
}

/// Cosines and sines of the rotations.
static TURNS: std::sync::LazyLock<[[f32; 2]; SPOKES]> = std::sync::LazyLock::new(|| {
    std::array::from_fn(|turn| {
        let (sin, cos) = angle_of(turn).sin_cos();
        [cos, sin]
    })
});

/// The angle of a rotation.
pub(super) fn angle_of(turn: usize) -> f32 {
    std::f32::consts::TAU * turn as f32 / SPOKES as f32
}

/// The rotation nearest to an angle.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "from 0 to the number of spokes"
)]
pub(super) fn turn_of(angle: f32) -> usize {
    let turns = (angle / std::f32::consts::TAU).rem_euclid(1.0) * SPOKES as f32;
    turns.round() as usize % SPOKES
}

/// How features (n by K) grow around each vertex, per spacing: from the second ring of its fan.
pub(super) fn gradients(ground: &Ground, features: &[f32], count: usize) -> Vec<[f32; 2]> {
    const RING: usize = 2;
    let unknown = vec![0.0; count];
    let mut all = vec![[0.0; 2]; ground.len() * count];
    if count == 0 {
        return all;
    }
    (all.par_chunks_mut(count).enumerate()).for_each_init(
        || vec![0.0; ground.fans.offsets() * count],
        |fan, (v, out)| {
            ground.fans.read(v, features, &unknown, fan);
            let ring = &fan[(1 + (RING - 1) * SPOKES) * count..][..SPOKES * count];
            for (spoke, values) in ring.chunks_exact(count).enumerate() {
                let [cos, sin] = TURNS[spoke].map(|x| x * 2.0 / (SPOKES * RING) as f32);
                for (out, value) in out.iter_mut().zip(values) {
                    out[0] += cos * value;
                    out[1] += sin * value;
                }
            }
        },
    );
    all
}

#[cfg(test)]
mod tests;
