//! Fills of known gaps.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use super::*;
use crate::base::{BaseSurface, Plane};
use crate::mesh::{
    Adjacency, LoopKind, TriMesh, boundary_loops, check, euler_characteristic, triangle_area,
    triangle_normal,
};
use crate::relief::{Relief, extract};
use crate::synth::{self, Kind, Part, SynthParams};

struct Holed {
    base: BaseSurface,
    mesh: TriMesh,
    relief: Relief,
    adjacency: Adjacency,
    spacing: f64,
}

fn holed(kind: Kind, part: Part) -> Holed {
    let made = synth::scan(&SynthParams {
        kind,
        vertices: 2000,
        part,
        ..SynthParams::default()
    })
    .unwrap();
    let mesh = made.scan.mesh();
    Holed {
        base: made.base,
        relief: extract(&mesh, &made.base),
        adjacency: Adjacency::new(&mesh),
        spacing: edge_spacing(&mesh, SpacingRule::Scan).unwrap().spacing,
        mesh,
    }
}

impl Holed {
    fn gap(&self, kind: LoopKind) -> Gap {
        let loops = boundary_loops(&self.mesh, &self.adjacency);
        let rim = loops.into_iter().find(|l| l.kind == kind).unwrap();
        Gap {
            rims: vec![rim.vertices],
            ..Gap::default()
        }
    }

    fn fill(&self, gap: &Gap) -> Result<Fill, FillError> {
        fill(&self.base, &self.relief, &self.adjacency, gap, self.spacing)
    }

    /// Scan and fill together, the fill on the base.
    fn filled(&self, fill: &Fill) -> TriMesh {
        let mut mesh = self.mesh.clone();
        mesh.positions.extend_from_slice(&fill.targets);
        mesh.triangles.extend_from_slice(&fill.triangles);
        mesh
    }
}

#[test]
fn a_hole_in_each_kind_of_base_is_closed_with_even_triangles_that_face_outwards() {
    for kind in [Kind::Waves, Kind::GolfBall, Kind::Bark, Kind::Column] {
        let scene = holed(kind, Part::hole(0.15));
        let fill = scene.fill(&scene.gap(LoopKind::Hole)).unwrap();
        let mesh = scene.filled(&fill);
        assert_eq!(check(&mesh), Ok(()), "{kind}");
        let adjacency = Adjacency::new(&mesh);
        let holes = boundary_loops(&mesh, &adjacency);
        assert!(holes.iter().all(|l| l.kind == LoopKind::Rim), "{kind}");
        // 15 % of 2000 vertices were cut out.
        let count = fill.targets.len();
        assert!((200..400).contains(&count), "{kind}: {count}");
        let mut ratios = Vec::new();
        for t in &fill.triangles {
            let corners = t.map(|v| {
                let foot = scene.base.foot(&mesh.positions[v as usize]);
                foot.point
            });
            let outwards = scene.base.foot(&corners[0]).normal;
            assert!(triangle_normal(corners).dot(&outwards) > 0.0, "{kind}");
            let longest = (0..3)
                .map(|i| (corners[i] - corners[(i + 1) % 3]).norm())
                .fold(0.0, f64::max);
            ratios.push(triangle_area(corners) / (longest * longest * 0.433));
        }
        // 1 for an equilateral triangle.
        ratios.sort_by(f64::total_cmp);
        assert!(ratios[ratios.len() / 2] > 0.7, "{kind}");
        assert!(ratios[ratios.len() / 20] > 0.3, "{kind}");
    }
}

#[test]
fn the_unseen_half_of_a_ball_is_closed() {
    let scene = holed(Kind::GolfBall, Part::view(Vector3::new(0.2, 0.5, 1.0)));
    let fill = scene.fill(&scene.gap(LoopKind::Rim)).unwrap();
    let mesh = scene.filled(&fill);
    assert_eq!(check(&mesh), Ok(()));
    assert_eq!(euler_characteristic(&mesh), 2);
    assert!(boundary_loops(&mesh, &Adjacency::new(&mesh)).is_empty());
}

#[test]
fn the_unseen_wall_of_a_trunk_is_closed_between_its_ends() {
    let scene = holed(Kind::Bark, Part::view(Vector3::x()));
    let mut gap = scene.gap(LoopKind::Rim);
    assert_eq!(scene.fill(&gap), Err(FillError::Unbounded));
    gap.extend_over = Some((0..u32::try_from(scene.mesh.positions.len()).unwrap()).collect());
    let fill = scene.fill(&gap).unwrap();
    let mesh = scene.filled(&fill);
    assert_eq!(check(&mesh), Ok(()));
    assert_eq!(euler_characteristic(&mesh), 0);
    assert_eq!(boundary_loops(&mesh, &Adjacency::new(&mesh)).len(), 2);
}

