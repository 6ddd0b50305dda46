//! What a search over the whole sample surface needs.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use crate::mesh::{PointTree, spatial_order};
use crate::neighborhood::{Place, Surface, View, Walker};

use super::similar::{self, Similar};
use super::table::Table;

/// How an exemplar is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExemplarParams {
    /// Number R of rotations about the normal, at multiples of 2π/R.
    pub rotations: u32,
    /// Most sites that are kept; of more, a spatially even choice is.
    pub most_sites: usize,
    /// Bytes that the tables may take; sites are thinned until they do not take more.
    pub memory: usize,
    /// Number k of most similar candidates that are found for every site beforehand.
    pub similar: usize,
}

/// Sites on the sample surface, their neighborhoods at every rotation, and for each site the most
/// similar others.
#[derive(Debug)]
pub struct Exemplar {
    sites: Vec<Place>,
    offered: usize,
    thinned_by_memory: bool,
    turns: Vec<[f32; 2]>,
    table: Table,
    /// The sites in space.
    points: Vec<Point3<f64>>,
    positions: PointTree,
    similar: Similar,
    /// Typical distance of sites.
    distance: f64,
}

impl Exemplar {
    /// Reads the neighborhoods of all sites of `view`, or of a spatially even choice of them where
    /// there are more than the parameters allow. `None` without sites, or if the memory is too little
    /// for a single one.
    #[must_use]
    pub fn new(view: &View, sites: Vec<Place>, params: &ExemplarParams) -> Option<Self> {
        let offered = sites.len();
        let affordable = affordable_sites(view, params);
        let most = params.most_sites.min(affordable);
        let sites = thinned(view.surface, sites, most);
        let rotations = params.rotations as usize;
        #[expect(clippy::cast_possible_truncation, reason = "directions are single")]
        let turns: Vec<[f32; 2]> = (0..rotations)
            .map(|r| {
                let angle = std::f64::consts::TAU * r as f64 / rotations as f64;
                [angle.cos() as f32, angle.sin() as f32]
            })
            .collect();
        let points: Vec<Point3<f64>> = sites.iter().map(|s| view.surface.position(s)).collect();
        if points.is_empty() {
            return None;
        }
        let positions = PointTree::new(&points);
        let table = Table::build(
            sites.len() * rotations,
            view.channels.count(),
            view.stencil.weights(),
            |candidate, out| {
                let place = sites[candidate / rotations].turned(turns[candidate % rotations]);
                Walker::default().gather(view, &place, view.stencil.len(), out);
            },
        );
        let similar = match params.similar {
            0 => Similar::default(),
            k => {
                let width = (view.stencil.offsets().last()).map_or(0.0, |[x, y]| x.hypot(*y));
                similar::most_similar(&table, &points, k, f64::from(width))
            }
        };
        Some(Self {
            distance: typical_distance(&positions, &points),
            positions,
            points,
            similar,
            sites,
            thinned_by_memory: affordable < params.most_sites.min(offered),
            offered,
            turns,
            table,
        })
    }

    /// The sites.
    #[must_use]
    pub fn sites(&self) -> &[Place] {
        &self.sites
    }

    /// How many sites there were before thinning.
    #[must_use]
    pub fn offered(&self) -> usize {
        self.offered
    }

    /// Whether there are fewer sites than asked for because the memory does not hold more.
    #[must_use]
    pub fn thinned_by_memory(&self) -> bool {
        self.thinned_by_memory
    }

