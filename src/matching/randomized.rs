//! Randomised search with propagation: a match for every vertex of a surface at once, where there are
//! too many neighborhoods to compare each with all.
//!
//! # Reference
//! [PatchMatch 2009](crate::bibliography#patchmatch-2009), §3: random start, propagation from neighbors
//! in an order that is turned round after every round, random search in shrinking radii; on surfaces as
//! in [MeshMatch 2012](crate::bibliography#meshmatch-2012).

use std::ops::Range;

use nalgebra::Point3;
use rayon::prelude::*;

use crate::mesh::{Csr, spatial_order};
use crate::neighborhood::{Descriptor, Frame, Place, View, Walker};
use crate::rng::{Rng, Stage};

use super::coherent::continuation;
use super::local::look_around;
use super::query::{Found, Origin, Query};

/// Targets that are gone through one after the other, each hearing what the one before it found. A fixed
/// number, so that the result does not depend on the number of threads.
const CHUNK: usize = 512;

/// Random search around a match begins at this many stencil spacings; farther away are the sites drawn
/// from the whole surface.
const RADIUS: f64 = 8.0;

/// It ends above this many.
const LEAST_RADIUS: f64 = 0.125;

/// The vertices that are to be matched.
#[derive(Debug, Clone, Copy)]
pub struct Targets<'a> {
    /// #T points on the base surface.
    pub feet: &'a [Point3<f64>],
    /// #T tangent frames there.
    pub frames: &'a [Frame],
    /// #T lists of neighbors, by number of target.
    pub neighbors: &'a Csr,
}

/// How long and how widely to search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldParams {
    /// Rounds of propagation and random search.
    pub rounds: u32,
    /// Sites drawn from the whole surface for each target and round, and places at each radius around
    /// its match.
    pub tries: u32,
    /// Number R of rotations about the normal in which a site is tried; none counts as one.
    pub rotations: u32,
    /// Seed of all draws.
    pub seed: u32,
}

impl Default for FieldParams {
    fn default() -> Self {
        Self {
            rounds: 6,
            tries: 2,
            rotations: 4,
            seed: 0,
        }
    }
}

/// The nearest-neighbor field (#T): for each target the best place that was found for its neighborhood,
/// among `sites` (places on the sample surface, that of `view`) and what lies between them; `None` where
/// no place has what the target knows.
///
/// `read` reads the neighborhood of a target; it is called from any thread, as often as needed.
///
/// # Panics
/// If there are 2³² targets or more.
#[must_use]
pub fn field(
    view: &View,
    sites: &[Place],
    targets: &Targets,
    read: impl Fn(usize, &mut Walker, &mut Descriptor) + Sync,
    params: &FieldParams,
) -> Vec<Option<Found>> {
    let count = u32::try_from(targets.feet.len()).expect("targets are u32");
    let order = spatial_order(targets.feet, (0..count).collect());
    let mut place_in_order = vec![0; order.len()];
    for (i, target) in order.iter().enumerate() {
        place_in_order[*target as usize] = i;
    }
    let search = Search {
        view,
        sites,
        targets,
        params,
        order,
        place_in_order,
    };
    let mut field: Vec<Option<Found>> = vec![None; search.order.len()];
    if sites.is_empty() {
        return field;
    }
    for round in 0..=params.rounds {
        field = (0..search.order.len().div_ceil(CHUNK))
            .into_par_iter()
            .flat_map_iter(|chunk| search.go_through(chunk, round, &field, &read))
            .collect();
    }
    // From the order along the curve to that of the targets.
    (search.place_in_order.iter()).map(|i| field[*i]).collect()
}

struct Search<'a> {
    view: &'a View<'a>,
    sites: &'a [Place],
    targets: &'a Targets<'a>,
    params: &'a FieldParams,
    /// Targets along a curve that fills space, and where on it each is.
    order: Vec<u32>,
    place_in_order: Vec<usize>,
}

