//! What the scanner saw: cutting a complete object without leaving loose ends.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::tessellate::{Tessellation, index, perpendicular, rounded};
use super::{Draw, SynthError, SynthParams, stream};
use crate::base::BaseSurface;
use crate::mesh::{Adjacency, DisjointSets, TriMesh};
use crate::rng::Rng;

/// Edges that stay between a hole and the rim.
const RIM_MARGIN: u32 = 3;
/// Bends of a hole's outline: waves a turn, from 2 (an ellipse) to this.
const MOST_BENDS: u32 = 7;
/// Largest amplitude of a bend of `m` waves is this over `m`, as a share of the radius; together at
/// most 0.29 of it.
const BEND: f64 = 0.18;
/// Clearance of a hole's middle from the rim, in radii of the hole: its farthest bend, and the
/// detours of walking along edges.
const CLEARANCE: f64 = 1.5;

/// The part of an object that the scanner saw. If both are given, the hole is cut into the view.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Part {
    /// Direction from the object to the scanner, of any length: only vertices whose base normal
    /// has a positive component along it are kept. A plane is seen whole, or not at all (an error).
    pub view: Option<Vector3<f64>>,
    /// Share of the vertices, in (0, 0.5], that one irregular, roughly round hole takes away. Its
    /// place follows from the seed; it never reaches the rim.
    pub hole: Option<f64>,
}

impl Part {
    /// The complete object.
    pub const FULL: Self = Self {
        view: None,
        hole: None,
    };

    /// The complete object but for a hole.
    #[must_use]
    pub fn hole(fraction: f64) -> Self {
        Self {
            hole: Some(fraction),
            ..Self::FULL
        }
    }

    /// What faces the scanner.
    #[must_use]
    pub fn view(direction: Vector3<f64>) -> Self {
        Self {
            view: Some(direction),
            ..Self::FULL
        }
    }
}

/// A cut object: the vertices that are left and its triangles between them.
pub(super) struct Cut {
    /// Indices in the complete object, ascending.
    pub(super) full_index: Vec<u32>,
    /// Triangles over positions in `full_index`.
    pub(super) triangles: Vec<[u32; 3]>,
}

pub(super) fn cut(surface: &Tessellation, params: &SynthParams) -> Result<Cut, SynthError> {
    let mut triangles = surface.triangles.clone();
    if let Some(direction) = params.part.view {
        let seen: Vec<bool> = surface
            .normals
            .iter()
            .map(|n| n.dot(&direction) > 0.0)
            .collect();
        triangles = keep(&triangles, &seen);
        if triangles.is_empty() {
            return Err(SynthError::NothingInView(params.kind));
        }
    }
    if let Some(fraction) = params.part.hole {
        let mut rng = stream(params.seed, Draw::Hole);
        let kept = punch(surface, &triangles, fraction, &mut rng)?;
        triangles = keep(&triangles, &kept);
    }
    Ok(renumber(surface.feet.len(), triangles))
}

/// Drops the vertices that no triangle uses.
fn renumber(vertices: usize, mut triangles: Vec<[u32; 3]>) -> Cut {
    let mut new_index = vec![u32::MAX; vertices];
    for v in triangles.iter().flatten() {
        new_index[*v as usize] = 0;
    }
    let mut full_index = Vec::new();
    for (old, new) in new_index.iter_mut().enumerate() {
        if *new == 0 {
            *new = index(full_index.len());
            full_index.push(index(old));
        }
    }
    for v in triangles.iter_mut().flatten() {
        *v = new_index[*v as usize];
    }
    Cut {
        full_index,
        triangles,
    }
}

