//! The gap between rims, filled with target vertices and triangles on the base surface.

use std::collections::BTreeMap;

use nalgebra::{Point2, Point3, Vector3};
use rayon::prelude::*;
use spade::handles::FixedVertexHandle;
use spade::{InsertionError, PositionInTriangulation, Triangulation};
use thiserror::Error;

use crate::base::{BaseSurface, Chart};
use crate::mesh::{Adjacency, PointTree, vector_area};
use crate::relief::Relief;

use super::lattice::{Angles, LatticePoint, Region, along_and_around};
use super::rectangle::bounding_rectangle;
use super::rims::{Rim, RimTriangulation, Vertex, insert};

/// More target vertices than this are refused before anything is allocated for them: about what
/// 24 GiB can hold with their neighborhoods.
pub(super) const MAX_TARGETS: f64 = 2e7;

/// Targets keep this many spacings away from the rim, so that no sliver stands between them. In a
/// lattice the next row would be 0.87 away.
const RIM_CLEARANCE: f64 = 0.6;

/// Edges longer than this many spacings are no part of an open-ended extension: they bridge the
/// concave outline of the lattice.
const LONGEST_EXTENSION_EDGE: f64 = 3.0;

/// Points of the lattice that one task looks for.
const LOCATED_AT_ONCE: usize = 4096;

/// A gap to fill: the loops around it, each with the gap on its left.
#[derive(Debug, Clone, Default)]
pub struct Gap {
    /// Loops that bound it.
    pub rims: Vec<Vec<u32>>,
    /// Outer rims of loose pieces that may lie inside it; those that do are left open.
    pub islands: Vec<Vec<u32>>,
    /// Fill to the end of the surface, as far as these vertices reach: the rest of the cylinder's or
    /// cone's wall between them, of the plane's bounding rectangle, of the sphere.
    pub extend_over: Option<Vec<u32>>,
}

/// Target vertices and the triangles that stitch them to the scan.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fill {
    /// #T points on the base surface.
    pub targets: Vec<Point3<f64>>,
    /// Triples of vertex indices, oriented as the scan's; targets are numbered on from the scan's
    /// last vertex.
    pub triangles: Vec<[u32; 3]>,
    /// Islands left open inside the gap, as indices into [`Gap::islands`].
    pub islands: Vec<usize>,
}

/// Why a gap cannot be filled on its base surface.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FillError {
    /// On a plane, or around a cylinder, what is beyond the rim has no end.
    #[error("it has no end on the base surface; --extend fills up to where the scan ends")]
    Unbounded,
    /// Two different vertices of the rim have one foot point.
    #[error("its rim folds over itself at vertex {vertex}, seen along the base surface's normal")]
    RimFolds {
        /// Vertex of the scan.
        vertex: u32,
    },
    /// The rim is no simple polygon in the chart.
    #[error(
        "its rim crosses itself at the edge between vertices {} and {}, seen along the base surface's normal",
        edge[0], edge[1]
    )]
    RimCrosses {
        /// The edge of the rim that meets another.
        edge: [u32; 2],
    },
    /// Every triangulation of the rim and the islands in it would need an edge twice.
    #[error(
        "its rim and the loose pieces in it cannot be joined by triangles; remove the loose pieces there"
    )]
    CannotBeSpanned,
    /// The spacing asks for too many vertices.
    #[error(
        "it would need about {predicted:.1e} new vertices at a spacing of {spacing:.1e}, more than {MAX_TARGETS:.0e}; give a larger --spacing"
    )]
    TooManyTargets {
        /// Predicted number.
        predicted: f64,
        /// Spacing, in the scan's unit.
        spacing: f64,
    },
    /// Cylinders more than some 40 times as long as wide leave the number range of exp.
    #[error("it is too far along the axis for the chart of the base surface ({source})")]
    ChartRange {
        /// What the triangulation says.
        source: InsertionError,
    },
}

