//! How far relief is like itself: read once, at a few places, before anything is copied.

use nalgebra::Vector3;

use crate::likeness::lightness;
use crate::neighborhood::{Among, Channels, Descriptor, Frame, Stencil, Surface, View, Walker};
use crate::rng::Rng;

/// Random places at which heights and colours are taken …
const PLACES: usize = 2000;
/// … and those of them around which the relief is read: the standard error of an autocorrelation is then
/// about 0.05.
const CENTERS: usize = 400;
/// The relief is read this far around a place, in steps.
const REACH: usize = 32;
/// Directions that are looked in, evenly around; opposite ones tell the same. One of them is within 7.5° of
/// any direction in which the relief repeats itself: with half as many, crossed waves were seen along
/// their diagonal only.
const SPOKES: usize = 24;
const DIRECTIONS: usize = SPOKES / 2;
/// Where the autocorrelation counts as gone.
const GONE: f64 = 0.2;
/// Beyond that it must rise again to so much where the relief is periodic: that of random waves of all
/// directions and one length rises to 0.3, of a band of lengths to less.
const PERIODIC: f64 = 0.35;
/// A correlation is told from as many differences.
const LEAST_COUNT: u32 = 50;

/// Relief with its colours, and where it can be read.
pub(super) struct Readable<'a> {
    /// The base surface, relief and gaps.
    pub(super) surface: &'a Surface,
    /// By vertex: tangents, the directions in which the relief is read.
    pub(super) frames: &'a [Frame],
    /// By vertex, in the scan's unit.
    pub(super) heights: &'a [f64],
    /// By vertex, in [0, 1].
    pub(super) colors: Option<&'a [[f64; 3]]>,
    /// By vertex: whether it can be copied from.
    pub(super) samples: &'a [bool],
    /// The scan's median edge, in its unit.
    pub(super) step: f64,
}

/// Figures of how relief is like itself at a distance. Lengths are in steps (median edges).
///
/// # Reference
/// ISO 25178-2:2021, 4.3: autocorrelation length Sal and texture aspect ratio Str.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Correlation {
    /// Shortest distance, over all directions, at which the autocorrelation falls to 0.2; at most
    /// [`REACH`].
    pub(super) length: f64,
    /// The same over the longest: 1 for relief that looks alike in all directions.
    pub(super) aspect: f64,
    /// Shortest distance at which the relief repeats itself, where it does.
    pub(super) period: Option<f64>,
    /// Variance of the heights as a share of their squared range.
    pub(super) height_variance: f64,
    /// Mean variance of the colours' channels, where there are colours.
    pub(super) color_variance: Option<f64>,
    /// Correlation of height and lightness, where both vary.
    pub(super) height_lightness: Option<f64>,
}

/// Reads the relief at random places; `None` without relief: flat, or no place to read.
pub(super) fn correlation(relief: &Readable, rng: &mut Rng) -> Option<Correlation> {
    let places = places(relief.samples, rng);
    let heights = places.iter().map(|v| relief.heights[*v as usize]);
    let [_, variance] = moments(heights.clone());
    let [low, high] = (relief.heights.iter().zip(relief.samples))
        .filter(|(_, is_sample)| **is_sample)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (h, _)| {
            [low.min(*h), high.max(*h)]
        });
    let range = high - low;
    if !(variance > 0.0 && range > 0.0) {
        return None;
    }
    let along = autocorrelations(relief, &places, variance);
    let lengths = along.iter().map(|along| correlation_length(along));
    let length = lengths.clone().fold(f64::INFINITY, f64::min);
    let longest = lengths.fold(0.0, f64::max);
    let of_places = (relief.colors)
        .map(|colors| (places.iter().map(|v| colors[*v as usize])).collect::<Vec<_>>());
    Some(Correlation {
        length,
        aspect: length / longest,
        period: (along.iter().filter_map(|along| period(along))).reduce(f64::min),
        height_variance: variance / (range * range),
        color_variance: (of_places.as_ref()).map(|colors| {
            let of_channel = |c: usize| moments(colors.iter().map(move |color| color[c]))[1];
            (0..3).map(of_channel).sum::<f64>() / 3.0
        }),
        height_lightness: (of_places.as_ref()).and_then(|colors| {
            let heights: Vec<f64> = heights.collect();
            let lightness: Vec<f64> = colors.iter().map(|color| lightness(*color)).collect();
            coefficient(&heights, &lightness)
        }),
    })
}

