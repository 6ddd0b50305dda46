//! Evenly spaced points on a base surface: hexagonal rows on what unrolls, a Fibonacci spiral on the
//! sphere. Angles and lengths are measured on the surface.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Vector3};

use crate::base::{BaseSurface, Cone, Cylinder, Sphere, perpendicular_frame};

/// Distance of rows over distance of points within a row in a hexagonal lattice.
const ROW_PITCH: f64 = 0.866_025_403_784_438_6;

/// The golden angle, π(3 − √5).
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// A point of the lattice.
#[derive(Debug, Clone, Copy)]
pub(super) struct LatticePoint {
    pub(super) point: Point3<f64>,
    /// Whether it stands on the end of the surface (first or last row, side of the rectangle).
    pub(super) border: bool,
}

/// The part of a base surface that a lattice covers.
#[derive(Debug, Clone)]
pub(super) enum Region {
    /// A rectangle: corner and two perpendicular edge vectors.
    Rectangle(Point3<f64>, [Vector3<f64>; 2]),
    /// A cap around a pole, up to a polar angle.
    Cap(Sphere, Vector3<f64>, f64),
    /// Wall of a cylinder: heights along the axis, angles around it.
    Wall(Cylinder, [f64; 2], Angles),
    /// Wall of a cone: slant lengths from the apex, angles around the axis.
    ConeWall(Cone, [f64; 2], Angles),
}

/// Angles around an axis, in the frame of [`perpendicular_frame`].
#[derive(Debug, Clone, Copy)]
pub(super) enum Angles {
    All,
    /// From the first for the second (in radians).
    From(f64, f64),
}

impl Angles {
    /// The smallest interval that holds all of `angles`.
    pub(super) fn covering(mut angles: Vec<f64>) -> Self {
        angles.sort_unstable_by(f64::total_cmp);
        let n = angles.len();
        let gap = |i: usize| {
            let next = if i + 1 < n {
                angles[i + 1]
            } else {
                angles[0] + TAU
            };
            next - angles[i]
        };
        match (0..n).max_by(|i, j| gap(*i).total_cmp(&gap(*j))) {
            Some(widest) => Self::From(angles[(widest + 1) % n], TAU - gap(widest)),
            None => Self::All,
        }
    }
}

/// Heights (or slant lengths) and angles of points on a cylinder or cone.
pub(super) fn along_and_around(base: &BaseSurface, p: &Point3<f64>) -> Option<(f64, f64)> {
    let (axis, from) = match base {
        BaseSurface::Cylinder(cylinder) => (&cylinder.axis, p - cylinder.point),
        BaseSurface::Cone(cone) => (&cone.axis, p - cone.apex),
        _ => return None,
    };
    let [first, second] = perpendicular_frame(axis);
    let along = match base {
        BaseSurface::Cone(_) => from.norm(),
        _ => from.dot(axis),
    };
    Some((along, from.dot(&second).atan2(from.dot(&first))))
}

impl Region {
    /// Area over the area of one lattice point: about how many points the lattice will have.
    pub(super) fn predicted_points(&self, spacing: f64) -> f64 {
        let span = |angles: &Angles| match angles {
            Angles::All => TAU,
            Angles::From(_, span) => *span,
        };
        let area = match self {
            Self::Rectangle(_, [a, b]) => (a.norm() + spacing) * (b.norm() + spacing),
            Self::Cap(sphere, _, polar) => TAU * sphere.radius.powi(2) * (1.0 - polar.cos()),
            Self::Wall(cylinder, [low, high], angles) => {
                (cylinder.radius * span(angles) + spacing) * (high - low + spacing)
            }
            Self::ConeWall(cone, [low, high], angles) => {
                let middle = 0.5 * (low + high) * cone.half_angle.sin();
                (middle * span(angles) + spacing) * (high - low + spacing)
            }
        };
        area / (spacing * spacing * ROW_PITCH)
    }

