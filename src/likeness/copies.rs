//! What was copied from where: a verbatim paste is perfect in all statistics and still no completion.

use nalgebra::Point3;
use serde::Serialize;

use crate::mesh::{Adjacency, Csr, TriMesh, edges};

/// Two sources are neighbors up to this many times the distance of what was copied from them (or the
/// scan's median edge, if that is longer): sources are vertices, so each is off by up to half an edge.
const NEIGHBORING: f64 = 1.6;

/// A piece of more than this share of the fill that was copied in one is a paste: the eye finds a shape
/// again of which it sees half. Growth by coherent candidates makes many pieces, the largest a small part.
const MOST_OF_ONE_PIECE: f64 = 0.5;

/// A source that gives more than this share of the fill is garbage grown from one spot (Efros & Leung 1999,
/// §4). Where new vertices are as dense as the scan and evenly copied, each gives about 1/(their number).
const MOST_OF_ONE_SOURCE: f64 = 0.05;
/// … but in a fill of a few vertices some source gives 5 % by chance; so many uses are none.
const FEW_USES: usize = 12;

/// How a fill was put together from copies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CopyIndex {
    /// Number of vertices with a source.
    pub vertices: usize,
    /// Share of the edges between them whose ends were copied from neighboring sources (or one).
    pub neighboring_edges: f64,
    /// Share of the vertices in the largest part that hangs together by such edges.
    pub largest_piece: f64,
    /// Number of such parts, single vertices among them.
    pub pieces: usize,
    /// How often the most re-used source was copied.
    pub most_reused: usize,
    /// Whether most of the fill is one copy, that is a verbatim paste.
    pub is_paste: bool,
    /// Whether a single source gives much of the fill.
    pub is_garbage: bool,
}

/// Looks through the sources (#V: the vertex that a completed one was copied from, negative for none) of a
/// completed surface; `None` without any. `step` is the scan's median edge.
///
/// # Reference
/// The danger: [Efros & Leung 1999](crate::bibliography#efros--leung-1999), §4, "verbatim copying" and
/// "growing garbage".
#[must_use]
pub fn copies(mesh: &TriMesh, sources: &[i64], step: f64) -> Option<CopyIndex> {
    let source = |v: u32| -> Option<&Point3<f64>> {
        let source = usize::try_from(*sources.get(v as usize)?).ok()?;
        mesh.positions.get(source)
    };
    let copied = |v: &u32| source(*v).is_some();
    let all: Vec<u32> = (0u32..).take(mesh.positions.len()).filter(copied).collect();
    if all.is_empty() {
        return None;
    }
    let (mut count, mut joined) = (0usize, Vec::new());
    for [a, b] in edges(mesh) {
        if let (Some(from_a), Some(from_b)) = (source(a), source(b)) {
            let length = (mesh.positions[a as usize] - mesh.positions[b as usize]).norm();
            count += 1;
            if (from_a - from_b).norm() <= NEIGHBORING * length.max(step) {
                joined.push((a, b));
            }
        }
    }
    let (largest, pieces) = pieces(mesh.positions.len(), &joined, &all);
    let most_reused = most_frequent(sources);
    let share = |n: usize, of: usize| n as f64 / of.max(1) as f64;
    let largest_piece = share(largest, all.len());
    Some(CopyIndex {
        vertices: all.len(),
        neighboring_edges: share(joined.len(), count),
        largest_piece,
        pieces,
        most_reused,
        is_paste: largest_piece > MOST_OF_ONE_PIECE,
        is_garbage: most_reused > FEW_USES && share(most_reused, all.len()) > MOST_OF_ONE_SOURCE,
    })
}

/// Size of the largest part that the edges join, and the number of parts of the given vertices.
fn pieces(rows: usize, joined: &[(u32, u32)], all: &[u32]) -> (usize, usize) {
    let both_ways = joined.iter().flat_map(|(a, b)| [(*a, *b), (*b, *a)]);
    let adjacency = Adjacency {
        neighbors: Csr::from_pairs(rows, both_ways),
        triangles: Csr::default(),
    };
    let (component, count) = adjacency.components();
    let mut sizes = vec![0usize; count];
    for v in all {
        sizes[component[*v as usize] as usize] += 1;
    }
    let largest = sizes.iter().copied().max().unwrap_or(0);
    (largest, sizes.iter().filter(|size| **size > 0).count())
}

fn most_frequent(sources: &[i64]) -> usize {
    let mut sorted: Vec<i64> = sources.iter().copied().filter(|s| *s >= 0).collect();
    sorted.sort_unstable();
    let uses = sorted.chunk_by(|a, b| a == b).map(<[i64]>::len);
    uses.max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two sheets of 10 by 10 vertices with sides of 1, the second copied from the first.
    fn sheets() -> TriMesh {
        let mut mesh = TriMesh::default();
        for sheet in 0..2u32 {
            for v in 0..100u32 {
                let (x, y) = (f64::from(v % 10), f64::from(v / 10));
                mesh.positions.push(Point3::new(x, y, f64::from(sheet)));
                if v % 10 < 9 && v < 90 {
                    let a = 100 * sheet + v;
                    mesh.triangles
                        .extend([[a, a + 1, a + 11], [a, a + 11, a + 10]]);
                }
            }
        }
        mesh
    }

    fn copied(from: impl Fn(i64) -> i64) -> CopyIndex {
        let sources: Vec<i64> = (0..200)
            .map(|v| if v < 100 { -1 } else { from(v - 100) })
            .collect();
        copies(&sheets(), &sources, 1.0).unwrap()
    }

    #[test]
    fn a_verbatim_paste_shows() {
        let index = copied(|v| v);
        assert!(index.is_paste && !index.is_garbage);
        assert_eq!(
            (index.vertices, index.pieces, index.most_reused),
            (100, 1, 1)
        );
        assert!((index.neighboring_edges - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_turned_paste_shows_as_well() {
        assert!(copied(|v| 10 * (v % 10) + 9 - v / 10).is_paste);
    }

    #[test]
    fn sources_all_over_the_place_are_no_paste() {
        let index = copied(|v| v * 37 % 100);
        assert!(!index.is_paste && !index.is_garbage);
        assert!(index.neighboring_edges < 0.3);
    }

    #[test]
    fn one_source_for_a_fifth_is_garbage() {
        let index = copied(|v| if v % 5 == 0 { 44 } else { v * 37 % 100 });
        assert!(index.is_garbage);
        assert_eq!(index.most_reused, 21);
    }

    #[test]
    fn without_sources_there_is_nothing_to_tell() {
        assert_eq!(copies(&sheets(), &[-1; 200], 1.0), None);
    }
}
