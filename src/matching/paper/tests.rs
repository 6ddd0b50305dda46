//! The engine against a plain loop over everything.

use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;

use super::*;
use crate::base::BaseSurface;
use crate::mesh::PreparedTriangle;
use crate::mesh::{Adjacency, TriMesh, boundary_loops};
use crate::neighborhood::{Window, gaussian_weight, local_frames, window_sigma};
use crate::relief;
use crate::rng::{Rng, Stage};
use crate::sampling::{SpacingRule, Subdivision, edge_spacing, subdivide};
use crate::synth::{self, Kind, SynthParams};

/// Points around the origin, for properties of triangles.
pub(super) fn point() -> impl Strategy<Value = Point3<f64>> {
    [-2.0..2.0f64, -2.0..2.0, -2.0..2.0].prop_map(Point3::from)
}

struct Scene {
    base: BaseSurface,
    mesh: TriMesh,
    colors: Option<Vec<[f64; 3]>>,
    surface: Subdivision,
}

fn scene(kind: Kind) -> Scene {
    let made = synth::scan(&SynthParams {
        kind,
        vertices: kind.least_vertices(),
        part: synth::Part::hole(0.1),
        noise: 0.02,
        seed: 3,
    })
    .unwrap();
    let mesh = made.scan.mesh();
    let relief = relief::extract(&mesh, &made.base);
    let colors = made.scan.colors();
    Scene {
        surface: subdivide(&mesh, &made.base, &relief, colors.as_deref()),
        base: made.base,
        mesh,
        colors,
    }
}

/// The surroundings of a scanned vertex, about half of them known.
fn query(scene: &Scene, center: u32, radius: usize, rng: &mut Rng) -> Query {
    let relief = &scene.surface.relief;
    let frames = local_frames(&scene.base, &relief.normals);
    let neighbors = Adjacency::new(&scene.mesh).neighbors;
    let v = center as usize;
    let spacing = edge_spacing(&scene.mesh, SpacingRule::Scan)
        .unwrap()
        .spacing;
    let sigma = window_sigma(radius, spacing);
    let mut window = Window::new(scene.mesh.positions.len());
    let known = (window.around(&neighbors, center, radius).iter())
        .filter(|_| rng.uniform() < 0.5)
        .map(|n| *n as usize)
        .map(|n| {
            Neighbor::new(
                &relief.feet[v],
                &frames[v],
                &relief.feet[n],
                &scene.mesh.positions[n],
                scene.colors.as_ref().map(|colors| colors[n]),
                |d| gaussian_weight(d, sigma),
            )
        })
        .collect();
    Query::new(known)
}

/// The paper's cost in one plain loop: partner by a search through all feet, distance to every
/// triangle that has it for a corner.
fn plain_cost(
    scene: &Scene,
    query: &Query,
    search: &Search,
    vertex: usize,
    rotation: u32,
) -> Option<f64> {
    let surface = &scene.surface;
    let relief = &surface.relief;
    let used = surface.mesh.used_vertices();
    let adjacency = Adjacency::new(&surface.mesh);
    let frame = local_frames(&scene.base, &relief.normals)[vertex];
    let angle = std::f64::consts::TAU * f64::from(rotation) / f64::from(search.rotations);
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
    let used_heights = || {
        (relief.heights.iter().zip(&used))
            .filter(|(_, used)| **used)
            .map(|(h, _)| *h)
    };
    let range = used_heights().fold(f64::MIN, f64::max) - used_heights().fold(f64::MAX, f64::min);
    let (mut shape, mut color, mut total) = (0.0, 0.0, 0.0);
    for n in query.neighbors() {
        let foot = relief.feet[vertex] + frame.to_world(&(turn * n.foot));
        let foot = scene.base.foot(&foot).point;
        let point = relief.feet[vertex] + frame.to_world(&(turn * n.point));
        let partner = (0..used.len())
            .filter(|v| used[*v])
            .min_by(|a, b| {
                let distance = |v: &usize| (relief.feet[*v] - foot).norm_squared();
                distance(a).total_cmp(&distance(b))
            })
            .unwrap();
        let around = adjacency.triangles.row(partner);
        if around.len() != adjacency.neighbors.row(partner).len() {
            return None;
        }
        let nearest = (around.iter())
            .map(|f| PreparedTriangle::new(surface.mesh.corners(*f as usize)).distance_sq(&point))
            .fold(f64::INFINITY, f64::min);
        shape += n.weight * nearest;
        if let (Some(ours), Some(colors)) = (n.color, &surface.colors) {
            color += n.weight
                * (0..3)
                    .map(|i| (ours[i] - colors[partner][i]).powi(2))
                    .sum::<f64>();
        }
        total += n.weight;
    }
    Some((1.0 - search.mu) * shape / (total * range * range) + search.mu * color / (total * 3.0))
}

