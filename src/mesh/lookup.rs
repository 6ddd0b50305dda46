//! What is at the vertices of a surface, at any point of it.

use nalgebra::{Point3, Vector3};

use super::{ClosestPoints, TriMesh};

/// Finds the triangle, and the place in it, that is closest to a point; values of the corners can be mixed there.
#[derive(Debug)]
pub struct SurfaceLookup {
    closest: ClosestPoints,
    triangles: Vec<[u32; 3]>,
}

/// A place on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePlace {
    /// The number of the triangle.
    pub triangle: u32,
    /// Its vertices.
    pub corners: [u32; 3],
    /// Barycentric coordinates: at least 0, sum 1.
    pub shares: [f64; 3],
}

impl SurfaceLookup {
    /// Over all triangles of a mesh.
    ///
    /// # Panics
    /// If there are 2³² triangles or more.
    #[must_use]
    pub fn new(mesh: &TriMesh) -> Self {
        Self {
            closest: ClosestPoints::new(mesh),
            triangles: mesh.triangles.clone(),
        }
    }

    /// The place that is closest to `point`, by the rules of [`ClosestPoints::closest`]: with a `normal` only triangles
    /// count that do not face away from it, unless all do. `None` without triangles, or for a point that is not
    /// finite.
    #[must_use]
    pub fn place(
        &self,
        point: &Point3<f64>,
        normal: Option<&Vector3<f64>>,
    ) -> Option<SurfacePlace> {
        let (triangle, shares, _) = self.closest.closest(point, normal)?;
        Some(SurfacePlace {
            triangle,
            corners: self.triangles[triangle as usize],
            shares,
        })
    }
}

impl SurfacePlace {
    /// Values there of values of the three corners.
    #[must_use]
    pub fn mixed<const N: usize>(&self, corners: [[f64; N]; 3]) -> [f64; N] {
        std::array::from_fn(|k| {
            let parts = corners.iter().zip(self.shares);
            parts.map(|(corner, share)| share * corner[k]).sum()
        })
    }

    /// Values there of values of all vertices (#V).
    ///
    /// # Panics
    /// If there are fewer values than vertices.
    #[must_use]
    pub fn of_vertices<const N: usize>(&self, values: &[[f64; N]]) -> [f64; N] {
        self.mixed(self.corners.map(|v| values[v as usize]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_corners_are_linear_and_beyond_the_rim_those_of_the_rim() {
        let mesh = TriMesh {
            positions: [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [4.0, 4.0]]
                .map(|[x, y]| Point3::new(x, y, 0.0))
                .to_vec(),
            triangles: vec![[0, 1, 2], [1, 3, 2]],
        };
        let lookup = SurfaceLookup::new(&mesh);
        let values: Vec<[f64; 2]> = (mesh.positions.iter())
            .map(|p| [3.0 * p.x - p.y, p.y + 1.0])
            .collect();
        for (x, y, nearest) in [
            (1.0, 0.5, [1.0, 0.5]),
            (3.0, 2.5, [3.0, 2.5]),
            (9.0, -1.0, [4.0, 0.0]),
        ] {
            let place = lookup.place(&Point3::new(x, y, 0.2), None).unwrap();
            let [a, b] = place.of_vertices(&values);
            assert!(
                (a - (3.0 * nearest[0] - nearest[1])).abs() < 1e-12,
                "{x}, {y}"
            );
            assert!((b - (nearest[1] + 1.0)).abs() < 1e-12, "{x}, {y}");
            assert_eq!(place.corners, mesh.triangles[place.triangle as usize]);
        }
        assert_eq!(lookup.place(&Point3::new(f64::NAN, 0.0, 0.0), None), None);
    }
}
