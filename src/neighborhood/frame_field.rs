//! Tangent frames that turn as little as possible from vertex to vertex.

use nalgebra::Vector3;

use crate::mesh::Adjacency;

use super::Frame;

/// Rounds in which each frame is turned towards its neighbors': from a field that is smooth but around
/// two places, enough to spread what is left of them.
const ROUNDS: usize = 40;

/// Frames for unit normals (#V) that follow the surface: neighbors' first tangents are as parallel as the
/// surface lets them be, so that what is ridged goes on in one direction. `first` is the direction that
/// they have where it is tangent.
///
/// # Panics
/// If `normals` has not one entry a vertex of the adjacency.
#[must_use]
pub fn smooth_frames(
    adjacency: &Adjacency,
    normals: &[Vector3<f64>],
    first: &Vector3<f64>,
) -> Vec<Frame> {
    assert_eq!(
        adjacency.neighbors.len(),
        normals.len(),
        "one normal a vertex"
    );
    let tangent = |v: &Vector3<f64>, normal: &Vector3<f64>| v - normal * v.dot(normal);
    let mut field: Vec<Vector3<f64>> = normals.iter().map(|n| tangent(first, n)).collect();
    for _ in 0..ROUNDS {
        // Next to the poles of `first` the field is short: its neighbors say where to turn.
        field = (normals.iter().enumerate())
            .map(|(v, normal)| {
                let row = adjacency.neighbors.row(v).iter();
                let sum: Vector3<f64> = row.map(|n| field[*n as usize]).sum();
                let turned = tangent(&(sum + field[v]), normal);
                turned.try_normalize(1e-12).unwrap_or(field[v])
            })
            .collect();
    }
    (field.iter().zip(normals))
        .map(|(direction, normal)| frame(&tangent(direction, normal), normal))
        .collect()
}

fn frame(tangent: &Vector3<f64>, normal: &Vector3<f64>) -> Frame {
    let any = || {
        let mut smallest = Vector3::zeros();
        smallest[normal.iamin()] = 1.0;
        normal.cross(&smallest).normalize()
    };
    let x = tangent.try_normalize(1e-12).unwrap_or_else(any);
    Frame {
        axes: [x, normal.cross(&x), *normal],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, vertex_normals};
    use nalgebra::Point3;

    /// A sphere of latitude rings without its poles.
    fn sphere() -> TriMesh {
        let (rings, around) = (20u32, 40u32);
        let mut mesh = TriMesh::default();
        for i in 0..rings {
            let polar = 0.3 + 2.5 * f64::from(i) / f64::from(rings - 1);
            for j in 0..around {
                let angle = std::f64::consts::TAU * f64::from(j) / f64::from(around);
                mesh.positions.push(Point3::new(
                    polar.sin() * angle.cos(),
                    polar.sin() * angle.sin(),
                    polar.cos(),
                ));
                if i + 1 < rings {
                    let v = |i, j| i * around + j % around;
                    let [a, b, c, d] = [v(i, j), v(i, j + 1), v(i + 1, j), v(i + 1, j + 1)];
                    mesh.triangles.extend([[a, c, d], [a, d, b]]);
                }
            }
        }
        mesh
    }

    #[test]
    fn frames_are_right_handed_and_turn_little_but_at_two_places() {
        let mesh = sphere();
        let adjacency = Adjacency::new(&mesh);
        let normals = vertex_normals(&mesh);
        let frames = smooth_frames(&adjacency, &normals, &Vector3::x());
        let mut turns = Vec::new();
        for (v, frame) in frames.iter().enumerate() {
            let [x, y, n] = frame.axes;
            assert!((x.cross(&y) - n).norm() < 1e-9 && (n - normals[v]).norm() < 1e-12);
            for w in adjacency.neighbors.row(v) {
                let other = frames[*w as usize].axes[0];
                turns.push((other - n * other.dot(&n)).angle(&x));
            }
        }
        turns.sort_by(f64::total_cmp);
        // A vector field on a sphere must turn somewhere; nearly everywhere it need not.
        assert!(turns[turns.len() * 9 / 10] < 0.25, "{:?}", turns.last());
    }

    #[test]
    fn on_a_plane_all_frames_are_the_same() {
        let mesh = TriMesh {
            positions: (0..4)
                .map(|i| Point3::new(f64::from(i % 2), f64::from(i / 2), 0.0))
                .collect(),
            triangles: vec![[0, 1, 3], [0, 3, 2]],
        };
        let normals = vertex_normals(&mesh);
        let direction = Vector3::new(1.0, 2.0, 0.0);
        for frame in smooth_frames(&Adjacency::new(&mesh), &normals, &direction) {
            assert!((frame.axes[0] - direction.normalize()).norm() < 1e-12);
        }
    }
}
