//! The rims of a gap as constraints of a Delaunay triangulation in the chart.

use std::collections::VecDeque;

use nalgebra::{Point2, Point3};
use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{
    ConstrainedDelaunayTriangulation, HasPosition, PositionInTriangulation, Triangulation,
};

use crate::base::Chart;

use super::FillError;

/// A vertex of the triangulation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    /// Chart position.
    pub(super) position: Point2<f64>,
    /// Index in the mesh; targets are numbered on from its last vertex.
    pub(super) index: u32,
    /// Whether it stands on the end of the surface.
    pub(super) border: bool,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> spade::Point2<f64> {
        spade::Point2::new(self.position.x, self.position.y)
    }
}

pub(super) type Cdt = ConstrainedDelaunayTriangulation<Vertex>;

/// Rounds of smoothing after which a rim that still crosses itself is given up.
const SMOOTHING_ROUNDS: usize = 128;

/// A closed chain of mesh vertices and their chart positions, the gap on its left.
#[derive(Debug, Clone)]
pub(super) struct Rim {
    pub(super) vertices: Vec<u32>,
    pub(super) chart: Vec<Point2<f64>>,
}

impl Rim {
    pub(super) fn new(vertices: &[u32], feet: &[Point3<f64>], chart: &Chart) -> Self {
        Self {
            vertices: vertices.to_vec(),
            chart: (vertices.iter())
                .map(|v| chart.to_plane(&feet[*v as usize]))
                .collect(),
        }
    }

    /// Area in the chart, positive if it runs counterclockwise.
    pub(super) fn signed_area(&self) -> f64 {
        let first = self.chart.first().copied().unwrap_or_default();
        (self.chart.windows(2))
            .map(|pair| (pair[0] - first).perp(&(pair[1] - first)))
            .sum::<f64>()
            / 2.0
    }

    /// Even-odd rule.
    pub(super) fn contains(&self, q: &Point2<f64>) -> bool {
        let n = self.chart.len();
        let mut inside = false;
        for i in 0..n {
            let (a, b) = (self.chart[i], self.chart[(i + 1) % n]);
            if (a.y > q.y) != (b.y > q.y) && q.x < a.x + (q.y - a.y) * (b.x - a.x) / (b.y - a.y) {
                inside = !inside;
            }
        }
        inside
    }

    /// One round of corner cutting without moving the number of corners. It straightens small folds
    /// that a rough rim makes when it is projected onto the base; only the positions used for
    /// triangulating change, never the mesh.
    fn smooth(&mut self) {
        let old = self.chart.clone();
        let n = old.len();
        for i in 0..n {
            let (before, after) = (old[(i + n - 1) % n], old[(i + 1) % n]);
            self.chart[i] =
                Point2::from((before.coords + old[i].coords * 2.0 + after.coords) / 4.0);
        }
    }
}

/// The triangulation of the rims alone.
pub(super) struct RimTriangulation {
    pub(super) cdt: Cdt,
    /// The rims that are in it, with the positions used.
    pub(super) rims: Vec<Rim>,
    /// Their vertices in the triangulation.
    handles: Vec<Vec<FixedVertexHandle>>,
}

impl RimTriangulation {
    /// Inserts all of `required` and, of `islands`, those that cross nothing.
    pub(super) fn new(mut required: Vec<Rim>, islands: Vec<Rim>) -> Result<Self, FillError> {
        let mut triangulation = Self::of(&required);
        for _ in 0..SMOOTHING_ROUNDS {
            if triangulation.is_ok() {
                break;
            }
            required.iter_mut().for_each(Rim::smooth);
            triangulation = Self::of(&required);
        }
        let mut triangulation = triangulation?;
        for island in islands {
            triangulation.add_island(island);
        }
        Ok(triangulation)
    }

    fn of(rims: &[Rim]) -> Result<Self, FillError> {
        let mut this = Self {
            cdt: Cdt::new(),
            rims: Vec::new(),
            handles: Vec::new(),
        };
        for rim in rims {
            let handles = this.insert_vertices(rim)?;
            this.rims.push(rim.clone());
            this.handles.push(handles);
        }
        // Constraints only after all vertices, so that no vertex splits one.
        for (rim, handles) in this.rims.iter().zip(&this.handles) {
            add_constraints(&mut this.cdt, rim, handles)?;
        }
        Ok(this)
    }

