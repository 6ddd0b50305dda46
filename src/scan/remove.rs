//! A scan without some of its vertices or faces, and the channels of faces that are turned.

use super::channel::match_column;
use super::texture_coordinates::OF_CORNERS;
use super::{Column, Scan, Table};
use crate::mesh::Csr;

impl Scan {
    /// The scan without the given vertices and all faces at them; everything else is kept in its order,
    /// bit for bit. Also gives, for each vertex that is kept, its number before.
    ///
    /// Further elements (edges, strips, grids) and sensors refer to vertices by number and are left out.
    ///
    /// # Panics
    /// If `removed` has not one entry a vertex.
    #[must_use]
    pub fn without(&self, removed: &[bool]) -> (Self, Vec<u32>) {
        assert_eq!(removed.len(), self.vertices.rows, "one entry a vertex");
        let kept: Vec<u32> = (0u32..)
            .zip(removed)
            .filter(|(_, removed)| !**removed)
            .map(|(v, _)| v)
            .collect();
        let mut number = vec![0u32; removed.len()];
        for (new, old) in (0u32..).zip(&kept) {
            number[*old as usize] = new;
        }
        let (mut faces, mut kept_faces) = (Csr::default(), Vec::new());
        for (f, face) in (0u32..).zip(self.faces.rows()) {
            if face.iter().all(|v| !removed[*v as usize]) {
                let renumbered: Vec<u32> = face.iter().map(|v| number[*v as usize]).collect();
                faces.push_row(&renumbered);
                kept_faces.push(f);
            }
        }
        let scan = Self {
            vertices: self.vertices.rows_of(&kept),
            face_channels: self.face_channels.rows_of(&kept_faces),
            faces,
            other_elements: Vec::new(),
            sensors: Vec::new(),
            ..self.clone()
        };
        (scan, kept)
    }
}

impl Scan {
    /// Keeps the channels of some faces only; the faces themselves are left as they are.
    ///
    /// # Panics
    /// If `kept` has not one entry a row of the channels.
    pub(crate) fn retain_face_channels(&mut self, kept: &[bool]) {
        if self.face_channels.channels.is_empty() {
            return;
        }
        assert_eq!(kept.len(), self.face_channels.rows, "one entry a face");
        let rows: Vec<u32> = (0u32..)
            .zip(kept)
            .filter(|(_, kept)| **kept)
            .map(|(f, _)| f)
            .collect();
        self.face_channels = self.face_channels.rows_of(&rows);
    }

    /// Turns the channels of faces that hold something for every corner, as texture coordinates do: of the
    /// turned ones of `faces`, which the rows stand for. The first corner stays the first.
    ///
    /// Such are lists with the same number of values a corner in every face that has any, and texture
    /// coordinates.
    ///
    /// # Panics
    /// If `turned` or `faces` have not one entry a row of the channels.
    pub(crate) fn turn_face_channels(&mut self, faces: &Csr, turned: &[bool]) {
        for channel in &mut self.face_channels.channels {
            let Column::List(lists) = &mut channel.values else {
                continue;
            };
            let of_texture = (channel.name == OF_CORNERS).then_some(2);
            let Some(per_corner) = of_texture.or_else(|| per_corner(lists, faces)) else {
                continue;
            };
            for (f, (list, turned)) in lists.iter_mut().zip(turned).enumerate() {
                if *turned && list.len() == per_corner * faces.row(f).len() {
                    list.turn(per_corner);
                }
            }
        }
    }
}

/// Number of values a corner that the lists of all faces have, but for empty ones.
fn per_corner(lists: &[Column], faces: &Csr) -> Option<usize> {
    let mut filled = (lists.iter().enumerate())
        .map(|(f, list)| (list.len(), faces.row(f).len()))
        .filter(|(values, _)| *values > 0);
    let (values, corners) = filled.clone().next()?;
    let per_corner = values.checked_div(corners)?;
    let all = filled.all(|(values, corners)| values == per_corner * corners);
    all.then_some(per_corner)
}

impl Table {
    /// The given rows of every column.
    pub(super) fn rows_of(&self, rows: &[u32]) -> Self {
        let mut table = self.clone();
        table.rows = rows.len();
        for (channel, old) in table.channels.iter_mut().zip(&self.channels) {
            channel.values = old.values.rows_of(rows);
        }
        table
    }
}

impl Column {
    /// Reverses the order of all groups of `size` values but the first.
    fn turn(&mut self, size: usize) {
        match_column!(self, values => {
            let others = &mut values[size..];
            others.reverse();
            others.chunks_exact_mut(size).for_each(<[_]>::reverse);
        }, _nested => {});
    }

    fn rows_of(&self, rows: &[u32]) -> Self {
        fn taken<T: Clone>(values: &[T], rows: &[u32]) -> Vec<T> {
            rows.iter().map(|r| values[*r as usize].clone()).collect()
        }
        match self {
            Self::I8(values) => Self::I8(taken(values, rows)),
            Self::U8(values) => Self::U8(taken(values, rows)),
            Self::I16(values) => Self::I16(taken(values, rows)),
            Self::U16(values) => Self::U16(taken(values, rows)),
            Self::I32(values) => Self::I32(taken(values, rows)),
            Self::U32(values) => Self::U32(taken(values, rows)),
            Self::F32(values) => Self::F32(taken(values, rows)),
            Self::F64(values) => Self::F64(taken(values, rows)),
            Self::List(lists) => Self::List(taken(lists, rows)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_keeps_its_values_and_faces_follow() {
        let mut scan = Scan::default();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let values = (0..5).map(|v| f64::from(v) + 0.1 * axis as f64);
            scan.vertices
                .set_channel(name, Column::F64(values.collect()));
        }
        let lists = (0..5u8).map(|v| Column::U8(vec![v; 2])).collect();
        scan.vertices.set_channel("list", Column::List(lists));
        for face in [&[0, 1, 2][..], &[0, 2, 3, 4], &[0, 2, 3]] {
            scan.faces.push_row(face);
        }
        scan.face_channels
            .set_channel("part", Column::I32(vec![7, 8, 9]));
        let (cut, kept) = scan.without(&[false, true, false, false, false]);
        assert_eq!(kept, [0, 2, 3, 4]);
        assert_eq!(cut.check("cut").map_err(|e| e.to_string()), Ok(()));
        let faces: Vec<&[u32]> = cut.faces.rows().collect();
        assert_eq!(faces, [&[0, 1, 2, 3][..], &[0, 1, 2]]);
        let Some(Column::I32(parts)) = cut.face_channels.column("part") else {
            unreachable!();
        };
        assert_eq!(parts, &[8, 9]);
        let Some(Column::List(lists)) = cut.vertices.column("list") else {
            unreachable!();
        };
        assert_eq!(lists[1], Column::U8(vec![2, 2]));
    }
}
