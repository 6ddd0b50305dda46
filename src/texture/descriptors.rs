//! Neighborhoods as rows of numbers, of the sample and of the mesh in the same way.

use rayon::prelude::*;

use crate::neighborhood::Spots;

/// What neighborhoods are read from: a level, and the next coarser one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reader<'a> {
    pub(super) coarse: Option<Layer<'a>>,
    pub(super) own: Layer<'a>,
    /// What stands where nothing is known (C).
    pub(super) unknown: &'a [f32],
}

/// Values on a surface, and where they are looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layer<'a> {
    pub(super) spots: &'a Spots,
    /// #V by C.
    pub(super) values: &'a [f32],
}

/// Which part of a neighborhood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// What is on the coarser level.
    Coarse,
    /// All of it.
    Whole,
}

impl Reader<'_> {
    /// Number of values of a neighborhood.
    pub(super) fn width(&self, part: Part) -> usize {
        let channels = self.unknown.len();
        let coarse = self.coarse.map_or(0, |layer| layer.spots.offsets());
        match part {
            Part::Coarse => coarse * channels,
            Part::Whole => (coarse + self.own.spots.offsets()) * channels,
        }
    }

    /// Reads the part of a neighborhood that is on its own level.
    pub(super) fn read_own(&self, vertex: usize, out: &mut [f32]) {
        self.own.read(vertex, self.unknown, out);
    }

    /// Reads the neighborhood of a vertex: the coarser level's values first.
    pub(super) fn read(&self, vertex: usize, part: Part, out: &mut [f32]) {
        let (coarse, own) = out.split_at_mut(self.width(Part::Coarse));
        if let Some(layer) = self.coarse {
            layer.read(vertex, self.unknown, coarse);
        }
        if part == Part::Whole {
            self.own.read(vertex, self.unknown, own);
        }
    }

    /// The neighborhoods of some vertices, row by row.
    pub(super) fn rows(&self, vertices: &[u32], part: Part) -> Vec<f32> {
        let width = self.width(part);
        let mut rows = vec![0.0; vertices.len() * width];
        (rows.par_chunks_mut(width).zip(vertices))
            .for_each(|(row, v)| self.read(*v as usize, part, row));
        rows
    }
}

impl Layer<'_> {
    fn read(&self, vertex: usize, unknown: &[f32], out: &mut [f32]) {
        self.spots.read(vertex, self.values, unknown, out);
    }
}
