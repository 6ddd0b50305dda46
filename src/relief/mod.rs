//! Scan and base surface to relief (signed heights along the base normal), and back.

mod displaced;

pub use displaced::{displaced, put_on};

use nalgebra::{Point3, Vector3};

use crate::base::{
    BaseSurface, FitReport, MAX_RELIEF_SHARE, Role, Undetermined, choose_wavelength, smooth_form,
};
use crate::mesh::{
    Adjacency, TriMesh, median_edge, smoothed_positions, triangle_normal, vertex_normals,
};

/// The relief of a mesh over its base surface, one row a vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct Relief {
    /// #V foot points s' on the base surface.
    pub feet: Vec<Point3<f64>>,
    /// #V corrected unit normals: those of the base surface at the feet, on the side that the
    /// triangles face. They do not feel the relief, so frames built on them agree between places.
    pub normals: Vec<Vector3<f64>>,
    /// #V signed heights over the base along the corrected normals, in the scan's unit; positive is
    /// towards the side that the triangles face.
    pub heights: Vec<f64>,
    /// 1 if the triangles face the base surface's outside, −1 if they face its inside (the inner
    /// wall of a vessel).
    pub side: f64,
}

impl Relief {
    /// Displacement vector D(s) of vertex `v`, from its foot to the vertex.
    #[must_use]
    pub fn displacement(&self, v: usize) -> Vector3<f64> {
        self.normals[v] * self.heights[v]
    }

    /// The point at height `height` over the foot of vertex `v`.
    #[must_use]
    pub fn point(&self, v: usize, height: f64) -> Point3<f64> {
        self.feet[v] + self.normals[v] * height
    }
}

/// Takes the relief of every vertex off the base surface, on the side that the triangles face.
///
/// # Reference
/// [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), §3 and Fig. 5.
#[must_use]
pub fn extract(mesh: &TriMesh, base: &BaseSurface) -> Relief {
    let mut relief = extract_on_side(&mesh.positions, base, 1.0);
    let outward = |v: u32| relief.normals[v as usize];
    if facing(&mesh.positions, &mesh.triangles, outward) < 0.0 {
        relief.side = -1.0;
        for normal in &mut relief.normals {
            *normal = -*normal;
        }
        for height in &mut relief.heights {
            *height = -*height;
        }
    }
    relief
}

/// 1 if most of the triangles (by area) face the outside of a base surface, −1 if its inside;
/// `outward` gives the base surface's normal at the foot of a vertex.
#[must_use]
pub fn facing(
    positions: &[Point3<f64>],
    triangles: &[[u32; 3]],
    outward: impl Fn(u32) -> Vector3<f64>,
) -> f64 {
    let agreement: f64 = (triangles.iter())
        .map(|triangle| {
            let base_normal: Vector3<f64> = triangle.map(&outward).iter().sum();
            let corners = triangle.map(|v| positions[v as usize]);
            triangle_normal(corners).dot(&base_normal)
        })
        .sum();
    if agreement < 0.0 { -1.0 } else { 1.0 }
}

/// The relief of `points` on the given side of the base surface, see [`Relief::side`].
#[must_use]
pub fn extract_on_side(points: &[Point3<f64>], base: &BaseSurface, side: f64) -> Relief {
    let mut relief = Relief {
        feet: Vec::with_capacity(points.len()),
        normals: Vec::with_capacity(points.len()),
        heights: Vec::with_capacity(points.len()),
        side,
    };
    for p in points {
        let foot = base.foot(p);
        relief.feet.push(foot.point);
        relief.normals.push(foot.normal * side);
        relief.heights.push(foot.height * side);
    }
    relief
}

/// The relief of a mesh over a smooth one with the same vertices and triangles: normals are the smooth
/// mesh's at its vertices, and feet stand under the mesh's vertices along them.
#[must_use]
pub fn over_form(mesh: &TriMesh, form: Vec<Point3<f64>>) -> Relief {
    let smooth = TriMesh {
        positions: form,
        triangles: mesh.triangles.clone(),
    };
    let normals = vertex_normals(&smooth);
    let heights: Vec<f64> = (mesh.positions.iter().zip(&smooth.positions))
        .zip(&normals)
        .map(|((p, foot), normal)| (p - foot).dot(normal))
        .collect();
    let feet = (mesh.positions.iter().zip(&normals))
        .zip(&heights)
        .map(|((p, normal), height)| p - normal * *height)
        .collect();
    Relief {
        feet,
        normals,
        heights,
        side: 1.0,
    }
}

/// The relief of a mesh over free form, and the wavelength that tells one from the other (given, or chosen from the
/// relief), in the scan's unit. What a completion added (`completed`: #V, or empty for nothing) has no say in the
/// form.
///
/// # Errors
/// [`Undetermined`] where a piece of the mesh has too few measured vertices for any form.
pub fn on_free_form(
    mesh: &TriMesh,
    wavelength: Option<f64>,
    completed: &[bool],
) -> Result<(Relief, f64), Undetermined> {
    let shape = smoothed_positions(mesh, &Adjacency::new(mesh), SHAPE_ROUNDS);
    let wavelength = match wavelength {
        Some(wavelength) => wavelength,
        None => {
            let spacing = median_edge(mesh).ok_or(Undetermined)?;
            choose_wavelength(mesh, &shape, spacing)?.wavelength
        }
    };
    let role = |v: usize| match completed.get(v) {
        Some(true) => Role::Free,
        _ => Role::Measured,
    };
    let roles: Vec<Role> = (0..mesh.positions.len()).map(role).collect();
    let smooth = smooth_form(mesh, &shape, &roles, wavelength)?;
    Ok((over_form(mesh, smooth), wavelength))
}

