//! Stanford range grids to triangles.
//!
//! A range image is stored as PLY element `range_grid`, one row a grid cell, row by row, each a list
//! of no or one vertex; `obj_info num_cols` and `num_rows` tell the grid's shape.
//!
//! Reference: Greg Turk and Marc Levoy, *Zippered Polygon Meshes from Range Images*, SIGGRAPH 1994,
//! section 3.

use nalgebra::{Point3, Vector3};

use super::vertex_lists::{exact_index, index_lists};
use super::{Column, Scan, ScanError, Table};
use crate::mesh::{Csr, triangle_normal};

/// Longest edge, as a multiple of the median distance between neighbors in the grid.
///
/// Turk and Levoy cut triangles with an edge longer than four times the (largest) sampling distance.
/// The median is robust against the jumps themselves, but smaller; with it, a factor of 4 tears holes
/// into walls that were in fact seen. 7 times the step is a surface seen at 8° (asin 1/7), flatter
/// than where range finders still deliver. Factors between 6 and 8 change the number of triangles of
/// three real scans by less than 2 %.
const LONGEST_EDGE: f64 = 7.0;

/// Name of the element that holds a range grid.
pub const RANGE_GRID: &str = "range_grid";

/// Triangulates the grids of a scan that has no faces yet: those that its reader found, and its own
/// `range_grid`.
///
/// Each cell of four neighbors gives two triangles, split along its shorter diagonal, or one where
/// one corner is missing; triangles with too long an edge are left out. All triangles of a grid run the
/// same way around: towards the sensor where it is known, or else such that their summed normal points
/// along the positive side of the axis that it is closest to. For the Stanford scanner and for height
/// maps, which look down the z axis, this is towards the viewer.
pub(super) fn triangulate(
    scan: &mut Scan,
    mut grids: Vec<Grid>,
    name: &str,
) -> Result<(), ScanError> {
    if !scan.faces.is_empty() {
        return Ok(());
    }
    if let Some((_, table)) = scan.other_elements.iter().find(|(n, _)| n == RANGE_GRID) {
        grids.push(Grid::of_element(scan, table, name)?);
    }
    if grids.is_empty() {
        return Ok(());
    }
    let positions = scan.positions();
    let mut faces = Csr::default();
    for grid in &grids {
        for triangle in &grid.facing_triangles(&positions) {
            faces.push_row(triangle);
        }
    }
    log::info!("{name}: {} triangles from its range grid", faces.len());
    scan.faces = faces;
    // Of the faces that the file does not have.
    scan.face_channels = Table::default();
    Ok(())
}

/// Vertices in rows and columns.
#[derive(Debug)]
pub(super) struct Grid {
    /// Number of columns.
    pub(super) columns: usize,
    /// Row by row, the vertex of each cell, if the sensor saw any.
    pub(super) cells: Vec<Option<u32>>,
    /// Where the sensor stood, in the scan's coordinates, if that is known.
    pub(super) sensor: Option<Point3<f64>>,
}

impl Grid {
    fn of_element(scan: &Scan, table: &Table, name: &str) -> Result<Self, ScanError> {
        let [columns, rows] = ["num_cols", "num_rows"].map(|key| info(&scan.obj_info, key));
        let number = |text: Option<&str>| text.and_then(|t| t.parse::<usize>().ok());
        let size = number(columns).zip(number(rows));
        let Some(columns) = size
            .filter(|(c, r)| c.checked_mul(*r) == Some(table.rows))
            .map(|(c, _)| c)
        else {
            return Err(ScanError::GridSize {
                name: name.to_owned(),
                columns: columns.unwrap_or("an unknown number of").to_owned(),
                rows: rows.unwrap_or("an unknown number of").to_owned(),
                cells: table.rows,
            });
        };
        let Some(lists) = index_lists(table) else {
            return Err(row_error(
                name,
                0,
                "it has no list `vertex_indices`".to_owned(),
            ));
        };
        let vertices = scan.vertices.rows;
        let cell = |(row, list): (usize, &Column)| {
            if list.is_empty() {
                return Ok(None);
            }
            // Indices of all integer types are exact in f64; a float is no index.
            let index = list.get_f64(0).and_then(|v| exact_index(v, vertices));
            match index {
                Some(index) if list.len() == 1 => Ok(Some(index)),
                Some(_) => Err(row_error(
                    name,
                    row,
                    "a cell holds at most one vertex".to_owned(),
                )),
                None => Err(row_error(
                    name,
                    row,
                    format!("it does not refer to one of the {vertices} vertices"),
                )),
            }
        };
        let cells = lists
            .iter()
            .enumerate()
            .map(cell)
            .collect::<Result<_, _>>()?;
        Ok(Self {
            columns,
            cells,
            sensor: None,
        })
    }

