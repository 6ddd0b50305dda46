//! Coherent search: what continues the neighbors' sources, against the best of all places.
//!
//! # Reference
//! [Ashikhmin 2001](crate::bibliography#ashikhmin-2001) for candidates that continue what the
//! neighbors were copied from, [Tong et al. 2002](crate::bibliography#tong-et-al-2002) for those most
//! similar to them, [Image analogies 2001](crate::bibliography#image-analogies-2001), §3.2, for
//! preferring coherent matches by a factor 1 + κ, and
//! [PatchMatch 2009](crate::bibliography#patchmatch-2009), §3.2, for the random search around a match.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use crate::neighborhood::{Frame, Place, Surface, View, Walker};
use crate::rng::Rng;

use super::exemplar::Exemplar;
use super::exhaustive;
use super::local::{look_around, polish, polish_best};
use super::query::{Found, Origin, Query};

/// A coherent match that costs less than this share of what a good match costs is taken at once: hardly
/// ever is another clearly better.
const UNCHALLENGED: f32 = 0.25;
/// Random search starts from sites that cost up to this share more than the best of them …
const WIDE: f32 = 0.5;
/// … and up to this many times as much as the coherent match: random search makes sites cheaper, more so
/// the sparser they are.
const PROMISE: f32 = 3.0;

/// How to search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Search {
    /// κ: a coherent match is taken unless another costs less than 1/(1 + κ) of it.
    pub coherence: f32,
    /// Matches that cost at most (1 + tolerance) times the best are drawn from at random.
    pub tolerance: f32,
    /// Number of the best sites that random search starts from.
    pub starts: usize,
    /// Random places tried at each radius around each of them.
    pub tries: u32,
}

/// A neighborhood to be matched, and all that it can be matched with.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// The sites.
    pub exemplar: &'a Exemplar,
    /// The sample surface.
    pub view: &'a View<'a>,
    /// What is known of the neighborhood.
    pub query: &'a Query<'a>,
    /// Places that continue what its neighbors were copied from, see [`continuation`].
    pub continued: &'a [Place],
    /// How to search.
    pub search: &'a Search,
}

/// The place that stands to `source` as the point `to` stands to the point `from`, whose source it is:
/// both with their frames in space. `None` where the surface ends before.
#[must_use]
pub fn continuation(
    surface: &Surface,
    source: &Place,
    from: (&Point3<f64>, &Frame),
    to: (&Point3<f64>, &Frame),
) -> Option<Place> {
    let offset = from.1.to_local(&(to.0 - from.0));
    let axis = from.1.to_local(&to.1.axes[0]);
    let length = axis.x.hypot(axis.y);
    if length < 1e-9 {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, reason = "places are single")]
    let single = |x: f64, y: f64| [x as f32, y as f32];
    let place = surface.walk(source, single(offset.x, offset.y))?;
    Some(place.turned(single(axis.x / length, axis.y / length)))
}

/// What looks most like the query. Of the `continued` places and those similar to them the cheapest, moved
/// to where it fits best; it is taken at once if it costs less than a quarter of what a good match does, and
/// else unless a match found among all sites costs less than 1/(1 + κ) of it. Only sites that
/// cost at most three times as much as it are looked into. `None` if no place has all that the query knows;
/// where nothing is known, the first of the continued places.
#[must_use]
pub fn find(task: &Task, rng: &mut Rng, walker: &mut Walker) -> Option<Found> {
    let candidates = candidates(task, rng, walker);
    let global = draw(candidates.global, task.search.tolerance, rng);
    match (candidates.coherent, global) {
        (Some(coherent), Some(global)) => {
            let is_clear = coherent.cost > (1.0 + task.search.coherence) * global.cost;
            Some(if is_clear { global } else { coherent })
        }
        (coherent, global) => coherent.or(global),
    }
}

