//! The targets on one base surface, and what has become of them.

use crate::neighborhood::Stencil;

use super::super::by_stencil::NothingToCopy;
use super::super::growth::{Canvas, Grown};
use super::super::patch::{Patch, Planned, REMEDY, Run};
use super::super::ready::{Ready, fit_together};
use super::super::report::Searched;
use super::super::{Clock, CompleteParams, Input, SkippedHole, Work};
use super::division::{Division, NONE};
use super::grown::GrownTile;
use super::places::{Spot, Spots};
use super::region::{Choice, Region};
use super::seams::{Completed, Steps};
use super::task::{COPIED, KNOWN, MEASURED, TileTask};
use super::{TileError, TileParams};

/// There are at most as many base surfaces as this: the scan's own, and free form. Random numbers of a tile
/// follow from its number and that of the surface; those of the first tile are those of the untiled completion.
const SURFACES: u32 = 2;

/// Without being told otherwise the overlap is so many times as wide as a window reaches.
const OVERLAP: f64 = 2.0;

/// Targets on one base surface, divided into tiles.
pub(super) struct Field {
    canvas: Canvas,
    ready: Ready,
    error_threshold: f64,
    /// By triangle of the canvas: whether it lies on the base.
    lying: Vec<bool>,
    spots: Spots,
    pub(super) division: Division,
    tile: usize,
    overlap: f64,
    /// Median length of the scan's edges.
    edge: f64,
    grown: Grown,
    /// By tile.
    searched: Vec<Searched>,
    /// By tile: whether it was put back; if it was not grown, why.
    put: Vec<Option<Result<(), NothingToCopy>>>,
}

impl Field {
    /// Chooses what suits the relief, and divides the targets.
    ///
    /// # Errors
    /// [`TileError::TooSmall`].
    pub(super) fn new(
        patch: &Patch,
        input: &Input,
        planned: &[Planned],
        (params, tiles): (&CompleteParams, &TileParams),
        work: &mut Work,
        clock: &mut Clock,
    ) -> Result<Self, TileError> {
        let mut run = Run::new(input, params, planned, work);
        let canvas = patch.canvas(input, planned);
        let ready = patch.ready(&mut run, &canvas, work, clock);
        clock.end("samples");
        clock.begin("tiles");
        let overlap = tiles.overlap.unwrap_or_else(|| OVERLAP * reach(&ready));
        let division = Division::new(&canvas, tiles.tile, overlap)?;
        clock.end("tiles");
        let targets = canvas.points.len() - canvas.first_target;
        Ok(Self {
            lying: lying(&canvas, &patch.lying, input.mesh.triangles.len()),
            spots: Spots::new(&ready.ground.surface),
            error_threshold: run.settings.error_threshold,
            grown: Grown::new(targets),
            searched: vec![Searched::default(); division.tiles.len()],
            put: vec![None; division.tiles.len()],
            tile: tiles.tile,
            overlap,
            edge: input.spacing.median,
            division,
            ready,
            canvas,
        })
    }

    /// What tells this field from others: all that tasks follow from.
    pub(super) fn fingerprint(&self, hasher: &mut crc32fast::Hasher) {
        let canvas = &self.canvas;
        let feet = canvas.relief.feet.iter().flat_map(|foot| &foot.coords);
        let colors = canvas.colors.iter().flatten().flatten();
        for x in feet.chain(&canvas.relief.heights).chain(colors) {
            hasher.update(&x.to_le_bytes());
        }
        let faces = canvas.triangles.iter().flatten();
        for v in faces.chain(self.division.tiles.iter().flatten()) {
            hasher.update(&v.to_le_bytes());
        }
        for is in [&self.ready.samples, &self.lying, &canvas.known] {
            is.iter().for_each(|is| hasher.update(&[u8::from(*is)]));
        }
        let settings = (self.ready.stencil, self.ready.scale, self.error_threshold);
        let of_tiles = (self.division.rounds.as_slice(), self.overlap, self.tile);
        hasher.update(format!("{settings:?}{of_tiles:?}").as_bytes());
    }

    /// Whether a tile was put back.
    pub(super) fn is_back(&self, k: usize) -> bool {
        self.put[k].is_some()
    }

