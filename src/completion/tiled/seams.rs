//! How well tiles fit together: steps across their borders against steps within them.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::neighborhood::Frame;

use super::super::growth::Canvas;
use super::division::NONE;

/// A border of fewer edges may stand out by chance.
const FEWEST: usize = 30;

/// Directions of edges are told apart by so many bins of half a turn.
const BINS: usize = 8;

/// Steps from a completed vertex to the next across borders of tiles, as ratios to what is expected there: 1 where no
/// border shows.
///
/// Relief and texture step more in some directions than in others, and borders have directions, too: each edge across a
/// border is expected to step as the mean edge of its direction (in eight bins, in the frame of the surface) does within
/// tiles. What goes wrong without a step from one vertex to the next is not seen: a brick that ends or changes its shape
/// at a border, or a bend.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SeamReport {
    /// Absolute differences of heights. `None` without an edge across a border, or where nothing is expected to step.
    pub heights: Option<f64>,
    /// Absolute differences of colours, over red, green and blue. `None` as for heights, or without colours.
    pub colors: Option<f64>,
    /// Number of edges across borders.
    pub edges: usize,
    /// Of all pairs of tiles with at least 30 edges across their border the one with the greatest ratio of heights or
    /// colours.
    pub worst: Option<WorstBorder>,
    /// Steps within tiles.
    pub within: StepsWithin,
}

/// The border between two tiles, see [`SeamReport`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WorstBorder {
    /// The tiles' numbers.
    pub tiles: [usize; 2],
    /// As of [`SeamReport`].
    pub heights: Option<f64>,
    /// As of [`SeamReport`].
    pub colors: Option<f64>,
    /// Number of edges across.
    pub edges: usize,
}

/// Steps within tiles as ratios to those between samples of the scan, for edges of the same direction and length:
/// above 1 where pieces that were copied from several places meet and do not fit together, borders or not.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct StepsWithin {
    /// As of [`SeamReport`].
    pub heights: Option<f64>,
    /// As of [`SeamReport`].
    pub colors: Option<f64>,
}

/// What is summed over edges.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    edges: usize,
    length: f64,
    heights: f64,
    colors: f64,
}

impl Sums {
    fn add(&mut self, edge: &Edge) {
        self.edges += 1;
        self.length += edge.length;
        self.heights += edge.height;
        self.colors += edge.color;
    }
}

/// Sums of steps, and of what is expected for the same edges.
#[derive(Debug, Clone, Copy, Default)]
struct Against {
    edges: usize,
    heights: [f64; 2],
    colors: [f64; 2],
}

impl Against {
    /// The steps of edges of one direction, of which `share` mean as much as all those that are `expected`.
    fn add(&mut self, steps: &Sums, expected: &Sums, share: f64) {
        self.edges += steps.edges;
        // In directions that nothing else has nothing can be expected.
        if share.is_finite() {
            self.heights[0] += steps.heights;
            self.heights[1] += expected.heights * share;
            self.colors[0] += steps.colors;
            self.colors[1] += expected.colors * share;
        }
    }

    fn add_all(&mut self, other: &Self) {
        self.edges += other.edges;
        for i in 0..2 {
            self.heights[i] += other.heights[i];
            self.colors[i] += other.colors[i];
        }
    }

    /// Ratios of heights and colours.
    fn ratios(&self) -> [Option<f64>; 2] {
        [self.heights, self.colors].map(|[steps, expected]| {
            let ratio = steps / expected;
            (expected > 0.0 && ratio.is_finite()).then_some(ratio)
        })
    }
}

/// An edge between two vertices.
struct Edge {
    bin: usize,
    length: f64,
    height: f64,
    color: f64,
}

impl Edge {
    fn new(canvas: &Canvas, frame: &Frame, [v, n]: [usize; 2]) -> Self {
        let way = canvas.relief.feet[n] - canvas.relief.feet[v];
        let local = frame.to_local(&way);
        let turn = local.y.atan2(local.x).rem_euclid(PI) / PI;
        let color = canvas.colors.as_ref().map_or(0.0, |colors| {
            let channels = colors[v].iter().zip(&colors[n]);
            channels.map(|(a, b)| (a - b).abs()).sum::<f64>() / 3.0
        });
        Self {
            bin: bin(turn),
            length: way.norm(),
            height: (canvas.relief.heights[v] - canvas.relief.heights[n]).abs(),
            color,
        }
    }
}

/// Edges along the frame's axes, of which grids have many, are in the middle of their bins.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a turn of at most 1; what is not a number is 0"
)]
fn bin(turn: f64) -> usize {
    (turn * BINS as f64).round() as usize % BINS
}

/// Steps along edges, on one base surface after the other.
#[derive(Debug, Default)]
pub(super) struct Steps {
    /// Across the border of each pair of tiles.
    borders: BTreeMap<[usize; 2], Against>,
    within: Against,
    /// Tiles so far.
    tiles: usize,
}