impl FillError {
    /// Whether the gap may be filled all the same where it need not lie on the base surface. What has no
    /// end there is rather an outer rim.
    #[must_use]
    pub fn is_of_the_chart(&self) -> bool {
        matches!(self, Self::RimFolds { .. } | Self::RimCrosses { .. })
    }
}

/// Fills `gap` with targets about `spacing` apart on the base surface and triangulates it, the rims'
/// own edges kept.
///
/// # Errors
/// [`FillError`]: the gap cannot be filled on this base surface.
///
/// # Reference
/// [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), §4; the chart is ours, see
/// [`Chart`].
pub fn fill(
    base: &BaseSurface,
    relief: &Relief,
    adjacency: &Adjacency,
    gap: &Gap,
    spacing: f64,
) -> Result<Fill, FillError> {
    let chart = gap_chart(base, relief, gap);
    let (rims, islands) = plane_rims(gap, relief, &chart)?;
    let in_gap = (rims.gap_faces(gap.extend_over.is_some())).ok_or(FillError::Unbounded)?;
    let region = region(base, relief, gap, &rims, &chart);
    let predicted = region.predicted_points(spacing);
    if predicted.is_nan() || predicted > MAX_TARGETS {
        return Err(FillError::TooManyTargets { predicted, spacing });
    }
    let clear = Clearance::new(&rims.rims, &chart, spacing);
    let lattice = region.points(spacing, gap.extend_over.is_some());
    let inside = (lattice.par_chunks(LOCATED_AT_ONCE)).flat_map_iter(|points| {
        // Neighbors in the lattice are near each other.
        let mut near = None;
        let inside = points.iter().filter_map(|point| {
            let q = chart.to_plane(&point.point);
            let free = is_in_gap(&rims, &in_gap, &q, &mut near, gap.extend_over.is_some());
            (free && clear.is_clear(&point.point)).then_some((q, *point))
        });
        inside.collect::<Vec<_>>()
    });
    let inside: Vec<_> = inside.collect();
    let first_target = u32::try_from(relief.feet.len()).unwrap_or(u32::MAX);
    let builder = Builder {
        chart: &chart,
        adjacency,
        first_target,
        spacing,
        open: gap.extend_over.is_some(),
        targets: Vec::new(),
    };
    let mut fill = builder.build(inside, rims)?;
    fill.islands = islands;
    Ok(fill)
}

/// Whether a place of the chart lies in the gap, looked for from `near` on. Beyond all rims only an
/// open gap lies.
fn is_in_gap(
    rims: &RimTriangulation,
    in_gap: &[bool],
    q: &Point2<f64>,
    near: &mut Option<FixedVertexHandle>,
    open: bool,
) -> bool {
    let place = spade::Point2::new(q.x, q.y);
    let location = match *near {
        Some(near) => rims.cdt.locate_with_hint(place, near),
        None => rims.cdt.locate(place),
    };
    match location {
        PositionInTriangulation::OnFace(face) => {
            *near = Some(rims.cdt.face(face).vertices()[0].fix());
            in_gap[face.index()]
        }
        PositionInTriangulation::OutsideOfConvexHull(_) => open,
        // On an edge or vertex: between rim vertices, so too near a rim or in line with one.
        PositionInTriangulation::OnEdge(edge) => {
            let edge = rims.cdt.directed_edge(edge);
            !edge.is_constraint_edge() && in_gap[edge.face().fix().index()]
        }
        _ => false,
    }
}

/// Whether the gap has an end on the base surface: not beyond a plane's outer rim, nor beyond the end
/// of a tube.
#[must_use]
pub fn is_bounded(base: &BaseSurface, relief: &Relief, gap: &Gap) -> bool {
    plane_rims(gap, relief, &gap_chart(base, relief, gap)).is_ok()
}

