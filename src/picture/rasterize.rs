//! Triangles to pixels: which triangle is nearest at each sample, exactly.
//!
//! Vertices are put on a grid of 1/256 of a sample and edges are compared in integers with the top-left
//! rule, so that a sample on a common edge belongs to exactly one of the two triangles: no cracks, nothing
//! drawn twice. Of two triangles at the same depth the one with the lower index wins. The picture is drawn
//! in tiles, each by one thread and in the triangles' order: the number of threads changes nothing.

use rayon::prelude::*;

use super::camera::Seen;
use super::canvas::{Canvas, Pixel, single};

/// Samples of a pixel along each side.
pub(super) const SAMPLES: usize = 3;
/// Grid steps of a sample along each side.
const STEPS: i64 = 256;
/// Side of a tile in pixels.
const TILE: usize = 32;
/// Side of a tile in samples.
const SIDE: usize = TILE * SAMPLES;

/// What a sample sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hit {
    /// Index of the triangle.
    pub(super) triangle: usize,
    /// Weights of its corners, on the picture.
    pub(super) weights: [f64; 3],
    /// Whether the triangle is seen from its front (counterclockwise).
    pub(super) front: bool,
    /// Distance to the nearest edge in pixels, where it is asked for; else infinite.
    pub(super) to_edge: f64,
}

/// Light and unit normal of what a sample sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shaded {
    /// Red, green and blue, linear.
    pub(super) light: [f64; 3],
    /// In the camera's axes.
    pub(super) normal: [f64; 3],
}

/// A vertex on the grid.
#[derive(Debug, Clone, Copy)]
struct Snapped {
    x: i64,
    y: i64,
    depth: f64,
}

/// A triangle on the grid, its corners ordered so that its area is positive.
struct OnGrid {
    corners: [Snapped; 3],
    /// Whether two corners changed places for that.
    turned: bool,
    area: f64,
}

/// Twice the area of a triangle on the grid; positive if it is clockwise on the picture (y down).
fn double_area(a: &Snapped, b: &Snapped, x: i64, y: i64) -> i64 {
    (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)
}

impl OnGrid {
    fn new(corners: [Snapped; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let area = double_area(&a, &b, c.x, c.y);
        let turned = area < 0;
        (area != 0).then(|| Self {
            corners: if turned { [a, c, b] } else { [a, b, c] },
            turned,
            area: area.abs() as f64,
        })
    }

    /// The edge functions (opposite to each corner) at a grid point.
    fn edges(&self, x: i64, y: i64) -> [i64; 3] {
        let [a, b, c] = &self.corners;
        [
            double_area(b, c, x, y),
            double_area(c, a, x, y),
            double_area(a, b, x, y),
        ]
    }

    /// For each edge, the least value of its function that is inside: 0 for upper and left edges, else 1.
    fn least(&self) -> [i64; 3] {
        let [a, b, c] = &self.corners;
        [[b, c], [c, a], [a, b]].map(|[from, to]| {
            let upper = from.y == to.y && to.x > from.x;
            let left = to.y < from.y;
            i64::from(!(upper || left))
        })
    }

    /// By how much the edge functions change from sample to sample in a row.
    fn steps(&self) -> [i64; 3] {
        let [a, b, c] = &self.corners;
        [[b, c], [c, a], [a, b]].map(|[from, to]| -(to.y - from.y) * STEPS)
    }

    fn depth(&self, edges: [i64; 3]) -> f64 {
        let [a, b, c] = &self.corners;
        let [_, to_b, to_c] = edges.map(|edge| edge as f64 / self.area);
        a.depth + to_b * (b.depth - a.depth) + to_c * (c.depth - a.depth)
    }

    fn hit(&self, triangle: usize, x: i64, y: i64, with_edges: bool) -> Hit {
        let edges = self.edges(x, y).map(|edge| edge as f64);
        let [a, b, c] = edges.map(|edge| edge / self.area);
        let to_edge = if with_edges {
            self.to_edge(edges)
        } else {
            f64::INFINITY
        };
        Hit {
            triangle,
            weights: if self.turned { [a, c, b] } else { [a, b, c] },
            // With y down, what is counterclockwise in the scan has a negative area.
            front: self.turned,
            to_edge,
        }
    }

    /// Distance to the nearest edge in pixels, from the edge functions.
    fn to_edge(&self, edges: [f64; 3]) -> f64 {
        let [a, b, c] = &self.corners;
        let sides = [[b, c], [c, a], [a, b]];
        let distances = sides.iter().zip(edges).map(|([from, to], edge)| {
            let [dx, dy] = [to.x - from.x, to.y - from.y].map(|d| d as f64);
            edge / dx.hypot(dy)
        });
        let pixel = (STEPS * SAMPLES as i64) as f64;
        distances.fold(f64::INFINITY, f64::min) / pixel
    }
}

/// The samples whose middles lie between two grid coordinates, of those from 0 to `count`.
fn samples_between(low: i64, high: i64, count: usize) -> std::ops::Range<usize> {
    // Middles lie at half a sample.
    let first = (low - STEPS / 2 + STEPS - 1).div_euclid(STEPS).max(0);
    let last = (high - STEPS / 2).div_euclid(STEPS);
    let inside = |n: i64| usize::try_from(n).unwrap_or(0).min(count);
    inside(first)..inside(last + 1)
}

fn middle(sample: usize) -> i64 {
    sample as i64 * STEPS + STEPS / 2
}

/// Triangles, sorted into tiles.
struct Scene<'a> {
    vertices: Vec<Snapped>,
    triangles: &'a [[u32; 3]],
    /// Whether samples are told how far the triangle's edges are.
    with_edges: bool,
    /// Tiles from left to right and from top to bottom.
    columns: usize,
    rows: usize,
    /// Where each tile's triangles begin in `members`, and the end.
    starts: Vec<usize>,
    members: Vec<u32>,
}