    /// The squares of neighboring cells, each counterclockwise if columns run right and rows up.
    fn squares(&self) -> impl Iterator<Item = [Option<u32>; 4]> {
        let rows = self.cells.chunks(self.columns.max(1));
        let above = rows.clone().skip(1);
        rows.zip(above).flat_map(|(low, high)| {
            low.windows(2)
                .zip(high.windows(2))
                .map(|(low, high)| [low[0], low[1], high[1], high[0]])
        })
    }

    fn median_step(&self, positions: &[Point3<f64>]) -> Option<f64> {
        let along = self
            .cells
            .chunks(self.columns.max(1))
            .flat_map(|row| row.windows(2));
        let pairs = along.map(|pair| (pair[0], pair[1])).chain(
            self.cells
                .iter()
                .copied()
                .zip(self.cells.iter().copied().skip(self.columns)),
        );
        let mut steps: Vec<f64> = pairs
            .filter_map(|(a, b)| Some((positions[a? as usize] - positions[b? as usize]).norm()))
            .collect();
        let middle = steps.len() / 2;
        (middle < steps.len()).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
    }

    /// The triangles, turned the way that they face.
    fn facing_triangles(&self, positions: &[Point3<f64>]) -> Vec<[u32; 3]> {
        let mut triangles = self.triangles(positions);
        let corners = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
        let backwards = if let Some(sensor) = self.sensor {
            let towards = |t: &[u32; 3]| {
                let [a, b, c] = corners(t);
                let middle = (a.coords + b.coords + c.coords) / 3.0;
                let view = (sensor.coords - middle).try_normalize(0.0);
                view.map_or(0.0, |view| triangle_normal([a, b, c]).dot(&view))
            };
            triangles.iter().map(towards).sum::<f64>() < 0.0
        } else {
            let sum: Vector3<f64> = triangles.iter().map(|t| triangle_normal(corners(t))).sum();
            sum[sum.iamax()] < 0.0
        };
        if backwards {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }
        triangles
    }

    fn triangles(&self, positions: &[Point3<f64>]) -> Vec<[u32; 3]> {
        let Some(step) = self.median_step(positions) else {
            return Vec::new();
        };
        let longest_sq = (LONGEST_EDGE * step).powi(2);
        let distance_sq =
            |a: u32, b: u32| (positions[a as usize] - positions[b as usize]).norm_squared();
        let short = |&[a, b, c]: &[u32; 3]| {
            distance_sq(a, b)
                .max(distance_sq(b, c))
                .max(distance_sq(c, a))
                <= longest_sq
                && a != b
                && b != c
                && c != a
        };
        let mut out = Vec::new();
        for square in self.squares() {
            match square {
                [Some(a), Some(b), Some(c), Some(d)] => {
                    let split = if distance_sq(a, c) <= distance_sq(b, d) {
                        [[a, b, c], [a, c, d]]
                    } else {
                        [[a, b, d], [b, c, d]]
                    };
                    out.extend(split.into_iter().filter(short));
                }
                _ => {
                    let mut corners = square.into_iter().flatten();
                    let three = [corners.next(), corners.next(), corners.next()];
                    if let [Some(a), Some(b), Some(c)] = three {
                        out.extend([[a, b, c]].into_iter().filter(short));
                    }
                }
            }
        }
        out
    }
}

/// The value behind a key in the `obj_info` lines.
fn info<'a>(lines: &'a [String], key: &str) -> Option<&'a str> {
    lines.iter().find_map(|line| {
        let mut words = line.split_whitespace();
        (words.next() == Some(key)).then(|| words.next()).flatten()
    })
}