/// The chart around the middle of the gap.
fn gap_chart(base: &BaseSurface, relief: &Relief, gap: &Gap) -> Chart {
    let polygons: Vec<Vec<_>> = (gap.rims.iter())
        .map(|rim| rim.iter().map(|v| relief.feet[*v as usize]).collect())
        .collect();
    let count = polygons.iter().map(Vec::len).sum::<usize>().max(1);
    let sum: Vector3<f64> = polygons.iter().flatten().map(|p| p.coords).sum();
    let middle = match base {
        // The vector area of the rims points to the middle of the gap, however large it is.
        BaseSurface::Sphere(sphere) => {
            let area: Vector3<f64> = polygons.iter().map(|p| vector_area(p)).sum();
            sphere.center + area * relief.side
        }
        _ => Point3::from(sum / count as f64),
    };
    Chart::new(base, relief.side, &middle)
}

/// The triangulated rims, and which islands are among them.
fn plane_rims(
    gap: &Gap,
    relief: &Relief,
    chart: &Chart,
) -> Result<(RimTriangulation, Vec<usize>), FillError> {
    let rims: Vec<_> = (gap.rims.iter())
        .map(|rim| Rim::new(rim, &relief.feet, chart))
        .collect();
    let islands: Vec<(usize, Rim)> = (gap.islands.iter().enumerate())
        .map(|(i, island)| (i, Rim::new(island, &relief.feet, chart)))
        .filter(|(_, island)| {
            // An extension goes all around the axis: pieces of surface may lie on either side.
            gap.extend_over.is_some()
                || island.signed_area() < 0.0
                    && rims
                        .iter()
                        .any(|rim| island.chart.iter().all(|q| rim.contains(q)))
        })
        .collect();
    let indices: BTreeMap<Vec<u32>, usize> = (islands.iter())
        .map(|(i, island)| (island.vertices.clone(), *i))
        .collect();
    let required = rims.len();
    if gap.extend_over.is_none() && !rims.iter().any(|rim| rim.signed_area() > 0.0) {
        return Err(FillError::Unbounded);
    }
    let triangulation =
        RimTriangulation::new(rims, islands.into_iter().map(|(_, rim)| rim).collect())?;
    let winds = |rim: &Rim| rim.contains(&Point2::origin());
    let loops_around = triangulation.rims.iter().filter(|rim| winds(rim)).count();
    if gap.extend_over.is_none() && chart.origin_is_an_end() && loops_around % 2 == 1 {
        return Err(FillError::Unbounded);
    }
    let used = (triangulation.rims[required..].iter())
        .filter_map(|rim| indices.get(&rim.vertices).copied())
        .collect();
    Ok((triangulation, used))
}

/// What part of the base surface the lattice must cover.
fn region(
    base: &BaseSurface,
    relief: &Relief,
    gap: &Gap,
    rims: &RimTriangulation,
    chart: &Chart,
) -> Region {
    let feet: Vec<Point3<f64>> = match &gap.extend_over {
        Some(vertices) => (vertices.iter())
            .map(|v| relief.feet[*v as usize])
            .collect(),
        // Smoothed rims lie within the old ones but for small folds; cover both.
        None => (rims.rims.iter())
            .flat_map(|rim| {
                rim.chart
                    .iter()
                    .map(|q| chart.to_surface(q))
                    .chain(rim.vertices.iter().map(|v| relief.feet[*v as usize]))
            })
            .collect(),
    };
    match base {
        BaseSurface::Plane(_) => {
            let corners: Vec<_> = feet.iter().map(|p| chart.to_plane(p)).collect();
            let (corner, [a, b]) = bounding_rectangle(&corners);
            let lift = |q: Point2<f64>| chart.to_surface(&q);
            Region::Rectangle(
                lift(corner),
                [
                    lift(corner + a) - lift(corner),
                    lift(corner + b) - lift(corner),
                ],
            )
        }
        BaseSurface::Sphere(sphere) => {
            let pole = chart.to_surface(&Point2::origin()) - sphere.center;
            let polar = (rims.rims.iter())
                .flat_map(|rim| &rim.chart)
                .map(|q| (chart.to_surface(q) - sphere.center).angle(&pole))
                .fold(0.0, f64::max);
            Region::Cap(*sphere, pole, polar)
        }
        BaseSurface::Cylinder(_) | BaseSurface::Cone(_) => {
            let (along, around): (Vec<_>, Vec<_>) = (feet.iter())
                .filter_map(|p| along_and_around(base, p))
                .unzip();
            let low = along.iter().copied().fold(f64::INFINITY, f64::min);
            let high = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let encircles = rims.rims.iter().any(|rim| rim.contains(&Point2::origin()));
            let angles = if gap.extend_over.is_some() || encircles {
                Angles::All
            } else {
                Angles::covering(around)
            };
            match base {
                BaseSurface::Cylinder(cylinder) => Region::Wall(*cylinder, [low, high], angles),
                BaseSurface::Cone(cone) => Region::ConeWall(*cone, [low, high], angles),
                _ => unreachable!("matched above"),
            }
        }
    }
}

