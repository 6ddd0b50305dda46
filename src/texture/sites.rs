//! The sample's side of a level: what can be copied, and the neighborhoods there.

use rayon::prelude::*;

use crate::neighborhood::{Spots, Stencil};

use super::descriptors::{Layer, Part, Reader};
use super::level::Window;
use super::pyramid::PyramidLevel;

/// How sharp the mesh's neighborhoods are ([`Spots::sharpness`]): the sample's are made as blurred before they are
/// compared, since a mesh that is read between its vertices would otherwise look like the sample's smooth places.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sharpness {
    pub(super) own: f64,
    pub(super) coarse: Option<f64>,
}

/// No site.
pub(super) const NONE: u32 = u32::MAX;

/// The vertices of a level whose whole neighborhoods are known.
#[derive(Debug)]
pub(super) struct Sites<'a> {
    pub(super) level: &'a PyramidLevel,
    pub(super) vertices: Vec<u32>,
    /// By vertex the number of its site, [`NONE`] of others.
    pub(super) numbers: Vec<u32>,
    /// Sites by [`Self::width`].
    pub(super) rows: Vec<f32>,
    pub(super) width: usize,
    /// Values of a row that are of the coarser level; they come first.
    pub(super) coarse_width: usize,
    /// The mean color and height (C).
    pub(super) mean: Vec<f32>,
}

/// Where the offsets of a window lie, for every vertex of a sample's level.
fn looks(
    level: &PyramidLevel,
    above: Option<&PyramidLevel>,
    window: &Window,
    vertices: &[usize],
) -> (Spots, Option<Spots>) {
    let places = |all: &[Option<_>]| vertices.iter().map(|v| all[*v]).collect::<Vec<_>>();
    let own = Stencil::square(window.own, level.texel);
    let coarse = window.coarse.zip(above).map(|(radius, above)| {
        let stencil = Stencil::square(radius, above.texel);
        Spots::walked(&above.surface, &stencil, &places(&level.above))
    });
    (
        Spots::walked(&level.surface, &own, &places(&level.places)),
        coarse,
    )
}

/// Whether all that a neighborhood is read from is known.
fn is_known(
    level: &PyramidLevel,
    above: Option<&PyramidLevel>,
    (own, coarse): &(Spots, Option<Spots>),
    i: usize,
) -> bool {
    let known =
        |level: &PyramidLevel, spots: &Spots| spots.all_known(i, |v| level.known[v as usize]);
    known(level, own)
        && coarse
            .as_ref()
            .zip(above)
            .is_none_or(|(c, above)| known(above, c))
}

/// Whether a level has any site at all.
pub(super) fn has_sites(
    level: &PyramidLevel,
    above: Option<&PyramidLevel>,
    window: &Window,
) -> bool {
    /// Vertices that are looked at together: most levels have a site among the first few thousand.
    const SOME: usize = 2048;
    let all: Vec<usize> = (0..level.known.len()).collect();
    all.chunks(SOME).any(|some| {
        let looks = looks(level, above, window, some);
        (0..some.len()).any(|i| is_known(level, above, &looks, i))
    })
}

impl<'a> Sites<'a> {
    pub(super) fn new(
        level: &'a PyramidLevel,
        above: Option<&'a PyramidLevel>,
        window: &Window,
        channels: usize,
        sharpness: Option<Sharpness>,
    ) -> Self {
        let count = u32::try_from(level.known.len()).expect("vertices are u32");
        let all: Vec<usize> = (0..level.known.len()).collect();
        let looks = looks(level, above, window, &all);
        let vertices: Vec<u32> = (0..count)
            .into_par_iter()
            .filter(|v| is_known(level, above, &looks, *v as usize))
            .collect();
        let mut numbers = vec![NONE; level.known.len()];
        for (site, v) in (0..).zip(&vertices) {
            numbers[*v as usize] = site;
        }
        let mean = mean(level, channels);
        let (own, coarse) = &looks;
        let seen = |level: &PyramidLevel, spots: &Spots, sharpness: Option<f64>| match sharpness {
            Some(sharpness) => level.blurred(sharpness / spots.sharpness(), channels),
            None => level.values.clone(),
        };
        let own_values = seen(level, own, sharpness.map(|s| s.own));
        let coarse = coarse.as_ref().zip(above);
        let coarse_values = coarse.map(|(spots, above)| {
            seen(
                above,
                spots,
                sharpness.and_then(|sharpness| sharpness.coarse),
            )
        });
        let reader = Reader {
            coarse: coarse
                .zip(coarse_values.as_deref())
                .map(|((spots, _), values)| Layer { spots, values }),
            own: Layer {
                spots: own,
                values: &own_values,
            },
            unknown: &mean,
        };
        let rows = reader.rows(&vertices, Part::Whole);
        let (width, coarse_width) = (reader.width(Part::Whole), reader.width(Part::Coarse));
        Self {
            level,
            vertices,
            numbers,
            rows,
            width,
            coarse_width,
            mean,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// The rows' values of the coarser level only.
    pub(super) fn coarse_rows(&self) -> Vec<f32> {
        (self.rows.chunks_exact(self.width))
            .flat_map(|row| &row[..self.coarse_width])
            .copied()
            .collect()
    }

    pub(super) fn row(&self, site: u32) -> &[f32] {
        &self.rows[site as usize * self.width..][..self.width]
    }

    /// The values of a vertex of the sample.
    pub(super) fn values(&self, vertex: u32) -> &[f32] {
        let channels = self.mean.len();
        &self.level.values[vertex as usize * channels..][..channels]
    }
}

/// The means of the values that are known.
fn mean(level: &PyramidLevel, channels: usize) -> Vec<f32> {
    let mut sums = vec![0f64; channels];
    let mut count = 0.0;
    let rows = level.values.chunks_exact(channels).zip(&level.known);
    for (values, _) in rows.filter(|(_, known)| **known) {
        count += 1.0;
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += f64::from(*value);
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "values are single")]
    let mean = sums.iter().map(|sum| (sum / f64::max(count, 1.0)) as f32);
    mean.collect()
}
