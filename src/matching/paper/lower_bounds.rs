//! Lower bounds of the shape's part of all candidates' costs, a few instructions each.
//!
//! Carried to a sample, a neighbor whose foot is in a given cell of the target's tangent plane always
//! lands on about the same piece of surface. So for each such cell there is a row of envelopes of
//! these pieces, one for each sample, in the sample's own frame: bounds for all samples are computed
//! along the row, without looking anything up. Rows are made when they are first worth it.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::base::BaseSurface;

use super::cells::{Cells, ThickTriangle};
use super::envelope::Envelope;
use super::query::Neighbor;
use super::samples::Samples;
use super::site_grid::nearest_somewhere;

/// Only so many neighbors have bounds, the heaviest: rows for the far ones would be many.
const MOST_PROBES: usize = 32;

/// Samples whose bounds are computed together.
pub(super) const LANES: usize = 8;

/// Size of the cells of the tangent plane over the typical distance of samples.
const OFFSET_PER_SPACING: f64 = 0.4;

/// Size of the cells in space that have an envelope over the typical distance of samples.
const CELL_PER_SPACING: f64 = 0.3;

/// Most that projecting a foot's surroundings onto the base may stretch them.
const STRETCH: f64 = 1.1;

/// Searches of the same samples before bounds are made: cutting the surface into pieces takes about as
/// long as 30 searches without bounds.
const PATIENCE: usize = 100;

/// Rows made per search after that. One takes about as long as a quarter of a search.
const ROWS_PER_SEARCH: usize = 2;

/// Rows take at most this much memory, in bytes.
const MOST_MEMORY: usize = 256 << 20;

/// Envelopes by the place of a foot.
#[derive(Debug)]
pub(super) struct LowerBounds {
    triangles: Vec<ThickTriangle>,
    spacing: f64,
    searches: AtomicUsize,
    pieces: OnceLock<Pieces>,
    rows: Mutex<HashMap<[i32; 2], Vec<AskedRow>>>,
    row_count: AtomicUsize,
}

/// What may be around the partner of a foot.
#[derive(Debug, Clone, Copy)]
enum Piece {
    /// The triangles that can be around it are in an envelope.
    Within(Envelope),
    /// It has no partner, or none surrounded by samples.
    Nothing,
    /// No bound is known.
    Anything,
}

/// Pieces by cell.
#[derive(Debug)]
struct Pieces {
    cells: Cells,
    pieces: Vec<Piece>,
    /// Large cells; outside these there is nothing at all.
    outer: Cells,
}

/// A row that was asked for.
#[derive(Debug)]
struct AskedRow {
    foot: Vector3<f64>,
    row: Option<Arc<Row>>,
}

/// Envelopes of what neighbors with about the same foot get to, at every sample, in its frame.
#[derive(Debug)]
struct Row {
    blocks: Vec<Block>,
    /// Units of `middle` and `half`.
    steps: [f32; 2],
}

/// Envelopes at consecutive samples, rounded so that they hold what they should.
#[derive(Debug, Clone)]
struct Block {
    /// In units of 2⁻¹⁵.
    normal: [[i16; LANES]; 3],
    middle: [i16; LANES],
    /// `NOTHING` where there is nothing.
    half: [i16; LANES],
    /// In units of 2⁻¹⁵.
    slope: [i16; LANES],
}

/// 2⁻¹⁵.
const UNIT: f32 = 1.0 / 32768.0;

/// Half thickness of nothing, infinitely far away.
const NOTHING: i16 = i16::MIN;

/// A neighbor, prepared for bounds.
#[derive(Debug)]
pub(super) struct Probe {
    row: Arc<Row>,
    point: [f32; 3],
    /// Way from the foot to the point, and its squared length, rounded up.
    lift: [f32; 3],
    lift_sq: f32,
    /// Covers rounding.
    margin: f32,
    weight: f32,
}

impl LowerBounds {
    /// For samples with feet in `triangles`.
    pub(super) fn new(triangles: Vec<ThickTriangle>, spacing: f64) -> Self {
        Self {
            triangles,
            spacing,
            searches: AtomicUsize::new(0),
            pieces: OnceLock::new(),
            rows: Mutex::default(),
            row_count: AtomicUsize::new(0),
        }
    }

