//! Texture coordinates of the faces' corners, wherever a scan keeps them.
//!
//! u runs from 0 at the left border of the image to 1 at the right one, v from 0 at the bottom to 1 at the top.
//! Either faces have a list of both for each corner, as MeshLab writes PLY and as OBJ is read, or vertices
//! have them, as glTF does (whose v runs down in the file).

use std::borrow::Cow;

use super::triangulate::triangulate;
use super::{Column, Scan, Table};
use crate::mesh::Csr;

/// The faces' list: u and v of each corner.
pub(super) const OF_CORNERS: &str = "texcoord";

/// Names of the vertices' two channels: of Blender, of MeshLab, of several programs.
pub(super) const OF_VERTICES: [[&str; 2]; 3] = [["s", "t"], ["texture_u", "texture_v"], ["u", "v"]];

/// Faces of more corners look theirs up in order.
const MOST_SEARCHED: usize = 8;

/// Where a scan keeps them.
#[derive(Debug, Clone, Copy)]
pub(super) enum Coordinates<'a> {
    Corners(&'a [Column]),
    Vertices([&'a Column; 2]),
}

/// The vertices' channels.
pub(super) fn of_vertices(table: &Table) -> Option<[usize; 2]> {
    OF_VERTICES.iter().find_map(|[u, v]| {
        let [u, v] = [u, v].map(|name| table.scalar_index(name));
        Some([u?, v?])
    })
}

impl<'a> Coordinates<'a> {
    /// `None` if there are none, or no faces.
    pub(super) fn of(scan: &'a Scan) -> Option<Self> {
        if let Some(Column::List(lists)) = scan.face_channels.column(OF_CORNERS)
            && (lists.iter().zip(scan.faces.rows())).any(|(list, face)| is_complete(list, face))
        {
            return Some(Self::Corners(lists));
        }
        let channels = of_vertices(&scan.vertices).filter(|_| !scan.faces.is_empty())?;
        let columns = channels.map(|c| &scan.vertices.channels[c].values);
        Some(Self::Vertices(columns))
    }

    /// Those of a corner of a face; NaN if it has none.
    fn corner(&self, face: usize, vertices: &[u32], corner: usize) -> [f64; 2] {
        let values = match self {
            Self::Corners(lists) => {
                let list = lists.get(face).filter(|list| is_complete(list, vertices));
                [0, 1].map(|k| list.and_then(|list| list.get_f64(2 * corner + k)))
            }
            Self::Vertices(columns) => columns.map(|c| c.get_f64(vertices[corner] as usize)),
        };
        values.map(|value| value.unwrap_or(f64::NAN))
    }

    /// Those of all corners of a face; none if one is not finite.
    pub(super) fn face(&self, face: usize, vertices: &[u32]) -> Vec<[f64; 2]> {
        let corners = (0..vertices.len()).map(|corner| self.corner(face, vertices, corner));
        let corners: Vec<[f64; 2]> = corners.collect();
        let complete = corners.iter().flatten().all(|c| c.is_finite());
        if complete { corners } else { Vec::new() }
    }

    /// The triangles that a scan's faces are split into, each with the number of its face and those of its
    /// corners.
    ///
    /// In a polygon that passes a vertex twice both corners take those of the first.
    pub(super) fn triangles(
        &self,
        scan: &Scan,
        mut take: impl FnMut(usize, [u32; 3], [[f64; 2]; 3]),
    ) {
        let positions = scan.positions();
        let (mut split, mut sorted) = (Vec::new(), Vec::new());
        for (number, face) in scan.faces.rows().enumerate() {
            split.clear();
            triangulate(face, |v| positions[v as usize], &mut split);
            sorted.clear();
            if face.len() > MOST_SEARCHED {
                sorted.extend(face.iter().copied().zip(0..));
                sorted.sort_unstable();
            }
            let corner_of = |vertex: u32| {
                let corner = if sorted.is_empty() {
                    face.iter().position(|v| *v == vertex)
                } else {
                    let at = sorted.partition_point(|(v, _)| *v < vertex);
                    sorted.get(at).map(|(_, corner)| *corner)
                };
                corner.unwrap_or_default()
            };
            for triangle in &split {
                let corners = triangle.map(|v| self.corner(number, face, corner_of(v)));
                take(number, *triangle, corners);
            }
        }
    }
}

/// Whether a list has two numbers for each corner of a face.
fn is_complete(list: &Column, face: &[u32]) -> bool {
    list.len() == 2 * face.len()
}

/// Whether the vertices of a triangle differ: others are no part of a mesh.
pub(super) fn is_proper([a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}

impl Scan {
    /// Texture coordinates of the corners of each triangle of [`mesh`](Self::mesh), in its order: u from 0 at
    /// the left border of the image to 1 at the right one, v from 0 at the *bottom* to 1 at the top.
    ///
    /// Looked for as the faces' list `texcoord`, then as the vertices' `s`, `t`; `texture_u`, `texture_v`; `u`,
    /// `v`. NaN where there are none; `None` if no corner has any. Triangles of [`triangles`](Self::triangles)
    /// with the same vertex twice, which `mesh` drops, have no row.
    ///
    /// Coordinates of vertices are those of the vertices that the faces name: after [`crate::repair`] has
    /// joined seams, [`restore`](crate::repair::Repaired::restore) the scan first.
    ///
    /// # Panics
    /// As [`positions`](Self::positions).
    #[must_use]
    pub fn texture_coordinates(&self) -> Option<Vec<[[f64; 2]; 3]>> {
        let coordinates = Coordinates::of(self)?;
        let mut rows = Vec::with_capacity(self.faces.len());
        coordinates.triangles(self, |_, triangle, corners| {
            if is_proper(&triangle) {
                rows.push(corners);
            }
        });
        let any = rows.iter().flatten().flatten().any(|c| c.is_finite());
        any.then_some(rows)
    }

    /// The scan with the faces' list `texcoord`, empty for faces without texture coordinates; as it is, if it has
    /// none or the list already.
    pub(super) fn with_corner_coordinates(&self) -> Cow<'_, Self> {
        let Some(coordinates @ Coordinates::Vertices(_)) = Coordinates::of(self) else {
            return Cow::Borrowed(self);
        };
        let faces = self.faces.rows().enumerate();
        let lists = faces.map(|(number, face)| listed(&coordinates.face(number, face)));
        let lists = Column::List(lists.collect());
        let mut scan = self.clone();
        scan.face_channels.set_channel(OF_CORNERS, lists);
        Cow::Owned(scan)
    }

    /// The triangles with texture coordinates `s` and `t` of their vertices. A vertex whose corners differ in
    /// them is there several times: once with its number, and again behind all others. Corners without any
    /// get 0.
    pub(super) fn split_at_seams(&self) -> Option<Self> {
        let coordinates = Coordinates::of(self)?;
        let mut corners: Vec<(u32, [u32; 2])> = Vec::new();
        coordinates.triangles(self, |_, triangle, of_corners| {
            for (vertex, place) in triangle.into_iter().zip(of_corners) {
                let place = place
                    .map(float)
                    .map(|c| if c.is_finite() { c } else { 0.0 });
                corners.push((vertex, place.map(f32::to_bits)));
            }
        });
        let mut different = corners.clone();
        different.sort_unstable();
        different.dedup();
        let count = self.vertices.rows;
        let mut sources: Vec<u32> = (0u32..).take(count).collect();
        let mut places = vec![[0.0f32; 2]; count];
        // The number of each of the different ones.
        let mut numbers = Vec::with_capacity(different.len());
        let mut before = None;
        for (vertex, place) in &different {
            let place = place.map(f32::from_bits);
            if before == Some(vertex) {
                numbers.push(u32::try_from(sources.len()).ok()?);
                sources.push(*vertex);
                places.push(place);
            } else {
                numbers.push(*vertex);
                places[*vertex as usize] = place;
            }
            before = Some(vertex);
        }
        let mut faces = Csr::default();
        for triangle in corners.chunks_exact(3) {
            let corner = |c: usize| {
                different
                    .binary_search(&triangle[c])
                    .ok()
                    .map(|at| numbers[at])
            };
            faces.push_row(&[corner(0)?, corner(1)?, corner(2)?]);
        }
        let mut vertices = self.vertices.rows_of(&sources);
        let of_vertices = OF_VERTICES.as_flattened();
        (vertices.channels).retain(|c| !of_vertices.contains(&c.name.as_str()));
        for (k, name) in OF_VERTICES[0].into_iter().enumerate() {
            let values = places.iter().map(|place| place[k]).collect();
            vertices.set_channel(name, Column::F32(values));
        }
        Some(Self {
            vertices,
            faces,
            ..Self::default()
        })
    }
}

/// The list of a face. `float`, since that is what other programs expect there.
pub(super) fn listed(corners: &[[f64; 2]]) -> Column {
    Column::F32(corners.iter().flatten().map(|c| float(*c)).collect())
}

/// The nearest `float`.
pub(super) fn float(value: f64) -> f32 {
    super::channel::Scalar::rounded(value)
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "the values are exact in binary")]
mod tests {
    use super::*;
    use crate::scan::{Format, ReadOptions, read_from};

    fn read(text: &str, format: Format) -> Scan {
        read_from(text.as_bytes(), format, "a", &ReadOptions::default()).unwrap()
    }

    /// A quad, a triangle with a vertex twice, one without coordinates, and one more; the coordinates of a
    /// corner tell its number in the face.
    const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0.5 0\n\
                       vt 0 0\nvt 0.25 0\nvt 0.5 0\nvt 0.75 0\n\
                       f 1/1 2/2 3/3 4/4\nf 1/1 1/2 2/3\nf 2 5/2 3/3\nf 5/1 3/2 2/3\n";

    #[test]
    fn rows_are_those_of_the_triangles_of_the_mesh() {
        let scan = read(OBJ, Format::Obj);
        let (mesh, rows) = (scan.mesh(), scan.texture_coordinates().unwrap());
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [1, 4, 2], [4, 2, 1]]);
        let first = |row: usize| rows[row].map(|c| c[0]);
        assert_eq!(first(0), [0.0, 0.25, 0.5]);
        assert_eq!(first(1), [0.0, 0.5, 0.75]);
        assert!(first(2).iter().all(|c| c.is_nan()));
        assert_eq!(first(3), [0.0, 0.25, 0.5]);
        assert_eq!(rows.len(), 4);
    }

    #[test]
    fn large_polygons_take_those_of_their_own_corners() {
        let mut text = String::new();
        for k in 0..20 {
            let (sin, cos) = (f64::from(k) * 0.314).sin_cos();
            text += &format!("v {cos} {sin} 0\nvt {} 0\n", f64::from(k) / 32.0);
        }
        text += "f";
        for k in 0..20 {
            // In another order than the vertices'.
            let vertex = (k * 7) % 20 + 1;
            text += &format!(" {vertex}/{}", k + 1);
        }
        let scan = read(&text, Format::Obj);
        let rows = scan.texture_coordinates().unwrap();
        assert_eq!(rows.len(), 18);
        for (triangle, row) in scan.mesh().triangles.iter().zip(&rows) {
            for (vertex, place) in triangle.iter().zip(row) {
                let corner = scan.faces.row(0).iter().position(|v| v == vertex).unwrap();
                assert_eq!(place[0], corner as f64 / 32.0);
            }
        }
    }

    fn ply(vertex: &str, rows: &str, face: &str, lists: &str) -> Scan {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             {vertex}element face 1\nproperty list uchar int vertex_indices\n{face}end_header\n{rows}3 0 1 2{lists}\n"
        );
        read(&text, Format::Ply)
    }

    #[test]
    fn every_usual_name_is_known() {
        for [s, t] in OF_VERTICES {
            let scan = ply(
                &format!("property float {s}\nproperty double {t}\n"),
                "0 0 0 0.5 0.25\n1 0 0 1 0\n0 1 0 0 1\n",
                "",
                "",
            );
            let rows = scan.texture_coordinates().unwrap();
            assert_eq!(rows, [[[0.5, 0.25], [1.0, 0.0], [0.0, 1.0]]], "{s}");
            assert_eq!(
                scan.with_corner_coordinates().texture_coordinates(),
                Some(rows)
            );
        }
        let rows = "0 0 0\n1 0 0\n0 1 0\n";
        let face = "property list uchar float texcoord\n";
        let scan = ply("", rows, face, " 6 0.5 0.25 1 0 0 1");
        assert_eq!(scan.texture_coordinates().unwrap()[0][0], [0.5, 0.25]);
        for incomplete in [" 0", " 4 1 1 1 1", " 6 nan nan nan nan nan nan"] {
            assert_eq!(ply("", rows, face, incomplete).texture_coordinates(), None);
        }
        assert_eq!(ply("", rows, "", "").texture_coordinates(), None);
    }

    #[test]
    fn vertices_are_split_where_their_corners_differ() {
        let scan = read(OBJ, Format::Obj);
        let split = scan.split_at_seams().unwrap();
        assert_eq!(split.check("split").map_err(|e| e.to_string()), Ok(()));
        let (old, new) = (scan.positions(), split.positions());
        assert_eq!(new[..old.len()], old);
        let finite = |c: f64| if c.is_nan() { 0.0 } else { c };
        let rows = scan.texture_coordinates().unwrap();
        let rows = rows.into_iter().map(|row| row.map(|c| c.map(finite)));
        assert_eq!(split.texture_coordinates(), Some(rows.collect()));
        let corners = |scan: &Scan| {
            let positions = scan.positions();
            let triangles = scan.triangles().into_iter().flatten();
            triangles.map(|v| positions[v as usize]).collect::<Vec<_>>()
        };
        assert_eq!(corners(&split), corners(&scan));
        assert!(
            read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)
                .split_at_seams()
                .is_none()
        );
    }
}