/// Random samples, no two the same.
fn places(samples: &[bool], rng: &mut Rng) -> Vec<u32> {
    let mut left: Vec<u32> = (0u32..)
        .zip(samples)
        .filter_map(|(v, is_sample)| is_sample.then_some(v))
        .collect();
    (0..PLACES.min(left.len()))
        .map(|_| left.swap_remove(rng.index(left.len())))
        .collect()
}

/// By direction: the autocorrelation at 0, 1, … steps, 1 − γ/(2 Sq²) with the variogram γ; NaN where
/// too little is known.
fn autocorrelations(relief: &Readable, places: &[u32], variance: f64) -> Vec<Vec<f64>> {
    let mut channels = Channels::new(relief.heights.len(), 1);
    #[expect(clippy::cast_possible_truncation, reason = "channels are single")]
    for (v, _) in relief.samples.iter().enumerate().filter(|(_, is)| **is) {
        channels.set(v, &[relief.heights[v] as f32], &[Among::Samples]);
    }
    let stencil = Stencil::fan(REACH, SPOKES, relief.step);
    let view = View {
        surface: relief.surface,
        channels: &channels,
        stencil: &stencil,
        among: Among::Samples,
    };
    let mut sums = vec![[(0.0, 0u32); REACH]; DIRECTIONS];
    let mut walker = Walker::default();
    let mut around = Descriptor::new(stencil.len(), 1);
    for v in places.iter().take(CENTERS) {
        let axis: &Vector3<f64> = &relief.frames[*v as usize].axes[0];
        let Some(place) = relief.surface.at_vertex(*v, axis) else {
            continue;
        };
        walker.gather(&view, &place, stencil.len(), &mut around);
        let own = f64::from(around.values[0]);
        for j in around.known.iter().filter(|j| *j > 0) {
            let (ring, spoke) = ((j - 1) / SPOKES, (j - 1) % SPOKES);
            let (sum, count) = &mut sums[spoke % DIRECTIONS][ring];
            *sum += (f64::from(around.values[j]) - own).powi(2);
            *count += 1;
        }
    }
    let at_lag = |(sum, count): &(f64, u32)| match *count {
        LEAST_COUNT.. => 1.0 - sum / (2.0 * variance * f64::from(*count)),
        _ => f64::NAN,
    };
    (sums.iter())
        .map(|along| {
            std::iter::once(1.0)
                .chain(along.iter().map(at_lag))
                .collect()
        })
        .collect()
}

/// Where the autocorrelation falls to [`GONE`], linearly between steps; its end where it does not.
fn correlation_length(along: &[f64]) -> f64 {
    let fall = along.windows(2).position(|pair| pair[1] <= GONE);
    fall.map_or((along.len() - 1) as f64, |lag| {
        lag as f64 + (along[lag] - GONE) / (along[lag] - along[lag + 1])
    })
}

/// Where the autocorrelation has its first clear peak after it was gone, by a parabola through three steps.
fn period(along: &[f64]) -> Option<f64> {
    let gone = along.iter().position(|rho| *rho <= GONE)?;
    let peak = (gone + 1..along.len() - 1).find(|lag| {
        along[*lag] >= PERIODIC && along[*lag] >= along[lag - 1] && along[*lag] > along[lag + 1]
    })?;
    let [before, at, after] = [along[peak - 1], along[peak], along[peak + 1]];
    let bend = before - 2.0 * at + after;
    Some(peak as f64 + 0.5 * (before - after) / bend)
}

/// Mean and variance.
fn moments(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    [
        mean,
        values.map(|x| (x - mean).powi(2)).sum::<f64>() / count,
    ]
}

