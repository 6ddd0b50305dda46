//! `cargo bench --bench formats`: reading and writing a scan of a million vertices with colours.
//!
//! Prints, next to the times, the largest memory that reading took (Linux only).

#![allow(
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    reason = "a report is what a bench is for, and made-up coordinates may be rounded"
)]

use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use relievo::scan::{Column, ReadOptions, Scan, WriteOptions, read, write};

/// Side of the grid: 1000 by 1000 vertices, 1 996 002 triangles.
const SIDE: u32 = 1000;

fn scan() -> Scan {
    let mut scan = Scan::default();
    let grid = || (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| [i, j]));
    let height = |[i, j]: [u32; 2]| (f64::from(i) * 0.3).sin() * (f64::from(j) * 0.2).cos();
    let float = |f: &dyn Fn([u32; 2]) -> f64| Column::F32(grid().map(|p| f(p) as f32).collect());
    let vertices = &mut scan.vertices;
    vertices.set_channel("x", float(&|[i, _]| f64::from(i) * 0.1));
    vertices.set_channel("y", float(&|[_, j]| f64::from(j) * 0.1));
    vertices.set_channel("z", float(&height));
    for (k, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let value = |[i, j]: [u32; 2]| ((i * 7 + j * 3) >> k & 255) as u8;
        vertices.set_channel(name, Column::U8(grid().map(value).collect()));
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

/// Peak of the memory held since the last call, in MiB; `None` where the system does not tell.
fn peak() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    // 5 resets the peak.
    fs::write("/proc/self/clear_refs", "5").ok()?;
    Some(kilobytes / 1024.0)
}

fn resident() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

fn memory(path: &Path, what: &str) {
    let (before, _) = (resident(), peak());
    let start = Instant::now();
    let scan = read(path, &ReadOptions::default()).expect("it was written by us");
    let seconds = start.elapsed().as_secs_f64();
    if let (Some(peak), Some(before)) = (peak(), before) {
        println!("{what}: {seconds:.2} s, at most {:.0} MiB", peak - before);
    }
    drop(black_box(scan));
}

fn formats(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("there is room");
    let scan = scan();
    let mut group = criterion.benchmark_group("a million vertices");
    group.sample_size(10);
    for (what, file, ascii) in [
        ("PLY", "a.ply", false),
        ("ASCII PLY", "text.ply", true),
        ("OBJ", "a.obj", false),
        ("OFF", "a.off", false),
        ("STL", "a.stl", false),
        ("GLB", "a.glb", false),
    ] {
        let path = folder.path().join(file);
        let options = WriteOptions { ascii };
        group.bench_function(format!("write {what}"), |b| {
            b.iter(|| write(&scan, &path, &options).expect("there is room"));
        });
        memory(&path, &format!("read {what}"));
        group.bench_function(format!("read {what}"), |b| {
            b.iter(|| read(black_box(&path), &ReadOptions::default()).expect("it can be read"));
        });
    }
    group.finish();
}

criterion_group!(benches, formats);
criterion_main!(benches);
