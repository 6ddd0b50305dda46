//! Completes range scans: where the scanner saw nothing, the smooth shape, the *relief* and the
//! *colour* are restored, so that the completed part passes as original.
//!
//! The data walks through the rooms of this crate in this order; a room imports only from rooms
//! above it.
//!
//! | room | in → out | source |
//! |---|---|---|
//! | [`rng`] | seed → Mersenne twister, the only door to randomness | Matsumoto & Nishimura 1998 |
//! | [`progress`] | what a long computation says while it runs | |
//! | [`mesh`] | triangle mesh, adjacency, boundary loops, normals, invariant check | |
//! | [`scan`] | file → [`scan::Scan`] (vertices, faces, every channel) and back | PLY, OBJ, STL, OFF, glTF, XYZ, PTX, PCD, E57, LAS, depth images |
//! | [`repair`] | scan → the same vertices with faces that can be completed, and what was done | |
//! | [`base`] | mesh → base surface, [`base::FitReport`]; or free form, [`base::smooth_form`] | [`bibliography#breckon--fisher-2005`] §3 |
//! | [`cloud`] | scan of points only → scan with faces | [`bibliography#gopi-krishnan--silva-2000`] |
//! | [`relief`] | mesh + base → heights, corrected normals; and heights + base → points | §3, Fig. 5 |
//! | [`sampling`] | hole + base → target vertices, stitched triangulation; 1-to-4 subdivision | §4 |
//! | [`neighborhood`] | vertex → neighbors within a window; place → values on a stencil in its tangent frame | §3; [`bibliography#wei--levoy-2001`] §3.3 |
//! | [`matching`] | neighborhood + samples → best matches over all rotations | §3; [`bibliography#patchmatch-2009`] |
//! | [`likeness`] | surface + piece → how far the piece is from the rest, in units of natural variation | ISO 25178-2 |
//! | [`completion`] | scan → completed scan, grown from the front inwards | Appendix A |
//! | [`texture`] | sample + mesh → the mesh with that texture, in color or as relief | [`bibliography#wei--levoy-2001`] |
//! | [`transfer`] | source mesh + target mesh → the target with the source's texture or relief | [`bibliography#meshmatch-2012`] |
//! | [`stats`] | completed scan → original against completed part in figures; height map → areal parameters | Table 1, Fig. 13; ISO 25178-2 |
//! | [`evaluation`] | scan → holes cut, completed, and judged by the surface's own variation | |
//! | [`picture`] | scan and its channels → picture, drawn on the processor; computes no figures | |
//! | [`report`] | results → a page to look at: tables, plots, the scan in three dimensions | |
//! | [`synth`] | parameters → synthetic scans with known truth | Fig. 8–12 |
//! | [`cli`] | arguments → parameters → one call of a room above | |
//! | `python` | Python's values → one call of [`cli`] or [`scan`] → Python's values; with the feature `python` | |
//!
//! Units: lengths are absolute, in the scan's own (unknown) unit, `f64`; angles are radians;
//! colours are intensities from 0 to 1.

pub mod bibliography;
pub mod rng;
pub mod progress;
pub mod mesh;
pub mod scan;
pub mod repair;
pub mod base;
pub mod cloud;
pub mod relief;
pub mod sampling;
pub mod neighborhood;
pub mod matching;
pub mod likeness;
pub mod completion;
pub mod texture;
pub mod transfer;
pub mod stats;
pub mod evaluation;
pub mod picture;
pub mod report;
pub mod synth;
pub mod cli;
#[cfg(feature = "python")]
mod python;
