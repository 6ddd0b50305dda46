//! A scan as it came to one that can be completed, and what had to be done for it.
//!
//! Vertices never move, merge or leave. What changes is which faces there are and which vertices they
//! name: seams are joined by letting faces on both sides name one of the vertices that lie at the same place,
//! and [`Repaired::restore`] gives the faces of the finished scan their own vertices back. A clean scan
//! comes out as it went in.

mod duplicates;
mod edges;
mod manifold;
mod orient;
mod spikes;
#[cfg(test)]
mod tests;
mod weld;

use nalgebra::Point3;
use serde::Serialize;

use crate::mesh::{Csr, first_at_place};
use crate::scan::Scan;

/// Which steps to take, in their order. Default: all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RepairParams {
    /// Remove faces with fewer than three different vertices.
    pub degenerate: bool,
    /// Of faces with the same corners keep the first.
    pub duplicates: bool,
    /// Join surface along edges that lie at the same place bit by bit, as texture seams do.
    pub weld: bool,
    /// Where more than two faces meet in an edge, keep two.
    pub manifold: bool,
    /// Turn faces that are oriented against most others of their piece of surface.
    pub orient: bool,
    /// Remove faces that stick out of the rim like needles or are folded back from it.
    pub spikes: bool,
}

impl Default for RepairParams {
    fn default() -> Self {
        Self {
            degenerate: true,
            duplicates: true,
            weld: true,
            manifold: true,
            orient: true,
            spikes: true,
        }
    }
}

impl RepairParams {
    /// No step at all.
    pub const NONE: Self = Self {
        degenerate: false,
        duplicates: false,
        weld: false,
        manifold: false,
        orient: false,
        spikes: false,
    };
}

/// What was repaired; all zero for a clean scan.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct RepairReport {
    /// Faces removed since they have fewer than three different vertices.
    pub degenerate_faces: usize,
    /// Faces removed since an earlier one has the same corners.
    pub duplicate_faces: usize,
    /// Vertices that stand for no place of their own any more, since a seam was joined there.
    pub welded_vertices: usize,
    /// Edges at which more than two faces met.
    pub non_manifold_edges: usize,
    /// Faces removed there.
    pub non_manifold_faces: usize,
    /// Faces that were turned.
    pub flipped_faces: usize,
    /// Edges whose two faces cannot be made to agree: the surface is one-sided.
    pub unorientable_edges: usize,
    /// Faces removed at the rim.
    pub spike_faces: usize,
    /// Vertices in which several rims touch; nothing needs to be done there, holes are filled apart.
    pub touching_vertices: usize,
}

impl RepairReport {
    /// Whether anything was changed: edges and vertices that are only counted do not tell.
    #[must_use]
    pub fn changed(&self) -> bool {
        self.removed_faces() + self.welded_vertices + self.flipped_faces > 0
    }

    /// Number of faces removed by all steps together.
    #[must_use]
    pub fn removed_faces(&self) -> usize {
        self.degenerate_faces + self.duplicate_faces + self.non_manifold_faces + self.spike_faces
    }
}

/// A scan that can be completed.
#[derive(Debug, Clone)]
pub struct Repaired {
    /// The scan: the same vertices, and the faces that are left.
    pub scan: Scan,
    /// What was done.
    pub report: RepairReport,
    /// The faces that are left with their own vertices on either side of seams; `None` if no seam was
    /// joined.
    apart: Option<Csr>,
}

impl Repaired {
    /// The scan after more was appended to it, with the vertices that its faces had before seams were
    /// joined.
    #[must_use]
    pub fn restore(&self, mut completed: Scan) -> Scan {
        if let Some(apart) = &self.apart {
            let mut faces = apart.clone();
            for row in completed.faces.rows().skip(apart.len()) {
                faces.push_row(row);
            }
            completed.faces = faces;
        }
        completed
    }
}

