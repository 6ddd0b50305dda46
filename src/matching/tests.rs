//! Searches on a stencil, against each other and against known places.

use nalgebra::Point3;

use super::coherent::{self, Search, Task, continuation};
use super::exemplar::{Exemplar, ExemplarParams, least_bytes};
use super::exhaustive;
use super::local::polish;
use super::query::{Found, Origin, Query};
use crate::mesh::TriMesh;
use crate::neighborhood::{
    Among, Channels, Descriptor, Frame, Place, Stencil, Surface, View, Walker, local_frames,
};
use crate::relief;
use crate::rng::{Rng, Stage};
use crate::synth::{self, Kind, Part, SynthParams};

/// A surface all of whose vertices are samples, or those `kept`.
struct Scene {
    feet: Vec<Point3<f64>>,
    frames: Vec<Frame>,
    surface: Surface,
    channels: Channels,
    stencil: Stencil,
}

fn scene(
    kind: Kind,
    stencil: impl Fn(f64) -> Stencil,
    kept: impl Fn(&Point3<f64>) -> bool,
) -> Scene {
    let made = synth::scan(&SynthParams {
        kind,
        vertices: 3000,
        part: Part::FULL,
        noise: 0.0,
        seed: 11,
    })
    .unwrap();
    let mesh = made.scan.mesh();
    let relief = relief::extract(&mesh, &made.base);
    let spacing = crate::sampling::edge_spacing(&mesh, crate::sampling::SpacingRule::Scan)
        .unwrap()
        .spacing;
    let mut channels = Channels::new(mesh.positions.len(), 1);
    for (v, height) in relief.heights.iter().enumerate() {
        #[expect(clippy::cast_possible_truncation, reason = "channels are single")]
        let value = (*height / spacing) as f32;
        let among: &[Among] = if kept(&relief.feet[v]) {
            &[Among::Known, Among::Samples]
        } else {
            &[Among::Known]
        };
        channels.set(v, &[value], among);
    }
    Scene {
        frames: local_frames(&made.base, &relief.normals),
        surface: Surface::new(TriMesh {
            positions: relief.feet.clone(),
            triangles: mesh.triangles,
        }),
        feet: relief.feet,
        channels,
        stencil: stencil(spacing),
    }
}

impl Scene {
    fn view(&self, among: Among) -> View<'_> {
        View {
            surface: &self.surface,
            channels: &self.channels,
            stencil: &self.stencil,
            among,
        }
    }

    fn place(&self, v: usize) -> Place {
        let number = u32::try_from(v).unwrap();
        self.surface
            .at_vertex(number, &self.frames[v].axes[0])
            .unwrap()
    }

    fn sites(&self) -> Vec<Place> {
        (0..self.feet.len())
            .filter(|v| self.channels.is(u32::try_from(*v).unwrap(), Among::Samples))
            .map(|v| self.place(v))
            .collect()
    }

    fn exemplar(&self, params: &ExemplarParams) -> Exemplar {
        Exemplar::new(&self.view(Among::Samples), self.sites(), params).unwrap()
    }

    /// A vertex with all of its neighborhood on the surface.
    fn inner_vertex(&self, rng: &mut Rng) -> usize {
        loop {
            let v = rng.index(self.feet.len());
            if self.read(&self.place(v)).known.count() == self.stencil.len() {
                return v;
            }
        }
    }

    fn read(&self, place: &Place) -> Descriptor {
        let mut found = Descriptor::new(self.stencil.len(), 1);
        let count = self.stencil.len();
        Walker::default().gather(&self.view(Among::Known), place, count, &mut found);
        found
    }

    /// Its part on one side of a line near the centre.
    fn read_half(&self, place: &Place, rng: &mut Rng) -> Descriptor {
        let mut half = self.read(place);
        let angle = rng.uniform() * std::f64::consts::TAU;
        let known = half.known.clone();
        half.known.clear();
        for j in known.iter() {
            let [x, y] = self.stencil.offsets()[j].map(f64::from);
            if x * angle.cos() + y * angle.sin() > 0.3 * self.stencil.spacing() {
                half.known.set(j);
            } else {
                half.values[j] = f32::NAN;
            }
        }
        half
    }
}

