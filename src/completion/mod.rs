//! Scan to completed scan: base surface, relief, targets, growth.
//!
//! [`complete`] is the list of these steps. Originals come first in its result, bit for bit;
//! completion only appends.
//!
//! # Reference
//! [Breckon & Fisher 2005](crate::bibliography#breckon--fisher-2005), Appendix A.

mod assemble;
mod audit;
mod begin;
mod blend;
mod by_paper;
mod by_stencil;
mod choice;
mod correlation;
mod error;
mod free_form;
mod gaps;
mod ground;
mod growth;
mod noted;
mod own_base;
mod params;
mod patch;
mod ready;
mod report;
mod scale;
mod smooth_part;
mod suited;
mod surroundings;
mod tiled;

pub use assemble::{COMPLETED, COST, HEIGHT, SOURCE};
pub use choice::{COLOR_TOLERANCE, HoleChoice, HoleLimits, Paint};
pub use error::CompletionError;
pub use noted::{
    RememberedBase, RememberedFreeForm, noted_relief, remembered_base, remembered_free_form,
};
pub use params::{CompleteParams, Method};
pub use report::{
    Chosen, CompletionReport, Counts, FilledHole, FreeFormReport, Recall, Searched, SkippedHole,
};

pub use tiled::{
    GrownTile, SeamReport, StepsWithin, TileError, TileParams, TilePlan, TileTask, TiledCompletion,
    Tiling, WorstBorder, complete_tiled,
};

use crate::mesh::{Adjacency, BoundaryLoop, LoopKind, TriMesh};
use crate::progress::{Clock, Progress};
use crate::sampling::EdgeSpacing;
use crate::scan::Scan;

use begin::{Begun, Prepared, begin};
use patch::{Added as AddedGap, NumberedGap};

/// A completed scan.
#[derive(Debug, Clone)]
pub struct Completion {
    /// The scan with the completed part appended and the channels [`COMPLETED`], [`HEIGHT`],
    /// [`SOURCE`] and [`COST`].
    pub scan: Scan,
    /// What was done.
    pub report: CompletionReport,
}

/// Completes the scan's missing parts with relief and colour.
///
/// Holes that lie off the scan's base surface (all, if no kind of base surface fits the whole scan)
/// are completed on free form, or by the paper's method each on a base surface of its own, fitted to its
/// surroundings. Holes that cannot be filled are reported in
/// [`CompletionReport::skipped`]; that is no error.
///
/// # Errors
/// [`CompletionError`] if nothing can be completed at all.
pub fn complete(
    scan: &Scan,
    params: &CompleteParams,
    progress: &mut dyn FnMut(Progress),
) -> Result<Completion, CompletionError> {
    let mut clock = Clock::new(progress);
    let Begun {
        prepared,
        on_base,
        off_base,
        mut work,
    } = begin(scan, params, &mut clock)?;
    let Prepared { input, whole, .. } = &prepared;
    if let Some(whole) = whole {
        whole.complete(input, on_base, params, &mut work, &mut clock);
    }
    let off_base = with_those_off_the_chart(off_base, input, params, &mut work);
    let free_form = complete_off_base(input, off_base, params, &mut work, &mut clock);
    Ok(prepared.completed(scan, free_form.as_ref(), work, clock))
}

/// Completes gaps that have no place on the scan's own base surface: on free form, or by the paper's method
/// each on a base surface of its own.
fn complete_off_base(
    input: &Input,
    off_base: Vec<NumberedGap>,
    params: &CompleteParams,
    work: &mut Work,
    clock: &mut Clock,
) -> Option<free_form::FreeFormDone> {
    if params.method == Method::Paper {
        for gap in off_base {
            own_base::complete_on_own_base(input, &gap, params, work, clock);
        }
        return None;
    }
    let gaps = without_open_rims(off_base, input, params, work);
    if gaps.is_empty() {
        return None;
    }
    free_form::complete_on_free_form(input, &gaps, params, work, clock)
}

/// The gaps but for outer rims that were not asked for one by one: free form has no end that would tell how
/// to close what is outside of a rim.
fn without_open_rims(
    off_base: Vec<NumberedGap>,
    input: &Input,
    params: &CompleteParams,
    work: &mut Work,
) -> Vec<NumberedGap> {
    let (gaps, rims): (Vec<NumberedGap>, Vec<_>) = off_base.into_iter().partition(|gap| {
        params.holes != HoleChoice::All || input.loops[gap.rim_ids[0]].kind == LoopKind::Hole
    });
    work.skipped.extend(rims.into_iter().map(|gap| SkippedHole {
        loops: gap.rim_ids,
        reason: "it is an outer rim, and no base surface closes behind it; to close it all the same give its number to --holes".to_owned(),
    }));
    gaps
}

/// The gaps off the base surface, and holes that lie on it but turn over or cross themselves as seen along
/// its normals, as between stones: they are filled on free form, too.
fn with_those_off_the_chart(
    mut off_base: Vec<NumberedGap>,
    input: &Input,
    params: &CompleteParams,
    work: &mut Work,
) -> Vec<NumberedGap> {
    for (gap, reason) in std::mem::take(&mut work.off_chart) {
        let is_hole = |id: &usize| input.loops[*id].kind == LoopKind::Hole;
        if params.method != Method::Paper && gap.rim_ids.iter().all(is_hole) {
            off_base.push(gap);
        } else {
            work.skipped.push(SkippedHole {
                loops: gap.rim_ids,
                reason,
            });
        }
    }
    off_base
}

/// The scan as every step sees it: around its centroid, so that large offsets (national grids) cost
/// no precision.
#[derive(Debug)]
struct Input {
    mesh: TriMesh,
    adjacency: Adjacency,
    loops: Vec<BoundaryLoop>,
    colors: Option<Vec<[f64; 3]>>,
    spacing: EdgeSpacing,
    /// Whether a vertex may be copied from; what an earlier completion invented may not.
    scanned: Vec<bool>,
    /// Number of vertices on stray pieces of surface, which are not copied from either.
    strays: usize,
}

/// What was completed so far.
#[derive(Debug, Default)]
struct Work {
    added: Vec<AddedGap>,
    skipped: Vec<SkippedHole>,
    /// Gaps that cannot be filled in the chart of the scan's own base surface, and why.
    off_chart: Vec<(NumberedGap, String)>,
    /// Samples searched on the scan's own base surface.
    samples: usize,
    searched: Searched,
    /// What was chosen for want of being given.
    chosen: Vec<Chosen>,
    /// Number of patches begun: each has random numbers of its own.
    patches: u32,
}

impl Work {
    fn vertices(&self) -> usize {
        self.added.iter().map(|gap| gap.points.len()).sum()
    }

    fn faces(&self) -> usize {
        self.added.iter().map(|gap| gap.triangles.len()).sum()
    }

    fn filled(&self) -> Vec<FilledHole> {
        self.added.iter().map(|gap| gap.report.clone()).collect()
    }
}

fn index(v: usize) -> u32 {
    u32::try_from(v).expect("vertex indices are u32")
}
