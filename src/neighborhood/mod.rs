//! Vertex to neighborhood: who is within the window, in which frame, with which weight; and a
//! neighborhood as values on a fixed stencil.

mod descriptor;
mod frame;
mod window;

pub use descriptor::{Descriptor, Mask};
pub use frame::{Frame, local_frames};
pub use window::{Window, gaussian_weight, window_sigma};