/// What steps are counted on: a canvas that is completed.
pub(super) struct Completed<'a> {
    pub(super) canvas: &'a Canvas,
    /// By vertex.
    pub(super) frames: &'a [Frame],
    /// By vertex: whether it may be copied from.
    pub(super) samples: &'a [bool],
    /// By target: its tile, [`NONE`] for what is not looked at.
    pub(super) tile_of: &'a [u32],
    /// Number of tiles.
    pub(super) tiles: usize,
}

impl Completed<'_> {
    /// Calls with all edges between vertices that are looked at: samples have no tile.
    fn for_each_edge(&self, mut visit: impl FnMut([Option<u32>; 2], &Edge)) {
        let canvas = self.canvas;
        let first = canvas.first_target;
        let is_looked_at = |v: usize| match v.checked_sub(first) {
            None => self.samples[v],
            Some(target) => self.tile_of[target] != NONE,
        };
        let tile = |v: usize| Some(self.tile_of[v.checked_sub(first)?]);
        for v in (0..canvas.points.len()).filter(|v| is_looked_at(*v)) {
            for n in canvas.adjacency.neighbors.row(v) {
                let n = *n as usize;
                if n > v && is_looked_at(n) {
                    let edge = Edge::new(canvas, &self.frames[v], [v, n]);
                    visit([tile(v), tile(n)], &edge);
                }
            }
        }
    }
}

impl Steps {
    /// Adds the edges between samples or targets of a canvas, whose tiles are numbered on from those before.
    pub(super) fn add(&mut self, completed: &Completed) {
        let [mut scanned, mut within] = [[Sums::default(); BINS]; 2];
        let mut across: BTreeMap<[usize; 2], [Sums; BINS]> = BTreeMap::new();
        completed.for_each_edge(|tiles, edge| {
            let sums = match tiles {
                [None, None] => &mut scanned,
                [Some(a), Some(b)] if a == b => &mut within,
                [Some(a), Some(b)] => {
                    let pair = [a.min(b), a.max(b)].map(|tile| self.tiles + tile as usize);
                    across.entry(pair).or_default()
                }
                // Between scan and fill: no border of tiles.
                _ => return,
            };
            sums[edge.bin].add(edge);
        });
        for (pair, across) in across {
            let border = self.borders.entry(pair).or_default();
            for (across, within) in across.iter().zip(&within) {
                border.add(across, within, across.edges as f64 / within.edges as f64);
            }
        }
        for (within, scanned) in within.iter().zip(&scanned) {
            // Targets may be closer to each other than samples are.
            (self.within).add(within, scanned, within.length / scanned.length);
        }
        self.tiles += completed.tiles;
    }

    pub(super) fn report(&self) -> SeamReport {
        let mut all = Against::default();
        self.borders.values().for_each(|border| all.add_all(border));
        let worst = (self.borders.iter())
            .filter(|(_, border)| border.edges >= FEWEST)
            .map(|(tiles, border)| {
                let [heights, colors] = border.ratios();
                let (tiles, edges) = (*tiles, border.edges);
                WorstBorder {
                    tiles,
                    heights,
                    colors,
                    edges,
                }
            })
            .filter(|border| border.greatest() > 0.0)
            // Of equal ones the first.
            .min_by(|a, b| b.greatest().total_cmp(&a.greatest()));
        let [heights, colors] = all.ratios();
        let [within_heights, within_colors] = self.within.ratios();
        SeamReport {
            heights,
            colors,
            edges: all.edges,
            worst,
            within: StepsWithin {
                heights: within_heights,
                colors: within_colors,
            },
        }
    }
}

