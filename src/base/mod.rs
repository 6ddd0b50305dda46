//! Scan to base surface: the smooth shape underneath the relief, and how well it fits.
//!
//! Every surface answers the same question, "where is the foot point of this point, which way is
//! out, and how high above is it": see [`BaseSurface::foot`]. [`fit`] finds the surface.

mod chart;
mod surface;
mod params;
mod error;
mod report;
mod samples;
mod robust;
mod model;
mod axis;
mod plane;
mod sphere;
mod cylinder;
mod cone;
mod refine;
mod select;
mod fit;
mod wavelength;
mod form;
mod free_form;
#[cfg(test)]
mod tests;

pub use chart::Chart;
pub use error::FitError;
pub use fit::{fit, fit_part};
pub use form::{Form, FreeForm};
pub use free_form::{Role, Undetermined, smooth_form};
pub use params::{BaseChoice, FitParams, Loss, Weighting};
pub use report::{Candidate, Degenerate, FitReport, MAX_RELIEF_SHARE, StopReason};
pub use surface::{
    BaseKind, BaseSurface, Cone, Cylinder, Foot, Plane, Sphere, perpendicular_frame,
};
pub use wavelength::{Separation, WavelengthChoice, choose_wavelength};
