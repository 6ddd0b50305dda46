//! How large a texture image should be.

use crate::mesh::TriMesh;

/// Smallest side of a texture image, in pixels.
const SMALLEST: u32 = 64;

/// Largest side, in pixels: all of today's graphics cards take it.
const LARGEST: u32 = 8192;

/// Width and height of a texture image whose pixels are, on the surface, no wider and no higher than `texel`
/// (in the scan's unit) in the median triangle: the next powers of two, from 64 to 8192.
///
/// `uv`: u and v of the corners of each triangle of `mesh`. Triangles without a finite area there do not
/// count; if none is left, the image is as small as can be.
///
/// A pixel's width on a triangle is |∂p/∂u| over the number of columns, its height |∂p/∂v| over that of rows.
#[must_use]
pub fn image_size(uv: &[[[f64; 2]; 3]], mesh: &TriMesh, texel: f64) -> [u32; 2] {
    let mut stretches: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
    for (corners, triangle) in uv.iter().zip(&mesh.triangles) {
        let [p, q, r] = triangle.map(|v| mesh.positions[v as usize]);
        let edges = [q - p, r - p];
        let [first, second] =
            [1, 2].map(|k| [0, 1].map(|axis| corners[k][axis] - corners[0][axis]));
        let area = first[0] * second[1] - first[1] * second[0];
        let along_u = (edges[0] * second[1] - edges[1] * first[1]).norm() / area.abs();
        let along_v = (edges[1] * first[0] - edges[0] * second[0]).norm() / area.abs();
        if along_u.is_finite() && along_v.is_finite() {
            stretches[0].push(along_u);
            stretches[1].push(along_v);
        }
    }
    stretches.map(|mut values| {
        if values.is_empty() {
            return SMALLEST;
        }
        let middle = values.len() / 2;
        let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
        let least = *median / texel;
        let mut side = SMALLEST;
        while f64::from(side) < least && side < LARGEST {
            side *= 2;
        }
        side
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn pixels_are_as_small_as_asked_for() {
        // 10 by 5, which takes a quarter of the image's width and half of its height.
        let corner = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let mesh = TriMesh {
            positions: vec![
                corner(0.0, 0.0),
                corner(10.0, 0.0),
                corner(10.0, 5.0),
                corner(0.0, 5.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 2, 3]],
        };
        let uv = [
            [[0.0, 0.0], [0.25, 0.0], [0.25, 0.5]],
            [[0.0, 0.0], [0.25, 0.5], [0.0, 0.5]],
            [[f64::NAN; 2]; 3],
        ];
        // The whole image would be 40 wide and 10 high.
        assert_eq!(image_size(&uv, &mesh, 0.1), [512, 128]);
        assert_eq!(image_size(&uv, &mesh, 40.0 / 512.0), [512, 128]);
        assert_eq!(image_size(&uv, &mesh, 100.0), [64, 64]);
        assert_eq!(image_size(&uv, &mesh, 1e-9), [8192, 8192]);
        assert_eq!(image_size(&uv[2..], &mesh, 0.1), [64, 64]);
    }
}
