//! A hole with as much of the scan as its completion looks at.

use std::collections::HashSet;

use crate::mesh::{Adjacency, BoundaryLoop, TriMesh};
use crate::sampling::Gap;

use super::patch::{Added, NumberedGap};
use super::{Input, index};

/// A hole's own base is fitted to at least this many vertices around it, and …
const SURROUNDING_VERTICES: usize = 400;
/// … to this many times as many as it is predicted to need itself.
const SURROUNDING_RATIO: f64 = 4.0;
/// The narrow surroundings of a hole have this many times as many vertices as its rim: about three
/// rings.
const NARROW_RATIO: usize = 3;

/// The part of a scan around a hole: with many holes, work on the whole scan for each would be too much.
#[derive(Debug)]
pub(super) struct Surroundings {
    /// The part: what is looked at to fit a base, and what a window on the hole or on an island in
    /// it can reach.
    pub(super) part: Part,
    /// The hole, by vertices of the part.
    pub(super) gap: NumberedGap,
    /// Its loop, by vertices of the part.
    pub(super) boundary: BoundaryLoop,
    /// Whether a vertex of the part belongs to the wide surroundings: enough to fit, and to copy the
    /// hole's relief from.
    pub(super) wide: Vec<bool>,
    /// Whether it belongs to the narrow ones: next to the rim.
    pub(super) narrow: Vec<bool>,
}

/// Some vertices of a scan, as a scan of its own with its own numbers of vertices.
#[derive(Debug)]
pub(super) struct Part {
    /// The part, without loops.
    pub(super) input: Input,
    /// The scan's vertex of each of the part, ascending.
    vertices: Vec<u32>,
}

impl Surroundings {
    /// The surroundings of a gap with one rim, for windows of a radius in edges.
    pub(super) fn new(input: &Input, gap: &NumberedGap, window: usize) -> Self {
        let boundary = &input.loops[gap.rim_ids[0]];
        let enough = enough_vertices(input, boundary);
        let few = NARROW_RATIO * boundary.vertices.len();
        let rim = &boundary.vertices;
        let (wide, rings) = around(&input.adjacency, rim, |_, count| count < enough);
        let (narrow, _) = around(&input.adjacency, rim, |_, count| count < few);
        // One ring more, so that all triangles of every vertex are there.
        let reach = |ring: usize, rings: usize| ring <= rings.max(window);
        let (mut vertices, _) = around(&input.adjacency, rim, |ring, _| reach(ring, rings));
        let islands: Vec<u32> = gap.gap.islands.iter().flatten().copied().collect();
        let (beyond, _) = around(&input.adjacency, &islands, |ring, _| reach(ring, 0));
        vertices.extend(beyond);
        let part = Part::new(input, vertices);
        let flags = |region: &[u32]| {
            let mut flags = vec![false; part.vertices.len()];
            for v in part.renumbered(region) {
                flags[v as usize] = true;
            }
            flags
        };
        Self {
            gap: part.gap(gap),
            boundary: BoundaryLoop {
                vertices: part.renumbered(rim),
                ..boundary.clone()
            },
            wide: flags(&wide),
            narrow: flags(&narrow),
            part,
        }
    }
}

impl Part {
    fn new(input: &Input, mut vertices: Vec<u32>) -> Self {
        vertices.sort_unstable();
        vertices.dedup();
        Self {
            input: part(input, &vertices),
            vertices,
        }
    }

    /// The whole scan, or if it has more vertices than `most` about as many around the gaps.
    pub(super) fn around(input: &Input, gaps: &[NumberedGap], most: usize) -> Self {
        if input.mesh.positions.len() <= most {
            return Self::new(input, (0..index(input.mesh.positions.len())).collect());
        }
        let found = around(&input.adjacency, &rims(gaps), |_, count| count < most);
        Self::new(input, found.0)
    }

    /// The vertices at most so many edges from the gaps.
    pub(super) fn within(input: &Input, gaps: &[NumberedGap], rings: usize) -> Self {
        let found = around(&input.adjacency, &rims(gaps), |ring, _| ring <= rings);
        Self::new(input, found.0)
    }

    /// Of the scan's values those of the part.
    pub(super) fn chosen<T: Copy>(&self, values: &[T]) -> Vec<T> {
        chosen(values, &self.vertices)
    }

