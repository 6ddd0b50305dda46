//! A hole of known content.

use crate::mesh::{Adjacency, TriMesh, boundary_loops, triangle_area};
use crate::scan::Scan;

use super::HoleReport;

/// A scan with a hole, and what was there.
#[derive(Debug)]
pub(super) struct Hole {
    /// The scan without it.
    pub(super) scan: Scan,
    /// By vertex of the uncut scan: whether it was cut out.
    pub(super) removed: Vec<bool>,
    /// By vertex of the scan with the hole: whether it is next to what was cut out.
    rim: Vec<bool>,
}

impl Hole {
    /// Cuts the vertices out of the scan, and those that would be left without a face.
    pub(super) fn cut(scan: &Scan, mesh: &TriMesh, vertices: &[u32]) -> Self {
        let mut removed = vec![false; mesh.positions.len()];
        for v in vertices {
            removed[*v as usize] = true;
        }
        let (mut had_face, mut has_face) = (vec![false; removed.len()], vec![false; removed.len()]);
        for t in &mesh.triangles {
            let stays = t.iter().all(|v| !removed[*v as usize]);
            for v in t {
                had_face[*v as usize] = true;
                has_face[*v as usize] |= stays;
            }
        }
        for (v, removed) in removed.iter_mut().enumerate() {
            *removed |= had_face[v] && !has_face[v];
        }
        let mut next_to = vec![false; removed.len()];
        for t in &mesh.triangles {
            if t.iter().any(|v| removed[*v as usize]) {
                for v in t {
                    next_to[*v as usize] = true;
                }
            }
        }
        let (scan, kept) = scan.without(&removed);
        Self {
            rim: kept.iter().map(|v| next_to[*v as usize]).collect(),
            scan,
            removed,
        }
    }

    /// Numbers of the boundary loops that the cut has made.
    pub(super) fn loops(&self) -> Vec<usize> {
        let (mesh, _) = self.scan.mesh().centered();
        let loops = boundary_loops(&mesh, &Adjacency::new(&mesh));
        (loops.iter())
            .filter(|l| l.vertices.iter().all(|v| self.rim[*v as usize]))
            .map(|l| l.id)
            .collect()
    }

    /// The triangles that are missing.
    pub(super) fn triangles<'a>(&self, mesh: &'a TriMesh) -> impl Iterator<Item = &'a [u32; 3]> {
        (mesh.triangles.iter()).filter(|t| t.iter().any(|v| self.removed[*v as usize]))
    }

    pub(super) fn report(&self, mesh: &TriMesh) -> HoleReport {
        let areas = self
            .triangles(mesh)
            .map(|t| triangle_area(t.map(|v| mesh.positions[v as usize])));
        let removed = (mesh.positions.iter().zip(&self.removed)).filter(|(_, removed)| **removed);
        let count = removed.clone().count();
        let mut center = removed.fold([0.0; 3], |[x, y, z], (p, _)| [x + p.x, y + p.y, z + p.z]);
        for x in &mut center {
            *x /= count.max(1) as f64;
        }
        HoleReport {
            center,
            vertices: count,
            area: areas.sum(),
        }
    }
}
