//! The distribution of the Laplacian: what noise, blur and fading change first.

use super::distance::wasserstein;
use super::field::{Field, Quantity, Split};
use super::{Figure, Measure};

/// Wasserstein distance of the Laplacians of a piece and of the known part, over the mean magnitude there.
pub(super) fn figure(field: &Field, quantity: &Quantity, split: &Split) -> Figure {
    Figure {
        measure: Measure::Laplacian,
        name: quantity.named("laplacian"),
        value: distance(field, quantity, &split.in_inner, &split.in_reference),
    }
}

/// The distance for any two parts.
pub(super) fn distance(
    field: &Field,
    quantity: &Quantity,
    part: &[bool],
    reference: &[bool],
) -> Option<f64> {
    let weight = |of: &[bool], v: u32| {
        if of[v as usize] {
            field.areas[v as usize]
        } else {
            0.0
        }
    };
    let items = (quantity.by_laplacian.iter()).map(|v| {
        (
            quantity.laplacian(*v),
            weight(part, *v),
            weight(reference, *v),
        )
    });
    let (sum, total) = items
        .clone()
        .fold((0.0, 0.0), |(sum, total), (value, _, w)| {
            (sum + w * value.abs(), total + w)
        });
    (sum > 0.0)
        .then(|| wasserstein(items))?
        .map(|distance| distance * total / sum)
}
