//! What the columns of a text file without names mean, and their types.

use crate::scan::channel::Scalar;
use crate::scan::names::unique;
use crate::scan::{Column, Table};

/// How far the length of a normal may be from 1: programs write as few as two decimals, which
/// rounds by up to 0.005·√3.
const NORMAL_TOLERANCE: f64 = 0.01;

/// What three neighboring columns hold.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Triple {
    Color,
    Normal,
}

/// Names for columns without names: coordinates first, then colours or normals or both in either
/// order, and, if one column is left over, an intensity before, between or after them (PTS: before).
///
/// Columns that do not look like this are called by their number, from 1.
pub(super) fn guess(columns: &[Vec<f64>]) -> Vec<String> {
    let rest = columns.get(3..).unwrap_or_default();
    let groups = rest.len() / 3;
    let layout = match rest.len() % 3 {
        0 => triples(rest, None).map(|found| (found, None)),
        1 => {
            let between = 1..groups;
            std::iter::once(0)
                .chain((groups > 0).then_some(groups))
                .chain(between)
                .find_map(|before| {
                    let found = triples(rest, Some(before))?;
                    Some((found, Some(before)))
                })
        }
        _ => None,
    };
    let mut names: Vec<String> = ["x", "y", "z"].map(str::to_owned).into();
    if let Some((found, intensity)) = layout {
        for group in 0..=found.len() {
            if intensity == Some(group) {
                names.push("intensity".to_owned());
            }
            let three = found.get(group).map(|triple| match triple {
                Triple::Color => ["red", "green", "blue"],
                Triple::Normal => ["nx", "ny", "nz"],
            });
            names.extend(three.into_iter().flatten().map(str::to_owned));
        }
    }
    // Those that are left get their numbers.
    names.resize(columns.len(), String::new());
    unique(names)
}

/// What each three columns hold, if `intensity` stands before that many of them; `None` if some hold
/// something else, or two the same.
fn triples(rest: &[Vec<f64>], intensity: Option<usize>) -> Option<Vec<Triple>> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < rest.len() {
        if intensity == Some(found.len()) && at == found.len() * 3 {
            at += 1;
            continue;
        }
        let triple = kind(rest.get(at..at + 3)?)?;
        if found.contains(&triple) {
            return None;
        }
        found.push(triple);
        at += 3;
    }
    Some(found)
}

fn kind(three: &[Vec<f64>]) -> Option<Triple> {
    let [a, b, c] = three else { return None };
    let unit = |((a, b), c): ((&f64, &f64), &f64)| {
        let length = (a * a + b * b + c * c).sqrt();
        // Zero stands for a normal that is not known.
        (length - 1.0).abs() <= NORMAL_TOLERANCE || length <= 0.0
    };
    let zero = three.iter().flatten().all(|v| v.to_bits() << 1 == 0);
    if !zero && a.iter().zip(b).zip(c).all(unit) {
        return Some(Triple::Normal);
    }
    let whole = three.iter().all(|c| largest_whole(c, 255.0).is_some());
    let fractions = three.iter().flatten().all(|v| (0.0..=1.0).contains(v));
    (whole || fractions).then_some(Triple::Color)
}

/// The largest value, if all are whole and from 0 to `limit`.
fn largest_whole(values: &[f64], limit: f64) -> Option<f64> {
    values.iter().try_fold(0.0_f64, |largest, v| {
        ((0.0..=limit).contains(v) && v.fract().to_bits() << 1 == 0).then_some(largest.max(*v))
    })
}

