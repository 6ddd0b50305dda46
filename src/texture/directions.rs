//! Where the texture's first axis points, on every level.

use nalgebra::{Complex, Point3, Vector3};

use crate::mesh::{PointTree, TriMesh, vertex_normals};
use crate::rng::Rng;

use super::orientation::{Connection, random};
use super::params::Orientation;
use super::report::OrientationReport;

/// Where less than this of a direction is tangent, it is left to the neighbors.
const LEAST_TANGENT: f64 = 0.3;

/// Unit tangents at the vertices of each level, and what is to be said of those of the finest. Levels are the finest
/// first.
pub(super) fn directions(
    levels: &[&TriMesh],
    orientation: &Orientation,
    symmetry: u32,
    rng: &mut Rng,
) -> (Vec<Vec<Vector3<f64>>>, OrientationReport) {
    let mut all: Vec<Vec<Vector3<f64>>> = Vec::new();
    let mut report = OrientationReport::default();
    for (number, mesh) in levels.iter().enumerate().rev() {
        let normals = vertex_normals(mesh);
        let connection = Connection::new(mesh, &normals);
        let level = Level {
            mesh,
            normals: &normals,
            connection: &connection,
        };
        // What the next coarser level says.
        let coarse = (levels.get(number + 1).zip(all.last()))
            .map(|(mesh, directions)| level.carried_over(mesh, directions));
        let (mut field, pinned) = level.start(orientation, symmetry, coarse.as_deref(), rng);
        let mut rounds = 0;
        if *orientation != Orientation::Random {
            rounds = connection.relax(&mut field, symmetry, &pinned, coarse.is_some());
            // Pieces on which nothing is given have found nothing to go by.
            let nowhere: Vec<usize> = (0..field.len())
                .filter(|v| field[*v] == Complex::default())
                .collect();
            if !nowhere.is_empty() {
                for (v, z) in nowhere.iter().zip(random(nowhere.len(), rng)) {
                    field[*v] = z;
                }
                rounds += connection.relax(&mut field, symmetry, &pinned, false);
            }
        }
        if number == 0 {
            report = OrientationReport {
                rounds,
                error: connection.error(&field, symmetry),
                singularities: match orientation {
                    Orientation::Random => Vec::new(),
                    _ => connection.singularities(mesh, &field, symmetry),
                },
            };
        }
        let chosen = connection.branches(&field, symmetry, coarse.as_deref());
        let vectors = (chosen.into_iter().enumerate()).map(|(v, z)| connection.to_vector(v, z));
        all.push(vectors.collect());
    }
    all.reverse();
    (all, report)
}

/// A level whose directions are to be found.
struct Level<'a> {
    mesh: &'a TriMesh,
    normals: &'a [Vector3<f64>],
    connection: &'a Connection,
}

impl Level<'_> {
    /// The directions of a coarser level at the nearest of its vertices.
    fn carried_over(&self, mesh: &TriMesh, directions: &[Vector3<f64>]) -> Vec<Complex<f64>> {
        let tree = PointTree::new(&mesh.positions);
        let normals = vertex_normals(mesh);
        (self.mesh.positions.iter().enumerate())
            .map(|(v, point)| {
                let near = tree.nearest_n(point, 8);
                let agrees = |u: usize| normals[u].dot(&self.normals[v]) > 0.0;
                let nearest = near.iter().find(|n| agrees(n.index)).or(near.first());
                let direction = nearest.map_or_else(Vector3::x, |n| directions[n.index]);
                self.connection.to_complex(v, &direction)
            })
            .collect()
    }

    /// The field to begin with, and which directions of it stay.
    fn start(
        &self,
        orientation: &Orientation,
        symmetry: u32,
        coarse: Option<&[Complex<f64>]>,
        rng: &mut Rng,
    ) -> (Vec<Complex<f64>>, Vec<bool>) {
        let count = self.normals.len();
        let powers = |z: &Complex<f64>| z.powu(symmetry);
        let mut field = match (orientation, coarse) {
            (Orientation::Random, _) | (Orientation::Relax, None) => random(count, rng),
            // Nothing is known yet but what is pinned.
            (_, None) => vec![Complex::default(); count],
            (_, Some(coarse)) => coarse.iter().map(powers).collect(),
        };
        if let (Orientation::Along(direction), None) = (orientation, coarse) {
            // What is tangent of it is a beginning also where it is too little to be kept.
            for (v, z) in field.iter_mut().enumerate() {
                *z = powers(&self.connection.to_complex(v, direction));
            }
        }
        let mut pinned = vec![false; count];
        let mut pin = |v: usize, direction: &Vector3<f64>| {
            let z = self.connection.to_complex(v, direction);
            if z != Complex::default() {
                field[v] = z.powu(symmetry);
                pinned[v] = true;
            }
        };
        match orientation {
            Orientation::Random | Orientation::Relax => {}
            Orientation::Along(direction) => {
                let direction = direction.normalize();
                for (v, normal) in self.normals.iter().enumerate() {
                    if direction.cross(normal).norm() >= LEAST_TANGENT {
                        pin(v, &direction);
                    }
                }
            }
            Orientation::Given(list) => {
                let tree = PointTree::new(&self.mesh.positions);
                for (v, direction) in given(list, &tree) {
                    pin(v, &direction);
                }
            }
        }
        (field, pinned)
    }
}

/// The vertices nearest to points with directions; of several points the nearest one's.
fn given(list: &[(Point3<f64>, Vector3<f64>)], tree: &PointTree) -> Vec<(usize, Vector3<f64>)> {
    let is_usable = |(p, d): &&(Point3<f64>, Vector3<f64>)| {
        p.iter().chain(d.iter()).all(|x| x.is_finite()) && d.norm() > 0.0
    };
    let mut nearest: Vec<(usize, f64, Vector3<f64>)> = (list.iter().filter(is_usable))
        .map(|(point, direction)| {
            let near = tree.nearest(point);
            (near.index, near.distance_sq, direction.normalize())
        })
        .collect();
    nearest.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    nearest.dedup_by_key(|(v, ..)| *v);
    nearest.into_iter().map(|(v, _, d)| (v, d)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stage;
    use crate::texture::tests::plane;

    #[test]
    fn where_a_direction_is_nowhere_tangent_all_are_parallel_all_the_same() {
        let mesh = plane(6);
        let upright = Orientation::Along(Vector3::z());
        let mut rng = Rng::new(1, Stage::Texture, 0);
        let (found, report) = directions(&[&mesh], &upright, 1, &mut rng);
        assert!(report.error < 1e-4 && report.singularities.is_empty());
        for direction in &found[0] {
            assert!((direction.norm() - 1.0).abs() < 1e-9 && direction.z.abs() < 1e-9);
            assert!(direction.dot(&found[0][0]) > 0.99);
        }
    }

    #[test]
    fn a_single_direction_spreads_over_a_flat_piece() {
        let mesh = plane(6);
        let wanted: Vector3<f64> = Vector3::new(0.6, 0.8, 0.0);
        let given = Orientation::Given(vec![(Point3::new(0.5, 0.5, 0.0), 3.0 * wanted)]);
        let mut rng = Rng::new(1, Stage::Texture, 0);
        for symmetry in [1, 2, 4] {
            let (found, _) = directions(&[&mesh], &given, symmetry, &mut rng);
            let turned = |d: &Vector3<f64>| {
                let angle = d.y.atan2(d.x) - wanted.y.atan2(wanted.x);
                (f64::from(symmetry) * angle).cos()
            };
            assert!(found[0].iter().all(|d| turned(d) > 0.999));
        }
    }
}
