//! The only door to randomness: a Mersenne twister, one stream per (seed, stage, item).
//!
//! Floats and indices are made here from the generator's own 32-bit words, so that no update of a
//! dependency changes a result.

use rand_mt::Mt;

/// A stage that draws random numbers. Each has streams of its own, so that a stage which draws one
/// number more does not change what the next one does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Stage {
    /// Synthetic scans.
    Synth = 1,
    /// The pick among the best matches, and the order of equally constrained front vertices.
    Completion = 2,
    /// Random subsets for robust starting values of a fit.
    Fit = 3,
    /// Picks and random places in the search for one vertex's match.
    Matching = 4,
    /// Places of the true pieces that a figure is calibrated with.
    Likeness = 5,
    /// Places of the holes that are cut for an evaluation.
    Evaluation = 6,
    /// Places at which relief is read to choose parameters.
    Suiting = 7,
    /// The order in which a mesh is textured, and the values that it begins with.
    Texture = 8,
    /// Places that a transfer between meshes tries.
    Transfer = 9,
}

/// A stream of random numbers.
///
/// The state is 2.5 kB and seeding it is not free: make one per stage (or per independent item),
/// never one per draw.
#[derive(Debug, Clone)]
pub struct Rng {
    generator: Mt,
}

impl Rng {
    /// The stream of one stage: equal arguments give equal numbers.
    #[must_use]
    pub fn new(seed: u32, stage: Stage, item: u32) -> Self {
        Self {
            generator: Mt::new_with_key([seed, stage as u32, item]),
        }
    }

    /// The stream of one of many items within an item of a stage, such as one target of a patch.
    #[must_use]
    pub fn of_part(seed: u32, stage: Stage, item: u32, part: u32) -> Self {
        Self {
            generator: Mt::new_with_key([seed, stage as u32, item, part]),
        }
    }

    /// Uniform in [0, 1), with all 53 bits of a double (Matsumoto & Nishimura's `genrand_res53`).
    pub fn uniform(&mut self) -> f64 {
        let high = f64::from(self.generator.next_u32() >> 5);
        let low = f64::from(self.generator.next_u32() >> 6);
        (high * 67_108_864.0 + low) / 9_007_199_254_740_992.0
    }

    /// The generator's next 32 bits.
    pub fn word(&mut self) -> u32 {
        self.generator.next_u32()
    }

    /// Uniform index below `len`, without modulo bias (Lemire's multiplication with rejection).
    ///
    /// # Panics
    /// If `len` is zero or does not fit in 32 bits.
    pub fn index(&mut self, len: usize) -> usize {
        let len = u32::try_from(len).expect("no list here has more than 2^32 items");
        assert!(len > 0, "cannot pick from an empty list");
        let threshold = len.wrapping_neg() % len;
        loop {
            let product = u64::from(self.generator.next_u32()) * u64::from(len);
            let (high, low) = ((product >> 32) as usize, product & 0xffff_ffff);
            if low >= u64::from(threshold) {
                return high;
            }
        }
    }

    /// One of the items, each as likely as another; `None` of none.
    pub fn pick<T: Copy>(&mut self, items: &[T]) -> Option<T> {
        (!items.is_empty()).then(|| items[self.index(items.len())])
    }

    /// Standard normal deviate (Box–Muller; the second of each pair is thrown away).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_key_gives_the_same_stream_and_any_other_another() {
        let draw = |seed, stage, item| {
            let mut rng = Rng::new(seed, stage, item);
            (0..8).map(|_| rng.uniform()).collect::<Vec<_>>()
        };
        assert_eq!(draw(1, Stage::Synth, 0), draw(1, Stage::Synth, 0));
        assert_ne!(draw(1, Stage::Synth, 0), draw(2, Stage::Synth, 0));
        assert_ne!(draw(1, Stage::Synth, 0), draw(1, Stage::Completion, 0));
        assert_ne!(draw(1, Stage::Synth, 0), draw(1, Stage::Synth, 1));
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut rng = Rng::new(5, Stage::Synth, 0);
        let n = 100_000;
        let (mut mean, mut variance, mut uniform) = (0.0, 0.0, 0.0);
        let mut counts = [0usize; 7];
        for _ in 0..n {
            let x = rng.normal();
            mean += x;
            variance += x * x;
            uniform += rng.uniform();
            counts[rng.index(7)] += 1;
        }
        let n = f64::from(n);
        // Bounds are five standard errors.
        assert!((mean / n).abs() < 5.0 / n.sqrt());
        assert!((variance / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
        assert!((uniform / n - 0.5).abs() < 5.0 / (12.0 * n).sqrt());
        for count in counts {
            assert!((count as f64 - n / 7.0).abs() < 5.0 * (n * 6.0 / 49.0).sqrt());
        }
    }
}