impl Search<'_> {
    /// One round over a chunk of the order: its part of the new field.
    fn go_through(
        &self,
        chunk: usize,
        round: u32,
        field: &[Option<Found>],
        read: &impl Fn(usize, &mut Walker, &mut Descriptor),
    ) -> Vec<Option<Found>> {
        let span = chunk * CHUNK..self.order.len().min((chunk + 1) * CHUNK);
        let mut found = field[span.clone()].to_vec();
        let channels = self.view.channels.count();
        let mut known = Descriptor::new(self.view.stencil.len(), channels);
        let mut walker = Walker::default();
        let mut rng = Rng::of_part(
            self.params.seed,
            Stage::Matching,
            round,
            u32::try_from(chunk).expect("fewer chunks than targets"),
        );
        for i in 0..found.len() {
            let i = if round.is_multiple_of(2) {
                i
            } else {
                found.len() - 1 - i
            };
            let target = self.order[span.start + i] as usize;
            read(target, &mut walker, &mut known);
            let query = Query::new(&known, self.view.stencil);
            let mut best = found[i];
            if round > 0 {
                self.propagate(target, &span, field, &found, &query, &mut best, &mut walker);
            }
            self.draw(&query, &mut best, &mut rng, &mut walker);
            if let (Some(best), true) = (&mut best, round > 0) {
                let spacing = self.view.stencil.spacing();
                let (radii, tries) = (RADIUS * spacing..LEAST_RADIUS * spacing, self.params.tries);
                look_around(
                    self.view,
                    &query,
                    best,
                    &radii,
                    tries,
                    &mut rng,
                    &mut walker,
                );
            }
            found[i] = best;
        }
        found
    }

    /// Tries what continues the matches of the target's neighbors: those of this round in its own chunk,
    /// those of the last elsewhere.
    #[expect(clippy::too_many_arguments, reason = "both rounds' fields")]
    fn propagate(
        &self,
        target: usize,
        span: &Range<usize>,
        field: &[Option<Found>],
        found: &[Option<Found>],
        query: &Query,
        best: &mut Option<Found>,
        walker: &mut Walker,
    ) {
        let Targets {
            feet,
            frames,
            neighbors,
        } = self.targets;
        for n in neighbors.row(target) {
            let n = *n as usize;
            let at = self.place_in_order[n];
            let theirs = if span.contains(&at) {
                found[at - span.start]
            } else {
                field[at]
            };
            let place = theirs.and_then(|theirs| {
                let (from, to) = ((&feet[n], &frames[n]), (&feet[target], &frames[target]));
                continuation(self.view.surface, &theirs.place, from, to)
            });
            if let Some(place) = place {
                self.offer(place, Origin::Continued, query, best, walker);
            }
        }
    }

    /// Tries sites drawn from the whole surface.
    fn draw(&self, query: &Query, best: &mut Option<Found>, rng: &mut Rng, walker: &mut Walker) {
        for _ in 0..self.params.tries {
            let site = self.sites[rng.index(self.sites.len())];
            let turn = f64::from(index(rng.index(self.params.rotations.max(1) as usize)));
            let angle = std::f64::consts::TAU * turn / f64::from(self.params.rotations.max(1));
            #[expect(clippy::cast_possible_truncation, reason = "places are single")]
            let turn = [angle.cos() as f32, angle.sin() as f32];
            self.offer(site.turned(turn), Origin::Global, query, best, walker);
        }
    }

    /// Takes a place if it is cheaper than the best so far.
    fn offer(
        &self,
        place: Place,
        origin: Origin,
        query: &Query,
        best: &mut Option<Found>,
        walker: &mut Walker,
    ) {
        let budget = best.map_or(f32::INFINITY, |best| best.cost);
        if let Some(cost) = query.cost(walker, self.view, &place, budget)
            && best.is_none_or(|best| cost < best.cost)
        {
            *best = Some(Found {
                place,
                cost,
                origin,
            });
        }
    }
}

fn index(i: usize) -> u32 {
    u32::try_from(i).expect("rotations are u32")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Adjacency, TriMesh};
    use crate::neighborhood::{Among, Channels, Stencil, Surface, local_frames};
    use crate::relief;
    use crate::synth::{self, Kind, Part, SynthParams};

    /// Waves on a plane, every frame turned by an angle of its own.
    #[test]
    fn a_surface_is_found_on_itself_for_any_number_of_threads() {
        let made = synth::scan(&SynthParams {
            kind: Kind::Noise,
            vertices: 4000,
            part: Part::FULL,
            noise: 0.0,
            seed: 5,
        })
        .unwrap();
        let mesh = made.scan.mesh();
        let relief = relief::extract(&mesh, &made.base);
        let turned = |(v, frame): (usize, Frame)| {
            let [x, y, normal] = frame.axes;
            let (sin, cos) = (0.7 * f64::from(index(v))).sin_cos();
            Frame {
                axes: [x * cos + y * sin, y * cos - x * sin, normal],
            }
        };
        let frames = local_frames(&made.base, &relief.normals);
        let frames: Vec<Frame> = frames.into_iter().enumerate().map(turned).collect();
        let neighbors = Adjacency::new(&mesh).neighbors;
        let surface = Surface::new(TriMesh {
            positions: relief.feet.clone(),
            triangles: mesh.triangles.clone(),
        });
        let mut channels = Channels::new(mesh.positions.len(), 1);
        for (v, height) in relief.heights.iter().enumerate() {
            #[expect(clippy::cast_possible_truncation, reason = "channels are single")]
            channels.set(v, &[*height as f32], &[Among::Known, Among::Samples]);
        }
        let spacing = (relief.feet[0] - relief.feet[neighbors.row(0)[0] as usize]).norm();
        let stencil = Stencil::disc(4, spacing);
        let view = View {
            surface: &surface,
            channels: &channels,
            stencil: &stencil,
            among: Among::Samples,
        };
        let at = |v: usize| surface.at_vertex(index(v), &frames[v].axes[0]).unwrap();
        let sites: Vec<Place> = (0..mesh.positions.len()).map(at).collect();
        let targets = Targets {
            feet: &relief.feet,
            frames: &frames,
            neighbors: &neighbors,
        };
        let read = |target: usize, walker: &mut Walker, known: &mut Descriptor| {
            walker.gather(&view, &at(target), stencil.len(), known);
        };
        let matched = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| field(&view, &sites, &targets, read, &FieldParams::default()))
        };
        let found = matched(1);
        assert_eq!(found, matched(2));
        assert_eq!(found, matched(8));
        let on_itself = (found.iter().enumerate())
            .filter(|(v, found)| {
                found.is_some_and(|found| {
                    (surface.position(&found.place) - relief.feet[*v]).norm() < 0.5 * spacing
                })
            })
            .count();
        assert!(
            on_itself * 10 > found.len() * 9,
            "{on_itself} of {}",
            found.len()
        );
    }
}
