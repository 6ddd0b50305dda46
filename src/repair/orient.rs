//! One orientation for every piece of surface.

use std::collections::VecDeque;

use super::Work;
use super::edges::{HalfEdge, by_edge, half_edges};

/// Turns the faces that disagree with most of their piece of surface; of two halves of the same size, the
/// one without the first face.
pub(super) fn repair(work: &mut Work) {
    let edges = half_edges(work);
    let disagrees = |pair: &[HalfEdge]| pair[0].forward == pair[1].forward;
    let pairs: Vec<&[HalfEdge]> = by_edge(&edges).filter(|edge| edge.len() == 2).collect();
    if !pairs.iter().any(|pair| disagrees(pair)) {
        return;
    }
    let neighbors = Neighbors::new(work.faces.len(), &pairs);
    let mut turned: Vec<Option<bool>> = vec![None; work.faces.len()];
    let mut queue = VecDeque::new();
    let starts: Vec<u32> = work.left().collect();
    for start in starts {
        if turned[start as usize].is_some() {
            continue;
        }
        turned[start as usize] = Some(false);
        queue.push_back(start);
        let mut piece = vec![start];
        while let Some(f) = queue.pop_front() {
            let side = turned[f as usize] == Some(true);
            for (g, disagrees) in neighbors.of(f) {
                if turned[g as usize].is_none() {
                    turned[g as usize] = Some(side != disagrees);
                    queue.push_back(g);
                    piece.push(g);
                }
            }
        }
        let others = piece.iter().filter(|f| turned[**f as usize] == Some(true));
        let minority = 2 * others.count() <= piece.len();
        for f in piece {
            if (turned[f as usize] == Some(true)) == minority {
                work.flipped[f as usize] ^= true;
                work.report.flipped_faces += 1;
            }
        }
    }
    let unresolved = pairs.iter().filter(|pair| {
        let turned = |h: &HalfEdge| turned[h.face as usize] == Some(true);
        disagrees(pair) != (turned(&pair[0]) != turned(&pair[1]))
    });
    work.report.unorientable_edges = unresolved.count();
}

/// For each face, those beside it and whether they disagree with it.
struct Neighbors {
    starts: Vec<usize>,
    items: Vec<(u32, bool)>,
}

impl Neighbors {
    fn new(faces: usize, pairs: &[&[HalfEdge]]) -> Self {
        let mut starts = vec![0usize; faces + 1];
        for half in pairs.iter().copied().flatten() {
            starts[half.face as usize + 1] += 1;
        }
        for f in 0..faces {
            starts[f + 1] += starts[f];
        }
        let mut next = starts.clone();
        let mut items = vec![(0, false); starts[faces]];
        for pair in pairs {
            let disagrees = pair[0].forward == pair[1].forward;
            for (f, g) in [(pair[0].face, pair[1].face), (pair[1].face, pair[0].face)] {
                items[next[f as usize]] = (g, disagrees);
                next[f as usize] += 1;
            }
        }
        Self { starts, items }
    }

    fn of(&self, f: u32) -> impl Iterator<Item = (u32, bool)> {
        let f = f as usize;
        self.items[self.starts[f]..self.starts[f + 1]]
            .iter()
            .copied()
    }
}
