//! A neighborhood read off a surface: the one way in which values come onto a stencil.

use std::ops::ControlFlow;

use super::surface::{Reached, Surface};
use super::{Descriptor, Place, Stencil};

/// Values at the vertices of a surface.
#[derive(Debug, Clone)]
pub struct Channels {
    count: usize,
    /// #V · C, the C channels of a vertex next to each other.
    values: Vec<f32>,
    /// #V: bits of [`KNOWN`] and [`SAMPLE`].
    flags: Vec<u8>,
}

/// Which vertices count when a neighborhood is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Among {
    /// All that are known: scanned, or completed by now.
    Known = 1,
    /// Those that may be copied from.
    Samples = 2,
}

/// A value is known where known corners have at least this share of it.
const LEAST_KNOWN: f32 = 0.5;

impl Channels {
    /// Of `vertices` vertices with `count` values each, nothing known.
    #[must_use]
    pub fn new(vertices: usize, count: usize) -> Self {
        Self {
            count,
            values: vec![0.0; vertices * count],
            flags: vec![0; vertices],
        }
    }

    /// Number C of channels.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Sets the values of vertex `v` (C of them, scaled by the root of their channel's weight) and what
    /// it counts as.
    ///
    /// # Panics
    /// If there are not C values.
    pub fn set(&mut self, v: usize, values: &[f32], among: &[Among]) {
        self.values[v * self.count..][..self.count].copy_from_slice(values);
        self.flags[v] = among.iter().fold(0, |flags, a| flags | *a as u8);
    }

    /// Whether vertex `v` counts.
    #[must_use]
    #[inline]
    pub fn is(&self, v: u32, among: Among) -> bool {
        self.flags[v as usize] & among as u8 != 0
    }

    /// The values of vertex `v`.
    #[must_use]
    #[inline]
    pub fn of(&self, v: u32) -> &[f32] {
        &self.values[v as usize * self.count..][..self.count]
    }

    /// Reads the values at barycentric coordinates: the mean of the known corners, as they share the
    /// point. Whether they have enough of it.
    #[inline]
    fn read(&self, corners: [u32; 3], weights: [f32; 3], among: Among, out: &mut [f32]) -> bool {
        let flags = corners.map(|v| self.flags[v as usize] & among as u8 != 0);
        out.fill(0.0);
        if flags == [true; 3] {
            for (v, w) in corners.into_iter().zip(weights) {
                for (out, value) in out.iter_mut().zip(self.of(v)) {
                    *out += w * value;
                }
            }
            return true;
        }
        let share = |i: usize| if flags[i] { weights[i].max(0.0) } else { 0.0 };
        let known = share(0) + share(1) + share(2);
        if known < LEAST_KNOWN {
            return false;
        }
        for (i, v) in corners.into_iter().enumerate().filter(|(i, _)| flags[*i]) {
            let w = share(i) / known;
            for (out, value) in out.iter_mut().zip(self.of(v)) {
                *out += w * value;
            }
        }
        true
    }
}

/// What is looked at.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// The values at its vertices.
    pub channels: &'a Channels,
    /// The offsets that are looked at.
    pub stencil: &'a Stencil,
    /// Which vertices count.
    pub among: Among,
}

/// The values at an offset of a stencil.
#[derive(Debug, Clone, Copy)]
pub struct Reading<'a> {
    view: &'a View<'a>,
    reached: Reached,
    values: &'a [f32],
}

impl Reading<'_> {
    /// The C values.
    #[must_use]
    #[inline]
    pub fn values(&self) -> &[f32] {
        self.values
    }

    /// How fast the value of a channel grows along the two axes of the frame; 0 where not all that it
    /// follows from is known.
    #[must_use]
    #[inline]
    pub fn gradient(&self, channel: usize) -> [f32; 2] {
        let View {
            surface,
            channels,
            among,
            ..
        } = *self.view;
        let corners = surface.corners(self.reached.triangle());
        if !corners.iter().all(|v| channels.is(*v, among)) {
            return [0.0; 2];
        }
        surface.gradient(&self.reached, corners.map(|v| channels.of(v)[channel]))
    }
}

/// Memory for walking over a stencil; keeps it between calls.
#[derive(Debug, Clone, Default)]
pub struct Walker {
    reached: Vec<Option<Reached>>,
    values: Vec<f32>,
}

