//! Transfers between meshes.
//!
//!     cargo bench --bench transfer -- times [VERTICES]
//!     cargo bench --bench transfer -- linear
//!     cargo bench --bench transfer -- field
//!     cargo bench --bench transfer -- copies
//!
//! `times` tells how long the stages take, with correspondences and with heat kernel signatures, on meshes of 65 536
//! vertices. `linear` tells the time of meshes of 8 192 to 524 288 vertices. `field` compares matches with the best that
//! there are. `copies` puts meshes onto themselves, and onto turned, scaled and differently tessellated copies; with
//! those of ../shared/data/transfer if they are there.
#![expect(clippy::print_stdout, reason = "the table is what this is for")]

mod transfer_meshes;

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail};
use nalgebra::Point3;
use relievo::mesh::TriMesh;
use relievo::scan::{self, ReadOptions};
use relievo::transfer::{
    Last, Pair, Rotations, Shape, Source, TransferParams, Transferred, transfer,
};

use transfer_meshes::{Colored, copy, error, ring};

/// Where real meshes are.
const MESHES: &str = "../shared/data/transfer";

fn main() -> Result<()> {
    // Cargo adds `--bench`.
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| word != "--bench")
        .collect();
    match words.first().map(String::as_str) {
        Some("times") => times(words.get(1).map_or(Ok(65_536), |n| n.parse())?),
        Some("linear") => linear(),
        Some("field") => field(),
        Some("copies") => copies(),
        None => {
            println!(
                "nothing to do: say `-- times [VERTICES]`, `-- linear`, `-- field` or `-- copies`"
            );
            Ok(())
        }
        Some(word) => bail!("say `times`, `linear`, `field` or `copies`, not `{word}`"),
    }
}

/// Puts the colors of one mesh onto another, and tells the seconds.
fn transferred(
    source: &Colored,
    target: &TriMesh,
    params: &TransferParams,
) -> Result<(Transferred, f64)> {
    let source = Source {
        mesh: &source.mesh,
        colors: Some(&source.colors),
        heights: None,
    };
    let start = Instant::now();
    let transferred = transfer(&source, target, None, params, &mut |_| {})?;
    Ok((transferred, start.elapsed().as_secs_f64()))
}

/// Pairs of vertices with the same numbers, spread over both meshes.
fn pairs(vertices: usize, count: usize) -> Vec<Pair> {
    let at = |i: usize| u32::try_from(i * vertices / count).unwrap_or(0);
    (0..count)
        .map(|i| Pair {
            source: at(i),
            targets: vec![at(i)],
        })
        .collect()
}

fn seconds(transferred: &Transferred, stage: &str) -> f64 {
    let stages = transferred.report.stages.iter();
    stages.filter(|s| s.stage == stage).map(|s| s.seconds).sum()
}

fn times(vertices: usize) -> Result<()> {
    let (source, target) = (ring(vertices, 3.0), ring(vertices, 5.0));
    let vertices = target.mesh.positions.len();
    // All but one: with the direction that is up there are 17 features, and 182 numbers to compare.
    let by_pairs = Shape::Affinities(pairs(vertices, 16));
    println!("{vertices} vertices; seconds; a round and a vote on the finest level");
    println!("| shape | rotations | hierarchy | shape | fans | round | vote | all |");
    println!("|---|---|---|---|---|---|---|---|");
    for (name, shape, rotations) in [
        ("correspondences", by_pairs.clone(), Rotations::All),
        ("correspondences", by_pairs, Rotations::Search),
        ("heat kernel", Shape::HeatKernel, Rotations::All),
        ("heat kernel", Shape::HeatKernel, Rotations::Search),
    ] {
        let params = TransferParams {
            shape,
            rotations,
            ..TransferParams::default()
        };
        let (transferred, all) = transferred(&source, &target.mesh, &params)?;
        let levels = &transferred.report.levels;
        // The levels' times are as their numbers of vertices.
        let vertices: usize = levels.iter().map(|level| level.vertices).sum();
        let share = levels[0].vertices as f64 / vertices as f64 / f64::from(params.rounds);
        let each = |stage| seconds(&transferred, stage) * share;
        println!(
            "| {name} | {rotations:?} | {:.2} | {:.2} | {:.2} | {:.3} | {:.3} | {all:.2} |",
            seconds(&transferred, "hierarchy"),
            seconds(&transferred, "shape"),
            seconds(&transferred, "fans"),
            each("search"),
            each("votes"),
        );
    }
    Ok(())
}

