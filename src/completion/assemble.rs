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
/// Name of the channel with the normalised cost of a completed vertex's match, from 0 to 1; NaN for
/// originals.
pub const COST: &str = "cost";

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
    let mut costs = Vec::new();
    let mut triangles = Vec::new();
    for gap in &work.added {
        let offset = points.len();
        points.extend(gap.points.iter().map(|p| p + origin));
        colors.extend(gap.colors.iter().flatten());
        sources.extend(&gap.sources);
        heights.extend(&gap.heights);
        costs.extend(&gap.costs);
        triangles.extend(gap.triangles.iter().map(|t| {
            t.map(|v| match (v as usize).checked_sub(first) {
                None => v,
                Some(target) => index(first + offset + target),
            })
        }));
    }
    let normals = new_normals(input, &points, &triangles, origin);
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
    set_channels(
        &mut out,
        &Marks {
            first,
            earlier,
            heights,
            sources,
            costs,
        },
    );
    out
}

/// What the channels of completion are made of.
struct Marks {
    /// Number of vertices of the input.
    first: usize,
    earlier: Option<Earlier>,
    /// #V.
    heights: Vec<f64>,
    /// By new vertex.
    sources: Vec<u32>,
    /// By new vertex.
    costs: Vec<f64>,
}

/// Writes the channels that tell completed from original vertices, keeping what an earlier completion wrote.
#[expect(
    clippy::cast_possible_truncation,
    reason = "float channels are asked for"
)]
fn set_channels(out: &mut Scan, marks: &Marks) {
    let (first, new) = (marks.first, marks.sources.len());
    let mut completed = [vec![0u8; first], vec![1u8; new]].concat();
    let signed = |v: &u32| i32::try_from(*v).unwrap_or(i32::MAX);
    let mut source: Vec<i32> = vec![-1; first];
    source.extend(marks.sources.iter().map(signed));
    let mut cost = vec![f32::NAN; first];
    cost.extend(marks.costs.iter().map(|c| *c as f32));
    if let Some(earlier) = &marks.earlier {
        completed[..first].copy_from_slice(&earlier.completed);
        source[..first].copy_from_slice(&earlier.sources);
        cost[..first].copy_from_slice(&earlier.costs);
    }
    let heights = marks.heights.iter().map(|h| *h as f32).collect();
    out.vertices.set_channel(COMPLETED, Column::U8(completed));
    out.vertices.set_channel(HEIGHT, Column::F32(heights));
    out.vertices.set_channel(SOURCE, Column::I32(source));
    out.vertices.set_channel(COST, Column::F32(cost));
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

/// The channels of a scan that was completed before, #V each.
pub(super) struct Earlier {
    /// 1 for completed vertices.
    pub(super) completed: Vec<u8>,
    /// −1 for originals.
    pub(super) sources: Vec<i32>,
    /// NaN for originals, and where the cost was not written.
    pub(super) costs: Vec<f32>,
}

/// What an earlier completion wrote.
#[expect(
    clippy::cast_possible_truncation,
    reason = "vertex indices saturate, costs are single"
)]
pub(super) fn earlier_marks(scan: &Scan) -> Option<Earlier> {
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
    let costs = values(COST).unwrap_or_else(|| vec![f64::NAN; marks.len()]);
    Some(Earlier {
        completed: marks.iter().map(|mark| u8::from(*mark > 0.5)).collect(),
        sources: sources.iter().map(|source| *source as i32).collect(),
        costs: costs.iter().map(|cost| *cost as f32).collect(),
    })
}

/// Keeps channels that happen to have the names of ours under other names, unless they are ours.
fn rename_foreign_channels(scan: &mut Scan) {
    if earlier_marks(scan).is_some() {
        return;
    }
    for own in [COMPLETED, HEIGHT, SOURCE, COST] {
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
