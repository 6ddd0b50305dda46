//! `cargo bench --bench render`: a picture of 250 000 vertices and 1600 by 1200 pixels, by the library and
//! by the whole command.

use std::hint::black_box;
use std::path::Path;
use std::process::Command;

use criterion::{Criterion, criterion_group, criterion_main};
use relievo::picture::{ChannelChoice, RenderParams, render, write_png};
use relievo::scan::{Column, Scan, WriteOptions, write};

/// Side of the grid: 500 by 500 vertices, 498 002 triangles.
const SIDE: u32 = 500;

/// A wavy sheet, as a scanner writes it: single precision, with colours and heights.
fn scan() -> Scan {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "made-up coordinates may be rounded"
    )]
    let column = |f: &dyn Fn(f64, f64) -> f64| {
        let grid = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| [i, j].map(f64::from)));
        Column::F32(grid.map(|[i, j]| f(i, j) as f32).collect())
    };
    let height = |i: f64, j: f64| (i * 0.11).sin() * (j * 0.07).cos() + 0.2 * (i * 0.9 + j).sin();
    let mut scan = Scan::default();
    let vertices = &mut scan.vertices;
    vertices.set_channel("x", column(&|i, _| i * 0.1));
    vertices.set_channel("y", column(&|_, j| j * 0.1));
    vertices.set_channel("z", column(&height));
    vertices.set_channel("height", column(&height));
    for (k, name) in (0u32..).zip(["red", "green", "blue"]) {
        let values = (0..SIDE * SIDE)
            .map(|n| (n >> k).to_le_bytes()[0])
            .collect();
        vertices.set_channel(name, Column::U8(values));
    }
    for i in 0..SIDE - 1 {
        for j in 0..SIDE - 1 {
            let a = i * SIDE + j;
            scan.faces.push_row(&[a, a + SIDE, a + SIDE + 1]);
            scan.faces.push_row(&[a, a + SIDE + 1, a + 1]);
        }
    }
    scan
}

fn pictures(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("there is room");
    let scan = scan();
    let mut group = criterion.benchmark_group("a picture of 250 000 vertices");
    group.sample_size(10);
    let params = |channel| RenderParams {
        channel,
        ..RenderParams::default()
    };
    for (what, channel) in [
        ("colors", ChannelChoice::Color),
        ("shape", ChannelChoice::Shape),
        ("height", ChannelChoice::Height),
    ] {
        let params = params(channel);
        group.bench_function(format!("drawing, {what}"), |bencher| {
            bencher.iter(|| render(black_box(&scan), &params).expect("it can be drawn"));
        });
    }
    let picture = render(&scan, &params(ChannelChoice::Color)).expect("it can be drawn");
    group.bench_function("writing PNG", |bencher| {
        bencher.iter(|| {
            let mut bytes = Vec::new();
            write_png(black_box(&picture.raster), &mut bytes).expect("memory takes it");
            bytes
        });
    });
    let [input, output] = ["in.ply", "out.png"].map(|name| folder.path().join(name));
    write(&scan, &input, &WriteOptions::default()).expect("it can be written");
    for channel in ["color", "height"] {
        group.bench_function(format!("whole command, {channel}"), |bencher| {
            bencher.iter(|| command(&input, &output, channel));
        });
    }
    group.finish();
}

fn command(input: &Path, output: &Path, channel: &str) {
    let status = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .arg("render")
        .arg(input)
        .arg("-o")
        .arg(output)
        .args(["--channel", channel])
        .status()
        .expect("the program starts");
    assert!(status.success());
}

criterion_group!(benches, pictures);
criterion_main!(benches);
