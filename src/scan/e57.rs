//! ASTM E57: scans with pose, colours, intensities, and grids.
//!
//! Reference: ASTM E2807-11, *Standard Specification for 3D Imaging Data Exchange*, clause 8.4.

#[cfg(feature = "e57")]
mod layout;
#[cfg(feature = "e57")]
mod reader;

#[cfg(feature = "e57")]
pub(super) use reader::read;

/// Says what this build lacks.
#[cfg(not(feature = "e57"))]
pub(super) fn read(
    source: &super::source::Source,
) -> Result<super::source::Parsed, super::ScanError> {
    Err(super::ScanError::NotBuiltIn {
        name: source.name.to_owned(),
        format: "E57",
        feature: "e57",
    })
}
