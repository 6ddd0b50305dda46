//! From heights and colours to channels whose squared differences add up to a cost.

use serde::{Deserialize, Serialize};

use super::growth::Canvas;

/// Makes channels whose squared differences add up to a cost in [0, 1].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Scale {
    /// Height that becomes 0.
    pub(super) middle: f64,
    pub(super) height: f64,
    /// 0 where colours have no say.
    pub(super) color: f64,
}

impl Scale {
    /// Shares of shape and colour as in the paper's metric: over the square of the range of heights,
    /// and over 3, the largest squared distance of two colours.
    pub(super) fn new(canvas: &Canvas, samples: &[bool], mu: f64) -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let [low, high] = (canvas.relief.heights.iter().zip(samples))
            .filter(|(_, is)| **is)
            .fold(none, |[low, high], (h, _)| [low.min(*h), high.max(*h)]);
        let mu = if canvas.colors.is_some() { mu } else { 0.0 };
        let range = high - low;
        Self {
            middle: 0.5 * (low + high),
            height: if range > 0.0 {
                (1.0 - mu).sqrt() / range
            } else {
                0.0
            },
            color: (mu / 3.0).sqrt(),
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        [self.middle, self.height, self.color]
            .iter()
            .all(|x| x.is_finite())
    }

    /// Number of channels.
    pub(super) fn count(&self) -> usize {
        if self.color > 0.0 { 4 } else { 1 }
    }

    /// Height and, where they have a say, colours of a vertex.
    #[expect(clippy::cast_possible_truncation, reason = "channels are single")]
    pub(super) fn channels(&self, canvas: &Canvas, v: usize) -> [f32; 4] {
        let height = (canvas.relief.heights[v] - self.middle) * self.height;
        match &canvas.colors {
            Some(colors) if self.color > 0.0 => {
                let [r, g, b] = colors[v].map(|c| (c * self.color) as f32);
                [height as f32, r, g, b]
            }
            _ => [height as f32, 0.0, 0.0, 0.0],
        }
    }
}
