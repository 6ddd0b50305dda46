//! The levels of a scanned surface.

use rayon::prelude::*;

use crate::mesh::{PointTree, TriMesh};
use crate::rng::Rng;
use crate::texture::canvas::CanvasLevel;
use crate::texture::directions::directions;
use crate::texture::params::Orientation;
use crate::texture::retile::{Retiled, retile};
use crate::texture::sample::SampleSurface;

use super::PyramidLevel;

/// Fewer vertices than this hold no neighborhood.
const LEAST_VERTICES: usize = 16;

/// With up to `levels` levels; fewer if the coarsest would have too few vertices.
pub(super) fn of_surface(
    sample: &SampleSurface,
    channels: usize,
    levels: usize,
    rng: &mut Rng,
) -> Vec<PyramidLevel> {
    // A texel is as large as two triangles of the scan.
    let finest = sample.base.triangles.len() / 2;
    let counts: Vec<usize> = (0..levels)
        .map(|k| finest >> (2 * k))
        .take_while(|count| *count >= LEAST_VERTICES)
        .collect();
    let retiled = retile(&sample.base, &counts);
    let meshes: Vec<&TriMesh> = retiled.iter().map(|level| &level.mesh).collect();
    let along = Orientation::Along(sample.axis);
    let (directions, _) = directions(&meshes, &along, 1, rng);
    let Some(first) = retiled.first() else {
        return Vec::new();
    };
    let origins = origins(sample, first);
    let canvas: Vec<CanvasLevel> = (retiled.into_iter().zip(directions))
        .map(|(level, directions)| CanvasLevel::new(level, directions))
        .collect();
    let mut values = vec![taken(sample, channels, &origins)];
    let mut known = vec![
        origins
            .iter()
            .map(|v| sample.known[*v as usize])
            .collect::<Vec<_>>(),
    ];
    for k in 1..canvas.len() {
        let (v, is_known) = filtered(
            &canvas[k - 1],
            &values[k - 1],
            &known[k - 1],
            &canvas[k],
            channels,
        );
        values.push(v);
        known.push(is_known);
    }
    let on = |from: &CanvasLevel, to: Option<&CanvasLevel>| match to {
        Some(to) => to.locate(from.surface.positions(), &from.normals, &from.directions),
        None => vec![None; from.normals.len()],
    };
    let links: Vec<_> = (canvas.iter().enumerate())
        .map(|(k, level)| {
            let finer = k.checked_sub(1).map(|k| &canvas[k]);
            (on(level, canvas.get(k + 1)), on(level, finer))
        })
        .collect();
    let mut origins = Some(origins);
    (canvas.into_iter().zip(values).zip(known).zip(links))
        .map(|(((level, values), known), (above, below))| PyramidLevel {
            surface: level.surface,
            texel: level.texel,
            values,
            known,
            places: level.places,
            above,
            below,
            size: None,
            origins: origins.take().unwrap_or_default(),
        })
        .collect()
}

/// For each vertex of the retiled sample the nearest corner of the triangle it is on: values are copied, not mixed,
/// so that relief keeps its amplitude.
fn origins(sample: &SampleSurface, retiled: &Retiled) -> Vec<u32> {
    (retiled.places.iter())
        .map(|place| {
            let [a, b, c] = place.weights;
            let nearest = if a >= b && a >= c {
                0
            } else {
                1 + usize::from(c > b)
            };
            sample.base.triangles[place.triangle as usize][nearest]
        })
        .collect()
}

fn taken(sample: &SampleSurface, channels: usize, origins: &[u32]) -> Vec<f32> {
    (origins.iter())
        .flat_map(|v| &sample.values[*v as usize * channels..][..channels])
        .copied()
        .collect()
}

/// The values of a level on the next coarser one: Gaussian means, as wide as the binomials that images are filtered
/// with (a variance of one texel's square). A vertex is known if most of what it is the mean of is.
fn filtered(
    fine: &CanvasLevel,
    values: &[f32],
    known: &[bool],
    coarse: &CanvasLevel,
    channels: usize,
) -> (Vec<f32>, Vec<bool>) {
    let tree = PointTree::new(fine.surface.positions());
    let rows: Vec<(Vec<f32>, bool)> = (coarse.surface.positions().par_iter().zip(&coarse.normals))
        .map(|(point, normal)| {
            let mut near = tree.within(point, 2.5 * fine.texel);
            near.sort_unstable();
            let mut sums = vec![0.0; channels];
            let (mut total, mut of_known) = (0.0, 0.0);
            for v in near.into_iter().map(|v| v as usize) {
                if fine.normals[v].dot(normal) <= 0.0 {
                    continue;
                }
                let apart = (fine.surface.positions()[v] - point).norm() / fine.texel;
                let weight = (-0.5 * apart * apart).exp();
                total += weight;
                if known[v] {
                    of_known += weight;
                    for (sum, value) in sums.iter_mut().zip(&values[v * channels..]) {
                        *sum += weight * f64::from(*value);
                    }
                }
            }
            #[expect(clippy::cast_possible_truncation, reason = "values are single")]
            let row = sums
                .into_iter()
                .map(|s| (s / f64::max(of_known, f64::MIN_POSITIVE)) as f32);
            (row.collect(), of_known > 0.5 * total)
        })
        .collect();
    let (values, known): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
    (values.concat(), known)
}
