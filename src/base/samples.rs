//! The mesh's vertices as the fit sees them: centered, scaled, weighted.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use super::params::Weighting;
use super::{BaseSurface, FitError};
use crate::mesh::{TriMesh, vertex_areas, vertex_normals};
use crate::rng::Rng;

/// A vertex counts at most this many times the median one.
const MAX_WEIGHT: f64 = 8.0;

/// Vertices nearer to one line than this share of the mesh's extent are on the line: rounding of
/// coordinates that are a million times the extent leaves 1e-10.
const COLLINEAR: f64 = 1e-9;

/// Points with unit normals (zero where unknown) and weights.
#[derive(Debug, Clone, Default)]
pub(super) struct Samples {
    pub(super) points: Vec<Point3<f64>>,
    pub(super) normals: Vec<Vector3<f64>>,
    pub(super) weights: Vec<f64>,
}

/// The mesh in coordinates in which its centroid is the origin and half its diagonal is 1.
#[derive(Debug)]
pub(super) struct Normalized {
    /// The used vertices.
    pub(super) samples: Samples,
    /// Triangles by index of `samples`.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Sum of the area normals of all triangles.
    pub(super) facing: Vector3<f64>,
    center: Point3<f64>,
    /// Half the diagonal, in the scan's unit.
    pub(super) unit: f64,
}

impl Normalized {
    pub(super) fn new(
        positions: &[Point3<f64>],
        triangles: &[[u32; 3]],
        weighting: Weighting,
    ) -> Result<Self, FitError> {
        let TriMesh {
            positions: used,
            triangles,
        } = used_part(positions, triangles)?;
        let Some(&first) = used.first() else {
            return Err(FitError::TooFewVertices {
                found: 0,
                needed: 3,
            });
        };
        let (low, high) = used
            .iter()
            .fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
        // Halved before they are subtracted, so that nothing overflows.
        let (half_low, half_high) = (low.coords * 0.5, high.coords * 0.5);
        let largest = (half_high - half_low).amax();
        if largest == 0.0 {
            return Err(FitError::Coincident);
        }
        let unit = ((half_high - half_low) / largest).norm() * largest;
        let scaled = |p: &Point3<f64>| (p.coords * 0.5 - half_low) / (0.5 * unit);
        let count = used.len() as f64;
        let mean = used.iter().map(scaled).sum::<Vector3<f64>>() / count;
        let center = low + mean * unit;
        let points: Vec<_> = used
            .iter()
            .map(|p| Point3::from((p.coords * 0.5 - center.coords * 0.5) / (0.5 * unit)))
            .collect();
        if is_collinear(&points) {
            return Err(FitError::Collinear);
        }
        let mesh = TriMesh {
            positions: points,
            triangles,
        };
        let weights = match weighting {
            Weighting::Area => capped(vertex_areas(&mesh)),
            Weighting::Uniform => vec![1.0; mesh.positions.len()],
        };
        let facing = (0..mesh.triangles.len())
            .map(|f| crate::mesh::triangle_normal(mesh.corners(f)))
            .sum();
        Ok(Self {
            samples: Samples {
                normals: vertex_normals(&mesh),
                points: mesh.positions,
                weights,
            },
            triangles: mesh.triangles,
            facing,
            center,
            unit,
        })
    }

    /// A surface of the normalised mesh in the mesh's own coordinates.
    pub(super) fn to_mesh(&self, surface: &BaseSurface) -> BaseSurface {
        let point = |p: Point3<f64>| self.center + p.coords * self.unit;
        let mut surface = *surface;
        match &mut surface {
            BaseSurface::Plane(plane) => plane.point = point(plane.point),
            BaseSurface::Sphere(sphere) => {
                sphere.center = point(sphere.center);
                sphere.radius *= self.unit;
            }
            BaseSurface::Cylinder(cylinder) => {
                cylinder.point = point(cylinder.point);
                cylinder.radius *= self.unit;
            }
            BaseSurface::Cone(cone) => cone.apex = point(cone.apex),
        }
        surface
    }
}

