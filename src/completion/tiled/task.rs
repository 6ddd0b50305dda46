//! A tile to be grown: all that a worker needs.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::mesh::{Adjacency, TriMesh};
use crate::neighborhood::{Frame, Place, Surface};
use crate::progress::Progress;
use crate::relief::Relief;
use crate::rng::{Rng, Stage};

use super::super::by_stencil::{ByStencil, StencilParams};
use super::super::ground::{Ground, Originals};
use super::super::growth::{Canvas, Growth};
use super::super::scale::Scale;
use super::TileError;
use super::grown::{Copy, GrownTile};
use super::places::{Spot, Spots};
use super::sealed::{opened, sealed};

const KIND: &str = "tile to be grown";

/// What a vertex of a tile is: the sum of these.
pub(super) const KNOWN: u8 = 1;
/// … It may be copied from.
pub(super) const COPIED: u8 = 2;
/// … It was measured.
pub(super) const MEASURED: u8 = 4;

/// A tile to be grown, with all that is needed for it: goes to a worker as bytes.
///
/// Its vertices are some that the scanner saw, new ones that other tiles complete (or have completed), and at last its
/// own. The same task gives the same [`GrownTile`], however often and wherever it is grown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TileTask {
    pub(super) tile: u32,
    /// Tells the plan from others.
    pub(super) plan: u32,
    pub(super) stencil: StencilParams,
    pub(super) scale: Scale,
    pub(super) error_threshold: f64,
    /// Number of vertices that the scanner saw, and of those that are not the tile's own.
    pub(super) scanned: u32,
    pub(super) first_own: u32,
    /// By vertex: its number in the plan.
    pub(super) numbers: Vec<u32>,
    /// By vertex.
    pub(super) roles: Vec<u8>,
    pub(super) feet: Vec<Point3<f64>>,
    pub(super) axes: Vec<[Vector3<f64>; 3]>,
    /// By vertex; 0 for what is not known.
    pub(super) heights: Vec<f64>,
    /// By vertex, if colours have a say in what matches.
    pub(super) colors: Option<Vec<[f64; 3]>>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// By triangle: whether it lies on the base.
    pub(super) lying: Vec<bool>,
    /// Where some of the new vertices that others have completed were copied from.
    pub(super) sources: Vec<(u32, Spot)>,
}

impl TileTask {
    /// Number of the tile.
    #[must_use]
    pub fn tile(&self) -> usize {
        self.tile as usize
    }

