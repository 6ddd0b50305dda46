//! Colour: the measures of height on L\*, a\*, b\*, and how colour goes with height.

use super::distance::wasserstein;
use super::field::{Field, Quantity, Split};
use super::{Figure, Measure, areal, classifier, laplacian, seam, variogram};

/// Correlations are taken as far from ±1 as this: where colour follows from height the transform below
/// would be infinite.
const MOST_CORRELATION: f64 = 0.999;

/// L\*, a\*, b\* by vertex.
pub(super) fn quantities(colors: &[[f64; 3]]) -> [(&'static str, Vec<f64>); 3] {
    let lab: Vec<[f64; 3]> = colors.iter().map(|color| to_lab(*color)).collect();
    let column = |i: usize| lab.iter().map(|lab| lab[i]).collect();
    [("L* ", column(0)), ("a* ", column(1)), ("b* ", column(2))]
}

/// All figures of colour.
pub(super) fn figures(field: &Field, split: &Split) -> Vec<Figure> {
    let colors = &field.quantities[1..];
    let mut figures = Vec::new();
    for quantity in colors {
        figures.push(histogram(field, quantity, split));
        figures.push(laplacian::figure(field, quantity, split));
        let variograms = variogram::Both::new(field, quantity, split);
        figures.push(variogram::figure(quantity, &variograms));
        // A mean integral has no meaning without a base; the histogram has the mean.
        let areal = areal::figures(field, quantity, split, &variograms);
        let areal = areal.into_iter().skip(1);
        figures.extend(areal);
        let [laplacian, _] = seam::figures(field, quantity, split);
        figures.push(laplacian);
    }
    figures.push(classifier::figure(field, colors, split));
    figures.push(Figure {
        measure: Measure::Color,
        name: "height-lightness correlation".to_owned(),
        value: correlation_distance(field, split),
    });
    for figure in &mut figures {
        figure.measure = Measure::Color;
    }
    figures
}

/// Wasserstein distance of the values themselves, over their standard deviation in the known part.
fn histogram(field: &Field, quantity: &Quantity, split: &Split) -> Figure {
    let weight = |of: &[bool], v: u32| {
        if of[v as usize] {
            field.areas[v as usize]
        } else {
            0.0
        }
    };
    let items = (quantity.by_value.iter()).map(|v| {
        (
            quantity.values[*v as usize],
            weight(&split.in_inner, *v),
            weight(&split.in_reference, *v),
        )
    });
    let scale = areal::deviation(field, quantity, split.reference());
    Figure {
        measure: Measure::Color,
        name: quantity.named("histogram"),
        value: (scale.filter(|scale| *scale > 0.0))
            .and_then(|scale| Some(wasserstein(items)? / scale)),
    }
}

/// Difference of the correlations of height and lightness, each as z = artanh(r) (Fisher), in which equal
/// differences are about equally likely whatever r is.
fn correlation_distance(field: &Field, split: &Split) -> Option<f64> {
    let z = |part: &mut dyn Iterator<Item = u32>| {
        let r = correlation(field, &field.quantities[0], &field.quantities[1], part)?;
        Some(r.clamp(-MOST_CORRELATION, MOST_CORRELATION).atanh())
    };
    // A piece without relief or shades has nothing that goes together.
    let of_piece = z(&mut split.inner.iter().copied()).unwrap_or(0.0);
    Some((of_piece - z(&mut split.reference())?).abs())
}

fn correlation(
    field: &Field,
    a: &Quantity,
    b: &Quantity,
    part: &mut dyn Iterator<Item = u32>,
) -> Option<f64> {
    let items: Vec<[f64; 3]> = part
        .map(|v| v as usize)
        .filter(|v| field.areas[*v] > 0.0)
        .map(|v| [field.areas[v], a.values[v], b.values[v]])
        .collect();
    let total: f64 = items.iter().map(|[w, ..]| w).sum();
    let mean = |i: usize| items.iter().map(|item| item[0] * item[i]).sum::<f64>() / total;
    let means = [0.0, mean(1), mean(2)];
    let moment = |i: usize, j: usize| -> f64 {
        (items.iter())
            .map(|item| item[0] * (item[i] - means[i]) * (item[j] - means[j]))
            .sum()
    };
    let scale = (moment(1, 1) * moment(2, 2)).sqrt();
    (scale > 0.0).then(|| moment(1, 2) / scale)
}

/// Lightness L\* of an sRGB colour with intensities from 0 to 1; 0 to 100.
pub(crate) fn lightness(color: [f64; 3]) -> f64 {
    to_lab(color)[0]
}

/// CIE L\*a\*b\* (white point D65) of an sRGB colour with intensities from 0 to 1.
///
/// # Reference
/// IEC 61966-2-1 (sRGB), CIE 15:2004 (L\*a\*b\*).
fn to_lab(color: [f64; 3]) -> [f64; 3] {
    let linear = color.map(|c| {
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    });
    let row = |weights: [f64; 3], white: f64| {
        let sum: f64 = weights.iter().zip(linear).map(|(w, c)| w * c).sum();
        let t = sum / white;
        let limit: f64 = 6.0 / 29.0;
        if t > limit.powi(3) {
            t.cbrt()
        } else {
            t / (3.0 * limit * limit) + 4.0 / 29.0
        }
    };
    let x = row([0.412_456, 0.357_576, 0.180_438], 0.950_470);
    let y = row([0.212_673, 0.715_152, 0.072_175], 1.0);
    let z = row([0.019_334, 0.119_192, 0.950_304], 1.088_830);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn colours_have_their_published_coordinates() {
        // B. Lindbloom's calculator, sRGB, D65.
        let known = [
            ([1.0, 1.0, 1.0], [100.0, 0.0, 0.0]),
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            ([1.0, 0.0, 0.0], [53.24, 80.09, 67.20]),
            ([0.0, 0.0, 1.0], [32.30, 79.19, -107.86]),
            ([0.5, 0.5, 0.5], [53.39, 0.0, 0.0]),
        ];
        for (color, lab) in known {
            for (found, expected) in to_lab(color).into_iter().zip(lab) {
                assert_relative_eq!(found, expected, epsilon = 0.02);
            }
        }
    }
}
