//! A scan on a finer mesh of the same surface.

use nalgebra::Point3;

use super::color::ColorLayout;
use super::texture_coordinates::{OF_CORNERS, OF_VERTICES, is_proper, listed};
use super::triangulate::triangulate;
use super::{Column, Scan};
use crate::mesh::{Bisected, Csr, PreparedTriangle};

impl Scan {
    /// The scan with the vertices and triangles of `finer`, which [`bisected`](crate::mesh::bisected) made of its
    /// [`mesh`](Self::mesh).
    ///
    /// The original vertices keep every channel, bit by bit. New ones have the coordinates of the finer mesh, rounded
    /// to the channels' types; the means of their parents where channels are `float`, `double` or colors; and else the
    /// values of the first parent. Triangles have the channels of the face that they are a part of.
    ///
    /// `uv`: texture coordinates of the corners of each triangle of `mesh`, as of
    /// [`texture_coordinates`](Self::texture_coordinates), which become the faces' list `texcoord`. Any other
    /// coordinates of that kind are left out.
    ///
    /// # Panics
    /// If `finer` is not made of this scan's mesh, or `uv` has not one row for each of its triangles.
    #[must_use]
    pub fn refined(&self, finer: &Bisected, uv: Option<&[[[f64; 2]; 3]]>) -> Self {
        let (triangles, of_faces) = self.numbered_triangles();
        let originals = finer.mesh.positions.len() - finer.parents.len();
        assert_eq!(originals, self.vertices.rows, "of this scan's vertices");
        let mut scan = self.clone();
        scan.faces = Csr::default();
        for triangle in &finer.mesh.triangles {
            scan.faces.push_row(triangle);
        }
        let faces: Vec<u32> = (finer.faces.iter())
            .map(|f| of_faces[*f as usize])
            .collect();
        scan.face_channels.channels.retain(|c| c.name != OF_CORNERS);
        scan.face_channels = scan.face_channels.rows_of(&faces);
        scan.face_channels.rows = faces.len();
        if let Some(uv) = uv {
            assert_eq!(uv.len(), triangles.len(), "one row a triangle");
            let of_vertices = OF_VERTICES.as_flattened();
            (scan.vertices.channels).retain(|c| !of_vertices.contains(&c.name.as_str()));
            let positions = &finer.mesh.positions;
            let lists = (finer.mesh.triangles.iter().zip(&finer.faces)).map(|(part, whole)| {
                let corners = triangles[*whole as usize].map(|v| positions[v as usize]);
                let at = part.map(|v| positions[v as usize]);
                listed(&placed(corners, at, &uv[*whole as usize]))
            });
            let lists = Column::List(lists.collect());
            scan.face_channels.set_channel(OF_CORNERS, lists);
        }
        scan.append_between(finer);
        scan
    }

    /// The triangles of the mesh, with the numbers of their faces.
    fn numbered_triangles(&self) -> (Vec<[u32; 3]>, Vec<u32>) {
        let positions = self.positions();
        let (mut triangles, mut faces) = (Vec::new(), Vec::new());
        for (number, face) in (0u32..).zip(self.faces.rows()) {
            let first = triangles.len();
            triangulate(face, |v| positions[v as usize], &mut triangles);
            let mut kept = first;
            for at in first..triangles.len() {
                if is_proper(&triangles[at]) {
                    triangles[kept] = triangles[at];
                    kept += 1;
                    faces.push(number);
                }
            }
            triangles.truncate(kept);
        }
        (triangles, faces)
    }

    /// Appends the values of the new vertices.
    fn append_between(&mut self, finer: &Bisected) {
        let vertices = finer.mesh.positions.len();
        let axes = self.vertices.triple(["x", "y", "z"]);
        let colors = ColorLayout::of(&self.vertices).map(|layout| layout.channels);
        for (number, channel) in self.vertices.channels.iter_mut().enumerate() {
            let axis = axes.and_then(|axes| axes.iter().position(|axis| *axis == number));
            let is_color = colors.is_some_and(|colors| colors.contains(&number));
            let column = &mut channel.values;
            column.reserve(finer.parents.len());
            let is_mixed = is_color || matches!(column, Column::F32(_) | Column::F64(_));
            for (v, [a, b]) in (vertices - finer.parents.len()..).zip(&finer.parents) {
                let ends = [a, b].map(|end| column.get_f64(*end as usize));
                match (axis, ends) {
                    (Some(k), _) => column.push_rounded(finer.mesh.positions[v][k]),
                    (None, [Some(a), Some(b)]) if is_mixed => column.push_rounded(0.5 * (a + b)),
                    _ => column.push_copy(*a as usize),
                }
            }
        }
        self.vertices.rows = vertices;
    }
}

