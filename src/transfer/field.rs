//! The nearest-neighbor field of a level: for each vertex of the target a vertex of the source, and a rotation.
//!
//! # Reference
//! [MeshMatch 2012](crate::bibliography#meshmatch-2012), §5; [PatchMatch 2009](crate::bibliography#patchmatch-2009), §3.

use std::f32::consts::PI;
use std::ops::Range;

use pulp::Arch;
use rayon::prelude::*;

use crate::mesh::spatial_order;
use crate::rng::{Rng, Stage};

use super::descriptors::{Descriptors, Query, SPOKES, angle_of, turn_of};
use super::ground::{Ground, numbers};
use super::hierarchy::Hierarchy;
use super::{AuditReport, Rotations};

/// Targets that are gone through one after the other, each hearing what the one before it found. A fixed number, so that
/// the result does not depend on the number of threads.
const CHUNK: usize = 512;

/// What is used much is told by vertices this many levels up.
const OVERUSE_LEVELS: usize = 2;

/// Relatives tried on each level of the tree.
const DRAWS: usize = 2;

/// So many of the vertices tried last are not tried again.
const TRIED: usize = 4;

/// Rotations tried at a vertex that nothing leads to, where not all are.
const TRIED_ROTATIONS: usize = 2;

/// What belongs to a vertex of the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Match {
    /// The vertex of the source.
    pub(super) source: u32,
    /// A direction of angle θ here has the angle θ + 2π `turn` / 18 there.
    pub(super) turn: u8,
    pub(super) cost: f32,
}

impl Match {
    pub(super) fn new(source: u32, turn: usize, cost: f32) -> Self {
        let turn = u8::try_from(turn).expect("one of 18");
        Self { source, turn, cost }
    }

    pub(super) fn angle(&self) -> f32 {
        angle_of(usize::from(self.turn))
    }
}

/// A level of source and target.
#[derive(Clone, Copy)]
pub(super) struct Pairing<'a> {
    pub(super) target: &'a Ground,
    pub(super) source: &'a Ground,
    pub(super) hierarchy: &'a Hierarchy,
    /// Which of the source's levels it is.
    pub(super) level: usize,
    /// Lengths of the source over those of the target.
    pub(super) ratio: f32,
    /// By vertex of the source whether it may be copied; empty if all may.
    pub(super) allowed: &'a [bool],
    /// By vertex of the target whether its match stays; empty if none does.
    pub(super) pinned: &'a [bool],
}

impl Pairing<'_> {
    pub(super) fn is_allowed(&self, source: u32) -> bool {
        self.allowed.get(source as usize).copied().unwrap_or(true)
    }

    pub(super) fn is_pinned(&self, target: u32) -> bool {
        self.pinned.get(target as usize).copied().unwrap_or(false)
    }
}

/// What is searched for: by cost, less what continues a neighbor's match is worth, plus the penalty of what is used much.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) of_target: &'a Descriptors,
    pub(super) of_source: &'a Descriptors,
    pub(super) rotations: Rotations,
    /// Share of the cost that a match is spared if it continues that of a neighbor.
    pub(super) coherence: f32,
    /// Penalty of a source that is used twice as often as others.
    pub(super) overuse: f32,
    pub(super) seed: u32,
}

/// An order in which the target's vertices are gone through, in chunks: along a curve that fills space, within a
/// chunk breadth-first.
#[derive(Debug)]
pub(super) struct Order {
    vertices: Vec<u32>,
    place: Vec<u32>,
}

