//! Our own syntheses: on a flat square for comparison with those of images, on a sphere for their times.

use std::path::Path;

use anyhow::{Context, Result};
use nalgebra::{Point3, Vector3};
use relievo::mesh::TriMesh;
use relievo::rng::{Rng, Stage};
use relievo::scan::{Image, read_image, write_png};
use relievo::texture::{
    Density, Method, Orientation, Sample, Search, TextureParams, Textured, synthesize,
};

/// Side of the square in pixels, as the images of the other program have.
const SIDE: u16 = 192;

/// A flat square with a vertex a pixel: what is compared then is the growth alone.
fn grid() -> TriMesh {
    let side = u32::from(SIDE);
    let at = |i: u32| [i % side, i / side];
    TriMesh {
        positions: (0..side * side)
            .map(|i| Point3::new(f64::from(at(i)[0]), -f64::from(at(i)[1]), 0.0))
            .collect(),
        triangles: (0..side * side)
            .filter(|i| at(*i).iter().all(|x| x + 1 < side))
            .flat_map(|i| {
                let [a, b, c, d] = [i, i + 1, i + side, i + side + 1];
                if at(i).iter().sum::<u32>().is_multiple_of(2) {
                    [[a, c, b], [b, c, d]]
                } else {
                    [[a, d, b], [a, c, d]]
                }
            })
            .collect(),
    }
}

/// The same square of two triangles.
fn two_triangles() -> TriMesh {
    let side = f64::from(SIDE) - 1.0;
    let corners = [[0.0, 0.0], [side, 0.0], [0.0, -side], [side, -side]];
    TriMesh {
        positions: corners.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec(),
        triangles: vec![[0, 2, 1], [1, 2, 3]],
    }
}

/// Writes what comes of a sample on a flat square into a folder each: `coherent` and `wei-levoy` with a vertex a pixel, and
/// `retiled` by the default method on evenly spread vertices, read at the pixels between them.
pub(crate) fn flat(sample: &Path, folder: &Path, seed: u32) -> Result<()> {
    let name = sample.file_name().context("a sample has a name")?;
    let sample = Sample::of_image(&read_image(sample)?);
    let runs = [
        ("coherent", Method::Coherent, grid()),
        ("wei-levoy", Method::WeiLevoy, grid()),
        ("retiled", Method::Coherent, two_triangles()),
    ];
    for (into, method, mesh) in runs {
        let params = TextureParams {
            density: Density::Vertices(usize::from(SIDE) * usize::from(SIDE)),
            orientation: Orientation::Along(Vector3::x()),
            method,
            seed,
            ..TextureParams::default()
        };
        let textured = synthesize(&mesh, &sample, &params, &mut |_| {})?;
        let folder = folder.join(into);
        std::fs::create_dir_all(&folder)?;
        let mut file = std::fs::File::create(folder.join(name))?;
        write_png(&seen_from_above(&textured), &mut file)?;
    }
    Ok(())
}

/// The texture at the pixels of the square.
fn seen_from_above(textured: &Textured) -> Image {
    let lookup = textured.lookup();
    let pixel = |x: u16, y: u16| {
        let point = Point3::new(f64::from(x), -f64::from(y), 0.0);
        lookup.color(&point, None).unwrap_or_default()
    };
    #[expect(clippy::cast_possible_truncation, reason = "pixels are single")]
    let colors: Vec<[f32; 3]> = (0..SIDE)
        .flat_map(|y| (0..SIDE).map(move |x| (x, y)))
        .map(|(x, y)| pixel(x, y).map(|value| value as f32))
        .collect();
    Image {
        width: u32::from(SIDE),
        height: u32::from(SIDE),
        is_grey: colors
            .iter()
            .all(|[r, g, b]| r.to_bits() == g.to_bits() && g.to_bits() == b.to_bits()),
        colors,
        opaque: None,
        bits: 8,
    }
}

