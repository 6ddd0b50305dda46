//! A surface with all that is read off it once.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use serde::Serialize;

use crate::mesh::{TriMesh, vertex_areas, vertex_normals};
use crate::neighborhood::Surface;
use crate::rng::{Rng, Stage};

use super::curved::CurvedChannels;
use super::seam::Bend;
use super::{Discs, Figure, areal, classifier, color, laplacian, readings, seam, variogram};
use readings::{LAGS, VertexReading};

/// A piece with less than this share of its area off the seam is all seam, and looked at as a whole.
const LEAST_INNER: f64 = 0.2;

/// A surface with heights and colours.
#[derive(Debug, Clone, Copy)]
pub struct FieldInput<'a> {
    /// The foot points on the base surface, and the triangles.
    pub feet: &'a TriMesh,
    /// #V heights over the base, in the scan's unit; NaN for vertices that are not to be looked at.
    pub heights: &'a [f64],
    /// #V intensities of red, green and blue in sRGB, from 0 to 1.
    pub colors: Option<&'a [[f64; 3]]>,
    /// The scan's median edge: the unit of all distances that are looked at.
    pub step: f64,
}

/// One thing that every vertex has: height, or a coordinate of its colour.
#[derive(Debug, Clone)]
pub(super) struct Quantity {
    /// Before the names of its figures: empty for the height.
    pub(super) prefix: &'static str,
    /// #V values.
    pub(super) values: Vec<f64>,
    /// #V.
    pub(super) readings: Vec<VertexReading>,
    /// Vertices with a Laplacian, by ascending value of it.
    pub(super) by_laplacian: Vec<u32>,
    /// Vertices with a value, by ascending value.
    pub(super) by_value: Vec<u32>,
    /// By angle.
    pub(super) bends: Vec<Bend>,
}

/// A surface, and what every vertex sees around it.
#[derive(Debug, Clone)]
pub struct Field {
    pub(super) feet: TriMesh,
    /// #V: areas of the base surface; 0 for vertices that are not looked at.
    pub(super) areas: Vec<f64>,
    pub(super) step: f64,
    pub(super) discs: Discs,
    /// Height first, then L\*, a\*, b\*.
    pub(super) quantities: Vec<Quantity>,
}

/// A piece, its seam, and the part that it is compared with.
#[derive(Debug)]
pub(super) struct Split {
    /// #V: whether a vertex is of the piece.
    pub(super) in_piece: Vec<bool>,
    /// Those of the piece that are not in the seam: what is said of them is not said of how the piece fits
    /// in.
    pub(super) inner: Vec<u32>,
    /// #V.
    pub(super) in_inner: Vec<bool>,
    /// #V: within two median edges of the rim, on either side.
    pub(super) in_seam: Vec<bool>,
    /// #V: known, and neither in the piece nor in its seam.
    pub(super) in_reference: Vec<bool>,
}

impl Field {
    /// Reads the surface.
    ///
    /// # Panics
    /// If heights or colours are not one a vertex.
    #[must_use]
    pub fn new(input: FieldInput) -> Self {
        let FieldInput {
            feet,
            heights,
            colors,
            step,
        } = input;
        assert_eq!(heights.len(), feet.positions.len(), "one height a vertex");
        let mut values = vec![("", heights.to_vec())];
        if let Some(colors) = colors {
            assert_eq!(heights.len(), colors.len(), "one colour a vertex");
            values.extend(color::quantities(colors));
        }
        let counts: Vec<bool> = heights.iter().map(|height| height.is_finite()).collect();
        let (feet, _) = feet.clone().centered();
        let surface = Surface::new(feet.clone());
        let count = values.len();
        let curved = CurvedChannels::new(&feet, &values, &counts);
        let axes = smooth_axes(&vertex_normals(&feet));
        let read = readings::read(&surface, &curved, &axes, step);
        let quantities = (values.into_iter().enumerate())
            .map(|(c, (prefix, values))| {
                let readings = read.iter().skip(c).step_by(count).copied().collect();
                let bends = seam::bends(&surface, &feet, &values, step);
                Quantity::new(prefix, values, readings, bends)
            })
            .collect();
        let mut areas = vertex_areas(&feet);
        for (area, counts) in areas.iter_mut().zip(&counts) {
            *area = if *counts { *area } else { 0.0 };
        }
        Self {
            discs: Discs::new(&feet, &counts, step),
            areas,
            feet,
            step,
            quantities,
        }
    }

    /// Area of the base surface under a piece, in square units.
    #[must_use]
    pub fn area(&self, piece: &[u32]) -> f64 {
        piece.iter().map(|v| self.areas[*v as usize]).sum()
    }

    /// The foot points around their centroid, and the triangles.
    #[must_use]
    pub fn feet(&self) -> &TriMesh {
        &self.feet
    }

    /// The unit of all distances that are looked at, see [`FieldInput::step`].
    #[must_use]
    pub fn step(&self) -> f64 {
        self.step
    }

    /// #V: whether a vertex is one of the given, and is looked at.
    #[must_use]
    pub fn marked(&self, vertices: &[u32]) -> Vec<bool> {
        let mut marks = vec![false; self.areas.len()];
        for v in vertices {
            marks[*v as usize] = self.areas[*v as usize] > 0.0;
        }
        marks
    }

