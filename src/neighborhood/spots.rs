//! Where the offsets of a stencil lie on a surface, found once and read many times.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::flatten::Flattening;
use super::gather::walk_over;
use super::surface::Reached;
use super::{Charts, Place, Stencil, Surface};

/// No triangle: the offset is not on the surface.
const NONE: u32 = u32::MAX;

/// Where an offset lies: a triangle and the shares of its second and third corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    pub(super) triangle: u32,
    pub(super) shares: [f32; 2],
}

impl Spot {
    pub(super) const NOWHERE: Self = Self {
        triangle: NONE,
        shares: [0.0; 2],
    };

    fn of(reached: &Reached) -> Self {
        let [_, b, c] = reached.weights();
        Self {
            triangle: reached.triangle(),
            shares: [b, c],
        }
    }

    pub(super) fn is_somewhere(&self) -> bool {
        self.triangle != NONE
    }
}

/// Where the J offsets of a stencil around each of n places lie on a surface.
#[derive(Debug, Clone)]
pub struct Spots {
    offsets: usize,
    /// n by J.
    spots: Vec<Spot>,
    /// The surface's, close together.
    corners: Vec<[u32; 3]>,
}

impl Spots {
    /// By walking along the surface, from offset to offset; `None` has its spots nowhere.
    ///
    /// # Panics
    /// If the stencil has 2³² offsets or more.
    #[must_use]
    pub fn walked(surface: &Surface, stencil: &Stencil, places: &[Option<Place>]) -> Self {
        let offsets = stencil.len();
        let numbers = u32::try_from(offsets).expect("a stencil is small");
        let mut spots = vec![Spot::NOWHERE; offsets * places.len()];
        (spots.par_chunks_mut(offsets).zip(places)).for_each_init(
            Vec::new,
            |reached, (row, place)| {
                let Some(place) = place else { return };
                walk_over(
                    reached,
                    surface,
                    stencil,
                    place,
                    0..numbers,
                    |j, reached| {
                        if let Some(reached) = reached {
                            row[j] = Spot::of(&reached);
                        }
                        ControlFlow::Continue(())
                    },
                );
            },
        );
        Self {
            offsets,
            spots,
            corners: surface.triangles(),
        }
    }

    /// Geodesic fans around all vertices: J = 1 + `rings` · `spokes` offsets, the vertex itself, then ring after ring, `spacing`
    /// apart, the spokes of each counterclockwise. Beyond the surface's rim the offset is where the spoke last was on the
    /// surface, so that every offset of every vertex with a triangle is somewhere.
    ///
    /// # Panics
    /// If the surface has 2³² vertices or more.
    ///
    /// # Reference
    /// [Zelinka & Garland 2004](crate::bibliography#zelinka--garland-2004), §3.
    #[must_use]
    pub fn fans(
        surface: &Surface,
        charts: &Charts,
        [rings, spokes]: [usize; 2],
        spacing: f32,
    ) -> Self {
        let offsets = 1 + rings * spokes;
        let vertices = surface.positions().len();
        let mut spots = vec![Spot::NOWHERE; offsets * vertices];
        let numbers = 0..u32::try_from(vertices).expect("vertices are u32");
        (spots.par_chunks_mut(offsets).zip(numbers)).for_each(|(row, v)| {
            let Some(center) = charts.place(surface, v, 0.0) else {
                return;
            };
            let center = Spot::of(&surface.start(&center));
            row[0] = center;
            for spoke in 0..spokes {
                let mut last = center;
                let angle = std::f32::consts::TAU * spoke as f32 / spokes as f32;
                let mut reached = charts
                    .place(surface, v, angle)
                    .map(|place| surface.start(&place));
                for ring in 1..=rings {
                    let offset = [ring as f32 * spacing, 0.0];
                    reached = reached.and_then(|from| surface.step(&from, offset));
                    last = reached.as_ref().map_or(last, Spot::of);
                    row[1 + (ring - 1) * spokes + spoke] = last;
                }
            }
        });
        Self {
            offsets,
            spots,
            corners: surface.triangles(),
        }
    }

