//! The side of each normal: what is known of it, spread to the others.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::points::{Neighbors, Points, index};
use super::report::Orientation;
use super::signs::Groups;
use crate::scan::Scan;

/// Neighbors of a point in the graph along which signs spread.
const GRAPH_NEIGHBORS: usize = 10;

/// Edges up to this cost are followed without a vote: normals up to 18 degrees apart where the edge lies
/// in their planes, and a hundredth of the spread across them.
const CHEAP: f64 = 0.05;

/// Cost of the share of the spread that is across the plane: at the edge of a thin wall, whose plane
/// is that of neither side, signs would cross over.
const ROUGHNESS_COST: f64 = 5.0;

/// Votes that join two groups: for each point of the smaller one, at most so many, and at least this
/// share of what they would be if all agreed.
const VOTES_PER_POINT: f64 = 0.25;
const MOST_VOTES: f64 = 10.0;
/// A half instead of 0.8 turns the roof of a tower over its eaves inside out, and a fifth instead of a
/// tenth of the triangles of a gravel bed downwards.
const MAJORITY: f64 = 0.8;

/// A line of sight that meets the plane at less than about 6 degrees does not tell its side.
const GRAZING: f64 = 0.1;

/// Where the mean normal of a group is longer, the group is a sheet, else it closes up: it is 0 for
/// all of a sphere or pipe, the missing share for a sphere with a hole, 0.5 for half a sphere, 0.64 for
/// half a pipe.
const SHEET: f64 = 0.4;

/// What is known beforehand of the side of a point's normal.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Known {
    Sensor(Vector3<f64>),
    File(Vector3<f64>),
    Nothing,
}

/// Turns the normals: to the sensor where one is known, else as the file's own normals, else as their
/// neighbors, along the tree of least turns (Hoppe et al. 1992, section 3.3).
///
/// A group for which nothing is known is turned outwards if it closes up. A sheet is turned such that
/// its summed normal points along the positive side of the axis that it is closest to, as range grids
/// are; small ones like the largest if they are roughly parallel to it.
pub(super) fn orient(
    normals: &mut [Vector3<f64>],
    rough: &[f64],
    points: &Points,
    neighbors: &Neighbors,
    scan: &Scan,
    positions: &[Point3<f64>],
) -> Orientation {
    let known = known(points, scan, positions);
    let mut counts = Orientation::default();
    let mut open = false;
    // How much the known direction agrees with the normal as it is.
    let evidence: Vec<f64> = (normals.iter().zip(&known))
        .map(|(n, known)| match known {
            Known::Sensor(d) if n.dot(d).abs() > GRAZING => {
                counts.sensor += 1;
                n.dot(d)
            }
            Known::File(d) if n.dot(d).abs() > GRAZING => {
                counts.file += 1;
                n.dot(d)
            }
            _ => {
                counts.propagated += 1;
                open = true;
                0.0
            }
        })
        .collect();
    if open {
        spread(normals, rough, &evidence, points, neighbors);
    } else {
        for (n, e) in normals.iter_mut().zip(&evidence) {
            *n *= e.signum();
        }
    }
    counts
}

fn known(points: &Points, scan: &Scan, positions: &[Point3<f64>]) -> Vec<Known> {
    let mut of_row = vec![Known::Nothing; positions.len()];
    let columns = ["nx", "ny", "nz"].map(|name| scan.vertices.column(name));
    if let [Some(x), Some(y), Some(z)] = columns {
        for (row, known) in of_row.iter_mut().enumerate() {
            let normal = [x, y, z].map(|c| c.get_f64(row).unwrap_or(f64::NAN));
            // What is no direction does not tell any.
            let unit = Vector3::from(normal).try_normalize(f64::MIN_POSITIVE);
            if let Some(unit) = unit.filter(|n| n.iter().all(|x| x.is_finite())) {
                *known = Known::File(unit);
            }
        }
    }
    for sensor in scan.sensors.iter().rev() {
        let end = sensor.vertices.end.min(positions.len());
        for row in sensor.vertices.start..end {
            let view = (sensor.position - positions[row]).try_normalize(f64::MIN_POSITIVE);
            if let Some(view) = view.filter(|n| n.iter().all(|x| x.is_finite())) {
                of_row[row] = Known::Sensor(view);
            }
        }
    }
    points
        .rows
        .iter()
        .map(|row| of_row[*row as usize])
        .collect()
}