    /// Number of its vertices: never more than [`super::TileParams::tile`].
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.feet.len()
    }

    /// Number of vertices that it completes.
    #[must_use]
    pub fn targets(&self) -> usize {
        self.feet.len() - self.first_own as usize
    }

    /// The task as bytes: the same on every machine.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        sealed(KIND, self)
    }

    /// A task from its bytes.
    ///
    /// # Errors
    /// [`TileError::Damaged`] if they are not just what [`Self::to_bytes`] has made; [`TileError::OtherVersion`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TileError> {
        let task: Self = opened(KIND, bytes)?;
        match task.defect() {
            None => Ok(task),
            Some(reason) => Err(TileError::Damaged { kind: KIND, reason }),
        }
    }

    /// Grows relief and colour over the tile; `progress` hears how far it is.
    ///
    /// The result does not depend on the number of threads.
    #[must_use]
    pub fn grow(&self, progress: &mut dyn FnMut(Progress)) -> GrownTile {
        let mut canvas = self.canvas();
        let matcher = ByStencil::new(self.ground(&canvas), self.stencil);
        let copies = matcher.map(|mut matcher| {
            let [seed, stream] = self.stencil.seed;
            let mut rng = Rng::new(seed, Stage::Completion, stream);
            let growth = Growth::new(&mut canvas, self.stencil.window, self.error_threshold);
            let total = self.targets();
            let grown = growth.run(&mut matcher, &mut rng, |done| {
                progress(Progress {
                    stage: "growth",
                    done,
                    total,
                });
            });
            let first = canvas.first_target;
            let copies = (grown.costs.iter().zip(&grown.sources).enumerate())
                .map(|(target, (cost, source))| {
                    let place = matcher.ground().source(first + target)?;
                    let spot = Spot::of(&matcher.ground().surface, &place);
                    Some(Copy {
                        height: canvas.relief.heights[first + target],
                        cost: (*cost)?,
                        vertex: self.numbers[*source as usize],
                        spot: spot.renumbered(|v| self.numbers[v as usize]),
                    })
                })
                .collect();
            (copies, matcher.searched())
        });
        GrownTile {
            tile: self.tile,
            plan: self.plan,
            vertices: index(self.feet.len()),
            copies,
        }
    }

    fn canvas(&self) -> Canvas {
        let mesh = TriMesh {
            positions: self.feet.clone(),
            triangles: self.triangles.clone(),
        };
        Canvas {
            adjacency: Adjacency::new(&mesh),
            relief: Relief {
                feet: self.feet.clone(),
                normals: self.axes.iter().map(|axes| axes[2]).collect(),
                heights: self.heights.clone(),
                side: 1.0,
            },
            // Nobody asks for points on the relief here.
            points: mesh.positions,
            triangles: mesh.triangles,
            colors: self.colors.clone(),
            known: self.flags(KNOWN),
            first_target: self.first_own as usize,
        }
    }

    fn ground(&self, canvas: &Canvas) -> Ground {
        let lying = self.triangles.iter().zip(&self.lying);
        let surface = Surface::new(TriMesh {
            positions: self.feet.clone(),
            triangles: lying.filter_map(|(t, lies)| lies.then_some(*t)).collect(),
        });
        let spots = (!self.sources.is_empty()).then(|| Spots::new(&surface));
        let sources: Vec<(u32, Place)> = (self.sources.iter())
            .filter_map(|(v, spot)| Some((*v, spots.as_ref()?.place(spot)?)))
            .collect();
        let frames = self.axes.iter().map(|axes| Frame { axes: *axes });
        let [copied, measured] = [COPIED, MEASURED].map(|role| self.flags(role));
        let originals = Originals {
            copied: &copied,
            measured: &measured,
        };
        let first = self.scanned as usize;
        let frames = frames.collect();
        let mut ground = Ground::new(canvas, surface, frames, self.scale, originals, first);
        for (v, place) in sources {
            ground.set_source(v as usize, place);
        }
        ground
    }

    fn flags(&self, role: u8) -> Vec<bool> {
        self.roles.iter().map(|roles| roles & role != 0).collect()
    }

    /// What would lead astray: a task that was read is not trusted.
    fn defect(&self) -> Option<&'static str> {
        let count = self.feet.len();
        let [scanned, first_own] = [self.scanned, self.first_own].map(|n| n as usize);
        let same = [self.numbers.len(), self.roles.len(), self.axes.len()];
        let colors = self.colors.as_ref();
        let finite = |p: &Vector3<f64>| p.iter().all(|x| x.is_finite());
        let stencil = &self.stencil;
        let rules = [
            (
                "numbers of vertices differ",
                same.iter().all(|len| *len == count)
                    && self.heights.len() == count
                    && colors.is_none_or(|colors| colors.len() == count)
                    && self.lying.len() == self.triangles.len(),
            ),
            (
                "its new vertices do not come after the others",
                scanned <= first_own && first_own <= count && u32::try_from(count).is_ok(),
            ),
            (
                "a triangle has a corner that is not there",
                self.triangles.len() < 1 << 30
                    && (self.triangles.iter().flatten()).all(|v| (*v as usize) < count),
            ),
            (
                "a vertex was copied from where nothing is",
                (self.sources.iter()).all(|(v, spot)| {
                    (scanned..first_own).contains(&(*v as usize)) && spot.is_finite()
                }),
            ),
            (
                "a new vertex is known already, or a completed one to be copied from",
                (self.roles.iter().skip(first_own)).all(|roles| *roles == 0)
                    && (self.roles.iter().skip(scanned)).all(|roles| roles & COPIED == 0),
            ),
            (
                "a number is not finite",
                self.feet.iter().all(|p| finite(&p.coords))
                    && self.axes.iter().flatten().all(finite)
                    && self.heights.iter().all(|h| h.is_finite())
                    && colors.is_none_or(|colors| colors.iter().flatten().all(|c| c.is_finite())),
            ),
            ("a parameter is out of its range", stencil.is_in_range()),
            (
                "a parameter is out of its range",
                self.error_threshold > 0.0 && self.scale.is_finite(),
            ),
        ];
        rules.into_iter().find(|rule| !rule.1).map(|rule| rule.0)
    }
}

fn index(v: usize) -> u32 {
    u32::try_from(v).expect("vertex indices are u32")
}