/// The cheapest match that [`find`] comes upon, coherent or not.
#[must_use]
pub fn cheapest(task: &Task, rng: &mut Rng, walker: &mut Walker) -> Option<Found> {
    let candidates = candidates(task, rng, walker);
    (candidates.coherent.into_iter().chain(candidates.global))
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// What a target can be copied from.
struct Candidates {
    coherent: Option<Found>,
    /// The best sites, if the coherent match is to be challenged.
    global: Vec<Found>,
}

fn candidates(task: &Task, rng: &mut Rng, walker: &mut Walker) -> Candidates {
    let mut coherent = coherent_match(task, walker);
    if let Some(found) = &mut coherent {
        polish(task.view, task.query, found, walker);
    }
    let unchallenged = UNCHALLENGED * task.exemplar.typical_cost();
    let global = match coherent {
        Some(found) if task.query.is_empty() || found.cost < unchallenged => Vec::new(),
        Some(found) => refined_global_matches(task, PROMISE * found.cost, rng, walker),
        None => refined_global_matches(task, f32::INFINITY, rng, walker),
    };
    Candidates { coherent, global }
}

/// The best sites that cost no more than the budget, each moved to where it is cheapest nearby: by random
/// search where sites are sparse, then by least squares.
fn refined_global_matches(
    task: &Task,
    budget: f32,
    rng: &mut Rng,
    walker: &mut Walker,
) -> Vec<Found> {
    let mut matches = global_matches(task, budget);
    // Least squares finds what is less than a spacing away.
    let radii = task.exemplar.distance()..0.5 * task.view.stencil.spacing();
    for found in &mut matches {
        let tries = task.search.tries;
        look_around(task.view, task.query, found, &radii, tries, rng, walker);
    }
    polish_best(task.view, task.query, &mut matches, walker);
    matches
}

/// One of the matches within the tolerance of the best, drawn at random.
fn draw(mut matches: Vec<Found>, tolerance: f32, rng: &mut Rng) -> Option<Found> {
    let best = (matches.iter()).fold(f32::INFINITY, |best, found| best.min(found.cost));
    matches.retain(|found| found.cost <= (1.0 + tolerance) * best);
    rng.pick(&matches)
}

/// The cheapest of the continued places and those similar to them; the first, where nothing is known.
#[must_use]
pub fn coherent_match(task: &Task, walker: &mut Walker) -> Option<Found> {
    if task.query.is_empty() {
        return task.continued.first().map(|place| Found {
            place: *place,
            cost: 0.0,
            origin: Origin::Continued,
        });
    }
    let mut best: Option<Found> = None;
    let mut offer = |place: Place, origin: Origin| {
        let budget = best.map_or(f32::INFINITY, |found| found.cost);
        if let Some(cost) = task.query.cost(walker, task.view, &place, budget)
            && best.is_none_or(|found| cost < found.cost)
        {
            best = Some(Found {
                place,
                cost,
                origin,
            });
        }
    };
    for place in task.continued {
        offer(*place, Origin::Continued);
    }
    for place in task.continued {
        for similar in task.exemplar.similar_places(task.view.surface, place) {
            offer(similar, Origin::Similar);
        }
    }
    best
}

/// The cheapest matches among all sites, as many as the search starts from, of those that cost no more
/// than the budget.
fn global_matches(task: &Task, budget: f32) -> Vec<Found> {
    let search = exhaustive::Search {
        tolerance: WIDE,
        budget,
        ..exhaustive::Search::default()
    };
    let (table, query) = (task.exemplar.table(), task.query.descriptor());
    let mut matches = exhaustive::best_matches(table, query, &search, &[]);
    matches.sort_by(|a, b| {
        a.cost
            .total_cmp(&b.cost)
            .then(a.candidate.cmp(&b.candidate))
    });
    (apart(task.exemplar, &matches, task.search.starts).into_iter())
        .map(|found| Found {
            place: task.exemplar.place(found.candidate),
            cost: found.cost,
            origin: Origin::Global,
        })
        .collect()
}

/// The first `most` matches, in the order given, that are not next to an earlier one of nearly the same
/// rotation: random search would find the same from both.
fn apart(
    exemplar: &Exemplar,
    matches: &[exhaustive::Found],
    most: usize,
) -> Vec<exhaustive::Found> {
    let mut kept: Vec<exhaustive::Found> = Vec::with_capacity(most);
    for found in matches {
        if kept.len() == most {
            break;
        }
        if !(kept.iter()).any(|other| exemplar.are_close(found.candidate, other.candidate)) {
            kept.push(*found);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Adjacency, TriMesh};
    use crate::neighborhood::local_frames;
    use crate::relief;
    use crate::synth::{self, Kind, Part, SynthParams};
    use nalgebra::{Rotation3, Vector3};

    #[test]
    fn continuing_from_vertex_to_vertex_carries_a_patch_rigidly() {
        let made = synth::scan(&SynthParams {
            kind: Kind::GolfBall,
            vertices: 6000,
            part: Part::FULL,
            noise: 0.0,
            seed: 1,
        })
        .unwrap();
        let mesh = made.scan.mesh();
        let relief = relief::extract(&mesh, &made.base);
        let frames = local_frames(&made.base, &relief.normals);
        let neighbors = Adjacency::new(&mesh).neighbors;
        let feet = &relief.feet;
        let surface = Surface::new(TriMesh {
            positions: feet.clone(),
            triangles: mesh.triangles.clone(),
        });
        let spacing = (feet[0] - feet[neighbors.row(0)[0] as usize]).norm();
        let moved = Rotation3::new(Vector3::new(0.4, -0.3, 0.8));
        // Where the rotation takes a vertex with its frame.
        let start = 17usize;
        let site = (0..feet.len())
            .min_by(|a, b| {
                let away = |v: &usize| (feet[*v] - moved * feet[start]).norm();
                away(a).total_cmp(&away(b))
            })
            .unwrap();
        let at_site = surface
            .at_vertex(
                u32::try_from(site).unwrap(),
                &(moved * frames[start].axes[0]),
            )
            .unwrap();
        let way = moved * feet[start] - feet[site];
        let source = surface
            .walk(&at_site, surface.to_local(&at_site, &way))
            .unwrap();
        // Away from there in a random walk.
        let (mut v, mut place) = (start, source);
        let mut rng = Rng::new(3, crate::rng::Stage::Fit, 0);
        for _ in 0..40 {
            let row = neighbors.row(v);
            let n = row[rng.index(row.len())] as usize;
            place = continuation(
                &surface,
                &place,
                (&feet[v], &frames[v]),
                (&feet[n], &frames[n]),
            )
            .unwrap();
            v = n;
            let off = (surface.position(&place) - moved * feet[v]).norm();
            let turned = (surface.axis(&place) - moved * frames[v].axes[0]).norm();
            assert!(
                off < 0.15 * spacing && turned < 0.1,
                "{off} of {spacing}, {turned}"
            );
        }
    }
}
