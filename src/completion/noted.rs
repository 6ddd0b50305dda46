//! What the heights of a completed scan are over, noted in the scan's comments.

use nalgebra::Vector3;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::base::{BaseSurface, FreeForm};
use crate::mesh::TriMesh;
use crate::relief::{self, Relief};
use crate::scan::Scan;

use super::assemble::earlier_marks;
use super::free_form::relief_of_completed;

/// Start of the comment line that says which base surface the heights are over.
const BASE_COMMENT: &str = "relievo base ";
/// … and of the one that says which free form.
const FREE_FORM_COMMENT: &str = "relievo free form ";

/// What a completed scan's heights are over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RememberedBase {
    /// The base surface.
    pub surface: BaseSurface,
    /// Largest absolute height that counts as relief, in the scan's unit.
    pub reach: f64,
}

/// What the heights of a scan that was completed on free form are over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RememberedFreeForm {
    /// The free form.
    pub form: FreeForm,
    /// Largest absolute height that counts as relief, in the scan's unit.
    pub reach: f64,
}

/// Notes what the heights are over in the scan's comments, instead of what an earlier completion noted.
pub(super) fn remember(
    scan: &mut Scan,
    base: Option<&RememberedBase>,
    free_form: Option<&RememberedFreeForm>,
) {
    let ours = [BASE_COMMENT, FREE_FORM_COMMENT];
    (scan.comments).retain(|line| !ours.iter().any(|start| line.starts_with(start)));
    let notes = [
        (BASE_COMMENT, base.map(serde_json::to_string)),
        (FREE_FORM_COMMENT, free_form.map(serde_json::to_string)),
    ];
    for (start, note) in notes {
        match note {
            Some(Ok(json)) => scan.comments.push(format!("{start}{json}")),
            Some(Err(error)) => log::warn!("the base surface is not written down: {error}"),
            None => {}
        }
    }
}

/// The base surface that a completed scan's heights are over, if its comments tell.
#[must_use]
pub fn remembered_base(scan: &Scan) -> Option<RememberedBase> {
    noted(scan, BASE_COMMENT)
}

/// The free form that a completed scan's heights are over, if its comments tell.
#[must_use]
pub fn remembered_free_form(scan: &Scan) -> Option<RememberedFreeForm> {
    noted(scan, FREE_FORM_COMMENT)
}

fn noted<T: DeserializeOwned>(scan: &Scan, start: &str) -> Option<T> {
    (scan.comments.iter())
        .find_map(|line| line.strip_prefix(start))
        .and_then(|json| serde_json::from_str(json).ok())
}

/// The relief of a completed scan over the base that its comments note, and how high relief is; `None` if
/// they note none. `mesh` is the scan's moved by `-origin`.
#[must_use]
pub fn noted_relief(scan: &Scan, mesh: &TriMesh, origin: &Vector3<f64>) -> Option<(Relief, f64)> {
    if let Some(RememberedBase { surface, reach }) = remembered_base(scan) {
        return Some((relief::extract(mesh, &surface.translated(-origin)), reach));
    }
    let RememberedFreeForm { form, reach } = remembered_free_form(scan)?;
    let earlier = earlier_marks(scan)?;
    let completed: Vec<bool> = earlier.completed.iter().map(|mark| *mark > 0).collect();
    let relief = relief_of_completed(mesh, &completed, form.wavelength)?;
    Some((relief, reach))
}
