//! Places on a surface in terms that hold for every surface with the same triangle.

use serde::{Deserialize, Serialize};

use crate::neighborhood::{Place, Surface};

/// A place by the corners of its triangle: a surface numbers its triangles in its own way, but their flat
/// coordinates follow from the corners and their order alone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Spot {
    corners: [u32; 3],
    at: [f32; 2],
    axis: [f32; 2],
}

impl Spot {
    pub(super) fn of(surface: &Surface, place: &Place) -> Self {
        Self {
            corners: surface.corners(place.triangle),
            at: place.at,
            axis: place.axis,
        }
    }

    /// The same spot with other numbers of vertices.
    pub(super) fn renumbered(self, number: impl Fn(u32) -> u32) -> Self {
        Self {
            corners: self.corners.map(number),
            ..self
        }
    }

    /// Whether none of its corners has a number.
    pub(super) fn has_corners_but(&self, number: u32) -> bool {
        !self.corners.contains(&number)
    }

    pub(super) fn is_finite(&self) -> bool {
        self.at.iter().chain(&self.axis).all(|x| x.is_finite())
    }
}

/// The triangles of a surface by their corners.
#[derive(Debug)]
pub(super) struct Spots {
    /// Ascending.
    triangles: Vec<([u32; 3], u32)>,
}

impl Spots {
    pub(super) fn new(surface: &Surface) -> Self {
        let mut triangles: Vec<([u32; 3], u32)> =
            surface.triangles().into_iter().zip(0u32..).collect();
        triangles.sort_unstable();
        Self { triangles }
    }

    /// The place on the surface, if it has the triangle.
    pub(super) fn place(&self, spot: &Spot) -> Option<Place> {
        // Of several triangles with the same corners the first.
        let i = (self.triangles).partition_point(|(corners, _)| *corners < spot.corners);
        let (corners, triangle) = self.triangles.get(i)?;
        (*corners == spot.corners).then_some(Place {
            triangle: *triangle,
            at: spot.at,
            axis: spot.axis,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn a_place_is_the_same_on_a_part_of_the_surface() {
        let at = |v: u32| Point3::new(f64::from(v % 7), f64::from(v / 7), 0.1 * f64::from(v % 3));
        let cells = (0..42).filter(|v| v % 7 < 6);
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|a| [[a, a + 1, a + 8], [a, a + 8, a + 7]])
            .collect();
        let whole = Surface::new(TriMesh {
            positions: (0..49).map(at).collect(),
            triangles: triangles.clone(),
        });
        // The upper rows only, with numbers of their own.
        let rest = triangles.iter().filter(|t| t.iter().all(|v| *v >= 21));
        let part = Surface::new(TriMesh {
            positions: (21..49).map(at).collect(),
            triangles: rest.map(|t| t.map(|v| v - 21)).collect(),
        });
        let spots = Spots::new(&part);
        let corners = [31, 32, 39];
        let triangle = (0u32..).zip(whole.triangles()).find(|(_, t)| *t == corners);
        let (triangle, _) = triangle.unwrap();
        let place = (whole.in_triangle(triangle, [0.2, 0.5, 0.3], &Vector3::y())).unwrap();
        let spot = Spot::of(&whole, &place).renumbered(|v| v - 21);
        let again = spots.place(&spot).unwrap();
        assert_eq!(Spot::of(&part, &again), spot);
        assert!((part.position(&again) - whole.position(&place)).norm() < 1e-12);
        assert!((part.axis(&again) - whole.axis(&place)).norm() < 1e-12);
        let gone = Spot::of(&whole, &place).renumbered(|v| v - 25);
        assert_eq!(spots.place(&gone), None);
    }
}
