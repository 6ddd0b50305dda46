//! Completion only appends.

use nalgebra::{Point3, Vector3};

use super::Scan;
use super::color::ColorLayout;

/// What completion adds to a scan.
#[derive(Debug, Clone, Copy, Default)]
pub struct Added<'a> {
    /// One point an added vertex.
    pub positions: &'a [Point3<f64>],
    /// Intensities from 0 to 1, one an added vertex; `None`: as the source.
    pub colors: Option<&'a [[f64; 3]]>,
    /// Unit normals, one an added vertex; `None`: as the source.
    pub normals: Option<&'a [Vector3<f64>]>,
    /// For each added vertex, the row of the original vertex that it takes all other channels from.
    pub sources: &'a [u32],
    /// Triangles of original and added vertices; the first added vertex has the index that follows
    /// the last original one.
    pub triangles: &'a [[u32; 3]],
}

impl Scan {
    /// Appends vertices and triangles; what is there already stays as it is, bit for bit.
    ///
    /// Coordinates, colours and normals (`nx`, `ny`, `nz`) are rounded to the type of their channel;
    /// colours are clamped to its range. Channels that the scan does not have are not made. Every
    /// other channel of a vertex is copied from its source; every channel of a face is 0, or the empty
    /// list.
    ///
    /// # Panics
    /// If the slices have not one entry an added vertex, a source is not a row of the table, or a
    /// triangle refers to a vertex that is neither original nor added.
    pub fn append(&mut self, added: &Added<'_>) {
        let originals = self.vertices.rows;
        let count = added.positions.len();
        assert_eq!(added.sources.len(), count, "one source an added vertex");
        assert!(
            added.colors.is_none_or(|c| c.len() == count),
            "one colour an added vertex"
        );
        assert!(
            added.normals.is_none_or(|n| n.len() == count),
            "one normal an added vertex"
        );
        let exists = |v: &u32, limit: usize| (*v as usize) < limit;
        assert!(
            added.sources.iter().all(|s| exists(s, originals)),
            "sources are original vertices"
        );
        let all = originals + count;
        assert!(
            added.triangles.iter().flatten().all(|v| exists(v, all)),
            "triangles refer to original or added vertices"
        );

        let mut given: Vec<Option<Given>> = vec![None; self.vertices.channels.len()];
        if let Some([x, y, z]) = self.vertices.triple(["x", "y", "z"]) {
            for (k, channel) in [x, y, z].into_iter().enumerate() {
                given[channel] = Some(Given::Position(k));
            }
        }
        if let (Some(normals), Some(channels)) =
            (added.normals, self.vertices.triple(["nx", "ny", "nz"]))
        {
            for (k, channel) in channels.into_iter().enumerate() {
                given[channel] = Some(Given::Normal(normals, k));
            }
        }
        if let (Some(colors), Some(layout)) = (added.colors, ColorLayout::of(&self.vertices)) {
            for (k, channel) in layout.channels.into_iter().enumerate() {
                given[channel] = Some(Given::Color(colors, k, layout.full));
            }
        }
        for (channel, given) in self.vertices.channels.iter_mut().zip(given) {
            let column = &mut channel.values;
            column.reserve(count);
            for (row, source) in added.sources.iter().enumerate() {
                match given {
                    Some(Given::Position(k)) => column.push_rounded(added.positions[row][k]),
                    Some(Given::Normal(normals, k)) => column.push_rounded(normals[row][k]),
                    Some(Given::Color(colors, k, full)) => {
                        column.push_rounded(colors[row][k].clamp(0.0, 1.0) * full);
                    }
                    None => column.push_copy(*source as usize),
                }
            }
        }
        self.vertices.rows = all;
        self.append_faces(added.triangles);
    }

    fn append_faces(&mut self, triangles: &[[u32; 3]]) {
        for triangle in triangles {
            self.faces.push_row(triangle);
        }
        for channel in &mut self.face_channels.channels {
            channel.values.reserve(triangles.len());
            for _ in triangles {
                channel.values.push_rounded(0.0);
            }
        }
        if !self.face_channels.channels.is_empty() {
            self.face_channels.rows = self.faces.len();
        }
    }
}