const ALL: ExemplarParams = ExemplarParams {
    rotations: 4,
    most_sites: usize::MAX,
    memory: usize::MAX,
    similar: 3,
};

const SEARCH: Search = Search {
    coherence: 0.3,
    tolerance: 0.1,
    starts: 4,
    tries: 3,
};

#[test]
fn costs_on_the_surface_are_those_of_the_table() {
    for kind in [Kind::Noise, Kind::GolfBall] {
        let scene = scene(
            kind,
            |spacing| Stencil::disc(3, spacing),
            |p| p.x > 0.1 * p.y,
        );
        let view = scene.view(Among::Samples);
        let exemplar = scene.exemplar(&ALL);
        let mut rng = Rng::new(1, Stage::Fit, 0);
        let mut walker = Walker::default();
        let (mut viable, mut not) = (0, 0);
        for _ in 0..200 {
            let v = scene.inner_vertex(&mut rng);
            let half = scene.read_half(&scene.place(v), &mut rng);
            let query = Query::new(&half, &scene.stencil);
            let candidate = u32::try_from(rng.index(exemplar.table().len())).unwrap();
            let place = exemplar.place(candidate);
            let table = exhaustive::cost(exemplar.table(), &half, candidate);
            let surface = query.cost(&mut walker, &view, &place, f32::INFINITY);
            assert_eq!(table.is_some(), surface.is_some());
            if let (Some(table), Some(surface)) = (table, surface) {
                assert!((table - surface).abs() <= 1e-5 * (table + surface) + 1e-9);
                assert!(
                    query
                        .cost(&mut walker, &view, &place, 0.99 * surface)
                        .is_none()
                );
                viable += 1;
            } else {
                not += 1;
            }
        }
        assert!(viable > 30 && not > 10, "{viable} {not}");
    }
}

#[test]
fn a_neighborhood_turned_by_a_known_angle_is_found_there_at_that_rotation() {
    let scene = scene(Kind::Noise, |spacing| Stencil::disc(4, spacing), |_| true);
    let params = ExemplarParams {
        rotations: 5,
        similar: 0,
        ..ALL
    };
    let exemplar = scene.exemplar(&params);
    let mut rng = Rng::new(2, Stage::Fit, 0);
    for rotation in 0..5u32 {
        let v = scene.inner_vertex(&mut rng);
        let angle = f64::from(rotation) * std::f64::consts::TAU / 5.0;
        #[expect(clippy::cast_possible_truncation, reason = "places are single")]
        let turn = [angle.cos() as f32, angle.sin() as f32];
        let half = scene.read_half(&scene.place(v).turned(turn), &mut rng);
        let found = exhaustive::nearest(exemplar.table(), &half, 1)[0];
        assert_eq!(found.candidate % 5, rotation);
        let place = exemplar.place(found.candidate);
        assert!((scene.surface.position(&place) - scene.feet[v]).norm() < 1e-4);
        assert!(found.cost < 1e-6);
    }
}

#[test]
fn in_a_fan_a_rotation_is_a_cyclic_shift() {
    let scene = scene(
        Kind::GolfBall,
        |spacing| Stencil::fan(3, 12, spacing),
        |_| true,
    );
    let mut rng = Rng::new(3, Stage::Fit, 0);
    for steps in 0..12 {
        let place = scene.place(rng.index(scene.feet.len()));
        let angle = std::f64::consts::TAU * steps as f64 / 12.0;
        #[expect(clippy::cast_possible_truncation, reason = "places are single")]
        let turned = place.turned([angle.cos() as f32, angle.sin() as f32]);
        let (straight, turned) = (scene.read(&place), scene.read(&turned));
        for (j, from) in scene.stencil.turned(steps).iter().enumerate() {
            let (a, b) = (turned.values[j], straight.values[*from as usize]);
            assert!((a - b).abs() < 1e-4, "{steps} {j}: {a} {b}");
        }
    }
}

