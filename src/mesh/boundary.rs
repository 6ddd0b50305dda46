//! Boundary loops, and whether each bounds a hole or is an outer rim.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use serde::Serialize;

use super::{Adjacency, Csr, TriMesh};

/// What is beyond a boundary loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LoopKind {
    /// A gap in the surface.
    Hole,
    /// The end of the surface.
    Rim,
}

/// A closed walk along edges that have one triangle only, the hole on its left.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundaryLoop {
    /// Number of the loop: 0 is the longest.
    pub id: usize,
    /// Its vertices in walking order, the first not repeated; the hole is on the left as seen from
    /// outside.
    #[serde(skip)]
    pub vertices: Vec<u32>,
    /// Length, in the scan's unit.
    pub length: f64,
    /// Estimated area of what it encloses (the length of its vector area), in square units.
    pub area: f64,
    /// Hole or outer rim, see [`boundary_loops`].
    pub kind: LoopKind,
    /// Total geodesic curvature in radians, walked with the surface on the left: −2π around a hole
    /// in a flat surface, 2π along the outer rim of a flat piece, 0 at the end of a tube.
    pub turning: f64,
    /// Connected component of the mesh that it bounds.
    pub component: u32,
    /// Numbers of other loops that have a vertex in common with it, ascending.
    pub touches: Vec<usize>,
    /// An edge on the way where three or more triangles meet, or where two are oriented against
    /// each other: such a loop cannot be filled as it is.
    pub defect: Option<[u32; 2]>,
}

/// Total geodesic curvature above which a loop is an outer rim. On a plane holes have −2π and rims
/// 2π; on a sphere a hole that takes a quarter of it has −π, so what is larger counts as the end of
/// what the scanner saw, not as a hole in it. By Gauss–Bonnet the figure depends on the loop and
/// the curvature beside it, not on how ragged the loop is.
const RIM_TURNING: f64 = -std::f64::consts::PI;

/// Rounds of umbrella smoothing before angles are summed, so that rough relief and depth noise at
/// the rim do not pass for curvature.
const SMOOTHING_ROUNDS: usize = 5;

/// All boundary loops, longest first.
///
/// Where gaps touch in a point, they stay apart: each loop passes a vertex once. So a hole that touches
/// the outer rim is a hole, while a notch, which opens into the outside along more than a point, is part of
/// the rim.
#[must_use]
pub fn boundary_loops(mesh: &TriMesh, adjacency: &Adjacency) -> Vec<BoundaryLoop> {
    let walker = Walker { mesh, adjacency };
    let (components, _) = adjacency.components();
    let smooth = smoothed_positions(mesh, adjacency, SMOOTHING_ROUNDS);
    let mut seen = std::collections::HashSet::new();
    let mut loops = Vec::new();
    for (f, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if walker.is_boundary(from, to) && !seen.contains(&(f, from)) {
                let walk = walker.walk(f, from, to, &smooth, &mut seen);
                for part in walk.parts(&smooth) {
                    loops.push(part.into_loop(mesh, components[from as usize]));
                }
            }
        }
    }
    loops.sort_by(|x, y| (y.length.total_cmp(&x.length)).then_with(|| x.vertices.cmp(&y.vertices)));
    for (id, boundary) in loops.iter_mut().enumerate() {
        boundary.id = id;
    }
    tell_touching(&mut loops);
    loops
}

fn tell_touching(loops: &mut [BoundaryLoop]) {
    let mut visits: Vec<(u32, usize)> = (loops.iter())
        .flat_map(|l| l.vertices.iter().map(move |v| (*v, l.id)))
        .collect();
    visits.sort_unstable();
    for here in visits.chunk_by(|a, b| a.0 == b.0).filter(|h| h.len() > 1) {
        for (_, id) in here {
            let others = here.iter().map(|(_, other)| *other);
            let others: Vec<usize> = others.filter(|other| other != id).collect();
            loops[*id].touches.extend(others);
        }
    }
    for boundary in loops {
        boundary.touches.sort_unstable();
        boundary.touches.dedup();
    }
}

struct Walker<'a> {
    mesh: &'a TriMesh,
    adjacency: &'a Adjacency,
}

/// What a walk met, the surface on its left.
struct Walk {
    visits: Vec<Visit>,
    defect: Option<[u32; 2]>,
}

#[derive(Clone, Copy)]
struct Visit {
    vertex: u32,
    /// Angle of the surface to the left, in radians.
    angle: f64,
}