/// Repairs a scan in the steps of `params`.
///
/// Zero-area faces with three different vertices stay: without them, there would be a crack.
#[must_use]
pub fn repair(mut scan: Scan, params: &RepairParams) -> Repaired {
    let positions = scan.positions();
    let mut work = Work::new(std::mem::take(&mut scan.faces), &positions);
    if params.degenerate {
        work.report.degenerate_faces = work.remove_degenerate();
    }
    let places = (params.duplicates || params.weld).then(|| first_at_place(&positions));
    if let (true, Some(places)) = (params.duplicates, &places) {
        work.report.duplicate_faces = duplicates::remove(&mut work, places);
    }
    if let (true, Some(places)) = (params.weld, &places) {
        work.report.welded_vertices = weld::join_seams(&mut work, places);
    }
    if params.manifold {
        manifold::repair(&mut work);
    }
    if params.orient {
        orient::repair(&mut work);
    }
    if params.spikes {
        work.report.spike_faces = spikes::remove(&mut work);
    }
    work.report.touching_vertices = edges::touching_vertices(&work);
    work.finish(scan)
}

/// The faces while they are repaired.
struct Work<'a> {
    positions: &'a [Point3<f64>],
    /// As in the scan.
    faces: Csr,
    /// For each vertex the one that stands for it since seams were joined; `None` if none was.
    stands_for: Option<Vec<u32>>,
    kept: Vec<bool>,
    flipped: Vec<bool>,
    report: RepairReport,
}

impl<'a> Work<'a> {
    fn new(faces: Csr, positions: &'a [Point3<f64>]) -> Self {
        let count = faces.len();
        Self {
            positions,
            faces,
            stands_for: None,
            kept: vec![true; count],
            flipped: vec![false; count],
            report: RepairReport::default(),
        }
    }

    /// The faces that are left, ascending.
    fn left(&self) -> impl Iterator<Item = u32> + Clone {
        (0u32..)
            .zip(&self.kept)
            .filter(|(_, kept)| **kept)
            .map(|(f, _)| f)
    }

    /// The vertex that stands for `v`.
    fn vertex(&self, v: u32) -> u32 {
        self.stands_for.as_ref().map_or(v, |s| s[v as usize])
    }

    /// The corners of a face, in its own order.
    fn corners(&self, f: u32) -> impl ExactSizeIterator<Item = u32> + Clone {
        self.faces.row(f as usize).iter().map(|v| self.vertex(*v))
    }

    fn point(&self, v: u32) -> Point3<f64> {
        self.positions[v as usize]
    }

    fn remove_degenerate(&mut self) -> usize {
        let mut removed = 0;
        for f in 0..self.faces.len() {
            let row = self.faces.row(f);
            let Some(first) = row.first() else { continue };
            let second = row.iter().find(|v| *v != first);
            let third = second.and_then(|second| row.iter().find(|v| *v != first && *v != second));
            if third.is_none() {
                self.kept[f] = false;
                removed += 1;
            }
        }
        removed
    }

    fn finish(self, mut scan: Scan) -> Repaired {
        let unchanged = !self.report.changed();
        let build = |vertex: &dyn Fn(u32) -> u32| {
            let (mut faces, mut row) = (Csr::default(), Vec::new());
            for f in self.left() {
                row.clear();
                row.extend(self.faces.row(f as usize).iter().map(|v| vertex(*v)));
                if self.flipped[f as usize] {
                    // The first corner stays the first.
                    row[1..].reverse();
                }
                faces.push_row(&row);
            }
            faces
        };
        let apart = self.stands_for.as_ref().map(|_| build(&|v| v));
        if unchanged {
            scan.faces = self.faces;
        } else {
            scan.faces = build(&|v| self.vertex(v));
            scan.turn_face_channels(&self.faces, &self.flipped);
            scan.retain_face_channels(&self.kept);
        }
        Repaired {
            scan,
            report: self.report,
            apart,
        }
    }
}
