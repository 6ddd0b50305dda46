//! Targets divided into tiles, and the rounds in which tiles are grown.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use super::super::growth::Canvas;
use super::TileError;
use super::nearest_first::nearest_first;

/// No tile.
pub(super) const NONE: u32 = u32::MAX;

/// A part that is within the overlap of one of its vertices is not divided on when what surrounds it has so many times as
/// many vertices as it has itself: smaller parts would hardly need less room.
const MOST_OVERLAP: usize = 16;

/// The targets of a canvas, divided.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Division {
    /// By tile: the vertices that it completes, ascending.
    pub(super) tiles: Vec<Vec<u32>>,
    /// The tiles of each round: none that touch each other.
    pub(super) rounds: Vec<Vec<usize>>,
    /// By tile: its round.
    pub(super) round_of: Vec<usize>,
    /// By target: its tile; [`NONE`] for what no known vertex leads to.
    pub(super) tile_of: Vec<u32>,
}

impl Division {
    /// Halves the targets until each part and what is within `overlap` of it (in the scan's unit, along edges)
    /// are at most half a tile: the other half is for something to copy from.
    ///
    /// # Errors
    /// [`TileError::TooSmall`].
    pub(super) fn new(canvas: &Canvas, tile: usize, overlap: f64) -> Result<Self, TileError> {
        let reached = reached_targets(canvas);
        let parts = if canvas.points.len() <= tile {
            [reached]
                .into_iter()
                .filter(|part| !part.is_empty())
                .collect()
        } else {
            let mut parts = Vec::new();
            halve(canvas, reached, tile, overlap, &mut parts)?;
            parts
        };
        let tiles: Vec<Vec<u32>> = (parts.into_iter())
            .flat_map(|part| with_way_in(canvas, &part))
            .collect();
        let mut tile_of = vec![NONE; canvas.points.len() - canvas.first_target];
        for (k, own) in (0u32..).zip(&tiles) {
            for v in own {
                tile_of[*v as usize - canvas.first_target] = k;
            }
        }
        let touching = touching(canvas, &tiles, &tile_of, overlap);
        let rounds = rounds(&levels(canvas, &tiles, &tile_of), &touching);
        let mut round_of = vec![0; tiles.len()];
        for (number, round) in rounds.iter().enumerate() {
            for k in round {
                round_of[*k] = number;
            }
        }
        Ok(Self {
            tiles,
            rounds,
            round_of,
            tile_of,
        })
    }
}

/// The targets that growth can reach, ascending.
fn reached_targets(canvas: &Canvas) -> Vec<u32> {
    let first = canvas.first_target;
    let mut reached = vec![false; canvas.points.len() - first];
    let mut waiting: Vec<u32> = (0u32..)
        .zip(&canvas.known)
        .filter_map(|(v, known)| known.then_some(v))
        .collect();
    while let Some(v) = waiting.pop() {
        for n in canvas.adjacency.neighbors.row(v as usize) {
            if let Some(target) = (*n as usize).checked_sub(first)
                && !reached[target]
            {
                reached[target] = true;
                waiting.push(*n);
            }
        }
    }
    (index(first)..)
        .zip(reached)
        .filter_map(|(v, reached)| reached.then_some(v))
        .collect()
}

/// The vertices of a part and those within the overlap, nearest first, and at last those next to it that are farther
/// away than that.
pub(super) fn surrounded(canvas: &Canvas, part: &[u32], overlap: f64) -> Vec<u32> {
    let neighbors = &canvas.adjacency.neighbors;
    let mut is_found = vec![false; canvas.points.len()];
    let mut found = Vec::new();
    nearest_first(neighbors, &canvas.relief.feet, part, |v, distance| {
        if distance > overlap {
            return ControlFlow::Break(());
        }
        is_found[v as usize] = true;
        found.push(v);
        ControlFlow::Continue(())
    });
    for v in part {
        for n in neighbors.row(*v as usize) {
            if !std::mem::replace(&mut is_found[*n as usize], true) {
                found.push(*n);
            }
        }
    }
    found
}