fn row_error(name: &str, row: usize, reason: String) -> ScanError {
    ScanError::Row {
        name: name.to_owned(),
        element: RANGE_GRID.to_owned(),
        row,
        reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::check;

    /// A grid of `rows` strings, a digit being the height of a vertex and `.` none.
    fn scan(rows: &[&str]) -> Scan {
        let mut scan = Scan::default();
        let (mut x, mut y, mut z, mut cells) = (vec![], vec![], vec![], vec![]);
        for (r, row) in rows.iter().enumerate() {
            for (c, height) in row.chars().enumerate() {
                let index = i32::try_from(x.len()).unwrap();
                if let Some(height) = height.to_digit(10) {
                    x.push(c as f32);
                    y.push(r as f32);
                    z.push(height as f32 * 2.0);
                    cells.push(Column::I32(vec![index]));
                } else {
                    cells.push(Column::I32(vec![]));
                }
            }
        }
        scan.obj_info = vec![
            "is_mesh 0".to_owned(),
            format!("num_cols {}", rows[0].len()),
            format!("num_rows {}", rows.len()),
        ];
        scan.vertices.set_channel("x", Column::F32(x));
        scan.vertices.set_channel("y", Column::F32(y));
        scan.vertices.set_channel("z", Column::F32(z));
        let mut table = Table::default();
        table.set_channel("vertex_indices", Column::List(cells));
        scan.other_elements.push((RANGE_GRID.to_owned(), table));
        scan
    }

    fn faces(rows: &[&str]) -> usize {
        let mut scan = scan(rows);
        triangulate(&mut scan, Vec::new(), "a.ply").unwrap();
        assert_eq!(check(&scan.mesh()), Ok(()));
        scan.faces.len()
    }

    #[test]
    fn four_corners_give_two_triangles_and_three_give_one() {
        assert_eq!(faces(&["000", "000"]), 4);
        assert_eq!(faces(&[".00", "000"]), 3);
        assert_eq!(faces(&["0.0", "000"]), 2);
        assert_eq!(faces(&["0.0", ".0."]), 0);
        assert_eq!(faces(&["00.", "..0"]), 0);
        assert_eq!(faces(&["0000"]), 0);
        assert_eq!(faces(&["..", ".."]), 0);
    }

    #[test]
    fn depth_jumps_stay_open() {
        assert_eq!(faces(&["0009", "0000", "0000"]), 11);
        assert_eq!(faces(&["00099", "00099", "00099"]), 2 * 4 + 4);
        assert_eq!(faces(&["00011", "00011", "00011"]), 16);
    }

    #[test]
    fn triangles_face_the_viewer_whichever_way_the_grid_runs() {
        let rows = ["0000", "0100", "0.10"];
        let mirrored: Vec<String> = rows.iter().map(|r| r.chars().rev().collect()).collect();
        let mut mirrored = scan(&mirrored.iter().map(String::as_str).collect::<Vec<_>>());
        if let Some(x) = mirrored
            .vertices
            .channels
            .iter_mut()
            .find(|c| c.name == "x")
        {
            let Column::F32(values) = &mut x.values else {
                panic!()
            };
            values.iter_mut().for_each(|v| *v = -*v);
        }
        for mut scan in [scan(&rows), mirrored] {
            triangulate(&mut scan, Vec::new(), "a.ply").unwrap();
            let mesh = scan.mesh();
            assert_eq!(check(&mesh), Ok(()));
            for f in 0..mesh.triangles.len() {
                assert!(triangle_normal(mesh.corners(f)).z > 0.0);
            }
        }
    }

    #[test]
    fn faces_of_the_file_win_and_the_grid_is_kept() {
        let mut scan = scan(&["00", "00"]);
        scan.faces.push_row(&[0, 1, 2]);
        let before = scan.clone();
        triangulate(&mut scan, Vec::new(), "a.ply").unwrap();
        assert_eq!(scan, before);
    }

    #[test]
    fn contradictions_are_errors() {
        for (line, text) in [(1, "num_cols 3"), (1, "num_cols -2"), (2, "nothing")] {
            let mut scan = scan(&["00", "00"]);
            scan.obj_info[line] = text.to_owned();
            let error = triangulate(&mut scan, Vec::new(), "a.ply").unwrap_err();
            assert!(
                matches!(error, ScanError::GridSize { cells: 4, .. }),
                "{error}"
            );
        }
        for cell in [
            Column::I32(vec![-1]),
            Column::I32(vec![4]),
            Column::I32(vec![0, 1]),
            Column::F32(vec![0.5]),
        ] {
            let mut scan = scan(&["00", "00"]);
            let Column::List(cells) = &mut scan.other_elements[0].1.channels[0].values else {
                panic!()
            };
            cells[2] = cell;
            let error = triangulate(&mut scan, Vec::new(), "a.ply").unwrap_err();
            assert!(matches!(error, ScanError::Row { row: 2, .. }), "{error}");
        }
    }
}