impl WorstBorder {
    fn greatest(&self) -> f64 {
        let ratios = [self.heights, self.colors].into_iter().flatten();
        ratios.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::super::division::tests::sheet;
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::{Rotation3, Vector3};

    /// Left and right half of a hole, each a slope of 1 an edge to the right as the scan around is; the right one is
    /// higher by `step`.
    fn halves(step: f64) -> (Canvas, Vec<u32>) {
        let mut canvas = sheet(20);
        let first = canvas.first_target;
        let is_right = |x: f64| x >= 20.0;
        for v in 0..canvas.points.len() {
            let x = canvas.points[v].x;
            let is_higher = v >= first && is_right(x);
            canvas.relief.heights[v] = x + if is_higher { step } else { 0.0 };
        }
        let tiles = canvas.points[first..].iter();
        let tiles = tiles.map(|p| u32::from(is_right(p.x))).collect();
        (canvas, tiles)
    }

    fn report(canvas: &Canvas, tile_of: &[u32], axes: [Vector3<f64>; 3]) -> SeamReport {
        let samples: Vec<bool> = (0..canvas.points.len())
            .map(|v| v < canvas.first_target)
            .collect();
        let mut steps = Steps::default();
        steps.add(&Completed {
            canvas,
            frames: &vec![Frame { axes }; canvas.points.len()],
            samples: &samples,
            tile_of,
            tiles: 2,
        });
        steps.report()
    }

    fn axes() -> [Vector3<f64>; 3] {
        [Vector3::x(), Vector3::y(), Vector3::z()]
    }

    #[test]
    fn a_border_shows_by_its_step_and_not_by_its_direction() {
        for step in [0.0, 2.0] {
            for degrees in [0.0, 30.0, 45.0f64] {
                let (canvas, tiles) = halves(step);
                let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), degrees.to_radians());
                let report = report(&canvas, &tiles, axes().map(|axis| turn * axis));
                // 20 rows with an edge across each, and a diagonal between any two; all rise by 1.
                assert_eq!(report.edges, 39);
                assert_relative_eq!(report.heights.unwrap(), 1.0 + step, epsilon = 1e-12);
                assert_eq!(report.colors, None);
                assert_relative_eq!(report.within.heights.unwrap(), 1.0, epsilon = 1e-12);
                let worst = report.worst.unwrap();
                assert_eq!((worst.tiles, worst.edges), ([0, 1], 39));
                assert_eq!(worst.heights, report.heights);
            }
        }
    }

    #[test]
    fn one_bad_border_is_told_from_good_ones() {
        let (mut canvas, _) = halves(0.0);
        canvas.colors = Some(canvas.points.iter().map(|p| [p.x / 100.0; 3]).collect());
        let first = canvas.first_target;
        // Three tiles side by side, and a small one in a corner; colours jump between the last two, and around that.
        let mut tiles = Vec::new();
        for v in first..canvas.points.len() {
            let [x, y] = [canvas.points[v].x, canvas.points[v].y];
            let is_in_corner = x < 12.0 && y < 12.0;
            let (tile, higher) = match x {
                _ if is_in_corner => (3, 0.5),
                ..16.0 => (0, 0.0),
                ..23.0 => (1, 0.0),
                _ => (2, 0.03),
            };
            tiles.push(tile);
            canvas.colors.as_mut().unwrap()[v] = [x / 100.0 + higher; 3];
        }
        let report = report(&canvas, &tiles, axes());
        let worst = report.worst.unwrap();
        assert_eq!((worst.tiles, worst.edges), ([1, 2], 39));
        assert_relative_eq!(worst.colors.unwrap(), 4.0, epsilon = 1e-9);
        assert_relative_eq!(worst.heights.unwrap(), 1.0, epsilon = 1e-9);
        assert_relative_eq!(report.heights.unwrap(), 1.0, epsilon = 1e-9);
    }

    #[test]
    fn what_does_not_fit_within_a_tile_is_told() {
        let (canvas, tiles) = halves(2.0);
        let report = report(&canvas, &vec![0; tiles.len()], axes());
        assert_eq!((report.edges, report.worst), (0, None));
        // All edges that lead to the right rise by 1, but for 20 + 19 by 3.
        let count = 19.0 * 20.0 + 19.0 * 19.0;
        let expected = (count + 2.0 * 39.0) / count;
        assert_relative_eq!(report.within.heights.unwrap(), expected, epsilon = 1e-12);
    }

    #[test]
    fn without_borders_or_steps_there_is_no_ratio() {
        let (canvas, mut tiles) = halves(0.0);
        let mut flat = sheet(20);
        flat.colors = Some(vec![[0.5; 3]; flat.points.len()]);
        let told = report(&flat, &tiles, axes());
        assert_eq!((told.heights, told.colors), (None, None));
        assert_eq!((told.edges, told.worst), (39, None));
        tiles.fill(NONE);
        assert_eq!(report(&canvas, &tiles, axes()), SeamReport::default());
        tiles.fill(1);
        let told = report(&canvas, &tiles, axes());
        assert_eq!((told.heights, told.colors, told.edges), (None, None, 0));
    }

    #[test]
    fn tiles_of_a_second_surface_are_numbered_on() {
        let (canvas, tile_of) = halves(1.0);
        let frames = vec![Frame { axes: axes() }; canvas.points.len()];
        let samples = vec![false; canvas.points.len()];
        let completed = Completed {
            canvas: &canvas,
            frames: &frames,
            samples: &samples,
            tile_of: &tile_of,
            tiles: 2,
        };
        let mut flat = sheet(20);
        flat.relief
            .heights
            .clone_from(&halves(0.0).0.relief.heights);
        let mut steps = Steps::default();
        steps.add(&Completed {
            canvas: &flat,
            ..completed
        });
        steps.add(&completed);
        let report = steps.report();
        assert_eq!(report.edges, 78);
        assert_relative_eq!(report.heights.unwrap(), 1.5, epsilon = 1e-12);
        assert_eq!(report.worst.unwrap().tiles, [2, 3]);
        // Without samples there is nothing that steps within could be held against.
        assert_eq!(report.within.heights, None);
    }
}
