//! A triangulated surface that can be walked on.

use nalgebra::{Point3, Vector3};

use crate::mesh::{ALONE, TriMesh, opposite_half_edges, spatial_order};

/// No triangle.
const NONE: u32 = u32::MAX;

/// A step crosses at most this many edges, so that rounding cannot keep a walk in circles.
const MOST_CROSSINGS: usize = 4096;

/// A triangle lower than this share of its longest edge is taken for as high as that, so that one can
/// walk through it.
const LEAST_ASPECT: f64 = 1e-4;

/// How far outside of a triangle, in barycentric coordinates, a point still counts as inside: rounding
/// must not send a walk back and forth over an edge.
const EDGE_SLACK: f32 = 1e-5;

/// A triangulated surface, laid out for walking: every triangle has flat coordinates of its own, with
/// its first corner in the origin and its second on the x axis, and a walk is carried from triangle to
/// triangle by unfolding them about their common edges. It goes in short straight steps; where the surface
/// is flat, or the steps are short against its curvature, they make a straightest geodesic. Edges where the
/// surface ends, where more than two triangles meet, or two that are oriented against each other, cannot
/// be crossed.
#[derive(Debug, Clone)]
pub struct Surface {
    positions: Vec<Point3<f64>>,
    flats: Vec<Flat>,
    /// By vertex: one of its triangles, [`NONE`] without any.
    a_triangle: Vec<u32>,
}

/// A triangle in flat coordinates: corners at (0, 0), (`bx`, 0), (`cx`, `cy`). One cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Flat {
    corners: [u32; 3],
    /// Triangle across the edge from corner e to corner e + 1, times 4, plus its number of that edge;
    /// [`NONE`] where the surface ends.
    across: [u32; 3],
    bx: f32,
    cx: f32,
    cy: f32,
    inverse_bx: f32,
    inverse_cy: f32,
    /// Unit vectors along the edges from b to c and from c to a.
    along: [[f32; 2]; 2],
}

/// A point of a surface, and a direction there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The triangle.
    pub triangle: u32,
    /// The point in the triangle's flat coordinates.
    pub at: [f32; 2],
    /// Unit vector in the triangle's flat coordinates: the first axis of the tangent frame; the second
    /// is a quarter of a turn further, counterclockwise as seen from outside.
    pub axis: [f32; 2],
}

impl Place {
    /// The same point with the frame turned counterclockwise by the angle of the unit vector
    /// (cos, sin).
    #[must_use]
    pub fn turned(self, by: [f32; 2]) -> Self {
        Self {
            axis: product(self.axis, by),
            ..self
        }
    }
}

/// From the centre's flat coordinates into those of a triangle: x ↦ `turn`·x + `shift`, as complex
/// numbers.
#[derive(Debug, Clone, Copy)]
struct Unfolding {
    turn: [f32; 2],
    shift: [f32; 2],
}

/// Where a step of a walk has led.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reached {
    triangle: u32,
    unfolding: Unfolding,
    /// Barycentric coordinates.
    weights: [f32; 3],
}

impl Surface {
    /// Over the mesh as it is.
    ///
    /// # Panics
    /// If there are 2³⁰ triangles or more.
    #[must_use]
    pub fn new(mesh: TriMesh) -> Self {
        assert!(
            mesh.triangles.len() < 1 << 30,
            "triangle numbers must leave two bits for an edge"
        );
        // Walks go from triangle to triangle: what is close on the surface had better be close in memory.
        let centers: Vec<Point3<f64>> = (0..mesh.triangles.len())
            .map(|f| {
                let [a, b, c] = mesh.corners(f);
                Point3::from((a.coords + b.coords + c.coords) / 3.0)
            })
            .collect();
        let count = u32::try_from(centers.len()).expect("fewer than 2^30");
        let mut flats: Vec<Flat> = (spatial_order(&centers, (0..count).collect()).into_iter())
            .map(|f| Flat::new(mesh.triangles[f as usize], mesh.corners(f as usize)))
            .collect();
        join(&mut flats);
        let mut a_triangle = vec![NONE; mesh.positions.len()];
        for (f, flat) in (0u32..).zip(&flats) {
            for v in flat.corners.iter() {
                let a_triangle = &mut a_triangle[*v as usize];
                *a_triangle = f.min(*a_triangle);
            }
        }
        Self {
            positions: mesh.positions,
            flats,
            a_triangle,
        }
    }

    /// Every edge once, as a triangle with it and the numbers of its two corners there.
    pub fn edges(&self) -> impl Iterator<Item = (u32, [usize; 2])> {
        (0u32..).zip(&self.flats).flat_map(|(f, flat)| {
            let first = move |edge: &usize| {
                let across = flat.across[*edge];
                across == NONE || across >> 2 > f
            };
            let corners = move |edge: usize| (f, [edge, (edge + 1) % 3]);
            (0..3).filter(first).map(corners)
        })
    }

