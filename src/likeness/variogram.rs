//! The variogram: how much values differ by direction and distance.

use super::distance::log_ratio;
use super::field::{Field, Quantity, Split};
use super::readings::{DIRECTIONS, LAGS};
use super::{Figure, Measure};

/// Number of figures of a variogram.
const SIZE: usize = DIRECTIONS * LAGS.len();

/// Mean squared differences, by direction and then lag; NaN where there are none.
pub(super) type Variogram = [f64; SIZE];

/// Of a piece off its seam, and of the known part.
#[derive(Debug)]
pub(super) struct Both {
    pub(super) piece: Variogram,
    pub(super) reference: Variogram,
}

impl Both {
    pub(super) fn new(field: &Field, quantity: &Quantity, split: &Split) -> Self {
        Self {
            piece: of_part(field, quantity, split.inner.iter().copied()),
            reference: of_part(field, quantity, split.reference()),
        }
    }
}

/// Root mean square of |ln(γ/γ′)| over all directions and lags from 1 to 32 median edges, γ of the piece,
/// γ′ of the known part.
pub(super) fn figure(quantity: &Quantity, of_both: &Both) -> Figure {
    let (mut sum, mut count) = (0.0, 0.0);
    for (a, b) in of_both.piece.iter().zip(&of_both.reference) {
        if let Some(distance) = log_ratio(*a, *b) {
            sum += distance * distance;
            count += 1.0;
        }
    }
    Figure {
        measure: Measure::Variogram,
        name: quantity.named("variogram"),
        value: (count > 0.0).then(|| f64::sqrt(sum / count)),
    }
}

/// The variogram of a part: differences from its vertices to whatever lies at a distance.
pub(super) fn of_part(
    field: &Field,
    quantity: &Quantity,
    part: impl Iterator<Item = u32>,
) -> Variogram {
    let (mut sums, mut weights) = ([0.0; SIZE], [0.0; SIZE]);
    for v in part {
        let area = field.areas[v as usize];
        let increments = &quantity.readings[v as usize].increments;
        for ((sum, weight), increment) in sums.iter_mut().zip(&mut weights).zip(increments) {
            if !increment.is_nan() {
                *sum += area * f64::from(*increment);
                *weight += area;
            }
        }
    }
    for (sum, weight) in sums.iter_mut().zip(weights) {
        *sum /= weight;
    }
    sums
}
