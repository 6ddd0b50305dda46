//! Geodesic affinities: how near each vertex is, over the surface, to the places whose correspondence is known.
//!
//! Distances on two surfaces differ even where they correspond: a leg is longer on one. The target's vectors of
//! distances are therefore mapped affinely so that those at the known places become those of the source, by the
//! map that changes least. Near places count, far ones hardly: each distance d becomes exp(−d² / 2σ²).
//!
//! # Reference
//! [MeshMatch 2012](crate::bibliography#meshmatch-2012), its shape features from correspondences.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;

use super::{Features, Geodesics};
use crate::mesh::TriMesh;
use crate::transfer::Pair;

/// Singular values below this share of the largest are left out of the map: the distances themselves are no more
/// exact than some per cent, and what hangs on smaller ones would be magnified errors.
const LEAST_SINGULAR: f64 = 1e-3;

/// Instead of an infinite distance, while the map is applied, in largest finite distances.
const FAR: f64 = 2.0;

/// Rows that are mapped at once.
const ROWS: usize = 1024;

/// Affinities of all vertices of the source, and of the target, to each pair's places: from 1 there to 0 far
/// away, and on connected pieces that hold none of them. One number a pair; without unit, the same for a mesh
/// of another size.
///
/// σ is a third of the largest distance on the source. Where more pairs are given than an affine map can send to
/// their places, they are met as well as possible.
///
/// # Panics
/// If a pair's vertex is not one of its mesh.
#[must_use]
pub fn affinities(source: &TriMesh, target: &TriMesh, pairs: &[Pair]) -> [Features; 2] {
    let sources: Vec<&[u32]> = pairs
        .iter()
        .map(|p| std::slice::from_ref(&p.source))
        .collect();
    let targets: Vec<&[u32]> = pairs.iter().map(|p| p.targets.as_slice()).collect();
    let (on_source, on_target) = rayon::join(
        || Distances::new(source, &sources),
        || Distances::new(target, &targets),
    );
    let (Some(on_source), Some(on_target)) = (on_source, on_target) else {
        return [source, target].map(|mesh| Features {
            count: pairs.len(),
            values: vec![0.0; pairs.len() * mesh.positions.len()],
        });
    };
    let far = FAR * on_source.largest.max(on_target.largest);
    let sigma = on_source.largest / 3.0;
    let map = AffineMap::between(&on_source, &on_target, pairs, far);
    [
        features(&on_source, sigma, |row| row.to_owned(), far),
        features(&on_target, sigma, |row| map.apply(row), far),
    ]
}

/// Distances over a surface in units of its size.
struct Distances {
    /// #V by #pairs, infinite where there is no way.
    values: Mat<f64>,
    /// The largest finite one.
    largest: f64,
}

impl Distances {
    fn new(mesh: &TriMesh, sets: &[&[u32]]) -> Option<Self> {
        let geodesics = Geodesics::new(mesh)?;
        let size = geodesics.area().sqrt();
        let columns = geodesics.distances_to_each(sets);
        let values = Mat::from_fn(mesh.positions.len(), sets.len(), |v, k| {
            columns[k][v] / size
        });
        let finite = columns.iter().flatten().filter(|d| d.is_finite());
        let largest = finite.fold(0.0f64, |largest, d| largest.max(*d)) / size;
        Some(Self { values, largest })
    }

    /// A vertex's distances, no longer than `far`.
    fn at(&self, v: u32, far: f64) -> impl Iterator<Item = f64> {
        let row = self.values.row(v as usize);
        row.iter()
            .map(|d| d.min(far))
            .collect::<Vec<_>>()
            .into_iter()
    }
}

/// d ↦ d + difference · (d, 1), for vectors d of distances.
struct AffineMap {
    /// #pairs by #pairs + 1.
    difference: Mat<f64>,
}

