//! 1-to-4 subdivision of the sample surface, so that a target finds samples in phase with it.

use nalgebra::Point3;
use rayon::prelude::*;

use crate::base::BaseSurface;
use crate::mesh::{PointTree, TriMesh, edges};
use crate::relief::Relief;

/// Neighbors whose colours a new vertex takes a share of: the two ends of its edge, the two corners
/// across it, and as many again.
const COLOR_NEIGHBORS: usize = 8;

/// A surface with a new vertex in the middle of each edge.
#[derive(Debug, Clone)]
pub struct Subdivision {
    /// #S by 3: the old vertices in their order, then the new ones; on the relief, not on the base.
    pub mesh: TriMesh,
    /// #S: relief of `mesh`.
    pub relief: Relief,
    /// #S colours in [0, 1], where the scan has any.
    pub colors: Option<Vec<[f64; 3]>>,
    /// For each new vertex the ends of its edge, the lower first.
    pub parents: Vec<[u32; 2]>,
}

/// Splits each triangle in four. Each new vertex stands on the base where its edge's middle falls,
/// at the mean height of the edge's ends; its colour is the Gaussian-weighted mean of its nearest
/// old vertices (σ = their mean distance, measured on the base).
///
/// # Panics
/// If there would be 2³² vertices or more.
///
/// # Reference
/// [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), §4.
#[must_use]
pub fn subdivide(
    mesh: &TriMesh,
    base: &BaseSurface,
    relief: &Relief,
    colors: Option<&[[f64; 3]]>,
) -> Subdivision {
    let (triangles, parents) = split(mesh);
    let mut fine = relief.clone();
    fine.feet.reserve_exact(parents.len());
    fine.normals.reserve_exact(parents.len());
    fine.heights.reserve_exact(parents.len());
    for [a, b] in &parents {
        let (a, b) = (*a as usize, *b as usize);
        let foot = base.foot(&nalgebra::center(&mesh.positions[a], &mesh.positions[b]));
        fine.feet.push(foot.point);
        fine.normals.push(foot.normal * relief.side);
        fine.heights
            .push(0.5 * (relief.heights[a] + relief.heights[b]));
    }
    let old = mesh.positions.len();
    let mut positions = Vec::with_capacity(fine.feet.len());
    positions.extend_from_slice(&mesh.positions);
    positions.extend((old..fine.feet.len()).map(|v| fine.point(v, fine.heights[v])));
    Subdivision {
        mesh: TriMesh {
            positions,
            triangles,
        },
        colors: colors.map(|colors| mixed_colors(colors, mesh, relief, &fine.feet[old..])),
        relief: fine,
        parents,
    }
}

/// The four triangles of each triangle, and the edge under each new vertex.
fn split(mesh: &TriMesh) -> (Vec<[u32; 3]>, Vec<[u32; 2]>) {
    let old = u32::try_from(mesh.positions.len()).expect("indices are u32");
    let edges = edges(mesh);
    // The edges of each vertex to higher ones stand together.
    let starts: Vec<usize> = (0..=old)
        .scan(0, |next, v| {
            while edges.get(*next).is_some_and(|edge| edge[0] < v) {
                *next += 1;
            }
            Some(*next)
        })
        .collect();
    let middle = |a: u32, b: u32| {
        let (low, high) = (a.min(b) as usize, a.max(b));
        let place = edges[starts[low]..starts[low + 1]].binary_search_by_key(&high, |e| e[1]);
        let place = starts[low] + place.expect("every edge was listed");
        old + u32::try_from(place).expect("indices are u32")
    };
    let triangles = (mesh.triangles.iter())
        .flat_map(|&[a, b, c]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        })
        .collect();
    (triangles, edges)
}

/// Old colours followed by those at `points`.
fn mixed_colors(
    colors: &[[f64; 3]],
    mesh: &TriMesh,
    relief: &Relief,
    points: &[Point3<f64>],
) -> Vec<[f64; 3]> {
    let used: Vec<usize> = (mesh.used_vertices().into_iter().enumerate())
        .filter_map(|(v, used)| used.then_some(v))
        .collect();
    if used.is_empty() {
        return colors.to_vec();
    }
    let feet: Vec<_> = used.iter().map(|v| relief.feet[*v]).collect();
    let tree = PointTree::new(&feet);
    let mixed = points.par_iter().map(|p| {
        let nearest = tree.nearest_n(p, COLOR_NEIGHBORS);
        let distances = nearest.iter().map(|n| n.distance_sq.sqrt());
        let sigma = distances.sum::<f64>() / nearest.len() as f64;
        let mut sum = [0.0; 3];
        let mut total = 0.0;
        for n in &nearest {
            let weight = if sigma > 0.0 {
                (-n.distance_sq / (2.0 * sigma * sigma)).exp()
            } else {
                1.0
            };
            let color = colors[used[n.index]];
            total += weight;
            for (sum, c) in sum.iter_mut().zip(color) {
                *sum += weight * c;
            }
        }
        sum.map(|c| c / total)
    });
    (colors.par_iter().copied()).chain(mixed).collect()
}
