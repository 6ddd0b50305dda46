//! What the scanner saw, prepared for being searched.

use nalgebra::{Point3, Vector3};

use crate::base::BaseSurface;
use crate::mesh::{Adjacency, Csr};
use crate::neighborhood::{Frame, local_frames};
use crate::sampling::Subdivision;

use super::Match;
use super::exhaustive::turned;
use super::point_triangle::PreparedTriangle;
use super::site_grid::SiteGrid;

/// Index of a sample: a vertex of the subdivided sample surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SampleId(pub u32);

impl SampleId {
    /// As an index.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The searchable sample surface.
#[derive(Debug)]
pub struct Samples {
    pub(super) base: BaseSurface,
    pub(super) side: f64,
    pub(super) surface: Subdivision,
    pub(super) frames: Vec<Frame>,
    pub(super) triangles: Vec<PreparedTriangle>,
    pub(super) incident: Csr,
    /// Whether a vertex is surrounded by samples.
    pub(super) complete: Vec<bool>,
    /// Lowest and highest height of the triangles around each vertex, with a margin for the
    /// curvature of the base.
    pub(super) height_bounds: Vec<[f64; 2]>,
    /// Vertices that may be copied from.
    pub(super) candidates: Vec<SampleId>,
    grid: SiteGrid,
    /// Vertex of each site of the grid.
    site_vertices: Vec<u32>,
    pub(super) height_range: f64,
}

impl Samples {
    /// Prepares a subdivided sample surface over `base`. Vertices that no triangle uses are no
    /// samples.
    #[must_use]
    pub fn new(base: &BaseSurface, surface: Subdivision) -> Self {
        let adjacency = Adjacency::new(&surface.mesh);
        let used = surface.mesh.used_vertices();
        let complete: Vec<bool> = (0..used.len())
            .map(|v| {
                let around = adjacency.triangles.row(v).len();
                around > 0 && around == adjacency.neighbors.row(v).len()
            })
            .collect();
        let candidates: Vec<SampleId> = (0u32..)
            .zip(&used)
            .filter_map(|(v, used)| used.then_some(SampleId(v)))
            .collect();
        let site_vertices: Vec<u32> = candidates.iter().map(|s| s.0).collect();
        let sites: Vec<_> = candidates
            .iter()
            .map(|s| surface.relief.feet[s.index()])
            .collect();
        let spacing = typical_edge(&surface);
        let grid = SiteGrid::new(&sites, spacing, foot_boxes(&surface, spacing));
        let heights = candidates.iter().map(|s| surface.relief.heights[s.index()]);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
            (low.min(h), high.max(h))
        });
        Self {
            base: *base,
            side: surface.relief.side,
            frames: local_frames(base, &surface.relief.normals),
            triangles: (0..surface.mesh.triangles.len())
                .map(|f| PreparedTriangle::new(surface.mesh.corners(f)))
                .collect(),
            height_bounds: height_bounds(&surface, &adjacency),
            incident: adjacency.triangles,
            complete,
            candidates,
            grid,
            site_vertices,
            height_range: if high > low { high - low } else { 0.0 },
            surface,
        }
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.candidates.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    /// Height of a sample over the base.
    #[must_use]
    pub fn height(&self, sample: SampleId) -> f64 {
        self.surface.relief.heights[sample.index()]
    }

    /// Colour of a sample, in [0, 1].
    #[must_use]
    pub fn color(&self, sample: SampleId) -> Option<[f64; 3]> {
        (self.surface.colors.as_ref()).map(|colors| colors[sample.index()])
    }

    /// The scanned vertex that a sample stands for: itself, or for one in the middle of an edge the
    /// end with the lower index.
    #[must_use]
    pub fn scanned_vertex(&self, sample: SampleId) -> u32 {
        let scanned = self.surface.mesh.positions.len() - self.surface.parents.len();
        match sample.index().checked_sub(scanned) {
            None => sample.0,
            Some(middle) => self.surface.parents[middle][0],
        }
    }

    /// The sample that stands to `found` as a target stands to its neighbor copied from there:
    /// `offset` is the way from the neighbor's foot to the target's, in the neighbor's frame.
    #[must_use]
    pub fn continuation(
        &self,
        found: &Match,
        rotations: u32,
        offset: &Vector3<f64>,
    ) -> Option<SampleId> {
        let turned = turned(offset, found.rotation, rotations);
        let sample = found.sample.index();
        let moved = self.surface.relief.feet[sample] + self.frames[sample].to_world(&turned);
        self.nearest(&self.base.foot(&moved).point)
    }

    /// The sample whose foot is nearest to a point of the base surface, if any is near.
    #[must_use]
    pub fn nearest(&self, foot: &Point3<f64>) -> Option<SampleId> {
        (self.grid.nearest(foot)).map(|site| SampleId(self.site_vertices[site as usize]))
    }
}

/// Root of twice the mean triangle area: the edge of a square lattice as dense as the feet.
fn typical_edge(surface: &Subdivision) -> f64 {
    let feet = &surface.relief.feet;
    let count = surface.mesh.triangles.len().max(1);
    let area: f64 = (surface.mesh.triangles.iter())
        .map(|t| crate::mesh::triangle_area(t.map(|v| feet[v as usize])))
        .sum();
    (2.0 * area / count as f64).sqrt()
}

/// Boxes around the piece of base surface under each triangle.
fn foot_boxes(surface: &Subdivision, spacing: f64) -> impl Iterator<Item = [Point3<f64>; 2]> {
    let relief = &surface.relief;
    surface.mesh.triangles.iter().map(move |t| {
        let [a, b, c] = t.map(|v| relief.feet[v as usize]);
        // The base bulges over the chords between the feet; and rounding needs a little, too.
        let margin = bulge(surface, t) + 1e-3 * spacing;
        let margin = Vector3::repeat(margin);
        [a.inf(&b).inf(&c) - margin, a.sup(&b).sup(&c) + margin]
    })
}

/// Bound of how far the base surface rises over a flat triangle between its points: for a chord e
/// over which the normal turns by δ the sagitta is eδ/8, for an equilateral triangle eδ/6; a third
/// leaves room for oblong ones.
fn bulge(surface: &Subdivision, triangle: &[u32; 3]) -> f64 {
    let relief = &surface.relief;
    let corner = |i: usize| triangle[i % 3] as usize;
    (0..3)
        .map(|i| {
            let (a, b) = (corner(i), corner(i + 1));
            let edge = (relief.feet[a] - relief.feet[b]).norm();
            edge * (relief.normals[a] - relief.normals[b]).norm() / 3.0
        })
        .fold(0.0, f64::max)
}

fn height_bounds(surface: &Subdivision, adjacency: &Adjacency) -> Vec<[f64; 2]> {
    let heights = &surface.relief.heights;
    (0..heights.len())
        .map(|v| {
            let mut bounds = [heights[v], heights[v]];
            let mut margin = 0.0f64;
            for f in adjacency.triangles.row(v) {
                let triangle = &surface.mesh.triangles[*f as usize];
                margin = margin.max(bulge(surface, triangle));
                for corner in triangle {
                    let h = heights[*corner as usize];
                    bounds = [bounds[0].min(h), bounds[1].max(h)];
                }
            }
            // Feet bulge as the surface over them does, by more the higher it stands.
            let reach = bounds[1].abs().max(bounds[0].abs());
            let margin = 2.0 * margin + 1e-12 * reach;
            [bounds[0] - margin, bounds[1] + margin]
        })
        .collect()
}
