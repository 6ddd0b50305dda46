//! Nearly even triangulations of the base surfaces, with the mild irregularity of a scan.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point2, Point3, Vector2, Vector3};
use spade::{DelaunayTriangulation, Triangulation};

use crate::base::{BaseSurface, Cylinder, Plane, Sphere};
use crate::rng::Rng;

/// Largest displacement of a vertex from its lattice, along each of two directions, in edges: so
/// little that no triangle of the hexagonal lattice turns over.
const JITTER: f64 = 0.12;

/// Relative deviation from the asked number of vertices up to which the lattice's proportions,
/// rather than its count, decide.
const COUNT_TOLERANCE: f64 = 0.01;

/// A base surface as a triangle mesh: closed, or with one rim (plane) or two (cylinder).
#[derive(Debug)]
pub(super) struct Tessellation {
    pub(super) base: BaseSurface,
    /// #V points of the base.
    pub(super) feet: Vec<Point3<f64>>,
    /// #V outward unit normals of the base.
    pub(super) normals: Vec<Vector3<f64>>,
    /// #V coordinates on the (unrolled) wall: across and up, from its lower left corner. Empty for
    /// the sphere.
    pub(super) wall: Vec<Point2<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Length of an edge, were all triangles equilateral.
    pub(super) edge: f64,
}

impl Tessellation {
    /// Moves the base outward by `distance`.
    pub(super) fn raise(&mut self, distance: f64) {
        for (foot, normal) in self.feet.iter_mut().zip(&self.normals) {
            *foot += normal * distance;
        }
        match &mut self.base {
            BaseSurface::Plane(plane) => plane.point += plane.normal.scale(distance),
            BaseSurface::Sphere(sphere) => sphere.radius += distance,
            BaseSurface::Cylinder(cylinder) => cylinder.radius += distance,
            BaseSurface::Cone(_) => unreachable!("no object has a cone for its base"),
        }
    }
}

/// Edge of the equilateral triangulation of `area` with so many vertices.
fn edge(area: f64, vertices: usize) -> f64 {
    (area / vertices as f64 * 2.0 / 3f64.sqrt()).sqrt()
}

/// A rectangle of size `extent` around the origin, in xy, facing +z.
pub(super) fn plane(extent: Vector2<f64>, vertices: usize, rng: &mut Rng) -> Tessellation {
    let (rows, columns) = lattice_size(extent, vertices);
    let step = Vector2::new(
        extent.x / (columns as f64 - 0.5),
        extent.y / (rows - 1) as f64,
    );
    let wall = lattice(rows, columns, step, rng);
    Tessellation {
        base: BaseSurface::Plane(Plane {
            point: Point3::origin(),
            normal: Vector3::z_axis(),
        }),
        feet: wall
            .iter()
            .map(|w| Point3::new(w.x - 0.5 * extent.x, w.y - 0.5 * extent.y, 0.0))
            .collect(),
        normals: vec![Vector3::z(); wall.len()],
        wall,
        triangles: lattice_triangles(rows, columns, false),
        edge: edge(extent.x * extent.y, vertices),
    }
}

/// A cylinder wall around the z axis, its middle at the origin, with two open ends.
pub(super) fn cylinder(radius: f64, height: f64, vertices: usize, rng: &mut Rng) -> Tessellation {
    let extent = Vector2::new(TAU * radius, height);
    let (rows, columns) = lattice_size(extent, vertices);
    let step = Vector2::new(extent.x / columns as f64, extent.y / (rows - 1) as f64);
    let wall = lattice(rows, columns, step, rng);
    let normals: Vec<_> = wall
        .iter()
        .map(|w| {
            let (sin, cos) = (w.x / radius).sin_cos();
            Vector3::new(cos, sin, 0.0)
        })
        .collect();
    Tessellation {
        base: BaseSurface::Cylinder(Cylinder {
            point: Point3::origin(),
            axis: Vector3::z_axis(),
            radius,
        }),
        feet: wall
            .iter()
            .zip(&normals)
            .map(|(w, n)| Point3::new(n.x * radius, n.y * radius, w.y - 0.5 * height))
            .collect(),
        normals,
        wall,
        triangles: lattice_triangles(rows, columns, true),
        edge: edge(extent.x * extent.y, vertices),
    }
}

