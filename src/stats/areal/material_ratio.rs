//! The material ratio curve: what share of the surface lies above a height.

use super::sum::Sum;

/// Width of the central region of the curve (ISO 21920-2:2021 and ISO 13565-2: 40 %).
const CENTRAL_WIDTH: f64 = 0.4;

/// Material ratio p between peaks and core of the volume parameters (default of ISO 25178-3).
const PEAK_RATIO: f64 = 0.1;

/// Material ratio q between core and pits of the volume parameters (default of ISO 25178-3).
const PIT_RATIO: f64 = 0.8;

/// Material ratios between which Sxp is measured (default of ISO 25178-3).
const EXTREME_PEAK_RATIOS: [f64; 2] = [0.025, 0.5];

/// Height over material ratio (Abbott-Firestone curve), falling from the highest point at 0 to the lowest at
/// 1. Ratios are shares from 0 to 1 here, not percent.
///
/// A height stands at the middle of the area that it weighs, and the curve is linear between heights. It is
/// the curve itself, not a histogram of it.
///
/// # Reference
/// ISO 25178-2:2021, 4.5; for the equivalent straight line its Annex B and ISO 13565-2:1996, 4.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialRatioCurve {
    /// Ratios of the nodes, rising from 0 to 1.
    ratios: Vec<f64>,
    /// Their heights, falling.
    heights: Vec<f64>,
    /// Integral of the curve from 0 to each node.
    integrals: Vec<f64>,
}

/// The core of the curve and what stands out of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Core {
    /// Core height.
    pub sk: f64,
    /// Reduced peak height.
    pub spk: f64,
    /// Reduced pit depth.
    pub svk: f64,
    /// Share of the surface above the core, 0 to 1.
    pub smr1: f64,
    /// Share of the surface above the pits, 0 to 1.
    pub smr2: f64,
}

/// Material and void volumes over the area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volumes {
    /// Material of the peaks.
    pub vmp: f64,
    /// Material of the core.
    pub vmc: f64,
    /// Void of the core.
    pub vvc: f64,
    /// Void of the pits.
    pub vvv: f64,
}

