//! A hole filled with targets where no base surface with a chart lies under it.

use nalgebra::{Point3, Vector3};

use crate::mesh::{Adjacency, PointTree, TriMesh, triangle_area};

use super::fill::{Fill, FillError, Gap, MAX_TARGETS};
use super::patch_mesh::PatchMesh;
use super::refine::Refinement;
use super::span::{Polygon, triangulate};

/// Area of the surface around a vertex of an equilateral lattice, over the square of its edge.
const LATTICE_CELL: f64 = 0.866_025_403_784_438_6;

/// An island lies in a hole if it is no farther off its fill than this share of the fill's size.
const ISLAND_DISTANCE: f64 = 0.25;

/// Rounds in which a shift of the rim spreads over the targets: some seven edges deep.
const GIVING_WAY: usize = 50;

/// A hole's triangulation, whose targets can be moved and evened out until the surface is right.
#[derive(Debug, Clone)]
pub struct Spanned {
    /// The scan's vertex of each of the first vertices of the triangulation.
    rim: Vec<u32>,
    mesh: PatchMesh,
    islands: Vec<usize>,
    spacing: f64,
}

impl Spanned {
    /// Spans the gap's first rim over the smooth surface `surface` (the scan's own vertices and triangles,
    /// without its relief) and refines it to targets about `spacing` apart. Islands whose rims lie in the
    /// gap are left open.
    ///
    /// # Errors
    /// [`FillError`]: the rim cannot be spanned, or the spacing asks for too many targets.
    pub fn new(
        gap: &Gap,
        surface: &TriMesh,
        adjacency: &Adjacency,
        spacing: f64,
    ) -> Result<Self, FillError> {
        let scan = Scanned { surface, adjacency };
        let rim = scan.polygon(gap.rims.first().map_or(&[], Vec::as_slice));
        let alone = Self::over(&rim, scan, spacing)?;
        let middle = alone.middle();
        let islands: Vec<usize> = (gap.islands.iter().enumerate())
            .filter(|(_, island)| middle.holds(&scan.polygon(island)))
            .map(|(i, _)| i)
            .collect();
        if islands.is_empty() {
            return Ok(alone);
        }
        let joint = (islands.iter()).fold(rim, |rim, island| {
            rim.with_island(&scan.polygon(&gap.islands[*island]))
        });
        Ok(Self {
            islands,
            ..Self::over(&joint, scan, spacing)?
        })
    }

    fn over(polygon: &Polygon, scan: Scanned, spacing: f64) -> Result<Self, FillError> {
        let mut rim = polygon.vertices.clone();
        rim.sort_unstable();
        rim.dedup();
        let local = |v: u32| local_number(rim.binary_search(&v).unwrap_or(0));
        let mut points: Vec<Point3<f64>> = (rim.iter())
            .map(|v| scan.surface.positions[*v as usize])
            .collect();
        let found = triangulate(polygon, &|a, b| scan.joined(a, b))
            .filter(|triangles| has_no_edge_twice(triangles, |corner| polygon.vertices[corner]));
        let triangles = match found {
            Some(found) => (found.into_iter())
                .map(|t| t.map(|corner| local(polygon.vertices[corner])))
                .collect(),
            // A vertex in the middle, where edges between the rim's own vertices are there already.
            None if polygon.is_simple() => {
                let middle = local_number(points.len());
                points.push(polygon.centroid());
                let sides = (polygon.vertices.iter()).zip(polygon.vertices.iter().cycle().skip(1));
                sides.map(|(a, b)| [local(*a), local(*b), middle]).collect()
            }
            None => return Err(FillError::CannotBeSpanned),
        };
        let mut spanned = Self {
            mesh: PatchMesh::new(points, triangles),
            rim,
            islands: Vec::new(),
            spacing,
        };
        spanned.refine(scan.adjacency)?;
        Ok(spanned)
    }