/// The columns as channels: `double`, but whole-number colours `uchar` or `ushort`.
///
/// Columns without a name are left out.
pub(super) fn table(names: &[String], columns: Vec<Vec<f64>>) -> Table {
    let colors = ["red", "green", "blue"];
    let largest = |name: &str| {
        let index = names.iter().position(|n| n == name)?;
        // Names may be there without a single point.
        largest_whole(columns.get(index)?, f64::from(u16::MAX))
    };
    // Colours have one type, or else they would have different scales. If none exceeds 1, they are
    // rather fractions that happen to be whole: as whole numbers all would be black.
    let full = colors
        .iter()
        .try_fold(0.0_f64, |full, name| Some(full.max(largest(name)?)))
        .filter(|full| *full > 1.0);
    let full = full.map(|full| full.max(largest("alpha").unwrap_or(0.0)));
    let mut table = Table::default();
    for (name, values) in names.iter().zip(columns) {
        let is_color = colors.contains(&name.as_str())
            || (name == "alpha" && largest_whole(&values, f64::from(u16::MAX)).is_some());
        let column = match full.filter(|_| is_color) {
            Some(full) if full <= 255.0 => {
                Column::U8(values.into_iter().map(Scalar::rounded).collect())
            }
            Some(_) => Column::U16(values.into_iter().map(Scalar::rounded).collect()),
            None => Column::F64(values),
        };
        if !name.is_empty() {
            table.set_channel(name, column);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guessed(rows: &[&[f64]]) -> String {
        let columns: Vec<Vec<f64>> = (0..rows[0].len())
            .map(|c| rows.iter().map(|row| row[c]).collect())
            .collect();
        guess(&columns).join(" ")
    }

    #[test]
    fn columns_are_guessed_from_number_and_values() {
        for (rows, expected) in [
            (&[&[5.0, 6.0, 7.0][..]][..], "x y z"),
            (&[&[5.0, 6.0, 7.0, -0.5]], "x y z intensity"),
            (&[&[5.0, 6.0, 7.0, -0.5, 3.0]], "x y z column_4 column_5"),
            (&[&[5.0, 6.0, 7.0, 255.0, 0.0, 1.0]], "x y z red green blue"),
            (&[&[5.0, 6.0, 7.0, 0.5, 0.0, 1.0]], "x y z red green blue"),
            (
                &[
                    &[5.0, 6.0, 7.0, 0.6, 0.0, -0.8],
                    &[5.0, 6.0, 7.0, 0.0, 0.0, 0.0],
                ],
                "x y z nx ny nz",
            ),
            (
                &[&[5.0, 6.0, 7.0, 256.0, 0.0, 1.0]],
                "x y z column_4 column_5 column_6",
            ),
            (
                &[&[5.0, 6.0, 7.0, -1024.0, 0.0, 1.0, 255.0]],
                "x y z intensity red green blue",
            ),
            (
                &[&[5.0, 6.0, 7.0, 9.0, 0.0, 1.0, 255.5]],
                "x y z red green blue intensity",
            ),
            (
                &[&[5.0, 6.0, 7.0, 9.0, 0.0, 255.0, 0.0, 0.0, 1.0]],
                "x y z red green blue nx ny nz",
            ),
            (
                &[&[5.0, 6.0, 7.0, 0.0, -1.0, 0.0, 9.0, 0.0, 255.0, 0.5]],
                "x y z nx ny nz red green blue intensity",
            ),
            (
                &[&[5.0, 6.0, 7.0, 9.0, 0.0, 255.0, 0.5, 0.0, -1.0, 0.0]],
                "x y z red green blue intensity nx ny nz",
            ),
        ] {
            assert_eq!(guessed(rows), expected);
        }
    }

    #[test]
    fn colors_get_the_type_of_their_scale() {
        let names: Vec<String> = ["red", "green", "blue"].map(str::to_owned).into();
        let typed = |blue: f64| {
            let table = table(&names, vec![vec![0.0], vec![1.0], vec![blue]]);
            table.channels[0].values.clone()
        };
        assert_eq!(typed(255.0), Column::U8(vec![0]));
        assert_eq!(typed(256.0), Column::U16(vec![0]));
        assert_eq!(typed(1.0), Column::F64(vec![0.0]));
        assert_eq!(typed(70000.0), Column::F64(vec![0.0]));
        assert_eq!(typed(f64::NAN), Column::F64(vec![0.0]));
    }
}
