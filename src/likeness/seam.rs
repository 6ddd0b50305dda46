//! The seam: what happens along the rim of a piece.

use rayon::prelude::*;

use crate::mesh::TriMesh;
use crate::neighborhood::{Place, Surface};

use super::distance::wasserstein;
use super::field::{Field, Quantity, Split};
use super::{Figure, Measure, laplacian};

/// Width of the seam to both sides of the rim, in median edges.
const BAND: f64 = 2.0;

/// How far the surface bends across an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bend {
    ends: [u32; 2],
    /// The third corners of the two triangles.
    opposite: [u32; 2],
    length: f64,
    /// Between the normals of the profile across the edge, one median edge to both sides, in radians.
    angle: f64,
}

/// The Laplacian's distance within two median edges of the rim, and the distance of the distributions of
/// bends: across the rim's edges against inner edges of the known part, over the mean there.
pub(super) fn figures(field: &Field, quantity: &Quantity, split: &Split) -> [Figure; 2] {
    let figure = |name, value| Figure {
        measure: Measure::Seam,
        name: quantity.named(name),
        value,
    };
    [
        figure(
            "seam laplacian",
            laplacian::distance(field, quantity, &split.in_seam, &split.in_reference),
        ),
        figure("seam bend", bend_distance(quantity, split)),
    ]
}

/// The vertices within two median edges of the rim of a piece. The rim are the vertices next to the piece,
/// but not of it.
pub(super) fn around(field: &Field, piece: &[u32], in_piece: &[bool]) -> Vec<u32> {
    let neighbors = &field.discs.adjacency().neighbors;
    let mut rim: Vec<u32> = (piece.iter())
        .flat_map(|v| neighbors.row(*v as usize))
        .filter(|v| !in_piece[**v as usize])
        .copied()
        .collect();
    rim.sort_unstable();
    rim.dedup();
    field.discs.near(&rim, BAND * field.step)
}

fn bend_distance(quantity: &Quantity, split: &Split) -> Option<f64> {
    let items = quantity.bends.iter().map(|bend| {
        let inside = |v: &u32| split.in_piece[*v as usize];
        let ends_outside = !bend.ends.iter().any(inside);
        let reaches_in = bend.opposite.iter().any(inside);
        let known = |v: &u32| split.in_reference[*v as usize];
        let of = |is: bool| if is { bend.length } else { 0.0 };
        (
            bend.angle,
            of(ends_outside && reaches_in),
            of(bend.ends.iter().chain(&bend.opposite).all(known)),
        )
    });
    let (sum, total) = items
        .clone()
        .fold((0.0, 0.0), |(sum, total), (angle, _, w)| {
            (sum + w * angle, total + w)
        });
    (sum > 0.0)
        .then(|| wasserstein(items))?
        .map(|distance| distance * total / sum)
}

/// The bends of a quantity (as a height over `feet`) across all inner edges, by ascending angle.
///
/// They are read one median edge to either side: angles between the triangles themselves would grow with
/// their number.
pub(super) fn bends(surface: &Surface, feet: &TriMesh, values: &[f64], step: f64) -> Vec<Bend> {
    let opposites = Opposites::new(feet);
    let edges: Vec<(u32, [usize; 2])> = surface.edges().collect();
    let mut bends: Vec<Bend> = (edges.par_iter())
        .filter_map(|(triangle, corners)| {
            let all = surface.corners(*triangle);
            let ends = corners.map(|i| all[i]);
            let opposite = opposites.of(ends)?;
            let [a, b] = ends.map(|v| feet.positions[v as usize]);
            let mut middle = [0.0f32; 3];
            for i in corners {
                middle[*i] = 0.5;
            }
            let place = surface.in_triangle(*triangle, middle, &(b - a))?;
            Some(Bend {
                ends,
                opposite,
                length: (b - a).norm(),
                angle: angle_across(surface, &place, values, step)?,
            })
        })
        .collect();
    bends.sort_by(|a, b| a.angle.total_cmp(&b.angle).then(a.ends.cmp(&b.ends)));
    bends
}

/// Angle of the profile across the first axis of the place; `None` where it is not known.
fn angle_across(surface: &Surface, place: &Place, values: &[f64], step: f64) -> Option<f64> {
    let read = |place: &Place| {
        let corners = surface.corners(place.triangle);
        let value: f64 = (corners.iter().zip(surface.barycentric(place)))
            .map(|(v, w)| values[*v as usize] * f64::from(w))
            .sum();
        value.is_finite().then_some(value)
    };
    #[expect(clippy::cast_possible_truncation, reason = "places are single")]
    let across = step as f32;
    let here = read(place)?;
    let slope = |to: f32| Some((read(&surface.walk(place, [0.0, to])?)? - here) / step);
    Some((slope(across)?.atan() + slope(-across)?.atan()).abs())
}

/// For each edge the third corners of its triangles.
struct Opposites {
    /// (lower end, higher end, third corner), ascending.
    sides: Vec<[u32; 3]>,
}

impl Opposites {
    fn new(mesh: &TriMesh) -> Self {
        let mut sides: Vec<[u32; 3]> = (mesh.triangles.iter())
            .flat_map(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]])
            .map(|[a, b, c]| [a.min(b), a.max(b), c])
            .collect();
        sides.par_sort_unstable();
        Self { sides }
    }

    /// Of an edge with two triangles.
    fn of(&self, [a, b]: [u32; 2]) -> Option<[u32; 2]> {
        let (low, high) = (a.min(b), a.max(b));
        let start = (self.sides).partition_point(|side| (side[0], side[1]) < (low, high));
        let mut same = (self.sides[start..].iter()).take_while(|s| s[..2] == [low, high]);
        match (same.next(), same.next(), same.next()) {
            (Some(one), Some(other), None) => Some([one[2], other[2]]),
            _ => None,
        }
    }
}
