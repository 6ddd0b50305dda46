//! The coordinator's part: tasks out, grown tiles in.

use std::fmt;
use std::time::Instant;

use crate::progress::{Clock, Progress, StageTime};
use crate::scan::Scan;

use super::super::begin::{Begun, Prepared, begin};
use super::super::free_form::{FreeFormPlan, plan_on_free_form};
use super::super::growth::Grown;
use super::super::patch::{Patch, Planned, REMEDY, Run};
use super::super::{
    CompleteParams, CompletionError, Input, Method, Work, with_those_off_the_chart,
    without_open_rims,
};
use super::field::Field;
use super::grown::GrownTile;
use super::seams::Steps;
use super::task::TileTask;
use super::{TileError, TileParams, TiledCompletion, Tiling};

/// A completion in tiles: what is chosen once for the whole scan, so that tiles agree, and what was grown so far.
///
/// ```
/// use relievo::completion::{CompleteParams, GrownTile, TileParams, TilePlan, TileTask};
/// # use relievo::synth::{Kind, Part, SynthParams};
/// # let scan = relievo::synth::scan(&SynthParams {
/// #     kind: Kind::Waves, vertices: 1500, part: Part::hole(0.05), ..SynthParams::default()
/// # }).unwrap().scan;
/// let tiles = TileParams { tile: 1000, overlap: None };
/// let params = CompleteParams { window: Some(2), ..CompleteParams::default() };
/// let mut plan = TilePlan::new(&scan, &params, &tiles, &mut |_| {})?;
/// for round in plan.rounds() {
///     // The tiles of a round are independent of each other: each can go to another machine.
///     for tile in round {
///         let sent = plan.task(tile)?.to_bytes();
///         let grown = TileTask::from_bytes(&sent)?.grow(&mut |_| {}).to_bytes();
///         plan.put(tile, GrownTile::from_bytes(&grown)?)?;
///     }
/// }
/// let done = plan.finish(&mut |_| {})?;
/// assert!(done.report.skipped.is_empty());
/// # Ok::<(), relievo::completion::CompletionError>(())
/// ```
pub struct TilePlan {
    scan: Scan,
    params: CompleteParams,
    prepared: Prepared,
    work: Work,
    /// On the scan's own base surface.
    on_base: Option<Gaps>,
    free_form: Option<(FreeFormPlan, Gaps)>,
    /// By tile: whether it is on free form, and its number there.
    tiles: Vec<(bool, usize)>,
    rounds: Vec<Vec<usize>>,
    /// By tile: its round.
    round_of: Vec<usize>,
    fingerprint: u32,
    /// By tile: vertices of its task, once it is put back.
    sizes: Vec<usize>,
    /// Times of the stages so far, and when the last of them ended.
    stages: Vec<StageTime>,
    since: Instant,
}

/// Gaps on one base surface.
struct Gaps {
    planned: Vec<Planned>,
    /// `None` where no gap needs a new vertex.
    field: Option<Field>,
}

impl Gaps {
    fn new(
        patch: &Patch,
        input: &Input,
        planned: Vec<Planned>,
        params: (&CompleteParams, &TileParams),
        work: &mut Work,
        clock: &mut Clock,
    ) -> Result<Self, TileError> {
        let field = if planned.iter().all(|gap| gap.targets.is_empty()) {
            // Counts the patch.
            let _ = Run::new(input, params.0, &planned, work);
            None
        } else {
            let field = Field::new(patch, input, &planned, params, work, clock)?;
            Some(field)
        };
        Ok(Self { planned, field })
    }

    fn collect(
        self,
        patch: &Patch,
        input: &Input,
        params: &CompleteParams,
        (work, steps): (&mut Work, &mut Steps),
        clock: &mut Clock,
    ) {
        match self.field {
            Some(field) => field.collect(patch, self.planned, params, (work, steps), clock),
            None => {
                let canvas = patch.canvas(input, &self.planned);
                patch.collect_all(self.planned, &canvas, Ok(Grown::new(0)), REMEDY, work);
            }
        }
    }
}

