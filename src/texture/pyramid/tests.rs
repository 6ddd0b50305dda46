use nalgebra::{Point3, Vector3};

use super::*;
use crate::rng::Stage;
use crate::scan::Image;

/// Values that no filter can mistake for others.
fn grid(width: usize, height: usize, channels: usize, known: impl Fn(usize) -> bool) -> Grid {
    let mut rng = Rng::new(5, Stage::Texture, 0);
    #[expect(clippy::cast_possible_truncation, reason = "any value does")]
    let values = (0..width * height * channels)
        .map(|_| rng.uniform() as f32)
        .collect();
    Grid {
        width,
        height,
        channels,
        values,
        known: (0..width * height).map(known).collect(),
    }
}

/// The index that a mirror at the first and the last of `count` shows.
fn reflected(at: isize, count: usize) -> usize {
    let count = isize::try_from(count).unwrap();
    let mut at = at;
    while count > 1 && !(0..count).contains(&at) {
        at = if at < 0 { -at } else { 2 * (count - 1) - at };
    }
    usize::try_from(if count > 1 { at } else { 0 }).unwrap()
}

/// What a plain double loop makes of a pixel and channel.
fn reference(grid: &Grid, x: usize, y: usize, channel: usize) -> f64 {
    let weight = |d: isize| f64::from([1u8, 4, 6, 4, 1][usize::try_from(d + 2).unwrap()]) / 16.0;
    let (mut sum, mut total) = (0.0, 0.0);
    for dy in -2..=2 {
        for dx in -2..=2 {
            let column = reflected(isize::try_from(2 * x).unwrap() + dx, grid.width);
            let row = reflected(isize::try_from(2 * y).unwrap() + dy, grid.height);
            let pixel = row * grid.width + column;
            if grid.known[pixel] {
                let value = f64::from(grid.values[pixel * grid.channels + channel]);
                sum += weight(dx) * weight(dy) * value;
                total += weight(dx) * weight(dy);
            }
        }
    }
    if total > 0.0 { sum / total } else { 0.0 }
}

#[test]
fn reduced_grids_match_a_plain_double_loop() {
    for [width, height] in [
        [9, 7],
        [8, 8],
        [5, 12],
        [4, 4],
        [3, 2],
        [1, 6],
        [2, 1],
        [1, 1],
    ] {
        for channels in [1, 3] {
            for mask in [|_| true, |i: usize| !i.is_multiple_of(3), |i: usize| i > 30] {
                let grid = grid(width, height, channels, mask);
                let reduced = grid.reduced();
                assert_eq!(
                    (reduced.width, reduced.height),
                    (width.div_ceil(2), height.div_ceil(2))
                );
                for (i, [x, y]) in reduced.pixels().enumerate() {
                    for channel in 0..channels {
                        let value = f64::from(reduced.values[i * channels + channel]);
                        let expected = reference(&grid, x, y, channel);
                        assert!(
                            (value - expected).abs() < 1e-6,
                            "{width} x {height}: {x}, {y}"
                        );
                    }
                    assert_eq!(reduced.known[i], grid.known[2 * y * width + 2 * x]);
                }
            }
        }
    }
}

#[test]
fn a_constant_stays_what_it_is() {
    let mut grid = grid(13, 10, 1, |i| i % 4 != 1);
    grid.values.fill(0.3);
    let reduced = grid.reduced();
    assert!(
        reduced
            .values
            .iter()
            .all(|value| (value - 0.3).abs() < 1e-6)
    );
}

#[test]
fn levels_of_an_image_lie_over_each_other() {
    for [width, height] in [[17, 13], [16, 24]] {
        let levels = of_image(&grid(width, height, 1, |_| true), 3);
        assert_eq!(levels.len(), 3);
        for (k, level) in levels.iter().enumerate() {
            assert!((level.texel - f64::from(1 << k)).abs() < 1e-12);
            let same = |place: &Option<Place>, on: &PyramidLevel, point: &Point3<f64>| {
                let place = place.as_ref()?;
                assert!((on.surface.axis(place) - Vector3::x()).norm() < 1e-5);
                Some((on.surface.position(place) - point).norm() < 1e-4)
            };
            let coarser = levels.get(k + 1);
            let [columns, rows] = [width, height].map(|side| (side - 1) >> (k + 1) << (k + 1));
            for (v, point) in level.surface.positions().iter().enumerate() {
                assert_eq!(same(&level.places[v], level, point), Some(true));
                // Beyond the last pixel of the coarser level there is nothing of it.
                let is_beyond = point.x > columns as f64 || -point.y > rows as f64;
                let above = coarser.and_then(|on| same(&level.above[v], on, point));
                assert_eq!(
                    above,
                    (coarser.is_some() && !is_beyond).then_some(true),
                    "{point}"
                );
                let below = k
                    .checked_sub(1)
                    .and_then(|k| same(&level.below[v], &levels[k], point));
                assert_eq!(below, (k > 0).then_some(true), "{point}");
            }
        }
        let origins: Vec<u32> = (0..).take(width * height).collect();
        assert_eq!(levels[0].origins, origins);
    }
}

#[test]
fn places_of_one_level_are_found_on_the_finer_one() {
    let levels = of_image(&grid(20, 20, 1, |_| true), 2);
    let [fine, coarse] = &levels[..] else {
        unreachable!()
    };
    let centre = coarse.places[5 * 10 + 5].unwrap();
    for offset in [[0.0, 0.0], [0.7, -0.3], [1.9, 1.2], [-3.1, 2.2]] {
        let place = coarse.surface.walk(&centre, offset).unwrap();
        let there = coarse.one_finer(&place, fine).unwrap();
        let apart = fine.surface.position(&there) - coarse.surface.position(&place);
        assert!(apart.norm() < 1e-4, "{offset:?}: {apart}");
    }
}

fn image(width: u32, height: u32, opaque: Option<Vec<bool>>) -> Image {
    let pixels = (width * height) as usize;
    Image {
        width,
        height,
        colors: vec![[0.5, 0.2, 0.1]; pixels],
        opaque,
        is_grey: false,
        bits: 8,
    }
}

#[test]
fn samples_that_hold_no_neighborhood_are_refused() {
    let mut rng = Rng::new(0, Stage::Texture, 0);
    let mut pyramid = |image: &Image, method| {
        let pyramid = Pyramid::new(&Sample::of_image(image), method, 4, &mut rng);
        pyramid.map(|pyramid| pyramid.levels.len())
    };
    for method in [Method::Coherent, Method::WeiLevoy] {
        for [width, height] in [[1, 1], [6, 6], [1, 100], [100, 6]] {
            let refused = pyramid(&image(width, height, None), method);
            assert!(matches!(
                refused,
                Err(TextureError::SampleTooSmall { window: 7, .. })
            ));
        }
        assert_eq!(
            pyramid(&image(7, 7, None), method).unwrap(),
            1,
            "{method:?}"
        );
        // Opaque, but for every seventh pixel.
        let holes = (0..400).map(|i| i % 7 != 0).collect();
        assert!(pyramid(&image(20, 20, Some(holes)), method).is_err());
        assert!(
            pyramid(&image(64, 64, None), method).unwrap() > 2,
            "{method:?}"
        );
    }
}