    /// The lattice of points about `spacing` apart. With `exact_ends` the first and the last row
    /// (and the rectangle's sides) are met exactly.
    pub(super) fn points(&self, spacing: f64, exact_ends: bool) -> Vec<LatticePoint> {
        match self {
            Self::Rectangle(corner, [a, b]) => {
                let (width, height) = (a.norm(), b.norm());
                let (a, b) = (a.normalize(), b.normalize());
                strip([0.0, height], spacing, exact_ends, |row, t| {
                    columns(width, spacing, row, exact_ends)
                        .into_iter()
                        .map(|(s, border)| (corner + a * s + b * t, border))
                        .collect()
                })
            }
            Self::Cap(sphere, pole, polar) => fibonacci_cap(sphere, pole, *polar, spacing),
            Self::Wall(cylinder, ends, angles) => {
                let [first, second] = perpendicular_frame(&cylinder.axis);
                strip(*ends, spacing, exact_ends, |row, height| {
                    ring(cylinder.radius, spacing, row, *angles)
                        .map(|angle| {
                            let out = first * angle.cos() + second * angle.sin();
                            let along = cylinder.axis.scale(height);
                            (cylinder.point + along + out * cylinder.radius, false)
                        })
                        .collect()
                })
            }
            Self::ConeWall(cone, ends, angles) => {
                let [first, second] = perpendicular_frame(&cone.axis);
                let (sin, cos) = cone.half_angle.sin_cos();
                strip(*ends, spacing, exact_ends, |row, slant| {
                    ring(slant * sin, spacing, row, *angles)
                        .map(|angle| {
                            let out = first * angle.cos() + second * angle.sin();
                            (
                                cone.apex + (cone.axis.scale(cos) + out * sin) * slant,
                                false,
                            )
                        })
                        .collect()
                })
            }
        }
    }
}

/// Rows a pitch apart between two ends; `row(number, position)` gives the points of one.
fn strip(
    [low, high]: [f64; 2],
    spacing: f64,
    exact_ends: bool,
    row: impl Fn(usize, f64) -> Vec<(Point3<f64>, bool)>,
) -> Vec<LatticePoint> {
    let pitch = spacing * ROW_PITCH;
    let steps = count((high - low) / pitch).max(1);
    let step = if exact_ends {
        (high - low) / steps as f64
    } else {
        pitch
    };
    (0..=steps)
        .flat_map(|number| {
            let end = exact_ends && (number == 0 || number == steps);
            row(number, low + step * number as f64)
                .into_iter()
                .map(move |(point, border)| LatticePoint {
                    point,
                    border: border || end,
                })
        })
        .collect()
}

/// Positions along an open row, every second row shifted by half; (position, at an end).
fn columns(width: f64, spacing: f64, row: usize, exact_ends: bool) -> Vec<(f64, bool)> {
    let steps = count(width / spacing).max(1);
    let step = if exact_ends {
        width / steps as f64
    } else {
        spacing
    };
    let odd = row % 2 == 1;
    let shift = if odd { 0.5 } else { 0.0 };
    let mut columns: Vec<_> = (0..=steps)
        .filter(|i| !(odd && *i == steps))
        .map(|i| {
            let end = exact_ends && !odd && (i == 0 || i == steps);
            ((i as f64 + shift) * step, end)
        })
        .collect();
    if odd && exact_ends {
        columns.extend([(0.0, true), (width, true)]);
    }
    columns
}

/// Angles of a ring of points, every second ring shifted by half a step.
fn ring(radius: f64, spacing: f64, row: usize, angles: Angles) -> impl Iterator<Item = f64> {
    let steps = count(TAU * radius / spacing).max(3);
    let step = TAU / steps as f64;
    let shift = if row % 2 == 1 { 0.5 } else { 0.0 };
    let (start, span) = match angles {
        Angles::All => (0.0, TAU - 0.5 * step),
        Angles::From(start, span) => (start, span),
    };
    // Rings keep the same lattice however long the interval is, so start on a multiple of the step.
    let first = (start / step).floor();
    let points = count(span / step) + 1;
    (0..=points)
        .map(move |i| (first + i as f64 + shift) * step)
        .take(if matches!(angles, Angles::All) {
            steps
        } else {
            points + 1
        })
}

