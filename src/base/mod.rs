//! Scan to base surface: the smooth shape underneath the relief, and how well it fits.
//!
//! Every surface answers the same question, "where is the foot point of this point, which way is
//! out, and how high above is it": see [`BaseSurface::foot`].

mod chart;
mod surface;

pub use chart::Chart;
pub use surface::{
    BaseKind, BaseSurface, Cone, Cylinder, Foot, Plane, Sphere, perpendicular_frame,
};
