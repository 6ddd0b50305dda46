//! Primitives of glTF meshes, gathered into one scan.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Matrix4, Point3, Vector3};

use super::accessor::{self, Component, Numbers};
use super::buffers::{Buffers, compressed, is_compression};
use super::colors::Colors;
use super::json::{Document, Primitive};
use crate::scan::channel::Scalar;
use crate::scan::paint::Painted;
use crate::scan::source::Source;
use crate::scan::text::table_of_doubles;
use crate::scan::texture_coordinates::OF_VERTICES;
use crate::scan::{Column, Scan};

/// Vertices and corners that nodes may repeat beyond what the buffers hold. A scene can show one mesh
/// many times at no cost; a scan cannot.
const MOST_REPEATED: usize = 1 << 24;

/// A scan in the making.
pub(super) struct Builder<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    name: &'a str,
    scan: Scan,
    positions: Vec<[f64; 3]>,
    /// Whether all positions are `float` numbers of the file.
    untouched: bool,
    normals: Vec<[f64; 3]>,
    /// u, and v from the bottom; NaN for vertices without. Too short if the last ones have none.
    coordinates: Vec<[f64; 2]>,
    colors: Colors<'a>,
    /// Attributes of the application that all primitives have, by name.
    others: BTreeMap<String, (Component, Vec<f64>)>,
    room: usize,
    lines: usize,
}

/// What tells whether two primitives of a mesh share their vertices.
type Key<'a> = (&'a BTreeMap<String, usize>, Option<usize>);

impl<'a> Builder<'a> {
    pub(super) fn new(
        document: &'a Document,
        buffers: &'a Buffers<'a>,
        source: &'a Source<'a>,
        with_faces: bool,
    ) -> Self {
        Self {
            document,
            buffers,
            name: source.name,
            scan: Scan::default(),
            positions: Vec::new(),
            untouched: true,
            normals: Vec::new(),
            coordinates: Vec::new(),
            colors: Colors::new(document, buffers, source, with_faces),
            others: BTreeMap::new(),
            room: MOST_REPEATED.saturating_add(buffers.size()),
            lines: 0,
        }
    }

    /// Adds a mesh.
    pub(super) fn mesh(
        &mut self,
        primitives: &'a [Primitive],
        transform: &Matrix4<f64>,
    ) -> Result<(), String> {
        let mut known: BTreeMap<Key<'a>, (usize, usize)> = BTreeMap::new();
        for (number, primitive) in primitives.iter().enumerate() {
            let wrong = |reason: String| format!("primitive {number}: {reason}");
            self.refuse_compressed(primitive).map_err(wrong)?;
            let mode = primitive.mode.unwrap_or(4);
            if matches!(mode, 1..=3) {
                self.lines += 1;
                continue;
            }
            let key = (&primitive.attributes, self.colors.look(primitive));
            let vertices = match known.get(&key) {
                Some(vertices) => *vertices,
                None => self.vertices(primitive, transform).map_err(wrong)?,
            };
            known.insert(key, vertices);
            let mirrored = transform.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
            self.faces(primitive, mode, vertices, mirrored)
                .map_err(wrong)?;
        }
        Ok(())
    }

    /// Refuses a primitive that is there in compressed form only.
    fn refuse_compressed(&self, primitive: &Primitive) -> Result<(), String> {
        let compression = primitive.extensions.keys().find(|n| is_compression(n));
        let positions = primitive.attributes.get("POSITION");
        let positions = positions.and_then(|p| self.document.accessors.get(*p));
        match compression {
            Some(name) if positions.is_none_or(|p| p.buffer_view.is_none()) => {
                Err(compressed(name))
            }
            _ => Ok(()),
        }
    }

    /// Takes room for more vertices or corners.
    fn take_room(&mut self, count: usize) -> Result<(), String> {
        let left = self.room.checked_sub(count);
        self.room = left.ok_or("it claims more vertices than the file can hold, or the scene repeats its meshes too often")?;
        Ok(())
    }

    fn numbers(&mut self, accessor: usize, widths: &[usize]) -> Result<Numbers, String> {
        // Reading refuses counts that the buffers cannot have, so that what room is left for is real.
        let numbers = accessor::read(&self.document.accessors, accessor, self.buffers)?;
        self.take_room(numbers.len())?;
        if widths.contains(&numbers.width) {
            Ok(numbers)
        } else {
            let width = numbers.width;
            Err(format!(
                "accessor {accessor} has {width} numbers an element"
            ))
        }
    }

    /// Adds the vertices of a primitive; gives their first index and their number.
    fn vertices(
        &mut self,
        primitive: &Primitive,
        transform: &Matrix4<f64>,
    ) -> Result<(usize, usize), String> {
        let first = self.positions.len();
        let Some(accessor) = primitive.attributes.get("POSITION") else {
            return Err("it has no POSITION".to_owned());
        };
        let positions = self.numbers(*accessor, &[3])?;
        let count = positions.len();
        if *transform == Matrix4::identity() {
            self.untouched &= positions.component == Component::F32;
            self.positions.extend(positions.triples());
        } else {
            self.untouched = false;
            let moved = |p: [f64; 3]| <[f64; 3]>::from(transform.transform_point(&Point3::from(p)));
            self.positions.extend(positions.triples().map(moved));
        }
        for (name, accessor) in &primitive.attributes {
            let widths: &[usize] = match name.as_str() {
                "NORMAL" => &[3],
                "COLOR_0" => &[3, 4],
                name if name.starts_with("TEXCOORD_") => &[2],
                name if name.starts_with('_') => &[1, 2, 3, 4],
                _ => continue,
            };
            let numbers = self.numbers(*accessor, widths)?;
            if numbers.len() != count {
                let found = numbers.len();
                return Err(format!("it has {count} positions, but {found} of {name}"));
            }
            match name.as_str() {
                "NORMAL" if self.normals.len() == first => {
                    let turn = turn_of_normals(transform);
                    self.normals
                        .extend(numbers.triples().map(|n| turned(n, turn.as_ref())));
                }
                "COLOR_0" => self.colors.keep(&numbers),
                "TEXCOORD_0" => {
                    self.coordinates.resize(first, [f64::NAN; 2]);
                    let places = numbers.values.chunks_exact(2);
                    self.coordinates.extend(places.map(|c| [c[0], 1.0 - c[1]]));
                }
                _ if name.starts_with('_') && numbers.width == 1 => {
                    let channel = name.trim_start_matches('_').to_lowercase();
                    let (component, values) = self
                        .others
                        .entry(channel)
                        .or_insert((numbers.component, Vec::new()));
                    // One that lacks earlier vertices stays too short, and is dropped in the end.
                    if *component == numbers.component && values.len() == first {
                        values.extend(numbers.values);
                    }
                }
                _ => {}
            }
        }
        self.colors.paint(primitive, count)?;
        Ok((first, count))
    }

