//! How to read and how to write.

use std::path::PathBuf;

/// What a file does not tell by itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Names of the columns of a text file without a line of names (see [`super::Format::Xyz`]), in
    /// their order; `-` skips one. Default `None`: guessed from their number and values.
    pub columns: Option<Vec<String>>,
    /// The camera of a depth image, which cannot be read without.
    pub intrinsics: Option<Intrinsics>,
    /// A colour image of the same size as the depth image.
    pub color_image: Option<PathBuf>,
}

/// A pinhole camera, in pixels: column u and row v of a pixel's centre (counted from 0) see along
/// ((u − cx)/fx, (v − cy)/fy, 1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics {
    /// Focal length along columns.
    pub fx: f64,
    /// Focal length along rows.
    pub fy: f64,
    /// Column of the principal point.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
}

/// How to write.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// PLY as text instead of binary; the other formats have one way only. Default: binary.
    pub ascii: bool,
}
