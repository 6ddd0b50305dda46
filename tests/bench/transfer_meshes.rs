//! Meshes for the measurement of transfers.

use nalgebra::{Point3, Rotation3, Vector3};
use relievo::mesh::{ClosestPoints, TriMesh};
use relievo::texture::retile;
use relievo::transfer::Transferred;

/// A mesh with a color a vertex.
#[derive(Debug)]
pub(crate) struct Colored {
    pub(crate) mesh: TriMesh,
    pub(crate) colors: Vec<[f64; 3]>,
}

/// A knobbly ring of about so many vertices, with `knobs` knobs and spots on stripes.
pub(crate) fn ring(vertices: usize, knobs: f64) -> Colored {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few hundred"
    )]
    let rows = (vertices as f64 / 2.0).sqrt().round() as u32;
    let columns = 2 * rows;
    let mut made = Colored {
        mesh: TriMesh::default(),
        colors: Vec::new(),
    };
    for i in 0..columns {
        for j in 0..rows {
            let u = std::f64::consts::TAU * f64::from(i) / f64::from(columns);
            let v = std::f64::consts::TAU * f64::from(j) / f64::from(rows);
            let thick =
                0.4 + 0.1 * (knobs * u).cos() * (1.0 + 0.5 * u.sin()) + 0.05 * (2.0 * v + u).sin();
            let out = 1.0 + 0.2 * (u + 0.3).cos() + thick * v.cos();
            made.mesh
                .positions
                .push(Point3::new(out * u.cos(), thick * v.sin(), out * u.sin()));
            let stripe = 0.5 + 0.5 * (20.0 * u + 2.0 * (3.0 * v).sin()).tanh_wave();
            let spot = 0.5 + 0.5 * (17.0 * v + 5.0 * u.sin()).tanh_wave();
            made.colors.push([stripe, 0.5 * (stripe + spot), spot]);
            let at = |i: u32, j: u32| (i % columns) * rows + j % rows;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            made.mesh.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    made
}

trait Wave {
    fn tanh_wave(self) -> f64;
}

impl Wave for f64 {
    /// A wave with steep flanks.
    fn tanh_wave(self) -> f64 {
        (3.0 * self.sin()).tanh()
    }
}

/// A copy, turned about y, scaled, and with other vertices and triangles.
#[derive(Debug)]
pub(crate) struct Copied {
    pub(crate) mesh: TriMesh,
    turn: Rotation3<f64>,
    scale: f64,
}

pub(crate) fn copy(mesh: &TriMesh) -> Copied {
    let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), 0.7);
    let scale = 2.5;
    let other = retile(mesh, &[mesh.positions.len() * 5 / 4]).remove(0).mesh;
    Copied {
        mesh: TriMesh {
            positions: other.positions.iter().map(|p| turn * p * scale).collect(),
            triangles: other.triangles,
        },
        turn,
        scale,
    }
}

impl Copied {
    /// Where a point of the copy is on the original.
    pub(crate) fn back(&self, p: &Point3<f64>) -> Point3<f64> {
        self.turn.inverse() * (p / self.scale)
    }
}

/// The mean difference of colors from those of the source at the same place, and that of the colors of the source's nearest
/// corners: no copy of single vertices can be better.
pub(crate) fn error(
    source: &Colored,
    transferred: &Transferred,
    back: impl Fn(&Point3<f64>) -> Point3<f64>,
) -> [f64; 2] {
    let closest = ClosestPoints::new(&source.mesh);
    let colors = transferred.colors.iter().flatten();
    let mut sums = [0.0; 2];
    for (p, color) in transferred.finer.mesh.positions.iter().zip(colors) {
        let Some((triangle, shares, _)) = closest.closest(&back(p), None) else {
            return [f64::NAN; 2];
        };
        let corners = source.mesh.triangles[triangle as usize].map(|v| source.colors[v as usize]);
        let nearest = (0..3).max_by(|a, b| shares[*a].total_cmp(&shares[*b]));
        for k in 0..3 {
            let expected: f64 = (0..3).map(|i| shares[i] * corners[i][k]).sum();
            sums[0] += (color[k] - expected).abs() / 3.0;
            sums[1] += (corners[nearest.unwrap_or(0)][k] - expected).abs() / 3.0;
        }
    }
    sums.map(|sum| sum / transferred.finer.mesh.positions.len() as f64)
}
