#![allow(
    clippy::float_cmp,
    reason = "the same computation gives the same value"
)]

use nalgebra::Point3;

use super::*;
use crate::rng::{Rng, Stage};

type Uv = [[f64; 2]; 3];

/// Random triangles around the image, some of them turned over, beyond its borders or without area.
fn random_charts(seed: u32, count: usize) -> Vec<Uv> {
    let mut rng = Rng::new(seed, Stage::Synth, 0);
    let mut number = |low: f64, high: f64| low + (high - low) * rng.uniform();
    (0..count)
        .map(|k| {
            let middle = [number(-1.5, 2.5), number(-1.5, 2.5)];
            let size = if k % 5 == 0 { 1.2 } else { 0.2 };
            let mut corner = || middle.map(|m| m + number(-size, size));
            let (a, b, c) = (corner(), corner(), corner());
            match k % 7 {
                3 => [a, b, b],
                5 => [a, [f64::NAN, 0.0], c],
                _ => [a, b, c],
            }
        })
        .collect()
}

/// Barycentric coordinates; `None` without area.
fn barycentric(p: [f64; 2], [a, b, c]: Uv) -> Option<[f64; 3]> {
    let area = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let whole = area(a, b, c);
    (whole.abs() > 0.0).then(|| [area(p, b, c), area(a, p, c), area(a, b, p)].map(|s| s / whole))
}

/// The first triangle at a place, and whether there is another one.
fn plainly(place: [f64; 2], uv: &[Uv]) -> (Option<usize>, bool) {
    let images = (-4..=4).flat_map(|i| (-4..=4).map(move |j| [f64::from(i), f64::from(j)]));
    let images: Vec<[f64; 2]> = images.collect();
    let mut inside = Vec::new();
    for (number, corners) in uv.iter().enumerate() {
        for [i, j] in &images {
            let weights = barycentric([place[0] + i, place[1] + j], *corners);
            if weights.is_some_and(|w| w.iter().all(|w| *w >= 0.0)) {
                inside.push(number);
            }
        }
    }
    (inside.first().copied(), inside.len() > 1)
}

#[test]
fn every_pixel_is_as_a_plain_search_finds_it() {
    for (seed, [width, height]) in [(1, [32, 32]), (2, [40, 17]), (3, [7, 61]), (4, [3, 5])] {
        let uv = random_charts(seed, 25);
        let number = |triangle: usize, _: [f64; 3]| [triangle as f64 / 32.0, 0.5, 1.0];
        let baked = bake(width, height, &uv, number);
        let (mut covered, mut overlapping) = (0, 0);
        for y in 0..height {
            for x in 0..width {
                let u = (f64::from(x) + 0.5) / f64::from(width);
                let v = 1.0 - (f64::from(y) + 0.5) / f64::from(height);
                let (first, several) = plainly([u, v], &uv);
                covered += usize::from(first.is_some());
                overlapping += usize::from(several);
                if let Some(first) = first {
                    let color = baked.image.colors[(y * width + x) as usize];
                    assert_eq!(color, [first as f32 / 32.0, 0.5, 1.0], "{seed} {x} {y}");
                }
            }
        }
        let report = BakeReport {
            covered_pixels: covered,
            overlapping_pixels: overlapping,
            left_out_triangles: uv.len()
                - (0..uv.len()).filter(|k| ![3, 5].contains(&(k % 7))).count(),
        };
        assert_eq!(baked.report, report, "{seed}");
        assert!(covered > 0 && overlapping > 0);
    }
}