    /// The surface as a mesh, its triangles in the order of their numbers here.
    #[must_use]
    pub fn mesh(&self) -> TriMesh {
        TriMesh {
            positions: self.positions.clone(),
            triangles: self.triangles(),
        }
    }

    /// The corners of all triangles.
    #[must_use]
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        self.flats.iter().map(|flat| flat.corners).collect()
    }

    /// Positions of the vertices.
    #[must_use]
    pub fn positions(&self) -> &[Point3<f64>] {
        &self.positions
    }

    /// The triangle across the edge from corner `edge` of a triangle to the next one; `None` where the surface
    /// ends.
    pub(super) fn across(&self, triangle: u32, edge: usize) -> Option<u32> {
        let across = self.flats[triangle as usize].across[edge];
        (across != NONE).then_some(across >> 2)
    }

    /// The triangle at a vertex, and the number of its corner there, that the others follow counterclockwise, and whether they go
    /// all around it; `None` if no triangle has the vertex.
    pub(super) fn first_wedge(&self, v: u32) -> Option<((u32, usize), bool)> {
        let triangle = self.a_triangle[v as usize];
        let flat = self.flats.get(triangle as usize)?;
        let start = (triangle, flat.corners.iter().position(|c| *c == v)?);
        let mut at = start;
        for _ in 0..MOST_CROSSINGS {
            let across = self.flats[at.0 as usize].across[at.1];
            if across == NONE {
                return Some((at, false));
            }
            at = (across >> 2, ((across & 3) as usize + 1) % 3);
            if at == start {
                return Some((start, true));
            }
        }
        Some((start, false))
    }

    /// The triangle counterclockwise next to one at a corner, and its corner there.
    pub(super) fn counterclockwise(&self, triangle: u32, corner: usize) -> Option<(u32, usize)> {
        let across = self.flats[triangle as usize].across[(corner + 2) % 3];
        (across != NONE).then_some((across >> 2, (across & 3) as usize))
    }

    /// The angle at a corner of a triangle, and the lengths of the two edges there, counterclockwise.
    pub(super) fn opening(&self, triangle: u32, corner: usize) -> (f32, [f32; 2]) {
        let flat = &self.flats[triangle as usize];
        let at = flat.corner(corner);
        let [x, y] = [1, 2].map(|k| {
            let to = flat.corner((corner + k) % 3);
            [to[0] - at[0], to[1] - at[1]]
        });
        let [along, across] = product(y, [x[0], -x[1]]);
        (across.atan2(along), [x, y].map(|e| e[0].hypot(e[1])))
    }

    /// A corner of a triangle, with the frame's first axis turned by an angle from the edge to the next corner.
    #[inline]
    pub(super) fn at_corner(&self, triangle: u32, corner: usize, angle: f32) -> Place {
        let flat = &self.flats[triangle as usize];
        let (sin, cos) = angle.sin_cos();
        Place {
            triangle,
            at: flat.corner(corner),
            axis: product(flat.direction(corner), [cos, sin]),
        }
    }

    /// The angle of a place's axis to the edge from a corner of its triangle to the next one, from -π to π.
    #[inline]
    pub(super) fn angle_at(&self, place: &Place, corner: usize) -> f32 {
        let [x, y] = self.flats[place.triangle as usize].direction(corner);
        let [along, across] = product(place.axis, [x, -y]);
        across.atan2(along)
    }

    /// The corners of a triangle.
    #[must_use]
    pub fn corners(&self, triangle: u32) -> [u32; 3] {
        self.flats[triangle as usize].corners
    }

    /// Vertex `v`, with the frame's first axis along the tangent `axis`; `None` if no triangle has the
    /// vertex, or the axis stands upright on it.
    #[must_use]
    pub fn at_vertex(&self, v: u32, axis: &Vector3<f64>) -> Option<Place> {
        let triangle = self.a_triangle[v as usize];
        let flat = self.flats.get(triangle as usize)?;
        let corner = flat.corners.iter().position(|c| *c == v)?;
        let [x, y] = self.axes(triangle);
        Some(Place {
            triangle,
            at: flat.corner(corner),
            axis: unit([axis.dot(&x), axis.dot(&y)])?,
        })
    }

    /// The barycentric coordinates of a place in its triangle.
    #[must_use]
    pub fn barycentric(&self, place: &Place) -> [f32; 3] {
        self.flats[place.triangle as usize].barycentric(place.at)
    }

    /// The point in space.
    #[must_use]
    pub fn position(&self, place: &Place) -> Point3<f64> {
        let corners = self.corners(place.triangle);
        let sum: Vector3<f64> = (corners.iter().zip(self.barycentric(place)))
            .map(|(v, w)| self.positions[*v as usize].coords * f64::from(w))
            .sum();
        Point3::from(sum)
    }

    /// The frame's first axis in space.
    #[must_use]
    pub fn axis(&self, place: &Place) -> Vector3<f64> {
        let [x, y] = self.axes(place.triangle);
        x * f64::from(place.axis[0]) + y * f64::from(place.axis[1])
    }

    /// Components of a vector along the two axes of the place's frame.
    #[must_use]
    pub fn to_local(&self, place: &Place, v: &Vector3<f64>) -> [f32; 2] {
        let [x, y] = self.axes(place.triangle);
        let [cos, sin] = place.axis;
        #[expect(clippy::cast_possible_truncation, reason = "places are single")]
        let flat = [v.dot(&x) as f32, v.dot(&y) as f32];
        product(flat, [cos, -sin])
    }

    /// The point with these barycentric coordinates in a triangle, with the frame's first axis along
    /// the tangent `axis`; `None` if that stands upright on the triangle.
    #[must_use]
    pub fn in_triangle(
        &self,
        triangle: u32,
        barycentric: [f32; 3],
        axis: &Vector3<f64>,
    ) -> Option<Place> {
        let [x, y] = self.axes(triangle);
        Some(Place {
            triangle,
            at: self.flats[triangle as usize].point(barycentric),
            axis: unit([axis.dot(&x), axis.dot(&y)])?,
        })
    }

    /// The place that is reached by walking straight along `offset`, given in the place's frame (in
    /// the scan's unit), with the frame carried along; `None` where the surface ends before.
    #[must_use]
    pub fn walk(&self, place: &Place, offset: [f32; 2]) -> Option<Place> {
        // In steps below a triangle's size, so that the triangles are those along the straight line.
        let typical = self.flats[place.triangle as usize].bx;
        self.walk_by(place, offset, 0.5 * typical)
    }

    /// The same in steps of a given length at most.
    #[must_use]
    #[inline]
    pub fn walk_by(&self, place: &Place, offset: [f32; 2], step: f32) -> Option<Place> {
        let start = self.start(place);
        let steps = (offset[0].hypot(offset[1]) / step).ceil();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small whole number"
        )]
        let steps = steps.clamp(1.0, 1024.0) as u16;
        let mut reached = start;
        for number in 1..=steps {
            let share = f32::from(number) / f32::from(steps);
            reached = self.step(&reached, [offset[0] * share, offset[1] * share])?;
        }
        Some(Place {
            triangle: reached.triangle,
            at: self.flats[reached.triangle as usize].point(reached.weights),
            axis: reached.unfolding.turn,
        })
    }

    /// The beginning of every walk from `place`: offsets are in the place's frame from here on.
    pub(super) fn start(&self, place: &Place) -> Reached {
        Reached {
            triangle: place.triangle,
            unfolding: Unfolding {
                turn: place.axis,
                shift: place.at,
            },
            weights: self.barycentric(place),
        }
    }

    /// On from where `from` is to the point at `offset` from the start of the walk; `None` where the
    /// surface ends.
    #[inline]
    pub(super) fn step(&self, from: &Reached, offset: [f32; 2]) -> Option<Reached> {
        let (mut triangle, mut unfolding) = (from.triangle, from.unfolding);
        let mut entered = 3;
        for _ in 0..MOST_CROSSINGS {
            let flat = &self.flats[triangle as usize];
            let weights = flat.barycentric(unfolding.apply(offset));
            if weights.iter().all(|w| *w >= -EDGE_SLACK) {
                return Some(Reached {
                    triangle,
                    unfolding,
                    weights,
                });
            }
            let edge = flat.way_out(weights, entered)?;
            let across = flat.across[edge];
            let (next, theirs) = (across >> 2, (across & 3) as usize);
            unfolding = unfolding.over(flat, edge, &self.flats[next as usize], theirs);
            (triangle, entered) = (next, theirs);
        }
        None
    }

    /// How fast a value with the given size at the corners of the triangle reached grows along the two axes
    /// of the frame at the start of the walk.
    #[inline]
    pub(super) fn gradient(&self, reached: &Reached, [a, b, c]: [f32; 3]) -> [f32; 2] {
        let flat = &self.flats[reached.triangle as usize];
        let x = (b - a) * flat.inverse_bx;
        let y = (c - a - x * flat.cx) * flat.inverse_cy;
        let [cos, sin] = reached.unfolding.turn;
        product([x, y], [cos, -sin])
    }

    /// The triangle's axes of flat coordinates in space.
    fn axes(&self, triangle: u32) -> [Vector3<f64>; 2] {
        let [a, b, c] = self.corners(triangle).map(|v| self.positions[v as usize]);
        let x = (b - a).try_normalize(0.0).unwrap_or_else(Vector3::x);
        let across = (c - a) - x * x.dot(&(c - a));
        let any = || crate::base::perpendicular_frame(&nalgebra::Unit::new_unchecked(x))[0];
        [x, across.try_normalize(0.0).unwrap_or_else(any)]
    }
}

