//! What each vertex or face is coloured with, and what that means.

use nalgebra::{Point3, Vector3};

use crate::base;
use crate::completion::{COMPLETED, COST, HEIGHT, SOURCE};
use crate::mesh::TriMesh;
use crate::relief;
use crate::scan::Scan;

use super::canvas::{encoded, linear, linear_of, single};
use super::color_map::{ColorMap, look_up, of_place};
use super::legend::Legend;
use super::view::bounds;
use super::{ChannelChoice, PictureError, RenderParams};

/// Shares of the values below and above the ends of the color bar.
const QUANTILES: [f64; 2] = [0.02, 0.98];

/// sRGB colours of original and completed faces: blue and orange of Okabe & Ito (2008), which the
/// color-blind tell apart; the blue one lighter.
const ORIGINAL: [u8; 3] = [170, 196, 220];
const COMPLETED_COLOR: [u8; 3] = [230, 140, 20];

/// How pale originals are on a source map: the share of white.
const PALE: f64 = 0.62;

/// What surface without a value looks like, in linear light.
const PLAIN: [f64; 3] = [0.70, 0.67, 0.62];

/// Colours of a surface.
#[derive(Debug, Clone)]
pub(super) enum Paint {
    /// One everywhere.
    Plain,
    /// #V, linear light.
    Vertices(Vec<[f32; 3]>),
    /// #V values, NaN for none, and a colour map between two of them.
    Values {
        values: Vec<f64>,
        range: [f64; 2],
        table: Vec<[f32; 3]>,
    },
    /// #V: whether it is completed; faces with such a vertex are.
    Marks(Vec<bool>),
}

/// A paint and what it stands for.
#[derive(Debug, Clone)]
pub(super) struct Painted {
    pub(super) paint: Paint,
    pub(super) legend: Option<Legend>,
    /// Name of the channel.
    pub(super) channel: String,
    /// Values at the ends of the color bar.
    pub(super) range: Option<[f64; 2]>,
}

impl Paint {
    /// The colour (linear light) at a place in a triangle, by weights of its corners.
    pub(super) fn color(&self, corners: [u32; 3], weights: [f64; 3]) -> [f64; 3] {
        let mixed = |of: &dyn Fn(usize) -> f64| -> f64 {
            (0..3).map(|k| weights[k] * of(corners[k] as usize)).sum()
        };
        match self {
            Self::Plain => PLAIN,
            Self::Vertices(colors) => [0, 1, 2].map(|k| mixed(&|v| f64::from(colors[v][k]))),
            Self::Values {
                values,
                range: [low, high],
                table,
            } => {
                let known = |v: usize| !values[v].is_nan();
                // Of a face between values and none the corners with a value count.
                let share = mixed(&|v| if known(v) { 1.0 } else { 0.0 });
                if share <= 0.0 {
                    return PLAIN;
                }
                let value = mixed(&|v| if known(v) { values[v] } else { 0.0 }) / share;
                look_up(table, (value - low) / (high - low)).map(f64::from)
            }
            Self::Marks(marks) => {
                let completed = corners.iter().any(|v| marks[*v as usize]);
                let color = if completed { COMPLETED_COLOR } else { ORIGINAL };
                color.map(|byte| f64::from(linear(byte)))
            }
        }
    }

    /// Whether colours stand for values, so that shading should change them little.
    pub(super) fn is_data(&self) -> bool {
        !matches!(self, Self::Plain)
    }
}

/// #V: whether a vertex was completed; `None` if the scan does not tell.
pub(super) fn completed(scan: &Scan) -> Option<Vec<bool>> {
    let marks = scan.vertices.column(COMPLETED)?;
    let is_marked = |row| marks.get_f64(row).is_some_and(|mark| mark > 0.5);
    Some((0..scan.vertices.rows).map(is_marked).collect())
}

/// That a channel is missing.
pub(super) fn missing(scan: &Scan, what: impl Into<String>) -> PictureError {
    let names = scan.vertices.channels.iter().map(|c| c.name.clone());
    PictureError::NoChannel {
        what: what.into(),
        known: names.collect(),
    }
}

