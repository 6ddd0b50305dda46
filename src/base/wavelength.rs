//! Where form ends and relief begins, read off the relief.

use serde::Serialize;

use nalgebra::Point3;

use crate::mesh::{TriMesh, bounding_diagonal};

use super::free_form::{Role, Undetermined, smooth_form};

/// Wavelengths that are tried: this many spacings, and so many more by factors of √2.
const SHORTEST: f64 = 6.0;
const STEPS: i32 = 8;

/// Form is at most as long as this share of the mesh's diagonal: above it there is too little to tell.
const LONGEST_SHARE: f64 = 0.5;

/// Where heights grow with this power of the wavelength or more everywhere, all of them are form: a bend adds
/// to them with the square, relief of its own size with less and less.
const SMOOTH: f64 = 2.0;

/// The wavelength is then this many spacings, and the base goes through the scan.
const NO_RELIEF: f64 = 2.0;

/// What a wavelength leaves to the relief.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Separation {
    /// Wavelength, in the scan's unit.
    pub wavelength: f64,
    /// Median absolute height over the form, in the scan's unit.
    pub height: f64,
}

/// A wavelength with what it was chosen from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WavelengthChoice {
    /// The chosen one, in the scan's unit.
    pub wavelength: f64,
    /// The ones that were tried, ascending.
    pub tried: Vec<Separation>,
    /// Why, in words.
    pub reason: String,
}

/// The wavelength around which heights depend least on it: what is shorter is relief, what is longer is
/// form. Relief of its own size adds nothing to the heights once the wavelength is beyond that size, while
/// form adds to them with a high power of the wavelength. `shape` is as for [`smooth_form`].
///
/// # Errors
/// [`Undetermined`], see [`smooth_form`].
pub fn choose_wavelength(
    mesh: &TriMesh,
    shape: &[Point3<f64>],
    spacing: f64,
) -> Result<WavelengthChoice, Undetermined> {
    let longest = LONGEST_SHARE * bounding_diagonal(&mesh.positions);
    let mut tried = Vec::new();
    for step in 0..STEPS {
        let wavelength = spacing * SHORTEST * f64::powf(2.0, 0.5 * f64::from(step));
        if step > 0 && wavelength > longest {
            break;
        }
        let height = typical_height(mesh, shape, wavelength)?;
        tried.push(Separation { wavelength, height });
    }
    let growth = |pair: &[Separation]| (pair[1].height / pair[0].height).log2();
    let steadiest = (1..tried.len().max(2) - 1)
        .map(|i| (i, growth(&tried[i - 1..=i]) + growth(&tried[i..=i + 1])))
        .filter(|(_, growth)| growth.is_finite())
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let (chosen, reason) = match steadiest {
        Some((_, growth)) if growth > SMOOTH => (
            Separation {
                wavelength: spacing * NO_RELIEF,
                height: 0.0,
            },
            format!(
                "heights grow with the wavelength's power {growth:.2} or more: there is form, but no relief"
            ),
        ),
        Some((i, growth)) => (
            tried[i],
            format!("around it heights grow least with the wavelength: as its power {growth:.2}"),
        ),
        None => (
            tried[0],
            "the scan is too small, or too smooth, to compare wavelengths".to_owned(),
        ),
    };
    Ok(WavelengthChoice {
        wavelength: chosen.wavelength,
        tried,
        reason,
    })
}

fn typical_height(
    mesh: &TriMesh,
    shape: &[Point3<f64>],
    wavelength: f64,
) -> Result<f64, Undetermined> {
    let roles = vec![Role::Measured; mesh.positions.len()];
    let form = smooth_form(mesh, shape, &roles, wavelength)?;
    let used = mesh.used_vertices();
    let mut heights: Vec<f64> = (mesh.positions.iter().zip(&form))
        .zip(&used)
        .filter(|(_, used)| **used)
        .map(|((p, q), _)| (p - q).norm())
        .collect();
    let middle = heights.len() / 2;
    if heights.is_empty() {
        return Ok(0.0);
    }
    Ok(*heights.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square sheet with unit spacing.
    fn sheet(size: u32, height: impl Fn(f64, f64) -> f64) -> TriMesh {
        let mut mesh = TriMesh::default();
        for i in 0..size {
            for j in 0..size {
                let (x, y) = (f64::from(j), f64::from(i));
                mesh.positions.push(Point3::new(x, y, height(x, y)));
                if i + 1 < size && j + 1 < size {
                    let a = i * size + j;
                    mesh.triangles
                        .extend([[a, a + 1, a + size + 1], [a, a + size + 1, a + size]]);
                }
            }
        }
        mesh
    }

    #[test]
    fn it_lies_between_the_waves_of_the_relief_and_the_bends_of_the_form() {
        let waves = |x: f64, y: f64| 0.4 * (x * 0.9).sin() * (y * 0.9).sin();
        let bends = |x: f64, y: f64| 8.0 * (x * 0.045).sin() * (y * 0.05).cos();
        let mesh = sheet(120, |x, y| waves(x, y) + bends(x, y));
        let choice = choose_wavelength(&mesh, &mesh.positions, 1.0).unwrap();
        // Waves are 7 by 7 long (5 along the diagonal), bends 130.
        assert!((10.0..=45.0).contains(&choice.wavelength), "{choice:?}");
        let doubled = sheet(120, |x, y| 2.0 * (waves(x, y) + bends(x, y)));
        let scaled = TriMesh {
            positions: doubled
                .positions
                .iter()
                .map(|p| Point3::new(2.0 * p.x, 2.0 * p.y, p.z))
                .collect(),
            ..doubled
        };
        let scaled = choose_wavelength(&scaled, &scaled.positions, 2.0).unwrap();
        assert!((scaled.wavelength - 2.0 * choice.wavelength).abs() < 1e-9);
    }

    #[test]
    fn a_scan_without_relief_gets_a_wavelength_too() {
        let flat = sheet(30, |_, _| 0.0);
        let choice = choose_wavelength(&flat, &flat.positions, 1.0).unwrap();
        assert!(choice.wavelength > 0.0 && !choice.reason.is_empty());
        let bent = sheet(60, |x, y| 0.01 * x * y + 3.0 * (0.1 * x).sin());
        let choice = choose_wavelength(&bent, &bent.positions, 1.0).unwrap();
        assert!(choice.wavelength < 10.0, "{choice:?}");
    }
}
