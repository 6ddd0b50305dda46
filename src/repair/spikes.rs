//! Faces that stick out of the rim: points that the sensor mixed from near and far, and ears folded back.

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
    for (tip, on_rim) in (0u32..).zip(&on_rim) {
        let faces = faces_at.row(tip as usize);
        if *on_rim && (1..=MOST_FACES).contains(&faces.len()) {
            let ear = Ear {
                work,
                faces_at: &faces_at,
                tip,
                faces,
            };
            if ear.is_needle() || ear.is_folded_back() {
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

    fn is_needle(&self) -> bool {
        let base = self.base();
        let length = |[a, b]: [u32; 2]| (self.work.point(a) - self.work.point(b)).norm();
        let mut around: Vec<f64> = base
            .iter()
            .flat_map(|v| self.faces_at.row(*v as usize))
            .filter(|f| !self.faces.contains(f))
            .flat_map(|f| sides(self.work, *f).map(length))
            .collect();
        if around.is_empty() {
            return false;
        }
        let middle = around.len() / 2;
        let (_, median, _) = around.select_nth_unstable_by(middle, f64::total_cmp);
        let long = LONG * *median;
        base.iter().all(|v| length([self.tip, *v]) > long)
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
        let behind = self
            .faces_at
            .row(a as usize)
            .iter()
            .find(|f| **f != face && self.faces_at.row(b as usize).contains(f));
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