/// Divides a part along its longest extent through the median.
fn halve(
    canvas: &Canvas,
    part: Vec<u32>,
    tile: usize,
    overlap: f64,
    parts: &mut Vec<Vec<u32>>,
) -> Result<(), TileError> {
    let room = tile / 2;
    if part.is_empty() {
        return Ok(());
    }
    if part.len() <= room {
        let needed = surrounded(canvas, &part, overlap).len();
        if needed <= room {
            parts.push(part);
            return Ok(());
        }
        // Vertices far from each other have overlaps of their own: halves need less room, however much there is.
        let is_compact = || {
            let mut around = surrounded(canvas, &part[..1], overlap);
            around.sort_unstable();
            part.iter().all(|v| around.binary_search(v).is_ok())
        };
        if part.len() == 1 || (needed > MOST_OVERLAP * part.len() && is_compact()) {
            return Err(TileError::TooSmall {
                tile,
                needed,
                least: 2 * needed,
            });
        }
    }
    let feet = &canvas.relief.feet;
    let first = feet[part[0] as usize];
    let [low, high] = part.iter().fold([first; 2], |[low, high], v| {
        [low.inf(&feet[*v as usize]), high.sup(&feet[*v as usize])]
    });
    let axis = (high - low).imax();
    let mut along = part;
    along.sort_by(|a, b| {
        let [x, y] = [a, b].map(|v| feet[*v as usize][axis]);
        x.total_cmp(&y).then(a.cmp(b))
    });
    let mut second = along.split_off(along.len() / 2);
    along.sort_unstable();
    second.sort_unstable();
    halve(canvas, along, tile, overlap, parts)?;
    halve(canvas, second, tile, overlap, parts)
}

/// The part in pieces that can each be grown as soon as something next to it is known: all that touch the scan
/// together, and each other one on its own.
fn with_way_in(canvas: &Canvas, part: &[u32]) -> Vec<Vec<u32>> {
    let mut touches_scan = Vec::new();
    let mut others = Vec::new();
    let mut seen = vec![false; part.len()];
    for start in 0..part.len() {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let (mut piece, mut touches) = (vec![part[start]], false);
        let mut next = 0;
        while next < piece.len() {
            for n in canvas.adjacency.neighbors.row(piece[next] as usize) {
                touches |= (*n as usize) < canvas.first_target && canvas.known[*n as usize];
                if let Ok(i) = part.binary_search(n)
                    && !std::mem::replace(&mut seen[i], true)
                {
                    piece.push(*n);
                }
            }
            next += 1;
        }
        piece.sort_unstable();
        if touches {
            touches_scan.extend(piece);
        } else {
            others.push(piece);
        }
    }
    touches_scan.sort_unstable();
    let touching = [touches_scan].into_iter().filter(|piece| !piece.is_empty());
    touching.chain(others).collect()
}

/// For each tile those that have targets within its overlap, or next to it.
fn touching(
    canvas: &Canvas,
    tiles: &[Vec<u32>],
    tile_of: &[u32],
    overlap: f64,
) -> Vec<BTreeSet<usize>> {
    let mut touching = vec![BTreeSet::new(); tiles.len()];
    if tiles.len() < 2 {
        return touching;
    }
    for (k, own) in tiles.iter().enumerate() {
        for v in surrounded(canvas, own, overlap) {
            let target = (v as usize).checked_sub(canvas.first_target);
            let other = target.map_or(NONE, |target| tile_of[target]);
            if other != NONE && other as usize != k {
                touching[k].insert(other as usize);
                touching[other as usize].insert(k);
            }
        }
    }
    touching
}