#[test]
fn single_costs_match_the_plain_loop() {
    for kind in [Kind::Noise, Kind::GolfBall, Kind::Bark, Kind::Bricks] {
        let scene = scene(kind);
        let samples = Samples::new(&scene.base, &scene.surface);
        let mut rng = Rng::new(7, Stage::Fit, 0);
        let search = Search {
            rotations: 5,
            mu: if scene.colors.is_some() { 0.3 } else { 0.0 },
            tolerance: 0.1,
        };
        let by_foot = |v: usize| {
            (0..samples.len())
                .find(|s| samples.sites[*s].foot == scene.surface.relief.feet[v])
                .map(|s| SampleId(u32::try_from(s).unwrap()))
        };
        let mut viable = 0;
        for _ in 0..60 {
            let center = u32::try_from(rng.index(scene.mesh.positions.len())).unwrap();
            let query = query(&scene, center, 2, &mut rng);
            if query.neighbors().is_empty() {
                continue;
            }
            let vertex = rng.index(scene.surface.mesh.positions.len());
            let Some(sample) = by_foot(vertex) else {
                continue;
            };
            let rotation = u32::try_from(rng.index(5)).unwrap();
            let plain = plain_cost(&scene, &query, &search, vertex, rotation);
            let fast = match_cost(&samples, &query, &search, sample, rotation);
            match (plain, fast) {
                (Some(plain), Some(fast)) => {
                    assert!(
                        (plain - fast).abs() <= 1e-12 + 1e-9 * plain,
                        "{kind}: {plain} {fast}"
                    );
                    viable += 1;
                }
                (plain, fast) => assert_eq!(plain.is_some(), fast.is_some(), "{kind}"),
            }
        }
        assert!(viable > 15, "{kind}: {viable}");
    }
}

#[test]
fn dropping_candidates_early_changes_nothing() {
    for kind in [Kind::Waves, Kind::Bark, Kind::Bricks] {
        let scene = scene(kind);
        let samples = Samples::new(&scene.base, &scene.surface);
        let mut rng = Rng::new(8, Stage::Fit, 0);
        let search = Search {
            rotations: 3,
            mu: 0.2,
            tolerance: 0.1,
        };
        for _ in 0..4 {
            let center = u32::try_from(rng.index(scene.mesh.positions.len())).unwrap();
            let query = query(&scene, center, 3, &mut rng);
            let all: Vec<Match> = (0..u32::try_from(samples.len()).unwrap())
                .flat_map(|s| (0..3).map(move |r| (SampleId(s), r)))
                .filter_map(|(sample, rotation)| {
                    let cost = match_cost(&samples, &query, &search, sample, rotation)?;
                    Some(Match {
                        sample,
                        rotation,
                        cost,
                    })
                })
                .collect();
            let best = all.iter().map(|m| m.cost).fold(f64::INFINITY, f64::min);
            let expected: Vec<Match> = (all.into_iter()).filter(|m| m.cost <= best * 1.1).collect();
            assert!(!expected.is_empty());
            let likely: Vec<SampleId> = (0..10)
                .map(|_| SampleId(u32::try_from(rng.index(samples.len())).unwrap()))
                .collect();
            // The first searches do without bounds.
            samples.lower_bounds.be_impatient();
            for _ in 0..6 {
                assert_eq!(best_matches(&samples, &query, &search, &[]), expected);
                assert_eq!(best_matches(&samples, &query, &search, &likely), expected);
            }
        }
    }
}

