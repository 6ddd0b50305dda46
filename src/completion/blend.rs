//! Seams between copied patches: every target keeps its own height as far as it can and takes on the shape
//! of its source.
//!
//! Neighboring targets that were copied from different places do not quite fit together: heights jump from
//! one patch to the other, and from the scan to the first. A target's *shape* is how far it stands from what
//! its source shows around itself, summed over its neighbors (the discrete Laplacian). Where its neighbors
//! continue the same source it has that shape already; elsewhere heights change by d, the minimiser of
//! the screened Poisson energy
//!
//! ```text
//! Σ |d(v) − d(n)|²  −  2 Σ d(v)·missing(v)  +  screening · Σ d(v)²
//!  edges                targets                            targets
//! ```
//!
//! with d = 0 on the scan, where `missing` is the shape that a target lacks.
//! Averages of the shapes at both ends of an edge, as image editing takes them, would smooth the relief.
//!
//! # Reference
//! [Pérez et al. 2003](crate::bibliography#pérez-et-al-2003): differences are copied, not values;
//! [Bhat et al. 2008](crate::bibliography#bhat-et-al-2008): screened by the values.

use rayon::prelude::*;

use super::growth::Canvas;

/// How strongly heights are held where they are. A change fades to 1/e within about an edge: at a tenth of
/// this, shapes that do not belong together add up to hills (RMS roughness up to 1.4 of the original's on bark);
/// at three times this, seams stay visible on smooth relief.
const SCREENING: f64 = 1.0;
/// The system is solved to this share of what was missing.
const ACCURACY: f64 = 1e-8;
/// Screened as strongly as this, it takes some twenty steps.
const MOST_STEPS: usize = 200;

/// Moves the heights of the completed targets of `canvas` so that they take on the shapes of their sources.
/// `continued` tells, for a target and a vertex next to it, the height that the target's source shows
/// there; `None` if it does not reach there. No height leaves the range of the scan's.
pub(super) fn blend(
    canvas: &mut Canvas,
    continued: impl Fn(&Canvas, usize, usize) -> Option<f64> + Sync,
) {
    let first = canvas.first_target;
    let targets = canvas.points.len() - first;
    let missing: Vec<f64> = (0..targets)
        .into_par_iter()
        .map(|target| missing_shape(canvas, first + target, &continued))
        .collect();
    let changes = screened_poisson(canvas, &missing);
    let scanned = (canvas.relief.heights[..first].iter().zip(&canvas.known)).filter(|(_, is)| **is);
    let [low, high] = scanned.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (h, _)| {
        [low.min(*h), high.max(*h)]
    });
    for (v, change) in (first..).zip(changes) {
        if canvas.known[v] && low <= high {
            let height = (canvas.relief.heights[v] + change).clamp(low, high);
            canvas.relief.heights[v] = height;
            canvas.points[v] = canvas.relief.point(v, height);
        }
    }
}

/// How much more the known neighbors of a target stand above it than its source has it.
fn missing_shape(
    canvas: &Canvas,
    v: usize,
    continued: &impl Fn(&Canvas, usize, usize) -> Option<f64>,
) -> f64 {
    if !canvas.known[v] {
        return 0.0;
    }
    known_neighbors(canvas, v)
        .filter_map(|n| Some(canvas.relief.heights[n] - continued(canvas, v, n)?))
        .sum()
}

fn known_neighbors(canvas: &Canvas, v: usize) -> impl Iterator<Item = usize> {
    (canvas.adjacency.neighbors.row(v).iter())
        .map(|n| *n as usize)
        .filter(|n| canvas.known[*n])
}