impl<'a> Scene<'a> {
    fn new(seen: &[Seen], triangles: &'a [[u32; 3]], width: usize, height: usize) -> Self {
        let scale = (STEPS * SAMPLES as i64) as f64;
        #[expect(clippy::cast_possible_truncation, reason = "a float cast saturates")]
        let on_grid = |x: f64| (x * scale).round() as i64;
        let vertices = (seen.par_iter())
            .map(|s| Snapped {
                x: on_grid(s.x),
                y: on_grid(s.y),
                depth: s.depth,
            })
            .collect();
        let mut scene = Self {
            vertices,
            triangles,
            with_edges: false,
            columns: width.div_ceil(TILE),
            rows: height.div_ceil(TILE),
            starts: Vec::new(),
            members: Vec::new(),
        };
        scene.sort(width * SAMPLES, height * SAMPLES);
        scene
    }

    fn corners(&self, triangle: usize) -> [Snapped; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// The tiles (columns and rows) that a triangle may have samples in; empty ranges for none.
    fn tiles(&self, triangle: usize, width: usize, height: usize) -> [std::ops::Range<usize>; 2] {
        let corners = self.corners(triangle);
        let tiles = |values: [i64; 3], count: usize| {
            let [a, b, c] = values;
            let samples = samples_between(a.min(b).min(c), a.max(b).max(c), count);
            if samples.is_empty() {
                0..0
            } else {
                samples.start / SIDE..(samples.end - 1) / SIDE + 1
            }
        };
        let columns = tiles(corners.map(|c| c.x), width);
        let rows = tiles(corners.map(|c| c.y), height);
        [columns, rows]
    }

    /// Sorts the triangles into tiles, in their order.
    fn sort(&mut self, width: usize, height: usize) {
        let mut starts = vec![0; self.columns * self.rows + 1];
        let all: Vec<[std::ops::Range<usize>; 2]> = (0..self.triangles.len())
            .into_par_iter()
            .map(|triangle| self.tiles(triangle, width, height))
            .collect();
        let places = |[columns, rows]: &[std::ops::Range<usize>; 2]| {
            let (columns, stride) = (columns.clone(), self.columns);
            (rows.clone()).flat_map(move |row| columns.clone().map(move |c| row * stride + c))
        };
        for ranges in &all {
            for tile in places(ranges) {
                starts[tile + 1] += 1;
            }
        }
        for tile in 1..starts.len() {
            starts[tile] += starts[tile - 1];
        }
        let mut next = starts.clone();
        let mut members = vec![0; *starts.last().unwrap_or(&0)];
        for (triangle, ranges) in (0u32..).zip(&all) {
            for tile in places(ranges) {
                members[next[tile]] = triangle;
                next[tile] += 1;
            }
        }
        self.starts = starts;
        self.members = members;
    }

    fn members(&self, tile: usize) -> &[u32] {
        &self.members[self.starts[tile]..self.starts[tile + 1]]
    }
}

/// No triangle.
const NONE: u32 = u32::MAX;

/// What the samples of a tile see.
struct Tile {
    /// Place of its left upper sample.
    left: usize,
    top: usize,
    depths: Vec<f64>,
    nearest: Vec<u32>,
}

impl Tile {
    fn new() -> Self {
        Self {
            left: 0,
            top: 0,
            depths: vec![f64::NEG_INFINITY; SIDE * SIDE],
            nearest: vec![NONE; SIDE * SIDE],
        }
    }

