//! Numbers as people read them.

/// Four significant digits; a power of ten where there would be many zeros.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "\u{2013}".to_owned();
    }
    // Zero has no sign.
    let value = value + 0.0;
    let size = value.abs();
    if size > 0.0 && !(1e-4..1e7).contains(&size) {
        let text = format!("{value:.3e}");
        return match text.split_once('e') {
            Some((digits, power)) => minus(&format!("{digits}\u{b7}10^{power}")),
            None => text,
        };
    }
    let digits = if size > 0.0 {
        let mut below = 3usize;
        let mut bound = 10.0;
        while size >= bound && below > 0 {
            below -= 1;
            bound *= 10.0;
        }
        bound = 1.0;
        while size < bound {
            below += 1;
            bound /= 10.0;
        }
        below
    } else {
        0
    };
    minus(&format!("{value:.digits$}"))
}

/// A number in percent, with its sign.
pub(super) fn signed_percent(value: f64) -> String {
    if value.is_finite() {
        minus(&format!("{value:+.1}\u{202f}%"))
    } else {
        "\u{2013}".to_owned()
    }
}

/// A whole number in groups of three digits.
pub(super) fn count(value: usize) -> String {
    let digits = value.to_string();
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        // A narrow space that keeps the number on one line.
        if index > 0 && (digits.len() - index).is_multiple_of(3) && digits.len() > 4 {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

/// A count with its noun.
pub(super) fn counted(value: usize, one: &str, many: &str) -> String {
    format!("{} {}", count(value), if value == 1 { one } else { many })
}

/// With a minus sign in place of the hyphen.
fn minus(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1.000"),
            (12.34567, "12.35"),
            (-0.001_234_56, "\u{2212}0.001235"),
            (123_456.7, "123457"),
            (1.5e-7, "1.500\u{b7}10^\u{2212}7"),
            (f64::NAN, "\u{2013}"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!(signed_percent(-2.04), "\u{2212}2.0\u{202f}%");
    }

    #[test]
    fn counts_are_grouped() {
        assert_eq!(count(1234), "1234");
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(counted(1, "gap", "gaps"), "1 gap");
        assert_eq!(counted(2, "gap", "gaps"), "2 gaps");
    }
}