impl Reached {
    pub(super) fn triangle(&self) -> u32 {
        self.triangle
    }

    pub(super) fn weights(&self) -> [f32; 3] {
        self.weights
    }
}

impl Unfolding {
    #[inline]
    fn apply(&self, p: [f32; 2]) -> [f32; 2] {
        let turned = product(self.turn, p);
        [turned[0] + self.shift[0], turned[1] + self.shift[1]]
    }

    /// Carried on over `edge` of `flat` into the triangle `next`, whose edge `theirs` it is.
    #[inline]
    fn over(&self, flat: &Flat, edge: usize, next: &Flat, theirs: usize) -> Self {
        // The common edge runs the other way there, from our end to our start.
        let [x, y] = flat.direction(edge);
        let turn = product(next.direction(theirs), [-x, y]);
        let end = product(turn, flat.corner(if edge == 2 { 0 } else { edge + 1 }));
        let to = next.corner(theirs);
        let shift = product(turn, self.shift);
        Self {
            turn: product(turn, self.turn),
            shift: [shift[0] + to[0] - end[0], shift[1] + to[1] - end[1]],
        }
    }
}

impl Flat {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "flat coordinates are single"
    )]
    fn new(corners: [u32; 3], [a, b, c]: [Point3<f64>; 3]) -> Self {
        let (ab, ac) = (b - a, c - a);
        let longest = ab.norm().max(ac.norm()).max((c - b).norm());
        let least = (LEAST_ASPECT * longest).max(f64::from(f32::MIN_POSITIVE) * 1e8);
        let bx = ab.norm().max(least);
        let cx = ab.dot(&ac) / bx;
        let cy = (ac.norm_squared() - cx * cx).max(0.0).sqrt().max(least);
        let direction = |x: f64, y: f64| {
            let length = x.hypot(y);
            [(x / length) as f32, (y / length) as f32]
        };
        Self {
            corners,
            across: [NONE; 3],
            bx: bx as f32,
            cx: cx as f32,
            cy: cy as f32,
            inverse_bx: (1.0 / bx) as f32,
            inverse_cy: (1.0 / cy) as f32,
            along: [direction(cx - bx, cy), direction(-cx, -cy)],
        }
    }

    #[inline]
    fn corner(&self, i: usize) -> [f32; 2] {
        match i {
            0 => [0.0, 0.0],
            1 => [self.bx, 0.0],
            _ => [self.cx, self.cy],
        }
    }

    #[inline]
    fn direction(&self, edge: usize) -> [f32; 2] {
        match edge {
            0 => [1.0, 0.0],
            1 => self.along[0],
            _ => self.along[1],
        }
    }

    #[inline]
    fn barycentric(&self, [x, y]: [f32; 2]) -> [f32; 3] {
        let c = y * self.inverse_cy;
        let b = (x - self.cx * c) * self.inverse_bx;
        [1.0 - b - c, b, c]
    }

    fn point(&self, [_, b, c]: [f32; 3]) -> [f32; 2] {
        [b * self.bx + c * self.cx, c * self.cy]
    }

    /// The edge to leave by, towards a point with these barycentric coordinates: of those that it is
    /// beyond and the surface goes on behind the one that it is farthest beyond, if that is not where
    /// the walk came from.
    #[inline]
    fn way_out(&self, weights: [f32; 3], entered: usize) -> Option<usize> {
        let [a, b, c] = weights;
        let mut out = (-EDGE_SLACK, None);
        // By edge the weight of the corner opposite.
        for (edge, weight) in [c, a, b].into_iter().enumerate() {
            if weight < out.0 && edge != entered && self.across[edge] != NONE {
                out = (weight, Some(edge));
            }
        }
        out.1
    }
}

/// Finds the triangles across the edges: where two triangles alone have an edge, and run along it in
/// opposite directions.
fn join(flats: &mut [Flat]) {
    let triangles: Vec<[u32; 3]> = flats.iter().map(|flat| flat.corners).collect();
    for (h, opposite) in opposite_half_edges(&triangles).into_iter().enumerate() {
        if opposite != ALONE {
            flats[h / 3].across[h % 3] = opposite / 3 * 4 + opposite % 3;
        }
    }
}

/// Product of complex numbers: turns and scales.
#[inline]
fn product([a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
    [a * c - b * d, a * d + b * c]
}

#[expect(clippy::cast_possible_truncation, reason = "directions are single")]
fn unit([x, y]: [f64; 2]) -> Option<[f32; 2]> {
    let length = x.hypot(y);
    (length > 1e-9).then(|| [(x / length) as f32, (y / length) as f32])
}