/// What a scan is coloured with; `mesh` is the scan's, with all its triangles.
pub(super) fn paint(
    scan: &Scan,
    mesh: &TriMesh,
    params: &RenderParams,
) -> Result<Painted, PictureError> {
    match &params.channel {
        ChannelChoice::Auto if scan.colors().is_none() => Ok(shape()),
        ChannelChoice::Auto | ChannelChoice::Color => colors(scan),
        ChannelChoice::Shape => Ok(shape()),
        ChannelChoice::Height => height(scan, mesh, params),
        ChannelChoice::Completed => marks(scan),
        ChannelChoice::Cost => property(scan, mesh, params, COST, ""),
        ChannelChoice::Source => sources(scan, mesh),
        ChannelChoice::Property(name) => property(scan, mesh, params, name, ""),
    }
}

fn plainly(paint: Paint, channel: &str) -> Painted {
    Painted {
        paint,
        legend: None,
        channel: channel.to_owned(),
        range: None,
    }
}

fn shape() -> Painted {
    plainly(Paint::Plain, "shape")
}

fn colors(scan: &Scan) -> Result<Painted, PictureError> {
    let colors = scan.colors().ok_or_else(|| missing(scan, "colours"))?;
    let light = |color: &[f64; 3]| color.map(|value| single(linear_of(value)));
    let colors = colors.iter().map(light).collect();
    Ok(plainly(Paint::Vertices(colors), "color"))
}

fn marks(scan: &Scan) -> Result<Painted, PictureError> {
    let marks =
        completed(scan).ok_or_else(|| missing(scan, format!("vertex property \"{COMPLETED}\"")))?;
    Ok(Painted {
        legend: Some(Legend::Keys(vec![
            (ORIGINAL, "original".to_owned()),
            (COMPLETED_COLOR, "completed".to_owned()),
        ])),
        ..plainly(Paint::Marks(marks), "completed")
    })
}

/// The values of a property of numbers.
fn values(scan: &Scan, name: &str) -> Result<Vec<f64>, PictureError> {
    let column = scan.vertices.column(name);
    let values = column.and_then(|column| {
        (0..scan.vertices.rows)
            .map(|row| column.get_f64(row))
            .collect::<Option<Vec<f64>>>()
    });
    values.ok_or_else(|| missing(scan, format!("vertex property \"{name}\" of numbers")))
}

fn property(
    scan: &Scan,
    mesh: &TriMesh,
    params: &RenderParams,
    name: &str,
    unit: &str,
) -> Result<Painted, PictureError> {
    let values = values(scan, name)?;
    valued(mesh, values, params, name, unit, ColorMap::Sequential)
}

fn height(scan: &Scan, mesh: &TriMesh, params: &RenderParams) -> Result<Painted, PictureError> {
    let heights = match values(scan, HEIGHT) {
        Ok(heights) => heights,
        Err(_) => fitted_heights(scan, mesh, params)?,
    };
    valued(
        mesh,
        heights,
        params,
        HEIGHT,
        "scan units",
        ColorMap::Diverging,
    )
}

/// Heights over the base surface that fits the original part; NaN beyond the relief's reach.
fn fitted_heights(
    scan: &Scan,
    mesh: &TriMesh,
    params: &RenderParams,
) -> Result<Vec<f64>, PictureError> {
    let (mesh, _) = mesh.clone().centered();
    let marks = completed(scan).unwrap_or_else(|| vec![false; mesh.positions.len()]);
    let is_original = |t: &&[u32; 3]| t.iter().all(|v| !marks[*v as usize]);
    let originals: Vec<[u32; 3]> = mesh.triangles.iter().filter(is_original).copied().collect();
    let fit = base::fit_part(&mesh.positions, &originals, &params.fit)?;
    if !fit.fits() {
        return Err(PictureError::NoBase);
    }
    let reach = relief::reach(&fit);
    let within = |height: f64| {
        if height.abs() <= reach {
            height
        } else {
            f64::NAN
        }
    };
    let relief = relief::extract(&mesh, &fit.base);
    Ok(relief.heights.into_iter().map(within).collect())
}