/// A cube from 0 to 1 with a chart for each of its six faces, three by two of them, apart from each other and
/// turned about: texture coordinates and corners of its twelve triangles.
fn cube(gap: f64) -> (Vec<Uv>, Vec<[Point3<f64>; 3]>) {
    let (mut uv, mut corners) = (Vec::new(), Vec::new());
    for face in 0..6_usize {
        let axis = face % 3;
        let point = |s: f64, t: f64| {
            let mut point = [0.0; 3];
            point[axis] = if face < 3 { 0.0 } else { 1.0 };
            point[(axis + 1) % 3] = s;
            point[(axis + 2) % 3] = t;
            Point3::from(point)
        };
        // A chart is turned by a few degrees within its cell.
        let (sin, cos) = (0.1 * face as f64).sin_cos();
        let scale = (1.0 - gap) / (cos + sin);
        let place = |s: f64, t: f64| {
            let (s, t) = (scale * (s - 0.5), scale * (t - 0.5));
            let (x, y) = (cos * s - sin * t, sin * s + cos * t);
            [
                (axis as f64 + 0.5 + x) / 3.0,
                ((face / 3) as f64 + 0.5 + y) / 2.0,
            ]
        };
        for t in [
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)],
            [(0.0, 0.0), (1.0, 1.0), (0.0, 1.0)],
        ] {
            uv.push(t.map(|(s, t)| place(s, t)));
            corners.push(t.map(|(s, t)| point(s, t)));
        }
    }
    (uv, corners)
}

fn mixed(corners: &[Point3<f64>; 3], w: [f64; 3]) -> [f64; 3] {
    let sum = corners[0].coords * w[0] + corners[1].coords * w[1] + corners[2].coords * w[2];
    sum.into()
}

/// The image at a place, interpolated linearly between the four nearest pixels; it repeats.
fn sampled(image: &Image, [u, v]: [f64; 2]) -> [f64; 3] {
    let (width, height) = (image.width as usize, image.height as usize);
    let (x, y) = (u * width as f64 - 0.5, (1.0 - v) * height as f64 - 0.5);
    let (left, top) = (x.floor(), y.floor());
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a whole number near the image"
    )]
    let place = |place: f64, size: usize| wrapped(place as i64, size);
    let mut sum = [0.0; 3];
    for (row, share_y) in [(top, 1.0 - (y - top)), (top + 1.0, y - top)] {
        for (column, share_x) in [(left, 1.0 - (x - left)), (left + 1.0, x - left)] {
            let color = image.colors[place(row, height) * width + place(column, width)];
            sum = [0, 1, 2].map(|k| sum[k] + share_x * share_y * f64::from(color[k]));
        }
    }
    sum
}

/// The image of half the size, each pixel the mean of four.
fn halved(image: &Image) -> Image {
    let (width, height) = (image.width / 2, image.height / 2);
    let at = |x: u32, y: u32| image.colors[(y * image.width + x) as usize];
    let pixel = |x: u32, y: u32| {
        let four = [
            at(2 * x, 2 * y),
            at(2 * x + 1, 2 * y),
            at(2 * x, 2 * y + 1),
            at(2 * x + 1, 2 * y + 1),
        ];
        [0, 1, 2].map(|k| four.iter().map(|c| c[k]).sum::<f32>() / 4.0)
    };
    Image {
        width,
        height,
        colors: (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| pixel(x, y))
            .collect(),
        ..image.clone()
    }
}

