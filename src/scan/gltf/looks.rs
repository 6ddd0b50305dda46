//! What the faces of glTF primitives look like.

use crate::scan::paint::{Paint, Painted};
use crate::scan::texture::Textures;
use crate::scan::{Column, Scan};

/// Paints in the making, one a primitive, in the order of the vertices.
#[derive(Debug, Default)]
pub(super) struct Looks {
    paints: Vec<Paint>,
    /// Of each vertex.
    numbers: Vec<u32>,
    /// u and v of each vertex as in the file; NaN without an image.
    coordinates: [Vec<f64>; 2],
    pub(super) textures: Textures,
}

impl Looks {
    /// Adds the vertices of a primitive, and where they are on its image.
    pub(super) fn push(&mut self, paint: Paint, places: Option<Vec<[f64; 2]>>, count: usize) {
        let number = u32::try_from(self.paints.len()).unwrap_or(u32::MAX);
        self.paints.push(paint);
        self.numbers.extend(std::iter::repeat_n(number, count));
        let mut places = places.unwrap_or_default();
        places.resize(count, [f64::NAN; 2]);
        for (k, values) in self.coordinates.iter_mut().enumerate() {
            values.extend(places.iter().map(|place| place[k]));
        }
    }

    /// With the scan of these vertices. A face has the paint of its first one: those of a primitive are together.
    pub(super) fn of(self, scan: Scan) -> Painted {
        let number = |face: &[u32]| {
            let number = face.first().and_then(|v| self.numbers.get(*v as usize));
            number.copied().unwrap_or(u32::MAX)
        };
        let is_asked_for = !self.paints.is_empty();
        Painted {
            of_faces: (scan.faces.rows().filter(|_| is_asked_for))
                .map(number)
                .collect(),
            scan,
            coordinates: Some(self.coordinates.map(Column::F64)),
            paints: self.paints,
            textures: self.textures,
        }
    }
}
