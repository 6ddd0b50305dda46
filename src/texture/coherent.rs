//! Growth that continues what the neighbors were copied from.
//!
//! A level begins with the coarser one's sources. Then each vertex in turn compares where its own and its neighbors'
//! sources lead to, and what looks like these places on the sample. Two things lead away from the paper's least
//! difference, both chosen by measuring: what continues a neighbor is preferred, and what was copied more often than its
//! share is avoided, so that no smooth place of the sample takes over.
//!
//! # Reference
//! Candidates: [Ashikhmin 2001](crate::bibliography#ashikhmin-2001), [Tong et al. 2002](crate::bibliography#tong-et-al-2002).
//! From coarse to fine by sources: [Lefebvre & Hoppe 2005](crate::bibliography#lefebvre--hoppe-2005). Coherence
//! preferred: [Image analogies 2001](crate::bibliography#image-analogies-2001). Uniform use:
//! [Kaspar et al. 2015](crate::bibliography#kaspar-et-al-2015).

use rayon::prelude::*;

use crate::matching::nearby::{Nearby, NearbyParams};
use crate::matching::tree::distance_sq;
use crate::mesh::Adjacency;
use crate::neighborhood::Place;
use crate::rng::Rng;

use super::descriptors::Part;
use super::level::{Above, Painted, Work, scaled};
use super::paint::shuffle;
use super::pyramid::PyramidLevel;
use super::sites::{NONE, Sites};
use super::waves::Waves;

/// Places that look most like a site, for each.
const SIMILAR: usize = 4;

/// What looks alike within this many texels is the same thing.
const APART: f64 = 3.0;

/// Rounds over all vertices of a level, and of the coarsest.
const ROUNDS: usize = 3;
const FIRST_ROUNDS: usize = 7;

/// By how much more a match may cost that continues a neighbor.
const COHERENCE: f32 = 0.3;

/// By how much a match costs more for each time that it was copied beyond its share, …
const OVERUSE: f32 = 0.5;
/// … up to so many.
const MOST_OVERUSE: f32 = 4.0;

/// Paints a level, beginning with what the coarser one has (`coarse_sample` is the sample's coarser level).
pub(super) fn run(
    work: &Work,
    coarse_sample: Option<&PyramidLevel>,
    painted: &mut Painted,
    rng: &mut Rng,
) {
    let growth = Growth::new(work, painted);
    let rounds = match work.above.zip(coarse_sample) {
        Some((above, coarse_sample)) => {
            growth.begin(painted, &above, coarse_sample);
            ROUNDS
        }
        None => FIRST_ROUNDS,
    };
    let mut order: Vec<u32> = (0..work.len()).collect();
    shuffle(&mut order, rng);
    let waves = Waves::new(&work.looks.own, &order);
    for _ in 0..rounds {
        growth.round(painted, &waves);
    }
}

struct Growth<'a> {
    work: &'a Work<'a>,
    adjacency: Adjacency,
    /// By site the sites most like it.
    similar: Vec<Vec<u32>>,
    /// What the neighborhoods have on the coarser level, which stays as it is.
    coarse_rows: Vec<f32>,
    /// All sites, on the coarsest level, where nothing is to be continued yet.
    all: Option<Nearby<'a>>,
}

/// A place to copy from.
#[derive(Debug, Clone, Copy)]
struct Match {
    source: Place,
    cost: f32,
    /// The cost with all preferences.
    score: f32,
}

impl<'a> Growth<'a> {
    fn new(work: &'a Work<'a>, painted: &Painted) -> Self {
        let sites = work.sites;
        let all: Vec<u32> = (0..work.len()).collect();
        let is_coarsest = work.above.is_none();
        let nearby = Nearby::new(&sites.rows, sites.width, &NearbyParams::default());
        Self {
            work,
            adjacency: Adjacency::new(&work.canvas.surface.mesh()),
            similar: similar(sites, &nearby),
            coarse_rows: match is_coarsest {
                true => Vec::new(),
                false => work.reader(painted).rows(&all, Part::Coarse),
            },
            all: is_coarsest.then_some(nearby),
        }
    }

    /// Takes over the sources of the coarser level.
    fn begin(&self, painted: &mut Painted, above: &Above, coarse_sample: &PyramidLevel) {
        let sources: Vec<Option<Place>> = (0..above.places.len())
            .into_par_iter()
            .map(|v| self.source_from_above(v, above, coarse_sample))
            .collect();
        for (v, source) in (0..).zip(sources) {
            if let Some(source) = source {
                painted.set(v, source, self.work.sites, f32::NAN);
            }
        }
    }

    /// Where the source of the nearest vertex of the coarser level leads to at vertex `v`.
    fn source_from_above(
        &self,
        v: usize,
        above: &Above,
        coarse_sample: &PyramidLevel,
    ) -> Option<Place> {
        let place = above.places[v].as_ref()?;
        let weights = above.canvas.surface.barycentric(place);
        let corners = above.canvas.surface.corners(place.triangle);
        let nearest = (0..3).max_by(|a, b| weights[*a].total_cmp(&weights[*b]))?;
        let nearest = corners[nearest] as usize;
        let offset = above
            .canvas
            .offset_to(nearest, &self.work.canvas.surface.positions()[v]);
        let scale = coarse_sample.texel / above.canvas.texel;
        let source = &above.painted.sources[nearest];
        let there = coarse_sample.surface.walk(source, scaled(offset, scale))?;
        coarse_sample.one_finer(&there, self.work.sites.level)
    }