/// The tiles by how many tiles lie between them and the scan.
fn levels(canvas: &Canvas, tiles: &[Vec<u32>], tile_of: &[u32]) -> Vec<Vec<usize>> {
    let beside = |k: usize| {
        (tiles[k].iter()).flat_map(|v| canvas.adjacency.neighbors.row(*v as usize).iter().copied())
    };
    let is_scanned = |v: u32| (v as usize) < canvas.first_target && canvas.known[v as usize];
    let (mut level, mut left): (Vec<usize>, Vec<usize>) =
        (0..tiles.len()).partition(|k| beside(*k).any(is_scanned));
    let mut levels = Vec::new();
    while !level.is_empty() {
        let mut is_last = vec![false; tiles.len()];
        for k in &level {
            is_last[*k] = true;
        }
        let is_next = |k: &usize| {
            beside(*k).any(|v| {
                let target = (v as usize).checked_sub(canvas.first_target);
                let tile = target.map_or(NONE, |target| tile_of[target]);
                tile != NONE && is_last[tile as usize]
            })
        };
        let (next, rest) = left.into_iter().partition(is_next);
        left = rest;
        levels.push(std::mem::replace(&mut level, next));
    }
    debug_assert!(left.is_empty(), "something leads to every tile");
    levels
}

/// Rounds level by level; within a level each tile goes to the first round in which nothing touches it.
fn rounds(levels: &[Vec<usize>], touching: &[BTreeSet<usize>]) -> Vec<Vec<usize>> {
    let mut rounds: Vec<Vec<usize>> = Vec::new();
    for level in levels {
        let begin = rounds.len();
        for k in level {
            let is_free = |round: &Vec<usize>| !round.iter().any(|j| touching[*k].contains(j));
            match rounds[begin..].iter().position(is_free) {
                Some(round) => rounds[begin + round].push(*k),
                None => rounds.push(vec![*k]),
            }
        }
    }
    rounds
}