    fn faces(
        &mut self,
        primitive: &Primitive,
        mode: u32,
        (first, count): (usize, usize),
        mirrored: bool,
    ) -> Result<(), String> {
        if mode == 0 {
            return Ok(());
        }
        let corner = |index: f64| {
            let index = crate::scan::vertex_lists::exact_index(index, count);
            let index = index.ok_or_else(|| format!("an index exceeds its {count} vertices"))?;
            u32::try_from(first + index as usize).map_err(|_| "it has 2^32 vertices".to_owned())
        };
        let corners: Vec<u32> = if let Some(accessor) = primitive.indices {
            let indices = self.numbers(accessor, &[1])?;
            indices
                .values
                .into_iter()
                .map(corner)
                .collect::<Result<_, _>>()?
        } else {
            self.take_room(count)?;
            let last = u32::try_from(first + count).map_err(|_| "it has 2^32 vertices")?;
            (last - u32::try_from(count).unwrap_or(last)..last).collect()
        };
        let mut push = |[a, b, c]: [u32; 3]| {
            let face = if mirrored { [a, c, b] } else { [a, b, c] };
            self.scan.faces.push_row(&face);
        };
        match mode {
            4 => corners
                .chunks_exact(3)
                .for_each(|t| push([t[0], t[1], t[2]])),
            // Section 3.7.2.1; strips turn at a triangle with the same vertex twice.
            5 => corners.windows(3).enumerate().for_each(|(k, t)| {
                if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                    push([t[0], t[1 + k % 2], t[2 - k % 2]]);
                }
            }),
            6 => corners
                .windows(2)
                .skip(1)
                .for_each(|t| push([t[0], t[1], corners[0]])),
            _ => return Err(format!("there is no mode {mode}")),
        }
        Ok(())
    }

    pub(super) fn finish(self) -> Painted {
        let Self { mut scan, name, .. } = self;
        let rows = self.positions.len();
        let table = &mut scan.vertices;
        *table = table_of_doubles(["x", "y", "z"], &self.positions);
        if self.untouched {
            for channel in &mut table.channels {
                if let Column::F64(values) = &channel.values {
                    channel.values = floats(values);
                }
            }
        }
        if self.normals.len() == rows && rows > 0 {
            let normals = table_of_doubles(["nx", "ny", "nz"], &self.normals);
            for channel in normals.channels {
                if let Column::F64(values) = &channel.values {
                    table.set_channel(&channel.name, floats(values));
                }
            }
        } else if !self.normals.is_empty() {
            log::warn!("{name}: normals dropped, since only some meshes have them");
        }
        if !self.coordinates.is_empty() {
            let mut coordinates = self.coordinates;
            coordinates.resize(rows, [f64::NAN; 2]);
            for (k, channel) in OF_VERTICES[0].into_iter().enumerate() {
                let values: Vec<f64> = coordinates.iter().map(|c| c[k]).collect();
                table.set_channel(channel, floats(&values));
            }
        }
        let looks = self.colors.finish(table, name);
        for (channel, (component, values)) in self.others {
            if values.len() != rows || table.channel(&channel).is_some() || channel.is_empty() {
                log::warn!("{name}: `_{channel}` dropped, since not all meshes have it alike");
                continue;
            }
            let column = match component {
                Component::U8 => Column::U8(values.into_iter().map(Scalar::rounded).collect()),
                Component::U16 => Column::U16(values.into_iter().map(Scalar::rounded).collect()),
                _ => floats(&values),
            };
            table.set_channel(&channel, column);
        }
        if self.lines > 0 {
            log::warn!("{name}: {} primitives of lines dropped", self.lines);
        }
        looks.of(scan)
    }
}

fn floats(values: &[f64]) -> Column {
    Column::F32(values.iter().map(|v| Scalar::rounded(*v)).collect())
}

/// The inverse transpose, up to a positive factor: that of the cofactors, which always exists.
fn turn_of_normals(transform: &Matrix4<f64>) -> Option<Matrix3<f64>> {
    if *transform == Matrix4::identity() {
        return None;
    }
    let linear: Matrix3<f64> = transform.fixed_view::<3, 3>(0, 0).into();
    let [a, b, c] = [0, 1, 2].map(|k| linear.column(k).into_owned());
    let cofactors = Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)]);
    Some(cofactors * linear.determinant().signum())
}

fn turned(normal: [f64; 3], turn: Option<&Matrix3<f64>>) -> [f64; 3] {
    let Some(turn) = turn else { return normal };
    let normal = turn * Vector3::from(normal);
    normal.try_normalize(0.0).unwrap_or_default().into()
}