/// Where the values of a channel come from, if not from the source.
#[derive(Clone, Copy)]
enum Given<'a> {
    Position(usize),
    Normal(&'a [Vector3<f64>], usize),
    /// Colours, the one of the three, and the value of full intensity.
    Color(&'a [[f64; 3]], usize, f64),
}

#[cfg(test)]
mod tests {
    use super::super::{Column, Table};
    use super::*;

    fn scan() -> Scan {
        let mut vertices = Table::default();
        vertices.set_channel(
            "quality",
            Column::F32(vec![f32::from_bits(0x7fc0_1234), 2.0, 3.0]),
        );
        for axis in ["x", "y", "z"] {
            vertices.set_channel(axis, Column::F32(vec![0.1, 1.0, 2.0]));
        }
        vertices.set_channel("nx", Column::F64(vec![1.0; 3]));
        vertices.set_channel("ny", Column::F64(vec![0.0; 3]));
        vertices.set_channel("nz", Column::F64(vec![0.0; 3]));
        for (k, name) in ["red", "green", "blue", "alpha"].into_iter().enumerate() {
            let k = u8::try_from(k).unwrap();
            vertices.set_channel(name, Column::U8(vec![k, k + 10, k + 20]));
        }
        let tags = [7, 8, 9].map(|v| Column::U16(vec![v, v]));
        vertices.set_channel("tags", Column::List(tags.to_vec()));
        let mut scan = Scan {
            vertices,
            ..Scan::default()
        };
        scan.faces.push_row(&[0, 1, 2]);
        scan.face_channels
            .set_channel("flags", Column::I32(vec![-5]));
        scan.face_channels
            .set_channel("uv", Column::List(vec![Column::F32(vec![0.5])]));
        scan
    }

    /// A row as text: NaN is not equal to itself.
    fn rows(table: &Table, count: usize) -> Vec<String> {
        let row = |row: usize| {
            let values = table.channels.iter().map(|c| match &c.values {
                Column::F32(v) => format!("{:x}", v[row].to_bits()),
                Column::List(lists) => format!("{:?}", lists[row]),
                other => format!("{:?}", other.get_f64(row)),
            });
            values.collect::<Vec<_>>().join(" ")
        };
        (0..count).map(row).collect()
    }

    #[test]
    fn originals_stay_and_the_rest_is_given_or_copied() {
        let before = scan();
        let mut after = before.clone();
        after.append(&Added {
            positions: &[Point3::new(0.1, 0.2, 0.3), Point3::new(1.0, 2.0, 3.0)],
            colors: Some(&[[0.5, -1.0, 2.0], [0.0, 0.0, 1.0]]),
            normals: Some(&[Vector3::z(), Vector3::y()]),
            sources: &[0, 2],
            triangles: &[[0, 1, 3], [1, 3, 4]],
        });
        assert_eq!(rows(&before.vertices, 3), rows(&after.vertices, 3));
        assert_eq!(after.check("a.ply").map_err(|e| e.to_string()), Ok(()));
        let Some(Column::F32(quality)) = after.vertices.column("quality") else {
            panic!()
        };
        assert_eq!(quality[3].to_bits(), 0x7fc0_1234);
        let value = |name: &str, row| after.vertices.column(name).unwrap().get_f64(row);
        assert_eq!(value("y", 3), Some(f64::from(0.2f32)));
        assert_eq!(value("nz", 3), Some(1.0));
        assert_eq!(
            [value("red", 3), value("green", 3), value("blue", 3)],
            [128.0, 0.0, 255.0].map(Some)
        );
        assert_eq!(value("alpha", 4), Some(23.0));
        let Some(Column::List(tags)) = after.vertices.column("tags") else {
            panic!()
        };
        assert_eq!(tags[4], Column::U16(vec![9, 9]));
        assert_eq!(after.faces.row(2), [1, 3, 4]);
        assert_eq!(
            after.face_channels.column("flags"),
            Some(&Column::I32(vec![-5, 0, 0]))
        );
        let Some(Column::List(uv)) = after.face_channels.column("uv") else {
            panic!()
        };
        assert_eq!(uv[1..], [Column::F32(vec![]), Column::F32(vec![])]);
    }

    #[test]
    fn without_colors_and_normals_the_source_is_copied() {
        let mut scan = scan();
        scan.append(&Added {
            positions: &[Point3::origin()],
            sources: &[1],
            ..Added::default()
        });
        assert_eq!(scan.vertices.column("red").unwrap().get_f64(3), Some(10.0));
        assert_eq!(scan.vertices.column("nx").unwrap().get_f64(3), Some(1.0));
    }

    #[test]
    fn colors_come_back_as_they_were_given() {
        for column in [
            Column::U16(vec![0, 1, 2]),
            Column::F32(vec![0.0, 0.5, 1.0]),
            Column::F64(vec![0.0, 99.0, 255.0]),
        ] {
            let mut scan = scan();
            for name in ["red", "green", "blue"] {
                scan.vertices.set_channel(name, column.clone());
            }
            scan.append(&Added {
                positions: &[Point3::origin()],
                colors: Some(&[[0.25, 0.5, 1.0]]),
                sources: &[1],
                ..Added::default()
            });
            let color = scan.colors().unwrap()[3];
            for (given, back) in [0.25, 0.5, 1.0].into_iter().zip(color) {
                assert!((given - back).abs() < 1e-4, "{column:?}: {color:?}");
            }
        }
    }
}