fn linear() -> Result<()> {
    println!("| vertices | shape | seconds | microseconds a vertex |");
    println!("|---|---|---|---|");
    for vertices in [8192, 32_768, 131_072, 524_288] {
        let (source, target) = (ring(vertices, 3.0), ring(vertices, 5.0));
        let vertices = target.mesh.positions.len();
        for (name, shape) in [
            ("correspondences", Shape::Affinities(pairs(vertices, 16))),
            ("heat kernel", Shape::HeatKernel),
        ] {
            let params = TransferParams {
                shape,
                ..TransferParams::default()
            };
            let (_, all) = transferred(&source, &target.mesh, &params)?;
            let each = 1e6 * all / vertices as f64;
            println!("| {vertices} | {name} | {all:.2} | {each:.1} |");
        }
    }
    Ok(())
}

fn field() -> Result<()> {
    println!("| meshes | rotations | coherence, overuse | mean cost | least | ratio | seconds |");
    println!("|---|---|---|---|---|---|---|");
    let mut cases = vec![(
        "rings".to_owned(),
        ring(8192, 3.0),
        ring(8192, 5.0).mesh,
        TransferParams::default().up,
    )];
    if let Some((zebra, horse)) = real("zebra_rgb.ply")?.zip(real_mesh("horse.ply")?) {
        let z = Some(nalgebra::Vector3::z());
        cases.push(("zebra, horse".to_owned(), zebra, horse, [z; 2]));
    }
    for (name, source, target, up) in cases {
        let target = with_vertices(&target, 8192);
        for rotations in [Rotations::All, Rotations::Search] {
            for (coherence, overuse) in [(0.0, 0.0), (0.3, 0.02)] {
                let params = TransferParams {
                    rotations,
                    coherence,
                    overuse,
                    up,
                    vertices: Some(8192),
                    audit: 8192,
                    ..TransferParams::default()
                };
                let (transferred, all) = transferred(&source, &target, &params)?;
                let Some(audit) = transferred.report.levels[0].audit else {
                    bail!("nothing was audited");
                };
                println!(
                    "| {name} | {rotations:?} | {coherence}, {overuse} | {:.4} | {:.4} | {:.3} | {:.2} |",
                    audit.mean_cost,
                    audit.least_cost,
                    audit.mean_cost / audit.least_cost,
                    all - seconds(&transferred, "audit"),
                );
            }
        }
    }
    Ok(())
}

fn copies() -> Result<()> {
    println!(
        "| mesh | onto | shape | final | vertices | mean color error of 255 | of nearest corners |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut meshes = vec![("ring".to_owned(), ring(16_384, 3.0))];
    for name in ["spot_rgb.ply", "zebra_rgb.ply"] {
        if let Some(mesh) = real(name)? {
            meshes.push((name.to_owned(), mesh));
        }
    }
    for (name, source) in &meshes {
        let other = copy(&source.mesh);
        for shape in [Shape::HeatKernel, Shape::Position] {
            for (onto, target) in [("itself", &source.mesh), ("a copy", &other.mesh)] {
                // Turned, places are others.
                if onto == "a copy" && shape == Shape::Position {
                    continue;
                }
                for last in [Last::Nearest, Last::Vote] {
                    let params = TransferParams {
                        shape: shape.clone(),
                        last,
                        ..TransferParams::default()
                    };
                    let (transferred, _) = transferred(source, target, &params)?;
                    let back = |p: &Point3<f64>| match onto {
                        "itself" => *p,
                        _ => other.back(p),
                    };
                    let [error, floor] = error(source, &transferred, back).map(|e| 255.0 * e);
                    let vertices = transferred.finer.mesh.positions.len();
                    println!(
                        "| {name} | {onto} | {shape:?} | {last:?} | {vertices} | {error:.2} | {floor:.2} |"
                    );
                }
            }
        }
    }
    Ok(())
}

/// A mesh with colors, if it is there.
fn real(name: &str) -> Result<Option<Colored>> {
    let path = Path::new(MESHES).join(name);
    if !path.is_file() {
        println!("SKIPPED: {} is not there", path.display());
        return Ok(None);
    }
    let scan = scan::read(&path, &ReadOptions::default())?;
    let Some(colors) = scan.colors() else {
        bail!("{name} has no colors");
    };
    Ok(Some(Colored {
        mesh: scan.mesh(),
        colors,
    }))
}

fn real_mesh(name: &str) -> Result<Option<TriMesh>> {
    let path = Path::new(MESHES).join(name);
    if !path.is_file() {
        return Ok(None);
    }
    Ok(Some(scan::read(&path, &ReadOptions::default())?.mesh()))
}

/// The same surface with about so many vertices.
fn with_vertices(mesh: &TriMesh, vertices: usize) -> TriMesh {
    if mesh.positions.len() <= vertices {
        return mesh.clone();
    }
    let (hierarchy, _) = relievo::transfer::Hierarchy::new(mesh, &[vertices]);
    hierarchy.levels[0].clone()
}
