//! What is given beside the meshes: a map, correspondences, a mask.

use std::path::Path;

use crate::completion::Paint;
use crate::mesh::TriMesh;
use crate::repair::Repaired;
use crate::scan::{self, Format, ReadOptions, trace};
use crate::transfer::{Correspondences, Shape, TransferError};
use anyhow::{Context, anyhow};
use serde_json::Value;

use super::super::outcome::Failure;
use super::Arguments;
use super::source::FromSource;

/// What is painted.
pub(super) struct Painted {
    /// By vertex of the mesh in its file.
    pub(super) own: Vec<bool>,
    /// By vertex of the mesh that is worked on: what is put on an edge is painted if both ends are.
    pub(super) fine: Vec<bool>,
}

impl Painted {
    /// `None` without a mask.
    pub(super) fn new(
        arguments: &Arguments,
        surface: &Repaired,
        source: &FromSource,
    ) -> Result<Option<Self>, Failure> {
        let Some(paint) = &arguments.mask else {
            return Ok(None);
        };
        let name = arguments.source_input().name();
        let own = match paint {
            Paint::Color(bare) => {
                let colors = surface.scan.colors().ok_or_else(|| {
                    anyhow!("{name}: it has no colours that could tell what is painted: give --mask the name of a vertex property")
                })?;
                let is_same = |(c, b): (&f64, &u8)| (255.0 * c - f64::from(*b)).abs() < 0.5;
                let is_bare = |color: &[f64; 3]| color.iter().zip(bare).all(is_same);
                colors.iter().map(|color| !is_bare(color)).collect()
            }
            others => others.vertices(&surface.scan).with_context(|| name)?,
        };
        let fine = source.between(&own);
        Ok(Some(Self { own, fine }))
    }
}

/// Pairs of vertices.
pub(super) fn correspondences(
    path: &Path,
    source: &TriMesh,
    target: &TriMesh,
) -> Result<Shape, Failure> {
    let text = text(path)?;
    let pairs = Correspondences::from_json(&text)
        .and_then(|given| given.resolve(source, target))
        .with_context(|| path.display().to_string())?;
    Ok(Shape::Affinities(pairs))
}

/// The vertex of the source for each one of the target.
pub(super) fn map(
    path: &Path,
    source: &TriMesh,
    target: &TriMesh,
) -> Result<Vec<Option<u32>>, Failure> {
    let map = match Format::of_path(path) {
        Ok(format) if format != Format::Xyz => of_scan(path, target)?,
        _ => of_text(&text(path)?).map_err(|reason| anyhow!("{}: {reason}", path.display()))?,
    };
    // A source that was made finer has more vertices, which no file knows of.
    let vertices = source.positions.len();
    let beyond = |entry: &(usize, &Option<u32>)| entry.1.is_some_and(|v| v as usize >= vertices);
    if map.len() == target.positions.len()
        && let Some((target, Some(source_vertex))) = map.iter().enumerate().find(beyond)
    {
        let error = TransferError::MapRange {
            target,
            source_vertex: *source_vertex,
            vertices,
        };
        return Err(anyhow::Error::new(error)
            .context(path.display().to_string())
            .into());
    }
    Ok(map)
}

fn text(path: &Path) -> Result<String, Failure> {
    let read = std::fs::read(path);
    trace::has_read(path, read.as_deref().ok());
    let bytes = read.with_context(|| path.display().to_string())?;
    Ok(String::from_utf8(bytes).map_err(|_| anyhow!("{}: this is no text", path.display()))?)
}

/// The vertex property `source`. Where vertices were put on the edges of the same target, those behind its own have no
/// say.
fn of_scan(path: &Path, target: &TriMesh) -> Result<Vec<Option<u32>>, Failure> {
    let scan = scan::read(path, &ReadOptions::default())?;
    let column = scan.vertices.column("source").ok_or_else(|| {
        anyhow!(
            "{}: its vertices have no property source that would be a map: give a file that this command wrote, or numbers as text",
            path.display()
        )
    })?;
    let own = target.positions.len();
    let begins_with = || scan.positions().starts_with(&target.positions);
    let rows = match scan.vertices.rows {
        more if more > own && begins_with() => own,
        rows => rows,
    };
    let entries = (0..rows)
        .map(|row| entry(column.get_f64(row)?))
        .collect::<Option<_>>();
    let entries = entries.ok_or_else(|| {
        anyhow!(
            "{}: its property source is not a whole number from 0, -1 or nan everywhere",
            path.display()
        )
    })?;
    Ok(entries)
}

/// Numbers, one a line, or a JSON list.
fn of_text(text: &str) -> Result<Vec<Option<u32>>, String> {
    let expected = "a whole number from 0, or -1 or nan for none";
    if text.trim_start().starts_with('[') {
        let list: Vec<Value> =
            serde_json::from_str(text).map_err(|error| format!("this is no JSON list: {error}"))?;
        let number = |value: &Value| match value {
            Value::Null => Some(None),
            value => entry(value.as_f64()?),
        };
        return (list.iter().enumerate())
            .map(|(at, value)| {
                number(value)
                    .ok_or_else(|| format!("entry {at} of the map is {value}, not {expected}"))
            })
            .collect();
    }
    (text.trim_end().lines().zip(1..))
        .map(|(line, number)| {
            let value = line.trim().parse().ok();
            value.and_then(entry).ok_or_else(|| {
                let start: String = line.trim().chars().take(40).collect();
                format!("line {number} of the map is `{start}`, not {expected}")
            })
        })
        .collect()
}

/// The vertex that a number names: `Some(None)` for none, `None` if it is no such number.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked before"
)]
fn entry(value: f64) -> Option<Option<u32>> {
    let is_none = value.is_nan() || (value + 1.0).abs() <= 0.0;
    let is_whole = value.fract().abs() <= 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value);
    match (is_none, is_whole) {
        (true, _) => Some(None),
        (_, true) => Some(Some(value as u32)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_numbers_a_line_or_a_list() {
        let expected = Ok(vec![Some(3), None, Some(0), None]);
        assert_eq!(of_text("3\n-1\n 0 \r\nnan\n\n"), expected);
        assert_eq!(of_text(" [3, -1, 0, null]"), expected);
        assert_eq!(of_text(""), Ok(Vec::new()));
        for (text, words) in [
            ("1\n2.5\n", "line 2 of the map is `2.5`"),
            ("1\n\n3\n", "line 2 of the map is ``"),
            ("-2", "line 1"),
            ("4294967296", "line 1"),
            ("[1, \"2\"]", "entry 1 of the map is \"2\""),
            ("[1, 2", "no JSON list"),
            ("inf", "whole number"),
        ] {
            let message = of_text(text).unwrap_err();
            assert!(message.contains(words), "{text:?}: {message}");
        }
    }
}
