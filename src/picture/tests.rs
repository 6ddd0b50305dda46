//! Pictures of which it is known what must be on them.

use nalgebra::Vector3;

use super::*;
use crate::scan::Column;
use crate::synth::{Kind, Part, SynthParams, scan as synthesize};

fn to_scan(positions: &[[f64; 3]], faces: &[[u32; 3]]) -> Scan {
    let mut scan = Scan::default();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let values = positions.iter().map(|p| p[axis]).collect();
        scan.vertices.set_channel(name, Column::F64(values));
    }
    for face in faces {
        scan.faces.push_row(face);
    }
    scan
}

fn painted(mut scan: Scan, colors: &[[u8; 3]]) -> Scan {
    for (k, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let values = colors.iter().map(|color| color[k]).collect();
        scan.vertices.set_channel(name, Column::U8(values));
    }
    scan
}

fn small() -> RenderParams {
    RenderParams {
        width: 120,
        height: 90,
        ..RenderParams::default()
    }
}

fn drawn(scan: &Scan, params: &RenderParams) -> Raster {
    render(scan, params).unwrap().raster
}

/// A sphere of 12 482 triangles around a point, with a height channel that is its x.
fn sphere(center: Vector3<f64>) -> Scan {
    let (rings, sectors) = (80u32, 79u32);
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for ring in 0..=rings {
        let polar = f64::from(ring) / f64::from(rings) * std::f64::consts::PI;
        for sector in 0..sectors {
            let around = f64::from(sector) / f64::from(sectors) * std::f64::consts::TAU;
            let p = Vector3::new(
                polar.sin() * around.cos(),
                polar.sin() * around.sin(),
                polar.cos(),
            );
            // Multiples of 2⁻²⁰, so that large offsets round nothing away.
            let p = p.map(|x| (x * 1_048_576.0).round() / 1_048_576.0);
            positions.push((p + center).into());
            let next = ring * sectors + (sector + 1) % sectors;
            if ring < rings {
                let here = ring * sectors + sector;
                faces.push([here, here + sectors, next]);
                faces.push([next, here + sectors, next + sectors]);
            }
        }
    }
    let mut scan = to_scan(&positions, &faces);
    let heights = positions.iter().map(|p| p[0] - center.x).collect();
    scan.vertices.set_channel("height", Column::F64(heights));
    scan
}

const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0]];

#[test]
fn a_red_triangle_is_red_in_the_middle_and_its_back_is_dull() {
    let scan = painted(to_scan(&TRIANGLE, &[[0, 1, 2]]), &[[255, 0, 0]; 3]);
    let raster = drawn(&scan, &small());
    let [r, g, b, a] = raster.pixel(60, 55).unwrap();
    assert!(r > 200 && g < 60 && b < 60 && a == 255, "{r} {g} {b} {a}");
    assert_eq!(raster.pixel(3, 3), Some([255; 4]));
    let behind = RenderParams {
        view: View::Back,
        ..small()
    };
    let [back, ..] = drawn(&scan, &behind).pixel(60, 55).unwrap();
    assert!(back < r - 40, "{back}");
}

#[test]
fn the_nearer_of_two_triangles_is_seen_from_either_side() {
    let mut positions = TRIANGLE.to_vec();
    positions.extend(TRIANGLE.map(|[x, y, _]| [x, y, 0.2]));
    let colors = [
        [255, 0, 0],
        [255, 0, 0],
        [255, 0, 0],
        [0, 0, 255],
        [0, 0, 255],
        [0, 0, 255],
    ];
    let scan = painted(to_scan(&positions, &[[0, 1, 2], [3, 4, 5]]), &colors);
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let seen = |view| {
            let params = RenderParams {
                view,
                projection,
                ..small()
            };
            drawn(&scan, &params).pixel(60, 55).unwrap()
        };
        let (front, back) = (seen(View::Front), seen(View::Back));
        assert!(
            front[2] > front[0] && back[0] > back[2],
            "{front:?} {back:?}"
        );
    }
}

#[test]
fn a_spheres_silhouette_has_the_area_of_its_circle() {
    let params = RenderParams {
        width: 200,
        height: 200,
        background: Background::Transparent,
        channel: ChannelChoice::Shape,
        ..RenderParams::default()
    };
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let params = RenderParams {
            projection,
            ..params.clone()
        };
        let raster = drawn(&sphere(Vector3::zeros()), &params);
        let covered: f64 = raster.pixels.iter().map(|p| f64::from(p[3]) / 255.0).sum();
        // It is fitted to the picture but for the margin of 3 % on each side.
        let radius: f64 = 0.5 * 200.0 * 0.94;
        let share = covered / (std::f64::consts::PI * radius * radius);
        assert!((share - 1.0).abs() < 0.01, "{projection:?} {share}");
    }
}