/// Distance of candidates from the rims, measured on the surface.
struct Clearance {
    tree: PointTree,
    least_sq: f64,
}

impl Clearance {
    fn new(rims: &[Rim], chart: &Chart, spacing: f64) -> Self {
        let mut points = Vec::new();
        for rim in rims {
            for (i, from) in rim.chart.iter().enumerate() {
                let to = rim.chart[(i + 1) % rim.chart.len()];
                let length = (chart.to_surface(from) - chart.to_surface(&to)).norm() / spacing;
                // Points a quarter spacing apart: the error of the distance is below 2 %.
                let mut t = 0.0;
                while t < 1.0 {
                    let q = from + (to - from) * t;
                    points.push(chart.to_surface(&q));
                    t += (0.25 / length).max(1e-3);
                }
            }
        }
        Self {
            tree: PointTree::new(&points),
            least_sq: (RIM_CLEARANCE * spacing).powi(2),
        }
    }

    fn is_clear(&self, point: &Point3<f64>) -> bool {
        self.tree.nearest(point).distance_sq >= self.least_sq
    }
}

/// Turns the rims' triangulation and the free lattice points into a [`Fill`].
struct Builder<'a> {
    chart: &'a Chart,
    adjacency: &'a Adjacency,
    first_target: u32,
    spacing: f64,
    /// Whether the gap may reach the end of the surface.
    open: bool,
    targets: Vec<Point3<f64>>,
}