impl Order {
    pub(super) fn new(ground: &Ground) -> Self {
        let count = u32::try_from(ground.len()).expect("vertices are u32");
        let mut vertices = spatial_order(ground.surface.positions(), (0..count).collect());
        let mut chunk_of = vec![0u32; vertices.len()];
        for (chunk, members) in (0u32..).zip(vertices.chunks(CHUNK)) {
            for v in members {
                chunk_of[*v as usize] = chunk;
            }
        }
        let mut reached = vec![false; vertices.len()];
        for (chunk, members) in (0u32..).zip(vertices.chunks_mut(CHUNK)) {
            let mut order: Vec<u32> = Vec::with_capacity(members.len());
            for start in members.iter() {
                if std::mem::replace(&mut reached[*start as usize], true) {
                    continue;
                }
                let mut at = order.len();
                order.push(*start);
                while let Some(v) = order.get(at).copied() {
                    at += 1;
                    for next in ground.charts.next(v) {
                        let w = next.vertex as usize;
                        if chunk_of[w] == chunk && !std::mem::replace(&mut reached[w], true) {
                            order.push(next.vertex);
                        }
                    }
                }
            }
            members.copy_from_slice(&order);
        }
        let mut place = vec![0; vertices.len()];
        for (i, v) in (0u32..).zip(&vertices) {
            place[*v as usize] = i;
        }
        Self { vertices, place }
    }
}

/// The costs of the field's own matches, in their rotations.
pub(super) fn rated(
    pairing: &Pairing,
    of_target: &Descriptors,
    of_source: &Descriptors,
    field: &mut [Match],
) {
    let arch = Arch::new();
    (field.par_chunks_mut(CHUNK).enumerate()).for_each(|(chunk, found)| {
        let mut query = Query::default();
        let first = u32::try_from(chunk * CHUNK).expect("vertices are u32");
        for (v, found) in (first..).zip(found) {
            if pairing.is_pinned(v) {
                found.cost = 0.0;
                continue;
            }
            query.set(of_target, v);
            let (source, turn) = (found.source, usize::from(found.turn));
            found.cost = arch.dispatch(
                #[inline(always)]
                || query.cost(of_source, source, turn, f32::INFINITY),
            );
        }
    });
}

/// One round of propagation and random search. The field's costs must be those of the descriptors.
pub(super) fn improved(
    pairing: &Pairing,
    order: &Order,
    field: &[Match],
    search: &Search,
    round: u32,
) -> Vec<Match> {
    let searching = Searching {
        pairing,
        order,
        field,
        search,
        round,
        penalties: penalties(pairing, field, search.overuse),
        arch: Arch::new(),
    };
    let found: Vec<Match> = (0..order.vertices.len().div_ceil(CHUNK))
        .into_par_iter()
        .flat_map_iter(|chunk| searching.go_through(chunk))
        .collect();
    order.place.iter().map(|i| found[*i as usize]).collect()
}

/// By vertex of the source: the penalty for how much more than others it, and what is next to it in the tree, are used;
/// empty if there is none.
fn penalties(pairing: &Pairing, field: &[Match], overuse: f32) -> Vec<f32> {
    if overuse <= 0.0 {
        return Vec::new();
    }
    let parents = &pairing.hierarchy.parents;
    let top = parents.len().min(pairing.level + OVERUSE_LEVELS);
    let ancestor = |source: u32| {
        (parents[pairing.level..top].iter()).fold(source, |s, parents| parents[s as usize])
    };
    let of_source: Vec<u32> = numbers(pairing.source.len()).map(ancestor).collect();
    let mut sizes = vec![0.0f32; pairing.hierarchy.levels[top].positions.len()];
    let mut uses = sizes.clone();
    for ancestor in &of_source {
        sizes[*ancestor as usize] += 1.0;
    }
    for found in field {
        uses[of_source[found.source as usize] as usize] += 1.0;
    }
    let usual = field.len() as f32 / pairing.source.len() as f32;
    (of_source.iter())
        .map(|a| uses[*a as usize] / (sizes[*a as usize] * usual))
        .map(|times| overuse * (times - 1.0).max(0.0))
        .collect()
}

/// For some vertices of the target the best of all vertices of the source; what they have already, if that is as good.
pub(super) fn exhaustive(
    pairing: &Pairing,
    of_target: &Descriptors,
    of_source: &Descriptors,
    field: &[Match],
    vertices: &[u32],
) -> Vec<Match> {
    let arch = Arch::new();
    let sources = u32::try_from(pairing.source.len()).expect("vertices are u32");
    (vertices.par_iter())
        .map_init(Query::default, |query, v| {
            let mut best = field[*v as usize];
            query.set(of_target, *v);
            let query = &*query;
            for source in (0..sources).filter(|s| pairing.is_allowed(*s)) {
                offer(&arch, query, of_source, source, &mut best);
            }
            best
        })
        .collect()
}

