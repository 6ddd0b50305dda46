//! Vertex to neighborhood: who is within the window, in which frame, with which weight; and a
//! neighborhood as values on a fixed stencil.

mod charts;
mod descriptor;
mod frame;
mod flatten;
mod frame_field;
mod gather;
mod spots;
mod stencil;
mod surface;
mod window;

pub use charts::{Charts, Next};
pub use descriptor::{Descriptor, Mask};
pub use frame::{Frame, local_frames};
pub use frame_field::smooth_frames;
pub use gather::{Among, Channels, Reading, View, Walker};
pub use spots::Spots;
pub use stencil::Stencil;
pub use surface::{Place, Surface};
pub use window::{Window, gaussian_weight, window_sigma};
