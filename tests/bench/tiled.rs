//! Completion in tiles against completion in one piece: time, memory, and how well tiles fit together.
//!
//!     cargo bench --bench tiled -- KIND [VERTICES [TILE]]
//!
//! KIND is a synthetic object (golf-ball, bricks, …) of 1 000 000 vertices unless told otherwise, of which one large hole
//! takes a fifth and eight small ones a little. Tiles have at most 200 000 vertices. Every way runs in a process of its own,
//! whose peak memory the system tells (Linux: `VmHWM`).
#![expect(clippy::print_stdout, reason = "the table is what this is for")]

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use relievo::completion::{CompleteParams, TileParams, TilePlan, TileTask, complete};
use relievo::mesh::Csr;
use relievo::scan::{self, Column, ReadOptions, Scan, WriteOptions};
use relievo::stats;
use relievo::synth::{Kind, Part, SynthParams};

fn main() -> Result<()> {
    // Cargo adds `--bench`.
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| word != "--bench")
        .collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        [] => {
            println!("nothing to do: say `-- KIND [VERTICES [TILE]]`");
            Ok(())
        }
        ["untiled", input, output] => untiled(Path::new(input), Path::new(output)),
        ["tiled", input, output, tile, tasks] => {
            let places = [input, output, tasks].map(Path::new);
            tiled(places, tile.parse()?)
        }
        ["task", file] => task(Path::new(file)),
        [kind, ref rest @ ..] => {
            let number = |i: usize, default: usize| match rest.get(i) {
                Some(word) => word.parse().with_context(|| format!("{word} is no number")),
                None => Ok(default),
            };
            compare(kind.parse()?, number(0, 1_000_000)?, number(1, 200_000)?)
        }
    }
}

/// Both ways on the same scan.
fn compare(kind: Kind, vertices: usize, tile: usize) -> Result<()> {
    let folder = std::env::temp_dir().join(format!("relievo_tiled_{kind}"));
    std::fs::create_dir_all(&folder)?;
    let input = folder.join("scan.ply");
    let made = holed(kind, vertices)?;
    scan::write(&made, &input, &WriteOptions::default())?;
    println!("{kind}: {} vertices, tiles of {tile}", made.vertices.rows);
    let [one, many] = ["untiled.ply", "tiled.ply"].map(|name| folder.join(name));
    let place = |path: &Path| path.display().to_string();
    child(&["untiled", &place(&input), &place(&one)])?;
    let tasks = place(&folder.join("largest.task"));
    child(&[
        "tiled",
        &place(&input),
        &place(&many),
        &tile.to_string(),
        &tasks,
    ])?;
    child(&["task", &tasks])?;
    println!("results are in {}", folder.display());
    Ok(())
}

/// Runs one way in a process of its own.
fn child(words: &[&str]) -> Result<()> {
    let status = Command::new(std::env::current_exe()?)
        .args(words)
        .status()?;
    if !status.success() {
        bail!("`{}` failed", words.join(" "));
    }
    Ok(())
}

/// An object with one large hole and eight small ones.
fn holed(kind: Kind, vertices: usize) -> Result<Scan> {
    let params = SynthParams {
        kind,
        vertices,
        part: Part::hole(0.2),
        ..SynthParams::default()
    };
    let made = relievo::synth::scan(&params)?.scan;
    let positions = made.positions();
    let edge = relievo::mesh::median_edge(&made.mesh()).context("it has faces")?;
    // Around vertices spread over the scan; near its rim they may become bays, which stay open.
    let middles: Vec<_> = (1..=8)
        .map(|i| positions[i * positions.len() / 9])
        .collect();
    let radius = 20.0 * edge;
    let stays = |v: u32| {
        let p = positions[v as usize];
        middles.iter().all(|middle| (p - middle).norm() > radius)
    };
    let triangles = made.triangles();
    let kept: Vec<[u32; 3]> = (triangles.into_iter())
        .filter(|t| t.iter().all(|v| stays(*v)))
        .collect();
    Ok(only(&made, &kept))
}