    /// True pieces to calibrate with: `count` discs of the given area around random vertices, within the
    /// known part and away from its rims.
    #[must_use]
    pub fn pieces(&self, known: &[bool], area: f64, count: usize, seed: u32) -> Vec<Vec<u32>> {
        let allowed: Vec<bool> = (known.iter().zip(&self.areas))
            .map(|(known, area)| *known && *area > 0.0)
            .collect();
        let discs = Discs::new(&self.feet, &allowed, self.step);
        discs.random(area, count, &mut Rng::new(seed, Stage::Likeness, 0))
    }

    /// All figures of a piece (vertices, ascending) against the known part of the surface, without the
    /// piece itself where it is known; always the same figures in the same order.
    #[must_use]
    pub fn figures(&self, piece: &[u32], known: &[bool]) -> Vec<Figure> {
        let split = Split::new(self, piece, known);
        let mut figures = Vec::new();
        let height = &self.quantities[0];
        figures.push(laplacian::figure(self, height, &split));
        let variograms = variogram::Both::new(self, height, &split);
        figures.push(variogram::figure(height, &variograms));
        figures.extend(areal::figures(self, height, &split, &variograms));
        figures.extend(seam::figures(self, height, &split));
        figures.push(classifier::figure(self, &self.quantities[..1], &split));
        if self.quantities.len() > 1 {
            figures.extend(color::figures(self, &split));
        }
        figures
    }

    /// The variogram of the height of a part: distances in the scan's unit, and half the mean squared
    /// difference of two heights so far apart, over all directions. Distances at which nothing is known are left
    /// out.
    #[must_use]
    pub fn variogram(&self, part: &[u32]) -> Vec<(f64, f64)> {
        let by_direction = variogram::of_part(self, &self.quantities[0], part.iter().copied());
        (LAGS.iter().enumerate())
            .filter_map(|(lag, edges)| {
                let known = (by_direction.iter().skip(lag).step_by(LAGS.len()))
                    .filter(|square| square.is_finite());
                let count = known.clone().count();
                let mean = known.sum::<f64>() / count as f64;
                (count > 0).then_some((*edges as f64 * self.step, 0.5 * mean))
            })
            .collect()
    }

    /// ISO 25178-2 figures of the height of a part of the surface.
    #[must_use]
    pub fn areal(&self, part: &[u32]) -> Option<super::ArealFigures> {
        areal::of_part(self, &self.quantities[0], part.iter().copied())
    }
}

impl Split {
    fn new(field: &Field, piece: &[u32], known: &[bool]) -> Self {
        let marked = |vertices: &[u32]| {
            let mut marks = vec![false; field.areas.len()];
            for v in vertices {
                marks[*v as usize] = true;
            }
            marks
        };
        let in_piece = marked(piece);
        let in_seam = marked(&seam::around(field, piece, &in_piece));
        let mut inner: Vec<u32> = piece.to_vec();
        inner.retain(|v| !in_seam[*v as usize]);
        if field.area(&inner) < LEAST_INNER * field.area(piece) {
            inner = piece.to_vec();
        }
        Self {
            in_reference: (0..known.len())
                .map(|v| known[v] && !in_piece[v] && !in_seam[v])
                .collect(),
            in_inner: marked(&inner),
            inner,
            in_piece,
            in_seam,
        }
    }

    pub(super) fn reference(&self) -> impl Iterator<Item = u32> + Clone {
        (0u32..)
            .zip(&self.in_reference)
            .filter(|(_, is)| **is)
            .map(|(v, _)| v)
    }
}

impl Quantity {
    fn new(
        prefix: &'static str,
        values: Vec<f64>,
        readings: Vec<VertexReading>,
        bends: Vec<Bend>,
    ) -> Self {
        let laplacian = |v: u32| f64::from(readings[v as usize].laplacian);
        Self {
            by_laplacian: ascending(readings.len(), laplacian),
            by_value: ascending(values.len(), |v| values[v as usize]),
            prefix,
            values,
            readings,
            bends,
        }
    }

    pub(super) fn laplacian(&self, v: u32) -> f64 {
        f64::from(self.readings[v as usize].laplacian)
    }

    /// A figure's name with that of the quantity before it.
    pub(super) fn named(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }
}

/// Vertices with a number, by ascending number.
fn ascending(count: usize, value: impl Fn(u32) -> f64) -> Vec<u32> {
    let mut order: Vec<u32> = (0u32..)
        .take(count)
        .filter(|v| !value(*v).is_nan())
        .collect();
    order.sort_by(|a, b| value(*a).total_cmp(&value(*b)).then(a.cmp(b)));
    order
}

/// A tangent at each vertex that turns smoothly over the surface: the projection of the one direction
/// that the normals are least along (on a cylinder its axis, on a plane any direction in it).
fn smooth_axes(normals: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let spread: Matrix3<f64> = normals.iter().map(|n| n * n.transpose()).sum();
    let eigen = SymmetricEigen::new(spread);
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| eigen.eigenvalues[*i].total_cmp(&eigen.eigenvalues[*j]));
    let [axis, instead, _] = order.map(|i| eigen.eigenvectors.column(i).into_owned());
    (normals.iter())
        .map(|normal| {
            let along = |axis: &Vector3<f64>| axis - normal * axis.dot(normal);
            along(&axis)
                .try_normalize(1e-6)
                .or_else(|| along(&instead).try_normalize(1e-6))
                .unwrap_or(instead)
        })
        .collect()
}

/// A name and a number for each figure of a group.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Named {
    pub(super) name: &'static str,
    pub(super) value: Option<f64>,
}