/// Gives each normal the sign of its evidence, or, without any, that of its group's.
fn spread(
    normals: &mut [Vector3<f64>],
    rough: &[f64],
    evidence: &[f64],
    points: &Points,
    neighbors: &Neighbors,
) {
    let mut groups = tree(normals, rough, points, neighbors);
    let (roots, evidence): (Vec<u32>, Vec<f64>) = (normals.iter_mut().enumerate())
        .map(|(i, normal)| {
            let (root, flipped) = groups.find(index(i));
            let sign = if flipped { -1.0 } else { 1.0 };
            *normal *= sign;
            (root, evidence[i] * sign)
        })
        .unzip();
    let signs = Sums::of_groups(normals, &evidence, points, &roots).signs();
    for (i, normal) in normals.iter_mut().enumerate() {
        *normal *= if evidence[i] == 0.0 {
            signs[roots[i] as usize]
        } else {
            evidence[i].signum()
        };
    }
}

/// Two neighbors, what their edge costs and how it votes.
struct Pair {
    ends: [u32; 2],
    /// The more, the more the normals differ in direction (1 − |n·n'|) and, so that signs do not cross
    /// from one side of a thin wall to the other, the more the edge leaves their planes and the less
    /// these are planes.
    cost: f64,
    /// Positive if the normals have one side as they are, and nearer to zero the less that is certain.
    /// The sign is that with which a circular arc passes through both (the second normal mirrored at
    /// the edge's middle plane): right over creases of up to 180 degrees, where n·n' is up to 90.
    vote: f64,
}

impl Pair {
    fn new(ends: [u32; 2], normals: &[Vector3<f64>], points: &Points, rough: &[f64]) -> Self {
        let [p, q] = ends.map(|v| points.positions[v as usize]);
        let [n, m] = ends.map(|v| normals[v as usize]);
        let [r, t] = ends.map(|v| rough[v as usize]);
        let along = (q - p).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let steep = n.dot(&along).powi(2).max(m.dot(&along).powi(2));
        let mirrored = m - along * (2.0 * m.dot(&along));
        Self {
            ends,
            cost: (1.0 - n.dot(&m).abs()).max(0.0) + steep + ROUGHNESS_COST * r.max(t),
            vote: n.dot(&mirrored) * (1.0 - steep).max(0.0).powi(2),
        }
    }
}

/// Joins neighbors into groups of one side: along the edges of a spanning forest of least cost (Hoppe
/// et al. 1992, section 3.3) as far as these are cheap, then group by group where all edges between two
/// of them together tell their sides. Groups that nothing sure connects stay apart.
fn tree(normals: &[Vector3<f64>], rough: &[f64], points: &Points, neighbors: &Neighbors) -> Groups {
    let listed = |i: usize| &neighbors.of(i)[..GRAPH_NEIGHBORS.min(neighbors.of(i).len())];
    let mut pairs: Vec<Pair> = (0..normals.len())
        .into_par_iter()
        .flat_map_iter(|i| {
            let i_index = index(i);
            (listed(i).iter())
                .filter(move |j| i_index < **j || !listed(**j as usize).contains(&i_index))
                .map(move |j| Pair::new([i_index, *j], normals, points, rough))
        })
        .collect();
    pairs.par_sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let cheap = pairs.partition_point(|pair| pair.cost <= CHEAP);
    let mut groups = Groups::new(normals.len());
    for pair in &pairs[..cheap] {
        let [i, j] = pair.ends;
        groups.join(i, j, pair.vote < 0.0);
    }
    while join_by_votes(&mut groups, &mut pairs) {}
    groups
}