#[test]
fn light_comes_from_the_upper_left() {
    let raster = drawn(
        &sphere(Vector3::zeros()),
        &RenderParams {
            channel: ChannelChoice::Shape,
            ..small()
        },
    );
    let [lit, dark] = [(45, 30), (75, 62)].map(|(x, y)| raster.pixel(x, y).unwrap()[1]);
    assert!(lit > dark + 40, "{lit} {dark}");
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let scan = synthesize(&SynthParams {
        kind: Kind::Bricks,
        vertices: 2000,
        part: Part::hole(0.1),
        ..SynthParams::default()
    });
    let scan = scan.unwrap().scan;
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| drawn(&scan, &small()))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn an_offset_of_ten_million_changes_no_byte() {
    for channel in [ChannelChoice::Shape, ChannelChoice::Height] {
        let params = RenderParams {
            channel,
            view: View::Iso,
            ..small()
        };
        let offset = Vector3::new(1e7, -1e7, 2e7);
        let there = drawn(&sphere(offset), &params);
        assert_eq!(there, drawn(&sphere(Vector3::zeros()), &params));
    }
}

#[test]
fn scales_change_hardly_anything() {
    let params = RenderParams {
        channel: ChannelChoice::Shape,
        ..small()
    };
    let plain = drawn(&sphere(Vector3::zeros()), &params);
    for size in [1e-150, 1e-9, 1e9, 1e150] {
        let mut scan = sphere(Vector3::zeros());
        for p in &mut scan.vertices.channels[..3] {
            let Column::F64(values) = &mut p.values else {
                unreachable!()
            };
            values.iter_mut().for_each(|x| *x *= size);
        }
        let scaled = drawn(&scan, &params);
        let pairs = plain.pixels.iter().zip(&scaled.pixels);
        let differing = pairs.filter(|(a, b)| a[0].abs_diff(b[0]) > 3).count();
        assert!(differing < 100, "{size} {differing}");
    }
}

#[test]
fn vertices_that_are_not_finite_are_left_out_with_their_triangles() {
    let mut positions = TRIANGLE.to_vec();
    positions.extend([[f64::NAN; 3], [f64::INFINITY, 0.0, 0.0], [0.2, 0.1, 0.0]]);
    let faces = [
        [0, 1, 2],
        [0, 1, 3],
        [4, 1, 2],
        [3, 4, 5],
        [5, 5, 5],
        [0, 0, 1],
    ];
    let clean = drawn(&to_scan(&TRIANGLE, &[[0, 1, 2]]), &small());
    assert_eq!(drawn(&to_scan(&positions, &faces), &small()), clean);
}

#[test]
fn meshes_without_extent_draw_nothing_and_those_without_faces_say_so() {
    let point = to_scan(&[[7.0, 7.0, 7.0]; 3], &[[0, 1, 2]]);
    let line = to_scan(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[[0, 1, 2]]);
    for (scan, most) in [(&point, 0), (&line, 200)] {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let params = RenderParams {
                projection,
                ..small()
            };
            let raster = drawn(scan, &params);
            // Rounding to the picture's grid may leave a line the width of a sample.
            let drawn = raster.pixels.iter().filter(|pixel| **pixel != [255; 4]);
            assert!(drawn.count() <= most);
        }
    }
    let nan = to_scan(&[[f64::NAN; 3]; 3], &[[0, 1, 2]]);
    for scan in [
        to_scan(&[[1.0; 3]], &[]),
        to_scan(&TRIANGLE, &[[0, 0, 1]]),
        nan,
    ] {
        assert_eq!(render(&scan, &small()), Err(PictureError::NoFaces));
    }
}

/// A strip of 4 triangles, the right half completed.
fn half_completed() -> Scan {
    let mut positions = Vec::new();
    for k in 0..3 {
        positions.extend([[f64::from(k), 0.0, 0.0], [f64::from(k), 1.0, 0.0]]);
    }
    let faces = [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]];
    let mut scan = to_scan(&positions, &faces);
    let marks = vec![0, 0, 0, 0, 1, 1];
    scan.vertices.set_channel("completed", Column::U8(marks));
    let sources = vec![-1, -1, -1, -1, 0, 9];
    scan.vertices.set_channel("source", Column::I32(sources));
    let nan = f32::NAN;
    let costs = vec![nan, nan, nan, nan, 0.5, 0.25];
    scan.vertices.set_channel("cost", Column::F32(costs));
    scan
}

#[test]
fn before_leaves_out_what_was_completed_and_keeps_the_camera() {
    let scan = half_completed();
    let after = drawn(&scan, &small());
    let params = RenderParams {
        before: true,
        ..small()
    };
    let before = drawn(&scan, &params);
    assert_eq!(before.pixel(90, 45), Some([255; 4]));
    assert_ne!(after.pixel(90, 45), Some([255; 4]));
    for x in 0..55 {
        for y in 0..90 {
            assert_eq!(before.pixel(x, y), after.pixel(x, y));
        }
    }
}

#[test]
fn completed_faces_have_another_color_and_the_camera_can_look_at_them() {
    let scan = half_completed();
    let params = RenderParams {
        channel: ChannelChoice::Completed,
        legend: false,
        ..small()
    };
    let raster = drawn(&scan, &params);
    let [old, new] = [30, 90].map(|x| raster.pixel(x, 45).unwrap());
    assert!(old[2] > old[0] && new[0] > new[2] + 80, "{old:?} {new:?}");
    let close = drawn(
        &scan,
        &RenderParams {
            look_at: LookAt::Completed,
            ..params
        },
    );
    // What is completed are the two vertices at the right end.
    let seen = close.pixel(55, 45).unwrap();
    assert!(seen[0] > seen[2] + 80, "{seen:?}");
    assert_eq!(close.pixel(70, 45), Some([255; 4]));
}