#[test]
fn an_outer_rim_on_a_plane_has_no_end() {
    let scene = holed(Kind::Waves, Part::hole(0.1));
    assert_eq!(
        scene.fill(&scene.gap(LoopKind::Rim)),
        Err(FillError::Unbounded)
    );
}

#[test]
fn too_fine_a_spacing_is_refused_before_it_is_tried() {
    let scene = holed(Kind::Waves, Part::hole(0.1));
    let gap = scene.gap(LoopKind::Hole);
    let result = fill(&scene.base, &scene.relief, &scene.adjacency, &gap, 1e-6);
    assert!(matches!(result, Err(FillError::TooManyTargets { .. })));
}

#[test]
fn subdivision_makes_four_triangles_of_one_and_keeps_the_old_vertices() {
    let scene = holed(Kind::GolfBall, Part::FULL);
    let colors: Vec<[f64; 3]> = (scene.mesh.positions.iter())
        .map(|p| [0.5 + p.x / 50.0, 0.5, 0.25])
        .collect();
    let fine = subdivide(&scene.mesh, &scene.base, &scene.relief, Some(&colors));
    let old = scene.mesh.positions.len();
    assert_eq!(fine.mesh.triangles.len(), 4 * scene.mesh.triangles.len());
    assert_eq!(fine.mesh.positions[..old], scene.mesh.positions[..]);
    assert_eq!(check(&fine.mesh), Ok(()));
    assert_eq!(euler_characteristic(&fine.mesh), 2);
    let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for [a, b] in &fine.parents {
        *edges.entry([*a, *b]).or_default() += 1;
    }
    assert!(edges.values().all(|n| *n == 1));
    for (new, [a, b]) in fine.parents.iter().enumerate() {
        let (v, a, b) = (old + new, *a as usize, *b as usize);
        let middle = 0.5 * (scene.relief.heights[a] + scene.relief.heights[b]);
        assert!((fine.relief.heights[v] - middle).abs() < 1e-12);
        let color = fine.colors.as_ref().unwrap()[v];
        let expected = 0.5 + fine.mesh.positions[v].x / 50.0;
        assert!((color[0] - expected).abs() < 0.02);
        assert!((color[2] - 0.25).abs() < 1e-12);
    }
}

#[test]
fn a_slit_of_vertices_that_were_never_welded_is_opened_and_stitched() {
    // A flat sheet, a square hole in it, and from the hole a slit of no width.
    let n = 12u32;
    let id = |i: u32, j: u32| i * (n + 1) + j;
    let mut positions: Vec<_> = (0..=n)
        .flat_map(|i| (0..=n).map(move |j| Point3::new(f64::from(i), f64::from(j), 0.0)))
        .collect();
    let mut triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|i| (0..n).map(move |j| [i, j]))
        .filter(|[i, j]| !((4..6).contains(i) && (4..6).contains(j)))
        .flat_map(|[i, j]| {
            [
                [id(i, j), id(i + 1, j), id(i + 1, j + 1)],
                [id(i, j), id(i + 1, j + 1), id(i, j + 1)],
            ]
        })
        .collect();
    for i in [6u32, 7] {
        let double = u32::try_from(positions.len()).unwrap();
        positions.push(positions[id(i, 5) as usize]);
        for t in &mut triangles {
            let below = t.iter().any(|v| v % (n + 1) < 5);
            for v in t.iter_mut().filter(|v| **v == id(i, 5) && below) {
                *v = double;
            }
        }
    }
    let mesh = TriMesh {
        positions,
        triangles,
    };
    let base = BaseSurface::Plane(Plane {
        point: Point3::origin(),
        normal: Vector3::z_axis(),
    });
    let scene = Holed {
        relief: extract(&mesh, &base),
        adjacency: Adjacency::new(&mesh),
        spacing: 1.0,
        base,
        mesh,
    };
    let fill = scene.fill(&scene.gap(LoopKind::Hole)).unwrap();
    let mesh = scene.filled(&fill);
    assert_eq!(check(&mesh), Ok(()));
    let left = boundary_loops(&mesh, &Adjacency::new(&mesh));
    assert_eq!(left.len(), 1);
}
