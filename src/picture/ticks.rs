//! Round numbers for the color bar.

/// Numbers between the ends of a range at a distance of 1, 2 or 5 times a power of ten, with their text: at
/// most `most` of them, and at least one.
pub(super) fn ticks([low, high]: [f64; 2], most: usize) -> Vec<(f64, String)> {
    let span = high - low;
    let rough = span / most.max(2) as f64;
    let power = rough.log10().floor();
    let unit = 10f64.powf(power);
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * unit)
        .find(|step| *step >= rough)
        .unwrap_or(10.0 * unit);
    // Rounding must not lose a tick at an end.
    let slack = 1e-9 * span;
    let first = ((low - slack) / step).ceil();
    let numbers = (0u32..)
        .map(|k| (first + f64::from(k)) * step)
        .take_while(|value| *value <= high + slack)
        .take(most + 1);
    let largest = low.abs().max(high.abs());
    numbers
        .map(|value| (value, written(value, step, largest)))
        .collect()
}

/// A number with as many digits as the step between two needs.
fn written(value: f64, step: f64, largest: f64) -> String {
    // Zero up to rounding is zero, and has no sign.
    let value = if value.abs() < 1e-6 * step {
        0.0
    } else {
        value
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a power of ten of a double, clamped"
    )]
    let decimals = |x: f64| (-(x.log10() + 1e-9).floor()).clamp(0.0, 17.0) as usize;
    if largest >= 1e6 || step < 1e-5 {
        if value.abs() <= 0.0 {
            return "0".to_owned();
        }
        let digits = decimals(step / 10f64.powf(value.abs().log10().floor()));
        return format!("{value:.digits$e}");
    }
    format!("{value:.*}", decimals(step))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(low: f64, high: f64, most: usize) -> Vec<String> {
        ticks([low, high], most)
            .into_iter()
            .map(|(_, text)| text)
            .collect()
    }

    #[test]
    fn ticks_are_round_numbers_in_the_range() {
        assert_eq!(
            texts(0.0, 1.0, 5),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(texts(-0.31, 0.31, 6), ["-0.2", "0.0", "0.2"]);
        assert_eq!(texts(3.0, 97.0, 5), ["20", "40", "60", "80"]);
        assert_eq!(
            texts(-0.012, 0.012, 5),
            ["-0.010", "-0.005", "0.000", "0.005", "0.010"]
        );
        assert_eq!(texts(0.0, 4e7, 4), ["0", "1e7", "2e7", "3e7", "4e7"]);
        assert_eq!(texts(0.0, 2.4e-7, 3), ["0", "1e-7", "2e-7"]);
    }

    #[test]
    fn any_range_has_ticks_and_few_of_them() {
        for exponent in -300..300 {
            let size = 10f64.powi(exponent);
            for (low, high) in [(-1.0, 2.3), (0.12, 0.13), (-7.0, -6.99), (0.0, 9.99)] {
                let ticks = ticks([low * size, high * size], 6);
                assert!(
                    (1..=7).contains(&ticks.len()),
                    "{low} {high} {size} {ticks:?}"
                );
                for (value, _) in ticks {
                    let share = (value / size - low) / (high - low);
                    assert!((-1e-6..=1.0 + 1e-6).contains(&share));
                }
            }
        }
    }
}
