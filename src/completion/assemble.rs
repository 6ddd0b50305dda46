//! The completed scan: originals, then what was added, and the channels that tell them apart.

use nalgebra::{Point3, Vector3};

use crate::mesh::vertex_normals;
use crate::scan::{Added, Column, RANGE_GRID, Scan};

use super::{Input, Work, index};

/// Name of the channel that tells completed vertices (1) from original ones (0).
pub const COMPLETED: &str = "completed";
/// Name of the channel with the height over the base surface.
pub const HEIGHT: &str = "height";
/// Name of the channel with the vertex that a completed one was copied from, −1 for originals.
pub const SOURCE: &str = "source";

/// The scan with all that was added.
pub(super) fn assemble(
    scan: &Scan,
    input: &Input,
    mut heights: Vec<f64>,
    work: &Work,
    origin: &Vector3<f64>,
) -> Scan {
    let first = input.mesh.positions.len();
    let (mut points, mut colors, mut sources) = (Vec::new(), Vec::new(), Vec::new());
    let mut triangles = Vec::new();
    for gap in &work.added {
        let offset = points.len();
        points.extend(gap.points.iter().map(|p| p + origin));
        colors.extend(gap.colors.iter().flatten());
        sources.extend(&gap.sources);
        heights.extend(&gap.heights);
        triangles.extend(gap.triangles.iter().map(|t| {
            t.map(|v| match (v as usize).checked_sub(first) {
                None => v,
                Some(target) => index(first + offset + target),
            })
        }));
    }
    let normals = new_normals(input, &points, &triangles, origin);
    let completed = [vec![0u8; first], vec![1u8; points.len()]].concat();
    let mut out = scan.clone();
    let earlier = earlier_marks(&out);
    rename_foreign_channels(&mut out);
    // The grid has become faces, and does not hold the new vertices. Kept beside the faces it stops
    // other programs from reading the file.
    out.other_elements.retain(|(name, _)| name != RANGE_GRID);
    out.append(&Added {
        positions: &points,
        colors: (input.colors.is_some() && !points.is_empty()).then_some(&colors),
        normals: Some(&normals),
        sources: &sources,
        triangles: &triangles,
    });
    let signed = |v: u32| i32::try_from(v).unwrap_or(i32::MAX);
    let mut source: Vec<i32> = vec![-1; first];
    source.extend(sources.iter().map(|v| signed(*v)));
    let mut completed = completed;
    if let Some((marks, origins)) = earlier {
        completed[..first].copy_from_slice(&marks);
        source[..first].copy_from_slice(&origins);
    }
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a float channel is asked for"
    )]
    let heights = heights.iter().map(|h| *h as f32).collect();
    out.vertices.set_channel(COMPLETED, Column::U8(completed));
    out.vertices.set_channel(HEIGHT, Column::F32(heights));
    out.vertices.set_channel(SOURCE, Column::I32(source));
    out
}

/// Normals of the new vertices, on the completed surface.
fn new_normals(
    input: &Input,
    points: &[Point3<f64>],
    triangles: &[[u32; 3]],
    origin: &Vector3<f64>,
) -> Vec<Vector3<f64>> {
    let mut mesh = input.mesh.clone();
    mesh.positions.extend(points.iter().map(|p| p - origin));
    mesh.triangles.extend(triangles);
    vertex_normals(&mesh).split_off(input.mesh.positions.len())
}

/// The `completed` and `source` channels of a scan that was completed before.
pub(super) fn earlier_marks(scan: &Scan) -> Option<(Vec<u8>, Vec<i32>)> {
    let values = |name: &str| -> Option<Vec<f64>> {
        let channel = scan.vertices.channel(name)?;
        (0..scan.vertices.rows)
            .map(|row| channel.values.get_f64(row))
            .collect()
    };
    let (marks, sources, _) = (values(COMPLETED)?, values(SOURCE)?, values(HEIGHT)?);
    let is_mark = |mark: &f64| mark.abs() <= 0.0 || (mark - 1.0).abs() <= 0.0;
    if !marks.iter().all(is_mark) {
        return None;
    }
    #[expect(
        clippy::cast_possible_truncation,
        reason = "vertex indices, saturating"
    )]
    let sources = sources.iter().map(|source| *source as i32).collect();
    Some((
        marks.iter().map(|mark| u8::from(*mark > 0.5)).collect(),
        sources,
    ))
}

/// Keeps channels that happen to have the names of ours under other names, unless they are ours.
fn rename_foreign_channels(scan: &mut Scan) {
    if earlier_marks(scan).is_some() {
        return;
    }
    for own in [COMPLETED, HEIGHT, SOURCE] {
        let mut name = own.to_owned();
        while scan.vertices.channel(&name).is_some() {
            name = format!("input_{name}");
        }
        let foreign = scan.vertices.channels.iter_mut().find(|c| c.name == own);
        if let Some(channel) = foreign {
            log::warn!("the scan's own property {own} is kept as {name}");
            channel.name = name;
        }
    }
}