#[test]
fn a_cube_colored_by_position_shows_it_everywhere_also_at_the_borders_of_charts() {
    let (uv, corners) = cube(0.15);
    let [width, height] = [192, 128];
    let color = |t: usize, w: [f64; 3]| mixed(&corners[t], w);
    let baked = bake(width, height, &uv, color);
    assert_eq!(baked.report.overlapping_pixels, 0);
    // A chart is turned by half a radian at most, on a cell of 64 pixels.
    let pixel = (0.5f64.cos() + 0.5f64.sin()) / 0.85 / 64.0;
    let mut rng = Rng::new(1, Stage::Synth, 0);
    let mut image = baked.image;
    for level in 0..3 {
        let (mut worst, mut sum, count) = (0.0f64, 0.0, 20_000_u16);
        for n in 0..count {
            let t = rng.index(corners.len());
            let (r, s) = (rng.uniform(), rng.uniform());
            let mut w = if r + s > 1.0 {
                [1.0 - r, 1.0 - s, r + s - 1.0]
            } else {
                [r, s, 1.0 - r - s]
            };
            if n % 3 == 0 {
                // On the border of the triangle.
                w = [0.0, r, 1.0 - r];
                w.rotate_left(usize::from(n % 9 / 3));
            }
            let place = [0, 1].map(|k| (0..3).map(|c| w[c] * uv[t][c][k]).sum());
            let (truth, found) = (mixed(&corners[t], w), sampled(&image, place));
            let error = (0..3)
                .map(|k| (truth[k] - found[k]).powi(2))
                .sum::<f64>()
                .sqrt();
            worst = worst.max(error);
            sum += error;
        }
        let pixel = pixel * f64::from(1 << level);
        println!(
            "level {level}: worst {:.3}, mean {:.4} pixels",
            worst / pixel,
            sum / f64::from(count) / pixel
        );
        assert!(worst < pixel, "{level}: {} pixels", worst / pixel);
        image = halved(&image);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_image() {
    let uv = random_charts(9, 200);
    let color = |t: usize, w: [f64; 3]| [w[0] / (1.0 + t as f64), w[1], w[2]];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| bake(100, 75, &uv, color))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn shared_edges_leave_no_gap_and_are_no_overlap() {
    // A fan whose edges go through centers of pixels.
    let center = [0.5 + 1.0 / 64.0, 0.5 + 1.0 / 64.0];
    let rim: Vec<[f64; 2]> = (0..16)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 16.0).sin_cos();
            [center[0] + 0.4 * cos, center[1] + 0.4 * sin]
        })
        .collect();
    let uv: Vec<Uv> = (0..16)
        .map(|k| [center, rim[k], rim[(k + 1) % 16]])
        .collect();
    let baked = bake(32, 32, &uv, |_, _| [1.0; 3]);
    assert_eq!(baked.report.overlapping_pixels, 0);
    let inside = |k: usize| {
        let place = [
            ((k % 32) as f64 + 0.5) / 32.0,
            1.0 - ((k / 32) as f64 + 0.5) / 32.0,
        ];
        plainly(place, &uv).0.is_some()
    };
    let plainly_covered = (0..1024).filter(|k| inside(*k)).count();
    assert!(baked.report.covered_pixels >= plainly_covered);
    assert!(baked.image.is_grey && baked.image.colors.iter().all(|c| *c == [1.0; 3]));
}

#[test]
fn triangles_that_make_no_sense_are_left_out() {
    let good = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let far = good.map(|c| c.map(|x: f64| x * 1e9));
    let infinite = [[f64::INFINITY, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let uv = [
        far,
        infinite,
        [[0.5; 2]; 3],
        good.map(|[u, _]| [u, u]),
        good,
    ];
    let baked = bake(16, 16, &uv, |t, _| [t as f64 / 4.0, f64::NAN, 7.0]);
    assert_eq!(baked.report.left_out_triangles, 4);
    assert_eq!(baked.report.covered_pixels, 136);
    let color = baked.image.colors[15 * 16];
    assert_eq!((color[0], color[2]), (1.0, 1.0));
    let nothing = bake(3, 5, &uv[..4], |_, _| [1.0; 3]);
    assert!(nothing.image.colors.iter().all(|c| *c == [0.5; 3]));
    assert!(bake(3, 5, &[], |_, _| [1.0; 3]).image.is_grey);
}

#[test]
fn textures_repeat_beyond_the_image() {
    let chart = [[0.1, 0.2], [0.7, 0.3], [0.4, 0.9]];
    let away = chart.map(|[u, v]| [u - 7.0, v + 1e6]);
    let color = |_: usize, w: [f64; 3]| w;
    let (here, there) = (bake(50, 40, &[chart], color), bake(50, 40, &[away], color));
    assert_eq!(here.report, there.report);
    for (a, b) in here.image.colors.iter().zip(&there.image.colors) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}