/// Texture coordinates at points of a triangle, of those of its corners.
fn placed(
    corners: [Point3<f64>; 3],
    points: [Point3<f64>; 3],
    uv: &[[f64; 2]; 3],
) -> [[f64; 2]; 3] {
    let triangle = PreparedTriangle::new(corners);
    points.map(|point| {
        let [second, third] = triangle.closest(&point);
        let shares = [1.0 - second - third, second, third];
        [0, 1].map(|k| (0..3).map(|corner| shares[corner] * uv[corner][k]).sum())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::bisected;

    /// A quad and a triangle, of all kinds of channels.
    fn scan() -> Scan {
        let mut scan = Scan::default();
        for (name, values) in [
            ("x", vec![0.0, 4.0, 4.0, 0.0, 8.0]),
            ("y", vec![0.0, 0.0, 4.0, 4.0, 2.0]),
            ("z", vec![0.0; 5]),
            ("quality", vec![0.0, 1.0, 2.0, f32::NAN, 5.0]),
        ] {
            scan.vertices.set_channel(name, Column::F32(values));
        }
        for name in ["red", "green", "blue"] {
            let values = Column::U8(vec![0, 100, 200, 50, 10]);
            scan.vertices.set_channel(name, values);
        }
        let label = Column::I32(vec![7, 9, 11, 13, 15]);
        scan.vertices.set_channel("label", label);
        for (name, values) in [
            ("s", vec![0.0, 0.5, 0.5, 0.0, 1.0]),
            ("t", vec![0.0, 0.0, 0.5, 0.5, 0.25]),
        ] {
            scan.vertices.set_channel(name, Column::F64(values));
        }
        scan.faces.push_row(&[0, 1, 2, 3]);
        scan.faces.push_row(&[1, 4, 2]);
        scan.face_channels
            .set_channel("group", Column::U8(vec![3, 4]));
        scan
    }

    #[test]
    fn new_vertices_are_between_their_parents_and_triangles_keep_their_face() {
        let scan = scan();
        let finer = bisected(&scan.mesh(), 60);
        let refined = scan.refined(&finer, None);
        refined.check("it").unwrap();
        assert_eq!(refined.mesh(), finer.mesh, "all coordinates are exact here");
        for (channel, before) in refined
            .vertices
            .channels
            .iter()
            .zip(&scan.vertices.channels)
        {
            assert_eq!(channel.name, before.name);
            for v in 0..5 {
                let [now, then] = [channel, before].map(|c| c.values.get_f64(v).unwrap());
                assert_eq!(now.to_bits(), then.to_bits(), "{} of {v}", channel.name);
            }
        }
        let value = |name: &str, v: usize| refined.vertices.column(name).unwrap().get_f64(v);
        for (v, [a, b]) in (5..).zip(&finer.parents) {
            let [a, b] = [a, b].map(|end| *end as usize);
            for (name, error) in [("red", 0.5), ("quality", 1e-6)] {
                let mean = 0.5 * (value(name, a).unwrap() + value(name, b).unwrap());
                let found = value(name, v).unwrap();
                assert!(
                    (found - mean).abs() <= error || mean.is_nan(),
                    "{name} of {v}"
                );
            }
            assert_eq!(value("label", v), value("label", a));
        }
        let Some(Column::U8(groups)) = refined.face_channels.column("group") else {
            panic!("the type is another one");
        };
        for (triangle, group) in finer.mesh.triangles.iter().zip(groups) {
            let middle: f64 = (triangle.iter())
                .map(|v| finer.mesh.positions[*v as usize].x / 3.0)
                .sum();
            assert_eq!(*group, if middle < 4.0 { 3 } else { 4 });
        }
    }

    #[test]
    fn texture_coordinates_stay_where_they_are_on_the_surface() {
        let scan = scan();
        let finer = bisected(&scan.mesh(), 60);
        let uv = scan.texture_coordinates().unwrap();
        let refined = scan.refined(&finer, Some(&uv));
        refined.check("it").unwrap();
        assert!(refined.vertices.column("s").is_none());
        let found = refined.texture_coordinates().unwrap();
        assert_eq!(found.len(), finer.mesh.triangles.len());
        for (triangle, corners) in finer.mesh.triangles.iter().zip(found) {
            for (v, [u, up]) in triangle.iter().zip(corners) {
                let p = finer.mesh.positions[*v as usize];
                // Both are linear in the place here, an eighth of it.
                assert!((u - p.x / 8.0).abs() < 1e-6 && (up - p.y / 8.0).abs() < 1e-6);
            }
        }
    }
}