/// Joins each group with the one that the votes of the edges between them tell most about; false if
/// there was nothing to join. Edges within a group are dropped.
///
/// The number of groups that can still be joined at least halves.
fn join_by_votes(groups: &mut Groups, pairs: &mut Vec<Pair>) -> bool {
    let mut votes: Vec<([u32; 2], f64)> = Vec::new();
    pairs.retain(|pair| {
        let [(a, a_flipped), (b, b_flipped)] = pair.ends.map(|v| groups.find(v));
        let vote = if a_flipped == b_flipped {
            pair.vote
        } else {
            -pair.vote
        };
        if a != b {
            votes.push(([a.min(b), a.max(b)], vote));
        }
        a != b
    });
    // Stable, so that sums do not depend on threads.
    votes.par_sort_by_key(|(between, _)| *between);
    let mut sums: Vec<(f64, [u32; 2])> = Vec::new();
    for same in votes.chunk_by(|a, b| a.0 == b.0) {
        let between = same[0].0;
        let sum: f64 = same.iter().map(|(_, vote)| vote).sum();
        let cast: f64 = same.iter().map(|(_, vote)| vote.abs()).sum();
        let smaller = between.map(|root| f64::from(groups.size(root)));
        let needed = (VOTES_PER_POINT * smaller[0].min(smaller[1])).min(MOST_VOTES);
        if sum.abs() >= needed && sum.abs() >= MAJORITY * cast && sum != 0.0 {
            sums.push((sum, between));
        }
    }
    sums.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()).then(a.1.cmp(&b.1)));
    // Only what is the best for one of the two, or else early mistakes would pass for votes.
    let mut taken = std::collections::BTreeSet::new();
    let mut joined = false;
    for (sum, [a, b]) in sums {
        let is_best = [taken.insert(a), taken.insert(b)];
        if is_best.contains(&true) {
            joined |= groups.join(a, b, sum < 0.0);
        }
    }
    joined
}

/// What the sign of a group is decided by; #V, of the groups at their roots.
struct Sums {
    normal: Vec<Vector3<f64>>,
    /// Σ (p − c)·n: three times the volume of a closed form, if each point had the same area.
    outwards: Vec<f64>,
    evidence: Vec<f64>,
    count: Vec<f64>,
}

impl Sums {
    fn of_groups(
        normals: &[Vector3<f64>],
        evidence: &[f64],
        points: &Points,
        roots: &[u32],
    ) -> Self {
        let mut sums = Self {
            normal: vec![Vector3::zeros(); roots.len()],
            outwards: vec![0.0; roots.len()],
            evidence: vec![0.0; roots.len()],
            count: vec![0.0; roots.len()],
        };
        let mut middle = vec![Vector3::zeros(); roots.len()];
        for (i, root) in roots.iter().enumerate() {
            let root = *root as usize;
            sums.normal[root] += normals[i];
            sums.evidence[root] += evidence[i];
            sums.count[root] += 1.0;
            middle[root] += points.positions[i].coords;
        }
        for (i, root) in roots.iter().enumerate() {
            let root = *root as usize;
            let from = points.positions[i].coords - middle[root] / sums.count[root];
            sums.outwards[root] += from.dot(&normals[i]);
        }
        sums
    }

    fn signs(&self) -> Vec<f64> {
        let is_sheet = |g: usize| self.normal[g].norm() > SHEET * self.count[g];
        let sheets = (0..self.count.len()).filter(|g| self.count[*g] > 0.0 && is_sheet(*g));
        // The first of the largest.
        let largest = sheets.max_by(|a, b| {
            let order = self.count[*a].total_cmp(&self.count[*b]);
            order.then(b.cmp(a))
        });
        let facing = |v: &Vector3<f64>| if v[v.iamax()] < 0.0 { -1.0 } else { 1.0 };
        let main = largest.map(|g| {
            let sum = self.normal[g];
            let evidence = self.evidence[g];
            sum.normalize()
                * if evidence == 0.0 {
                    facing(&sum)
                } else {
                    evidence.signum()
                }
        });
        let sign = |g: usize| {
            let sum = self.normal[g];
            let along = main.map_or(0.0, |main| main.dot(&sum));
            if self.evidence[g] != 0.0 {
                self.evidence[g].signum()
            } else if !is_sheet(g) {
                if self.outwards[g] < 0.0 { -1.0 } else { 1.0 }
            } else if along.abs() > 0.5 * sum.norm() {
                along.signum()
            } else {
                facing(&sum)
            }
        };
        (0..self.count.len()).map(sign).collect()
    }
}