    /// Evens out the targets, with more of them where the surface has grown.
    ///
    /// # Errors
    /// [`FillError::TooManyTargets`].
    pub fn refine(&mut self, adjacency: &Adjacency) -> Result<(), FillError> {
        let (predicted, spacing) = (self.predicted(), self.spacing);
        if predicted.is_nan() || predicted > MAX_TARGETS {
            return Err(FillError::TooManyTargets { predicted, spacing });
        }
        let rim = &self.rim;
        let joined = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|v| rim[v as usize]);
            adjacency
                .neighbors
                .row(a as usize)
                .binary_search(&b)
                .is_ok()
        };
        let refinement = Refinement {
            rim: rim.len(),
            spacing: self.spacing,
            joined: &joined,
        };
        refinement.run(&mut self.mesh);
        Ok(())
    }

    /// About how many targets there will be: by the area, or along the edges of triangles that are so
    /// narrow that they have hardly any.
    fn predicted(&self) -> f64 {
        let longest = (self.mesh.triangles.iter())
            .flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]])
            .map(|[a, b]| self.mesh.length(a, b))
            .fold(0.0, f64::max);
        let by_area = self.area() / (LATTICE_CELL * self.spacing * self.spacing);
        by_area.max(longest / self.spacing)
    }

    /// The scan's vertices around the gap, ascending: the first vertices of [`triangles`](Self::triangles).
    #[must_use]
    pub fn rim(&self) -> &[u32] {
        &self.rim
    }

    /// Islands left open, as indices into [`Gap::islands`].
    #[must_use]
    pub fn islands(&self) -> &[usize] {
        &self.islands
    }

    /// The targets, numbered on from the rim's last vertex.
    #[must_use]
    pub fn targets(&self) -> &[Point3<f64>] {
        &self.mesh.points[self.rim.len()..]
    }

    /// Triples of numbers of the rim's vertices and the targets, oriented as the scan's.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.mesh.triangles
    }

    /// Moves the rim to where it is on a surface with all the scan's vertices, and the targets to its points
    /// from number `first_target` on.
    ///
    /// # Panics
    /// If the surface has fewer points.
    pub fn move_to(&mut self, surface: &[Point3<f64>], first_target: usize) {
        let count = self.targets().len();
        self.move_targets(&surface[first_target..first_target + count]);
        for (point, v) in self.mesh.points.iter_mut().zip(&self.rim) {
            *point = surface[*v as usize];
        }
    }

    /// Moves the rim to other places not far away; the targets next to it give way.
    ///
    /// # Panics
    /// If there is no place for a vertex of the rim.
    pub fn meet_rim(&mut self, places: &[Point3<f64>]) {
        let mut shifts: Vec<Vector3<f64>> = (self.rim.iter().zip(&self.mesh.points))
            .map(|(v, point)| places[*v as usize] - point)
            .collect();
        shifts.resize(self.mesh.points.len(), Vector3::zeros());
        for _ in 0..GIVING_WAY {
            let means = self.mesh.neighbor_means(&shifts);
            shifts[self.rim.len()..].copy_from_slice(&means[self.rim.len()..]);
        }
        for (point, shift) in self.mesh.points.iter_mut().zip(shifts) {
            *point += shift;
        }
    }

    /// Moves every target.
    ///
    /// # Panics
    /// If there are not as many points as targets.
    pub fn move_targets(&mut self, points: &[Point3<f64>]) {
        self.mesh.points[self.rim.len()..].copy_from_slice(points);
    }

    /// The targets where they are now, numbered on from `first_target`.
    #[must_use]
    pub fn fill(&self, first_target: u32) -> Fill {
        let rim = &self.rim;
        let number = |v: u32| match rim.get(v as usize) {
            Some(scanned) => *scanned,
            None => first_target + (v - local_number(rim.len())),
        };
        Fill {
            targets: self.targets().to_vec(),
            triangles: (self.mesh.triangles.iter())
                .map(|t| t.map(number))
                .collect(),
            islands: self.islands.clone(),
        }
    }

    fn area(&self) -> f64 {
        (self.mesh.triangles.iter())
            .map(|t| triangle_area(t.map(|v| self.mesh.points[v as usize])))
            .sum()
    }

    fn middle(&self) -> Middle {
        Middle {
            tree: PointTree::new(&self.mesh.points),
            rim: self.rim.len(),
            near: ISLAND_DISTANCE * self.area().sqrt(),
            facing: (self.mesh.triangles.iter())
                .map(|t| self.mesh.normal(*t))
                .sum(),
        }
    }
}

/// The middle of a fill, to tell islands in it.
struct Middle {
    tree: PointTree,
    rim: usize,
    near: f64,
    facing: Vector3<f64>,
}

