//! Sums that keep their digits.

/// A sum whose rounding errors are carried along (Neumaier's variant of Kahan's summation): millions of terms cost
/// no digits.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sum {
    sum: f64,
    carry: f64,
}

impl Sum {
    pub(super) fn add(&mut self, value: f64) {
        let sum = self.sum + value;
        self.carry += if self.sum.abs() >= value.abs() {
            (self.sum - sum) + value
        } else {
            (value - sum) + self.sum
        };
        self.sum = sum;
    }

    pub(super) fn value(self) -> f64 {
        self.sum + self.carry
    }
}

impl FromIterator<f64> for Sum {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut sum = Self::default();
        for value in values {
            sum.add(value);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_terms_are_not_lost_in_a_large_sum() {
        let terms = [1e16, 1.0, 1.0, -1e16, 0.5];
        let sum: Sum = terms.into_iter().collect();
        assert!((sum.value() - 2.5).abs() < 1e-15);
    }
}
