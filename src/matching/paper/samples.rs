//! What the scanner saw, prepared for being searched.

use nalgebra::{Point3, Vector3};

use crate::base::BaseSurface;
use crate::mesh::{Adjacency, Csr, TriMesh, spatial_order};
use crate::neighborhood::{Frame, local_frames};
use crate::sampling::Subdivision;

use super::Match;
use super::cells::ThickTriangle;
use super::lower_bounds::LowerBounds;
use super::search::turned;
use super::site_grid::SiteGrid;
use super::slab::Slab;
use crate::mesh::PreparedTriangle;

/// Number of a sample: neighbors on the surface have numbers near each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SampleId(pub u32);

impl SampleId {
    /// As an index.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Where a sample stands, for carrying a neighborhood to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Site {
    pub(super) foot: Point3<f64>,
    pub(super) frame: Frame,
}

/// What a search asks of the partner of a neighbor. Apart from the sites, and small: partners are
/// looked up all over the surface, so what is not needed must not fill the cache.
#[derive(Debug, Clone, Copy)]
pub(super) struct Partner {
    /// Holds the triangles around it; `None` if it is not surrounded by samples.
    pub(super) slab: Option<Slab>,
    /// First of the triangles around it in `fans`, and how many.
    fan: (u32, u32),
}

/// The searchable sample surface.
#[derive(Debug)]
pub struct Samples {
    pub(super) base: BaseSurface,
    pub(super) sites: Vec<Site>,
    pub(super) partners: Vec<Partner>,
    triangles: Vec<PreparedTriangle>,
    /// Triangles around the samples, one sample after the other.
    fans: Vec<u32>,
    heights: Vec<f64>,
    pub(super) colors: Option<Vec<[f64; 3]>>,
    /// The scanned vertex that each stands for.
    scanned_vertices: Vec<u32>,
    pub(super) height_range: f64,
    pub(super) grid: SiteGrid,
    pub(super) lower_bounds: LowerBounds,
}

impl Samples {
    /// Prepares a subdivided sample surface over `base`. Vertices that no triangle uses are no
    /// samples.
    ///
    /// # Panics
    /// If there are 2³² samples or more.
    #[must_use]
    pub fn new(base: &BaseSurface, surface: &Subdivision) -> Self {
        let relief = &surface.relief;
        let adjacency = Adjacency::new(&surface.mesh);
        let order = order_of_samples(surface);
        let frames = local_frames(base, &relief.normals);
        let sites: Vec<Site> = (order.iter())
            .map(|v| Site {
                foot: relief.feet[*v as usize],
                frame: frames[*v as usize],
            })
            .collect();
        let (corners, incident) = ordered_triangles(&surface.mesh, &order);
        let (mut partners, mut fans) = (Vec::with_capacity(order.len()), Vec::new());
        for (row, vertex) in incident.rows().zip(&order) {
            let surrounded = row.len() == adjacency.neighbors.row(*vertex as usize).len();
            let index = |n: usize| u32::try_from(n).expect("a few times as many as samples");
            partners.push(Partner {
                slab: Slab::around(row.iter().map(|f| corners[*f as usize])).filter(|_| surrounded),
                fan: (index(fans.len()), index(row.len())),
            });
            fans.extend_from_slice(row);
        }
        let spacing = typical_edge(surface);
        let foot_triangles = foot_triangles(surface, spacing);
        let feet = sites.iter().map(|s| s.foot).collect();
        let heights: Vec<f64> = order.iter().map(|v| relief.heights[*v as usize]).collect();
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let range = (heights.iter()).fold(none, |[low, high], h| [low.min(*h), high.max(*h)]);
        Self {
            base: *base,
            grid: SiteGrid::new(feet, spacing, &foot_triangles),
            lower_bounds: LowerBounds::new(foot_triangles, spacing),
            sites,
            partners,
            triangles: corners.iter().map(|t| PreparedTriangle::new(*t)).collect(),
            fans,
            height_range: (range[1] - range[0]).max(0.0),
            heights,
            colors: (surface.colors.as_ref())
                .map(|colors| order.iter().map(|v| colors[*v as usize]).collect()),
            scanned_vertices: (order.iter())
                .map(|v| scanned_vertex(surface, *v))
                .collect(),
        }
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.sites.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sites.is_empty()
    }