impl Middle {
    /// Whether the rim of an island lies over the middle of the fill, and the island faces the way the
    /// fill does.
    fn holds(&self, island: &Polygon) -> bool {
        let is_over = |p: &Point3<f64>| {
            let nearest = self.tree.nearest(p);
            nearest.index >= self.rim && nearest.distance_sq <= self.near * self.near
        };
        let faces: Vector3<f64> = island.beyond.iter().sum();
        island.len() > 2 && faces.dot(&self.facing) > 0.0 && island.points.iter().all(is_over)
    }
}

/// Whether no directed edge is in two of the triangles.
fn has_no_edge_twice(triangles: &[[usize; 3]], vertex: impl Fn(usize) -> u32) -> bool {
    let mut edges: Vec<[u32; 2]> = (triangles.iter())
        .map(|t| t.map(&vertex))
        .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
        .collect();
    edges.sort_unstable();
    edges.windows(2).all(|pair| pair[0] != pair[1])
}

/// The scan's smooth surface and who is next to whom in it.
#[derive(Clone, Copy)]
struct Scanned<'a> {
    surface: &'a TriMesh,
    adjacency: &'a Adjacency,
}

impl Scanned<'_> {
    fn joined(&self, a: u32, b: u32) -> bool {
        let row = self.adjacency.neighbors.row(a as usize);
        row.binary_search(&b).is_ok()
    }

    fn polygon(&self, walk: &[u32]) -> Polygon {
        let beyond = |i: usize| {
            let (a, b) = (walk[i], walk[(i + 1) % walk.len()]);
            let faces = self.adjacency.triangles.row(a as usize).iter();
            let face =
                (faces.map(|f| *f as usize)).find(|f| self.surface.triangles[*f].contains(&b))?;
            crate::mesh::triangle_normal(self.surface.corners(face)).try_normalize(0.0)
        };
        Polygon {
            vertices: walk.to_vec(),
            points: (walk.iter())
                .map(|v| self.surface.positions[*v as usize])
                .collect(),
            beyond: (0..walk.len())
                .map(|i| beyond(i).unwrap_or_default())
                .collect(),
        }
    }
}