    /// By laying the surface around each place flat: triangles are projected onto the plane across a normal
    /// (one a place), and the lattice of a square stencil is laid over them.
    ///
    /// # Panics
    /// If there is not one normal a place, or the stencil is not [`Stencil::square`].
    ///
    /// # Reference
    /// [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001), §3.3: flattening and resampling.
    #[must_use]
    pub fn flattened(
        surface: &Surface,
        stencil: &Stencil,
        places: &[Option<Place>],
        normals: &[Vector3<f64>],
    ) -> Self {
        assert_eq!(places.len(), normals.len(), "one normal a place");
        let offsets = stencil.len();
        let flattening = Flattening::new(surface, stencil);
        let mut spots = vec![Spot::NOWHERE; offsets * places.len()];
        (spots.par_chunks_mut(offsets).zip(places).zip(normals)).for_each_init(
            Default::default,
            |memory, ((row, place), normal)| {
                if let Some(place) = place {
                    flattening.lay(memory, place, normal, row);
                }
            },
        );
        Self {
            offsets,
            spots,
            corners: surface.triangles(),
        }
    }

    /// Number n of places.
    #[must_use]
    pub fn len(&self) -> usize {
        self.spots.len() / self.offsets
    }

    /// Whether there are no places.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.spots.is_empty()
    }

    /// Number J of offsets.
    #[must_use]
    pub fn offsets(&self) -> usize {
        self.offsets
    }

    /// How sharp what is read is: the mean sum of squared shares, 1 if all offsets are at vertices, about 1/2 if they are
    /// anywhere in the triangles. Independent values at the vertices vary by that much less where they are read.
    #[must_use]
    pub fn sharpness(&self) -> f64 {
        let of_spot = |spot: &Spot| {
            let [b, c] = spot.shares.map(f64::from);
            let a = 1.0 - b - c;
            a * a + b * b + c * c
        };
        let spots = || self.spots.iter().filter(|spot| spot.is_somewhere());
        spots().map(of_spot).sum::<f64>() / spots().count().max(1) as f64
    }

    fn row(&self, place: usize) -> &[Spot] {
        &self.spots[place * self.offsets..][..self.offsets]
    }

    /// The vertices whose values a neighborhood is read from, an offset's three together.
    pub fn vertices(&self, place: usize) -> impl Iterator<Item = u32> {
        let spots = self.row(place).iter().filter(|spot| spot.is_somewhere());
        spots.flat_map(|spot| self.corners[spot.triangle as usize])
    }

    /// Whether the values at all offsets of a place are read from vertices that are known.
    #[must_use]
    pub fn all_known(&self, place: usize, known: impl Fn(u32) -> bool) -> bool {
        self.row(place).iter().all(|spot| {
            // A corner without a share in the value need not be known.
            let [b, c] = spot.shares;
            spot.is_somewhere()
                && (self.corners[spot.triangle as usize].into_iter())
                    .zip([1.0 - b - c, b, c])
                    .all(|(v, share)| share.abs() < 1e-4 || known(v))
        })
    }

    /// Reads a neighborhood: at each offset the C values between those of the corners (`values`: #V by C), offset
    /// after offset; `unknown` (C) where an offset is not on the surface.
    ///
    /// # Panics
    /// If `out` has not J · C entries.
    #[inline]
    pub fn read(&self, place: usize, values: &[f32], unknown: &[f32], out: &mut [f32]) {
        let count = unknown.len();
        assert_eq!(out.len(), self.offsets * count, "one row");
        for (spot, out) in self.row(place).iter().zip(out.chunks_exact_mut(count)) {
            if !spot.is_somewhere() {
                out.copy_from_slice(unknown);
                continue;
            }
            let [b, c] = spot.shares;
            let [p, q, r] = self.corners[spot.triangle as usize]
                .map(|v| &values[v as usize * count..][..count]);
            for (k, out) in out.iter_mut().enumerate() {
                *out = (1.0 - b - c) * p[k] + b * q[k] + c * r[k];
            }
        }
    }
}

#[cfg(test)]
mod tests;
