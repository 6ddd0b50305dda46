//! Parameters to synthetic scans with known truth: what a scanner would have delivered, and what
//! it missed.
//!
//! An object is a base surface, tessellated nearly evenly, and a relief over it. The complete
//! object is always made first and then cut to the asked [`Part`], so that a partial scan is bit
//! for bit a subset of the complete one. All objects lie around the origin: planes in xy, facing
//! +z; the axis of cylinders is z. Lengths are millimetres.
//!
//! The relief of an object does not depend on its number of vertices, but for [`Kind::Noise`].
//! Its mean over the complete object is zero, so that the base is (but for the noise) the one that
//! least squares find.
//!
//! ```
//! use relievo::synth::{Kind, Part, SynthParams};
//! let params = SynthParams { kind: Kind::GolfBall, vertices: 2000, ..SynthParams::default() };
//! let full = relievo::synth::scan(&params)?;
//! let holed = relievo::synth::scan(&SynthParams { part: Part::hole(0.1), ..params })?;
//! let z = |s: &relievo::synth::Synthetic| s.scan.vertices.channels[2].values.clone();
//! let (relievo::scan::Column::F64(all), relievo::scan::Column::F64(some)) = (z(&full), z(&holed))
//! else { unreachable!() };
//! assert_eq!(some[7].to_bits(), all[holed.full_index[7] as usize].to_bits());
//! # Ok::<(), relievo::synth::SynthError>(())
//! ```

mod bark;
mod bricks;
mod column;
mod fractal;
mod golf_ball;
mod kind;
mod part;
mod random_waves;
mod tessellate;
mod waves;

pub use kind::Kind;
pub use part::Part;

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::base::BaseSurface;
use crate::mesh::Csr;
use crate::rng::{Rng, Stage};
use crate::scan::{Channel, Column, Scan, Table};
use tessellate::Tessellation;

/// Largest number of vertices: with twice as many triangles, indices of half-edges stay in 32 bits.
const MOST_VERTICES: usize = 500_000_000;

/// What to make.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
pub struct SynthParams {
    /// The object. Default: the golf ball.
    pub kind: Kind,
    /// Number of vertices of the *complete* object, met within 2 %; at least
    /// [`Kind::least_vertices`]. Default: 12000.
    pub vertices: usize,
    /// What the scanner saw of it. Default: everything.
    pub part: Part,
    /// Standard deviation of the Gaussian noise along the base normal, in mm. Default: 0.
    pub noise: f64,
    /// Equal seeds give equal bytes. Default: 0.
    pub seed: u32,
}

impl Default for SynthParams {
    fn default() -> Self {
        Self {
            kind: Kind::GolfBall,
            vertices: 12_000,
            part: Part::default(),
            noise: 0.0,
            seed: 0,
        }
    }
}

/// A synthetic scan and its truth.
///
/// For every vertex, `position = foot + height · normal` with foot and normal on the true base.
#[derive(Debug, Clone, PartialEq)]
pub struct Synthetic {
    /// The scan: `x`, `y`, `z`, triangles, and `red`, `green`, `blue` (`uchar`) for coloured kinds.
    ///
    /// Coordinates are `double`: rounding to `float` would be a second noise, of about 1e-6 mm,
    /// which no parameter turns off.
    pub scan: Scan,
    /// The true base surface.
    pub base: BaseSurface,
    /// #V true heights over the base, noise included.
    pub heights: Vec<f64>,
    /// #V indices of the same vertices in the complete object, ascending.
    pub full_index: Vec<u32>,
}

/// Parameters from which no scan can be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SynthError {
    /// The relief needs a minimum number of vertices to be there at all.
    #[error("{kind} needs at least {least} vertices, but {asked} were asked for")]
    TooFewVertices {
        /// The object.
        kind: Kind,
        /// See [`Kind::least_vertices`].
        least: usize,
        /// The number asked for.
        asked: usize,
    },
    /// Indices have 32 bits.
    #[error("{0} vertices are too many; the limit is {MOST_VERTICES}")]
    TooManyVertices(usize),
    /// The standard deviation of the noise is finite and not negative.
    #[error("the noise must be a finite length of at least 0, not {0}")]
    Noise(f64),
    /// The hole's share is in (0, 0.5].
    #[error("the hole's share of the vertices must be above 0 and at most 0.5, not {0}")]
    Fraction(f64),
    /// The view direction is finite and not zero.
    #[error("the view direction must be finite and not zero")]
    Direction,
    /// Some triangle faces the scanner.
    #[error("nothing of {0} faces the scanner")]
    NothingInView(Kind),
    /// The hole fits inside the rim, a few edges away from it.
    #[error("a hole of {0} vertices does not fit inside the rim")]
    HoleTooLarge(usize),
    /// The name is one of [`Kind::ALL`].
    #[error("there is no synthetic object named {0:?}; there are {names}", names = kind::names())]
    UnknownKind(String),
}