/// Conjugate gradients on (L + screening) d = missing: L is the graph Laplacian of the known targets, 0 on
/// the scan. Sums go in the order of the targets, on one thread: the same digits however many there are.
fn screened_poisson(canvas: &Canvas, missing: &[f64]) -> Vec<f64> {
    let first = canvas.first_target;
    let apply = |d: &[f64]| -> Vec<f64> {
        (d.iter().enumerate())
            .map(|(target, own)| {
                let v = first + target;
                let others = known_neighbors(canvas, v).filter(|_| canvas.known[v]);
                let differences = others.map(|n| own - n.checked_sub(first).map_or(0.0, |n| d[n]));
                SCREENING * own + differences.sum::<f64>()
            })
            .collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut solution = vec![0.0; missing.len()];
    let mut residual = missing.to_vec();
    let mut direction = residual.clone();
    let mut remaining = dot(&residual, &residual);
    let enough = ACCURACY * ACCURACY * remaining;
    for _ in 0..MOST_STEPS {
        if remaining <= enough {
            break;
        }
        let image = apply(&direction);
        let step = remaining / dot(&direction, &image);
        for (i, way) in direction.iter().enumerate() {
            solution[i] += step * way;
            residual[i] -= step * image[i];
        }
        let left = dot(&residual, &residual);
        let turn = left / remaining;
        remaining = left;
        for (way, residual) in direction.iter_mut().zip(&residual) {
            *way = residual + turn * *way;
        }
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Adjacency, TriMesh};
    use crate::relief::Relief;
    use nalgebra::{Point3, Vector3};

    const SIDE: u32 = 24;

    fn truth(p: &Point3<f64>) -> f64 {
        (0.7 * p.x).sin() * (0.5 * p.y).cos()
    }

    /// By which a target's source is too high: two patches that do not fit together.
    fn offset(p: &Point3<f64>, step: f64) -> f64 {
        if p.x < 12.0 { step } else { -step }
    }

    /// A flat sheet: scanned vertices around `inside` ones, which were copied from two sources.
    fn canvas(step: f64) -> Canvas {
        let is_inside = |p: &Point3<f64>| (6.0..18.0).contains(&p.x) && (6.0..18.0).contains(&p.y);
        let mut order: Vec<u32> = (0..SIDE * SIDE).collect();
        let at = |v: u32| Point3::new(f64::from(v % SIDE), f64::from(v / SIDE), 0.0);
        order.sort_by_key(|v| is_inside(&at(*v)));
        let mut number = vec![0; order.len()];
        for (new, old) in (0u32..).zip(&order) {
            number[*old as usize] = new;
        }
        let cells = (0..SIDE * (SIDE - 1)).filter(|v| v % SIDE < SIDE - 1);
        let triangles = cells.flat_map(|a| {
            let [b, c, d] = [a + 1, a + SIDE, a + SIDE + 1];
            [[a, b, d], [a, d, c]].map(|t| t.map(|v| number[v as usize]))
        });
        let feet: Vec<Point3<f64>> = order.iter().map(|v| at(*v)).collect();
        let mesh = TriMesh {
            triangles: triangles.collect(),
            positions: feet.clone(),
        };
        let first_target = feet.iter().filter(|p| !is_inside(p)).count();
        // The scan's first two vertices, a peak and a pit in its corner, leave room for all the others.
        let height = |(v, p): (usize, &Point3<f64>)| match v {
            0 => 2.0,
            1 => -2.0,
            _ if v < first_target => truth(p),
            _ => truth(p) + offset(p, step),
        };
        let heights: Vec<f64> = feet.iter().enumerate().map(height).collect();
        Canvas {
            adjacency: Adjacency::new(&mesh),
            points: feet.clone(),
            triangles: mesh.triangles,
            colors: None,
            known: vec![true; feet.len()],
            first_target,
            relief: Relief {
                normals: vec![Vector3::z(); feet.len()],
                heights,
                feet,
                side: 1.0,
            },
        }
    }

    fn blended(step: f64) -> [Canvas; 2] {
        let before = canvas(step);
        let mut after = canvas(step);
        blend(&mut after, |canvas, v, n| {
            let feet = &canvas.relief.feet;
            Some(truth(&feet[n]) + offset(&feet[v], step))
        });
        [before, after]
    }

    #[test]
    fn what_fits_together_is_left_alone() {
        let [before, after] = blended(0.0);
        for (a, b) in before.relief.heights.iter().zip(&after.relief.heights) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn every_target_weighs_its_height_against_its_shape() {
        let [before, after] = blended(0.05);
        let (old, new) = (&before.relief.heights, &after.relief.heights);
        for v in after.first_target..new.len() {
            let change = |n: usize| new[n] - old[n];
            let feet = &after.relief.feet;
            let missing: f64 = known_neighbors(&before, v)
                .map(|n| old[n] - truth(&feet[n]) - offset(&feet[v], 0.05))
                .sum();
            let bent: f64 = known_neighbors(&after, v)
                .map(|n| change(v) - change(n))
                .sum();
            assert!((bent + SCREENING * change(v) - missing).abs() < 1e-7);
            assert_eq!(after.points[v].z.to_bits(), new[v].to_bits());
        }
        assert_eq!(old[..before.first_target], new[..before.first_target]);
    }

    #[test]
    fn seams_between_patches_and_to_the_scan_become_smaller() {
        let [before, after] = blended(0.05);
        // How far the shape at each target is from that of its source, which is the truth's.
        let off = |canvas: &Canvas| -> f64 {
            let heights = &canvas.relief.heights;
            let error = |v: usize| heights[v] - truth(&canvas.relief.feet[v]);
            (canvas.first_target..heights.len())
                .map(|v| {
                    let bends = known_neighbors(canvas, v).map(|n| error(v) - error(n));
                    bends.sum::<f64>().powi(2)
                })
                .sum::<f64>()
                .sqrt()
        };
        assert!(
            off(&after) < 0.5 * off(&before),
            "{} {}",
            off(&after),
            off(&before)
        );
    }

    #[test]
    fn heights_stay_within_those_of_the_scan() {
        let [_, after] = blended(5.0);
        let (scan, targets) = after.relief.heights.split_at(after.first_target);
        let [low, high] = [f64::min, f64::max].map(|of| scan.iter().copied().reduce(of).unwrap());
        assert!(targets.iter().all(|h| (low..=high).contains(h)));
    }
}
