//! An order along which what is close on the list is close in space, and what is at the same place.

use nalgebra::Point3;
use rayon::prelude::*;

/// Bits per axis of a place on the curve.
const BITS: u32 = 10;

/// The given points' indices along a Z-order curve; equal places in the order of their indices.
///
/// # Reference
/// G. M. Morton: *A computer oriented geodetic data base.* IBM, 1966.
#[must_use]
pub fn spatial_order(points: &[Point3<f64>], mut indices: Vec<u32>) -> Vec<u32> {
    let low = (indices.iter()).fold(Point3::from([f64::INFINITY; 3]), |low, v| {
        low.inf(&points[*v as usize])
    });
    let size = (indices.iter())
        .map(|v| (points[*v as usize] - low).amax())
        .fold(f64::MIN_POSITIVE, f64::max);
    let cells = f64::from((1u32 << BITS) - 1);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to 1023"
    )]
    let place = |v: u32| {
        let cell = (points[v as usize] - low) * (cells / size);
        (0..BITS).fold(0u64, |code, bit| {
            let bits = [cell.x, cell.y, cell.z].map(|x| (x as u64 >> (BITS - 1 - bit)) & 1);
            (code << 3) | (bits[0] << 2) | (bits[1] << 1) | bits[2]
        })
    };
    indices.sort_by_cached_key(|v| (place(*v), *v));
    indices
}

/// For each point the first one at the same place, bit by bit; both zeros are one place.
pub(crate) fn first_at_place(points: &[Point3<f64>]) -> Vec<u32> {
    // Adding 0 makes -0 the same as 0.
    let bits = |p: &Point3<f64>| [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits());
    let mut places: Vec<([u64; 3], u32)> = points.iter().map(bits).zip(0u32..).collect();
    places.par_sort_unstable();
    let mut first = vec![0; points.len()];
    for same in places.chunk_by(|a, b| a.0 == b.0) {
        for (_, point) in same {
            first[*point as usize] = same[0].1;
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn along_the_curve_steps_are_short() {
        let points: Vec<Point3<f64>> = (0..1024)
            .map(|i| Point3::new(f64::from(i * 37 % 32), f64::from(i * 37 / 32 % 32), 5.0))
            .collect();
        let order = spatial_order(&points, (0..1024).collect());
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..1024).collect::<Vec<_>>());
        let length: f64 = (order.windows(2))
            .map(|w| (points[w[0] as usize] - points[w[1] as usize]).norm())
            .sum();
        assert!(length < 2.0 * 1024.0);
    }
}