impl Walker {
    /// Walks from `place` to offsets of the stencil, ascending numbers with the parents of each among
    /// them, and reads the values there: `each` hears the number of an offset and what is read
    /// (`None` where it is not known, or the surface does not lead there), and may break off.
    ///
    /// # Panics
    /// If an offset comes before its parent.
    #[inline]
    pub fn visit(
        &mut self,
        view: &View,
        place: &Place,
        offsets: impl Iterator<Item = u32>,
        mut each: impl FnMut(usize, Option<Reading>) -> ControlFlow<()>,
    ) {
        let View {
            surface,
            channels,
            stencil,
            among,
        } = *view;
        let Self { reached, values } = self;
        values.resize(channels.count, 0.0);
        walk_over(reached, surface, stencil, place, offsets, |j, reached| {
            let reading = reached.and_then(|reached| {
                let corners = surface.corners(reached.triangle());
                let known = channels.read(corners, reached.weights(), among, values);
                known.then_some(Reading {
                    view,
                    reached,
                    values,
                })
            });
            each(j, reading)
        });
    }

    /// Reads a neighborhood: values and mask of the first `count` offsets; the rest is unknown.
    ///
    /// # Panics
    /// If the stencil has fewer offsets, or more than 2³².
    pub fn gather(&mut self, view: &View, place: &Place, count: usize, out: &mut Descriptor) {
        let channels = view.channels.count;
        out.clear();
        let first = 0..u32::try_from(count).expect("a stencil is small");
        self.visit(view, place, first, |j, reading| {
            if let Some(reading) = reading {
                out.values[j * channels..][..channels].copy_from_slice(reading.values);
                out.known.set(j);
            }
            ControlFlow::Continue(())
        });
    }
}