    /// By (turned) neighbor, what its bounds need, where there are any; `factor` times weight and
    /// squared distance is its cost.
    pub(super) fn probes(
        &self,
        samples: &Samples,
        neighbors: &[Neighbor],
        factor: f64,
    ) -> Vec<Option<Probe>> {
        (neighbors.iter().enumerate())
            .map(|(rank, n)| {
                if rank >= MOST_PROBES || factor <= 0.0 {
                    return None;
                }
                Some(Probe::new(self.row(samples, &n.foot)?, n, factor))
            })
            .collect()
    }

    /// Whether there were enough searches, with this one, that bounds are worth making.
    pub(super) fn wanted(&self) -> bool {
        self.searches.fetch_add(1, Ordering::Relaxed) >= PATIENCE
    }

    /// As after very many searches.
    #[cfg(test)]
    pub(super) fn be_impatient(&self) {
        self.searches.store(1 << 20, Ordering::Relaxed);
    }

    fn offset(&self) -> f64 {
        OFFSET_PER_SPACING * self.spacing
    }

    /// How far a foot may be from the one that its row was made for: half a cell's diagonal, and
    /// a quarter of its side along the normal.
    fn tolerance(&self) -> f64 {
        0.75 * self.offset() * (1.0 + 1e-9)
    }

    /// The same after projection onto the base.
    fn spread(&self) -> f64 {
        STRETCH * self.tolerance()
    }

    /// The row for neighbors with about this foot; `None` if it is not worth making.
    fn row(&self, samples: &Samples, foot: &Vector3<f64>) -> Option<Arc<Row>> {
        #[expect(clippy::cast_possible_truncation, reason = "saturates; checked below")]
        let cell = [foot.x, foot.y].map(|x| (x / self.offset()).floor() as i32);
        let [x, y] = cell.map(|i| (f64::from(i) + 0.5) * self.offset());
        let middle = Vector3::new(x, y, middle_height(samples, x, y).unwrap_or(foot.z));
        let near = |middle: &Vector3<f64>| (middle - foot).norm() <= self.tolerance();
        let wanted = {
            let mut rows = self.rows.lock().unwrap_or_else(PoisonError::into_inner);
            let here = rows.entry(cell).or_default();
            if let Some(asked) = here.iter_mut().find(|asked| near(&asked.foot)) {
                if asked.row.is_some() {
                    return asked.row.clone();
                }
                self.admits_row(samples.len()).then_some(asked.foot)
            } else {
                if near(&middle) {
                    here.push(AskedRow {
                        foot: middle,
                        row: None,
                    });
                }
                None
            }
        }?;
        // Not while holding the lock: waiting for others, a thread may come to make rows, too.
        let made = Arc::new(self.make_row(samples, &wanted));
        let mut rows = self.rows.lock().unwrap_or_else(PoisonError::into_inner);
        let here = rows.entry(cell).or_default();
        let asked = here.iter_mut().find(|asked| asked.foot == wanted)?;
        asked.row = Some(made);
        asked.row.clone()
    }

    /// Whether there is memory for one more row of so many samples, and there were enough searches.
    fn admits_row(&self, samples: usize) -> bool {
        let size = samples.div_ceil(LANES) * size_of::<Block>();
        let searches = self.searches.load(Ordering::Relaxed);
        let most = (MOST_MEMORY / size.max(1))
            .min(ROWS_PER_SEARCH * searches.saturating_sub(PATIENCE - 1));
        let admit = |made: usize| (made < most).then_some(made + 1);
        (self.row_count)
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, admit)
            .is_ok()
    }

    fn make_row(&self, samples: &Samples, foot: &Vector3<f64>) -> Row {
        let pieces = self.pieces(samples);
        let local: Vec<Piece> = (samples.sites.par_iter())
            .map(|site| {
                let moved = site.foot + site.frame.to_world(foot);
                let piece = match anchor(&samples.base, &moved, self.tolerance()) {
                    Some(anchor) => pieces.at(&anchor),
                    None => Piece::Anything,
                };
                match piece {
                    Piece::Within(envelope) => Piece::Within(Envelope {
                        middle: envelope.middle - envelope.normal.dot(&site.foot.coords),
                        normal: site.frame.to_local(&envelope.normal),
                        ..envelope
                    }),
                    other => other,
                }
            })
            .collect();
        Row::new(&local, 1e-6 * self.spacing)
    }

    fn pieces(&self, samples: &Samples) -> &Pieces {
        match self.pieces.get() {
            Some(pieces) => pieces,
            None => {
                // Not within the lock's initialisation, see above.
                let made = Pieces::new(self, samples);
                self.pieces.get_or_init(|| made)
            }
        }
    }
}