impl MaterialRatioCurve {
    /// The curve of heights with their weights (areas); heights that are not finite or weigh nothing are left
    /// out. `None` if nothing is left.
    #[must_use]
    pub fn new(samples: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let mut samples: Vec<(f64, f64)> = (samples.into_iter())
            .filter(|(height, weight)| height.is_finite() && *weight > 0.0)
            .collect();
        // Equal heights are ordered by weight, so that the order of the samples does not matter at all.
        samples.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1)));
        let area = samples
            .iter()
            .map(|(_, weight)| *weight)
            .collect::<Sum>()
            .value();
        let (highest, lowest) = (samples.first()?.0, samples.last()?.0);
        if !area.is_finite() {
            return None;
        }
        let (mut ratios, mut heights) = (vec![0.0], vec![highest]);
        let mut above = Sum::default();
        for (height, weight) in samples {
            ratios.push(((above.value() + 0.5 * weight) / area).min(1.0));
            heights.push(height);
            above.add(weight);
        }
        ratios.push(1.0);
        heights.push(lowest);
        let mut integrals = vec![0.0];
        let mut integral = Sum::default();
        for k in 1..ratios.len() {
            integral.add(0.5 * (heights[k] + heights[k - 1]) * (ratios[k] - ratios[k - 1]));
            integrals.push(integral.value());
        }
        Some(Self {
            ratios,
            heights,
            integrals,
        })
    }

    /// Inverse material ratio Smc: the height above which this share (0 to 1) of the surface lies.
    ///
    /// # Reference
    /// ISO 25178-2:2021, 4.5.2.
    #[must_use]
    pub fn height_at(&self, ratio: f64) -> f64 {
        let (k, share) = self.place(ratio);
        self.heights[k] + share * (self.heights[k + 1] - self.heights[k])
    }

    /// Areal material ratio Smr: the share (0 to 1) of the surface at this height or above.
    ///
    /// # Reference
    /// ISO 25178-2:2021, 4.5.1.
    #[must_use]
    pub fn ratio_at(&self, height: f64) -> f64 {
        self.first_ratio(height, |node| node >= height)
    }

    /// Share of the surface that is higher than this.
    fn share_above(&self, height: f64) -> f64 {
        self.first_ratio(height, |node| node > height)
    }

    /// Where the curve comes down to a height, behind the nodes of which `is_before` holds.
    fn first_ratio(&self, height: f64, is_before: impl Fn(f64) -> bool) -> f64 {
        let k = self.heights.partition_point(|node| is_before(*node));
        if k == 0 {
            return 0.0;
        }
        if k == self.heights.len() {
            return 1.0;
        }
        let (above, below) = (self.heights[k - 1], self.heights[k]);
        let share = (above - height) / (above - below);
        self.ratios[k - 1] + share * (self.ratios[k] - self.ratios[k - 1])
    }

    /// The piece of the curve that a ratio is in, and how far into it.
    fn place(&self, ratio: f64) -> (usize, f64) {
        let last = self.ratios.len() - 2;
        let after = self.ratios.partition_point(|node| *node <= ratio);
        let k = after.saturating_sub(1).min(last);
        let width = self.ratios[k + 1] - self.ratios[k];
        let share = if width > 0.0 {
            ((ratio - self.ratios[k]) / width).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (k, share)
    }

    /// Integral of the curve from 0 to a ratio.
    fn integral_to(&self, ratio: f64) -> f64 {
        let (k, share) = self.place(ratio);
        let width = share * (self.ratios[k + 1] - self.ratios[k]);
        let middle = self.heights[k] + 0.5 * share * (self.heights[k + 1] - self.heights[k]);
        self.integrals[k] + width * middle
    }

    /// Material over the height at a ratio, over the area.
    fn material(&self, ratio: f64) -> f64 {
        self.integral_to(ratio) - ratio * self.height_at(ratio)
    }

    /// Void below the height at a ratio, over the area.
    fn void(&self, ratio: f64) -> f64 {
        let below = self.integral_to(1.0) - self.integral_to(ratio);
        (1.0 - ratio) * self.height_at(ratio) - below
    }

    /// Material and void volumes, with p = 10 % and q = 80 %.
    ///
    /// # Reference
    /// ISO 25178-2:2021, 4.5.6 and 4.5.7.
    #[must_use]
    pub fn volumes(&self) -> Volumes {
        let vmp = self.material(PEAK_RATIO);
        let vvv = self.void(PIT_RATIO);
        Volumes {
            vmp,
            vmc: self.material(PIT_RATIO) - vmp,
            vvc: self.void(PEAK_RATIO) - vvv,
            vvv,
        }
    }

    /// Extreme peak height: from 2.5 % to 50 %.
    ///
    /// # Reference
    /// ISO 25178-2:2021, 4.5.3, with the ratios of ISO 25178-3.
    #[must_use]
    pub fn sxp(&self) -> f64 {
        let [peak, middle] = EXTREME_PEAK_RATIOS;
        self.height_at(peak) - self.height_at(middle)
    }

    /// Core height, reduced peak height and reduced pit depth by the equivalent straight line: the line of least
    /// squares through that 40 % of the curve whose secant falls least.
    ///
    /// # Reference
    /// ISO 25178-2:2021, 4.5.4 and Annex B; ISO 13565-2:1996, 4.
    #[must_use]
    pub fn core(&self) -> Core {
        let (slope, at_zero) = self.equivalent_line();
        let (top, bottom) = (at_zero, at_zero + slope);
        let smr1 = self.share_above(top);
        let smr2 = self.ratio_at(bottom);
        let peaks = self.integral_to(smr1) - smr1 * top;
        let pits = (1.0 - smr2) * bottom - (self.integral_to(1.0) - self.integral_to(smr2));
        // Where nothing stands out, an area that is not quite zero is rounding.
        let reduced = |area: f64, base: f64| {
            if base > 0.0 {
                (2.0 * area / base).max(0.0)
            } else {
                0.0
            }
        };
        Core {
            sk: top - bottom,
            spk: reduced(peaks, smr1),
            svk: reduced(pits, 1.0 - smr2),
            smr1,
            smr2,
        }
    }

    /// Slope of the equivalent straight line, and its height at 0.
    fn equivalent_line(&self) -> (f64, f64) {
        let start = self.flattest_start();
        let end = start + CENTRAL_WIDTH;
        let middle = 0.5 * (start + end);
        let mean = (self.integral_to(end) - self.integral_to(start)) / CENTRAL_WIDTH;
        // ∫ (t − middle)(c − mean) dt, exactly: both factors are linear in each piece.
        let mut covariance = 0.0;
        let mut from = (start, self.height_at(start));
        let first = self.ratios.partition_point(|node| *node <= start);
        let inside = (self.ratios[first..].iter().copied()).zip(self.heights[first..].iter());
        let inside = inside
            .map(|(ratio, height)| (ratio, *height))
            .take_while(|(ratio, _)| *ratio < end);
        for to in inside.chain([(end, self.height_at(end))]) {
            let (t0, t1) = (from.0 - middle, to.0 - middle);
            let (c0, c1) = (from.1 - mean, to.1 - mean);
            let products = 2.0 * (t0 * c0 + t1 * c1) + t0 * c1 + t1 * c0;
            covariance += (to.0 - from.0) * products / 6.0;
            from = to;
        }
        let slope = (covariance / (CENTRAL_WIDTH.powi(3) / 12.0)).min(0.0);
        (slope, mean - slope * middle)
    }

    /// Where the secant over 40 % falls least; the first such place. The fall is linear between places at
    /// which one end of the secant is on a node.
    fn flattest_start(&self) -> f64 {
        let starts = (self.ratios.iter().copied()).filter(|start| *start <= 1.0 - CENTRAL_WIDTH);
        let ends = (self.ratios.iter().copied())
            .filter(|end| *end >= CENTRAL_WIDTH)
            .map(|end| end - CENTRAL_WIDTH);
        let falls = starts.chain(ends).map(|start| {
            let fall = self.height_at(start) - self.height_at(start + CENTRAL_WIDTH);
            (fall, start)
        });
        let flattest = falls.min_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.total_cmp(&b.1)));
        flattest.map_or(0.0, |(_, start)| start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Heights at n quantiles of a distribution, all of one weight.
    fn curve(n: u32, quantile: impl Fn(f64) -> f64) -> MaterialRatioCurve {
        let heights = (0..n).map(|i| quantile((f64::from(i) + 0.5) / f64::from(n)));
        MaterialRatioCurve::new(heights.map(|h| (h, 1.0))).unwrap()
    }

    #[test]
    fn a_sawtooth_is_all_core() {
        let curve = curve(10_000, |p| 3.0 * p);
        let core = curve.core();
        assert_relative_eq!(core.sk, 3.0, epsilon = 1e-6);
        assert_relative_eq!(core.smr1, 0.0, epsilon = 1e-4);
        assert_relative_eq!(core.smr2, 1.0, epsilon = 1e-4);
        assert!(core.spk < 3e-3 && core.svk < 3e-3, "{core:?}");
        // A triangle of height h over a ratio p has the area h p / 2.
        let volumes = curve.volumes();
        assert_relative_eq!(volumes.vmp, 3.0 * 0.005, epsilon = 1e-7);
        assert_relative_eq!(volumes.vmc, 3.0 * (0.32 - 0.005), epsilon = 1e-7);
        assert_relative_eq!(volumes.vvv, 3.0 * 0.02, epsilon = 1e-7);
        assert_relative_eq!(volumes.vvc, 3.0 * (0.405 - 0.02), epsilon = 1e-7);
        assert_relative_eq!(curve.sxp(), 3.0 * 0.475, epsilon = 1e-9);
    }

    #[test]
    fn normally_distributed_heights_have_the_known_values() {
        // Every pair of quantiles through the Box-Muller transform: normal but for the steps.
        let quantile = |i: u32| (f64::from(i) + 0.5) / 400.0;
        let normal = (0..400 * 400).map(|k| {
            let (u, v) = (quantile(k / 400), quantile(k % 400));
            (
                (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos(),
                1.0,
            )
        });
        let curve = MaterialRatioCurve::new(normal).unwrap();
        // By numerical integration of the normal distribution.
        let core = curve.core();
        assert_relative_eq!(core.sk, 2.573_956, epsilon = 5e-3);
        assert_relative_eq!(core.smr1, 0.099_051, epsilon = 1e-3);
        assert_relative_eq!(core.smr2, 0.900_949, epsilon = 1e-3);
        assert_relative_eq!(core.spk, 0.945_031, epsilon = 1e-2);
        assert_relative_eq!(core.svk, 0.945_031, epsilon = 1e-2);
        let volumes = curve.volumes();
        assert_relative_eq!(volumes.vmp, 0.047_343, epsilon = 5e-4);
        assert_relative_eq!(volumes.vmc, 0.905_916, epsilon = 2e-3);
        assert_relative_eq!(volumes.vvc, 1.217_257, epsilon = 2e-3);
        assert_relative_eq!(volumes.vvv, 0.111_638, epsilon = 5e-4);
        assert_relative_eq!(curve.sxp(), 1.959_964, epsilon = 5e-3);
    }

    #[test]
    fn a_plateau_with_pits_has_the_values_of_its_line() {
        // The upper 80 % fall by 0.8, the pits from there by 4.
        let curve = curve(100_000, |p| if p < 0.2 { -4.8 + 20.0 * p } else { p - 1.0 });
        let core = curve.core();
        assert_relative_eq!(core.sk, 1.0, epsilon = 1e-6);
        // The pits cross the bottom of the core, −1, at p = 0.19.
        assert_relative_eq!(core.smr2, 0.81, epsilon = 1e-4);
        assert_relative_eq!(core.svk, 3.8, epsilon = 1e-3);
        assert_relative_eq!(core.smr1, 0.0, epsilon = 1e-4);
    }

    #[test]
    fn heights_and_ratios_are_inverse_to_each_other() {
        let curve = curve(500, |p| p.powi(3));
        for ratio in [0.01, 0.3, 0.5, 0.77, 0.99] {
            assert_relative_eq!(
                curve.ratio_at(curve.height_at(ratio)),
                ratio,
                epsilon = 1e-12
            );
        }
        assert_relative_eq!(curve.ratio_at(2.0), 0.0);
        assert_relative_eq!(curve.ratio_at(-1.0), 1.0);
        assert_relative_eq!(curve.height_at(0.5), 0.125, epsilon = 1e-5);
    }

    #[test]
    fn weights_and_order_do_as_repeated_heights() {
        let weighted: Vec<_> = (0..2000)
            .map(|i| (f64::from(i * i), f64::from(1 + i % 3)))
            .collect();
        let mut repeated: Vec<_> = (weighted.iter())
            .flat_map(|(h, w)| {
                (0..3)
                    .filter(move |k| f64::from(*k) < *w)
                    .map(move |_| (*h, 1.0))
            })
            .collect();
        repeated.reverse();
        let weighted = MaterialRatioCurve::new(weighted).unwrap();
        let repeated = MaterialRatioCurve::new(repeated).unwrap();
        let (a, b) = (weighted.core(), repeated.core());
        assert_relative_eq!(a.sk, b.sk, max_relative = 5e-3);
        assert_relative_eq!(a.spk, b.spk, max_relative = 5e-3);
        assert_relative_eq!(a.smr1, b.smr1, max_relative = 1e-2);
        let (a, b) = (weighted.volumes(), repeated.volumes());
        assert_relative_eq!(a.vmc, b.vmc, max_relative = 1e-3);
        assert_relative_eq!(a.vvv, b.vvv, max_relative = 1e-2);
    }

    #[test]
    fn a_flat_surface_is_a_core_of_no_height() {
        let core = curve(9, |_| 0.7).core();
        assert!(core.sk.abs() < 1e-15 && core.spk.abs() < 1e-15 && core.svk.abs() < 1e-15);
        let one = MaterialRatioCurve::new([(2.0, 0.5)]).unwrap();
        assert_relative_eq!(one.height_at(0.3), 2.0);
        assert_eq!(MaterialRatioCurve::new([(f64::NAN, 1.0)]), None);
    }
}
