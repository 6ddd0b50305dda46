//! A completed scan as it is judged: heights over one base surface for known part and fill.

use nalgebra::{Point3, Vector3};

use crate::base::{self, FitParams, Form};
use crate::completion::{COMPLETED, Completion, HEIGHT, SOURCE, noted_relief};
use crate::likeness::{Field, FieldInput};
use crate::mesh::{Adjacency, TriMesh, vertex_normals};
use crate::relief;
use crate::scan::Scan;

use super::{EvaluationError, HeightsOver};

/// Rounds in which colours are blended from the rim: enough for holes 50 vertices across.
const BLENDING_ROUNDS: usize = 1000;

/// Heights and what they stand on, #V each.
#[derive(Debug)]
struct Heights {
    feet: Vec<Point3<f64>>,
    /// Unit normals.
    normals: Vec<Vector3<f64>>,
    /// NaN for vertices that are no relief.
    heights: Vec<f64>,
    over: HeightsOver,
}

/// A completed scan, around its centroid.
#[derive(Debug)]
pub(super) struct Judged {
    pub(super) mesh: TriMesh,
    /// From the centroid to the scan's own coordinates.
    pub(super) origin: Vector3<f64>,
    heights: Heights,
    /// #V: of the hole's fill.
    pub(super) completed: Vec<bool>,
    /// #V: what an earlier completion invented is neither scanned nor of this fill.
    scanned: Vec<bool>,
    /// #V: −1 for none.
    pub(super) sources: Vec<i64>,
    pub(super) colors: Option<Vec<[f64; 3]>>,
    /// What the hole's fill stands on: the scan's base surface, or one of its own.
    under_fill: Form,
}

impl Judged {
    /// Of a completion of a scan with so many vertices; `uncut` is the scan as it was before the hole was
    /// cut.
    pub(super) fn new(
        completion: &Completion,
        originals: usize,
        uncut: &Scan,
        fit: &FitParams,
    ) -> Result<Self, EvaluationError> {
        let scan = &completion.scan;
        let (mesh, origin) = scan.mesh().centered();
        let completed: Vec<bool> = (0..scan.vertices.rows).map(|v| v >= originals).collect();
        #[expect(clippy::cast_possible_truncation, reason = "vertex indices")]
        let mut sources: Vec<i64> = numbers(scan, SOURCE).map(|source| source as i64).collect();
        sources[..originals].fill(-1);
        let heights = match of_channel(&mesh, &origin, scan, &completed) {
            Some(heights) => heights,
            None => over_uncut(&mesh, &origin, uncut, fit)?,
        };
        let own_base = completion.report.filled.iter().find_map(|f| f.own_base);
        Ok(Self {
            under_fill: (own_base.unwrap_or(Form::Primitive(completion.report.fit.base)))
                .translated(-origin),
            colors: scan.colors(),
            mesh,
            origin,
            heights,
            scanned: numbers(scan, COMPLETED).map(|mark| mark < 0.5).collect(),
            completed,
            sources,
        })
    }

    /// Puts the completed vertices onto the base surface and blends their colours from the rim.
    pub(super) fn make_smooth(&mut self) {
        for v in (0..self.completed.len()).filter(|v| self.completed[*v]) {
            let p = match self.under_fill {
                Form::Primitive(base) => base.foot(&self.mesh.positions[v]).point,
                Form::Free(_) => self.heights.feet[v],
            };
            let heights = &mut self.heights;
            let up = heights.normals[v].dot(&(p - self.mesh.positions[v]));
            heights.heights[v] += up;
            // What does not go along the normal moves the foot.
            heights.feet[v] += (p - self.mesh.positions[v]) - heights.normals[v] * up;
            self.mesh.positions[v] = p;
        }
        self.sources.fill(-1);
        let adjacency = Adjacency::new(&self.mesh);
        if let Some(colors) = &mut self.colors {
            blend(colors, &self.completed, &adjacency);
        }
    }

    /// All that is measured, read off.
    pub(super) fn field(&self, step: f64) -> Field {
        let feet = TriMesh {
            // Feet on a base that does not fit may lie in folds: the surface itself does not.
            positions: match self.heights.over {
                HeightsOver::Completed => self.heights.feet.clone(),
                HeightsOver::Uncut => self.mesh.positions.clone(),
            },
            triangles: self.mesh.triangles.clone(),
        };
        Field::new(FieldInput {
            feet: &feet,
            heights: &self.heights.heights,
            colors: self.colors.as_deref(),
            step,
        })
    }

    /// Completed vertices with a height.
    pub(super) fn piece(&self) -> Vec<u32> {
        let is_piece = |v: &u32| self.completed[*v as usize] && self.height(*v).is_finite();
        (0u32..)
            .take(self.completed.len())
            .filter(is_piece)
            .collect()
    }