impl Walker<'_> {
    /// Triangles that hold both vertices, ascending.
    ///
    /// Looked for at the vertex with fewer of them: so the time for all edges of a surface together grows
    /// with their number, even where thousands of triangles meet in a vertex. The sum of the smaller degree
    /// over all edges of a graph is at most twice its edges times its arboricity, which is 3 for planar
    /// graphs (Chiba & Nishizeki, *Arboricity and subgraph listing algorithms*, 1985).
    fn triangles_at(&self, a: u32, b: u32) -> impl Iterator<Item = usize> {
        let [at_a, at_b] = [a, b].map(|v| self.adjacency.triangles.row(v as usize));
        let (few, other) = if at_a.len() <= at_b.len() {
            (at_a, b)
        } else {
            (at_b, a)
        };
        few.iter()
            .map(|f| *f as usize)
            .filter(move |f| self.mesh.triangles[*f].contains(&other))
    }

    /// Whether there is one triangle only that holds both vertices.
    fn is_boundary(&self, a: u32, b: u32) -> bool {
        self.triangles_at(a, b).take(2).count() == 1
    }

    /// Walks from the boundary half-edge `from → to` of triangle `f` until it comes back.
    fn walk(
        &self,
        f: usize,
        from: u32,
        to: u32,
        positions: &[Point3<f64>],
        seen: &mut std::collections::HashSet<(usize, u32)>,
    ) -> Walk {
        let mut walk = Walk {
            visits: Vec::new(),
            defect: None,
        };
        let (mut face, mut tail, mut head) = (f, from, to);
        while seen.insert((face, tail)) {
            if !self.runs_along(face, tail, head) {
                walk.defect.get_or_insert([tail, head]);
            }
            // Turn around `head` through its fan until the next edge with one triangle.
            let mut angle = 0.0;
            let mut spoke = tail;
            for _ in 0..self.adjacency.triangles.row(head as usize).len() {
                let next = third(self.mesh.triangles[face], spoke, head);
                angle += corner_angle(positions, head, spoke, next);
                spoke = next;
                let mut others = self.triangles_at(head, spoke).filter(|g| *g != face);
                match (others.next(), others.next()) {
                    (None, _) => break,
                    (Some(g), None) => face = g,
                    (Some(g), Some(_)) => {
                        walk.defect.get_or_insert([head, spoke]);
                        face = g;
                    }
                }
            }
            walk.visits.push(Visit {
                vertex: head,
                angle,
            });
            (tail, head) = (head, spoke);
        }
        walk
    }

    /// Whether triangle `f` has the half-edge `a → b` in this direction.
    fn runs_along(&self, f: usize, a: u32, b: u32) -> bool {
        let [x, y, z] = self.mesh.triangles[f];
        [(x, y), (y, z), (z, x)].contains(&(a, b))
    }
}

impl Walk {
    /// The walk in parts that pass each vertex once: where it comes back to a vertex, gaps touch in a
    /// point, and what it walked since then is around a gap of its own.
    fn parts(self, positions: &[Point3<f64>]) -> Vec<Self> {
        let mut fans: HashMap<u32, Vec<f64>> = HashMap::new();
        for visit in &self.visits {
            fans.entry(visit.vertex).or_default().push(visit.angle);
        }
        if fans.len() == self.visits.len() {
            return vec![self];
        }
        let mut parts: Vec<Vec<Visit>> = Vec::new();
        let (mut open, mut place) = (Vec::<Visit>::new(), HashMap::new());
        for visit in self.visits {
            if let Some(start) = place.get(&visit.vertex).copied() {
                let part = open.split_off(start);
                for v in &part {
                    place.remove(&v.vertex);
                }
                parts.push(part);
            }
            place.insert(visit.vertex, open.len());
            open.push(visit);
        }
        parts.push(open);
        // An edge walked to and fro is around nothing.
        parts.retain(|part| part.len() > 2);
        set_pinched_angles(&mut parts, &fans, positions);
        let parts = parts.into_iter().map(|visits| {
            let passes = |v: u32| visits.iter().any(|visit| visit.vertex == v);
            Self {
                defect: self.defect.filter(|[a, b]| passes(*a) && passes(*b)),
                visits,
            }
        });
        parts.collect()
    }