fn local_number(i: usize) -> u32 {
    u32::try_from(i).expect("fewer than the scan's vertices")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{LoopKind, boundary_loops, check, euler_characteristic};

    /// A bent sheet of right triangles with the vertices around some places missing.
    fn sheet(missing: impl Fn(f64, f64) -> bool) -> TriMesh {
        let size = 40u32;
        let at = |i: u32, j: u32| (f64::from(j), f64::from(i));
        let mut mesh = TriMesh::default();
        for i in 0..size {
            for j in 0..size {
                let (x, y) = at(i, j);
                let z = 0.02 * ((x - 20.0).powi(2) + (y - 20.0).powi(2));
                mesh.positions.push(Point3::new(x, y, z));
            }
        }
        for i in 0..size - 1 {
            for j in 0..size - 1 {
                let a = i * size + j;
                for t in [[a, a + 1, a + size + 1], [a, a + size + 1, a + size]] {
                    let gone = |v: &u32| {
                        let (x, y) = at(v / size, v % size);
                        missing(x, y)
                    };
                    if !t.iter().any(gone) {
                        mesh.triangles.push(t);
                    }
                }
            }
        }
        mesh
    }

    fn filled(mesh: &TriMesh) -> (TriMesh, Fill) {
        let adjacency = Adjacency::new(mesh);
        let loops = boundary_loops(mesh, &adjacency);
        let hole = loops.iter().find(|l| l.kind == LoopKind::Hole).unwrap();
        let islands = loops.iter().filter(|l| l.component != hole.component);
        let gap = Gap {
            rims: vec![hole.vertices.clone()],
            islands: islands.map(|l| l.vertices.clone()).collect(),
            extend_over: None,
        };
        let spanned = Spanned::new(&gap, mesh, &adjacency, 1.0).unwrap();
        let first = u32::try_from(mesh.positions.len()).unwrap();
        let fill = spanned.fill(first);
        let mut joint = mesh.clone();
        joint.positions.extend(&fill.targets);
        joint.triangles.extend(&fill.triangles);
        (joint, fill)
    }

    #[test]
    fn a_hole_is_closed_and_its_rim_kept() {
        let mesh = sheet(|x, y| (x - 20.0).hypot(y - 18.0) < 9.0);
        let (joint, fill) = filled(&mesh);
        assert_eq!(check(&joint), Ok(()));
        assert_eq!(euler_characteristic(&joint), 1);
        let ideal = std::f64::consts::PI * 9.5f64.powi(2) / LATTICE_CELL;
        assert!((0.7..1.3).contains(&(fill.targets.len() as f64 / ideal)));
    }

    #[test]
    fn an_island_in_the_hole_stays_and_the_gap_around_it_is_closed() {
        let mesh = sheet(|x, y| (4.0..10.0).contains(&(x - 20.0).hypot(y - 20.0)));
        let (joint, fill) = filled(&mesh);
        assert_eq!(fill.islands, [0]);
        assert_eq!(check(&joint), Ok(()));
        assert_eq!(euler_characteristic(&joint), 1);
        assert_eq!(boundary_loops(&joint, &Adjacency::new(&joint)).len(), 1);
    }

    #[test]
    fn holes_that_touch_in_a_vertex_are_filled_each_by_itself() {
        let mesh = sheet(|x, y| {
            let in_square = |left: f64| x > left && x < left + 8.0 && y > left && y < left + 8.0;
            in_square(8.0) || in_square(16.0)
        });
        let (joint, fill) = filled(&mesh);
        let area: f64 = (fill.triangles.iter())
            .map(|t| triangle_area(t.map(|v| joint.positions[v as usize])))
            .sum();
        let flat: f64 = (fill.triangles.iter())
            .map(|t| {
                let normal = crate::mesh::triangle_normal(t.map(|v| joint.positions[v as usize]));
                0.5 * normal.z
            })
            .sum();
        assert!(
            (flat - 63.0).abs() < 1e-9 && area < 1.25 * flat,
            "{flat} {area}"
        );
        // The other hole is a loop of its own.
        assert_eq!(boundary_loops(&mesh, &Adjacency::new(&mesh)).len(), 3);
        assert_eq!(boundary_loops(&joint, &Adjacency::new(&joint)).len(), 2);
    }

    #[test]
    fn a_long_ragged_rim_is_closed() {
        let mesh = sheet(|x, y| {
            let radius = 14.0 + 2.0 * (9.0 * (y - 20.0).atan2(x - 20.0)).sin();
            (x - 20.0).hypot(y - 20.0) < radius
        });
        let rim = boundary_loops(&mesh, &Adjacency::new(&mesh));
        assert!(
            rim.iter()
                .any(|l| l.kind == LoopKind::Hole && l.vertices.len() > 100)
        );
        let (joint, fill) = filled(&mesh);
        assert_eq!(check(&joint), Ok(()));
        let up = |t: &&[u32; 3]| {
            crate::mesh::triangle_normal(t.map(|v| joint.positions[v as usize])).z > 0.0
        };
        assert_eq!(
            fill.triangles.iter().filter(up).count(),
            fill.triangles.len()
        );
    }

    #[test]
    fn a_piece_far_below_is_no_island() {
        let mut mesh = sheet(|x, y| (4.0..10.0).contains(&(x - 20.0).hypot(y - 20.0)));
        for p in &mut mesh.positions {
            if (p.x - 20.0).hypot(p.y - 20.0) < 5.0 {
                p.z -= 30.0;
            }
        }
        let (joint, fill) = filled(&mesh);
        assert!(fill.islands.is_empty());
        assert_eq!(boundary_loops(&joint, &Adjacency::new(&joint)).len(), 2);
    }

    #[test]
    fn a_hole_of_one_triangle_needs_no_vertex_and_one_of_two_a_single_one() {
        for (gone, targets) in [(1usize, 0), (2, 1)] {
            let mut mesh = sheet(|_, _| false);
            let start = mesh.triangles.len() / 2 + 1;
            let start = start - start % 2;
            mesh.triangles.drain(start..start + gone);
            let (joint, fill) = filled(&mesh);
            assert_eq!(fill.targets.len(), targets, "{gone}");
            assert_eq!(fill.triangles.len(), gone + 2 * targets);
            assert_eq!(euler_characteristic(&joint), 1);
        }
    }
}
