//! The measures that synthesized textures are judged by.

#[path = "bench/texture_measures.rs"]
mod texture_measures;

use approx::assert_relative_eq;
use relievo::rng::{Rng, Stage};
use texture_measures::{
    Copies, Grid, between_halves, coarse_sliced_wasserstein, copies, gradient_distance,
    least_histogram_correlation, sliced_wasserstein, spectrum_distance, wasserstein,
};

type Measure = fn(&Grid, &Grid) -> Option<f64>;

/// Those that are 0 for equal images.
const DISTANCES: [Measure; 4] = [
    sliced_wasserstein,
    coarse_sliced_wasserstein,
    spectrum_distance,
    gradient_distance,
];

/// Independent colors about the middle, none of them beyond 0 and 1.
fn noise(width: usize, height: usize, item: u32) -> Grid {
    let mut rng = Rng::new(7, Stage::Synth, item);
    #[expect(clippy::cast_possible_truncation, reason = "colors are single")]
    let mut value = || (0.2 + 0.6 * rng.uniform()) as f32;
    let colors = (0..width * height).map(|_| [(); 3].map(|()| value()));
    Grid::new(width, height, colors.collect())
}

/// Bricks with noise.
fn bricks(width: usize, height: usize) -> Grid {
    let mut grid = noise(width, height, 1);
    for (i, color) in grid.colors.iter_mut().enumerate() {
        let (x, y) = (i % width, i / width);
        let is_joint = y % 8 == 0 || (x + y / 8 % 2 * 6) % 12 == 0;
        let color_of_kind = if is_joint { 0.9 } else { 0.3 };
        *color = color.map(|value| 0.8 * color_of_kind + 0.2 * value);
    }
    grid
}

/// Binomial blur, some times; the border is repeated.
fn blurred(grid: &Grid, times: usize) -> Grid {
    let mut grid = grid.clone();
    let (width, height) = (grid.width, grid.height);
    for step in [1, width].repeat(times) {
        let colors = &grid.colors;
        let neighbors = |i: usize| {
            let (place, last) = match step {
                1 => (i % width, width - 1),
                _ => (i / width, height - 1),
            };
            let before = if place > 0 { i - step } else { i };
            let after = if place < last { i + step } else { i };
            [colors[before], colors[i], colors[after]]
        };
        let blurred = (0..colors.len()).map(|i| {
            let [a, b, c] = neighbors(i);
            [0, 1, 2].map(|k| 0.25 * a[k] + 0.5 * b[k] + 0.25 * c[k])
        });
        grid.colors = blurred.collect();
    }
    grid
}

/// With its pixels at other places.
fn shuffled(grid: &Grid) -> Grid {
    let mut grid = grid.clone();
    let mut rng = Rng::new(8, Stage::Synth, 0);
    for i in (1..grid.colors.len()).rev() {
        grid.colors.swap(i, rng.index(i + 1));
    }
    grid
}