/// Values with a color bar.
fn valued(
    mesh: &TriMesh,
    values: Vec<f64>,
    params: &RenderParams,
    name: &str,
    unit: &str,
    map: ColorMap,
) -> Result<Painted, PictureError> {
    let range = match params.range {
        Some(range) => range,
        None => robust_range(mesh, &values, map)
            .ok_or_else(|| PictureError::NoValues(name.to_owned()))?,
    };
    Ok(Painted {
        legend: Some(Legend::Bar {
            title: name.to_owned(),
            unit: unit.to_owned(),
            range,
            map,
        }),
        range: Some(range),
        ..plainly(
            Paint::Values {
                values,
                range,
                table: map.table(),
            },
            name,
        )
    })
}

/// Quantiles of the values at the vertices that triangles use, around 0 for a diverging map; `None` without
/// any finite value.
fn robust_range(mesh: &TriMesh, values: &[f64], map: ColorMap) -> Option<[f64; 2]> {
    let used = mesh.used_vertices();
    let mut known: Vec<f64> = (values.iter().zip(used))
        .filter(|(value, used)| *used && value.is_finite())
        .map(|(value, _)| *value)
        .collect();
    let last = known.len().checked_sub(1)?;
    let mut quantile = |share: f64| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share of an index"
        )]
        let rank = (share * last as f64).round() as usize;
        *known.select_nth_unstable_by(rank, f64::total_cmp).1
    };
    let [low, high] = QUANTILES.map(&mut quantile);
    let [low, high] = match map {
        ColorMap::Sequential => [low, high],
        ColorMap::Diverging => {
            let most = low.abs().max(high.abs());
            [-most, most]
        }
    };
    if low < high {
        return Some([low, high]);
    }
    // One value only: it is in the middle of the bar.
    let around = if low.abs() > 0.0 {
        0.5 * low.abs()
    } else {
        1.0
    };
    Some([low - around, low + around])
}

/// Each place of the scan in a colour of its own: originals pale, completed vertices in that of their source.
fn sources(scan: &Scan, mesh: &TriMesh) -> Result<Painted, PictureError> {
    let sources = values(scan, SOURCE)?;
    let place_colors = PlaceColors::new(&mesh.positions);
    let rows = mesh.positions.len();
    let colors = (mesh.positions.iter().zip(&sources))
        .map(|(p, source)| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "negative indices and NaN are sorted out before, and the rest saturates"
            )]
            let source = (*source >= 0.0).then_some(*source as usize);
            match source.filter(|source| *source < rows) {
                Some(source) => place_colors.of(&mesh.positions[source]).map(single),
                None => (place_colors.of(p)).map(|light| single(PALE + (1.0 - PALE) * light)),
            }
        })
        .collect();
    let sample = |share: f64| of_place([0.8, 0.4, 0.0]).map(|light| share + (1.0 - share) * light);
    Ok(Painted {
        legend: Some(Legend::Keys(vec![
            (in_bytes(sample(PALE)), "original".to_owned()),
            (in_bytes(sample(0.0)), "copied from".to_owned()),
        ])),
        ..plainly(Paint::Vertices(colors), "source")
    })
}

fn in_bytes(light: [f64; 3]) -> [u8; 3] {
    light.map(|light| encoded(single(light)))
}

/// Colours by position in the scan's box: the two longest sides give the hue, the third the lightness.
struct PlaceColors {
    middle: Point3<f64>,
    half: Vector3<f64>,
    /// The axes, the longest first.
    axes: [usize; 3],
}

impl PlaceColors {
    fn new(positions: &[Point3<f64>]) -> Self {
        let [low, high] = bounds(positions.iter()).unwrap_or([Point3::origin(); 2]);
        let half = 0.5 * (high - low);
        let mut axes = [0, 1, 2];
        axes.sort_by(|a, b| half[*b].total_cmp(&half[*a]).then(a.cmp(b)));
        Self {
            middle: low + half,
            half,
            axes,
        }
    }

    fn of(&self, p: &Point3<f64>) -> [f64; 3] {
        let from_middle = p - self.middle;
        of_place(self.axes.map(|axis| {
            if self.half[axis] > 0.0 {
                from_middle[axis] / self.half[axis]
            } else {
                0.0
            }
        }))
    }
}

#[cfg(test)]
mod tests;