/// A whole sphere around the origin: a jittered Fibonacci lattice and its Delaunay triangulation.
pub(super) fn sphere(radius: f64, vertices: usize, rng: &mut Rng) -> Tessellation {
    let edge = edge(4.0 * PI, vertices);
    let golden_angle = PI * (3.0 - 5f64.sqrt());
    let normals: Vec<Vector3<f64>> = (0..vertices)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / vertices as f64;
            let (sin, cos) = (golden_angle * i as f64).sin_cos();
            let across = (1.0 - z * z).sqrt();
            let lattice = Vector3::new(across * cos, across * sin, z);
            let side = perpendicular(&lattice);
            let jitter = jitter(rng) * edge;
            (lattice + side * jitter.x + lattice.cross(&side) * jitter.y).normalize()
        })
        .collect();
    Tessellation {
        base: BaseSurface::Sphere(Sphere {
            center: Point3::origin(),
            radius,
        }),
        feet: normals.iter().map(|n| Point3::from(n * radius)).collect(),
        triangles: spherical_delaunay(&normals),
        normals,
        wall: Vec::new(),
        edge: edge * radius,
    }
}

fn jitter(rng: &mut Rng) -> Vector2<f64> {
    let x = JITTER * (2.0 * rng.uniform() - 1.0);
    let y = JITTER * (2.0 * rng.uniform() - 1.0);
    Vector2::new(x, y)
}

/// Rows and columns of a hexagonal lattice over `extent`: as equilateral as the count allows.
fn lattice_size(extent: Vector2<f64>, vertices: usize) -> (usize, usize) {
    let edge = edge(extent.x * extent.y, vertices);
    let ideal = rounded(extent.y / (edge * 0.75f64.sqrt()));
    let deviation =
        |rows: usize, columns: usize| (rows * columns).abs_diff(vertices) as f64 / vertices as f64;
    let candidates = [0i8, 1, -1, 2, -2, 3, -3].map(|change| {
        let rows = ideal.saturating_add_signed(isize::from(change)).max(2);
        (rows, rounded(vertices as f64 / rows as f64).max(3))
    });
    candidates
        .into_iter()
        .find(|(rows, columns)| deviation(*rows, *columns) <= COUNT_TOLERANCE)
        .or_else(|| {
            candidates
                .into_iter()
                .min_by(|a, b| deviation(a.0, a.1).total_cmp(&deviation(b.0, b.1)))
        })
        .expect("there are candidates")
}

/// Vertices of a hexagonal lattice, row by row from the bottom, every other row half a step to the
/// right.
fn lattice(rows: usize, columns: usize, step: Vector2<f64>, rng: &mut Rng) -> Vec<Point2<f64>> {
    let mut points = Vec::with_capacity(rows * columns);
    for row in 0..rows {
        let shift = 0.5 * (row % 2) as f64;
        for column in 0..columns {
            let jitter = jitter(rng) * step.x;
            points.push(Point2::new(
                (column as f64 + shift) * step.x + jitter.x,
                row as f64 * step.y + jitter.y,
            ));
        }
    }
    points
}

/// Triangles of that lattice, counterclockwise; `around`: the last column is next to the first.
fn lattice_triangles(rows: usize, columns: usize, around: bool) -> Vec<[u32; 3]> {
    let vertex = |row: usize, column: usize| index(row * columns + column % columns);
    let cells = if around { columns } else { columns - 1 };
    let mut triangles = Vec::with_capacity(2 * rows * columns);
    for row in 0..rows - 1 {
        for column in 0..cells {
            let (a, b) = (vertex(row, column), vertex(row, column + 1));
            let (c, d) = (vertex(row + 1, column), vertex(row + 1, column + 1));
            if row % 2 == 0 {
                triangles.extend([[a, b, c], [b, d, c]]);
            } else {
                triangles.extend([[a, d, c], [a, b, d]]);
            }
        }
    }
    triangles
}