    /// The neighborhoods: candidate s·R + r is site s, turned by r·2π/R.
    #[must_use]
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Bytes that the tables take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let similar: usize = self
            .similar
            .candidates
            .iter()
            .map(|list| 4 * list.len())
            .sum();
        Table::bytes(
            self.table.len(),
            self.table.offsets(),
            self.table.channels(),
        ) + size_of_val(&self.sites[..])
            + similar
    }

    /// What a good match costs on this surface: the median over the sites of the cost of the candidate
    /// most similar to each, of those a window away; 0 if similar ones were not asked for.
    #[must_use]
    pub fn typical_cost(&self) -> f32 {
        self.similar.typical_cost
    }

    /// Typical distance of a site to the next, in the scan's unit.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// The place of a candidate, its frame turned as the neighborhood is.
    #[must_use]
    pub fn place(&self, candidate: u32) -> Place {
        let (candidate, rotations) = (candidate as usize, self.turns.len());
        self.sites[candidate / rotations].turned(self.turns[candidate % rotations])
    }

    /// Whether two candidates are at most two sites and a twelfth of a turn apart.
    #[must_use]
    pub fn are_close(&self, a: u32, b: u32) -> bool {
        let rotations = index(self.turns.len());
        let turn = (a % rotations).abs_diff(b % rotations);
        let turn = turn.min(rotations - turn);
        let [a, b] = [a, b].map(|candidate| self.points[(candidate / rotations) as usize]);
        turn * 12 <= rotations && (a - b).norm() <= 2.0 * self.distance
    }

    /// Places that look as the surroundings of `place` do: it stands to them as it stands to the site
    /// next to it, of which they are the most similar ones.
    pub fn similar_places(&self, surface: &Surface, place: &Place) -> impl Iterator<Item = Place> {
        let position = surface.position(place);
        let site = self.positions.nearest(&position).index;
        let own = &self.sites[site];
        let offset = surface.to_local(own, &(position - surface.position(own)));
        let axis = surface.to_local(own, &surface.axis(place));
        let length = axis[0].hypot(axis[1]);
        let turn = axis.map(|x| x / length);
        // Where the one stands upright on the other there is no telling the turn.
        let list = (self.similar.candidates.get(site)).filter(|_| length > 1e-3);
        list.into_iter().flatten().filter_map(move |candidate| {
            Some(surface.walk(&self.place(*candidate), offset)?.turned(turn))
        })
    }
}

/// How many sites the memory holds.
fn affordable_sites(view: &View, params: &ExemplarParams) -> usize {
    params.memory.saturating_sub(block_bytes(view)) / bytes_a_site(view, params)
}

/// Bytes without which no exemplar can be made.
#[must_use]
pub fn least_bytes(view: &View, params: &ExemplarParams) -> usize {
    block_bytes(view) + bytes_a_site(view, params)
}

/// Tables come in blocks: the last one may be the larger part empty.
fn block_bytes(view: &View) -> usize {
    Table::bytes(1, view.stencil.len(), view.channels.count())
}

/// Bytes that the tables take for each site, at most, while an exemplar is made.
fn bytes_a_site(view: &View, params: &ExemplarParams) -> usize {
    let (offsets, channels) = (view.stencil.len(), view.channels.count());
    // Tables come in blocks; a large one tells the share of a candidate.
    let many = 1 << 12;
    let table = Table::bytes(many, offsets, channels).div_ceil(many);
    let similar = if params.similar > 0 {
        similar::bytes_a_candidate(offsets, channels)
    } else {
        0
    };
    let own = size_of::<Place>() + 2 * size_of::<Point3<f64>>() + 4 * params.similar;
    params.rotations as usize * (table + similar) + own
}

/// At most `most` sites, evenly spread: every so many along a curve that fills space.
fn thinned(surface: &Surface, sites: Vec<Place>, most: usize) -> Vec<Place> {
    if sites.len() <= most {
        return sites;
    }
    let points: Vec<Point3<f64>> = sites.iter().map(|site| surface.position(site)).collect();
    let order = spatial_order(
        &points,
        (0..sites.len())
            .map(|i| u32::try_from(i).expect("sites are u32"))
            .collect(),
    );
    (0..most)
        .map(|i| sites[order[i * order.len() / most] as usize])
        .collect()
}

/// Median distance of a point to the nearest other, of some of the points.
fn typical_distance(tree: &PointTree, points: &[Point3<f64>]) -> f64 {
    const ENOUGH: usize = 256;
    let mut distances: Vec<f64> = (points.iter().step_by(points.len().div_ceil(ENOUGH)))
        .filter_map(|p| {
            tree.nearest_n(p, 2)
                .get(1)
                .map(|other| other.distance_sq.sqrt())
        })
        .collect();
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or(0.0)
}

fn index(i: usize) -> u32 {
    u32::try_from(i).expect("sites and rotations are u32")
}
