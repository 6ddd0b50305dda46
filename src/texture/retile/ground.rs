//! The surface that is retiled: what its new vertices walk on.

use nalgebra::{Point3, Vector3};

use super::OnTriangle;
use super::rim::Rim;
use crate::mesh::{TriMesh, spatial_order, surface_area, triangle_normal, turned_tangent};
use crate::neighborhood::{Place, Surface};

/// The input, laid out for walking.
#[derive(Debug)]
pub(super) struct Ground {
    /// Its triangles with three different corners, what is close together.
    mesh: TriMesh,
    /// What number each triangle had.
    numbers: Vec<u32>,
    surface: Surface,
    /// Where it ends.
    pub(super) rims: Vec<Rim>,
}

/// What is at a place of the input.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    pub(super) point: Point3<f64>,
    /// Unit normal of the triangle; zero if it has no area.
    pub(super) normal: Vector3<f64>,
}

impl Ground {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let proper = |f: &u32| {
            let [a, b, c] = mesh.triangles[*f as usize];
            a != b && b != c && c != a
        };
        let count = u32::try_from(mesh.triangles.len()).expect("indices are u32");
        let centers: Vec<Point3<f64>> = (0..mesh.triangles.len())
            .map(|f| {
                let [a, b, c] = mesh.corners(f);
                Point3::from((a.coords + b.coords + c.coords) / 3.0)
            })
            .collect();
        // The order that `Surface` gives them, so that it leaves them in place.
        let numbers = spatial_order(&centers, (0..count).filter(proper).collect());
        let mesh = TriMesh {
            positions: mesh.positions.clone(),
            triangles: (numbers.iter())
                .map(|f| mesh.triangles[*f as usize])
                .collect(),
        };
        let surface = Surface::new(mesh.clone());
        debug_assert!(
            (0u32..)
                .zip(&mesh.triangles)
                .all(|(f, t)| surface.corners(f) == *t)
        );
        Self {
            mesh,
            numbers,
            surface,
            rims: Vec::new(),
        }
    }

    pub(super) fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    pub(super) fn area(&self) -> f64 {
        surface_area(&self.mesh)
    }

    /// A place with the triangle's number in the input.
    pub(super) fn on_input(&self, place: &OnTriangle) -> OnTriangle {
        OnTriangle {
            triangle: self.numbers[place.triangle as usize],
            ..*place
        }
    }

    pub(super) fn spot(&self, place: &OnTriangle) -> Spot {
        let corners = self.mesh.corners(place.triangle as usize);
        let sum: Vector3<f64> = (corners.iter().zip(place.weights))
            .map(|(corner, weight)| corner.coords * weight)
            .sum();
        Spot {
            point: Point3::from(sum),
            normal: triangle_normal(corners)
                .try_normalize(0.0)
                .unwrap_or_default(),
        }
    }

    /// Where one comes to by walking from a place along `way`, which is tangential to the surface with unit
    /// normal `normal` there, seen from farther away than its triangles are large; the way is turned into
    /// the triangle's plane as the normal is. `None` where the surface ends before.
    pub(super) fn walk(
        &self,
        from: &OnTriangle,
        way: &Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> Option<OnTriangle> {
        let corners = self.mesh.corners(from.triangle as usize);
        let (x, y, own) = axes(&corners, normal)?;
        let way = turned_tangent(way, normal, &own);
        #[expect(clippy::cast_possible_truncation, reason = "walks are single")]
        let offset = [way.dot(&x) as f32, way.dot(&y) as f32];
        let to = self.surface.walk(&self.place(from, &x)?, offset)?;
        let weights = proper(self.surface.barycentric(&to).map(f64::from))?;
        Some(OnTriangle {
            triangle: to.triangle,
            weights,
        })
    }

    fn place(&self, from: &OnTriangle, x: &Vector3<f64>) -> Option<Place> {
        #[expect(clippy::cast_possible_truncation, reason = "walks are single")]
        let weights = from.weights.map(|w| w as f32);
        let mut place = self.surface.in_triangle(from.triangle, weights, x)?;
        place.axis = [1.0, 0.0];
        Some(place)
    }
}

/// Shares that are at least 0 with sum 1; `None` if that cannot be made of them.
fn proper(weights: [f64; 3]) -> Option<[f64; 3]> {
    let weights = weights.map(|w| w.max(0.0));
    let sum: f64 = weights.iter().sum();
    (sum.is_finite() && sum > 0.0).then(|| weights.map(|w| w / sum))
}

/// The axes of a triangle's flat coordinates and its unit normal; without an area, that which is closest to
/// the given one.
fn axes(
    corners: &[Point3<f64>; 3],
    normal: &Vector3<f64>,
) -> Option<(Vector3<f64>, Vector3<f64>, Vector3<f64>)> {
    let [a, b, c] = corners;
    let along = [b - a, c - a, c - b];
    let x = along.iter().find_map(|v| v.try_normalize(0.0))?;
    let upright = |v: &Vector3<f64>| (v - x * x.dot(v)).try_normalize(0.0);
    let own = upright(&triangle_normal(*corners)).or_else(|| upright(normal))?;
    Some((x, own.cross(&x), own))
}