/// Fibonacci spiral around `pole`, about hexagonal in density: consecutive points turn by the golden
/// angle and descend by equal areas.
fn fibonacci_cap(
    sphere: &Sphere,
    pole: &Vector3<f64>,
    polar: f64,
    spacing: f64,
) -> Vec<LatticePoint> {
    let pole = nalgebra::Unit::new_normalize(*pole);
    let [first, second] = perpendicular_frame(&pole);
    let whole = 2.0 * TAU * sphere.radius.powi(2) / (spacing * spacing * ROW_PITCH);
    let lowest = polar.min(PI).cos();
    (0..count(whole))
        .map(|i| (i as f64, 1.0 - (2.0 * i as f64 + 1.0) / whole))
        .take_while(|(_, z)| *z >= lowest)
        .map(|(i, z)| {
            let (sin, cos) = (i * GOLDEN_ANGLE).sin_cos();
            let radial = (1.0 - z * z).max(0.0).sqrt();
            let direction = (first * cos + second * sin) * radial + pole.scale(z);
            LatticePoint {
                point: sphere.center + direction * sphere.radius,
                border: false,
            }
        })
        .collect()
}

/// A nonnegative length ratio as a number of steps.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounded, not negative, and checked against the target limit before"
)]
fn count(ratio: f64) -> usize {
    ratio.max(0.0).round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Unit;

    fn nearest(points: &[LatticePoint], i: usize) -> f64 {
        (points.iter().enumerate())
            .filter(|(j, _)| *j != i)
            .map(|(_, q)| (q.point - points[i].point).norm())
            .fold(f64::INFINITY, f64::min)
    }

    fn regions() -> Vec<Region> {
        let axis = Unit::new_normalize(Vector3::new(0.2, 1.0, -0.4));
        vec![
            Region::Rectangle(Point3::origin(), [Vector3::x() * 3.0, Vector3::y() * 2.0]),
            Region::Cap(
                Sphere {
                    center: Point3::origin(),
                    radius: 1.0,
                },
                Vector3::z(),
                2.0,
            ),
            Region::Wall(
                Cylinder {
                    point: Point3::origin(),
                    axis,
                    radius: 1.0,
                },
                [-1.0, 1.0],
                Angles::All,
            ),
            Region::ConeWall(
                Cone {
                    apex: Point3::origin(),
                    axis,
                    half_angle: 0.6,
                },
                [1.0, 2.5],
                Angles::All,
            ),
        ]
    }

    #[test]
    fn points_are_about_the_spacing_apart_and_as_many_as_predicted() {
        for region in regions() {
            for exact_ends in [false, true] {
                let points = region.points(0.1, exact_ends);
                let predicted = region.predicted_points(0.1);
                assert_relative_eq!(points.len() as f64, predicted, max_relative = 0.1);
                // The rectangle's sides and a cone's rings of unequal number come closer.
                let close = (0..points.len()).filter(|i| nearest(&points, *i) < 0.07);
                assert!(close.count() * 10 < points.len(), "{region:?}");
                let far = (0..points.len()).filter(|i| nearest(&points, *i) > 0.13);
                assert_eq!(far.count(), 0, "{region:?}");
            }
        }
    }

    #[test]
    fn exact_ends_are_met() {
        let region = &regions()[2];
        let points = region.points(0.11, true);
        let axis = Vector3::new(0.2, 1.0, -0.4).normalize();
        let heights: Vec<f64> = points.iter().map(|p| p.point.coords.dot(&axis)).collect();
        let max = heights.iter().copied().fold(f64::MIN, f64::max);
        assert_relative_eq!(max, 1.0, epsilon = 1e-12);
        for (p, h) in points.iter().zip(heights) {
            assert_eq!(p.border, h.abs() > 0.999);
        }
    }

    #[test]
    fn an_interval_of_angles_covers_its_points_across_the_turn() {
        let Angles::From(start, span) = Angles::covering(vec![3.0, -3.0, -2.5, 2.9]) else {
            panic!("not all angles");
        };
        assert_relative_eq!(start, 2.9);
        assert_relative_eq!(span, TAU - 5.4, epsilon = 1e-12);
    }
}
