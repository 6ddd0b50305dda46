//! LZF, the compression of binary PCD files.
//!
//! Reference: Marc Lehmann's `LibLZF`, `lzf_d.c`: a control byte below 32 is followed by so many bytes
//! plus one to be copied; otherwise its upper three bits (7: and the next byte) are the length less
//! two, and its lower five bits and the next byte the distance back less one, of bytes to repeat.

/// Output bytes that one byte of input makes at most: 264 from three.
const LARGEST_RATIO: usize = 88;

/// The `length` bytes that were compressed; `None` if the input does not make exactly these.
pub(super) fn decompress(input: &[u8], length: usize) -> Option<Vec<u8>> {
    // A length that cannot be true is refused before memory is taken for it.
    if length > input.len().saturating_mul(LARGEST_RATIO) {
        return None;
    }
    let mut out = Vec::with_capacity(length);
    let mut rest = input;
    while let Some(control) = take(&mut rest) {
        if control < 32 {
            let (literal, behind) = rest.split_at_checked(control + 1)?;
            out.extend_from_slice(literal);
            rest = behind;
        } else {
            let mut count = (control >> 5) + 2;
            if control >> 5 == 7 {
                count += take(&mut rest)?;
            }
            let back = ((control & 31) << 8 | take(&mut rest)?) + 1;
            let from = out.len().checked_sub(back)?;
            // What is repeated may overlap with what is written.
            for at in from..from + count {
                out.push(out[at]);
            }
        }
        if out.len() > length {
            return None;
        }
    }
    (out.len() == length).then_some(out)
}

fn take(rest: &mut &[u8]) -> Option<usize> {
    let (first, behind) = rest.split_first()?;
    *rest = behind;
    Some(usize::from(*first))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_and_repetitions_come_back() {
        // As LibLZF compresses 20 times `a`: a literal `a`, then 19 more from one byte back.
        assert_eq!(
            decompress(&[0, b'a', 7 << 5, 10, 0], 20),
            Some(vec![b'a'; 20])
        );
        // `abcabc`: a literal of three, and three from three back.
        assert_eq!(
            decompress(&[2, b'a', b'b', b'c', 1 << 5, 2], 6).as_deref(),
            Some(&b"abcabc"[..])
        );
        assert_eq!(decompress(&[], 0), Some(vec![]));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        for (input, length) in [
            (&[0][..], 1),
            (&[2, 1, 1], 3),
            (&[0, 1], 2),
            (&[1, 1, 1], 1),
            (&[0, 1, 1 << 5, 1], 4),
            (&[0, 1, 7 << 5], 100),
            (&[0, 1, 1 << 5], 4),
            (&[0, 1], usize::MAX),
        ] {
            assert_eq!(decompress(input, length), None, "{input:?}");
        }
    }
}