    /// Height of a sample over the base.
    #[must_use]
    pub fn height(&self, sample: SampleId) -> f64 {
        self.heights[sample.index()]
    }

    /// Colour of a sample, in [0, 1].
    #[must_use]
    pub fn color(&self, sample: SampleId) -> Option<[f64; 3]> {
        self.colors.as_ref().map(|colors| colors[sample.index()])
    }

    /// The vertex that a sample stands for, of the surface before subdivision: itself, or for one in
    /// the middle of an edge the end with the lower index.
    #[must_use]
    pub fn scanned_vertex(&self, sample: SampleId) -> u32 {
        self.scanned_vertices[sample.index()]
    }

    /// The triangles around a sample.
    pub(super) fn fan(&self, sample: u32) -> impl Iterator<Item = &PreparedTriangle> {
        let (start, len) = self.partners[sample as usize].fan;
        (self.fans[start as usize..][..len as usize].iter()).map(|f| &self.triangles[*f as usize])
    }

    /// The triangles around those of the samples that are surrounded, each once.
    pub(super) fn triangles_around(&self, samples: &[u32]) -> Vec<&PreparedTriangle> {
        let mut around: Vec<u32> = (samples.iter())
            .map(|s| &self.partners[*s as usize])
            .filter(|partner| partner.slab.is_some())
            .flat_map(|Partner { fan, .. }| &self.fans[fan.0 as usize..][..fan.1 as usize])
            .copied()
            .collect();
        around.sort_unstable();
        around.dedup();
        (around.iter())
            .map(|f| &self.triangles[*f as usize])
            .collect()
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
        let site = &self.sites[found.sample.index()];
        let moved = site.foot + site.frame.to_world(&turned);
        let foot = self.base.foot(&moved).point;
        self.grid.nearest(&foot).map(SampleId)
    }
}

/// The vertices that a triangle uses, along a Z-order curve, so that samples which are looked at one
/// after the other are close in memory.
fn order_of_samples(surface: &Subdivision) -> Vec<u32> {
    let used = (0u32..)
        .zip(surface.mesh.used_vertices())
        .filter_map(|(v, used)| used.then_some(v))
        .collect();
    spatial_order(&surface.relief.feet, used)
}

/// Corners of the triangles in the order of their samples, and which triangles are around each sample.
fn ordered_triangles(mesh: &TriMesh, order: &[u32]) -> (Vec<[Point3<f64>; 3]>, Csr) {
    let mut number = vec![u32::MAX; mesh.positions.len()];
    for (sample, vertex) in (0u32..).zip(order) {
        number[*vertex as usize] = sample;
    }
    let mut triangles: Vec<([u32; 3], [u32; 3])> = (mesh.triangles.iter())
        .map(|t| (t.map(|v| number[v as usize]), *t))
        .collect();
    triangles.sort_by_key(|(samples, _)| samples.iter().copied().min());
    let corners = (0u32..)
        .zip(&triangles)
        .flat_map(|(f, (samples, _))| samples.map(|s| (s, f)));
    let incident = Csr::from_pairs(order.len(), corners);
    let corners = (triangles.iter())
        .map(|(_, t)| t.map(|v| mesh.positions[v as usize]))
        .collect();
    (corners, incident)
}

fn scanned_vertex(surface: &Subdivision, vertex: u32) -> u32 {
    let scanned = surface.mesh.positions.len() - surface.parents.len();
    match (vertex as usize).checked_sub(scanned) {
        None => vertex,
        Some(middle) => surface.parents[middle][0],
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

/// The triangles between the feet, so thick that the piece of base surface under each is in it.
fn foot_triangles(surface: &Subdivision, spacing: f64) -> Vec<ThickTriangle> {
    (surface.mesh.triangles.iter())
        .map(|t| ThickTriangle {
            corners: t.map(|v| surface.relief.feet[v as usize]),
            // The base bulges over the chords between feet, and rounding needs a little, too.
            margin: bulge(surface, t) + 1e-3 * spacing,
        })
        .collect()
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
