//! Vertex to neighborhood: who is within the window, in which frame, with which weight.

mod frame;
mod window;

pub use frame::{Frame, local_frames};
pub use window::{Window, gaussian_weight, window_sigma};