#[test]
fn the_linearised_cost_is_the_cost_nearby() {
    let scene = scene(Kind::Waves, |spacing| Stencil::disc(3, spacing), |_| true);
    let view = scene.view(Among::Samples);
    let mut rng = Rng::new(4, Stage::Fit, 0);
    let mut walker = Walker::default();
    for _ in 0..20 {
        let half = scene.read_half(&scene.place(scene.inner_vertex(&mut rng)), &mut rng);
        let query = Query::new(&half, &scene.stencil);
        let place = scene.place(scene.inner_vertex(&mut rng));
        let here = query
            .linearized(&mut walker, &view, &place, f32::INFINITY)
            .unwrap();
        let step = 0.02 * scene.stencil.spacing();
        // The surface is flat between vertices: differences of costs are those of g up to the turns at
        // edges, which a mean over many offsets hardly feels.
        for (axis, way) in [[step, 0.0], [0.0, step]].into_iter().enumerate() {
            let mut at = |sign: f64| {
                #[expect(clippy::cast_possible_truncation, reason = "places are single")]
                let place = (scene.surface.walk(&place, way.map(|x| (sign * x) as f32))).unwrap();
                (query.cost(&mut walker, &view, &place, f32::INFINITY)).unwrap()
            };
            let difference = f64::from(at(1.0) - at(-1.0)) / (2.0 * step);
            let derivative = 2.0 * here.gradient[axis];
            let scale = 2.0 * (f64::from(here.cost) * here.curvature[(axis, axis)]).sqrt();
            assert!(
                (difference - derivative).abs() < 0.1 * scale + 1e-6,
                "axis {axis}: {difference} {derivative} {scale}"
            );
        }
    }
}

#[test]
fn a_match_a_little_off_is_polished_to_where_it_belongs() {
    let scene = scene(Kind::Noise, |spacing| Stencil::disc(4, spacing), |_| true);
    let view = scene.view(Among::Samples);
    let mut rng = Rng::new(5, Stage::Fit, 0);
    let mut walker = Walker::default();
    let spacing = scene.stencil.spacing();
    for _ in 0..20 {
        let v = scene.inner_vertex(&mut rng);
        let whole = scene.read(&scene.place(v));
        let query = Query::new(&whole, &scene.stencil);
        #[expect(clippy::cast_possible_truncation, reason = "places are single")]
        let off = [0.5, -0.4].map(|x| (x * spacing) as f32);
        let place = scene.surface.walk(&scene.place(v), off).unwrap();
        let Some(cost) = query.cost(&mut walker, &view, &place, f32::INFINITY) else {
            continue;
        };
        let mut found = Found {
            place,
            cost,
            origin: Origin::Global,
        };
        polish(&view, &query, &mut found, &mut walker);
        assert!(found.cost < 0.2 * cost, "{} of {cost}", found.cost);
        let off = (scene.surface.position(&found.place) - scene.feet[v]).norm();
        assert!(off < 0.25 * spacing, "{off} of {spacing}");
    }
}

#[test]
fn what_continues_the_neighbors_is_taken_unless_another_place_is_clearly_better() {
    let scene = scene(Kind::Noise, |spacing| Stencil::disc(4, spacing), |_| true);
    let view = scene.view(Among::Samples);
    let exemplar = scene.exemplar(&ALL);
    let mut rng = Rng::new(6, Stage::Fit, 0);
    let mut walker = Walker::default();
    for _ in 0..20 {
        let v = scene.inner_vertex(&mut rng);
        let half = scene.read_half(&scene.place(v), &mut rng);
        let query = Query::new(&half, &scene.stencil);
        let (right, wrong) = (scene.place(v), scene.place(scene.inner_vertex(&mut rng)));
        let mut find = |continued: &[Place]| {
            let task = Task {
                exemplar: &exemplar,
                view: &view,
                query: &query,
                continued,
                search: &SEARCH,
            };
            coherent::find(&task, &mut rng, &mut walker).unwrap()
        };
        let found = find(&[wrong, right]);
        assert_eq!(found.origin, Origin::Continued);
        assert!((scene.surface.position(&found.place) - scene.feet[v]).norm() < 1e-4);
        let found = find(&[wrong]);
        let alone = find(&[]);
        assert_eq!(alone.origin, Origin::Global);
        assert!(alone.cost < 1e-4);
        if found.origin == Origin::Global {
            assert!(found.cost < 1e-4);
        }
        assert!((scene.surface.position(&alone.place) - scene.feet[v]).norm() < 1e-2);
    }
}