    fn insert_vertices(&mut self, rim: &Rim) -> Result<Vec<FixedVertexHandle>, FillError> {
        let mut handles = Vec::with_capacity(rim.vertices.len());
        for (index, position) in rim.vertices.iter().zip(&rim.chart) {
            let vertex = snapped(Vertex {
                position: *position,
                index: *index,
                border: false,
            });
            // A position that is taken: the same vertex met again (rims that touch) is fine.
            let handle = match self.cdt.locate(vertex.position()) {
                PositionInTriangulation::OnVertex(taken) => {
                    if self.cdt.vertex(taken).data().index != *index {
                        return Err(FillError::RimFolds { vertex: *index });
                    }
                    taken
                }
                _ => insert(&mut self.cdt, vertex, None)?,
            };
            handles.push(handle);
        }
        Ok(handles)
    }

    /// Adds an island's rim if it lies apart from all others.
    fn add_island(&mut self, rim: Rim) {
        let mut with_island = Self {
            cdt: self.cdt.clone(),
            rims: self.rims.clone(),
            handles: self.handles.clone(),
        };
        let Ok(handles) = with_island.insert_vertices(&rim) else {
            return;
        };
        let intact = (with_island.rims.iter().zip(&with_island.handles))
            .all(|(_, handles)| is_closed(&with_island.cdt, handles));
        if intact && add_constraints(&mut with_island.cdt, &rim, &handles).is_ok() {
            with_island.rims.push(rim);
            with_island.handles.push(handles);
            *self = with_island;
        }
    }

    /// For each inner face, by index, whether it lies in the gap: reached from the left side of a
    /// rim without crossing one. `None` if the gap has no end (it reaches the outside).
    pub(super) fn gap_faces(&self, may_be_open: bool) -> Option<Vec<bool>> {
        let mut in_gap = vec![false; self.cdt.num_all_faces()];
        let mut queue = VecDeque::new();
        for handles in &self.handles {
            for (i, from) in handles.iter().enumerate() {
                let to = handles[(i + 1) % handles.len()];
                let edge = self.cdt.get_edge_from_neighbors(*from, to)?;
                queue.push_back(edge.face().fix());
            }
        }
        while let Some(face) = queue.pop_front() {
            let Some(face) = self.cdt.face(face).as_inner().map(|face| face.fix()) else {
                if may_be_open {
                    continue;
                }
                return None;
            };
            if std::mem::replace(&mut in_gap[face.index()], true) {
                continue;
            }
            for edge in self.cdt.face(face).adjacent_edges() {
                if !edge.is_constraint_edge() {
                    queue.push_back(edge.rev().face().fix());
                }
            }
        }
        Some(in_gap)
    }

    /// The inner faces.
    pub(super) fn faces(&self) -> impl Iterator<Item = FixedFaceHandle<InnerTag>> {
        self.cdt.fixed_inner_faces()
    }
}

/// Inserts a vertex, near `hint` if it is known; coordinates that the predicates cannot hold become an
/// error.
pub(super) fn insert(
    cdt: &mut Cdt,
    vertex: Vertex,
    hint: Option<FixedVertexHandle>,
) -> Result<FixedVertexHandle, FillError> {
    let vertex = snapped(vertex);
    let inserted = match hint {
        Some(hint) => cdt.insert_with_hint(vertex, hint),
        None => cdt.insert(vertex),
    };
    inserted.map_err(|source| FillError::ChartRange { source })
}

/// Coordinates too small for the predicates are zero.
fn snapped(mut vertex: Vertex) -> Vertex {
    for x in vertex.position.iter_mut() {
        if x.abs() < spade::MIN_ALLOWED_VALUE {
            *x = 0.0;
        }
    }
    vertex
}

fn is_closed(cdt: &Cdt, handles: &[FixedVertexHandle]) -> bool {
    (0..handles.len()).all(|i| cdt.exists_constraint(handles[i], handles[(i + 1) % handles.len()]))
}

fn add_constraints(
    cdt: &mut Cdt,
    rim: &Rim,
    handles: &[FixedVertexHandle],
) -> Result<(), FillError> {
    let n = handles.len();
    for i in 0..n {
        let (from, to) = (handles[i], handles[(i + 1) % n]);
        let crosses = FillError::RimCrosses {
            edge: [rim.vertices[i], rim.vertices[(i + 1) % n]],
        };
        if from == to || !cdt.can_add_constraint(from, to) {
            return Err(crosses);
        }
        cdt.add_constraint(from, to);
        // A vertex in the middle of the edge would have split it.
        if !cdt.exists_constraint(from, to) {
            return Err(crosses);
        }
    }
    Ok(())
}
