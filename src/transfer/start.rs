//! Which field the coarsest level begins with.

use std::f32::consts::TAU;

use crate::mesh::TriMesh;
use crate::rng::{Rng, Stage};

use super::TransferError;
use super::descriptors::{SPOKES, turn_of};
use super::field::{Match, Pairing};
use super::ground::number;
use super::hierarchy::Hierarchy;
use super::ready::Ready;

/// A given map, if there is one.
#[derive(Debug)]
pub(super) struct Start {
    /// By vertex of the target's finest level: the vertex of the source's.
    map: Option<Vec<Option<u32>>>,
}

pub(super) fn check(
    map: Option<&[Option<u32>]>,
    source: &TriMesh,
    target: &TriMesh,
) -> Result<(), TransferError> {
    let Some(map) = map else { return Ok(()) };
    let (given, vertices) = (map.len(), target.positions.len());
    if given != vertices {
        return Err(TransferError::MapLength { given, vertices });
    }
    let sources = source.positions.len();
    if let Some((target, source)) = (map.iter().enumerate())
        .find_map(|(t, s)| s.filter(|s| *s as usize >= sources).map(|s| (t, s)))
    {
        return Err(TransferError::MapRange {
            target,
            source_vertex: source,
            vertices: sources,
        });
    }
    if map.iter().all(Option::is_none) {
        return Err(TransferError::MapEmpty);
    }
    Ok(())
}

impl Start {
    pub(super) fn new(
        map: Option<&[Option<u32>]>,
        [source, target]: [&Ready; 2],
        standing: &[u32],
    ) -> Self {
        let map = map.map(|map| {
            let nearest = source.nearest();
            let of_given = |v: u32| map[v as usize].map(|s| standing[nearest[s as usize] as usize]);
            // A vertex put on an edge begins where one of its ends does.
            (0u32..)
                .take(target.vertices.len())
                .map(|v| of_given(target.given_vertex(v)))
                .collect()
        });
        Self { map }
    }

    /// The field of the coarsest level: at random, or by the map.
    pub(super) fn field(&self, pairing: &Pairing, of_target: &Hierarchy, seed: u32) -> Vec<Match> {
        let mut rng = Rng::new(seed, Stage::Transfer, 0);
        let anywhere = |rng: &mut Rng| loop {
            let source = number(rng.index(pairing.source.len()));
            if pairing.is_allowed(source) {
                return source;
            }
        };
        let mut field: Vec<Match> = (0..pairing.target.len())
            .map(|_| Match::new(anywhere(&mut rng), rng.index(SPOKES), f32::INFINITY))
            .collect();
        if let Some(map) = &self.map {
            let mapped = coarse_map(map, pairing, of_target);
            for (v, found) in (0u32..).zip(&mut field) {
                if let Some(source) = mapped[v as usize] {
                    let turn = turn_of(rotation(pairing, &mapped, v, source));
                    *found = Match::new(source, turn, f32::INFINITY);
                }
            }
        }
        field
    }

    pub(super) fn is_given(&self) -> bool {
        self.map.is_some()
    }
}

/// A map of the finest level on the coarsest: what the first of a vertex's descendants that has a place is mapped to.
fn coarse_map(map: &[Option<u32>], pairing: &Pairing, of_target: &Hierarchy) -> Vec<Option<u32>> {
    let mut mapped: Vec<Option<u32>> = vec![None; pairing.target.len()];
    for (v, source) in map.iter().enumerate() {
        let Some(source) = source else { continue };
        let (mut t, mut s) = (number(v), *source);
        for level in 0..pairing.level {
            t = of_target.parents[level][t as usize];
            s = pairing.hierarchy.parents[level][s as usize];
        }
        let own = &mut mapped[t as usize];
        if own.is_none() && pairing.is_allowed(s) {
            *own = Some(s);
        }
    }
    mapped
}

/// The angle by which the map turns the directions to a vertex's neighbors, on average.
fn rotation(pairing: &Pairing, mapped: &[Option<u32>], v: u32, source: u32) -> f32 {
    let (mut x, mut y) = (0.0f32, 0.0f32);
    for next in pairing.target.charts.next(v) {
        let Some(theirs) = mapped[next.vertex as usize] else {
            continue;
        };
        let way = pairing.source.position(theirs) - pairing.source.position(source);
        let (angle, length) = pairing.source.polar(source, &way);
        let (sin, cos) = (angle - next.angle).sin_cos();
        x += cos * length;
        y += sin * length;
    }
    y.atan2(x).rem_euclid(TAU)
}

#[cfg(test)]
mod tests;