/// The scan with these triangles, and the vertices that they use.
fn only(scan: &Scan, triangles: &[[u32; 3]]) -> Scan {
    let mut used = vec![false; scan.vertices.rows];
    for v in triangles.iter().flatten() {
        used[*v as usize] = true;
    }
    let rows: Vec<usize> = (0..used.len()).filter(|v| used[*v]).collect();
    let mut number = vec![0; used.len()];
    for (new, old) in (0u32..).zip(&rows) {
        number[*old] = new;
    }
    let mut out = Scan::default();
    for channel in &scan.vertices.channels {
        let values = match &channel.values {
            Column::U8(values) => Column::U8(rows.iter().map(|row| values[*row]).collect()),
            Column::F64(values) => Column::F64(rows.iter().map(|row| values[*row]).collect()),
            _ => continue,
        };
        out.vertices.set_channel(&channel.name, values);
    }
    out.vertices.rows = rows.len();
    let mut faces = Csr::default();
    for t in triangles {
        faces.push_row(&t.map(|v| number[v as usize]));
    }
    out.face_channels.rows = faces.len();
    out.faces = faces;
    out
}

fn untiled(input: &Path, output: &Path) -> Result<()> {
    let scan = scan::read(input, &ReadOptions::default())?;
    let start = Instant::now();
    let done = complete(&scan, &CompleteParams::default(), &mut |_| {})?;
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "in one piece: {} new vertices, {} holes skipped, {seconds:.1} s, peak {} MiB; {}",
        done.report.counts.completed_vertices,
        done.report.skipped.len(),
        peak_mib()?,
        stages(&done.report.seconds),
    );
    roughness(&done.scan)?;
    Ok(scan::write(&done.scan, output, &WriteOptions::default())?)
}

fn tiled([input, output, largest]: [&Path; 3], tile: usize) -> Result<()> {
    let scan = scan::read(input, &ReadOptions::default())?;
    let tiles = TileParams {
        tile,
        overlap: None,
    };
    let start = Instant::now();
    let mut plan = TilePlan::new(&scan, &CompleteParams::default(), &tiles, &mut |_| {})?;
    let planned = start.elapsed().as_secs_f64();
    let rounds: Vec<usize> = plan.rounds().iter().map(Vec::len).collect();
    let (mut making, mut growing, mut most, mut bytes) = (0.0, Vec::new(), 0, 0);
    for number in plan.rounds().into_iter().flatten() {
        let start = Instant::now();
        let sent = plan.task(number)?.to_bytes();
        making += start.elapsed().as_secs_f64();
        let start = Instant::now();
        let task = TileTask::from_bytes(&sent)?;
        if task.targets() > most {
            most = task.targets();
            bytes = sent.len();
            std::fs::write(largest, &sent)?;
        }
        let grown = task.grow(&mut |_| {});
        growing.push(start.elapsed().as_secs_f64());
        plan.put(number, grown)?;
    }
    let done = plan.finish(&mut |_| {})?;
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "in tiles: {} new vertices, {} holes skipped, {seconds:.1} s, peak {} MiB with the coordinator; {}",
        done.report.counts.completed_vertices,
        done.report.skipped.len(),
        peak_mib()?,
        stages(&done.report.seconds),
    );
    println!(
        "{} tiles, tiles a round {rounds:?}; plan {planned:.1} s, tasks {making:.1} s, growth of each {growing:.1?} s",
        done.tiling.tiles
    );
    println!(
        "largest task: {} vertices at most; that with the most new ones has {most} of them, {bytes} bytes",
        done.tiling.most_vertices
    );
    println!("seams: {:?}", done.seams);
    roughness(&done.scan)?;
    Ok(scan::write(&done.scan, output, &WriteOptions::default())?)
}

fn task(file: &Path) -> Result<()> {
    let bytes = std::fs::read(file)?;
    let task = TileTask::from_bytes(&bytes)?;
    drop(bytes);
    let before = peak_mib()?;
    let start = Instant::now();
    let grown = task.grow(&mut |_| {}).to_bytes();
    println!(
        "a worker: {} vertices, {} of them new, {:.1} s, peak {} MiB ({before} MiB when the task was read), {} bytes back",
        task.vertices(),
        task.targets(),
        start.elapsed().as_secs_f64(),
        peak_mib()?,
        grown.len(),
    );
    Ok(())
}

fn stages(stages: &[relievo::progress::StageTime]) -> String {
    let each = stages
        .iter()
        .map(|s| format!("{} {:.1}", s.stage, s.seconds));
    each.collect::<Vec<_>>().join(", ")
}

/// Roughness of the completed part over that of the original.
fn roughness(scan: &Scan) -> Result<()> {
    let ratio = stats::compare(scan)?.roughness_ratio.unwrap_or(f64::NAN);
    println!("    Sq of the completed part: {ratio:.3} of the original's");
    Ok(())
}

/// Most memory that this process had so far.
fn peak_mib() -> Result<u64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib: u64 = (line.and_then(|line| line.split_whitespace().next()))
        .context("the system tells no peak memory")?
        .parse()?;
    Ok(kib / 1024)
}