/// Delaunay triangulation of unit vectors that surround the origin: the closed surface of their
/// convex hull, counterclockwise as seen from outside.
///
/// Seen stereographically from one of them, circles stay circles: the others' plane Delaunay
/// triangulation is that of the sphere, and the eye is joined to the plane's hull.
fn spherical_delaunay(directions: &[Vector3<f64>]) -> Vec<[u32; 3]> {
    let (eye, others) = directions.split_last().expect("there are vertices");
    let side = perpendicular(eye);
    let up = eye.cross(&side);
    let projected: Vec<_> = others
        .iter()
        .map(|d| {
            let scale = 1.0 / (1.0 - d.dot(eye));
            spade::Point2::new(d.dot(&side) * scale, d.dot(&up) * scale)
        })
        .collect();
    let plane: DelaunayTriangulation<_> = DelaunayTriangulation::bulk_load_stable(projected)
        .expect("coordinates between 1e-5 and 1e5 are in spade's range");
    let mut triangles: Vec<[u32; 3]> = plane
        .inner_faces()
        .map(|face| face.vertices().map(|v| index(v.index())))
        .collect();
    triangles.extend(plane.convex_hull().map(|hull_edge| {
        let [from, to] = hull_edge.vertices().map(|v| index(v.index()));
        [from, to, index(others.len())]
    }));
    for triangle in &mut triangles {
        let [a, b, c] = triangle.map(|v| directions[v as usize]);
        if (b - a).cross(&(c - a)).dot(&a) < 0.0 {
            triangle.swap(1, 2);
        }
    }
    triangles
}

/// A unit vector perpendicular to a unit vector, away from the coordinate axis next to that.
pub(super) fn perpendicular(direction: &Vector3<f64>) -> Vector3<f64> {
    let mut farthest = Vector3::zeros();
    farthest[direction.iamin()] = 1.0;
    direction.cross(&farthest).normalize()
}

/// A vertex index; their number was checked at the door.
pub(super) fn index(i: usize) -> u32 {
    u32::try_from(i).expect("the number of vertices was checked")
}

/// The nearest whole number.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts of rows, columns and vertices: positive and below 2^32"
)]
pub(super) fn rounded(x: f64) -> usize {
    x.round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stage;

    #[test]
    fn lattices_have_the_asked_size_and_nearly_equilateral_cells() {
        for vertices in (500..3000).step_by(17) {
            for extent in [Vector2::new(1.0, 1.0), Vector2::new(900.0, 600.0)] {
                let (rows, columns) = lattice_size(extent, vertices);
                let relative = (rows * columns) as f64 / vertices as f64;
                assert!((relative - 1.0).abs() < 0.02, "{vertices}: {relative}");
                let ratio = extent.y * columns as f64 / (extent.x * rows as f64);
                assert!((0.7..1.1).contains(&ratio), "{vertices}: {ratio}");
            }
        }
    }

    #[test]
    fn sphere_triangles_face_outward_and_are_not_slivers() {
        let sphere = sphere(2.0, 1500, &mut Rng::new(3, Stage::Synth, 0));
        assert_eq!(sphere.triangles.len(), 2 * 1500 - 4);
        for triangle in &sphere.triangles {
            let [a, b, c] = triangle.map(|v| sphere.feet[v as usize]);
            let normal = (b - a).cross(&(c - a));
            assert!(normal.dot(&a.coords) > 0.0);
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            assert!(longest < 2.0 * sphere.edge, "{}", longest / sphere.edge);
            assert!(normal.norm() > 0.2 * longest * longest);
        }
    }
}
