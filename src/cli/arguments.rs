//! Values on the command line that are not plain numbers.

use std::path::Path;

use nalgebra::Vector3;
use relievo::base::{BaseChoice, BaseKind};
use relievo::completion::HoleChoice;
use relievo::sampling::SpacingRule;
use relievo::scan::Format;
use relievo::synth::Kind;

use super::outcome::Failure;

/// The format to write a scan in.
pub(super) fn output_format(path: &Path) -> Result<Format, Failure> {
    match Format::of_path(path) {
        Ok(format @ (Format::Ply | Format::Obj | Format::Stl)) => Ok(format),
        Ok(Format::Off) | Err(_) => Err(Failure::usage(format!(
            "{}: scans are written as .ply, .obj or .stl: give the output one of these extensions",
            path.display()
        ))),
    }
}

pub(super) fn base(text: &str) -> Result<BaseChoice, String> {
    Ok(match text {
        "auto" => BaseChoice::Auto,
        "plane" => BaseChoice::Kind(BaseKind::Plane),
        "sphere" => BaseChoice::Kind(BaseKind::Sphere),
        "cylinder" => BaseChoice::Kind(BaseKind::Cylinder),
        "cone" => BaseChoice::Kind(BaseKind::Cone),
        _ => return Err("expected auto, plane, sphere, cylinder or cone".into()),
    })
}

/// A base surface, or free form.
pub(super) fn form(text: &str) -> Result<BaseChoice, String> {
    match text {
        "freeform" => Ok(BaseChoice::FreeForm),
        _ => base(text).map_err(|expected| expected.replace(" or cone", ", cone or freeform")),
    }
}

pub(super) fn yes_or_no(text: &str) -> Result<bool, String> {
    match text {
        "yes" => Ok(true),
        "no" => Ok(false),
        _ => Err("expected yes or no".into()),
    }
}

/// A positive length in the scan's unit.
pub(super) fn length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(length) if length > 0.0 && length.is_finite() => Ok(length),
        _ => Err("expected a positive length in the scan's unit".into()),
    }
}

pub(super) fn holes(text: &str) -> Result<HoleChoice, String> {
    Ok(match text {
        "interior" => HoleChoice::Interior,
        "all" => HoleChoice::All,
        "largest" => HoleChoice::Largest,
        ids => HoleChoice::Ids(
            ids.split(',')
                .map(|id| id.trim().parse())
                .collect::<Result<_, _>>()
                .map_err(|_| {
                    "expected interior, all, largest, or numbers with commas between".to_owned()
                })?,
        ),
    })
}

pub(super) fn spacing(text: &str) -> Result<SpacingRule, String> {
    match text {
        "nyquist" => Ok(SpacingRule::Nyquist),
        "scan" => Ok(SpacingRule::Scan),
        length => match length.parse::<f64>() {
            Ok(length) if length > 0.0 && length.is_finite() => Ok(SpacingRule::Length(length)),
            _ => Err("expected nyquist, scan, or a positive length in the scan's unit".into()),
        },
    }
}

/// A number of bytes, with or without a unit: K, M, G (or kB, MB, GB) for powers of 1000, KiB, MiB, GiB
/// for powers of 1024.
pub(super) fn memory(text: &str) -> Result<usize, String> {
    let expected = || "expected a size above 0, as in 500M, 2GiB or 800000000".to_owned();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match text[digits.len()..].to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        "kib" => 1024.0,
        "mib" => 1_048_576.0,
        "gib" => 1_073_741_824.0,
        _ => return Err(expected()),
    };
    let number: f64 = digits.trim().parse().map_err(|_| expected())?;
    let bytes = number * unit;
    if !(bytes >= 1.0 && bytes.is_finite()) {
        return Err(expected());
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive; more than any memory saturates"
    )]
    Ok(bytes as usize)
}

pub(super) fn vector(text: &str) -> Result<Vector3<f64>, String> {
    let parts: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse())
        .collect::<Result<_, _>>()
        .map_err(|_| "expected three numbers with commas between".to_owned())?;
    match parts[..] {
        [x, y, z] => Ok(Vector3::new(x, y, z)),
        _ => Err("expected three numbers with commas between".into()),
    }
}

pub(super) fn kind(text: &str) -> Result<Kind, String> {
    let text = match text {
        "golfball" => "golf-ball",
        other => other,
    };
    text.parse().map_err(|error| format!("{error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units_and_are_above_zero() {
        for (text, bytes) in [
            ("2GiB", 2 << 30),
            ("500M", 500_000_000),
            ("500 MB", 500_000_000),
            ("1.5kib", 1536),
            ("123", 123),
            ("7b", 7),
        ] {
            assert_eq!(memory(text), Ok(bytes), "{text}");
        }
        for text in ["", "0", "-1", "inf", "nan", "GiB", "2 Gold", "1e400", "0.1"] {
            assert!(memory(text).is_err(), "{text}");
        }
    }
}
