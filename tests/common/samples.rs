//! Samples of texture, and meshes to put it on.

use std::f64::consts::TAU;
use std::fs;

use nalgebra::Point3;
use relievo::mesh::TriMesh;
use relievo::scan::{Column, Image, Scan, write_png};

use super::place::Place;

/// An image of colors from 0 to 1.
pub(crate) fn image(width: u32, height: u32, color: impl Fn(u32, u32) -> [f32; 3]) -> Image {
    let colors: Vec<[f32; 3]> = (0..width * height)
        .map(|i| color(i % width, i / width))
        .collect();
    Image {
        width,
        height,
        is_grey: colors
            .iter()
            .all(|[r, g, b]| r.to_bits() == g.to_bits() && g.to_bits() == b.to_bits()),
        colors,
        opaque: None,
        bits: 8,
    }
}

pub(crate) const RED: [u8; 3] = [221, 51, 34];
pub(crate) const BLUE: [u8; 3] = [17, 68, 204];

/// As intensities.
pub(crate) fn intensities(color: [u8; 3]) -> [f32; 3] {
    color.map(|value| f32::from(value) / 255.0)
}

/// 24 by 24 pixels, red and blue fields of 4 by 4.
pub(crate) fn checks() -> Image {
    image(24, 24, |x, y| {
        intensities(if (x / 4 + y / 4) % 2 == 0 { RED } else { BLUE })
    })
}

/// 24 by 24 pixels of waves, 8 pixels long, along the rows and down; green alone tells the columns.
pub(crate) fn waves() -> Image {
    #[expect(clippy::cast_possible_truncation, reason = "intensities are single")]
    let wave = |x: u32| (0.5 + 0.45 * (TAU * f64::from(x) / 8.0).cos()) as f32;
    image(24, 24, |x, y| [wave(x), wave(2 * x), wave(y)])
}

/// Writes an image into the folder.
pub(crate) fn put_image(place: &Place, name: &str, image: &Image) {
    let mut bytes = Vec::new();
    write_png(image, &mut bytes).expect("memory takes it");
    fs::write(place.path(name), bytes).expect("it can be written");
}

/// A chart of `columns` by `rows` cells, closed around itself where `around` says so.
fn chart(
    [columns, rows]: [u32; 2],
    around: [bool; 2],
    at: impl Fn(f64, f64) -> [f64; 3],
) -> TriMesh {
    let counts = [
        columns + u32::from(!around[0]),
        rows + u32::from(!around[1]),
    ];
    let number = |i: u32, j: u32| i % counts[0] + counts[0] * (j % counts[1]);
    let positions = (0..counts[0] * counts[1]).map(|v| {
        let [i, j] = [v % counts[0], v / counts[0]].map(f64::from);
        Point3::from(at(i / f64::from(columns), j / f64::from(rows)))
    });
    let triangles = (0..columns * rows).flat_map(|cell| {
        let (i, j) = (cell % columns, cell / columns);
        let [a, b] = [number(i, j), number(i + 1, j)];
        let [d, c] = [number(i, j + 1), number(i + 1, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriMesh {
        positions: positions.collect(),
        triangles: triangles.collect(),
    }
}

/// A flat open square of side 10, facing up.
pub(crate) fn square() -> TriMesh {
    chart([12, 12], [false, false], |u, v| [10.0 * u, 10.0 * v, 0.0])
}

/// A torus around the z axis, of radii 3 and 1.2.
pub(crate) fn torus() -> TriMesh {
    chart([36, 16], [true, true], |u, v| {
        let (u, v) = (TAU * u, TAU * v);
        let radius = 3.0 + 1.2 * v.cos();
        [radius * u.cos(), radius * u.sin(), 1.2 * v.sin()]
    })
}

/// A sphere of radius 2: an octahedron, each face cut in 4, three times.
pub(crate) fn sphere() -> TriMesh {
    let mut positions: Vec<[f64; 3]> = (0..6)
        .map(|i| {
            [0, 1, 2].map(|k| {
                if i % 3 != k {
                    0.0
                } else if i < 3 {
                    2.0
                } else {
                    -2.0
                }
            })
        })
        .collect();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    for _ in 0..3 {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let sum = [0, 1, 2].map(|k| positions[a as usize][k] + positions[b as usize][k]);
                let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
                positions.push(sum.map(|x| 2.0 * x / length));
                u32::try_from(positions.len() - 1).expect("few")
            })
        };
        triangles = (triangles.iter())
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    TriMesh {
        positions: positions.into_iter().map(Point3::from).collect(),
        triangles,
    }
}

/// Meshes as one.
pub(crate) fn together(parts: &[TriMesh]) -> TriMesh {
    let mut all = TriMesh::default();
    for part in parts {
        let first = u32::try_from(all.positions.len()).expect("few");
        all.positions.extend(&part.positions);
        all.triangles
            .extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

/// Gives a scan's vertices texture coordinates: x and y over 10, each vertex its own.
pub(crate) fn with_texture_coordinates(mut scan: Scan) -> Scan {
    for (k, name) in [(0, "s"), (1, "t")] {
        let values = scan.positions().iter().map(|p| p[k] / 10.0).collect();
        scan.vertices.set_channel(name, Column::F64(values));
    }
    scan
}

/// Colors of a scan's vertices, as bytes.
pub(crate) fn colors(scan: &Scan) -> Vec<[u8; 3]> {
    let columns = ["red", "green", "blue"].map(|name| match scan.vertices.column(name) {
        Some(Column::U8(values)) => values,
        other => panic!("{name} is {other:?}"),
    });
    (0..scan.vertices.rows)
        .map(|v| columns.map(|column| column[v]))
        .collect()
}

/// The pixel or vertex that each vertex of a textured PLY was copied from.
pub(crate) fn sources(scan: &Scan) -> Vec<usize> {
    match scan.vertices.column("source") {
        Some(Column::U32(values)) => values.iter().map(|s| *s as usize).collect(),
        other => panic!("source is {other:?}"),
    }
}

/// A color as bytes.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturating"
)]
pub(crate) fn bytes(color: [f32; 3]) -> [u8; 3] {
    color.map(|value| (255.0 * value).round() as u8)
}
