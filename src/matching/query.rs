//! A partly known neighborhood, and what a place costs it.

use std::ops::ControlFlow;

use nalgebra::{Matrix2, Vector2};

use crate::neighborhood::{Descriptor, Place, Stencil, View, Walker};

/// Where a match comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// It continues a neighbor's source.
    Continued,
    /// It is similar to what continues a neighbor's source.
    Similar,
    /// It was found among all sites.
    Global,
}

/// A place to copy from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Where, with the frame turned as the target's neighborhood is to be.
    pub place: Place,
    /// Weighted mean of squared differences.
    pub cost: f32,
    /// Where the match comes from.
    pub origin: Origin,
}

/// A partly known neighborhood, ready to be compared.
#[derive(Debug, Clone)]
pub struct Query<'a> {
    descriptor: &'a Descriptor,
    /// The known offsets and those on the way to them, ascending.
    needed: Vec<u32>,
    /// Over the sum of the known offsets' weights; 0 if nothing is known.
    inverse_total: f32,
}

/// The cost of a place, and how it changes when the place moves by p in its frame, in the scan's unit:
/// approximately cost + 2 gᵀp + pᵀHp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearized {
    /// Weighted mean of the squared differences.
    pub cost: f32,
    /// g: weighted mean of derivative times difference.
    pub gradient: Vector2<f64>,
    /// H: weighted mean of the products of derivatives.
    pub curvature: Matrix2<f64>,
}

impl<'a> Query<'a> {
    /// Of what is known in `descriptor`.
    #[must_use]
    pub fn new(descriptor: &'a Descriptor, stencil: &Stencil) -> Self {
        let mut is_needed = vec![false; stencil.len()];
        let mut total = 0.0;
        for j in descriptor.known.iter() {
            is_needed[j] = true;
            total += stencil.weights()[j];
        }
        for j in (1..stencil.len()).rev().filter(|_| total > 0.0) {
            is_needed[stencil.parents()[j] as usize] |= is_needed[j];
        }
        Self {
            descriptor,
            needed: ((0u32..).zip(is_needed))
                .filter_map(|(j, is_needed)| is_needed.then_some(j))
                .collect(),
            inverse_total: if total > 0.0 { 1.0 / total } else { 0.0 },
        }
    }

    /// Its values and mask.
    #[must_use]
    pub fn descriptor(&self) -> &'a Descriptor {
        self.descriptor
    }

    /// Whether nothing is known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.needed.is_empty()
    }

    /// Weighted mean of the squared differences to the neighborhood of `place`, over the offsets that
    /// the query knows; `None` if one of them or the place itself is not known there, nothing is known in
    /// the query, or the cost is above `budget`.
    ///
    /// It is what [`super::exhaustive`] finds for a candidate read at the same place, but for rounding.
    #[must_use]
    pub fn cost(
        &self,
        walker: &mut Walker,
        view: &View,
        place: &Place,
        budget: f32,
    ) -> Option<f32> {
        let channels = view.channels.count();
        let weights = view.stencil.weights();
        let Descriptor { values, known } = self.descriptor;
        let mut cost = if self.is_empty() { None } else { Some(0.0) };
        walker.visit(view, place, self.needed.iter().copied(), |j, theirs| {
            if j == 0 && theirs.is_none() {
                cost = None;
                return ControlFlow::Break(());
            }
            if !known.get(j) {
                return ControlFlow::Continue(());
            }
            let ours = &values[j * channels..][..channels];
            cost = cost.zip(theirs).and_then(|(cost, theirs)| {
                let pairs = ours.iter().zip(theirs.values());
                let square: f32 = pairs.map(|(a, b)| (a - b) * (a - b)).sum();
                let cost = cost + weights[j] * self.inverse_total * square;
                (cost <= budget).then_some(cost)
            });
            match cost {
                Some(_) => ControlFlow::Continue(()),
                None => ControlFlow::Break(()),
            }
        });
        cost
    }

    /// The cost of `place` and how it changes from there; `None` if it is above `budget` or the place
    /// lacks what the query knows, see [`Self::cost`].
    #[must_use]
    pub fn linearized(
        &self,
        walker: &mut Walker,
        view: &View,
        place: &Place,
        budget: f32,
    ) -> Option<Linearized> {
        let channels = view.channels.count();
        let Descriptor { values, known } = self.descriptor;
        let mut cost = if self.is_empty() { None } else { Some(0f32) };
        // g, and the entries xx, xy and yy of H.
        let (mut gradient, mut curvature) = ([0f32; 2], [0f32; 3]);
        walker.visit(view, place, self.needed.iter().copied(), |j, theirs| {
            if j > 0 && !known.get(j) {
                return ControlFlow::Continue(());
            }
            let Some(theirs) = theirs else {
                cost = None;
                return ControlFlow::Break(());
            };
            if !known.get(j) {
                return ControlFlow::Continue(());
            }
            let weight = view.stencil.weights()[j] * self.inverse_total;
            for channel in 0..channels {
                let difference = theirs.values()[channel] - values[j * channels + channel];
                let [x, y] = theirs.gradient(channel);
                cost = cost.map(|cost| cost + weight * difference * difference);
                for (sum, slope) in gradient.iter_mut().zip([x, y]) {
                    *sum += weight * slope * difference;
                }
                for (sum, square) in curvature.iter_mut().zip([x * x, x * y, y * y]) {
                    *sum += weight * square;
                }
            }
            if cost.is_some_and(|cost| cost <= budget) {
                ControlFlow::Continue(())
            } else {
                cost = None;
                ControlFlow::Break(())
            }
        });
        let [xx, xy, yy] = curvature.map(f64::from);
        Some(Linearized {
            cost: cost?,
            gradient: Vector2::from(gradient.map(f64::from)),
            curvature: Matrix2::new(xx, xy, xy, yy),
        })
    }
}