#[test]
fn costs_and_sources_are_drawn_where_there_are_any() {
    let scan = half_completed();
    for channel in [ChannelChoice::Cost, ChannelChoice::Source] {
        let params = RenderParams {
            channel: channel.clone(),
            legend: false,
            ..small()
        };
        let raster = drawn(&scan, &params);
        let [old, new] = [10, 110].map(|x| raster.pixel(x, 45).unwrap());
        let colorful = |[r, g, b, _]: [u8; 4]| r.max(g).max(b) - r.min(g).min(b);
        assert!(colorful(new) > colorful(old), "{channel:?} {old:?} {new:?}");
    }
}

#[test]
fn heights_have_a_color_bar_with_text_unless_it_is_switched_off() {
    let scan = sphere(Vector3::zeros());
    let params = RenderParams {
        width: 400,
        height: 300,
        channel: ChannelChoice::Height,
        view: View::Front,
        ..RenderParams::default()
    };
    let picture = render(&scan, &params).unwrap();
    assert_eq!(picture.report.channel, "height");
    let [low, high] = picture.report.range.unwrap();
    assert!(
        (low + high).abs() < 1e-12 && high > 0.9 && high <= 1.0,
        "{high}"
    );
    let ink = |raster: &Raster| {
        raster
            .pixels
            .iter()
            .filter(|p| **p == [40, 40, 40, 255])
            .count()
    };
    assert!(ink(&picture.raster) > 200);
    let without = RenderParams {
        legend: false,
        ..params.clone()
    };
    assert_eq!(ink(&drawn(&scan, &without)), 0);
    // Blue on the left, where x is low, red on the right.
    let [left, right] = [60, 190].map(|x| picture.raster.pixel(x, 150).unwrap());
    assert!(
        left[2] > left[0] && right[0] > right[2],
        "{left:?} {right:?}"
    );
    let given = RenderParams {
        range: Some([-3.0, 5.0]),
        ..params
    };
    assert_eq!(
        render(&scan, &given).unwrap().report.range,
        Some([-3.0, 5.0])
    );
}

#[test]
fn heights_are_taken_over_the_base_that_fits_where_there_are_none() {
    let mut scan = synthesize(&SynthParams {
        kind: Kind::GolfBall,
        vertices: 1500,
        part: Part::hole(0.05),
        ..SynthParams::default()
    })
    .unwrap()
    .scan;
    scan.vertices
        .channels
        .retain(|channel| channel.name != "height");
    let params = RenderParams {
        channel: ChannelChoice::Height,
        ..small()
    };
    let [low, high] = render(&scan, &params).unwrap().report.range.unwrap();
    // Dimples are a quarter of a millimetre deep.
    assert!(low > -0.5 && high < 0.5 && high > 0.02, "{low} {high}");
}

#[test]
fn channels_that_are_missing_are_named_with_those_that_are_there() {
    let scan = sphere(Vector3::zeros());
    for (channel, what) in [
        (ChannelChoice::Color, "colours"),
        (ChannelChoice::Completed, "\"completed\""),
        (ChannelChoice::Cost, "\"cost\""),
        (ChannelChoice::Source, "\"source\""),
        (ChannelChoice::Property("heat".into()), "\"heat\""),
    ] {
        let params = RenderParams { channel, ..small() };
        let error = render(&scan, &params).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
        assert!(error.contains("\"x\", \"y\", \"z\", \"height\""), "{error}");
    }
    let mut nan = scan.clone();
    let values = vec![f64::NAN; nan.vertices.rows];
    nan.vertices.set_channel("heat", Column::F64(values));
    let params = RenderParams {
        channel: ChannelChoice::Property("heat".into()),
        ..small()
    };
    assert_eq!(
        render(&nan, &params),
        Err(PictureError::NoValues("heat".into()))
    );
    let params = RenderParams {
        before: true,
        ..small()
    };
    assert!(matches!(
        render(&scan, &params),
        Err(PictureError::NoChannel { .. })
    ));
}

#[test]
fn a_wireframe_is_darker_and_zoom_enlarges() {
    let scan = to_scan(&TRIANGLE, &[[0, 1, 2]]);
    let sum = |params: &RenderParams| -> u64 {
        drawn(&scan, params)
            .pixels
            .iter()
            .map(|p| u64::from(p[1]))
            .sum()
    };
    let plain = sum(&small());
    let wired = sum(&RenderParams {
        wireframe: true,
        ..small()
    });
    assert!(wired < plain);
    let near = RenderParams {
        zoom: 4.0,
        ..small()
    };
    let near = drawn(&scan, &near);
    assert!(near.pixels.iter().filter(|p| **p == [255; 4]).count() < 200);
}
