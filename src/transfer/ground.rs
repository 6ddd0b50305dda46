//! A level of a mesh, laid out for walks from vertex to vertex.

use std::f32::consts::PI;

use nalgebra::{Point3, Vector3};

use crate::base::perpendicular_frame;
use crate::mesh::{TriMesh, surface_area, vertex_normals};
use crate::neighborhood::{Charts, Place, Spots, Surface};

/// Rings and spokes of the geodesic fans.
pub(super) const FAN: [usize; 2] = [3, 18];

/// A level of a mesh.
#[derive(Debug)]
pub(super) struct Ground {
    pub(super) surface: Surface,
    pub(super) charts: Charts,
    /// Distance of neighbors if all triangles were equal and regular, in the mesh's unit; fans' rings are as far
    /// apart.
    pub(super) spacing: f32,
    pub(super) fans: Spots,
    /// The direction of the angle 0 at each vertex, and of a quarter turn.
    axes: Vec<[Vector3<f64>; 2]>,
}

impl Ground {
    pub(super) fn new(mesh: TriMesh) -> Self {
        let normals = vertex_normals(&mesh);
        let area = surface_area(&mesh);
        #[expect(clippy::cast_possible_truncation, reason = "places are single")]
        let spacing = (area / mesh.positions.len() as f64 * 2.0 / 3f64.sqrt()).sqrt() as f32;
        let surface = Surface::new(mesh);
        let charts = Charts::new(&surface);
        let fans = Spots::fans(&surface, &charts, FAN, spacing);
        let axes = (0u32..).zip(&normals).map(|(v, normal)| {
            let first = charts.place(&surface, v, 0.0);
            let first = first.map_or_else(Vector3::zeros, |place| surface.axis(&place));
            let tangent = first - normal * normal.dot(&first);
            match tangent.try_normalize(1e-9) {
                Some(x) => [x, normal.cross(&x)],
                None => match nalgebra::Unit::try_new(*normal, 0.5) {
                    Some(normal) => perpendicular_frame(&normal),
                    None => [Vector3::x(), Vector3::y()],
                },
            }
        });
        Self {
            axes: axes.collect(),
            charts,
            spacing,
            fans,
            surface,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.axes.len()
    }

    pub(super) fn position(&self, v: u32) -> &Point3<f64> {
        &self.surface.positions()[v as usize]
    }

    /// The direction of an angle at a vertex, in space.
    pub(super) fn direction(&self, v: u32, angle: f32) -> Vector3<f64> {
        let [x, y] = self.axes[v as usize];
        let (sin, cos) = f64::from(angle).sin_cos();
        x * cos + y * sin
    }

    /// Angle and length of what is tangent of a vector at a vertex.
    #[expect(clippy::cast_possible_truncation, reason = "angles are single")]
    pub(super) fn polar(&self, v: u32, vector: &Vector3<f64>) -> (f32, f32) {
        let [x, y] = self.axes[v as usize].map(|axis| axis.dot(vector));
        (y.atan2(x) as f32, x.hypot(y) as f32)
    }

    /// The angle of what is tangent of a direction, or where hardly anything is of another one.
    pub(super) fn upright(&self, v: u32, up: &Vector3<f64>) -> f32 {
        let (angle, length) = self.polar(v, &up.normalize());
        if length > 1e-3 {
            return angle;
        }
        self.polar(v, &Vector3::new(up.y, up.z, up.x)).0
    }

    /// Where one comes to on the way from a vertex in the direction of an angle, with the axis along the way; `None`
    /// beyond the rim.
    #[inline]
    pub(super) fn walk(&self, v: u32, angle: f32, length: f32) -> Option<Place> {
        let start = self.charts.place(&self.surface, v, angle)?;
        self.surface.walk_by(&start, [length, 0.0], self.spacing)
    }

    /// The vertex nearest to where that way leads, and the way's angle there.
    #[inline]
    pub(super) fn vertex_towards(&self, v: u32, angle: f32, length: f32) -> Option<(u32, f32)> {
        let place = self.walk(v, angle, length)?;
        let corner = largest(self.surface.barycentric(&place));
        let angle = self.charts.angle(&self.surface, &place, corner);
        Some((self.surface.corners(place.triangle)[corner], angle))
    }

    /// Vertices within `radius` of each vertex.
    pub(super) fn patch(&self, v: u32, radius: f32, patch: &mut Patch) {
        patch.members.clear();
        patch.members.push(Member {
            vertex: v,
            offset: [0.0, 0.0],
            transport: 0.0,
        });
        patch.round += 1;
        patch.seen.resize(self.len(), 0);
        patch.seen[v as usize] = patch.round;
        let mut at = 0;
        while let Some(from) = patch.members.get(at).copied() {
            at += 1;
            for next in self.charts.next(from.vertex) {
                if patch.seen[next.vertex as usize] == patch.round {
                    continue;
                }
                let (sin, cos) = (next.angle - from.transport).sin_cos();
                let offset = [
                    from.offset[0] + next.length * cos,
                    from.offset[1] + next.length * sin,
                ];
                if offset[0].hypot(offset[1]) <= radius {
                    patch.seen[next.vertex as usize] = patch.round;
                    patch.members.push(Member {
                        vertex: next.vertex,
                        offset,
                        transport: from.transport + next.transport,
                    });
                }
            }
        }
    }
}

/// A vertex near another one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Member {
    pub(super) vertex: u32,
    /// Where it lies in the plane of the angles of the other.
    pub(super) offset: [f32; 2],
    /// What has to be added to angles of the other to get those of this one.
    pub(super) transport: f32,
}

impl Member {
    /// Angle, at this vertex, of the way back, and its length.
    pub(super) fn way_back(&self) -> (f32, f32) {
        let [x, y] = self.offset;
        (y.atan2(x) + self.transport + PI, x.hypot(y))
    }
}

/// Vertices around one, and memory to find those around the next.
#[derive(Debug, Default)]
pub(super) struct Patch {
    pub(super) members: Vec<Member>,
    seen: Vec<u32>,
    round: u32,
}

/// Which is the largest.
pub(super) fn largest([a, b, c]: [f32; 3]) -> usize {
    if a >= b && a >= c {
        0
    } else if b >= c {
        1
    } else {
        2
    }
}

/// The numbers of so many vertices.
pub(super) fn numbers(vertices: usize) -> std::ops::Range<u32> {
    0..u32::try_from(vertices).expect("vertices are u32")
}

/// The number of a vertex.
pub(super) fn number(v: usize) -> u32 {
    u32::try_from(v).expect("vertices are u32")
}

/// Values, features and angles are single.
#[expect(clippy::cast_possible_truncation, reason = "digits, not range")]
pub(super) fn single(x: f64) -> f32 {
    x as f32
}
