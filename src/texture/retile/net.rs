//! The mesh that is being made: who has an edge with whom, and where on the input each vertex is.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::OnTriangle;
use super::ground::{Ground, Spot};
use super::half_edges::{HalfEdges, next, previous};
use crate::mesh::{TriMesh, triangle_normal};

/// A vertex of the mesh that is being made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Site {
    pub(super) place: OnTriangle,
    /// For a boundary vertex: the number of its rim, and its arc length there.
    pub(super) rim: Option<(u32, f64)>,
    /// Whether it is a corner of the boundary, which stays.
    pub(super) fixed: bool,
}

/// The mesh that is being made, over the input.
#[derive(Debug)]
pub(super) struct Net<'a> {
    pub(super) ground: &'a Ground,
    pub(super) edges: HalfEdges,
    /// By vertex what is at its site, apart from it, as this is read far more often.
    pub(super) spots: Vec<Spot>,
    pub(super) sites: Vec<Site>,
}

impl Site {
    /// A vertex inside.
    pub(super) fn inside(place: OnTriangle) -> Self {
        Self {
            place,
            rim: None,
            fixed: false,
        }
    }
}

impl Net<'_> {
    pub(super) fn point(&self, v: u32) -> Point3<f64> {
        self.spots[v as usize].point
    }

    pub(super) fn length(&self, h: u32) -> f64 {
        (self.point(self.edges.target(h)) - self.point(self.edges.origin(h))).norm()
    }

    /// Normal of three vertices' triangle, of length twice its area.
    pub(super) fn normal(&self, corners: [u32; 3]) -> Vector3<f64> {
        triangle_normal(corners.map(|v| self.point(v)))
    }

    /// Normal of the triangle of a half-edge, of length twice its area.
    pub(super) fn normal_at(&self, h: u32) -> Vector3<f64> {
        self.normal([h, next(h), previous(h)].map(|h| self.edges.origin(h)))
    }

    /// The half-edges that stand for the edges there are.
    pub(super) fn each_edge(&self) -> impl Iterator<Item = u32> {
        (0..self.edges.len()).filter(|h| self.edges.is_edge(*h))
    }

    /// Mean length of the edges, 0 without any.
    pub(super) fn mean_length(&self) -> f64 {
        let (sum, count) = self.each_edge().fold((0.0, 0u32), |(sum, count), h| {
            (sum + self.length(h), count + 1)
        });
        sum / f64::from(count.max(1))
    }

    /// A vertex of the boundary at an arc length of a rim.
    pub(super) fn on_rim(&self, rim: u32, along: f64) -> Site {
        Site {
            place: self.ground.rims[rim as usize].place(along),
            rim: Some((rim, along)),
            fixed: false,
        }
    }

    /// Half the way along the boundary between the ends of a boundary half-edge.
    pub(super) fn middle_on_rim(&self, h: u32) -> Option<Site> {
        let ends = [self.edges.origin(h), self.edges.target(h)];
        let [from, to] = ends.map(|v| self.sites[v as usize].rim);
        let ((rim, from), (_, to)) = (from?, to?);
        let polyline = &self.ground.rims[rim as usize];
        let half = 0.5 * polyline.forward(from, to);
        Some(self.on_rim(rim, polyline.moved(from, half)))
    }

    pub(super) fn place(&mut self, v: u32, site: Site) {
        self.spots[v as usize] = self.ground.spot(&site.place);
        self.sites[v as usize] = site;
    }

    pub(super) fn push(&mut self, site: Site) {
        self.spots.push(self.ground.spot(&site.place));
        self.sites.push(site);
    }

    /// Drops vertices and triangles that are gone.
    pub(super) fn compact(&mut self) {
        let kept = self.edges.kept();
        self.renumber(&kept);
    }

    /// Drops vertices and triangles that are gone and numbers the others so that what is close together
    /// is close in memory.
    pub(super) fn reorder(&mut self) {
        let mut kept = self.edges.kept();
        // The input's triangles are in such an order.
        kept.par_sort_by_key(|v| self.sites[*v as usize].place.triangle);
        self.renumber(&kept);
    }

    fn renumber(&mut self, kept: &[u32]) {
        self.edges.renumber(kept);
        self.sites = kept.iter().map(|v| self.sites[*v as usize]).collect();
        self.spots = kept.iter().map(|v| self.spots[*v as usize]).collect();
    }

    /// The mesh as it is; nothing may be gone.
    pub(super) fn mesh(&self) -> TriMesh {
        TriMesh {
            positions: self.spots.iter().map(|s| s.point).collect(),
            triangles: self.edges.triangles().to_vec(),
        }
    }
}
