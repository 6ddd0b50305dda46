//! Faces that stick out of the rim: points that the sensor mixed from near and far, and ears folded back.

use std::collections::HashMap;

use crate::mesh::Csr;

use super::Work;
use super::edges::{by_edge, half_edges};
use super::manifold::unit_normal;

/// A vertex at the rim is a spike's tip if all its edges are longer than this many times the median edge
/// of the surface that it sticks out of. On nine real scans, 4 finds none, but 1 face on one range grid, 7 on
/// another, and 118 of 286 000 on a third that is full of depth jumps.
const LONG: f64 = 4.0;
/// A tip has at most this many faces.
const MOST_FACES: usize = 3;
/// An ear is folded back if its normal and that of the face behind it are more than 120° apart.
const FOLDED: f64 = -0.5;
/// Spikes may stand on spikes.
const MOST_ROUNDS: usize = 4;

/// Removes spikes and gives the number of their faces.
pub(super) fn remove(work: &mut Work) -> usize {
    let mut removed = 0;
    for _ in 0..MOST_ROUNDS {
        let found = find(work);
        if found.is_empty() {
            break;
        }
        for f in &found {
            work.kept[*f as usize] = false;
        }
        removed += found.len();
    }
    removed
}

/// The faces of all spikes, ascending.
fn find(work: &Work) -> Vec<u32> {
    let edges = half_edges(work);
    let mut on_rim = vec![false; work.positions.len()];
    for edge in by_edge(&edges).filter(|edge| edge.len() == 1) {
        on_rim[edge[0].low as usize] = true;
        on_rim[edge[0].high as usize] = true;
    }
    let pairs = work
        .left()
        .flat_map(|f| work.corners(f).map(move |v| (v, f)));
    let faces_at = Csr::from_pairs(work.positions.len(), pairs);
    let mut found = Vec::new();
    let mut lengths = Lengths::default();
    for (tip, on_rim) in (0u32..).zip(&on_rim) {
        let faces = faces_at.row(tip as usize);
        if *on_rim && (1..=MOST_FACES).contains(&faces.len()) {
            let ear = Ear {
                work,
                faces_at: &faces_at,
                tip,
                faces,
            };
            if ear.is_needle(&mut lengths) || ear.is_folded_back() {
                found.extend_from_slice(faces);
            }
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// A vertex at the rim with few faces.
struct Ear<'a> {
    work: &'a Work<'a>,
    faces_at: &'a Csr,
    tip: u32,
    faces: &'a [u32],
}

impl Ear<'_> {
    /// The vertices that an edge of the ear's faces joins with its tip.
    fn base(&self) -> Vec<u32> {
        let mut base: Vec<u32> = self
            .faces
            .iter()
            .flat_map(|f| sides(self.work, *f))
            .filter_map(|[a, b]| match self.tip {
                tip if tip == a => Some(b),
                tip if tip == b => Some(a),
                _ => None,
            })
            .collect();
        base.sort_unstable();
        base.dedup();
        base
    }

    fn is_needle(&self, lengths: &mut Lengths) -> bool {
        let base = self.base();
        let to_tip = |v: &u32| length(self.work, [self.tip, *v]);
        let Some(shortest) = base.iter().map(to_tip).min_by(f64::total_cmp) else {
            return false;
        };
        // The median is short if more than half of the sides around are: counted, not selected, for a
        // vertex may be the base of thousands of tips.
        let is_short = |side: &f64| LONG * side < shortest;
        let (mut around, mut short) = (0, 0);
        for v in &base {
            let sides = lengths.at(self.work, self.faces_at, *v);
            around += sides.len();
            short += sides.partition_point(is_short);
        }
        for face in self.faces {
            let own: Vec<f64> = sides(self.work, *face)
                .map(|side| length(self.work, side))
                .collect();
            let at_base = |v: &u32| base.binary_search(v).is_ok();
            let times = self.work.corners(*face).filter(at_base).count();
            around -= times * own.len();
            short -= times * own.iter().filter(|side| is_short(side)).count();
        }
        short > around / 2
    }

    /// Whether it is one face, and that lies upon the face behind it.
    fn is_folded_back(&self) -> bool {
        let [face] = *self.faces else {
            return false;
        };
        let base = self.base();
        let [a, b] = *base.as_slice() else {
            return false;
        };
        // The faces at both, looked for where there are fewer.
        let [a, b] = [a, b].map(|v| (self.faces_at.row(v as usize), v));
        let ((fewer, _), (_, other)) = if a.0.len() <= b.0.len() {
            (a, b)
        } else {
            (b, a)
        };
        let behind = fewer
            .iter()
            .find(|f| **f != face && self.work.corners(**f).any(|v| v == other));
        behind.is_some_and(|behind| {
            unit_normal(self.work, face).dot(&unit_normal(self.work, *behind)) < FOLDED
        })
    }
}

/// The edges of a face.
fn sides(work: &Work, face: u32) -> impl Iterator<Item = [u32; 2]> {
    let corners = work.corners(face);
    let ahead = corners.clone().cycle().skip(1);
    corners.zip(ahead).map(|(a, b)| [a, b])
}

fn length(work: &Work, [a, b]: [u32; 2]) -> f64 {
    (work.point(a) - work.point(b)).norm()
}

/// For each vertex that was asked for, the lengths of all sides of the faces at it, ascending.
#[derive(Default)]
struct Lengths(HashMap<u32, Vec<f64>>);

impl Lengths {
    fn at(&mut self, work: &Work, faces_at: &Csr, v: u32) -> &[f64] {
        self.0.entry(v).or_insert_with(|| {
            let faces = faces_at.row(v as usize).iter();
            let mut lengths: Vec<f64> = faces
                .flat_map(|f| sides(work, *f))
                .map(|side| length(work, side))
                .collect();
            lengths.sort_unstable_by(f64::total_cmp);
            lengths
        })
    }
}