    /// Puts the part's values to the scan's.
    pub(super) fn put_back<T: Copy>(&self, own: &[T], values: &mut [T]) {
        for (v, value) in self.vertices.iter().zip(own) {
            values[*v as usize] = *value;
        }
    }

    fn renumbered(&self, old: &[u32]) -> Vec<u32> {
        (old.iter())
            .map(|v| number(&self.vertices, *v).expect("rims and rings are in it"))
            .collect()
    }

    /// A gap by vertices of the part.
    pub(super) fn gap(&self, gap: &NumberedGap) -> NumberedGap {
        let renumbered =
            |loops: &[Vec<u32>]| loops.iter().map(|rim| self.renumbered(rim)).collect();
        NumberedGap {
            gap: Gap {
                rims: renumbered(&gap.gap.rims),
                islands: renumbered(&gap.gap.islands),
                extend_over: None,
            },
            rim_ids: gap.rim_ids.clone(),
            island_ids: gap.island_ids.clone(),
        }
    }

    /// What was added to the part by the numbers of the scan.
    pub(super) fn renumber(&self, input: &Input, added: &mut Added) {
        let first_target = self.vertices.len();
        let number = |v: u32| match (v as usize).checked_sub(first_target) {
            None => self.vertices[v as usize],
            Some(target) => index(input.mesh.positions.len() + target),
        };
        for source in &mut added.sources {
            *source = number(*source);
        }
        for triangle in &mut added.triangles {
            *triangle = triangle.map(number);
        }
    }

    /// Values of the part's vertices as values of the scan's `count`; NaN for the others.
    pub(super) fn spread(&self, values: &[f64], count: usize) -> Vec<f64> {
        let mut spread = vec![f64::NAN; count];
        self.put_back(values, &mut spread);
        spread
    }
}

/// Some vertices of the scan, ascending, with the triangles between them.
fn part(input: &Input, vertices: &[u32]) -> Input {
    let mut faces: Vec<u32> = (vertices.iter())
        .flat_map(|v| input.adjacency.triangles.row(*v as usize))
        .copied()
        .collect();
    faces.sort_unstable();
    faces.dedup();
    let triangles = (faces.iter())
        .map(|f| input.mesh.triangles[*f as usize].map(|v| number(vertices, v)))
        .filter_map(|[a, b, c]| Some([a?, b?, c?]))
        .collect();
    let mesh = TriMesh {
        positions: chosen(&input.mesh.positions, vertices),
        triangles,
    };
    Input {
        adjacency: Adjacency::new(&mesh),
        loops: Vec::new(),
        colors: (input.colors.as_ref()).map(|colors| chosen(colors, vertices)),
        spacing: input.spacing,
        scanned: chosen(&input.scanned, vertices),
        strays: 0,
        mesh,
    }
}

/// The vertices of the loops around gaps.
fn rims(gaps: &[NumberedGap]) -> Vec<u32> {
    let loops = (gaps.iter()).flat_map(|gap| gap.gap.rims.iter().chain(&gap.gap.islands));
    loops.flatten().copied().collect()
}

/// The part's number of a vertex.
fn number(vertices: &[u32], v: u32) -> Option<u32> {
    vertices.binary_search(&v).ok().map(index)
}

fn chosen<T: Copy>(values: &[T], vertices: &[u32]) -> Vec<T> {
    vertices.iter().map(|v| values[*v as usize]).collect()
}

/// Size of the wide surroundings.
fn enough_vertices(input: &Input, boundary: &BoundaryLoop) -> usize {
    let needed = boundary.area / input.spacing.spacing.powi(2);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturating"
    )]
    let enough = (SURROUNDING_RATIO * needed) as usize;
    enough
        .max(SURROUNDING_VERTICES)
        .max(2 * boundary.vertices.len())
}

/// The vertices around a loop ring by ring, while `wanted` says so of the number of rings and of
/// vertices so far; and the number of rings.
pub(super) fn around(
    adjacency: &Adjacency,
    start: &[u32],
    wanted: impl Fn(usize, usize) -> bool,
) -> (Vec<u32>, usize) {
    let mut seen = HashSet::new();
    let (mut found, mut rings) = (Vec::new(), 0);
    let mut ring = start.to_vec();
    while !ring.is_empty() && wanted(rings, found.len()) {
        let mut next = Vec::new();
        for v in ring {
            if seen.insert(v) {
                found.push(v);
                next.extend(adjacency.neighbors.row(v as usize));
            }
        }
        ring = next;
        rings += 1;
    }
    (found, rings)
}