    /// By vertex: whether it is not of the hole's fill.
    pub(super) fn originals(&self) -> Vec<bool> {
        self.completed.iter().map(|completed| !completed).collect()
    }

    /// By vertex: whether it was scanned and has a height.
    pub(super) fn known(&self) -> Vec<bool> {
        (self.scanned.iter().zip(&self.heights.heights))
            .map(|(scanned, height)| *scanned && height.is_finite())
            .collect()
    }

    pub(super) fn height(&self, v: u32) -> f64 {
        self.heights.heights[v as usize]
    }

    pub(super) fn normal(&self, v: u32) -> Vector3<f64> {
        self.heights.normals[v as usize]
    }

    pub(super) fn heights_over(&self) -> HeightsOver {
        self.heights.over
    }

    /// Number of vertices without a height.
    pub(super) fn left_out(&self) -> usize {
        let heights = &self.heights.heights;
        heights.iter().filter(|height| !height.is_finite()).count()
    }
}

/// A channel's numbers, NaN without it.
fn numbers(scan: &Scan, name: &str) -> impl Iterator<Item = f64> {
    let column = scan.vertices.column(name);
    (0..scan.vertices.rows).map(move |row| column.and_then(|c| c.get_f64(row)).unwrap_or(f64::NAN))
}

/// The heights that completion has written; `None` if it has none for the fill, or for most of the scan.
fn of_channel(
    mesh: &TriMesh,
    origin: &Vector3<f64>,
    scan: &Scan,
    completed: &[bool],
) -> Option<Heights> {
    let mut heights: Vec<f64> = numbers(scan, HEIGHT).collect();
    let known = heights.iter().filter(|height| height.is_finite()).count();
    let of_fill = (heights.iter().zip(completed)).all(|(h, is)| !is || h.is_finite());
    if !of_fill || 2 * known < heights.len() {
        return None;
    }
    let (feet, normals) = match noted_relief(scan, mesh, origin) {
        Some((relief, reach)) => {
            for (v, height) in heights.iter_mut().enumerate() {
                // The channel is rounded to single precision. What is beyond the reach is another
                // surface, not relief.
                let exact = relief.heights[v];
                *height = if exact.abs() <= reach || completed[v] {
                    exact
                } else {
                    f64::NAN
                };
            }
            (relief.feet, relief.normals)
        }
        None => {
            let normals = vertex_normals(mesh);
            let feet = (0..heights.len())
                .map(|v| match heights[v].is_finite() {
                    true => mesh.positions[v] - normals[v] * heights[v],
                    false => mesh.positions[v],
                })
                .collect();
            (feet, normals)
        }
    };
    Some(Heights {
        feet,
        normals,
        heights,
        over: HeightsOver::Completed,
    })
}

/// Heights over what fits the uncut scan best, however well that is.
fn over_uncut(
    mesh: &TriMesh,
    origin: &Vector3<f64>,
    uncut: &Scan,
    fit: &FitParams,
) -> Result<Heights, EvaluationError> {
    let mut whole = uncut.mesh();
    for p in &mut whole.positions {
        *p -= origin;
    }
    let fitted = base::fit_part(&whole.positions, &whole.triangles, fit)?;
    let relief = relief::extract(mesh, &fitted.base);
    Ok(Heights {
        feet: relief.feet,
        normals: relief.normals,
        heights: relief.heights,
        over: HeightsOver::Uncut,
    })
}

/// Each completed vertex gets the mean colour of its neighbors, again and again; all else keeps its own.
fn blend(colors: &mut [[f64; 3]], completed: &[bool], adjacency: &Adjacency) {
    let inside: Vec<usize> = (0..completed.len()).filter(|v| completed[*v]).collect();
    let known: Vec<usize> = (inside.iter())
        .flat_map(|v| adjacency.neighbors.row(*v))
        .map(|n| *n as usize)
        .filter(|n| !completed[*n])
        .collect();
    let start = mean(colors, known.iter().copied());
    for v in &inside {
        colors[*v] = start;
    }
    for _ in 0..BLENDING_ROUNDS {
        for v in &inside {
            let neighbors = adjacency.neighbors.row(*v);
            colors[*v] = mean(colors, neighbors.iter().map(|n| *n as usize));
        }
    }
}

fn mean(colors: &[[f64; 3]], of: impl Iterator<Item = usize>) -> [f64; 3] {
    let (mut sum, mut count) = ([0.0; 3], 0.0f64);
    for v in of {
        for (sum, color) in sum.iter_mut().zip(colors[v]) {
            *sum += color;
        }
        count += 1.0;
    }
    sum.map(|sum| sum / count.max(1.0))
}
