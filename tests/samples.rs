//! Small files that other programs wrote (`scripts/make_samples.py` says how): the same sheet in every
//! format.

use std::path::{Path, PathBuf};

use relievo::scan::{Intrinsics, ReadOptions, Scan, read};

/// Vertices along a side of the sheet.
const SIDE: usize = 6;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/samples")
        .join(name)
}

fn sample(name: &str) -> Scan {
    read(&file(name), &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// The number of the sheet's vertex at a place, which is checked to be there.
fn number(name: &str, p: &nalgebra::Point3<f64>) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to 5, or else the place is wrong, which is told below"
    )]
    let nearest = |x: f64| (x * 10.0).round() as usize;
    let i = nearest(p.y) * SIDE + nearest(p.x);
    let expected = [
        (i % SIDE) as f64 / 10.0,
        (i / SIDE) as f64 / 10.0,
        (i as f64).sin() / 50.0,
    ];
    for (found, expected) in p.iter().zip(expected) {
        assert!((found - expected).abs() < 2e-6, "{name}: vertex {i} at {p}");
    }
    i
}

/// Checks positions, the number of faces and, if there should be any, colours within `tolerance` of 255.
fn check(name: &str, faces: usize, tolerance: Option<f64>) -> Scan {
    let scan = sample(name);
    assert_eq!(scan.vertices.rows, SIDE * SIDE, "{name}");
    assert_eq!(scan.faces.len(), faces, "{name}");
    let colors = scan.colors();
    assert_eq!(colors.is_some(), tolerance.is_some(), "{name}: colours");
    let mut seen = [false; SIDE * SIDE];
    for (row, p) in scan.positions().iter().enumerate() {
        let i = number(name, p);
        seen[i] = true;
        let (Some(colors), Some(tolerance)) = (&colors, tolerance) else {
            continue;
        };
        let i = i as f64;
        let expected = [5.0 * i, 255.0 - 5.0 * i, 100.0 + i];
        for (found, expected) in colors[row].iter().zip(expected) {
            let difference = (255.0 * found - expected).abs();
            assert!(difference <= tolerance, "{name}: colours of vertex {row}");
        }
    }
    assert!(seen.iter().all(|seen| *seen), "{name}: every vertex once");
    for face in scan.faces.rows() {
        let corners = [0, 1, 2].map(|k| scan.positions()[face[k] as usize]);
        assert!(
            relievo::mesh::triangle_normal(corners).z > 0.0,
            "{name}: sides"
        );
    }
    scan
}

const EXACT: Option<f64> = Some(1e-6);
/// Of colours that were rounded twice.
const ROUNDED: Option<f64> = Some(1.01);

#[test]
fn meshes_come_with_their_faces_and_colors() {
    for name in [
        "ply/trimesh_binary.ply",
        "ply/trimesh_ascii.ply",
        "ply/open3d_binary.ply",
        "ply/open3d_ascii.ply",
        "ply/meshlab.ply",
        "ply/strips.ply",
    ] {
        check(name, 50, EXACT);
    }
    for name in [
        "obj/trimesh.obj",
        "obj/open3d.obj",
        "obj/meshlab.obj",
        "off/meshlab.off",
        "off/open3d.off",
    ] {
        check(name, 50, ROUNDED);
    }
    for name in [
        "off/trimesh.off",
        "stl/trimesh_binary.stl",
        "stl/trimesh_ascii.stl",
        "stl/open3d.stl",
        "stl/meshlab.stl",
    ] {
        check(name, 50, None);
    }
}

#[test]
fn gltf_comes_with_its_faces_and_colors() {
    check("gltf/trimesh.glb", 50, EXACT);
    check("gltf/open3d.glb", 50, ROUNDED);
    check("gltf/embedded.gltf", 50, None);
}

#[test]
fn points_come_with_their_colors() {
    check("ply/trimesh_points.ply", 0, EXACT);
    for name in ["xyz/numpy.txt", "xyz/numpy.csv"] {
        check(name, 0, EXACT);
    }
    check("xyz/open3d.pts", 0, ROUNDED);
    for name in ["xyz/open3d.xyz", "xyz/trimesh.xyz"] {
        check(name, 0, None);
    }
    for name in [
        "pcd/open3d_ascii.pcd",
        "pcd/open3d_binary.pcd",
        "pcd/open3d_compressed.pcd",
    ] {
        check(name, 0, ROUNDED);
    }
    let normals = check("pcd/open3d_normals.pcd", 0, ROUNDED);
    let nz = normals.vertices.column("nz").expect("it has normals");
    assert!((0..36).all(|row| nz.get_f64(row).is_some_and(|nz| nz > 0.9)));
}

#[test]
#[cfg(feature = "e57")]
fn e57_comes_with_its_colors_and_intensity() {
    let scan = check("e57/pye57.e57", 0, EXACT);
    let intensity = scan.vertices.column("intensity").expect("it has intensity");
    let value = intensity.get_f64(18).expect("a number");
    assert!((value - 0.5).abs() < 1e-6, "{value}");
}

#[test]
#[cfg(feature = "las")]
fn las_and_laz_come_with_their_colors_and_intensity() {
    for name in ["las/laspy12.las", "las/laspy14.las", "las/laspy.laz"] {
        let scan = check(name, 0, EXACT);
        let intensity = scan.vertices.column("intensity").expect("it has intensity");
        assert_eq!(intensity.get_f64(7), Some(700.0), "{name}");
    }
}

#[test]
fn a_range_grid_becomes_a_surface_that_faces_its_sensor() {
    let scan = check("ptx/grid.ptx", 50, EXACT);
    assert_eq!(scan.sensors.len(), 1);
    assert_eq!(
        scan.sensors[0].position,
        nalgebra::Point3::new(0.0, 0.0, 2.0)
    );
}

#[test]
#[cfg(feature = "image")]
fn depth_images_become_surfaces_in_front_of_their_camera() {
    let options = ReadOptions {
        intrinsics: Some(Intrinsics {
            fx: 100.0,
            fy: 100.0,
            cx: 2.5,
            cy: 2.5,
        }),
        ..ReadOptions::default()
    };
    for name in [
        "depth/pillow.png",
        "depth/tifffile.tif",
        "depth/tifffile16.tif",
    ] {
        let scan = read(&file(name), &options).unwrap_or_else(|error| panic!("{error}"));
        // One pixel has no depth, and takes four of its six triangles with it.
        assert_eq!(scan.vertices.rows, 35, "{name}");
        assert!(
            (44..=46).contains(&scan.faces.len()),
            "{name}: {}",
            scan.faces.len()
        );
        let p = scan.positions()[0];
        assert!(
            (p - nalgebra::Point3::new(-25.0, -25.0, 1000.0)).norm() < 1e-3,
            "{name}: {p}"
        );
        for face in scan.faces.rows() {
            let corners = [0, 1, 2].map(|k| scan.positions()[face[k] as usize]);
            assert!(
                relievo::mesh::triangle_normal(corners).z < 0.0,
                "{name}: sides"
            );
        }
    }
}