    /// The task of a tile. `number` and `plan` are told on.
    pub(super) fn task(&self, k: usize, [number, plan]: [u32; 2]) -> TileTask {
        let region = self.region(k);
        let vertices = || {
            let Region {
                scanned,
                others,
                own,
            } = &region;
            (scanned.iter().chain(others).chain(own)).map(|v| *v as usize)
        };
        let mut number_of = vec![NONE; self.canvas.points.len()];
        for (new, old) in (0u32..).zip(vertices()) {
            number_of[old] = new;
        }
        let local = |v: u32| number_of[v as usize];
        let roles = self.roles(k, &region, &number_of);
        let is_known = |new: usize| roles[new] & KNOWN != 0;
        let values = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (vertices().enumerate())
                .map(|(new, v)| if is_known(new) { of(v) } else { 0.0 })
                .collect()
        };
        let mut faces: Vec<u32> = (vertices())
            .flat_map(|v| self.canvas.adjacency.triangles.row(v))
            .copied()
            .collect();
        faces.sort_unstable();
        faces.dedup();
        faces.retain(|f| (self.canvas.triangles[*f as usize].iter()).all(|v| local(*v) != NONE));
        let colors = (self.canvas.colors.as_ref()).filter(|_| self.ready.scale.color > 0.0);
        let mut stencil = self.ready.stencil;
        stencil.seed[1] += SURFACES * index(k);
        TileTask {
            tile: number,
            plan,
            stencil,
            scale: self.ready.scale,
            error_threshold: self.error_threshold,
            scanned: index(region.scanned.len()),
            first_own: index(region.scanned.len() + region.others.len()),
            numbers: vertices().map(index).collect(),
            feet: vertices().map(|v| self.canvas.relief.feet[v]).collect(),
            axes: (vertices().map(|v| self.ready.ground.frames[v].axes)).collect(),
            heights: values(&|v| self.canvas.relief.heights[v]),
            colors: colors.map(|colors| {
                (vertices().enumerate())
                    .map(|(new, v)| if is_known(new) { colors[v] } else { [0.0; 3] })
                    .collect()
            }),
            triangles: (faces.iter())
                .map(|f| self.canvas.triangles[*f as usize].map(local))
                .collect(),
            lying: faces.iter().map(|f| self.lying[*f as usize]).collect(),
            sources: self.sources(&region, &number_of, &roles),
            roles,
        }
    }

    /// Whether a tile in the making sees a vertex: scanned and on the base, or completed in an earlier round. What tiles
    /// of its own round complete must not show, in whatever order they come back.
    fn is_seen(&self, k: usize, v: u32) -> bool {
        let division = &self.division;
        self.canvas.known[v as usize]
            && match (v as usize).checked_sub(self.canvas.first_target) {
                None => true,
                Some(target) => match division.tile_of[target] {
                    NONE => false,
                    tile => division.round_of[tile as usize] < division.round_of[k],
                },
            }
    }

    fn region(&self, k: usize) -> Region {
        let choice = Choice {
            canvas: &self.canvas,
            samples: &self.ready.samples,
            overlap: self.overlap,
            reach: reach(&self.ready),
            edge: self.edge,
            most: self.tile,
        };
        let ground = &self.ready.ground;
        choice.region(&self.division.tiles[k], |v| {
            let place = ground.source(v as usize).filter(|_| self.is_seen(k, v))?;
            Some(ground.surface.corners(place.triangle))
        })
    }

    /// By vertex of a tile.
    fn roles(&self, k: usize, region: &Region, number_of: &[u32]) -> Vec<u8> {
        let samples = &self.ready.samples;
        let neighbors = &self.canvas.adjacency.neighbors;
        let is_in = |v: u32| number_of[v as usize] != NONE;
        // What is smooth at a vertex follows from the slopes of the means of rings.
        let has_ring = |v: u32| {
            let ring = neighbors.row(v as usize).iter();
            ring.clone().all(|n| is_in(*n) || !samples[*n as usize])
        };
        let rings: Vec<bool> = (region.scanned.iter())
            .map(|v| samples[*v as usize] && has_ring(*v))
            .collect();
        let has_rings = |v: u32| {
            let ring = neighbors.row(v as usize).iter();
            // Scanned vertices come first.
            ring.filter(|n| samples[**n as usize])
                .all(|n| is_in(*n) && rings[number_of[*n as usize] as usize])
        };
        let scanned = region.scanned.iter().zip(&rings).map(|(v, has_ring)| {
            let measured = samples[*v as usize];
            let copied = measured && *has_ring && has_rings(*v);
            KNOWN * u8::from(self.canvas.known[*v as usize])
                + COPIED * u8::from(copied)
                + MEASURED * u8::from(measured)
        });
        let others = (region.others.iter()).map(|v| KNOWN * u8::from(self.is_seen(k, *v)));
        (scanned.chain(others))
            .chain(region.own.iter().map(|_| 0))
            .collect()
    }

    /// Where the known ones of a region's other targets were copied from, if that is in the region: of those beside its
    /// own, the others' are not asked for.
    fn sources(&self, region: &Region, number_of: &[u32], roles: &[u8]) -> Vec<(u32, Spot)> {
        let ground = &self.ready.ground;
        let first_own = index(region.scanned.len() + region.others.len());
        let is_own = |v: &u32| (first_own..NONE).contains(&number_of[*v as usize]);
        let is_beside = |v: &u32| {
            let ring = self.canvas.adjacency.neighbors.row(*v as usize);
            ring.iter().any(is_own)
        };
        (index(region.scanned.len())..)
            .zip(&region.others)
            .filter(|(new, v)| roles[*new as usize] & KNOWN != 0 && is_beside(v))
            .filter_map(|(new, v)| {
                let spot = Spot::of(&ground.surface, &ground.source(*v as usize)?);
                let spot = spot.renumbered(|v| number_of[v as usize]);
                spot.has_corners_but(NONE).then_some((new, spot))
            })
            .collect()
    }

    /// Takes what was grown for a tile. Putting it back twice changes nothing.
    ///
    /// # Errors
    /// In words, why it does not belong there.
    pub(super) fn put(&mut self, k: usize, grown: GrownTile) -> Result<(), &'static str> {
        let own = &self.division.tiles[k];
        let (copies, searched) = match grown.copies {
            Ok(grown) => grown,
            Err(reason) => {
                self.put[k] = Some(Err(reason));
                return Ok(());
            }
        };
        if copies.len() != own.len() {
            return Err("it has another number of new vertices");
        }
        let mut placed = Vec::with_capacity(own.len());
        for copy in &copies {
            let Some(copy) = copy else {
                placed.push(None);
                continue;
            };
            let is_sample = self.ready.samples.get(copy.vertex as usize) == Some(&true);
            let is_in_range = copy.height.is_finite() && (0.0..=1.0).contains(&copy.cost);
            if !(is_sample && is_in_range && copy.spot.is_finite()) {
                return Err("a new vertex was copied from what cannot be copied from");
            }
            let place = self.spots.place(&copy.spot);
            let place = place.ok_or("a new vertex was copied from where no triangle is")?;
            placed.push(Some((copy, place)));
        }
        for (v, placed) in own.iter().map(|v| *v as usize).zip(placed) {
            let target = v - self.canvas.first_target;
            self.canvas.known[v] = placed.is_some();
            self.grown.costs[target] = placed.map(|(copy, _)| copy.cost);
            let Some((copy, place)) = placed else {
                continue;
            };
            self.grown.sources[target] = copy.vertex;
            self.ready.ground.set_source(v, place);
            self.canvas.relief.heights[v] = copy.height;
            self.canvas.points[v] = self.canvas.relief.point(v, copy.height);
            if let Some(colors) = &mut self.canvas.colors {
                colors[v] = colors[copy.vertex as usize];
            }
        }
        self.searched[k] = searched;
        self.put[k] = Some(Ok(()));
        Ok(())
    }

    /// Fits patches together and puts all gaps to `work`, and the steps between their vertices to `steps`.
    pub(super) fn collect(
        mut self,
        patch: &Patch,
        planned: Vec<Planned>,
        params: &CompleteParams,
        (work, steps): (&mut Work, &mut Steps),
        clock: &mut Clock,
    ) {
        self.searched.iter().for_each(|own| work.searched.add(own));
        let Ready {
            ground, samples, ..
        } = &self.ready;
        fit_together(&mut self.canvas, samples, ground, params, work, clock);
        let is_complete = |gap: &Planned| {
            let costs = &self.grown.costs[gap.targets.clone()];
            costs.iter().all(Option::is_some)
        };
        let mut tile_of = self.division.tile_of.clone();
        for gap in planned.iter().filter(|gap| !is_complete(gap)) {
            tile_of[gap.targets.clone()].fill(NONE);
        }
        steps.add(&Completed {
            canvas: &self.canvas,
            frames: &ground.frames,
            samples,
            tile_of: &tile_of,
            tiles: self.division.tiles.len(),
        });
        let mut grown = Vec::new();
        for gap in planned {
            match self.refusal(&gap) {
                Some(reason) => work.skipped.push(SkippedHole {
                    loops: gap.loops,
                    reason,
                }),
                None => grown.push(gap),
            }
        }
        let remedy = if self.division.tiles.len() > 1 {
            "try a larger --tile, a smaller --window or a larger --spacing"
        } else {
            REMEDY
        };
        patch.collect_all(grown, &self.canvas, Ok(self.grown), remedy, work);
    }

    /// Why a tile of a gap was not grown, in words.
    fn refusal(&self, gap: &Planned) -> Option<String> {
        let refused = (self.division.tile_of[gap.targets.clone()].iter())
            .filter(|tile| **tile != NONE)
            .find_map(|tile| self.put[*tile as usize]?.err())?;
        Some(match refused {
            NothingToCopy::NoSample if self.division.tiles.len() > 1 => format!(
                "one of its tiles has nothing to copy from: {} vertices have no room for enough of the scan; give a larger --tile",
                self.tile
            ),
            _ => refused.to_string(),
        })
    }
}

/// How far a window reaches, in the scan's unit.
fn reach(ready: &Ready) -> f64 {
    let stencil = Stencil::two_scales(ready.stencil.window, ready.stencil.spacing);
    let last = stencil.offsets().last();
    last.map_or(0.0, |[x, y]| f64::from(x.hypot(*y)))
}

/// By triangle of a canvas, which begin with the scan's: whether it lies on the base, as the new ones do, and of the
/// scan's those that are in a list in the same order.
fn lying(canvas: &Canvas, of_scan: &[[u32; 3]], scanned: usize) -> Vec<bool> {
    let mut left = of_scan.iter().peekable();
    (canvas.triangles.iter().enumerate())
        .map(|(f, t)| f >= scanned || left.next_if(|lies| *lies == t).is_some())
        .collect()
}

fn index(v: usize) -> u32 {
    u32::try_from(v).expect("vertex indices are u32")
}