impl AffineMap {
    /// The map of least difference from the identity that sends the distances at every place of the target to those
    /// at the source's place that it belongs to; or comes nearest to that.
    fn between(source: &Distances, target: &Distances, pairs: &[Pair], far: f64) -> Self {
        let count = pairs.len();
        let places: Vec<(u32, u32)> = (pairs.iter())
            .flat_map(|pair| pair.targets.iter().map(|target| (pair.source, *target)))
            .collect();
        let mut given = Mat::from_fn(count + 1, places.len(), |_, _| 1.0);
        let mut lacking = Mat::zeros(count, places.len());
        for (j, (at_source, at_target)) in places.iter().enumerate() {
            let wanted = source.at(*at_source, far);
            for (i, (wanted, is)) in wanted.zip(target.at(*at_target, far)).enumerate() {
                given[(i, j)] = is;
                lacking[(i, j)] = wanted - is;
            }
        }
        Self {
            difference: least_solution(&given, &lacking)
                .unwrap_or_else(|| Mat::zeros(count, count + 1)),
        }
    }

    /// Maps rows of vectors.
    fn apply(&self, rows: &Mat<f64>) -> Mat<f64> {
        let count = rows.ncols();
        let mut mapped = Mat::from_fn(rows.nrows(), count, |v, i| {
            rows[(v, i)] + self.difference[(i, count)]
        });
        let linear = self.difference.as_ref().subcols(0, count);
        matmul(
            mapped.as_mut(),
            Accum::Add,
            rows,
            linear.transpose(),
            1.0,
            Par::Seq,
        );
        mapped
    }
}

/// The x of least norm (Frobenius) for which x · `given` comes nearest to `wanted`: by the pseudo-inverse, small
/// singular values left out.
fn least_solution(given: &Mat<f64>, wanted: &Mat<f64>) -> Option<Mat<f64>> {
    let svd = given.thin_svd().ok()?;
    let values: Vec<f64> = svd.S().column_vector().iter().copied().collect();
    let least = LEAST_SINGULAR * values.iter().copied().fold(0.0, f64::max);
    let mut coefficients = wanted * svd.V();
    for (column, value) in coefficients.col_iter_mut().zip(&values) {
        let factor = if *value > least { 1.0 / value } else { 0.0 };
        column.iter_mut().for_each(|x| *x *= factor);
    }
    Some(coefficients * svd.U().transpose())
}

/// exp(−d² / 2σ²) of all mapped distances, by blocks of rows.
fn features(
    distances: &Distances,
    sigma: f64,
    map: impl Fn(&Mat<f64>) -> Mat<f64> + Sync,
    far: f64,
) -> Features {
    let values = distances.values.as_ref();
    let (rows, count) = (values.nrows(), values.ncols());
    let block = |k: usize| {
        let from = k * ROWS;
        let exact = values.subrows(from, ROWS.min(rows - from));
        let near = Mat::from_fn(exact.nrows(), count, |v, i| exact[(v, i)].min(far));
        let mapped = map(&near);
        (0..exact.nrows())
            .flat_map(|v| (0..count).map(move |i| (v, i)))
            .map(|place| affinity(exact[place], mapped[place], sigma))
            .collect::<Vec<f32>>()
    };
    let blocks: Vec<Vec<f32>> = (0..rows.div_ceil(ROWS))
        .into_par_iter()
        .map(block)
        .collect();
    Features {
        count,
        values: blocks.concat(),
    }
}

fn affinity(distance: f64, mapped: f64, sigma: f64) -> f32 {
    if !distance.is_finite() {
        return 0.0;
    }
    // The map may go below zero near a place; and where a surface is one point, σ is zero.
    let mapped = mapped.max(0.0);
    let exponent = if mapped > 0.0 {
        -0.5 * (mapped / sigma).powi(2)
    } else {
        0.0
    };
    #[expect(
        clippy::cast_possible_truncation,
        reason = "features are stored in single precision"
    )]
    let value = exponent.exp() as f32;
    value
}

#[cfg(test)]
mod tests {
    use super::super::test_shapes::{grid, icosphere, together};
    use super::*;
    use nalgebra::{Point3, Rotation3, Vector3};

    fn one_to_one(pairs: &[[u32; 2]]) -> Vec<Pair> {
        let pair = |[source, target]: [u32; 2]| Pair {
            source,
            targets: vec![target],
        };
        pairs.iter().copied().map(pair).collect()
    }

    fn same(vertices: &[u32]) -> Vec<Pair> {
        one_to_one(&vertices.iter().map(|v| [*v, *v]).collect::<Vec<_>>())
    }