/// Walks from `place` to offsets of the stencil, ascending numbers with the parents of each among them: `each`
/// hears the number of an offset and where it lies (`None` where the surface does not lead there), and may
/// break off. `reached` is memory that is kept between calls.
///
/// # Panics
/// If an offset comes before its parent.
#[inline]
pub(super) fn walk_over(
    reached: &mut Vec<Option<Reached>>,
    surface: &Surface,
    stencil: &Stencil,
    place: &Place,
    offsets: impl Iterator<Item = u32>,
    mut each: impl FnMut(usize, Option<Reached>) -> ControlFlow<()>,
) {
    reached.resize(stencil.len(), None);
    let start = surface.start(place);
    for j in offsets {
        let j = j as usize;
        reached[j] = if j == 0 {
            Some(start)
        } else {
            let parent = reached[stencil.parents()[j] as usize];
            parent.and_then(|parent| surface.step(&parent, stencil.offsets()[j]))
        };
        if each(j, reached[j]).is_break() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;
    use crate::rng::{Rng, Stage};
    use approx::assert_relative_eq;
    use nalgebra::{Point3, Vector3};

    /// A sheet of n by n squares with their corners shaken, at height z; vertices from `first` on.
    fn sheet(n: u32, z: f64, first: u32, rng: &mut Rng) -> TriMesh {
        let side = n + 1;
        let positions = (0..side * side)
            .map(|v| {
                let mut shaken = |i: u32| f64::from(i) + 0.5 * (rng.uniform() - 0.5);
                Point3::new(shaken(v % side), shaken(v / side), z)
            })
            .collect();
        let triangles = (0..n * n)
            .flat_map(|cell| {
                let a = first + cell / n * side + cell % n;
                let (b, c, d) = (a + 1, a + side, a + side + 1);
                if cell % 3 == 0 {
                    [[a, b, d], [a, d, c]]
                } else {
                    [[a, b, c], [b, d, c]]
                }
            })
            .collect();
        TriMesh {
            positions,
            triangles,
        }
    }

    fn channels(mesh: &TriMesh, value: impl Fn(&Point3<f64>) -> f32) -> Channels {
        let mut channels = Channels::new(mesh.positions.len(), 1);
        for (v, p) in mesh.positions.iter().enumerate() {
            channels.set(v, &[value(p)], &[Among::Known, Among::Samples]);
        }
        channels
    }

    #[expect(clippy::cast_possible_truncation, reason = "single values")]
    fn linear(p: &Point3<f64>) -> f32 {
        (0.3 * p.x - 0.7 * p.y + 2.0) as f32
    }

    #[test]
    fn a_linear_function_is_read_exactly_in_any_direction() {
        let mut rng = Rng::new(1, Stage::Synth, 0);
        let mesh = sheet(20, 0.0, 0, &mut rng);
        let surface = Surface::new(mesh.clone());
        let channels = channels(&mesh, linear);
        let mut walker = Walker::default();
        for stencil in [
            Stencil::disc(5, 0.9),
            Stencil::square(3, 1.3),
            Stencil::fan(4, 12, 1.1),
        ] {
            let view = View {
                surface: &surface,
                channels: &channels,
                stencil: &stencil,
                among: Among::Samples,
            };
            let mut found = Descriptor::new(stencil.len(), 1);
            for _ in 0..50 {
                let v = 21 * (7 + rng.index(6)) + 7 + rng.index(6);
                let angle = rng.uniform() * 6.3;
                let axis = Vector3::new(angle.cos(), angle.sin(), 0.0);
                let place = surface.at_vertex(u32::try_from(v).unwrap(), &axis).unwrap();
                assert_relative_eq!(surface.position(&place), mesh.positions[v], epsilon = 1e-5);
                assert_relative_eq!(surface.axis(&place), axis, epsilon = 1e-5);
                walker.gather(&view, &place, stencil.len(), &mut found);
                assert_eq!(found.known.count(), stencil.len());
                for ([x, y], value) in stencil.offsets().iter().zip(&found.values) {
                    let y_axis = Vector3::z().cross(&axis);
                    let p = mesh.positions[v] + axis * f64::from(*x) + y_axis * f64::from(*y);
                    assert_relative_eq!(*value, linear(&p), epsilon = 2e-5);
                }
            }
        }
    }

    #[test]
    fn a_neighborhood_does_not_jump_across_a_gap() {
        let mut rng = Rng::new(2, Stage::Synth, 0);
        // Two sheets closer to each other than their vertices are; the lower has a slit.
        let mut mesh = sheet(12, 0.0, 0, &mut rng);
        let crosses = |t: &[u32; 3]| t.iter().any(|v| v % 13 == 6) && t.iter().any(|v| v % 13 > 6);
        mesh.triangles.retain(|t| !crosses(t));
        let first = u32::try_from(mesh.positions.len()).unwrap();
        let upper = sheet(12, 0.05, first, &mut rng);
        mesh.positions.extend(upper.positions);
        mesh.triangles.extend(upper.triangles);
        let surface = Surface::new(mesh.clone());
        let channels = channels(&mesh, |p| if p.z > 0.0 { 1.0 } else { linear(p) - 9.0 });
        let stencil = Stencil::disc(3, 1.0);
        let view = View {
            surface: &surface,
            channels: &channels,
            stencil: &stencil,
            among: Among::Samples,
        };
        let place = surface.at_vertex(6 * 13 + 5, &Vector3::x()).unwrap();
        let mut found = Descriptor::new(stencil.len(), 1);
        Walker::default().gather(&view, &place, stencil.len(), &mut found);
        for j in 0..stencil.len() {
            if found.known.get(j) {
                assert!(found.values[j] < 0.0);
                assert!(stencil.offsets()[j][0] < 2.0);
            } else {
                assert!(stencil.offsets()[j][0] > 0.0);
            }
        }
        assert!(found.known.count() > 10 && found.known.count() < stencil.len());
    }

    #[test]
    fn what_is_not_known_is_masked_and_never_a_number() {
        let mut rng = Rng::new(3, Stage::Synth, 0);
        let mesh = sheet(12, 0.0, 0, &mut rng);
        let surface = Surface::new(mesh.clone());
        let mut channels = channels(&mesh, linear);
        for (v, p) in mesh.positions.iter().enumerate() {
            if p.x > 6.0 {
                channels.set(v, &[f32::NAN], &[]);
            }
        }
        let stencil = Stencil::disc(3, 1.0);
        let view = View {
            surface: &surface,
            channels: &channels,
            stencil: &stencil,
            among: Among::Known,
        };
        let place = surface.at_vertex(6 * 13 + 6, &Vector3::x()).unwrap();
        let mut found = Descriptor::new(stencil.len(), 1);
        Walker::default().gather(&view, &place, stencil.len(), &mut found);
        assert!(found.values.iter().all(|value| value.is_finite()));
        assert!(found.known.count() > 8 && found.known.count() < stencil.len() - 8);
        for j in found.known.iter() {
            assert!(stencil.offsets()[j][0] < 1.2);
        }
    }

    #[test]
    fn a_walk_around_a_sphere_is_as_long_as_its_circle() {
        let made = crate::synth::scan(&crate::synth::SynthParams {
            kind: crate::synth::Kind::GolfBall,
            vertices: 3000,
            part: crate::synth::Part::default(),
            noise: 0.0,
            seed: 1,
        })
        .unwrap();
        let mesh = made.scan.mesh();
        let relief = crate::relief::extract(&mesh, &made.base);
        let feet = TriMesh {
            positions: relief.feet.clone(),
            triangles: mesh.triangles,
        };
        let surface = Surface::new(feet);
        let radius = relief.feet[0].coords.norm();
        let along = relief.normals[7].cross(&Vector3::x()).normalize();
        let start = surface.at_vertex(7, &along).unwrap();
        #[expect(clippy::cast_possible_truncation, reason = "a length")]
        let quarter = (0.5 * std::f64::consts::PI * radius) as f32;
        let end = surface.walk(&start, [quarter, 0.0]).unwrap();
        let expected = Point3::from(along * radius);
        assert!((surface.position(&end) - expected).norm() < 0.03 * radius);
        assert!((surface.axis(&end) + relief.normals[7]).norm() < 0.05);
    }
}