/// The vertices that a triangle uses, and the triangles by their new indices.
fn used_part(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<TriMesh, FitError> {
    const UNUSED: u32 = u32::MAX;
    let mut new_index = vec![UNUSED; positions.len()];
    for (triangle, corners) in triangles.iter().enumerate() {
        for &vertex in corners {
            match new_index.get_mut(vertex as usize) {
                Some(index) => *index = 0,
                None => return Err(FitError::NoSuchVertex { triangle, vertex }),
            }
        }
    }
    let mut used = Vec::new();
    let mut next = 0u32;
    for (v, index) in new_index.iter_mut().enumerate() {
        if *index == UNUSED {
            continue;
        }
        let p = positions[v];
        if !p.iter().all(|x| x.is_finite()) {
            return Err(FitError::NotFinite(v));
        }
        used.push(p);
        *index = next;
        next += 1;
    }
    let triangles = triangles
        .iter()
        .map(|t| t.map(|v| new_index[v as usize]))
        .collect();
    Ok(TriMesh {
        positions: used,
        triangles,
    })
}

/// Areas as weights of mean 1, none above [`MAX_WEIGHT`] times the median; all the same if there is
/// no area.
fn capped(mut areas: Vec<f64>) -> Vec<f64> {
    let mut positive: Vec<f64> = areas.iter().copied().filter(|a| *a > 0.0).collect();
    if positive.is_empty() {
        return vec![1.0; areas.len()];
    }
    let middle = positive.len() / 2;
    let median = *positive.select_nth_unstable_by(middle, f64::total_cmp).1;
    for area in &mut areas {
        *area = area.min(MAX_WEIGHT * median);
    }
    let mean = areas.iter().sum::<f64>() / areas.len() as f64;
    areas.iter().map(|a| a / mean).collect()
}

fn is_collinear(points: &[Point3<f64>]) -> bool {
    let directions = covariance(points.iter().map(|p| (p.coords, 1.0)));
    let along = directions[2];
    points
        .iter()
        .all(|p| (p.coords - along * along.dot(&p.coords)).norm() <= COLLINEAR)
}

/// Unit eigenvectors of Σ w v vᵀ, by ascending eigenvalue.
pub(super) fn covariance(vectors: impl Iterator<Item = (Vector3<f64>, f64)>) -> [Vector3<f64>; 3] {
    let matrix: Matrix3<f64> = vectors.map(|(v, w)| v * v.transpose() * w).sum();
    let eigen = SymmetricEigen::new(matrix);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    order.map(|i| eigen.eigenvectors.column(i).into_owned())
}

impl Samples {
    /// Weighted mean of the points.
    pub(super) fn mean(&self) -> Point3<f64> {
        let sum: Vector3<f64> = self
            .points
            .iter()
            .zip(&self.weights)
            .map(|(p, w)| p.coords * *w)
            .sum();
        Point3::from(sum / self.weights.iter().sum::<f64>())
    }

    /// Signed heights over a surface.
    pub(super) fn heights(&self, surface: &BaseSurface) -> Vec<f64> {
        self.points.iter().map(|p| surface.height(p)).collect()
    }

    /// About `count` samples of equal weight: one in each stretch of equal weight, in order, at a
    /// random place of it, because an even stride through a range grid can lock to its columns.
    pub(super) fn thinned(&self, count: usize, rng: &mut Rng) -> Self {
        if self.points.len() <= count {
            return self.clone();
        }
        let step = self.weights.iter().sum::<f64>() / count as f64;
        let mut thin = Self::default();
        let (mut passed, mut taken) = (0.0, 0.0);
        let mut next = step * rng.uniform();
        for ((p, n), w) in self.points.iter().zip(&self.normals).zip(&self.weights) {
            passed += w;
            while passed > next {
                thin.points.push(*p);
                thin.normals.push(*n);
                thin.weights.push(1.0);
                taken += 1.0;
                next = step * (taken + rng.uniform());
            }
        }
        thin
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stage;

    #[test]
    fn thinning_follows_the_weights() {
        let n = 10_000;
        let samples = Samples {
            points: (0..n)
                .map(|i| Point3::new(f64::from(i), 0.0, 0.0))
                .collect(),
            normals: vec![Vector3::x(); 10_000],
            weights: (0..n).map(|i| if i < 5_000 { 3.0 } else { 1.0 }).collect(),
        };
        let thin = samples.thinned(1000, &mut Rng::new(0, Stage::Fit, 0));
        let heavy = thin.points.iter().filter(|p| p.x < 5000.0).count();
        assert!(thin.points.len().abs_diff(1000) <= 1);
        assert!(heavy.abs_diff(750) <= 1, "{heavy}");
    }

    #[test]
    fn weights_are_capped_areas_of_mean_one() {
        let mut areas = vec![2.0; 99];
        areas.push(1e6);
        let weights = capped(areas);
        assert!((weights[99] / weights[0] - 8.0).abs() < 1e-12);
        assert!((weights.iter().sum::<f64>() - 100.0).abs() < 1e-9);
    }
}
