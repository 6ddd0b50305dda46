//! Round pieces of a surface.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet};

use nalgebra::Point3;

use crate::mesh::{Adjacency, TriMesh, edges, vertex_areas};
use crate::rng::Rng;

/// Where so many times more places have no room for a disc, hardly any has.
const TRIES_A_DISC: usize = 50;

/// Between a piece and the nearest rim, in median edges: what is read around a vertex next to a rim is
/// not all known.
const RIM_MARGIN: f64 = 3.0;

/// Cuts discs out of a surface: vertices in the order of their distance from a centre, as far as they
/// hang together.
#[derive(Debug, Clone)]
pub struct Discs {
    positions: Vec<Point3<f64>>,
    adjacency: Adjacency,
    /// #V areas, 0 for vertices that do not count.
    areas: Vec<f64>,
    /// #V ways along edges to the next rim, or vertex that does not count.
    from_rim: Vec<f64>,
    step: f64,
}

impl Discs {
    /// Of a mesh and the vertices that may be in a disc; `step` is the median edge.
    ///
    /// # Panics
    /// If `allowed` has not one entry a vertex.
    #[must_use]
    pub fn new(mesh: &TriMesh, allowed: &[bool], step: f64) -> Self {
        assert_eq!(allowed.len(), mesh.positions.len(), "one entry a vertex");
        let adjacency = Adjacency::new(mesh);
        let mut areas = vertex_areas(mesh);
        let mut rim = Vec::new();
        for [a, b] in edges(mesh) {
            let (of_a, of_b) = (
                adjacency.triangles.row(a as usize),
                adjacency.triangles.row(b as usize),
            );
            let shared = of_a.iter().filter(|f| of_b.binary_search(f).is_ok());
            if shared.count() < 2 {
                rim.extend([a, b]);
            }
        }
        for (v, area) in (0u32..).zip(&mut areas) {
            if !allowed[v as usize] {
                *area = 0.0;
                rim.push(v);
            }
        }
        let from_rim = distances(&mesh.positions, &adjacency, &rim, f64::INFINITY);
        Self {
            positions: mesh.positions.clone(),
            adjacency,
            areas,
            from_rim,
            step,
        }
    }

    /// Area of all vertices that may be in a disc, in square units.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.areas.iter().sum()
    }

    /// The vertices, ascending, of a disc of (just about) the given area around a vertex; `None` if it
    /// would come too near to a rim.
    #[must_use]
    pub fn around(&self, center: u32, area: f64) -> Option<Vec<u32>> {
        self.grown(center, area, RIM_MARGIN * self.step)
    }

    fn grown(&self, center: u32, area: f64, margin: f64) -> Option<Vec<u32>> {
        let at = self.positions[center as usize];
        let mut disc = Vec::new();
        let mut covered = 0.0;
        let mut seen = HashSet::from([center]);
        let mut heap = BinaryHeap::from([Reverse((Ordered(0.0), center))]);
        while covered < area {
            let Reverse((_, v)) = heap.pop()?;
            if self.from_rim[v as usize] <= margin || self.areas[v as usize] <= 0.0 {
                return None;
            }
            covered += self.areas[v as usize];
            disc.push(v);
            for n in self.adjacency.neighbors.row(v as usize) {
                if seen.insert(*n) {
                    let distance_sq = (self.positions[*n as usize] - at).norm_squared();
                    heap.push(Reverse((Ordered(distance_sq), *n)));
                }
            }
        }
        disc.sort_unstable();
        Some(disc)
    }

    /// `count` discs around random vertices, away from rims as far as the surface is wide enough; fewer
    /// only if hardly any place has room for one.
    ///
    /// Discs overlap where the surface is small; no two have the same centre unless there are fewer
    /// centres than discs are asked for.
    #[must_use]
    pub fn random(&self, area: f64, count: usize, rng: &mut Rng) -> Vec<Vec<u32>> {
        let radius = (area / std::f64::consts::PI).sqrt();
        let mut centers: Vec<u32> = (0u32..)
            .zip(&self.from_rim)
            .filter(|(_, distance)| **distance > 0.8 * radius)
            .map(|(v, _)| v)
            .collect();
        let mut discs = Vec::new();
        // On narrow surfaces a disc may have to touch the rim, but never cross it.
        for margin in [RIM_MARGIN * self.step, 0.0] {
            let mut left = centers.clone();
            let mut tries = TRIES_A_DISC * count;
            while discs.len() < count && !left.is_empty() && tries > 0 {
                let center = left.swap_remove(rng.index(left.len()));
                discs.extend(self.grown(center, area, margin));
                tries -= 1;
            }
            if 2 * discs.len() >= count {
                break;
            }
            discs.clear();
            centers = (0u32..)
                .zip(&self.from_rim)
                .filter(|(_, distance)| **distance > 0.0)
                .map(|(v, _)| v)
                .collect();
        }
        discs
    }

    /// The vertices within `reach` (along edges) of the given ones.
    pub(super) fn near(&self, from: &[u32], reach: f64) -> Vec<u32> {
        let distances = distances(&self.positions, &self.adjacency, from, reach);
        (0u32..)
            .zip(distances)
            .filter(|(_, distance)| *distance <= reach)
            .map(|(v, _)| v)
            .collect()
    }

    /// The adjacency of the mesh.
    pub(super) fn adjacency(&self) -> &Adjacency {
        &self.adjacency
    }
}

/// Lengths of the shortest ways along edges from any of `from`, infinite beyond `reach`.
fn distances(
    positions: &[Point3<f64>],
    adjacency: &Adjacency,
    from: &[u32],
    reach: f64,
) -> Vec<f64> {
    let mut distances = vec![f64::INFINITY; positions.len()];
    let mut heap = BinaryHeap::new();
    for v in from {
        distances[*v as usize] = 0.0;
        heap.push(Reverse((Ordered(0.0), *v)));
    }
    while let Some(Reverse((Ordered(distance), v))) = heap.pop() {
        if distance > distances[v as usize] {
            continue;
        }
        for n in adjacency.neighbors.row(v as usize) {
            let length = (positions[*n as usize] - positions[v as usize]).norm();
            let there = distance + length;
            if there <= reach && there < distances[*n as usize] {
                distances[*n as usize] = there;
                heap.push(Reverse((Ordered(there), *n)));
            }
        }
    }
    distances
}

/// A distance that can be sorted.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ordered(f64);

impl Eq for Ordered {}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