/// Compares the matches of about `count` vertices, spread over the target, with the best that there are.
pub(super) fn audited(
    pairing: &Pairing,
    of_target: &Descriptors,
    of_source: &Descriptors,
    field: &[Match],
    count: usize,
) -> AuditReport {
    let free: Vec<u32> = numbers(field.len())
        .filter(|v| !pairing.is_pinned(*v))
        .step_by((field.len() / count).max(1))
        .collect();
    let least = exhaustive(pairing, of_target, of_source, field, &free);
    let mean = |costs: f64| costs / free.len().max(1) as f64;
    AuditReport {
        vertices: free.len(),
        mean_cost: mean(
            (free.iter())
                .map(|v| f64::from(field[*v as usize].cost))
                .sum(),
        ),
        least_cost: mean(least.iter().map(|m| f64::from(m.cost)).sum()),
    }
}

/// Share of the edges along which the field goes on: the match of one end leads to that of the other, or next to it.
pub(super) fn coherent_edges(pairing: &Pairing, field: &[Match]) -> f64 {
    let Pairing {
        target,
        source,
        ratio,
        ..
    } = *pairing;
    let counts = numbers(field.len()).into_par_iter().map(|v| {
        let own = field[v as usize];
        let mut counts = [0u64; 2];
        for next in target.charts.next(v).filter(|next| next.vertex > v) {
            counts[1] += 1;
            let way = next.angle + own.angle();
            let ahead = source.vertex_towards(own.source, way, next.length * ratio);
            let theirs = field[next.vertex as usize].source;
            let is_near =
                |s: u32| s == theirs || source.charts.next(s).any(|next| next.vertex == theirs);
            counts[0] += u64::from(ahead.is_some_and(|(s, _)| is_near(s)));
        }
        counts
    });
    let [coherent, all] = counts.reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    coherent as f64 / all.max(1) as f64
}

/// Takes a vertex in its best rotation if that costs less.
#[inline]
fn offer(arch: &Arch, query: &Query, of_source: &Descriptors, source: u32, best: &mut Match) {
    let limit = best.cost;
    let (turn, cost) = arch.dispatch(
        #[inline(always)]
        || query.best(of_source, source, limit),
    );
    if cost < best.cost {
        *best = Match::new(source, turn, cost);
    }
}

struct Searching<'a> {
    pairing: &'a Pairing<'a>,
    order: &'a Order,
    /// Of the last round.
    field: &'a [Match],
    search: &'a Search<'a>,
    round: u32,
    penalties: Vec<f32>,
    arch: Arch,
}

/// The best match so far.
struct Best {
    found: Match,
    /// What it is worth, with coherence and penalty: the less the better.
    worth: f32,
    /// What was tried last: where the field goes on, all neighbors lead to the same.
    tried: [Option<(u32, Option<usize>)>; TRIED],
}

impl Best {
    /// Whether a vertex (in a rotation, if not in all) is among those tried last; from now on it is.
    fn was_tried(&mut self, what: (u32, Option<usize>)) -> bool {
        if self.tried.contains(&Some(what)) {
            return true;
        }
        self.tried.rotate_right(1);
        self.tried[0] = Some(what);
        false
    }
}