/// A sphere of latitudes and longitudes: retiling makes it even.
fn sphere() -> TriMesh {
    let (rings, around) = (100u32, 200u32);
    let index = |ring: u32, i: u32| 1 + (ring - 1) * around + i % around;
    let angles = |ring: u32, i: u32| {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        (
            polar,
            std::f64::consts::TAU * f64::from(i) / f64::from(around),
        )
    };
    let mut mesh = TriMesh::default();
    mesh.positions.push(Point3::new(0.0, 0.0, 1.0));
    for ring in 1..rings {
        for i in 0..around {
            let (polar, angle) = angles(ring, i);
            let (sin, cos) = polar.sin_cos();
            mesh.positions
                .push(Point3::new(sin * angle.cos(), sin * angle.sin(), cos));
        }
    }
    let last = 1 + (rings - 1) * around;
    mesh.positions.push(Point3::new(0.0, 0.0, -1.0));
    for i in 0..around {
        mesh.triangles.push([0, index(1, i), index(1, i + 1)]);
        mesh.triangles
            .push([last, index(rings - 1, i + 1), index(rings - 1, i)]);
        for ring in 1..rings - 1 {
            let [a, b] = [index(ring, i), index(ring, i + 1)];
            let [c, d] = [index(ring + 1, i), index(ring + 1, i + 1)];
            mesh.triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    mesh
}

/// A sample of 64 by 64 colors, as many of them as in a photograph: noise smoothed over a few pixels.
fn noise() -> Image {
    const SIDE: usize = 64;
    let mut rng = Rng::new(1, Stage::Texture, 0);
    let white: Vec<f64> = (0..SIDE * SIDE * 3).map(|_| rng.normal()).collect();
    let smoothed = |x: usize, y: usize, k: usize| {
        let around = (0..5).flat_map(|dy| (0..5).map(move |dx| (dx, dy)));
        around
            .map(|(dx, dy)| white[3 * ((y + dy) % SIDE * SIDE + (x + dx) % SIDE) + k])
            .sum::<f64>()
    };
    #[expect(clippy::cast_possible_truncation, reason = "pixels are single")]
    let colors = (0..SIDE * SIDE)
        .map(|i| {
            [0, 1, 2].map(|k| (0.5 + 0.03 * smoothed(i % SIDE, i / SIDE, k)).clamp(0.0, 1.0) as f32)
        })
        .collect();
    Image {
        width: 64,
        height: 64,
        colors,
        opaque: None,
        is_grey: false,
        bits: 16,
    }
}

/// Times of the paper's sphere and of one ten times as dense, seconds by stage: what is read from `image` or, without
/// one, from noise.
pub(crate) fn times(image: Option<&Path>) -> Result<()> {
    let sample = match image {
        Some(path) => read_image(path)?,
        None => noise(),
    };
    let sample = Sample::of_image(&sample);
    let mesh = sphere();
    println!("| run | vertices | retiling | directions | neighborhoods | texture | all |");
    println!("|---|---|---|---|---|---|---|");
    for (name, vertices, method, search) in [
        (
            "wei-levoy, exhaustive",
            24_576,
            Method::WeiLevoy,
            Search::Exhaustive,
        ),
        ("wei-levoy, tree", 24_576, Method::WeiLevoy, Search::Tree),
        ("coherent", 24_576, Method::Coherent, Search::Tree),
        ("wei-levoy, tree", 262_144, Method::WeiLevoy, Search::Tree),
        ("coherent", 262_144, Method::Coherent, Search::Tree),
    ] {
        let params = TextureParams {
            density: Density::Vertices(vertices),
            method,
            search,
            ..TextureParams::default()
        };
        let textured = synthesize(&mesh, &sample, &params, &mut |_| {})?;
        let seconds = |stage: &str| {
            let stages = textured.report.stages.iter();
            stages
                .filter(|s| s.stage == stage)
                .map(|s| s.seconds)
                .sum::<f64>()
        };
        let neighborhoods = seconds("sample") + seconds("neighborhoods");
        let all = [
            seconds("retiling"),
            seconds("directions"),
            neighborhoods,
            seconds("texture"),
        ];
        let cells = all.map(|s| format!("{s:.2}")).join(" | ");
        println!(
            "| {name} | {vertices} | {cells} | {:.2} |",
            all.iter().sum::<f64>()
        );
    }
    Ok(())
}

/// Mean color difference over the edges that cross the meridian at which the input's latitudes begin and end, and over
/// all others: one line of the table.
pub(crate) fn seam(sample: &Path) -> Result<()> {
    let name = sample.file_stem().context("a sample has a name")?;
    let texture = Sample::of_image(&read_image(sample)?);
    let textured = synthesize(&sphere(), &texture, &TextureParams::default(), &mut |_| {})?;
    let colors = textured.colors.as_ref().context("images have colors")?;
    let mut sums = [[0.0; 2]; 2];
    for [a, b] in relievo::mesh::edges(&textured.mesh) {
        let [p, q] = [a, b].map(|v| textured.mesh.positions[v as usize]);
        let crosses = p.x > 0.0 && q.x > 0.0 && (p.y < 0.0) != (q.y < 0.0);
        let [one, other] = [a, b].map(|v| colors[v as usize]);
        let difference: f64 = one
            .iter()
            .zip(other)
            .map(|(x, y)| (x - y).abs())
            .sum::<f64>()
            / 3.0;
        let [sum, count] = &mut sums[usize::from(crosses)];
        *sum += difference;
        *count += 1.0;
    }
    let [inside, across] = sums.map(|[sum, count]| sum / f64::max(count, 1.0));
    println!(
        "| {} | {across:.4} | {inside:.4} | {:.3} |",
        name.display(),
        across / inside
    );
    Ok(())
}