#[test]
fn bounds_are_never_above_the_cost_and_say_something() {
    let search = Search {
        rotations: 1,
        mu: 0.0,
        tolerance: 0.0,
    };
    for kind in [Kind::Waves, Kind::GolfBall, Kind::Bark] {
        let scene = scene(kind);
        let samples = Samples::new(&scene.base, &scene.surface);
        let mut rng = Rng::new(9, Stage::Fit, 0);
        samples.lower_bounds.be_impatient();
        let (mut bounds, mut costs) = (0.0, 0.0);
        for _ in 0..20 {
            let center = u32::try_from(rng.index(scene.mesh.positions.len())).unwrap();
            for neighbor in query(&scene, center, 3, &mut rng).neighbors() {
                let factor = 1.0 / (neighbor.weight * samples.height_range.powi(2));
                let probes = [0, 1].map(|_| {
                    (samples.lower_bounds).probes(&samples, std::slice::from_ref(neighbor), factor)
                });
                let [_, probes] = probes;
                let Some(probe) = &probes[0] else { continue };
                let alone = Query::new(vec![*neighbor]);
                for _ in 0..50 {
                    let sample = rng.index(samples.len());
                    let id = SampleId(u32::try_from(sample).unwrap());
                    let bound = f64::from(probe.bound(sample));
                    match match_cost(&samples, &alone, &search, id, 0) {
                        Some(cost) => {
                            assert!(
                                bound <= cost * (1.0 + 1e-5) + 1e-30,
                                "{kind}: {bound} {cost}"
                            );
                            bounds += bound.min(1.0);
                            costs += cost.min(1.0);
                        }
                        None => assert!(bound >= 0.0),
                    }
                }
            }
        }
        // On scenes as coarse as these they are far below, but must say something.
        assert!(bounds > 0.03 * costs, "{kind}: {bounds} {costs}");
    }
}

#[test]
fn a_neighborhood_of_the_samples_is_found_where_it_is_and_turned_as_it_is() {
    let scene = scene(Kind::Noise);
    let samples = Samples::new(&scene.base, &scene.surface);
    let relief = &scene.surface.relief;
    let frames = local_frames(&scene.base, &relief.normals);
    let neighbors = Adjacency::new(&scene.mesh).neighbors;
    let boundary: Vec<u32> = (boundary_loops(&scene.mesh, &Adjacency::new(&scene.mesh)).iter())
        .flat_map(|l| l.vertices.clone())
        .collect();
    let mut window = Window::new(scene.mesh.positions.len());
    let middle = (0u32..)
        .find(|v| {
            let around = window.around(&neighbors, *v, 4);
            !around.is_empty() && !around.iter().any(|n| boundary.contains(n))
        })
        .unwrap() as usize;
    let angle = std::f64::consts::TAU * 2.0 / 6.0;
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), -angle);
    let mut window = Window::new(scene.mesh.positions.len());
    let around = (window
        .around(&neighbors, u32::try_from(middle).unwrap(), 2)
        .iter())
    .map(|n| *n as usize)
    .map(|n| {
        let straight = Neighbor::new(
            &relief.feet[middle],
            &frames[middle],
            &relief.feet[n],
            &scene.mesh.positions[n],
            None,
            |d| gaussian_weight(d, 2.0),
        );
        Neighbor {
            foot: turn * straight.foot,
            point: turn * straight.point,
            ..straight
        }
    })
    .collect();
    let search = Search {
        rotations: 6,
        mu: 0.0,
        tolerance: 0.0,
    };
    let found = best_matches(&samples, &Query::new(around), &search, &[]);
    let best = (found.iter())
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
        .unwrap();
    assert_eq!(best.rotation, 2, "{best:?} {middle}");
    assert_eq!(samples.scanned_vertex(best.sample) as usize, middle);
    assert!(best.cost < 1e-12);
}

#[test]
fn nothing_is_viable_where_the_neighbors_have_no_partner() {
    let scene = scene(Kind::Waves);
    let samples = Samples::new(&scene.base, &scene.surface);
    let far = Neighbor {
        foot: Vector3::new(1e4, 0.0, 0.0),
        point: Vector3::new(1e4, 0.0, 0.0),
        color: None,
        weight: 1.0,
    };
    let search = Search {
        rotations: 4,
        mu: 0.0,
        tolerance: 0.1,
    };
    assert_eq!(
        best_matches(&samples, &Query::new(vec![far]), &search, &[]),
        []
    );
    assert_eq!(best_matches(&samples, &Query::default(), &search, &[]), []);
}