#[test]
fn a_place_that_lacks_what_the_query_knows_never_wins() {
    // Samples on one half only: next to its rim most rotations lack something.
    let scene = scene(
        Kind::Noise,
        |spacing| Stencil::disc(3, spacing),
        |p| p.x > 0.0,
    );
    let view = scene.view(Among::Samples);
    let exemplar = scene.exemplar(&ALL);
    let mut rng = Rng::new(7, Stage::Fit, 0);
    let mut walker = Walker::default();
    for _ in 0..60 {
        let v = scene.inner_vertex(&mut rng);
        let half = scene.read_half(&scene.place(v), &mut rng);
        let query = Query::new(&half, &scene.stencil);
        let task = Task {
            exemplar: &exemplar,
            view: &view,
            query: &query,
            continued: &[scene.place(v)],
            search: &SEARCH,
        };
        let found = coherent::find(&task, &mut rng, &mut walker).unwrap();
        assert!(found.cost.is_finite());
        let mut there = Descriptor::new(scene.stencil.len(), 1);
        walker.gather(&view, &found.place, scene.stencil.len(), &mut there);
        assert!(half.known.iter().all(|j| there.known.get(j)));
    }
}

#[test]
fn tables_keep_to_the_memory_and_sites_stay_evenly_spread() {
    let scene = scene(Kind::Noise, |spacing| Stencil::disc(3, spacing), |_| true);
    let view = scene.view(Among::Samples);
    let least = least_bytes(&view, &ALL);
    let with = |memory: usize| {
        let params = ExemplarParams { memory, ..ALL };
        Exemplar::new(&view, scene.sites(), &params)
    };
    assert!(with(least - 1).is_none());
    assert_eq!(with(least).unwrap().sites().len(), 1);
    let mut last = 1;
    for memory in [20 * least, 100 * least, 500 * least] {
        let exemplar = with(memory).unwrap();
        assert!(exemplar.bytes() <= memory && exemplar.thinned_by_memory());
        let kept = exemplar.sites().len();
        assert!(kept > last, "{kept}");
        last = kept;
        assert_eq!(exemplar.offered(), scene.feet.len());
        // Each vertex has a site within a few times the mean distance.
        let area_of_one = scene.feet.len() as f64 / kept as f64;
        let most = 3.0 * area_of_one.sqrt() * scene.stencil.spacing();
        for p in &scene.feet {
            let near = |site: &Place| (scene.surface.position(site) - p).norm() < most;
            assert!(exemplar.sites().iter().any(near));
        }
    }
}

#[test]
fn a_continuation_leads_from_a_vertex_to_the_next() {
    let scene = scene(Kind::Bark, |spacing| Stencil::disc(3, spacing), |_| true);
    let mut rng = Rng::new(8, Stage::Fit, 0);
    for _ in 0..50 {
        let v = scene.inner_vertex(&mut rng);
        let to = (0..scene.feet.len())
            .filter(|n| *n != v)
            .min_by(|a, b| {
                let away = |n: &usize| (scene.feet[*n] - scene.feet[v]).norm();
                away(a).total_cmp(&away(b))
            })
            .unwrap();
        let at = |v: usize| (&scene.feet[v], &scene.frames[v]);
        let place = continuation(&scene.surface, &scene.place(v), at(v), at(to)).unwrap();
        let away = (scene.surface.position(&place) - scene.feet[to]).norm();
        assert!(away < 0.05 * scene.stencil.spacing());
        let turned = scene.surface.axis(&place) - scene.frames[to].axes[0];
        assert!(turned.norm() < 0.2);
    }
}
