//! Values on the command line that are not plain numbers.

use std::path::Path;

use crate::base::{BaseChoice, BaseKind};
use crate::cloud::JoinChoice;
use crate::completion::{HoleChoice, Paint};
use crate::repair::RepairParams;
use crate::sampling::SpacingRule;
use crate::scan::{Format, Intrinsics};
use crate::synth::Kind;
use nalgebra::Vector3;

use super::outcome::Failure;

/// The format to write a scan in.
pub(super) fn output_format(path: &Path) -> Result<Format, Failure> {
    format_to_write(path).map_err(Failure::usage)
}

/// The same for programs.
///
/// # Errors
/// A sentence.
pub(crate) fn format_to_write(path: &Path) -> Result<Format, String> {
    match Format::of_path(path) {
        Ok(format) if format.can_be_written() => Ok(format),
        _ => Err(format!(
            "{}: scans are written as .ply, .obj, .off, .stl or .glb: give the output one of these extensions",
            path.display()
        )),
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

/// The camera of a depth image.
pub(super) fn intrinsics(text: &str) -> Result<Intrinsics, String> {
    let expected = "expected four numbers with commas between: focal lengths above 0 and principal point, in pixels";
    let parts: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse())
        .collect::<Result<_, _>>()
        .map_err(|_| expected.to_owned())?;
    match *parts.as_slice() {
        [fx, fy, cx, cy] if fx > 0.0 && fy > 0.0 && parts.iter().all(|value| value.is_finite()) => {
            Ok(Intrinsics { fx, fy, cx, cy })
        }
        _ => Err(expected.into()),
    }
}

/// How points become a surface.
pub(super) fn join(text: &str) -> Result<JoinChoice, String> {
    match text {
        "auto" => Ok(JoinChoice::Auto),
        "chart" => Ok(JoinChoice::Chart),
        "local" => Ok(JoinChoice::Local),
        _ => Err("expected auto, chart or local".into()),
    }
}

/// The steps of repair but for those named.
pub(super) fn no_repair(text: &str) -> Result<RepairParams, String> {
    let mut params = RepairParams::default();
    for step in text.split(',') {
        let switch = match step.trim() {
            "all" => {
                params = RepairParams::NONE;
                continue;
            }
            "degenerate" => &mut params.degenerate,
            "duplicates" => &mut params.duplicates,
            "weld" => &mut params.weld,
            "manifold" => &mut params.manifold,
            "orient" => &mut params.orient,
            "spikes" => &mut params.spikes,
            _ => {
                return Err(
                    "expected degenerate, duplicates, weld, manifold, orient or spikes, with commas between"
                        .into(),
                );
            }
        };
        *switch = false;
    }
    Ok(params)
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
    positive(text).ok_or_else(|| "expected a positive length in the scan's unit".into())
}

/// A positive area.
pub(super) fn area(text: &str) -> Result<f64, String> {
    positive(text).ok_or_else(|| "expected a positive area in square units of the scan".into())
}

fn positive(text: &str) -> Option<f64> {
    let number: f64 = text.parse().ok()?;
    (number > 0.0 && number.is_finite()).then_some(number)
}

/// Vertices that are painted.
pub(super) fn paint(text: &str) -> Result<Paint, String> {
    if let Some(digits) = text.strip_prefix('#') {
        let is_color = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
        let channel = |k: usize| u8::from_str_radix(&digits[2 * k..2 * k + 2], 16).ok();
        return match is_color.then(|| [0, 1, 2].map(channel)) {
            Some([Some(r), Some(g), Some(b)]) => Ok(Paint::Color([r, g, b])),
            _ => Err("expected a colour of six hexadecimal digits, as in #ff0000".into()),
        };
    }
    match text.split_once('=') {
        Some((name, value)) => match value.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Paint::Value(name.to_owned(), value)),
            _ => Err("expected a number behind =, as in label=3".into()),
        },
        None if text.is_empty() => Err("expected the name of a vertex property".into()),
        None => Ok(Paint::Channel(text.to_owned())),
    }
}

/// A paint as it is given.
pub(super) fn paint_in_words(paint: &Paint) -> String {
    match paint {
        Paint::Channel(name) => name.clone(),
        Paint::Value(name, value) => format!("{name}={value}"),
        Paint::Color([r, g, b]) => format!("#{r:02x}{g:02x}{b:02x}"),
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
