//! A neighborhood as numbers: what a stencil's offsets hold, and which of them are known.

/// Bits in a word of a mask.
const WORD: usize = u64::BITS as usize;

/// Which offsets of a stencil are known, a bit each.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Mask {
    words: Vec<u64>,
}

impl Mask {
    /// Of `len` offsets, none known.
    #[must_use]
    pub fn new(len: usize) -> Self {
        Self {
            words: vec![0; Self::words_for(len)],
        }
    }

    /// Number of words that hold the bits of `len` offsets.
    #[must_use]
    pub fn words_for(len: usize) -> usize {
        len.div_ceil(WORD)
    }

    /// Marks offset `j` as known.
    #[inline]
    pub fn set(&mut self, j: usize) {
        self.words[j / WORD] |= 1 << (j % WORD);
    }

    /// Whether offset `j` is known.
    #[must_use]
    #[inline]
    pub fn get(&self, j: usize) -> bool {
        self.words[j / WORD] >> (j % WORD) & 1 == 1
    }

    /// Marks all as unknown.
    pub fn clear(&mut self) {
        self.words.fill(0);
    }

    /// Number of known offsets.
    #[must_use]
    pub fn count(&self) -> usize {
        (self.words.iter().map(|word| word.count_ones() as usize)).sum()
    }

    /// The known offsets, ascending.
    pub fn iter(&self) -> impl Iterator<Item = usize> {
        (self.words.iter().enumerate()).flat_map(|(i, word)| {
            let mut rest = *word;
            std::iter::from_fn(move || {
                let bit = rest.trailing_zeros() as usize;
                rest &= rest.checked_sub(1)?;
                Some(i * WORD + bit)
            })
        })
    }

    /// The bits, offset j at bit j mod 64 of word j / 64.
    #[must_use]
    pub fn words(&self) -> &[u64] {
        &self.words
    }
}

/// A neighborhood as values on a stencil of J offsets, C channels each.
///
/// Values carry the weight of their channel already (they are scaled by its root), so that a plain
/// sum of squared differences over the channels is what two neighborhoods differ by at an offset.
/// The values of an unknown offset are 0, never NaN.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Descriptor {
    /// J·C values, the C channels of an offset next to each other.
    pub values: Vec<f32>,
    /// Which of the J offsets are known.
    pub known: Mask,
}

impl Descriptor {
    /// Of a stencil of `offsets` with `channels` values each, nothing known.
    #[must_use]
    pub fn new(offsets: usize, channels: usize) -> Self {
        Self {
            values: vec![0.0; offsets * channels],
            known: Mask::new(offsets),
        }
    }

    /// Forgets all values.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
        self.known.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_come_back_in_order() {
        let mut mask = Mask::new(200);
        let bits = [0, 3, 63, 64, 127, 128, 199];
        for j in bits {
            mask.set(j);
        }
        assert_eq!(mask.iter().collect::<Vec<_>>(), bits);
        assert_eq!(mask.count(), bits.len());
        assert!(mask.get(127) && !mask.get(126));
        mask.clear();
        assert_eq!(mask.count(), 0);
    }
}
