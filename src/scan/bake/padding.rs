//! Pixels around charts.

use rayon::prelude::*;

/// Rings of pixels around the filled ones that take over their colors: as many as anisotropic filters
/// reach beyond the border of a chart, and more.
const RINGS: usize = 4;

/// Color where there is none at all.
const MID_GREY: [f32; 3] = [0.5; 3];

/// Fills all pixels that are not filled yet; the image repeats.
pub(super) fn pad(colors: &mut Vec<[f32; 3]>, filled: &mut Vec<bool>, columns: usize) {
    for _ in 0..RINGS {
        if filled.iter().all(|filled| *filled) {
            return;
        }
        (*colors, *filled) = dilated(colors, filled, columns);
    }
    fill_by_means(colors, filled, columns);
}

/// One ring more: the mean of those of the eight neighbors that are filled.
fn dilated(colors: &[[f32; 3]], filled: &[bool], columns: usize) -> (Vec<[f32; 3]>, Vec<bool>) {
    let rows = colors.len() / columns;
    let pixel = |at: usize| {
        if filled[at] {
            return (colors[at], true);
        }
        let (row, column) = (at / columns, at % columns);
        let around =
            |place: usize, size: usize| [(place + size - 1) % size, place, (place + 1) % size];
        let mut sum = Mean::default();
        for row in around(row, rows) {
            for column in around(column, columns) {
                let neighbor = row * columns + column;
                if filled[neighbor] {
                    sum.add(colors[neighbor]);
                }
            }
        }
        sum.get().map_or((colors[at], false), |mean| (mean, true))
    };
    (0..colors.len()).into_par_iter().map(pixel).unzip()
}

/// Gives pixels the mean of the filled ones in the smallest square of the pyramid that has any: the first
/// half of the push-pull algorithm (Gortler, Grzeszczuk, Szeliski & Cohen, *The Lumigraph*, 1996, §3.4), whose
/// squares are those of mipmaps.
fn fill_by_means(colors: &mut [[f32; 3]], filled: &[bool], columns: usize) {
    if filled.iter().all(|filled| *filled) {
        return;
    }
    let rows = colors.len() / columns;
    if columns == 1 && rows == 1 {
        colors.fill(MID_GREY);
        return;
    }
    let (half_columns, half_rows) = (columns.div_ceil(2), rows.div_ceil(2));
    let mean = |at: usize| {
        let (row, column) = (2 * (at / half_columns), 2 * (at % half_columns));
        let mut sum = Mean::default();
        for row in row..(row + 2).min(rows) {
            for column in column..(column + 2).min(columns) {
                let pixel = row * columns + column;
                if filled[pixel] {
                    sum.add(colors[pixel]);
                }
            }
        }
        sum.get().map_or(([0.0; 3], false), |mean| (mean, true))
    };
    let (mut coarse, found): (Vec<[f32; 3]>, Vec<bool>) = (0..half_columns * half_rows)
        .into_par_iter()
        .map(mean)
        .unzip();
    fill_by_means(&mut coarse, &found, half_columns);
    colors.par_iter_mut().enumerate().for_each(|(at, color)| {
        if !filled[at] {
            let (row, column) = (at / columns / 2, at % columns / 2);
            *color = coarse[row * half_columns + column];
        }
    });
}

/// The mean of a few colors.
#[derive(Default)]
struct Mean {
    sum: [f32; 3],
    count: f32,
}

impl Mean {
    fn add(&mut self, color: [f32; 3]) {
        self.sum = [0, 1, 2].map(|k| self.sum[k] + color[k]);
        self.count += 1.0;
    }

    fn get(&self) -> Option<[f32; 3]> {
        (self.count > 0.0).then(|| self.sum.map(|s| s / self.count))
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "the values are exact in binary")]
mod tests {
    use super::*;

    #[test]
    fn colors_spread_around_the_borders_and_to_everywhere() {
        let (columns, rows) = (37, 21);
        let mut colors = vec![[0.0; 3]; columns * rows];
        let mut filled = vec![false; columns * rows];
        colors[0] = [0.25, 0.5, 1.0];
        filled[0] = true;
        let (ring, is_filled) = dilated(&colors, &filled, columns);
        assert_eq!(is_filled.iter().filter(|f| **f).count(), 9);
        assert_eq!(ring[columns * rows - 1], [0.25, 0.5, 1.0]);
        pad(&mut colors, &mut filled, columns);
        assert!(colors.iter().all(|c| *c == [0.25, 0.5, 1.0]));
    }

    #[test]
    fn what_is_far_from_everything_is_the_mean() {
        let size = 64;
        let mut colors = vec![[0.0; 3]; size * size];
        let mut filled = vec![false; size * size];
        for (at, value) in [(0, 1.0), (1, 0.0)] {
            colors[at] = [value; 3];
            filled[at] = true;
        }
        fill_by_means(&mut colors, &filled, size);
        assert_eq!((colors[0], colors[1]), ([1.0; 3], [0.0; 3]));
        assert_eq!(colors[size * size - 1], [0.5; 3]);
    }

    #[test]
    fn an_image_of_nothing_is_grey() {
        let (mut colors, mut filled) = (vec![[0.0; 3]; 15], vec![false; 15]);
        pad(&mut colors, &mut filled, 5);
        assert!(colors.iter().all(|c| *c == MID_GREY));
    }
}