/// For each vertex, whether it is left when a hole holds `fraction` of the vertices in use.
fn punch(
    surface: &Tessellation,
    triangles: &[[u32; 3]],
    fraction: f64,
    rng: &mut Rng,
) -> Result<Vec<bool>, SynthError> {
    let mesh = TriMesh {
        positions: surface.feet.clone(),
        triangles: triangles.to_vec(),
    };
    let from_rim = edges_from_rim(&mesh);
    let used: Vec<usize> = (0..surface.feet.len())
        .zip(mesh.used_vertices())
        .filter_map(|(v, used)| used.then_some(v))
        .collect();
    let count = rounded(fraction * used.len() as f64).max(1);
    let inner: Vec<usize> = used
        .into_iter()
        .filter(|v| from_rim[*v] >= RIM_MARGIN)
        .collect();
    if inner.len() < count {
        return Err(SynthError::HoleTooLarge(count));
    }

    // Each vertex owns √3/2 edge².
    let radius_in_edges = (0.75f64.sqrt() * count as f64 / PI).sqrt();
    let deepest = inner.iter().map(|v| from_rim[*v]).max().unwrap_or(0);
    let clearance = (CLEARANCE * radius_in_edges).min(f64::from(deepest));
    let middles: Vec<usize> = inner
        .iter()
        .copied()
        .filter(|v| f64::from(from_rim[*v]) >= clearance)
        .collect();
    let middle = middles[rng.index(middles.len())];

    let bends: Vec<(f64, f64, f64)> = (2..=MOST_BENDS)
        .map(|m| {
            let m = f64::from(m);
            (m, BEND / m * rng.uniform(), TAU * rng.uniform())
        })
        .collect();
    let mut by_distance: Vec<(f64, usize)> = inner
        .into_iter()
        .map(|v| {
            let place = seen_from(surface, middle, v);
            let angle = place.y.atan2(place.x);
            let bend: f64 = bends
                .iter()
                .map(|(m, amplitude, phase)| amplitude * (m * angle + phase).cos())
                .sum();
            (place.norm() / (1.0 + bend), v)
        })
        .collect();
    by_distance.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut kept = vec![true; surface.feet.len()];
    for (_, v) in &by_distance[..count] {
        kept[*v] = false;
    }
    Ok(kept)
}

/// Where vertex `v` lies as seen from `middle`: distance and direction along the base surface.
fn seen_from(surface: &Tessellation, middle: usize, v: usize) -> Vector2<f64> {
    let normal = surface.normals[middle];
    let apart = surface.feet[v] - surface.feet[middle];
    if let BaseSurface::Cylinder(cylinder) = surface.base {
        let tangent = cylinder.axis.cross(&normal);
        let other = surface.normals[v];
        let angle = other.dot(&tangent).atan2(other.dot(&normal));
        return Vector2::new(angle * cylinder.radius, apart.dot(&cylinder.axis));
    }
    let right = perpendicular(&normal);
    let flat = Vector2::new(apart.dot(&right), apart.dot(&normal.cross(&right)));
    match surface.base {
        BaseSurface::Sphere(sphere) => {
            let angle = normal.angle(&surface.normals[v]);
            flat.try_normalize(0.0).unwrap_or_default() * (angle * sphere.radius)
        }
        _ => flat,
    }
}

/// Number of edges from each vertex to the nearest rim; `u32::MAX` where there is none.
fn edges_from_rim(mesh: &TriMesh) -> Vec<u32> {
    let mut distance = vec![u32::MAX; mesh.positions.len()];
    let mut queue = VecDeque::new();
    let sides = sides(&mesh.triangles);
    for same_edge in sides.chunk_by(|a, b| a.edge == b.edge) {
        if let [rim] = same_edge {
            for v in rim.edge {
                if distance[v as usize] != 0 {
                    distance[v as usize] = 0;
                    queue.push_back(v);
                }
            }
        }
    }
    let adjacency = Adjacency::new(mesh);
    while let Some(v) = queue.pop_front() {
        for &n in adjacency.neighbors.row(v as usize) {
            if distance[n as usize] == u32::MAX {
                distance[n as usize] = distance[v as usize] + 1;
                queue.push_back(n);
            }
        }
    }
    distance
}

/// The triangles whose corners are all kept, without islands and bow ties: of pieces joined in at
/// most a vertex, the largest stays.
fn keep(triangles: &[[u32; 3]], kept: &[bool]) -> Vec<[u32; 3]> {
    let mut left: Vec<[u32; 3]> = triangles
        .iter()
        .copied()
        .filter(|t| t.iter().all(|v| kept[*v as usize]))
        .collect();
    loop {
        let before = left.len();
        left = largest_piece(&left);
        left = without_bow_ties(&left);
        if left.len() == before {
            return left;
        }
    }
}