/// Pearson's correlation coefficient; `None` where one of the two does not vary.
fn coefficient(a: &[f64], b: &[f64]) -> Option<f64> {
    let [(mean_a, var_a), (mean_b, var_b)] = [a, b].map(|x| {
        let [mean, variance] = moments(x.iter().copied());
        (mean, variance)
    });
    let products = (a.iter().zip(b)).map(|(a, b)| (a - mean_a) * (b - mean_b));
    let scale = (var_a * var_b).sqrt() * a.len() as f64;
    (scale > 0.0).then(|| products.sum::<f64>() / scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;
    use crate::neighborhood::local_frames;
    use crate::relief;
    use crate::rng::Stage;
    use crate::sampling::{SpacingRule, edge_spacing};
    use crate::synth::{self, Kind, Part, SynthParams};
    use approx::assert_relative_eq;
    use std::f64::consts::TAU;

    /// Of a synthetic object, read in frames that are turned by an angle; and the step.
    fn measured(kind: Kind, angle: f64) -> (Correlation, f64) {
        let made = synth::scan(&SynthParams {
            kind,
            vertices: 10_000,
            part: Part::FULL,
            noise: 0.0,
            seed: 1,
        })
        .unwrap();
        let mesh = made.scan.mesh();
        let step = edge_spacing(&mesh, SpacingRule::Scan).unwrap().median;
        let relief = relief::extract(&mesh, &made.base);
        let mut frames = local_frames(&made.base, &relief.normals);
        for frame in &mut frames {
            let [x, y, n] = frame.axes;
            let x = x * angle.cos() + y * angle.sin();
            frame.axes = [x, n.cross(&x), n];
        }
        let surface = Surface::new(TriMesh {
            positions: relief.feet.clone(),
            triangles: mesh.triangles,
        });
        let colors = made.scan.colors();
        let readable = Readable {
            surface: &surface,
            frames: &frames,
            heights: &relief.heights,
            colors: colors.as_deref(),
            samples: &vec![true; relief.heights.len()],
            step,
        };
        let found = correlation(&readable, &mut Rng::new(0, Stage::Suiting, 0));
        (found.unwrap(), step)
    }

    #[test]
    fn the_period_of_waves_is_found_in_any_direction() {
        for angle in [0.0, 0.13, 0.3, 0.7] {
            let (found, step) = measured(Kind::Waves, angle);
            // Their wavelength is 12.5 mm.
            assert_relative_eq!(found.period.unwrap() * step, 12.5, max_relative = 0.2);
            assert!(found.aspect > 0.5, "{found:?}");
        }
    }

    #[test]
    fn ridges_are_told_from_relief_that_looks_alike_all_around() {
        for (kind, is_ridged) in [
            (Kind::Bark, true),
            (Kind::Bricks, true),
            (Kind::Column, true),
            (Kind::Noise, false),
            (Kind::GolfBall, false),
        ] {
            let (found, _) = measured(kind, 0.0);
            assert_eq!(found.aspect < 0.5, is_ridged, "{kind}: {found:?}");
        }
    }

    #[test]
    fn random_relief_has_no_period_and_dark_grooves_are_correlated_with_depth() {
        assert_eq!(measured(Kind::Noise, 0.0).0.period, None);
        let (bark, _) = measured(Kind::Bark, 0.0);
        assert_eq!(bark.period, None);
        assert!(bark.height_lightness.unwrap() > 0.8, "{bark:?}");
        assert!(bark.color_variance.unwrap() > 0.0);
    }

    #[test]
    fn without_relief_nothing_is_measured() {
        let mesh = TriMesh {
            positions: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
                .map(|[x, y]| nalgebra::Point3::new(x, y, 0.0))
                .to_vec(),
            triangles: vec![[0, 1, 2]],
        };
        let frame = Frame {
            axes: [Vector3::x(), Vector3::y(), Vector3::z()],
        };
        let surface = Surface::new(mesh);
        for samples in [[true; 3], [false; 3]] {
            let flat = Readable {
                surface: &surface,
                frames: &[frame; 3],
                heights: &[0.5; 3],
                colors: None,
                samples: &samples,
                step: 1.0,
            };
            assert_eq!(
                correlation(&flat, &mut Rng::new(0, Stage::Suiting, 0)),
                None
            );
        }
    }

    #[test]
    fn the_period_is_that_of_a_wave_and_the_length_a_part_of_it() {
        let wave: Vec<f64> = (0..=32u32)
            .map(|lag| (TAU * f64::from(lag) / 9.3).cos())
            .collect();
        assert_relative_eq!(period(&wave).unwrap(), 9.3, epsilon = 0.1);
        // cos reaches 0.2 after 0.218 of a wave.
        assert_relative_eq!(correlation_length(&wave), 2.03, epsilon = 0.05);
    }

    #[test]
    fn what_only_falls_has_no_period() {
        let falling: Vec<f64> = (0..=32u32)
            .map(|lag| (-f64::from(lag) / 5.0).exp())
            .collect();
        assert_eq!(period(&falling), None);
        assert_relative_eq!(correlation_length(&falling), 8.05, epsilon = 0.05);
        assert_relative_eq!(correlation_length(&[1.0; 33]), 32.0);
    }

    #[test]
    fn correlated_values_have_a_coefficient_of_one() {
        let a = [1.0, 2.0, 4.0];
        assert_relative_eq!(
            coefficient(&a, &[-2.0, -4.0, -8.0]).unwrap(),
            -1.0,
            epsilon = 1e-12
        );
        assert_eq!(coefficient(&a, &[3.0; 3]), None);
    }
}