/// Rounds of smoothing that free form is measured on: what relief would disturb in lengths and angles.
pub(crate) const SHAPE_ROUNDS: usize = 10;

/// Heights beyond this many robust standard deviations are no relief: the roof of a tower over the
/// cylinder of its shaft. Generous, since deep joints and vugs are what completion is for.
const REACH: f64 = 12.0;
/// Standard deviation over median absolute deviation, of a normal distribution.
const MAD_TO_SIGMA: f64 = 1.4826;
/// … and beyond this many plain ones, where the robust one says little.
const PLAIN_REACH: f64 = 4.0;

/// Largest absolute height that counts as relief over a fitted base, in the scan's unit.
#[must_use]
pub fn reach(fit: &FitReport) -> f64 {
    // Where most of the surface is flat the robust scale is (nearly) zero, however deep the rest is
    // engraved; the plain one serves if even that is small against the scan.
    let plain = if fit.rms <= MAX_RELIEF_SHARE * fit.diagonal {
        PLAIN_REACH * fit.rms
    } else {
        0.0
    };
    // Without any relief, rounding must not throw vertices off the base.
    (REACH * fit.scale).max(plain) + 1e-9 * fit.diagonal
}

/// Largest absolute height that counts as relief over free form, in the scan's unit: of these heights, which
/// are all small but at depth jumps and spikes.
#[must_use]
pub fn reach_of(heights: &[f64]) -> f64 {
    let mut absolute: Vec<f64> = heights.iter().map(|h| h.abs()).collect();
    let middle = absolute.len() / 2;
    if absolute.is_empty() {
        return 0.0;
    }
    let (_, median, _) = absolute.select_nth_unstable_by(middle, f64::total_cmp);
    let square: f64 = heights.iter().map(|h| h * h).sum();
    let plain = (square / heights.len() as f64).sqrt();
    (REACH * MAD_TO_SIGMA * *median).max(PLAIN_REACH * plain)
}

/// Puts the relief back on its base: #V points.
#[must_use]
pub fn apply(relief: &Relief) -> Vec<Point3<f64>> {
    (0..relief.feet.len())
        .map(|v| relief.point(v, relief.heights[v]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Sphere;
    use approx::assert_relative_eq;

    fn octahedron() -> TriMesh {
        let positions = [1.0, -1.0]
            .iter()
            .flat_map(|s| [[*s, 0.0, 0.0], [0.0, *s, 0.0], [0.0, 0.0, *s]])
            .map(Point3::from)
            .collect();
        let triangles = vec![
            [0, 1, 2],
            [1, 3, 2],
            [3, 4, 2],
            [4, 0, 2],
            [1, 0, 5],
            [3, 1, 5],
            [4, 3, 5],
            [0, 4, 5],
        ];
        TriMesh {
            positions,
            triangles,
        }
    }

    #[test]
    fn putting_the_relief_back_gives_the_scan() {
        let mut mesh = octahedron();
        mesh.positions[2].z = 1.25;
        let base = BaseSurface::Sphere(Sphere {
            center: Point3::new(0.01, 0.02, -0.03),
            radius: 1.1,
        });
        let relief = extract(&mesh, &base);
        for (p, q) in apply(&relief).iter().zip(&mesh.positions) {
            assert_relative_eq!(p, q, epsilon = 1e-15);
        }
        assert!(relief.heights[2] > 0.0 && relief.heights[0] < 0.0);
        assert_relative_eq!(relief.displacement(2).norm(), relief.heights[2]);
    }

    #[test]
    fn over_a_form_points_are_feet_and_heights_too() {
        let mut mesh = octahedron();
        let form = mesh.positions.clone();
        mesh.positions[2] = Point3::new(0.1, 0.2, 1.25);
        let relief = over_form(&mesh, form);
        assert_relative_eq!(relief.heights[2], 0.25, epsilon = 1e-12);
        assert_relative_eq!(relief.feet[2], Point3::new(0.1, 0.2, 1.0), epsilon = 1e-12);
        for (p, q) in apply(&relief).iter().zip(&mesh.positions) {
            assert_relative_eq!(p, q, epsilon = 1e-15);
        }
        let reach = reach_of(&[0.1, -0.1, 0.1, -0.1, 3.0]);
        assert!((1.5..6.0).contains(&reach), "{reach}");
        assert!(reach_of(&[]).abs() <= 0.0);
    }

    #[test]
    fn heights_rise_towards_the_side_that_the_triangles_face() {
        let mut mesh = octahedron();
        let base = BaseSurface::Sphere(Sphere {
            center: Point3::origin(),
            radius: 0.9,
        });
        assert!(extract(&mesh, &base).heights[0] > 0.0);
        for t in &mut mesh.triangles {
            t.swap(0, 1);
        }
        let inside = extract(&mesh, &base);
        assert!(inside.heights[0] < 0.0);
        assert_relative_eq!(inside.normals[0], -Vector3::x());
    }
}