/// A complete object: base, vertices and relief before levelling and noise.
struct Object {
    tessellation: Tessellation,
    /// #V heights over the tessellation's base.
    heights: Vec<f64>,
    /// #V colours, or none.
    colors: Vec<[u8; 3]>,
}

/// The independent uses of randomness, each with a stream of its own.
#[derive(Debug, Clone, Copy)]
#[repr(u32)]
enum Draw {
    Jitter,
    Relief,
    Noise,
    Hole,
}

fn stream(seed: u32, draw: Draw) -> Rng {
    Rng::new(seed, Stage::Synth, draw as u32)
}

/// Makes a synthetic scan.
///
/// # Errors
/// Parameters out of range, nothing in view, or a hole that does not fit: see [`SynthError`].
pub fn scan(params: &SynthParams) -> Result<Synthetic, SynthError> {
    check(params)?;
    let Object {
        tessellation: mut surface,
        mut heights,
        colors,
    } = object(params);

    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    surface.raise(mean);
    let mut rng = stream(params.seed, Draw::Noise);
    for height in &mut heights {
        *height += params.noise * rng.normal() - mean;
    }

    let cut = part::cut(&surface, params)?;
    let kept = |v: &u32| *v as usize;
    let positions: Vec<Point3<f64>> = cut
        .full_index
        .iter()
        .map(kept)
        .map(|v| surface.feet[v] + surface.normals[v] * heights[v])
        .collect();
    let colors: Vec<[u8; 3]> = if colors.is_empty() {
        colors
    } else {
        cut.full_index.iter().map(kept).map(|v| colors[v]).collect()
    };
    Ok(Synthetic {
        scan: to_scan(&positions, &colors, &cut.triangles, params),
        base: surface.base,
        heights: cut
            .full_index
            .iter()
            .map(kept)
            .map(|v| heights[v])
            .collect(),
        full_index: cut.full_index,
    })
}

fn check(params: &SynthParams) -> Result<(), SynthError> {
    let least = params.kind.least_vertices();
    if params.vertices < least {
        return Err(SynthError::TooFewVertices {
            kind: params.kind,
            least,
            asked: params.vertices,
        });
    }
    if params.vertices > MOST_VERTICES {
        return Err(SynthError::TooManyVertices(params.vertices));
    }
    if !(params.noise >= 0.0 && params.noise.is_finite()) {
        return Err(SynthError::Noise(params.noise));
    }
    if let Some(fraction) = params.part.hole
        && !(fraction > 0.0 && fraction <= 0.5)
    {
        return Err(SynthError::Fraction(fraction));
    }
    match params.part.view {
        Some(d) if !(d.iter().all(|x| x.is_finite()) && d != Vector3::zeros()) => {
            Err(SynthError::Direction)
        }
        _ => Ok(()),
    }
}

fn object(params: &SynthParams) -> Object {
    let (vertices, seed) = (params.vertices, params.seed);
    match params.kind {
        Kind::Waves => waves::object(vertices, seed),
        Kind::Noise => random_waves::object(vertices, seed),
        Kind::GolfBall => golf_ball::object(vertices, seed),
        Kind::Bark => bark::object(vertices, seed),
        Kind::Column => column::object(vertices, seed),
        Kind::Bricks => bricks::object(vertices, seed),
    }
}

fn to_scan(
    positions: &[Point3<f64>],
    colors: &[[u8; 3]],
    triangles: &[[u32; 3]],
    params: &SynthParams,
) -> Scan {
    let channel = |name: &str, values| Channel {
        name: name.to_owned(),
        values,
    };
    let coordinate = |axis: usize| Column::F64(positions.iter().map(|p| p[axis]).collect());
    let mut channels = vec![
        channel("x", coordinate(0)),
        channel("y", coordinate(1)),
        channel("z", coordinate(2)),
    ];
    if !colors.is_empty() {
        for (i, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let values = Column::U8(colors.iter().map(|c| c[i]).collect());
            channels.push(channel(name, values));
        }
    }
    let mut faces = Csr::default();
    for triangle in triangles {
        faces.push_row(triangle);
    }
    Scan {
        vertices: Table {
            channels,
            rows: positions.len(),
        },
        face_channels: Table {
            channels: Vec::new(),
            rows: faces.len(),
        },
        faces,
        comments: vec![format!("synthetic {}, seed {}", params.kind, params.seed)],
        ..Scan::default()
    }
}

#[cfg(test)]
mod tests;