    fn largest_difference([a, b]: &[Features; 2]) -> f32 {
        assert_eq!((a.count, a.values.len()), (b.count, b.values.len()));
        let differences = a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs());
        differences.fold(0.0, f32::max)
    }

    fn egg() -> TriMesh {
        let mut mesh = icosphere(3);
        for p in &mut mesh.positions {
            *p = Point3::new(2.0 * p.x, (1.2 + 0.3 * p.x) * p.y, p.z);
        }
        mesh
    }

    #[test]
    fn a_copy_moved_and_scaled_has_the_same() {
        let mesh = egg();
        let mut copy = mesh.clone();
        let rotation = Rotation3::from_scaled_axis(Vector3::new(0.4, -0.9, 0.3));
        for p in &mut copy.positions {
            *p = rotation * (*p * 30.0) + Vector3::new(5.0, 6.0, -7.0);
        }
        let both = affinities(&mesh, &copy, &same(&[0, 3, 5, 100, 300]));
        assert_eq!(both[0].count, 5);
        assert!(largest_difference(&both) < 1e-5);
        for (k, v) in [0usize, 3, 5, 100, 300].into_iter().enumerate() {
            assert!((both[0].values[5 * v + k] - 1.0).abs() < 1e-6);
        }
        // The farthest is three σ away.
        let least = both[0].values.iter().copied().fold(1.0, f32::min);
        assert!((least - (-4.5f32).exp()).abs() < 1e-4, "{least}");
    }

    #[test]
    fn a_bent_strip_has_nearly_the_same_as_the_flat_one() {
        let flat = grid(40, 13, |x, y| [0.1 * x, 0.1 * y, 0.0]);
        let bent = grid(40, 13, |x, y| [(0.1 * x).sin(), 0.1 * y, (0.1 * x).cos()]);
        let both = affinities(&flat, &bent, &same(&[0, 39, 500, 250]));
        assert!(largest_difference(&both) < 0.01);
    }

    #[test]
    fn the_map_sends_the_places_of_another_shape_where_they_belong() {
        let sphere = icosphere(3);
        // Of the same vertices, but another shape, and one place of the source is two of the target.
        let mut pairs = same(&[0, 3, 5, 8, 100, 300]);
        pairs[5].targets.push(310);
        let [source, target] = affinities(&sphere, &egg(), &pairs);
        let row = |of: &Features, v: u32| of.values[6 * v as usize..][..6].to_vec();
        for pair in &pairs {
            for place in &pair.targets {
                for (a, b) in row(&source, pair.source).iter().zip(row(&target, *place)) {
                    assert!((a - b).abs() < 0.01, "{pair:?}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn of_all_maps_the_one_nearest_to_the_identity_is_taken() {
        // One equation, x · (3, 4) = 10.
        let given = Mat::from_fn(2, 1, |i, _| [3.0, 4.0][i]);
        let x = least_solution(&given, &Mat::from_fn(1, 1, |_, _| 10.0)).unwrap();
        assert!((x[(0, 0)] - 1.2).abs() < 1e-12 && (x[(0, 1)] - 1.6).abs() < 1e-12);
        // Three for one unknown: their mean.
        let ones = Mat::from_fn(1, 3, |_, _| 1.0);
        let x = least_solution(&ones, &Mat::from_fn(1, 3, |_, j| [1.0, 2.0, 6.0][j])).unwrap();
        assert!((x[(0, 0)] - 3.0).abs() < 1e-12);
    }

    #[test]
    fn pieces_without_a_place_have_none() {
        let two = together(egg(), &icosphere(1));
        let [source, target] = affinities(&egg(), &two, &same(&[0, 100]));
        let (first, second) = target.values.split_at(source.values.len());
        assert!(first.iter().all(|a| *a > 0.0));
        assert!(second.iter().all(|a| *a == 0.0));
        let spread = one_to_one(&[[0, 0], [100, 650]]);
        for features in affinities(&egg(), &two, &spread) {
            assert!(features.values.iter().all(|a| (0.0..=1.0).contains(a)));
        }
    }

    #[test]
    fn they_are_the_same_for_any_number_of_threads() {
        let meshes = [icosphere(4), egg()];
        let solved = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pairs = one_to_one(&[[0, 3], [100, 50], [2000, 600]]);
            pool.unwrap()
                .install(|| affinities(&meshes[0], &meshes[1], &pairs))
        };
        assert_eq!(solved(1), solved(3));
    }
}