    /// Total geodesic curvature.
    fn turning(&self) -> f64 {
        let turns = self.visits.iter().map(|v| std::f64::consts::PI - v.angle);
        turns.sum()
    }

    fn into_loop(self, mesh: &TriMesh, component: u32) -> BoundaryLoop {
        let turning = self.turning();
        let mut vertices: Vec<u32> = self.visits.iter().map(|visit| visit.vertex).collect();
        vertices.reverse();
        // Start at the lowest vertex, so that the order of the triangles does not show.
        let start = (0..vertices.len())
            .min_by_key(|i| vertices[*i])
            .unwrap_or(0);
        vertices.rotate_left(start);
        let points: Vec<_> = vertices
            .iter()
            .map(|v| mesh.positions[*v as usize])
            .collect();
        let length = (0..points.len())
            .map(|i| (points[(i + 1) % points.len()] - points[i]).norm())
            .sum();
        BoundaryLoop {
            id: 0,
            length,
            area: vector_area(&points).norm(),
            kind: if turning > RIM_TURNING {
                LoopKind::Rim
            } else {
                LoopKind::Hole
            },
            turning,
            component,
            touches: Vec::new(),
            defect: self.defect,
            vertices,
        }
    }
}

/// Sets the angles where parts of one walk touch: what is to the left of a part there is everything but its
/// own gap.
///
/// The angle of a gap follows from its two edges, but for whether it is more or less than half a turn; of
/// the gaps at a vertex at most one is more, and together with the surface they make about a whole turn.
fn set_pinched_angles(
    parts: &mut [Vec<Visit>],
    fans: &HashMap<u32, Vec<f64>>,
    positions: &[Point3<f64>],
) {
    use std::f64::consts::TAU;
    // Vertex, part, place in the part, angle between its edges.
    let mut pinched: Vec<(u32, usize, usize, f64)> = Vec::new();
    for (p, part) in parts.iter().enumerate() {
        for (i, visit) in part.iter().enumerate() {
            if fans[&visit.vertex].len() > 1 {
                let [before, after] =
                    [i + part.len() - 1, i + 1].map(|j| part[j % part.len()].vertex);
                let angle = corner_angle(positions, visit.vertex, before, after);
                pinched.push((visit.vertex, p, i, angle));
            }
        }
    }
    pinched.sort_by_key(|(vertex, p, i, _)| (*vertex, *p, *i));
    for gaps in pinched.chunk_by(|a, b| a.0 == b.0) {
        let surface: f64 = fans[&gaps[0].0].iter().sum();
        let sum: f64 = gaps.iter().map(|gap| gap.3).sum();
        let misfit = |wide: Option<usize>| {
            let more = wide.map_or(0.0, |wide| TAU - 2.0 * gaps[wide].3);
            (surface + sum + more - TAU).abs()
        };
        let choices = std::iter::once(None).chain((0..gaps.len()).map(Some));
        let wide = choices.min_by(|a, b| misfit(*a).total_cmp(&misfit(*b)));
        for (k, (_, p, i, angle)) in gaps.iter().enumerate() {
            parts[*p][*i].angle = if wide == Some(Some(k)) {
                *angle
            } else {
                TAU - angle
            };
        }
    }
}

/// Vector area of a closed polygon: for a plane polygon its area times the normal of the side from
/// which it runs counterclockwise.
#[must_use]
pub fn vector_area(polygon: &[Point3<f64>]) -> Vector3<f64> {
    let Some(first) = polygon.first() else {
        return Vector3::zeros();
    };
    let mut sum = Vector3::zeros();
    for pair in polygon.windows(2) {
        sum += (pair[0] - first).cross(&(pair[1] - first));
    }
    sum * 0.5
}

/// The corner of a triangle that is neither `a` nor `b`.
fn third(triangle: [u32; 3], a: u32, b: u32) -> u32 {
    triangle
        .into_iter()
        .find(|v| *v != a && *v != b)
        .unwrap_or(a)
}

fn corner_angle(positions: &[Point3<f64>], at: u32, b: u32, c: u32) -> f64 {
    let at = positions[at as usize];
    let (b, c) = (positions[b as usize] - at, positions[c as usize] - at);
    b.angle(&c)
}