/// Third component of feet on planes and spheres, where it depends on the other two alone.
fn middle_height(samples: &Samples, x: f64, y: f64) -> Option<f64> {
    if !matches!(samples.base, BaseSurface::Plane(_) | BaseSurface::Sphere(_)) {
        return None;
    }
    let site = samples.sites.first()?;
    let moved = site.foot + site.frame.to_world(&Vector3::new(x, y, 0.0));
    let back = samples.base.foot(&moved).point - site.foot;
    Some(site.frame.to_local(&back).z)
}

/// The foot of `moved`, if feet (and on planes and spheres the points themselves) of all points at
/// most `tolerance` from it are at most `STRETCH` of that from it.
///
/// Where the base curves with radius r, projecting from a height h onto it stretches by r/(r + h).
fn anchor(base: &BaseSurface, moved: &Point3<f64>, tolerance: f64) -> Option<Point3<f64>> {
    let foot = base.foot(moved);
    let least_radius = match base {
        BaseSurface::Plane(_) | BaseSurface::Sphere(_) => {
            return (foot.height.abs() <= (STRETCH - 1.0) * tolerance).then_some(foot.point);
        }
        BaseSurface::Cylinder(cylinder) => cylinder.radius,
        BaseSurface::Cone(cone) => {
            let from_apex = foot.point - cone.apex;
            let slant = from_apex.norm().copysign(from_apex.dot(&cone.axis));
            (slant - tolerance) * cone.half_angle.tan()
        }
    };
    let least_height = foot.height - tolerance;
    (least_radius > 0.0 && STRETCH * (least_radius + least_height) >= least_radius)
        .then_some(foot.point)
}

impl Pieces {
    fn new(bounds: &LowerBounds, samples: &Samples) -> Self {
        let spread = bounds.spread();
        let cells = Cells::new(&bounds.triangles, CELL_PER_SPACING * bounds.spacing);
        let sites = nearest_somewhere(samples.grid.points(), &cells, spread);
        let radius = spread + 0.5 * 3f64.sqrt() * cells.side();
        let pieces = (sites.par_iter().enumerate())
            .map(|(cell, sites)| {
                let center = cells.center(cell);
                let away = samples.base.foot(&center).height.abs();
                if away > radius - spread {
                    // No foot is in this cell.
                    return Piece::Anything;
                }
                let triangles = samples.triangles_around(sites);
                if triangles.is_empty() {
                    return Piece::Nothing;
                }
                let gap = samples.height_range / 3.0;
                Envelope::around(&triangles, &center, radius, gap)
                    .map_or(Piece::Anything, Piece::Within)
            })
            .collect();
        let thicker = |t: &ThickTriangle| ThickTriangle {
            margin: t.margin + spread + samples.grid.reach(),
            ..*t
        };
        let outer: Vec<ThickTriangle> = bounds.triangles.iter().map(thicker).collect();
        Self {
            cells,
            pieces,
            outer: Cells::new(&outer, 2.0 * bounds.spacing),
        }
    }

    fn at(&self, p: &Point3<f64>) -> Piece {
        match self.cells.find(p) {
            Some(cell) => self.pieces[cell as usize],
            None if self.outer.find(p).is_some() => Piece::Anything,
            None => Piece::Nothing,
        }
    }
}

