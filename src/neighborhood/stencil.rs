//! Where a neighborhood is looked at: fixed offsets in the tangent plane.

use super::{gaussian_weight, window_sigma};

/// Offsets in a tangent frame, centre first, near ones before far ones.
///
/// Every offset but the centre has a *parent*, an earlier offset next to it: whoever walks over a
/// surface goes from parent to child, so that a neighborhood is what can be reached on the surface
/// and never what is merely close in space.
#[derive(Debug, Clone, PartialEq)]
pub struct Stencil {
    offsets: Vec<[f32; 2]>,
    parents: Vec<u32>,
    weights: Vec<f32>,
    spacing: f64,
    /// The stencil is its own image after a turn by 2π over this.
    symmetry: usize,
    /// Place of each offset after one such turn.
    turned: Vec<u32>,
}

impl Stencil {
    /// The points of a square lattice of the given spacing within a disc of `radius` spacings.
    /// Weights fall off as those of a window of that radius do (see [`window_sigma`]).
    #[must_use]
    pub fn disc(radius: usize, spacing: f64) -> Self {
        let reach = lattice_number(radius);
        let lattice = lattice(radius).filter(|[x, y]| x * x + y * y <= reach * reach);
        Self::on_lattice(lattice.collect(), spacing, windowed(radius))
    }

    /// A disc that sees two scales: all points of a square lattice of the given spacing within four fifths
    /// of `radius` spacings, and every other one along both axes out to twice as far. As many offsets as
    /// [`Self::disc`] has, but the outer ones show what the relief does beyond its finest detail.
    /// Each offset counts by the area that it stands for, and less the farther out it is: the Gaussian's
    /// standard deviation is the radius of the dense part.
    #[must_use]
    pub fn two_scales(radius: usize, spacing: f64) -> Self {
        let dense = (4 * radius).div_ceil(5);
        let within = |p: &[i64; 2], radius: usize| {
            let reach = lattice_number(radius);
            length_sq(p) <= reach * reach
        };
        let is_seen = |p: &[i64; 2]| {
            let is_every_other = p.iter().all(|x| x % 2 == 0);
            within(p, dense) || (is_every_other && within(p, 2 * dense))
        };
        let points = lattice(2 * dense).filter(is_seen).collect();
        #[expect(clippy::cast_possible_truncation, reason = "weights are single")]
        let weight = |p: &[i64; 2]| {
            let area = if within(p, dense) { 1.0 } else { 4.0 };
            (area * gaussian_weight(length_sq(p) as f64, dense as f64)) as f32
        };
        Self::on_lattice(points, spacing, weight)
    }

    /// A square of (2·`radius` + 1)² lattice points.
    ///
    /// # Reference
    /// [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001), §3.3: the neighborhood of an image.
    #[must_use]
    pub fn square(radius: usize, spacing: f64) -> Self {
        Self::on_lattice(lattice(radius).collect(), spacing, windowed(radius))
    }

    /// A polar fan: the centre and `rings` rings of `spokes` offsets each, `spacing` apart along a
    /// spoke. A turn by one spoke is a cyclic shift of every ring.
    ///
    /// # Panics
    /// If there are no spokes.
    ///
    /// # Reference
    /// [MeshMatch 2012](crate::bibliography#meshmatch-2012): geodesic fans.
    #[must_use]
    pub fn fan(rings: usize, spokes: usize, spacing: f64) -> Self {
        assert!(spokes > 0, "a fan needs a spoke");
        let angle = |spoke: usize| std::f64::consts::TAU * spoke as f64 / spokes as f64;
        let ring = |ring: usize| {
            (0..spokes).map(move |spoke| {
                let radius = ring as f64;
                [radius * angle(spoke).cos(), radius * angle(spoke).sin()]
            })
        };
        let mut points = vec![[0.0, 0.0]];
        points.extend((1..=rings).flat_map(ring));
        let parents = (0..points.len()).map(|j| j.saturating_sub(spokes));
        let shifted = (0..points.len()).map(|j| match j.checked_sub(1) {
            None => 0,
            Some(rest) => 1 + rest / spokes * spokes + (rest % spokes + 1) % spokes,
        });
        Self {
            parents: parents.map(index).collect(),
            turned: shifted.map(index).collect(),
            symmetry: spokes,
            weights: (points.iter())
                .map(|[x, y]| window_weight(x * x + y * y, rings))
                .collect(),
            offsets: scaled(&points, spacing),
            spacing,
        }
    }

