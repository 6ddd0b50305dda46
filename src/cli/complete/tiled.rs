//! A scan completed in tiles by workers elsewhere: what `--tile` does in one process.

use serde_json::{Map, Value};

use crate::completion::{GrownTile, TilePlan, TileTask};
use crate::repair::Repaired;

use super::super::call::{Call, CallError, Called, guarded};
use super::super::outcome::Failure;
use super::super::watch::Watch;
use super::super::{Common, ScanCommand};
use super::{Arguments, Done, failed, statistics};

/// A completion whose tiles are grown by workers.
///
/// ```
/// use relievo::cli::{Call, Content, Held, TiledCall, grow_tile};
/// use relievo::scan::{ReadOptions, read};
/// use serde_json::json;
///
/// let scan = read("data/scans/golf-ball-half.ply".as_ref(), &ReadOptions::default())?;
/// let mut call = Call::new("complete");
/// call.hold("ball", Held::new("the ball", Content::Scan(scan.into())));
/// call.set("scan", json!("ball"));
/// call.set("extend", json!(true));
/// call.set("tile", json!(1200));
/// call.set("window", json!(2));
/// call.set("sites", json!(64));
/// let mut tiled = TiledCall::new(call)?;
/// for tile in tiled.rounds().into_iter().flatten() {
///     let grown = grow_tile(&tiled.task(tile)?, None, None)?; // anywhere
///     tiled.put(tile, &grown)?;
/// }
/// let done = tiled.finish()?;
/// assert!(done.json["tiling"]["tiles"].as_u64() > Some(1));
/// assert!(done.scan.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct TiledCall {
    arguments: Box<Arguments>,
    surface: Repaired,
    known: Map<String, Value>,
    plan: TilePlan,
    common: Common,
}

impl TiledCall {
    /// Reads the scan, and plans what a call of `complete` with the option `tile` does: nothing is written.
    ///
    /// # Errors
    /// As [`Call::run`].
    pub fn new(call: Call) -> Result<Self, CallError> {
        let threads = call.pool();
        guarded(threads, move || {
            let (command, common) = call.prepared()?;
            let ScanCommand::Complete(arguments) = command else {
                return Err(Failure::usage("only complete works in tiles"));
            };
            Self::planned(Box::new(arguments), common)
        })
    }

    fn planned(arguments: Box<Arguments>, common: Common) -> Result<Self, Failure> {
        let params = arguments.params(common.seed);
        arguments.check(&params)?;
        let tiles = arguments.tiles().unwrap_or_default();
        let mut known = arguments.asked_for(&params);
        let (surface, _) =
            (arguments.prepare).told_surface(&arguments.input, &common, &mut known)?;
        let mut tell = |progress| common.tell(progress);
        let plan = TilePlan::new(&surface.scan, &params, &tiles, &mut tell)
            .map_err(|error| failed(error, &arguments))?;
        Ok(Self {
            arguments,
            surface,
            known,
            plan,
            common,
        })
    }

    /// The tiles in the order in which they have to be grown: those of a round in any order or at the same time.
    #[must_use]
    pub fn rounds(&self) -> Vec<Vec<usize>> {
        self.plan.rounds()
    }

    /// What a worker needs to grow a tile, for [`grow_tile`].
    ///
    /// # Errors
    /// [`CallError`] if there is no such tile, or one of an earlier round is missing.
    pub fn task(&self, tile: usize) -> Result<Vec<u8>, CallError> {
        guarded(None, || Ok(self.plan.task(tile)?.to_bytes()))
    }

    /// Takes what [`grow_tile`] gave.
    ///
    /// # Errors
    /// [`CallError`] if this is damaged, or no answer to the task of this tile.
    pub fn put(&mut self, tile: usize, grown: &[u8]) -> Result<(), CallError> {
        guarded(None, || {
            Ok(self.plan.put(tile, GrownTile::from_bytes(grown)?)?)
        })
    }

    /// Whether all tiles are back, so that they can be put together.
    ///
    /// # Errors
    /// [`CallError`] as long as one is not.
    pub fn check(&self) -> Result<(), CallError> {
        guarded(None, || Ok(self.plan.check()?))
    }

    /// Puts the tiles together: the scan, and the JSON with `tiling` and `seams`.
    ///
    /// # Errors
    /// [`CallError`] if a tile is missing (see [`Self::check`]), or no hole could be filled.
    pub fn finish(self) -> Result<Called, CallError> {
        let (arguments, surface, mut known) = (self.arguments, self.surface, self.known);
        let (plan, common) = (self.plan, self.common);
        guarded(None, move || {
            let mut tell = |progress| common.tell(progress);
            let done = plan.finish(&mut tell);
            let done = Done::from(done.map_err(|error| failed(error, &arguments))?);
            done.describe(&arguments, &mut known)?;
            let finished = surface.restore(done.scan);
            known.extend(statistics(&done.report, &finished));
            Ok(Called {
                partly: !done.report.skipped.is_empty(),
                scan: Some(finished.into()),
                json: known,
                ..Called::default()
            })
        })
    }
}

/// Grows the tile of a [`TiledCall::task`], with so many threads [default: those of the pool it is called from];
/// `watch` may end it. The same task gives the same bytes.
///
/// # Errors
/// [`CallError`] if the task is damaged, or the work was ended.
pub fn grow_tile(
    task: &[u8],
    threads: Option<usize>,
    watch: Option<&Watch>,
) -> Result<Vec<u8>, CallError> {
    guarded(threads, || {
        let grown = TileTask::from_bytes(task)?.grow(&mut |progress| {
            if let Some(watch) = watch {
                watch.tell(progress);
            }
        });
        Ok(grown.to_bytes())
    })
}