fn ascending(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

#[test]
fn an_image_is_at_no_distance_from_itself() {
    let grid = bricks(70, 50);
    for measure in DISTANCES {
        assert_eq!(measure(&grid, &grid), Some(0.0));
    }
    assert_relative_eq!(least_histogram_correlation(&grid, &grid).unwrap(), 1.0);
    // More patches than are taken.
    let large = bricks(150, 150);
    assert_eq!(sliced_wasserstein(&large, &large), Some(0.0));
}

#[test]
fn shuffled_pixels_keep_the_histogram_and_nothing_else() {
    let grid = bricks(72, 64);
    let shuffled = shuffled(&grid);
    assert_relative_eq!(least_histogram_correlation(&grid, &shuffled).unwrap(), 1.0);
    for measure in DISTANCES {
        let floor = between_halves(&grid, measure).unwrap();
        let distance = measure(&grid, &shuffled).unwrap();
        assert!(distance > 3.0 * floor, "{distance} against {floor}");
    }
}

#[test]
fn every_blur_adds_to_the_distances() {
    let grid = bricks(72, 64);
    for measure in DISTANCES {
        let distances = [0, 1, 2, 4, 8].map(|times| measure(&grid, &blurred(&grid, times)));
        let distances = distances.map(Option::unwrap);
        assert!(distances.is_sorted_by(|a, b| a < b), "{distances:?}");
    }
}

#[test]
fn another_piece_of_the_same_texture_is_nearer_than_another_texture() {
    let grid = noise(64, 64, 2);
    for measure in DISTANCES {
        let same = measure(&grid, &noise(64, 64, 3)).unwrap();
        let other = measure(&grid, &bricks(64, 64)).unwrap();
        assert!(same < 0.5 * other, "{same} against {other}");
    }
}

#[test]
fn shifted_values_are_at_the_distance_of_the_shift() {
    let mut rng = Rng::new(9, Stage::Synth, 0);
    let values = ascending((0..1000).map(|_| rng.normal()).collect());
    let shifted: Vec<f64> = values.iter().map(|value| value - 2.5).collect();
    assert_relative_eq!(wasserstein(&values, &shifted), 2.5, max_relative = 1e-12);
    // Uniform on [0, 1) and on [0, 2): the quantiles differ by 1/2 on average.
    let uniform = |n: u32, length: f64| -> Vec<f64> {
        (0..n)
            .map(|i| length * (f64::from(i) + 0.5) / f64::from(n))
            .collect()
    };
    let distance = wasserstein(&uniform(3000, 1.0), &uniform(1700, 2.0));
    assert_relative_eq!(distance, 0.5, max_relative = 1e-3);
}

#[test]
fn lists_of_unequal_counts_match_repeated_ones_of_equal_counts() {
    let mut rng = Rng::new(10, Stage::Synth, 0);
    for (n, m) in [(1, 1), (1, 5), (4, 6), (7, 3), (10, 9)] {
        let mut list = |count: usize| ascending((0..count).map(|_| rng.uniform()).collect());
        let (first, second) = (list(n), list(m));
        let repeated = |list: &[f64], times: usize| -> Vec<f64> {
            list.iter().flat_map(|value| vec![*value; times]).collect()
        };
        let pairs = (repeated(&first, m).into_iter()).zip(repeated(&second, n));
        let mean = pairs.map(|(a, b)| (a - b).abs()).sum::<f64>() / (n * m) as f64;
        assert_relative_eq!(wasserstein(&first, &second), mean, max_relative = 1e-12);
        assert_relative_eq!(wasserstein(&second, &first), mean, max_relative = 1e-12);
    }
}

#[test]
fn plain_greys_differ_by_the_mean_sum_of_a_direction() {
    let grey = |value| Grid::new(20, 10, vec![[value; 3]; 200]);
    let distance = sliced_wasserstein(&grey(0.25), &grey(0.75)).unwrap();
    // The sum of a unit vector's values is nearly normal: its mean magnitude is √(2/π), with a standard deviation
    // of √(1 − 2/π) over 128 directions; four standard errors.
    let expected = 0.5 * (2.0 / std::f64::consts::PI).sqrt();
    let error = 0.5 * ((1.0 - 2.0 / std::f64::consts::PI) / 128.0).sqrt();
    assert!((distance - expected).abs() < 4.0 * error, "{distance}");
}

#[test]
fn doubled_contrast_has_four_times_the_power_of_all_waves() {
    let grid = noise(80, 64, 4);
    let mut halved = grid.clone();
    for color in &mut halved.colors {
        *color = color.map(|value| 0.25 + 0.5 * value);
    }
    let distance = spectrum_distance(&halved, &grid).unwrap();
    assert_relative_eq!(distance, 4f64.log10(), max_relative = 1e-5);
    let gradients = gradient_distance(&grid, &halved).unwrap();
    assert_relative_eq!(gradients, 0.5, max_relative = 1e-5);
}

#[test]
fn power_below_that_of_rounding_is_none() {
    let plain = |value| Grid::new(32, 32, vec![[value; 3]; 1024]);
    assert_eq!(spectrum_distance(&plain(0.2), &plain(0.7)), Some(0.0));
    let mut rounded = plain(0.2);
    rounded.colors[100] = [0.2 + 0.5 / 255.0; 3];
    assert_eq!(spectrum_distance(&plain(0.2), &rounded), Some(0.0));
    assert_eq!(gradient_distance(&plain(0.2), &rounded), None);
}

#[test]
fn pixels_outside_the_mask_do_not_matter() {
    let grid = bricks(90, 80);
    let mut masked = grid.clone();
    masked.mask = Some((0..90 * 80).map(|pixel| pixel % 90 < 70).collect());
    let mut damaged = masked.clone();
    for (pixel, color) in damaged.colors.iter_mut().enumerate() {
        if pixel % 90 >= 70 {
            *color = [1.0, 0.0, 0.0];
        }
    }
    let cut = grid.part([0, 0], 70, 80);
    for measure in DISTANCES {
        assert_eq!(measure(&masked, &damaged), Some(0.0));
        assert_eq!(measure(&grid, &damaged), measure(&grid, &masked));
    }
    // Which patches there are is the same; which squares there are is not, nor must it be.
    assert_eq!(sliced_wasserstein(&cut, &damaged), Some(0.0));
    assert_eq!(gradient_distance(&cut, &damaged), Some(0.0));
    assert_eq!(least_histogram_correlation(&cut, &damaged), Some(1.0));
}

#[test]
fn coarse_patches_are_those_of_the_means_and_tell_misplaced_pieces() {
    // Of 28 by 28 pixels there is one coarse patch: it is the patch of the means.
    let fine = [noise(28, 28, 7), bricks(28, 28)];
    let means = fine.each_ref().map(|grid| {
        let mean = |i: usize| {
            let corner = i / 7 * 4 * 28 + i % 7 * 4;
            let colors = grid.square(corner, 4).map(|pixel| grid.colors[pixel]);
            colors.fold([0.0; 3], |sum, color| {
                [0, 1, 2].map(|k| sum[k] + color[k] / 16.0)
            })
        };
        Grid::new(7, 7, (0..49).map(mean).collect())
    });
    let coarse = coarse_sliced_wasserstein(&fine[0], &fine[1]).unwrap();
    let expected = sliced_wasserstein(&means[0], &means[1]).unwrap();
    assert_relative_eq!(coarse, expected, max_relative = 1e-5);
    // Stripes of 8 pixels; the same, but every second pair is turned around.
    let stripes = |dark: fn(usize) -> bool| {
        let color = |i: usize| if dark(i % 80 / 8) { [0.2; 3] } else { [0.8; 3] };
        Grid::new(80, 40, (0..3200).map(color).collect())
    };
    let even = stripes(|stripe| stripe % 2 == 0);
    let uneven = stripes(|stripe| [0, 3, 4, 7, 8].contains(&stripe));
    let coarse = coarse_sliced_wasserstein(&even, &uneven).unwrap();
    let close = sliced_wasserstein(&even, &uneven).unwrap();
    assert!(coarse > 2.0 * close, "{coarse} against {close}");
}

#[test]
fn images_too_small_for_a_measure_have_none() {
    let (small, grid) = (noise(6, 40, 5), noise(40, 40, 5));
    assert_eq!(sliced_wasserstein(&small, &grid), None);
    assert_eq!(coarse_sliced_wasserstein(&grid, &noise(27, 40, 5)), None);
    assert_eq!(spectrum_distance(&grid, &small), None);
    let mut nothing = grid.clone();
    nothing.mask = Some(vec![false; 1600]);
    assert_eq!(least_histogram_correlation(&grid, &nothing), None);
    assert_eq!(gradient_distance(&nothing, &grid), None);
    assert_eq!(gradient_distance(&grid, &nothing), None);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let (first, second) = (bricks(64, 48), noise(48, 64, 6));
    let distance = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| sliced_wasserstein(&first, &second).unwrap())
    };
    assert_eq!(distance(1).to_bits(), distance(3).to_bits());
}