impl Builder<'_> {
    fn build(
        mut self,
        inside: Vec<(Point2<f64>, LatticePoint)>,
        mut rims: RimTriangulation,
    ) -> Result<Fill, FillError> {
        let mut hint: Option<FixedVertexHandle> = None;
        for (position, point) in inside {
            let vertex = self.target(position, point.border);
            hint = Some(insert(&mut rims.cdt, vertex, hint)?);
        }
        self.split_doubled_edges(&mut rims)?;
        let in_gap = rims.gap_faces(self.open).ok_or(FillError::Unbounded)?;
        let keep = if self.open {
            self.prune(&rims, &in_gap)
        } else {
            in_gap
        };
        let triangles: Vec<[u32; 3]> = (rims.faces())
            .filter(|face| keep[face.index()])
            .map(|face| {
                rims.cdt
                    .face(face)
                    .vertices()
                    .map(|vertex| vertex.data().index)
            })
            .collect();
        Ok(self.compact(triangles))
    }

    fn target(&mut self, position: Point2<f64>, border: bool) -> Vertex {
        let index = self.first_target + u32::try_from(self.targets.len()).unwrap_or(u32::MAX);
        self.targets.push(self.chart.to_surface(&position));
        Vertex {
            position,
            index,
            border,
        }
    }

    /// An edge of the fill between two rim vertices that the scan joins by an edge, too, would have
    /// four triangles: it gets a target in its middle.
    fn split_doubled_edges(&mut self, rims: &mut RimTriangulation) -> Result<(), FillError> {
        loop {
            let in_gap = rims.gap_faces(self.open).ok_or(FillError::Unbounded)?;
            let doubled: Vec<([u32; 2], Point2<f64>)> = (rims.cdt.undirected_edges())
                .filter(|edge| !edge.is_constraint_edge())
                .filter(|edge| {
                    let edge = edge.as_directed();
                    [edge.face(), edge.rev().face()]
                        .iter()
                        .all(|face| face.as_inner().is_some() && in_gap[face.fix().index()])
                })
                .map(|edge| edge.vertices().map(|vertex| *vertex.data()))
                .filter(|[a, b]| {
                    a.index < self.first_target
                        && b.index < self.first_target
                        && (self.adjacency.neighbors.row(a.index as usize))
                            .binary_search(&b.index)
                            .is_ok()
                })
                .map(|[a, b]| {
                    (
                        [a.index, b.index],
                        nalgebra::center(&a.position, &b.position),
                    )
                })
                .collect();
            if doubled.is_empty() {
                return Ok(());
            }
            for (edge, position) in doubled {
                let vertex = self.target(position, false);
                let before = rims.cdt.num_vertices();
                insert(&mut rims.cdt, vertex, None)?;
                if rims.cdt.num_vertices() == before {
                    return Err(FillError::RimCrosses { edge });
                }
            }
        }
    }

    /// The faces of an open-ended fill: not the caps beyond the last row, nor the long faces of the
    /// convex hull, nor slivers along the scan's own end.
    fn prune(&self, rims: &RimTriangulation, in_gap: &[bool]) -> Vec<bool> {
        let mut keep = vec![false; in_gap.len()];
        let mut all_rim = Vec::new();
        for face in rims.faces().filter(|face| in_gap[face.index()]) {
            let vertices = rims.cdt.face(face).vertices().map(|vertex| *vertex.data());
            if vertices.iter().all(|v| v.index < self.first_target) {
                all_rim.push(face);
                continue;
            }
            let points = vertices.map(|v| self.chart.to_surface(&v.position));
            let longest = (0..3)
                .map(|i| (points[i] - points[(i + 1) % 3]).norm())
                .fold(0.0, f64::max);
            keep[face.index()] = longest <= LONGEST_EXTENSION_EDGE * self.spacing
                && !vertices.iter().all(|v| v.border);
        }
        // Faces between rim vertices alone fill notches: kept where all around them is.
        loop {
            let (enclosed, rest): (Vec<_>, Vec<_>) = all_rim.into_iter().partition(|face| {
                rims.cdt.face(*face).adjacent_edges().iter().all(|edge| {
                    let other = edge.rev().face().fix().index();
                    edge.is_constraint_edge() || keep[other]
                })
            });
            for face in &enclosed {
                keep[face.index()] = true;
            }
            if enclosed.is_empty() {
                return keep;
            }
            all_rim = rest;
        }
    }

    /// Drops targets that no triangle uses.
    fn compact(self, mut triangles: Vec<[u32; 3]>) -> Fill {
        let mut new_index: Vec<Option<u32>> = vec![None; self.targets.len()];
        let mut targets = Vec::with_capacity(self.targets.len());
        for v in triangles.iter().flatten() {
            if let Some(t) = v.checked_sub(self.first_target) {
                new_index[t as usize] = Some(0);
            }
        }
        let mut next = self.first_target;
        for (t, slot) in new_index.iter_mut().enumerate() {
            if slot.is_some() {
                *slot = Some(next);
                next += 1;
                targets.push(self.targets[t]);
            }
        }
        for v in triangles.iter_mut().flatten() {
            if let Some(t) = v.checked_sub(self.first_target) {
                *v = new_index[t as usize].unwrap_or(*v);
            }
        }
        Fill {
            targets,
            triangles,
            islands: Vec::new(),
        }
    }
}
