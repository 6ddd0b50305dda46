//! Normals of an OBJ file that belong to its vertices.

use crate::scan::channel::Scalar;

/// The `vn` lines, and which of them the corners of faces take.
#[derive(Debug, Default)]
pub(super) struct Normals {
    lines: Vec<[f64; 3]>,
    /// Vertex and normal of each corner that names one.
    corners: Vec<(u32, u32)>,
    /// Whether a line was not three finite numbers.
    broken: bool,
}

impl Normals {
    pub(super) fn push<'a>(&mut self, tokens: impl Iterator<Item = &'a str>) {
        let values: Vec<f64> = tokens.map_while(f64::parse).collect();
        let normal = <[f64; 3]>::try_from(values.as_slice()).ok();
        let normal = normal.filter(|n| n.iter().all(|v| v.is_finite()));
        self.broken |= normal.is_none();
        self.lines.push(normal.unwrap_or_default());
    }

    pub(super) fn len(&self) -> usize {
        self.lines.len()
    }

    pub(super) fn push_corner(&mut self, vertex: u32, normal: Option<u32>) {
        self.corners.extend(normal.map(|normal| (vertex, normal)));
    }

    /// #V normals, if each vertex has exactly one; else they are dropped with a warning.
    ///
    /// Vertices without a face (all, in a file of points) take the normal of their own number, if the
    /// file has as many normals as vertices and no corner says otherwise.
    pub(super) fn of_vertices(&self, vertices: usize, name: &str) -> Option<Vec<[f64; 3]>> {
        if self.lines.is_empty() {
            return None;
        }
        let normals = self.unique(vertices).filter(|_| !self.broken);
        if normals.is_none() {
            log::warn!(
                "{name}: {} normals dropped, since not every vertex has exactly one",
                self.lines.len()
            );
        }
        normals
    }

    fn unique(&self, vertices: usize) -> Option<Vec<[f64; 3]>> {
        if self.lines.len() == vertices && self.corners.iter().all(|(v, normal)| v == normal) {
            return Some(self.lines.clone());
        }
        let mut normals = vec![None; vertices];
        for (vertex, normal) in &self.corners {
            let value = self.lines.get(*normal as usize)?;
            // Another index with the same value is the same normal.
            if normals
                .get_mut(*vertex as usize)?
                .replace(value)
                .is_some_and(|known| known.map(f64::to_bits) != value.map(f64::to_bits))
            {
                return None;
            }
        }
        normals.into_iter().map(|normal| normal.copied()).collect()
    }
}