    /// Visits all vertices once.
    fn round(&self, painted: &mut Painted, waves: &Waves) {
        let mut uses = Uses::new(self.work, painted);
        for wave in waves.iter() {
            let found: Vec<Option<Match>> = (wave.par_iter())
                .map_init(Vec::new, |row, v| self.best(*v, painted, &uses, row))
                .collect();
            for (v, found) in wave.iter().zip(found) {
                if let Some(found) = found {
                    uses.move_one(self.work, &painted.sources[*v as usize], &found.source);
                    painted.set(*v, found.source, self.work.sites, found.cost);
                }
            }
        }
    }

    /// The best candidate for a vertex; `None` if nothing near it leads to a site.
    fn best(&self, v: u32, painted: &Painted, uses: &Uses, row: &mut Vec<f32>) -> Option<Match> {
        let sites = self.work.sites;
        row.resize(sites.width, 0.0);
        let (coarse, own) = row.split_at_mut(sites.coarse_width);
        coarse.copy_from_slice(&self.coarse_rows[v as usize * coarse.len()..][..coarse.len()]);
        self.work.reader(painted).read_own(v as usize, own);
        let mut best: Option<Match> = None;
        let mut seen: Vec<u32> = Vec::with_capacity(48);
        let mut consider = |site: u32, source: Option<Place>| {
            if seen.contains(&site) {
                return;
            }
            seen.push(site);
            let preference = if source.is_some() {
                1.0
            } else {
                1.0 + COHERENCE
            };
            let factor = preference * uses.factor(site);
            let limit = best.map_or(f32::INFINITY, |best| best.score / factor);
            let Some(cost) = distance_within(row, sites.row(site), limit) else {
                return;
            };
            let score = cost * factor;
            if best.is_none_or(|best| score < best.score) {
                best = Some(Match {
                    source: source.unwrap_or_else(|| self.work.place(site)),
                    cost: cost / sites.width as f32,
                    score,
                });
            }
        };
        let around = self.adjacency.neighbors.row(v as usize);
        for from in std::iter::once(v).chain(around.iter().copied()) {
            let Some(there) = self.work.continued(painted, from as usize, v as usize) else {
                continue;
            };
            let site = sites.numbers[sites.level.nearest(&there) as usize];
            if site == NONE {
                continue;
            }
            consider(site, Some(sites.level.straightened(&there)));
            for other in &self.similar[site as usize] {
                consider(*other, None);
            }
        }
        if let Some(all) = &self.all {
            for (site, _) in all.find(row, 1, |_| true) {
                consider(site, None);
            }
        }
        best
    }
}

/// Squared distance of two rows; `None` as soon as it is clear that it exceeds the limit.
fn distance_within(a: &[f32], b: &[f32], limit: f32) -> Option<f32> {
    /// Values that are compared between two looks at the sum.
    const STAGE: usize = 64;
    let mut sum = 0.0;
    for (a, b) in a.chunks(STAGE).zip(b.chunks(STAGE)) {
        sum += distance_sq(a, b);
        if sum > limit {
            return None;
        }
    }
    Some(sum)
}

/// For each site those most like it, but for its surroundings.
fn similar(sites: &Sites, nearby: &Nearby) -> Vec<Vec<u32>> {
    let count = u32::try_from(sites.len()).expect("sites are u32");
    let position =
        |site: u32| sites.level.surface.positions()[sites.vertices[site as usize] as usize];
    (0..count)
        .into_par_iter()
        .map(|site| {
            let is_apart =
                |other: u32| (position(other) - position(site)).norm() > APART * sites.level.texel;
            let near = nearby.find_for(site, SIMILAR, is_apart);
            near.into_iter().map(|(site, _)| site).collect()
        })
        .collect()
}

/// How often each site is copied.
struct Uses {
    counts: Vec<u32>,
    /// Its share of all vertices, at least one.
    share: f32,
}

impl Uses {
    fn new(work: &Work, painted: &Painted) -> Self {
        let sites = work.sites;
        let mut counts = vec![0; sites.len()];
        for source in &painted.sources {
            if let Some(count) = Self::count(&mut counts, sites, source) {
                *count += 1;
            }
        }
        Self {
            counts,
            share: (painted.sources.len() as f32 / sites.len() as f32).max(1.0),
        }
    }

    fn count<'a>(counts: &'a mut [u32], sites: &Sites, source: &Place) -> Option<&'a mut u32> {
        let site = sites.numbers[sites.level.nearest(source) as usize];
        counts.get_mut(site as usize)
    }

    fn move_one(&mut self, work: &Work, from: &Place, to: &Place) {
        if let Some(count) = Self::count(&mut self.counts, work.sites, from) {
            *count -= 1;
        }
        if let Some(count) = Self::count(&mut self.counts, work.sites, to) {
            *count += 1;
        }
    }

    /// What the cost of copying a site is multiplied with.
    fn factor(&self, site: u32) -> f32 {
        let over = self.counts[site as usize] as f32 / self.share - 1.0;
        1.0 + OVERUSE * over.clamp(0.0, MOST_OVERUSE)
    }
}
