//! Edges at which more than two faces meet.

use nalgebra::Vector3;

use super::Work;
use super::edges::{HalfEdge, by_edge, half_edges};
use crate::mesh::{DisjointSets, vector_area};

/// At an edge with more faces than this, only those of the largest pieces are compared by pairs.
const MOST_COMPARED: usize = 16;

/// Keeps two faces at every edge: two that run along it in opposite directions, if there are such, of the
/// largest pieces of surface, and as level with each other as possible.
pub(super) fn repair(work: &mut Work) {
    let edges = half_edges(work);
    if by_edge(&edges).all(|edge| edge.len() <= 2) {
        return;
    }
    let sizes = piece_sizes(work, &edges);
    for edge in by_edge(&edges).filter(|edge| edge.len() > 2) {
        work.report.non_manifold_edges += 1;
        let left: Vec<HalfEdge> = (edge.iter().copied())
            .filter(|h| work.kept[h.face as usize])
            .collect();
        if left.len() <= 2 {
            continue;
        }
        let pair = best_pair(work, &left, &sizes);
        for h in left.iter().filter(|h| !pair.contains(&h.face)) {
            // A face may have the edge twice.
            if std::mem::replace(&mut work.kept[h.face as usize], false) {
                work.report.non_manifold_faces += 1;
            }
        }
    }
}

/// For each face the number of faces of its piece, pieces ending at edges with more than two faces.
fn piece_sizes(work: &Work, edges: &[HalfEdge]) -> Vec<u32> {
    let mut pieces = DisjointSets::new(work.faces.len());
    for edge in by_edge(edges).filter(|edge| edge.len() == 2) {
        pieces.join(edge[0].face, edge[1].face);
    }
    let pieces = pieces.into_lowest();
    let mut counts = vec![0u32; pieces.len()];
    for f in work.left() {
        counts[pieces[f as usize] as usize] += 1;
    }
    pieces.iter().map(|p| counts[*p as usize]).collect()
}

fn best_pair(work: &Work, edge: &[HalfEdge], sizes: &[u32]) -> [u32; 2] {
    let mut faces = edge.to_vec();
    faces.sort_by_key(|h| (std::cmp::Reverse(sizes[h.face as usize]), h.face));
    faces.truncate(MOST_COMPARED);
    let normals: Vec<Vector3<f64>> = faces.iter().map(|h| unit_normal(work, h.face)).collect();
    let mut best: Option<((bool, u32, f64), [u32; 2])> = None;
    for (i, a) in faces.iter().enumerate() {
        for (j, b) in faces.iter().enumerate().skip(i + 1) {
            let against = a.forward != b.forward;
            // As if they ran against each other.
            let level = normals[i].dot(&normals[j]) * if against { 1.0 } else { -1.0 };
            let smaller = sizes[a.face as usize].min(sizes[b.face as usize]);
            let score = (against, smaller, level);
            let better = best.is_none_or(|(known, _)| {
                (score.0, score.1)
                    .cmp(&(known.0, known.1))
                    .then(score.2.total_cmp(&known.2))
                    .is_gt()
            });
            if better {
                best = Some((score, [a.face, b.face]));
            }
        }
    }
    best.map_or([faces[0].face; 2], |(_, pair)| pair)
}

/// The unit normal of a face as it is oriented now; zero for one without area.
pub(super) fn unit_normal(work: &Work, face: u32) -> Vector3<f64> {
    let polygon: Vec<_> = work.corners(face).map(|v| work.point(v)).collect();
    let normal = vector_area(&polygon).try_normalize(0.0).unwrap_or_default();
    if work.flipped[face as usize] {
        -normal
    } else {
        normal
    }
}
