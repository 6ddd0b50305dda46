//! The same surface with more vertices.

mod edges;

use nalgebra::center;

use super::TriMesh;
use edges::Edges;

/// A mesh whose longest edges were halved.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bisected {
    /// The mesh: the original vertices first, in their order and bit by bit where they were.
    pub mesh: TriMesh,
    /// For each new vertex, in their order, the ends of the edge that it halves, the lower number first. They
    /// may be new ones themselves, with lower numbers than its own.
    pub parents: Vec<[u32; 2]>,
    /// #F: the original triangle that each triangle is a part of.
    pub faces: Vec<u32>,
}

impl Bisected {
    /// Number of the original vertices.
    #[must_use]
    pub fn originals(&self) -> usize {
        self.mesh.positions.len() - self.parents.len()
    }

    /// Values at all vertices from those at the original ones: the original ones as they are, then the means of
    /// the parents', which is linear on each original triangle.
    ///
    /// # Panics
    /// If there are not as many values as original vertices.
    #[must_use]
    pub fn interpolate<const N: usize>(&self, values: &[[f64; N]]) -> Vec<[f64; N]> {
        let vertices = self.mesh.positions.len();
        assert_eq!(
            values.len(),
            self.originals(),
            "one row for each original vertex"
        );
        let mut all = Vec::with_capacity(vertices);
        all.extend_from_slice(values);
        for [a, b] in &self.parents {
            let (a, b): ([f64; N], [f64; N]) = (all[*a as usize], all[*b as usize]);
            all.push(std::array::from_fn(|k| 0.5 * (a[k] + b[k])));
        }
        all
    }
}

/// The same surface with at least `vertices` vertices (those that no triangle uses count): the longest edge is
/// halved, with all triangles at it, again and again.
///
/// A triangle is only ever cut through its longest edge, hence no angle becomes less than half the least one of
/// the original triangle. Of edges of equal length the one with the lower numbers is taken first, so that the
/// vertices do not depend on the order of the triangles. Boundaries stay boundaries; at an edge of more than two
/// triangles all are cut.
///
/// A mesh that has enough vertices comes back as it is. Edges without a length, or of one that is not finite, are
/// never halved, and triangles with the same vertex twice stay as they are: a mesh without any other edge keeps
/// fewer vertices. New vertices are on the surface but for rounding.
///
/// # Panics
/// If there are 2³² vertices or more, or a third as many triangles.
///
/// # Reference
/// M.-C. Rivara: *Algorithms for refining triangular grids suitable for adaptive and multigrid techniques.*
/// International Journal for Numerical Methods in Engineering 20(4), 1984, 745–756. The angles: I. G. Rosenberg,
/// F. Stenger: *A lower bound on the angles of triangles constructed by bisecting the longest side.* Mathematics
/// of Computation 29(130), 1975, 390–395.
#[must_use]
pub fn bisected(mesh: &TriMesh, vertices: usize) -> Bisected {
    let faces = u32::try_from(mesh.triangles.len()).expect("indices are u32");
    let mut bisected = Bisected {
        mesh: mesh.clone(),
        parents: Vec::new(),
        faces: (0..faces).collect(),
    };
    if mesh.positions.len() >= vertices {
        return bisected;
    }
    let mut edges = Edges::new(mesh);
    while bisected.mesh.positions.len() < vertices
        && let Some(edge) = edges.longest()
    {
        halve(&mut bisected, &mut edges, edge);
    }
    bisected
}

/// Cuts all triangles at an edge from its middle to their third corners.
fn halve(bisected: &mut Bisected, edges: &mut Edges, edge: u32) {
    let Bisected {
        mesh,
        parents,
        faces,
    } = bisected;
    let ends = edges.ends[edge as usize];
    let middle = index(mesh.positions.len());
    let [p, q] = ends.map(|v| mesh.positions[v as usize]);
    mesh.positions.push(center(&p, &q));
    parents.push(ends);
    let parts = ends.map(|end| edges.add(end, middle, &mesh.positions));
    let mut around = edges.around(edge);
    // Parts of triangles are appended in the order of these.
    around.sort_unstable();
    let corners = |h: u32, triangles: &[[u32; 3]]| {
        let (f, k) = (h as usize / 3, h as usize % 3);
        [0, 1, 2].map(|i| triangles[f][(k + i) % 3])
    };
    let third = |h: &u32| corners(*h, &mesh.triangles)[2];
    // Several triangles can have the same third corner.
    let mut thirds: Vec<u32> = around.iter().map(third).collect();
    thirds.sort_unstable();
    thirds.dedup();
    let cuts: Vec<u32> = (thirds.iter())
        .map(|third| edges.add(*third, middle, &mesh.positions))
        .collect();
    for h in around {
        let [first, _, third] = corners(h, &mesh.triangles);
        let (f, k) = (h / 3, h as usize % 3);
        // The triangle keeps its first corner here, its part has the second one.
        let mut part = mesh.triangles[f as usize];
        part[k] = middle;
        mesh.triangles[f as usize][(k + 1) % 3] = middle;
        let g = index(mesh.triangles.len());
        mesh.triangles.push(part);
        faces.push(faces[f as usize]);
        edges.make_room();
        let half_edge = |triangle: u32, step: usize| 3 * triangle + index((k + step) % 3);
        edges.replace(half_edge(f, 1), half_edge(g, 1));
        let [of_first, of_second] = if first == ends[0] {
            parts
        } else {
            [parts[1], parts[0]]
        };
        edges.attach(half_edge(f, 0), of_first);
        edges.attach(half_edge(g, 0), of_second);
        if let Ok(at) = thirds.binary_search(&third) {
            edges.attach(half_edge(f, 1), cuts[at]);
            edges.attach(half_edge(g, 2), cuts[at]);
        }
    }
}