/// The most triangles that hang together by edges.
fn largest_piece(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut pieces = DisjointSets::new(triangles.len());
    for (a, b) in neighbors(&sides(triangles)) {
        pieces.join(a.triangle, b.triangle);
    }
    let pieces = pieces.into_lowest();
    let mut sizes = vec![0usize; triangles.len()];
    for piece in &pieces {
        sizes[*piece as usize] += 1;
    }
    let largest = first_largest((0u32..).zip(sizes));
    let of_piece = triangles.iter().zip(&pieces);
    of_piece
        .filter(|(_, piece)| Some(**piece) == largest)
        .map(|(t, _)| *t)
        .collect()
}

/// Where triangles at a vertex form more than one fan, only the largest fan stays.
fn without_bow_ties(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let corner = |triangle: u32, v: u32| {
        let mut corners = (3 * triangle..).zip(triangles[triangle as usize]);
        let found = corners.find(|(_, at)| *at == v);
        found
            .expect("an edge's ends are corners of its triangles")
            .0
    };
    let mut fans = DisjointSets::new(3 * triangles.len());
    for (a, b) in neighbors(&sides(triangles)) {
        for v in a.edge {
            fans.join(corner(a.triangle, v), corner(b.triangle, v));
        }
    }
    let mut corners: Vec<(u32, u32, usize)> = fans
        .into_lowest()
        .into_iter()
        .enumerate()
        .map(|(corner, fan)| (triangles[corner / 3][corner % 3], fan, corner))
        .collect();
    corners.sort_unstable();
    let mut stays = vec![true; triangles.len()];
    for at_vertex in corners.chunk_by(|a, b| a.0 == b.0) {
        let fans = at_vertex.chunk_by(|a, b| a.1 == b.1);
        let largest = first_largest(fans.map(|fan| (fan[0].1, fan.len())));
        for (_, fan, corner) in at_vertex {
            stays[corner / 3] &= Some(*fan) == largest;
        }
    }
    let staying = triangles.iter().zip(stays);
    staying
        .filter_map(|(t, stays)| stays.then_some(*t))
        .collect()
}

/// The first name with the largest size.
fn first_largest(sizes: impl Iterator<Item = (u32, usize)>) -> Option<u32> {
    sizes
        .reduce(|best, next| if next.1 > best.1 { next } else { best })
        .map(|(name, _)| name)
}

/// One side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// Lower and higher vertex.
    edge: [u32; 2],
    triangle: u32,
}

/// All sides, those of the same edge next to each other.
fn sides(triangles: &[[u32; 3]]) -> Vec<Side> {
    let mut sides: Vec<Side> = triangles
        .iter()
        .zip(0u32..)
        .flat_map(|(&[a, b, c], triangle)| {
            [[a, b], [b, c], [c, a]].map(|[a, b]| Side {
                edge: [a.min(b), a.max(b)],
                triangle,
            })
        })
        .collect();
    sides.sort_unstable();
    sides
}

/// Pairs of sides of one edge.
fn neighbors(sides: &[Side]) -> impl Iterator<Item = (Side, Side)> {
    sides
        .windows(2)
        .filter(|pair| pair[0].edge == pair[1].edge)
        .map(|pair| (pair[0], pair[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn islands_and_bow_ties_go() {
        // A strip of three, one more triangle that touches it in vertex 2, and an island.
        let strip = [[0, 1, 2], [2, 1, 3], [2, 3, 4]];
        let mut triangles = strip.to_vec();
        triangles.extend([[2, 5, 6], [7, 8, 9]]);
        assert_eq!(keep(&triangles, &[true; 10]), strip);

        // A ring of triangles that closes in vertex 0 only: the lesser fan at 0 goes.
        let ring = [
            [0, 1, 2],
            [1, 3, 2],
            [2, 3, 4],
            [3, 5, 4],
            [4, 5, 0],
            [1, 0, 6],
        ];
        let kept = keep(&ring, &[true; 7]);
        assert_eq!(kept.len(), 5);
        assert!(!kept.contains(&[4, 5, 0]));
    }

    #[test]
    fn removing_a_vertex_removes_its_triangles_and_what_they_alone_used() {
        let mut kept = [true; 5];
        kept[3] = false;
        let cut = renumber(5, keep(&[[0, 1, 2], [2, 1, 3], [2, 3, 4]], &kept));
        assert_eq!(cut.full_index, [0, 1, 2]);
        assert_eq!(cut.triangles, [[0, 1, 2]]);
    }
}
