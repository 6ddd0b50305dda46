//! The texture image of a scan with texture coordinates.

use nalgebra::{Point3, Vector3};

use super::{Baked, bake};
use crate::mesh::triangle_normal;
use crate::scan::{Scan, image_size};

/// Draws colors into an image for a scan's texture coordinates, so large that its pixels are no larger than `texel` (in
/// the scan's unit) on the surface, as [`image_size`] says, with sides of at most `most` pixels. `None` if the scan has no
/// texture coordinates.
///
/// `color` gives red, green and blue, from 0 to 1, at a point of the surface, with the normal of its triangle (of
/// any length; `None` where that has no area).
///
/// # Panics
/// As [`bake`], and as [`Scan::positions`].
#[must_use]
pub fn bake_surface(
    scan: &Scan,
    texel: f64,
    most: Option<u32>,
    color: impl Fn(&Point3<f64>, Option<&Vector3<f64>>) -> [f64; 3] + Sync,
) -> Option<Baked> {
    let uv = scan.texture_coordinates()?;
    let mesh = scan.mesh();
    let most = most.unwrap_or(u32::MAX).max(1);
    let [width, height] = image_size(&uv, &mesh, texel).map(|pixels| pixels.min(most));
    let at = |triangle: usize, shares: [f64; 3]| {
        let corners = mesh.corners(triangle);
        let point: Vector3<f64> = (corners.iter().zip(shares))
            .map(|(p, share)| p.coords * share)
            .sum();
        let normal = triangle_normal(corners);
        let normal = Some(&normal).filter(|normal| normal.norm() > 0.0);
        color(&Point3::from(point), normal)
    };
    Some(bake(width, height, &uv, at))
}