fn index(number: usize) -> u32 {
    u32::try_from(number).expect("indices are u32")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{
        Adjacency, boundary_loops, edge_lengths, euler_characteristic, surface_area,
        triangle_normal,
    };
    use crate::rng::{Rng, Stage};
    use approx::assert_relative_eq;
    use nalgebra::Point3;

    /// A bumpy ring of `2 · around` triangles with two boundaries, and a vertex that no triangle uses.
    fn ring(around: u32) -> TriMesh {
        let mut rng = Rng::new(7, Stage::Synth, 0);
        let mut mesh = TriMesh::default();
        for k in 0..around {
            let angle = f64::from(k) / f64::from(around) * std::f64::consts::TAU;
            for radius in [1.0, 1.7] {
                let radius = radius + 0.2 * rng.uniform();
                let height = rng.uniform();
                let (sin, cos) = angle.sin_cos();
                (mesh.positions).push(Point3::new(radius * cos, radius * sin, height));
            }
            let [a, b] = [2 * k, 2 * k + 1];
            let [c, d] = [a, b].map(|v| (v + 2) % (2 * around));
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
        mesh.positions.push(Point3::new(9.0, 9.0, 9.0));
        mesh
    }

    fn longest(mesh: &TriMesh) -> f64 {
        edge_lengths(mesh).into_iter().fold(0.0, f64::max)
    }

    /// The least angle of each triangle.
    fn least_angles(mesh: &TriMesh) -> Vec<f64> {
        let angle = |p: Point3<f64>, q: Point3<f64>, r: Point3<f64>| (q - p).angle(&(r - p));
        (0..mesh.triangles.len())
            .map(|f| {
                let [a, b, c] = mesh.corners(f);
                angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b))
            })
            .collect()
    }

    #[test]
    fn the_surface_stays_and_its_edges_become_shorter() {
        let mesh = ring(12);
        let mut before = f64::INFINITY;
        for vertices in [26, 60, 200, 1001] {
            let finer = bisected(&mesh, vertices);
            crate::mesh::check(&finer.mesh).unwrap();
            assert_eq!(finer.mesh.positions.len(), vertices);
            assert_eq!(finer.mesh.positions[..25], mesh.positions);
            assert_eq!(finer.parents.len(), vertices - 25);
            assert_eq!(finer.faces.len(), finer.mesh.triangles.len());
            assert_eq!(euler_characteristic(&finer.mesh), 0);
            assert_eq!(
                boundary_loops(&finer.mesh, &Adjacency::new(&finer.mesh)).len(),
                2
            );
            assert_relative_eq!(
                surface_area(&finer.mesh),
                surface_area(&mesh),
                max_relative = 1e-12
            );
            assert!(longest(&finer.mesh) <= before);
            before = longest(&finer.mesh);
        }
        assert!(before < 0.25 * longest(&mesh));
    }

    #[test]
    fn parts_of_a_triangle_are_in_its_plane_and_make_up_its_area() {
        let mesh = ring(9);
        let finer = bisected(&mesh, 500);
        let mut sums = vec![nalgebra::Vector3::zeros(); mesh.triangles.len()];
        for (f, face) in finer.faces.iter().enumerate() {
            let normal = triangle_normal(finer.mesh.corners(f));
            let whole = triangle_normal(mesh.corners(*face as usize));
            assert!(normal.angle(&whole) < 1e-6, "turned or tilted");
            sums[*face as usize] += normal;
        }
        for (f, sum) in sums.iter().enumerate() {
            let whole = triangle_normal(mesh.corners(f));
            assert!((sum - whole).norm() < 1e-12 * whole.norm());
        }
    }

    #[test]
    fn no_angle_is_less_than_half_the_least_one() {
        let mesh = ring(10);
        let before = least_angles(&mesh);
        let finer = bisected(&mesh, 3000);
        for (angle, face) in least_angles(&finer.mesh).into_iter().zip(&finer.faces) {
            assert!(angle >= 0.5 * before[*face as usize] - 1e-9);
        }
    }

    #[test]
    fn new_vertices_are_halfway_between_parents_with_lower_numbers() {
        let mesh = ring(8);
        let finer = bisected(&mesh, 400);
        let first = mesh.positions.len();
        for (v, [a, b]) in (first..).zip(&finer.parents) {
            assert!(a < b && (*b as usize) < v);
            let [p, q] = [a, b].map(|v| finer.mesh.positions[*v as usize]);
            assert_eq!(finer.mesh.positions[v], center(&p, &q));
        }
        assert!(finer.parents.iter().flatten().any(|p| *p as usize >= first));
        let values: Vec<[f64; 3]> = mesh.positions.iter().map(|p| p.coords.into()).collect();
        let interpolated = finer.interpolate(&values);
        for (value, position) in interpolated.iter().zip(&finer.mesh.positions) {
            assert!((nalgebra::Vector3::from(*value) - position.coords).norm() < 1e-14);
        }
    }

    #[test]
    fn the_order_of_the_triangles_does_not_matter() {
        // A grid has many edges of equal length.
        let side = 6u32;
        let mut mesh = TriMesh::default();
        for row in 0..side {
            for column in 0..side {
                let place = [column, row].map(f64::from);
                mesh.positions.push(Point3::new(place[0], place[1], 0.0));
                if row + 1 < side && column + 1 < side {
                    let a = row * side + column;
                    let [b, c, d] = [a + 1, a + side, a + side + 1];
                    mesh.triangles.extend([[a, b, d], [a, d, c]]);
                }
            }
        }
        let mut other = mesh.clone();
        other.triangles.reverse();
        for triangle in &mut other.triangles {
            triangle.rotate_left(1);
        }
        let [one, two] = [&mesh, &other].map(|mesh| bisected(mesh, 333));
        assert_eq!(one.mesh.positions, two.mesh.positions);
        assert_eq!(one.parents, two.parents);
        let sets = [one, two].map(|finer| {
            let mut triangles: Vec<[u32; 3]> = finer.mesh.triangles;
            for triangle in &mut triangles {
                let least = (0..3).min_by_key(|k| triangle[*k]).unwrap();
                triangle.rotate_left(least);
            }
            triangles.sort_unstable();
            triangles
        });
        assert_eq!(sets[0], sets[1]);
    }

    #[test]
    fn all_triangles_at_an_edge_are_cut() {
        // Three wings, one of them doubled.
        let mesh = TriMesh {
            positions: vec![
                Point3::new(0.0, 0.0, 0.0),
                Point3::new(0.0, 0.0, 4.0),
                Point3::new(1.0, 0.0, 2.0),
                Point3::new(-1.0, 1.0, 2.0),
                Point3::new(-1.0, -1.0, 2.0),
            ],
            triangles: vec![[0, 1, 2], [0, 1, 3], [1, 0, 4], [1, 0, 4]],
        };
        let finer = bisected(&mesh, 6);
        assert_eq!(finer.parents, [[0, 1]]);
        assert_eq!(finer.faces, [0, 1, 2, 3, 0, 1, 2, 3]);
        assert_eq!(
            finer.mesh.triangles,
            [
                [0, 5, 2],
                [0, 5, 3],
                [1, 5, 4],
                [1, 5, 4],
                [5, 1, 2],
                [5, 1, 3],
                [5, 0, 4],
                [5, 0, 4]
            ]
        );
        let much_finer = bisected(&mesh, 300);
        assert_relative_eq!(
            surface_area(&much_finer.mesh),
            surface_area(&mesh),
            max_relative = 1e-12
        );
    }

    #[test]
    fn what_is_fine_enough_or_cannot_be_cut_comes_back_as_it_is() {
        let mesh = ring(5);
        for vertices in [0, 11] {
            let same = bisected(&mesh, vertices);
            assert_eq!(same.mesh, mesh);
            assert!(same.parents.is_empty());
            assert_eq!(same.faces, (0..10).collect::<Vec<u32>>());
        }
        let nan = Point3::new(f64::NAN, 0.0, 0.0);
        let next = Point3::new(1.0f64.next_up(), 0.0, 0.0);
        let one = Point3::new(1.0, 0.0, 0.0);
        for (positions, triangles) in [
            (vec![], vec![]),
            (vec![one; 3], vec![]),
            (vec![one; 3], vec![[0, 1, 2]]),
            (vec![one, Point3::origin()], vec![[0, 0, 1]]),
            (vec![nan; 3], vec![[0, 1, 2]]),
            (vec![one, one, next], vec![[0, 1, 2]]),
        ] {
            let mesh = TriMesh {
                positions,
                triangles,
            };
            let same = bisected(&mesh, 100);
            assert_eq!(same.mesh.positions.len(), mesh.positions.len());
            assert_eq!(same.mesh.triangles, mesh.triangles);
        }
    }

    #[test]
    fn a_triangle_with_a_zero_edge_is_cut_through_the_others() {
        let mesh = TriMesh {
            positions: vec![
                Point3::origin(),
                Point3::origin(),
                Point3::new(8.0, 0.0, 0.0),
            ],
            triangles: vec![[0, 1, 2]],
        };
        let finer = bisected(&mesh, 9);
        assert_eq!(finer.mesh.positions.len(), 9);
        assert!(longest(&finer.mesh) < 4.5);
        assert_eq!(euler_characteristic(&finer.mesh), 1);
    }
}