    fn clear(&mut self, left: usize, top: usize) {
        (self.left, self.top) = (left, top);
        self.depths.fill(f64::NEG_INFINITY);
        self.nearest.fill(NONE);
    }

    fn draw(&mut self, index: u32, corners: [Snapped; 3]) {
        let Some(triangle) = OnGrid::new(corners) else {
            return;
        };
        let range = |values: [i64; 3], start: usize| {
            let [a, b, c] = values.map(|value| value - start as i64 * STEPS);
            samples_between(a.min(b).min(c), a.max(b).max(c), SIDE)
        };
        let columns = range(corners.map(|c| c.x), self.left);
        let rows = range(corners.map(|c| c.y), self.top);
        let (least, steps) = (triangle.least(), triangle.steps());
        for row in rows {
            let y = middle(self.top + row);
            let mut edges = triangle.edges(middle(self.left + columns.start), y);
            for column in columns.clone() {
                if (0..3).all(|k| edges[k] >= least[k]) {
                    let depth = triangle.depth(edges);
                    let sample = row * SIDE + column;
                    if depth > self.depths[sample] {
                        self.depths[sample] = depth;
                        self.nearest[sample] = index;
                    }
                }
                for k in 0..3 {
                    edges[k] += steps[k];
                }
            }
        }
    }

    /// The pixel in a column and row of the tile.
    fn pixel(
        &self,
        scene: &Scene,
        column: usize,
        row: usize,
        shade: &impl Fn(&Hit) -> Shaded,
    ) -> Pixel {
        let mut light = [0.0; 3];
        let mut normal = [0.0; 3];
        let mut covered = 0.0;
        let mut last: Option<(u32, OnGrid)> = None;
        for down in 0..SAMPLES {
            for right in 0..SAMPLES {
                let [x, y] = [column * SAMPLES + right, row * SAMPLES + down];
                let index = self.nearest[y * SIDE + x];
                if index == NONE {
                    continue;
                }
                if last.as_ref().is_none_or(|(known, _)| *known != index) {
                    let corners = scene.corners(index as usize);
                    last = OnGrid::new(corners).map(|triangle| (index, triangle));
                }
                let Some((_, triangle)) = &last else {
                    continue;
                };
                let [x, y] = [middle(self.left + x), middle(self.top + y)];
                let hit = triangle.hit(index as usize, x, y, scene.with_edges);
                let shaded = shade(&hit);
                covered += 1.0;
                for k in 0..3 {
                    light[k] += shaded.light[k];
                    normal[k] += shaded.normal[k];
                }
            }
        }
        if covered <= 0.0 {
            return Pixel::EMPTY;
        }
        let center = (row * SAMPLES + SAMPLES / 2) * SIDE + column * SAMPLES + SAMPLES / 2;
        let all = (SAMPLES * SAMPLES) as f64;
        Pixel {
            light: light.map(|sum| single(sum / all)),
            coverage: single(covered / all),
            depth: match self.nearest[center] {
                NONE => f32::NAN,
                _ => single(self.depths[center]),
            },
            normal: normal.map(single),
        }
    }
}

/// Draws triangles, their vertices as the camera sees them, in the colours that `shade` gives; it is told the
/// distance to the nearest edge if `with_edges`. Vertices must be finite.
pub(super) fn draw(
    seen: &[Seen],
    triangles: &[[u32; 3]],
    [width, height]: [usize; 2],
    with_edges: bool,
    shade: impl Fn(&Hit) -> Shaded + Sync,
) -> Canvas {
    let mut scene = Scene::new(seen, triangles, width, height);
    scene.with_edges = with_edges;
    let mut pixels = vec![Pixel::EMPTY; width * height];
    let bands = pixels.par_chunks_mut(width * TILE).enumerate();
    bands.for_each_init(Tile::new, |tile, (tile_row, band)| {
        for tile_column in 0..scene.columns {
            let members = scene.members(tile_row * scene.columns + tile_column);
            if members.is_empty() {
                continue;
            }
            tile.clear(tile_column * SIDE, tile_row * SIDE);
            for &index in members {
                tile.draw(index, scene.corners(index as usize));
            }
            for (row, line) in band.chunks_mut(width).enumerate() {
                let part = line.iter_mut().skip(tile_column * TILE).take(TILE);
                for (column, pixel) in part.enumerate() {
                    *pixel = tile.pixel(&scene, column, row, &shade);
                }
            }
        }
    });
    Canvas {
        width,
        height,
        pixels,
    }
}

#[cfg(test)]
mod tests;