impl Row {
    /// `margin` covers rounding.
    fn new(pieces: &[Piece], margin: f64) -> Self {
        let most = |of: fn(&Envelope) -> f64| {
            (pieces.iter())
                .filter_map(|piece| match piece {
                    Piece::Within(envelope) => Some(of(envelope).abs()),
                    _ => None,
                })
                .fold(margin, f64::max)
        };
        let step = |most: f64| most / 32_000.0;
        let steps = [step(most(|e| e.middle)), step(most(|e| e.half))];
        let margin = margin + steps[0] + steps[1];
        let steps = [steps[0], step(most(|e| e.half) + margin)];
        let blocks = (pieces.chunks(LANES))
            .map(|pieces| {
                let mut block = Block::NOTHING;
                for (lane, piece) in pieces.iter().enumerate() {
                    block.set(lane, piece, steps, margin);
                }
                block
            })
            .collect();
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the margin covers rounding"
        )]
        let steps = steps.map(|step| step as f32);
        Self { blocks, steps }
    }
}

impl Block {
    const NOTHING: Self = Self {
        normal: [[0; LANES]; 3],
        middle: [0; LANES],
        half: [NOTHING; LANES],
        slope: [0; LANES],
    };

    #[expect(clippy::cast_possible_truncation, reason = "saturates")]
    fn set(&mut self, lane: usize, piece: &Piece, steps: [f64; 2], margin: f64) {
        match piece {
            Piece::Nothing => {}
            // Without a normal, every point is in the middle.
            Piece::Anything => self.half[lane] = 0,
            Piece::Within(envelope) => {
                for axis in 0..3 {
                    self.normal[axis][lane] = (envelope.normal[axis] * 32_767.0).round() as i16;
                }
                self.middle[lane] = (envelope.middle / steps[0]).round() as i16;
                self.half[lane] = ((envelope.half + margin) / steps[1]).ceil() as i16;
                self.slope[lane] = (envelope.slope * 32_768.0).ceil() as i16;
            }
        }
    }
}

impl Probe {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the margin covers rounding"
    )]
    fn new(row: Arc<Row>, neighbor: &Neighbor, factor: f64) -> Self {
        let lift = neighbor.point - neighbor.foot;
        let single = |v: &Vector3<f64>| [0, 1, 2].map(|i| v[i] as f32 * UNIT);
        Self {
            row,
            point: single(&neighbor.point),
            lift: single(&lift),
            // The normal is rounded, by up to 1.5 units along each axis.
            lift_sq: (lift.norm_squared() * (1.0 + 2e-4)) as f32,
            margin: (5e-5 * neighbor.point.abs().sum()) as f32,
            weight: (factor * neighbor.weight) as f32,
        }
    }

    /// Adds to `sums` at most (but for a relative error of 1e-5) what the neighbor costs at each of
    /// a block's samples; infinity where it has no partner.
    #[inline]
    pub(super) fn add(&self, block: usize, sums: &mut [f32; LANES]) {
        let block = &self.row.blocks[block];
        let mut costs = [0.0; LANES];
        for (lane, cost) in costs.iter_mut().enumerate() {
            *cost = self.least_cost(block, lane);
        }
        for (sum, cost) in sums.iter_mut().zip(costs) {
            *sum += cost;
        }
    }

    /// The same for a single sample.
    #[inline]
    pub(super) fn bound(&self, sample: usize) -> f32 {
        self.least_cost(&self.row.blocks[sample / LANES], sample % LANES)
    }

    #[inline(always)]
    fn least_cost(&self, block: &Block, lane: usize) -> f32 {
        let [x, y, z] = &block.normal;
        let (x, y, z) = (f32::from(x[lane]), f32::from(y[lane]), f32::from(z[lane]));
        let (middle, half) = (f32::from(block.middle[lane]), f32::from(block.half[lane]));
        let slope = f32::from(block.slope[lane]) * UNIT;
        let rise = x * self.lift[0] + y * self.lift[1] + z * self.lift[2];
        // How far the point may be from the disc of the envelope, where its foot is.
        let away = (self.lift_sq - rise * rise).max(0.0).sqrt();
        let along = x * self.point[0] + y * self.point[1] + z * self.point[2];
        let thickness = half * self.row.steps[1] + slope * away + self.margin;
        let gap = ((along - middle * self.row.steps[0]).abs() - thickness).max(0.0);
        // Least distance to a cone of that slope.
        let cost = self.weight * (gap * gap / (1.0 + slope * slope));
        if block.half[lane] == NOTHING {
            f32::INFINITY
        } else {
            cost
        }
    }
}