#[test]
fn pieces_are_told_by_their_sources() {
    let whole: Vec<_> = (0..48).map(|i| Some([3 + i % 8, 1 + i / 8])).collect();
    let all = Copies {
        continued: 1.0,
        largest: 1.0,
    };
    assert_eq!(copies(&whole, 8), Some(all));
    // The right half from elsewhere: of 8·5 + 7·6 pairs the 6 across the seam are broken.
    let mut halves = whole.clone();
    for (i, source) in halves.iter_mut().enumerate() {
        *source = source.map(|[x, y]| if i % 8 < 4 { [x, y] } else { [x + 20, y] });
    }
    let found = copies(&halves, 8).unwrap();
    assert_relative_eq!(found.continued, 76.0 / 82.0);
    assert_relative_eq!(found.largest, 0.5);
    // Mirrored pixels are no neighbors, and those without a source are no piece.
    let mirrored: Vec<_> = (0..48).map(|i| Some([10 - i % 8, 10 - i / 8])).collect();
    let none = Copies {
        continued: 0.0,
        largest: 1.0 / 48.0,
    };
    assert_eq!(copies(&mirrored, 8), Some(none));
    let nothing = Copies {
        continued: 0.0,
        largest: 0.0,
    };
    assert_eq!(copies(&[None; 48], 8), Some(nothing));
    assert_eq!(copies(&[Some([0, 0])], 1), None);
}