impl Searching<'_> {
    /// One round over a chunk of the order.
    fn go_through(&self, chunk: usize) -> Vec<Match> {
        let vertices = &self.order.vertices;
        let span = chunk * CHUNK..vertices.len().min((chunk + 1) * CHUNK);
        let mut found: Vec<Match> = (vertices[span.clone()].iter())
            .map(|v| self.field[*v as usize])
            .collect();
        let part = self.round << 8 | u32::try_from(self.pairing.level).expect("a few levels");
        let chunk = u32::try_from(chunk).expect("fewer chunks than vertices");
        let mut rng = Rng::of_part(self.search.seed, Stage::Transfer, part, chunk);
        let mut query = Query::default();
        for i in 0..found.len() {
            let i = if self.round.is_multiple_of(2) {
                i
            } else {
                found.len() - 1 - i
            };
            let v = vertices[span.start + i];
            if self.pairing.is_pinned(v) {
                continue;
            }
            query.set(self.search.of_target, v);
            let mut best = Best {
                found: found[i],
                worth: found[i].cost + self.penalty(found[i].source),
                tried: [None; TRIED],
            };
            self.propagate(v, &span, &found, &query, &mut best);
            self.draw(&query, &mut best, &mut rng);
            found[i] = best.found;
        }
        found
    }

    fn penalty(&self, source: u32) -> f32 {
        self.penalties.get(source as usize).copied().unwrap_or(0.0)
    }

    /// Tries what continues the matches of the neighbors: those of this round (`found`) in the own chunk, those of the
    /// last elsewhere.
    fn propagate(
        &self,
        v: u32,
        span: &Range<usize>,
        found: &[Match],
        query: &Query,
        best: &mut Best,
    ) {
        let Pairing {
            target,
            source,
            ratio,
            ..
        } = *self.pairing;
        let spared = 1.0 - self.search.coherence;
        for next in target.charts.next(v) {
            let at = self.order.place[next.vertex as usize] as usize;
            let theirs = if span.contains(&at) {
                found[at - span.start]
            } else {
                self.field[next.vertex as usize]
            };
            let back = next.angle + next.transport + PI;
            let way = back + theirs.angle();
            let Some((candidate, angle)) =
                source.vertex_towards(theirs.source, way, next.length * ratio)
            else {
                continue;
            };
            if candidate == best.found.source {
                let worth = best.found.cost * spared + self.penalty(candidate);
                best.worth = worth.min(best.worth);
            }
            // Here the way goes on at the angle to the neighbor and a half turn.
            let turn = turn_of(angle - (next.angle + PI));
            self.offer(candidate, turn, query, best, spared);
        }
    }

    /// Tries vertices far and near: relatives of the match in the tree.
    fn draw(&self, query: &Query, best: &mut Best, rng: &mut Rng) {
        let Pairing {
            hierarchy, level, ..
        } = *self.pairing;
        let from = best.found.source;
        let random_turns = match self.search.rotations {
            Rotations::All => 0,
            Rotations::Search => TRIED_ROTATIONS,
        };
        let levels = hierarchy.parents.len() - level;
        for up in (1..=levels).rev().flat_map(|up| [up; DRAWS]) {
            let candidate = hierarchy.relative(level, from, up, rng);
            self.offer(candidate, usize::from(best.found.turn), query, best, 1.0);
            for _ in 0..random_turns {
                self.offer(candidate, rng.index(SPOKES), query, best, 1.0);
            }
        }
        if self.search.rotations == Rotations::Search {
            // The match itself, turned a little and at random.
            let turn = usize::from(best.found.turn);
            for turn in [turn + 1, turn + SPOKES - 1, rng.index(SPOKES)] {
                self.offer(best.found.source, turn % SPOKES, query, best, 1.0);
            }
        }
    }

    /// Takes a vertex if it is worth more, in the given rotation or, where all are compared, in the best one; of its cost
    /// the share `counted` counts.
    #[inline]
    fn offer(&self, source: u32, turn: usize, query: &Query, best: &mut Best, counted: f32) {
        if !self.pairing.is_allowed(source) {
            return;
        }
        let what = match self.search.rotations {
            Rotations::All => (source, None),
            Rotations::Search => (source, Some(turn)),
        };
        if best.was_tried(what) {
            return;
        }
        let penalty = self.penalty(source);
        let limit = (best.worth - penalty) / counted;
        if limit <= 0.0 {
            return;
        }
        let (turn, cost) = self.arch.dispatch(
            #[inline(always)]
            || match self.search.rotations {
                Rotations::All => query.best(self.search.of_source, source, limit),
                Rotations::Search => {
                    let cost = query.cost(self.search.of_source, source, turn, limit);
                    (turn, cost)
                }
            },
        );
        if cost < limit {
            best.found = Match::new(source, turn, cost);
            best.worth = cost * counted + penalty;
        }
    }
}

#[cfg(test)]
mod tests;
