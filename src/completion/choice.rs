//! Which holes to fill.

use serde::Serialize;

use crate::mesh::{BoundaryLoop, LoopKind};
use crate::scan::Scan;

use super::{CompleteParams, CompletionError};

/// Which boundary loops to fill. Numbers are those of [`crate::mesh::boundary_loops`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HoleChoice {
    /// All gaps in the surface; outer rims stay open.
    #[default]
    Interior,
    /// Outer rims, too, where the base surface closes behind them (a sphere does, a plane does
    /// not).
    All,
    /// The hole with the largest estimated area.
    Largest,
    /// These, holes or rims.
    Ids(Vec<usize>),
}

/// How large a hole may be to be filled; what is larger stays open.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct HoleLimits {
    /// Most edges around it.
    pub max_edges: Option<usize>,
    /// Largest length around it, in the scan's unit.
    pub max_length: Option<f64>,
    /// Largest area as [`BoundaryLoop::area`] estimates it, in square units of the scan.
    pub max_area: Option<f64>,
}

impl HoleLimits {
    /// Whether a loop is within all limits.
    #[must_use]
    pub fn admit(&self, boundary: &BoundaryLoop) -> bool {
        (self.max_edges).is_none_or(|most| boundary.vertices.len() <= most)
            && self.max_length.is_none_or(|most| boundary.length <= most)
            && self.max_area.is_none_or(|most| boundary.area <= most)
    }
}

/// Vertices that somebody painted to say which holes are meant: those with a painted vertex on their
/// loop.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Paint {
    /// Vertices whose channel of this name is not 0 (and not NaN).
    Channel(String),
    /// Vertices whose channel of this name has this value.
    Value(String, f64),
    /// Vertices of this colour (red, green, blue from 0 to 255), give or take [`COLOR_TOLERANCE`].
    Color([u8; 3]),
}

/// Painted colours may differ by this much in each channel, of 255: programs blend and round.
pub const COLOR_TOLERANCE: u8 = 8;

impl Paint {
    /// For each vertex whether it is painted.
    ///
    /// # Errors
    /// [`CompletionError`] if the scan has no such channel, or no colours, or nothing is painted.
    pub fn vertices(&self, scan: &Scan) -> Result<Vec<bool>, CompletionError> {
        let rows = 0..scan.vertices.rows;
        let painted: Vec<bool> = match self {
            Self::Channel(name) | Self::Value(name, _) => {
                let column = scan.vertices.column(name);
                let column = column.filter(|c| c.is_empty() || c.get_f64(0).is_some());
                let column = column.ok_or_else(|| CompletionError::NoSuchChannel {
                    name: name.clone(),
                    known: channel_names(scan),
                })?;
                let is_painted = |value: f64| match self {
                    Self::Value(_, wanted) => (value - wanted).abs() <= 0.0,
                    _ => value.abs() > 0.0,
                };
                rows.map(|v| column.get_f64(v).is_some_and(is_painted))
                    .collect()
            }
            Self::Color(wanted) => {
                let colors = scan.colors().ok_or(CompletionError::NoColors)?;
                let near =
                    |c: f64, w: u8| (255.0 * c - f64::from(w)).abs() <= f64::from(COLOR_TOLERANCE);
                let is_painted =
                    |color: &[f64; 3]| color.iter().zip(wanted).all(|(c, w)| near(*c, *w));
                colors.iter().map(is_painted).collect()
            }
        };
        if painted.iter().any(|painted| *painted) {
            Ok(painted)
        } else {
            Err(CompletionError::NothingPainted)
        }
    }
}

fn channel_names(scan: &Scan) -> String {
    let names: Vec<&str> = (scan.vertices.channels.iter())
        .map(|c| c.name.as_str())
        .collect();
    names.join(", ")
}

/// Which loops the limits and the paint leave to choose from.
#[derive(Debug)]
pub(super) struct Admitted {
    loops: Vec<bool>,
}

impl Admitted {
    pub(super) fn new(
        scan: &Scan,
        loops: &[BoundaryLoop],
        params: &CompleteParams,
    ) -> Result<Self, CompletionError> {
        let painted = (params.paint.as_ref())
            .map(|paint| paint.vertices(scan))
            .transpose()?;
        let is_painted = |l: &BoundaryLoop| {
            (painted.as_ref()).is_none_or(|p| l.vertices.iter().any(|v| p[*v as usize]))
        };
        let admit = |l: &BoundaryLoop| params.limits.admit(l) && is_painted(l);
        Ok(Self {
            loops: loops.iter().map(admit).collect(),
        })
    }

    pub(super) fn admits(&self, id: usize) -> bool {
        self.loops[id]
    }
}

/// Numbers of the loops to fill, of those asked for one by one; extension is not among them.
pub(super) fn choose(
    loops: &[BoundaryLoop],
    admitted: &Admitted,
    params: &CompleteParams,
) -> Result<Vec<usize>, CompletionError> {
    let Some(last) = loops.len().checked_sub(1) else {
        return Err(CompletionError::Closed);
    };
    let all_holes = || loops.iter().filter(|l| l.kind == LoopKind::Hole);
    let holes = || all_holes().filter(|l| admitted.admits(l.id));
    let chosen: Vec<usize> = match &params.holes {
        HoleChoice::Interior => holes().map(|l| l.id).collect(),
        HoleChoice::All => (0..loops.len()).filter(|id| admitted.admits(*id)).collect(),
        HoleChoice::Largest => match holes().max_by(|a, b| a.area.total_cmp(&b.area)) {
            Some(largest) => vec![largest.id],
            None if params.extend || all_holes().next().is_some() => Vec::new(),
            None => return Err(CompletionError::NoInteriorHole { rims: loops.len() }),
        },
        HoleChoice::Ids(ids) => {
            if let Some(id) = ids.iter().find(|id| **id > last) {
                return Err(CompletionError::NoSuchLoop { id: *id, last });
            }
            let mut ids = ids.clone();
            ids.sort_unstable();
            ids.dedup();
            ids
        }
    };
    let open = all_holes().count();
    if chosen.is_empty() && open > 0 && !params.extend {
        return Err(CompletionError::NoneAdmitted { holes: open });
    }
    Ok(chosen)
}