    fn on_lattice(
        mut points: Vec<[i64; 2]>,
        spacing: f64,
        weight: impl Fn(&[i64; 2]) -> f32,
    ) -> Self {
        let angle = |[x, y]: &[i64; 2]| (*y as f64).atan2(*x as f64);
        points.sort_by(|a, b| {
            length_sq(a)
                .cmp(&length_sq(b))
                .then(angle(a).total_cmp(&angle(b)))
        });
        let place = |p: [i64; 2]| points.iter().position(|q| *q == p);
        let parents = points.iter().map(|p| parent(p, &points)).collect();
        let turned = (points.iter())
            .map(|[x, y]| place([-y, *x]).expect("a quarter of a turn maps the lattice to itself"));
        let turned = turned.map(index).collect();
        let weights = points.iter().map(weight).collect();
        let points: Vec<[f64; 2]> = points.iter().map(|p| p.map(|x| x as f64)).collect();
        Self {
            parents,
            turned,
            symmetry: 4,
            weights,
            offsets: scaled(&points, spacing),
            spacing,
        }
    }

    /// Number J of offsets, the centre among them.
    #[must_use]
    pub fn len(&self) -> usize {
        self.offsets.len()
    }

    /// Never: the centre is always there.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.offsets.is_empty()
    }

    /// The offsets along the two axes of the tangent frame, in the scan's unit.
    #[must_use]
    pub fn offsets(&self) -> &[[f32; 2]] {
        &self.offsets
    }

    /// For each offset the earlier one that it is reached from; the centre is its own.
    #[must_use]
    pub fn parents(&self) -> &[u32] {
        &self.parents
    }

    /// Weights, 1 at the centre.
    #[must_use]
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Distance of neighboring offsets, in the scan's unit.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Number of offsets within `radius` spacings; they come first.
    #[must_use]
    pub fn within(&self, radius: usize) -> usize {
        #[expect(clippy::cast_possible_truncation, reason = "offsets are single")]
        let reach = ((radius as f64 + 1e-3) * self.spacing) as f32;
        self.offsets.partition_point(|[x, y]| x.hypot(*y) <= reach)
    }

    /// The number n of turns by 2π/n that map the stencil to itself: 4 for a disc and a square, the
    /// number of spokes for a fan.
    #[must_use]
    pub fn symmetry(&self) -> usize {
        self.symmetry
    }

    /// Where each offset comes to lie after `steps` turns by 2π over [`Self::symmetry`]: what a
    /// neighborhood turned by as much holds at offset j, the neighborhood itself holds at the j-th of
    /// these.
    #[must_use]
    pub fn turned(&self, steps: usize) -> Vec<u32> {
        let mut places: Vec<u32> = (0..self.len()).map(index).collect();
        for _ in 0..steps % self.symmetry {
            for place in &mut places {
                *place = self.turned[*place as usize];
            }
        }
        places
    }
}

/// All points of a square lattice of (2·`radius` + 1)² points.
fn lattice(radius: usize) -> impl Iterator<Item = [i64; 2]> {
    let reach = lattice_number(radius);
    (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |x| [x, y]))
}

fn lattice_number(radius: usize) -> i64 {
    i64::try_from(radius).expect("a window is a few edges wide")
}

fn length_sq([x, y]: &[i64; 2]) -> i64 {
    x * x + y * y
}

/// Where `p` is reached from: the lattice point next to it on the way to the centre or, where the lattice
/// is thinned out, the nearest of those farther in.
fn parent(p: &[i64; 2], points: &[[i64; 2]]) -> u32 {
    let inwards = towards_centre(*p);
    let next = points.iter().position(|q| *q == inwards);
    let nearest = || {
        let distance_sq = |q: &[i64; 2]| length_sq(&[q[0] - p[0], q[1] - p[1]]);
        (points.iter().enumerate())
            .filter(|(_, q)| length_sq(q) < length_sq(p))
            .min_by_key(|(_, q)| distance_sq(q))
            .map_or(0, |(j, _)| j)
    };
    index(next.unwrap_or_else(nearest))
}

/// One less along the longer coordinate, along both on a diagonal.
fn towards_centre([x, y]: [i64; 2]) -> [i64; 2] {
    let along = |own: i64, other: i64| {
        if own.abs() >= other.abs() {
            own - own.signum()
        } else {
            own
        }
    };
    [along(x, y), along(y, x)]
}

