//! The paper's search: all neighborhoods of the sample, two passes a level.
//!
//! # Reference
//! [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001), §3.

use rayon::prelude::*;

use crate::matching::batch::Batch;
use crate::matching::nearby::{Nearby, NearbyParams};
use crate::rng::Rng;

use super::descriptors::Part;
use super::level::{Painted, Work};
use super::paint::shuffle;
use super::params::Search;
use super::waves::Waves;

/// Finds the nearest neighborhoods.
enum Finder<'a> {
    Exhaustive(Batch),
    Tree(Nearby<'a>),
}

impl<'a> Finder<'a> {
    fn new(rows: &'a [f32], width: usize, search: Search) -> Self {
        match search {
            Search::Exhaustive => Self::Exhaustive(Batch::new(rows, width)),
            Search::Tree => Self::Tree(Nearby::new(rows, width, &NearbyParams::default())),
        }
    }

    fn nearest_of_all(&self, queries: &[f32], width: usize) -> Vec<(u32, f32)> {
        match self {
            Self::Exhaustive(batch) => batch.nearest_of_all(queries),
            Self::Tree(tree) => (queries.par_chunks(width))
                .map(|query| tree.find(query, 1, |_| true)[0])
                .collect(),
        }
    }
}

/// Two passes: from the coarser level alone, then also with what the first one left on this level. Vertices are visited
/// in random order.
pub(super) fn run(work: &Work, painted: &mut Painted, search: Search, rng: &mut Rng) {
    let sites = work.sites;
    let (width, coarse_width) = (sites.width, sites.coarse_width);
    let mut order: Vec<u32> = (0..work.len()).collect();
    if coarse_width > 0 {
        let coarse_rows = sites.coarse_rows();
        let finder = Finder::new(&coarse_rows, coarse_width, search);
        let rows = work.reader(painted).rows(&order, Part::Coarse);
        let found = finder.nearest_of_all(&rows, coarse_width);
        for (v, (site, cost)) in order.iter().zip(found) {
            painted.set(*v, work.place(site), sites, cost / coarse_width as f32);
        }
    }
    if width == coarse_width + sites.mean.len() {
        // A neighborhood of one texel is what it was drawn as.
        return;
    }
    let finder = Finder::new(&sites.rows, width, search);
    shuffle(&mut order, rng);
    for wave in Waves::new(&work.looks.own, &order).iter() {
        let rows = work.reader(painted).rows(wave, Part::Whole);
        let found = finder.nearest_of_all(&rows, width);
        for (v, (site, cost)) in wave.iter().zip(found) {
            painted.set(*v, work.place(site), sites, cost / width as f32);
        }
    }
}
