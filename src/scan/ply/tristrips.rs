//! Triangle strips of PLY files to faces.
//!
//! Stanford's later scans have no faces but an element `tristrips` with one list `vertex_indices` (or a
//! list a strip), in which −1 begins a new strip. Every second triangle of a strip runs the other way
//! around.

use crate::mesh::Csr;
use crate::scan::vertex_lists::{exact_index, index_lists};
use crate::scan::{Scan, ScanError, Table};

/// Name of the element that holds strips.
const TRISTRIPS: &str = "tristrips";

/// Turns strips into faces, in place of the element, if the scan has no faces yet.
///
/// # Errors
/// [`ScanError::Row`] if a strip refers to a vertex that is not there.
pub(super) fn unroll(scan: &mut Scan, name: &str) -> Result<(), ScanError> {
    let found = scan.other_elements.iter().position(|(n, _)| n == TRISTRIPS);
    let Some(at) = found.filter(|_| scan.faces.is_empty()) else {
        return Ok(());
    };
    let vertices = scan.vertices.rows;
    let row_error = |row: usize, reason: String| ScanError::Row {
        name: name.to_owned(),
        element: TRISTRIPS.to_owned(),
        row,
        reason,
    };
    let table = &scan.other_elements[at].1;
    let Some(lists) = index_lists(table) else {
        return Err(row_error(0, "it has no list `vertex_indices`".to_owned()));
    };
    let mut faces = Csr::default();
    for (row, list) in lists.iter().enumerate() {
        let mut strip = Strip::default();
        for i in 0..list.len() {
            let value = list.get_f64(i).unwrap_or(f64::NAN);
            if value < 0.0 {
                strip = Strip::default();
            } else if let Some(index) = exact_index(value.abs(), vertices) {
                if let Some(triangle) = strip.next(index) {
                    faces.push_row(&triangle);
                }
            } else {
                let reason = format!("{value} is not one of the {vertices} vertices, nor -1");
                return Err(row_error(row, reason));
            }
        }
    }
    if u32::try_from(faces.len().saturating_mul(3)).is_err() {
        return Err(ScanError::TooLarge {
            name: name.to_owned(),
            what: "corners of faces",
        });
    }
    log::info!("{name}: {} triangles from its strips", faces.len());
    scan.faces = faces;
    // Of the faces that the file does not have.
    scan.face_channels = Table::default();
    scan.other_elements.remove(at);
    Ok(())
}

/// The last two vertices of a strip, and whether the next triangle is turned around.
#[derive(Default)]
struct Strip {
    last: [Option<u32>; 2],
    turned: bool,
}

impl Strip {
    /// The triangle that the strip's next vertex makes; none if two of its corners are the same, which
    /// is how strips are joined.
    fn next(&mut self, c: u32) -> Option<[u32; 3]> {
        let [a, b] = self.last;
        self.last = [b, Some(c)];
        let (a, b) = (a?, b?);
        let turned = self.turned;
        self.turned = !turned;
        let triangle = if turned { [b, a, c] } else { [a, b, c] };
        (a != b && b != c && c != a).then_some(triangle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Column;

    fn scan(strips: &[&[i32]]) -> Scan {
        let mut scan = Scan::default();
        for axis in ["x", "y", "z"] {
            let values = (0u8..6).map(f32::from).collect();
            scan.vertices.set_channel(axis, Column::F32(values));
        }
        let lists = strips.iter().map(|s| Column::I32(s.to_vec())).collect();
        let mut table = Table::default();
        table.set_channel("vertex_indices", Column::List(lists));
        scan.other_elements.push((TRISTRIPS.to_owned(), table));
        scan
    }

    fn faces(strips: &[&[i32]]) -> Result<Vec<Vec<u32>>, ScanError> {
        let mut scan = scan(strips);
        let done = unroll(&mut scan, "a.ply");
        done.map(|()| scan.faces.rows().map(<[u32]>::to_vec).collect())
    }

    #[test]
    fn every_second_triangle_is_turned_and_minus_one_begins_anew() {
        let expected = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [3, 4, 5]];
        assert_eq!(
            faces(&[&[0, 1, 2, 3, 4, -1, 3, 4, 5, -1]]).unwrap(),
            expected
        );
        assert_eq!(faces(&[&[0, 1, 2, 3, 4], &[3, 4, 5]]).unwrap(), expected);
    }

    #[test]
    fn repeated_vertices_join_strips_and_keep_the_sense() {
        // 0 1 2 | 2 3 3 | 3 4 5: the degenerate ones count when sides are told.
        let joined = faces(&[&[0, 1, 2, 2, 3, 3, 4, 5]]).unwrap();
        assert_eq!(joined, [[0, 1, 2], [4, 3, 5]]);
        assert!(faces(&[&[], &[1], &[1, 2], &[-1, -1]]).unwrap().is_empty());
    }

    #[test]
    fn vertices_that_are_not_there_are_errors() {
        let error = faces(&[&[0, 1, 2], &[0, 1, 6]]).unwrap_err().to_string();
        assert!(
            error.contains("row 1") && error.contains("6 is not one"),
            "{error}"
        );
    }

    #[test]
    fn faces_of_the_file_win() {
        let mut scan = scan(&[&[0, 1, 2]]);
        scan.faces.push_row(&[3, 4, 5]);
        let before = scan.clone();
        unroll(&mut scan, "a.ply").unwrap();
        assert_eq!(scan, before);
    }
}