fn index(v: usize) -> u32 {
    u32::try_from(v).expect("vertex indices are u32")
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::mesh::{Adjacency, TriMesh};
    use crate::relief::Relief;
    use nalgebra::{Point3, Vector3};

    const SIDE: u32 = 40;

    /// A flat sheet of scanned vertices around a square of `width` by `width` targets in its middle.
    pub(in super::super) fn sheet(width: u32) -> Canvas {
        let low = (SIDE - width) / 2;
        sheet_with(|at| at.iter().all(|x| (low..low + width).contains(x)))
    }

    /// A flat sheet of scanned vertices and targets, by their places.
    pub(in super::super) fn sheet_with(is_target: impl Fn([u32; 2]) -> bool) -> Canvas {
        let mut order: Vec<u32> = (0..SIDE * SIDE).collect();
        order.sort_by_key(|v| is_target([v % SIDE, v / SIDE]));
        let mut number = vec![0; order.len()];
        for (new, old) in (0u32..).zip(&order) {
            number[*old as usize] = new;
        }
        let at = |v: &u32| Point3::new(f64::from(v % SIDE), f64::from(v / SIDE), 0.0);
        let cells = (0..SIDE * (SIDE - 1)).filter(|v| v % SIDE < SIDE - 1);
        let triangles = cells.flat_map(|a| {
            [[a, a + 1, a + SIDE + 1], [a, a + SIDE + 1, a + SIDE]]
                .map(|t| t.map(|v| number[v as usize]))
        });
        let mesh = TriMesh {
            triangles: triangles.collect(),
            positions: order.iter().map(at).collect(),
        };
        let is_scanned = |v: &u32| !is_target([v % SIDE, v / SIDE]);
        let first_target = order.partition_point(is_scanned);
        Canvas {
            adjacency: Adjacency::new(&mesh),
            points: mesh.positions.clone(),
            triangles: mesh.triangles,
            colors: None,
            known: (0..order.len()).map(|v| v < first_target).collect(),
            first_target,
            relief: Relief {
                normals: vec![Vector3::z(); order.len()],
                heights: vec![0.0; order.len()],
                feet: mesh.positions,
                side: 1.0,
            },
        }
    }

    #[test]
    fn every_target_is_in_one_tile_and_tiles_of_a_round_do_not_touch() {
        let canvas = sheet(30);
        let division = Division::new(&canvas, 400, 2.0).unwrap();
        let mut all: Vec<u32> = division.tiles.iter().flatten().copied().collect();
        all.sort_unstable();
        let targets = index(canvas.first_target)..index(canvas.points.len());
        assert_eq!(all, targets.collect::<Vec<u32>>());
        assert!(division.tiles.len() >= 9, "{}", division.tiles.len());
        for (k, own) in division.tiles.iter().enumerate() {
            let around = surrounded(&canvas, own, 2.0);
            assert!(around.len() <= 200, "{}", around.len());
            for v in around
                .iter()
                .filter(|v| **v as usize >= canvas.first_target)
            {
                let other = division.tile_of[*v as usize - canvas.first_target] as usize;
                let same_round = division.round_of[other] == division.round_of[k];
                assert!(other == k || !same_round, "{k} and {other}");
            }
        }
    }

    #[test]
    fn every_tile_goes_on_from_the_scan_or_from_a_tile_before() {
        let canvas = sheet(30);
        let division = Division::new(&canvas, 400, 2.0).unwrap();
        let mut inner = 0;
        for (k, own) in division.tiles.iter().enumerate() {
            let beside =
                || (own.iter()).flat_map(|v| canvas.adjacency.neighbors.row(*v as usize).iter());
            let touches_scan = beside().any(|v| (*v as usize) < canvas.first_target);
            let goes_on = beside().any(|v| {
                let target = (*v as usize).checked_sub(canvas.first_target);
                target.is_some_and(|target| {
                    let other = division.tile_of[target] as usize;
                    division.round_of[other] < division.round_of[k]
                })
            });
            assert!(touches_scan || goes_on, "tile {k}");
            if !touches_scan {
                inner += 1;
                // All that touch the scan were grown before.
                let earlier = &division.rounds[..division.round_of[k]];
                assert!(earlier.iter().flatten().count() >= 4);
            }
        }
        assert!(inner > 0, "a tile in the middle is what this is about");
    }

    #[test]
    fn what_nothing_known_leads_to_is_in_no_tile() {
        let mut canvas = sheet(10);
        canvas.known.fill(false);
        let division = Division::new(&canvas, 400, 2.0).unwrap();
        assert!(division.tiles.is_empty() && division.rounds.is_empty());
        assert!(division.tile_of.iter().all(|tile| *tile == NONE));
    }

    #[test]
    fn pieces_away_from_the_scan_are_tiles_of_their_own() {
        let canvas = sheet(20);
        // A target at the rim, one next to it, and one in the middle of the hole.
        let rim = index(canvas.first_target);
        let middle = rim + 20 * 10 + 10;
        let pieces = with_way_in(&canvas, &[rim, rim + 1, middle]);
        assert_eq!(pieces, [vec![rim, rim + 1], vec![middle]]);
    }

    #[test]
    fn small_holes_far_apart_need_no_larger_tile_than_one_of_them() {
        // Ten pinholes eight edges apart.
        let canvas = sheet_with(|[x, y]| x % 8 == 4 && (y == 12 || y == 28));
        assert_eq!(canvas.points.len() - canvas.first_target, 10);
        let one = surrounded(&canvas, &[index(canvas.first_target)], 3.0).len();
        assert!(10 * one > MOST_OVERLAP * 10, "{one}");
        let division = Division::new(&canvas, 2 * one, 3.0).unwrap();
        assert_eq!((division.tiles.len(), division.rounds.len()), (10, 1));
        let two = Division::new(&canvas, 4 * one, 3.0).unwrap();
        // Five in each half, two or three in each half of these, of which three are too many.
        assert_eq!(two.tiles.len(), 6);
        let error = Division::new(&canvas, 2 * one - 1, 3.0).unwrap_err();
        assert!(
            matches!(error, TileError::TooSmall { least, .. } if least == 2 * one),
            "{error}"
        );
    }

    #[test]
    fn tiles_that_are_all_overlap_are_refused() {
        let canvas = sheet(30);
        let error = Division::new(&canvas, 400, 15.0).unwrap_err();
        assert!(
            matches!(error, TileError::TooSmall { tile: 400, least, .. } if least > 400),
            "{error}"
        );
    }
}