/// Some rounds of umbrella smoothing, halfway to the neighbors' mean each; boundary vertices move along the
/// boundary only.
#[must_use]
pub fn smoothed_positions(
    mesh: &TriMesh,
    adjacency: &Adjacency,
    rounds: usize,
) -> Vec<Point3<f64>> {
    let walker = Walker { mesh, adjacency };
    // Of boundary vertices, the neighbors along the boundary.
    let mut along = Csr::default();
    let mut row = Vec::new();
    for v in (0u32..).take(mesh.positions.len()) {
        row.clear();
        let neighbors = adjacency.neighbors.row(v as usize).iter().copied();
        row.extend(neighbors.filter(|n| walker.is_boundary(v, *n)));
        along.push_row(&row);
    }
    let averaged = |v: usize| match along.row(v) {
        [] => adjacency.neighbors.row(v),
        along => along,
    };
    let mut positions = mesh.positions.clone();
    for _ in 0..rounds {
        positions = (0..positions.len())
            .into_par_iter()
            .map(|v| {
                let neighbors = averaged(v);
                if neighbors.is_empty() {
                    return positions[v];
                }
                let sum: Vector3<f64> = (neighbors.iter())
                    .map(|n| positions[*n as usize].coords)
                    .sum();
                nalgebra::center(&positions[v], &Point3::from(sum / neighbors.len() as f64))
            })
            .collect();
    }
    positions
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::TAU;

    /// A flat n × n grid of squares of side 1 without the squares of `holes`.
    fn grid(n: u32, holes: &[[u32; 2]]) -> TriMesh {
        let id = |i: u32, j: u32| i * (n + 1) + j;
        let positions = (0..=n)
            .flat_map(|i| (0..=n).map(move |j| Point3::new(f64::from(i), f64::from(j), 0.0)))
            .collect();
        let triangles = (0..n)
            .flat_map(|i| (0..n).map(move |j| [i, j]))
            .filter(|square| !holes.contains(square))
            .flat_map(|[i, j]| {
                [
                    [id(i, j), id(i + 1, j), id(i + 1, j + 1)],
                    [id(i, j), id(i + 1, j + 1), id(i, j + 1)],
                ]
            })
            .collect();
        TriMesh {
            positions,
            triangles,
        }
    }

    fn loops(mesh: &TriMesh) -> Vec<BoundaryLoop> {
        boundary_loops(mesh, &Adjacency::new(mesh))
    }

    #[test]
    fn a_hole_in_a_sheet_is_told_from_its_outer_rim() {
        let loops = loops(&grid(6, &[[2, 2], [2, 3]]));
        assert_eq!(loops.len(), 2);
        assert_eq!(loops[0].kind, LoopKind::Rim);
        assert_relative_eq!(loops[0].length, 24.0);
        assert_relative_eq!(loops[0].area, 36.0, epsilon = 1e-12);
        assert_relative_eq!(loops[0].turning, TAU, epsilon = 1e-9);
        assert_eq!(loops[1].kind, LoopKind::Hole);
        assert_relative_eq!(loops[1].length, 6.0);
        assert_relative_eq!(loops[1].area, 2.0, epsilon = 1e-12);
        assert_relative_eq!(loops[1].turning, -TAU, epsilon = 1e-9);
    }

    #[test]
    fn the_hole_is_on_the_left() {
        let mesh = grid(4, &[[1, 1]]);
        let loops = loops(&mesh);
        let polygon = |i: usize| -> Vec<_> {
            (loops[i].vertices.iter())
                .map(|v| mesh.positions[*v as usize])
                .collect()
        };
        assert!(vector_area(&polygon(1)).z > 0.0);
        assert!(vector_area(&polygon(0)).z < 0.0);
    }

    #[test]
    fn loops_that_touch_in_a_vertex_stay_apart() {
        for holes in [[[2, 2], [3, 3]], [[2, 3], [3, 2]]] {
            let loops = loops(&grid(6, &holes));
            let sizes: Vec<_> = loops.iter().map(|l| l.vertices.len()).collect();
            // Through the common corner's two fans one walk leads around both.
            assert_eq!(sizes, [24, 4, 4]);
            assert_relative_eq!(loops[1].turning, -TAU, epsilon = 1e-9);
            assert_relative_eq!(loops[2].turning, -TAU, epsilon = 1e-9);
            assert!(loops[0].touches.is_empty());
            assert_eq!([&loops[1].touches[..], &loops[2].touches], [[2], [1]]);
            assert!(loops.iter().all(|l| l.defect.is_none()));
        }
    }

    #[test]
    fn a_hole_that_touches_the_rim_is_a_hole_and_a_notch_is_rim() {
        // A square at a corner of the sheet is missing, and the next one across: the hole touches the
        // notch.
        let touching = loops(&grid(6, &[[0, 0], [1, 1]]));
        let told: Vec<_> = touching
            .iter()
            .map(|l| (l.kind, l.vertices.len()))
            .collect();
        assert_eq!(told, [(LoopKind::Rim, 24), (LoopKind::Hole, 4)]);
        assert_relative_eq!(touching[0].turning, TAU, epsilon = 1e-9);
        assert_relative_eq!(touching[1].turning, -TAU, epsilon = 1e-9);
        assert_eq!(touching[1].touches, [0]);
        let notched = loops(&grid(6, &[[0, 2], [1, 2], [2, 2]]));
        let told: Vec<_> = notched.iter().map(|l| (l.kind, l.vertices.len())).collect();
        assert_eq!(told, [(LoopKind::Rim, 30)]);
    }

    #[test]
    fn holes_around_a_vertex_are_each_one() {
        let mut mesh = grid(6, &[]);
        let center = 3 * 7 + 3;
        let at_center: Vec<usize> = (0..mesh.triangles.len())
            .filter(|f| mesh.triangles[*f].contains(&center))
            .collect();
        assert_eq!(at_center.len(), 6);
        // Every second of the six triangles around it.
        let fan = around(&mesh, center, &at_center);
        for f in [fan[0], fan[2], fan[4]] {
            mesh.triangles[f] = [0, 0, 0];
        }
        mesh.triangles.retain(|t| *t != [0, 0, 0]);
        let loops = loops(&mesh);
        let told: Vec<_> = loops.iter().map(|l| (l.kind, l.vertices.len())).collect();
        let hole = (LoopKind::Hole, 3);
        assert_eq!(told, [(LoopKind::Rim, 24), hole, hole, hole]);
        for l in &loops[1..] {
            assert_relative_eq!(l.turning, -TAU, epsilon = 1e-9);
        }
    }

    /// The triangles around a vertex in their order.
    fn around(mesh: &TriMesh, center: u32, triangles: &[usize]) -> Vec<usize> {
        let c = mesh.positions[center as usize];
        let mut sorted = triangles.to_vec();
        let angle = |f: usize| {
            let [p, q, r] = mesh.corners(f);
            let d = (p.coords + q.coords + r.coords) / 3.0 - c.coords;
            d.y.atan2(d.x)
        };
        sorted.sort_by(|f, g| angle(*f).total_cmp(&angle(*g)));
        sorted
    }

    #[test]
    fn both_ends_of_a_tube_are_rims_and_a_hole_in_its_wall_is_one() {
        let n = 24u32;
        let id = |i: u32, j: u32| i * n + j % n;
        let positions = (0..20)
            .flat_map(|i| {
                (0..n).map(move |j| {
                    let angle = TAU * f64::from(j) / f64::from(n);
                    Point3::new(angle.cos(), angle.sin(), f64::from(i) * 0.2)
                })
            })
            .collect();
        let triangles = (0..19)
            .flat_map(|i| (0..n).map(move |j| [i, j]))
            .filter(|square| ![[9, 3], [9, 4], [10, 3], [10, 4]].contains(square))
            .flat_map(|[i, j]| {
                [
                    [id(i, j), id(i, j + 1), id(i + 1, j + 1)],
                    [id(i, j), id(i + 1, j + 1), id(i + 1, j)],
                ]
            })
            .collect();
        let kinds: Vec<_> = loops(&TriMesh {
            positions,
            triangles,
        })
        .iter()
        .map(|l| l.kind)
        .collect();
        assert_eq!(kinds, [LoopKind::Rim, LoopKind::Rim, LoopKind::Hole]);
    }

    #[test]
    fn flipped_and_surplus_triangles_at_the_rim_are_named() {
        let mut mesh = grid(4, &[[1, 1]]);
        mesh.triangles[0].swap(0, 1);
        assert!(loops(&mesh).iter().any(|l| l.defect.is_some()));
        let mut mesh = grid(2, &[]);
        mesh.positions.push(Point3::new(0.5, 0.5, 1.0));
        let [a, b, _] = mesh.triangles[0];
        mesh.triangles.push([a, b, 9]);
        mesh.triangles.push([b, a, 9]);
        assert!(loops(&mesh).iter().any(|l| l.defect.is_some()));
    }
}