impl TilePlan {
    /// Fits the base surface, chooses holes and settings, puts the targets and divides them.
    ///
    /// # Errors
    /// [`CompletionError`] if nothing can be completed at all; [`TileError::ByPaper`] and
    /// [`TileError::Bootstrap`] for what cannot be tiled; [`TileError::TooSmall`].
    pub fn new(
        scan: &Scan,
        params: &CompleteParams,
        tiles: &TileParams,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Self, CompletionError> {
        tiles.check()?;
        if params.method == Method::Paper {
            return Err(TileError::ByPaper.into());
        }
        if params.bootstrap {
            return Err(TileError::Bootstrap.into());
        }
        let mut clock = Clock::new(progress);
        let Begun {
            prepared,
            on_base,
            off_base,
            mut work,
        } = begin(scan, params, &mut clock)?;
        let input = &prepared.input;
        let both = (params, tiles);
        let on_base = match &prepared.whole {
            Some(whole) => {
                let planned = whole.planned(input, on_base, &mut work, &mut clock);
                Some(Gaps::new(
                    whole, input, planned, both, &mut work, &mut clock,
                )?)
            }
            None => None,
        };
        let off_base = with_those_off_the_chart(off_base, input, params, &mut work);
        let off_base = without_open_rims(off_base, input, params, &mut work);
        let mut free_form = None;
        if !off_base.is_empty()
            && let Some(mut plan) =
                plan_on_free_form(input, &off_base, params, &mut work, &mut clock)
        {
            let planned = std::mem::take(&mut plan.planned);
            let (patch, input) = (&plan.patch, &plan.part.input);
            let gaps = Gaps::new(patch, input, planned, both, &mut work, &mut clock)?;
            free_form = Some((plan, gaps));
        }
        let (stages, since) = (clock.stages, clock.since);
        let mut plan = Self {
            scan: scan.clone(),
            params: params.clone(),
            prepared,
            work,
            on_base,
            free_form,
            tiles: Vec::new(),
            rounds: Vec::new(),
            round_of: Vec::new(),
            fingerprint: 0,
            sizes: Vec::new(),
            stages,
            since,
        };
        plan.number();
        Ok(plan)
    }

    /// Numbers the tiles of both fields in a row.
    fn number(&mut self) {
        let mut hasher = crc32fast::Hasher::new();
        for on_free_form in [false, true] {
            let Some(field) = self.field(on_free_form) else {
                continue;
            };
            field.fingerprint(&mut hasher);
            let division = field.division.clone();
            let first = self.tiles.len();
            let own = 0..division.tiles.len();
            self.tiles.extend(own.map(|k| (on_free_form, k)));
            self.round_of.extend(division.round_of);
            let rounds = self.rounds.len().max(division.rounds.len());
            self.rounds.resize(rounds, Vec::new());
            for (round, own) in self.rounds.iter_mut().zip(division.rounds) {
                round.extend(own.into_iter().map(|k| first + k));
            }
        }
        self.fingerprint = hasher.finalize();
        self.sizes = vec![0; self.tiles.len()];
    }

    fn field(&self, on_free_form: bool) -> Option<&Field> {
        let gaps = if on_free_form {
            self.free_form.as_ref().map(|(_, gaps)| gaps)
        } else {
            self.on_base.as_ref()
        };
        gaps?.field.as_ref()
    }

    fn field_mut(&mut self, on_free_form: bool) -> Option<&mut Field> {
        let gaps = if on_free_form {
            self.free_form.as_mut().map(|(_, gaps)| gaps)
        } else {
            self.on_base.as_mut()
        };
        gaps?.field.as_mut()
    }

    /// The numbers of the tiles, round by round: those of a round do not depend on each other, but on all rounds
    /// before.
    #[must_use]
    pub fn rounds(&self) -> Vec<Vec<usize>> {
        self.rounds.clone()
    }

    /// Number of tiles.
    #[must_use]
    pub fn tiles(&self) -> usize {
        self.tiles.len()
    }

    /// New vertices of each tile.
    #[must_use]
    pub fn targets(&self) -> Vec<usize> {
        (self.tiles.iter())
            .filter_map(|(on_free_form, k)| {
                Some(self.field(*on_free_form)?.division.tiles[*k].len())
            })
            .collect()
    }

    /// What is needed to grow a tile.
    ///
    /// # Errors
    /// [`TileError::NoSuchTile`]; [`TileError::TooEarly`] as long as a tile of an earlier round is missing.
    pub fn task(&self, tile: usize) -> Result<TileTask, TileError> {
        let (on_free_form, k) = self.tile(tile)?;
        if let Some(missing) = self.missing(self.round_of[tile]) {
            return Err(TileError::TooEarly { tile, missing });
        }
        let number = u32::try_from(tile).unwrap_or(u32::MAX);
        let field = self.field(on_free_form).ok_or(self.no_such(tile))?;
        Ok(field.task(k, [number, self.fingerprint]))
    }

    /// Takes a tile that was grown. To put back the same one twice changes nothing.
    ///
    /// # Errors
    /// [`TileError::NoSuchTile`]; [`TileError::Foreign`] if it was not grown from the task of this tile.
    pub fn put(&mut self, tile: usize, grown: GrownTile) -> Result<(), TileError> {
        let (on_free_form, k) = self.tile(tile)?;
        let foreign = |reason| TileError::Foreign { tile, reason };
        if grown.plan != self.fingerprint {
            return Err(foreign("it belongs to another plan"));
        }
        if grown.tile() != tile {
            return Err(foreign("it is another tile"));
        }
        let size = grown.vertices as usize;
        let no_such = self.no_such(tile);
        let field = self.field_mut(on_free_form).ok_or(no_such)?;
        field.put(k, grown).map_err(foreign)?;
        self.sizes[tile] = size;
        Ok(())
    }

    fn tile(&self, tile: usize) -> Result<(bool, usize), TileError> {
        self.tiles.get(tile).copied().ok_or(self.no_such(tile))
    }

    fn no_such(&self, tile: usize) -> TileError {
        TileError::NoSuchTile {
            tile,
            tiles: self.tiles.len(),
        }
    }

    /// The first tile of the rounds before that is not back.
    fn missing(&self, rounds: usize) -> Option<usize> {
        let rounds = self.rounds.iter().take(rounds);
        (rounds.flatten().copied()).find(|tile| {
            let (on_free_form, k) = self.tiles[*tile];
            (self.field(on_free_form)).is_some_and(|field| !field.is_back(k))
        })
    }

    /// Whether all tiles are back, so that they can be put together.
    ///
    /// # Errors
    /// [`TileError::Missing`] as long as one is not.
    pub fn check(&self) -> Result<(), TileError> {
        match self.missing(usize::MAX) {
            Some(tile) => Err(TileError::Missing { tile }),
            None => Ok(()),
        }
    }

    /// Puts all together: patches are fitted to each other, and the scan gets its new part.
    ///
    /// # Errors
    /// As [`Self::check`], which leaves the plan as it is.
    pub fn finish(
        self,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<TiledCompletion, CompletionError> {
        self.check()?;
        let tiling = Tiling {
            tiles: self.tiles.len(),
            rounds: self.rounds.len(),
            most_vertices: self.sizes.iter().copied().max().unwrap_or_default(),
        };
        let Self {
            prepared,
            mut work,
            params,
            ..
        } = self;
        let mut clock = Clock {
            since: self.since,
            stages: self.stages,
            progress,
        };
        clock.end("growth");
        let mut steps = Steps::default();
        let input = &prepared.input;
        if let Some((gaps, whole)) = self.on_base.zip(prepared.whole.as_ref()) {
            gaps.collect(whole, input, &params, (&mut work, &mut steps), &mut clock);
        }
        let free_form = self.free_form.map(|(plan, gaps)| {
            let before = work.added.len();
            let (patch, part) = (&plan.patch, &plan.part.input);
            gaps.collect(patch, part, &params, (&mut work, &mut steps), &mut clock);
            plan.done(input, before, &mut work)
        });
        let done = prepared.completed(&self.scan, free_form.as_ref(), work, clock);
        Ok(TiledCompletion {
            scan: done.scan,
            report: done.report,
            seams: steps.report(),
            tiling,
        })
    }
}

impl fmt::Debug for TilePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TilePlan")
            .field("tiles", &self.tiles.len())
            .field("rounds", &self.rounds)
            .finish_non_exhaustive()
    }
}