/// Gaussian weights of a window of `radius` spacings.
fn windowed(radius: usize) -> impl Fn(&[i64; 2]) -> f32 {
    move |p| window_weight(length_sq(p) as f64, radius)
}

/// The weight at a squared distance, in squared spacings.
fn window_weight(distance_sq: f64, radius: usize) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "weights are single")]
    let weight = gaussian_weight(distance_sq, window_sigma(radius, 1.0)) as f32;
    // No weight vanishes, however wide a square's corners reach.
    weight.max(f32::MIN_POSITIVE)
}

#[expect(clippy::cast_possible_truncation, reason = "offsets are single")]
fn scaled(points: &[[f64; 2]], spacing: f64) -> Vec<[f32; 2]> {
    (points.iter())
        .map(|p| p.map(|x| (x * spacing) as f32))
        .collect()
}

fn index(j: usize) -> u32 {
    u32::try_from(j).expect("a stencil is small")
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn all() -> [Stencil; 4] {
        [
            Stencil::disc(5, 0.3),
            Stencil::two_scales(5, 0.3),
            Stencil::square(3, 0.3),
            Stencil::fan(3, 18, 0.3),
        ]
    }

    #[test]
    fn counts_are_those_of_the_papers() {
        assert_eq!(all().map(|s| s.len()), [81, 85, 49, 55]);
        assert_eq!(Stencil::disc(5, 0.3).within(1), 5);
        assert_eq!(Stencil::disc(5, 0.3).within(5), 81);
        assert_eq!(Stencil::fan(3, 18, 0.3).within(2), 37);
    }

    #[test]
    fn parents_come_first_and_are_next_to_their_children() {
        for stencil in all() {
            for (j, parent) in stencil.parents().iter().enumerate().skip(1) {
                let parent = *parent as usize;
                assert!(parent < j);
                let ([x, y], [u, v]) = (stencil.offsets()[j], stencil.offsets()[parent]);
                let is_thinned = x.hypot(y) > 4.01 * 0.3 && stencil.len() == 85;
                let step = if is_thinned { 2.0 } else { 1.0 };
                assert!((x - u).hypot(y - v) <= step * 0.3 * 1.4143);
                assert!(u.hypot(v) < x.hypot(y));
            }
        }
    }

    #[test]
    fn a_turn_maps_the_stencil_to_itself() {
        for stencil in all() {
            for steps in 0..stencil.symmetry() {
                #[expect(clippy::cast_possible_truncation, reason = "an angle")]
                let angle =
                    (std::f64::consts::TAU * steps as f64 / stencil.symmetry() as f64) as f32;
                for (j, to) in stencil.turned(steps).iter().enumerate() {
                    let [x, y] = stencil.offsets()[j];
                    let [u, v] = stencil.offsets()[*to as usize];
                    assert_relative_eq!(u, angle.cos() * x - angle.sin() * y, epsilon = 1e-6);
                    assert_relative_eq!(v, angle.sin() * x + angle.cos() * y, epsilon = 1e-6);
                }
            }
        }
    }

    #[test]
    fn two_scales_weigh_what_a_dense_disc_weighs() {
        let stencil = Stencil::two_scales(5, 0.3);
        let [mut inner, mut outer] = [0.0; 2];
        for ([x, y], weight) in stencil.offsets().iter().zip(stencil.weights()) {
            let distance = x.hypot(*y) / 0.3;
            assert!(distance <= 8.001);
            *(if distance < 4.2 {
                &mut inner
            } else {
                &mut outer
            }) += weight;
        }
        // The integrals of exp(−r²/2σ²) over the disc of radius σ and the ring from there to 2σ.
        let disc = |radii: f32| 1.0 - (-0.5 * radii * radii).exp();
        let expected = (disc(2.0) - disc(1.0)) / disc(1.0);
        assert!(
            (outer / inner - expected).abs() < 0.15 * expected,
            "{outer} {inner}"
        );
        // However narrow, something lies around the centre.
        assert_eq!(Stencil::two_scales(1, 0.3).len(), 9);
    }

    #[test]
    fn weights_fall_from_the_centre() {
        for stencil in all().into_iter().filter(|stencil| stencil.len() != 85) {
            assert_relative_eq!(stencil.weights()[0], 1.0);
            for j in 1..stencil.len() {
                assert!(stencil.weights()[j] > 0.0);
                assert!(stencil.weights()[j] <= stencil.weights()[j - 1] * (1.0 + 1e-6));
            }
        }
    }
}
