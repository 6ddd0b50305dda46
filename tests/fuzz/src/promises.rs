use relievo::completion::{CompleteParams, Method, complete as run};
use relievo::mesh::{Adjacency, boundary_loops};
use relievo::repair::{RepairParams, repair};
use relievo::scan::{
    Column, Format, Intrinsics, ReadOptions, Scan, WriteOptions, read_from, write_to,
};

/// Whatever the bytes: an error, or a scan that keeps the rules, that can be repaired, and that comes back
/// from PLY as it is. No panic, and no memory beyond what the bytes justify.
pub fn read(format: Format, bytes: &[u8]) {
    let options = ReadOptions {
        intrinsics: Some(Intrinsics {
            fx: 500.0,
            fy: 500.0,
            cx: 3.0,
            cy: 2.0,
        }),
        ..ReadOptions::default()
    };
    let Ok(scan) = read_from(bytes, format, "file", &options) else {
        return;
    };
    if let Err(error) = scan.check("file") {
        panic!("a scan that was read breaks a rule: {error}");
    }
    for ascii in [false, true] {
        let mut written = Vec::new();
        write_to(
            &scan,
            &mut written,
            Format::Ply,
            &WriteOptions { ascii },
            "copy",
        )
        .expect("memory can be written to");
        let back = read_from(
            written.as_slice(),
            Format::Ply,
            "copy",
            &ReadOptions::default(),
        );
        let back = back.expect("what was written can be read");
        assert_eq!(back.positions(), scan.positions());
        assert_eq!(back.faces, scan.faces);
    }
    for format in [Format::Obj, Format::Off, Format::Stl, Format::Gltf] {
        // Some formats cannot hold every scan, which they may say.
        let _ = write_to(
            &scan,
            &mut Vec::new(),
            format,
            &WriteOptions::default(),
            "copy",
        );
    }
    let repaired = repair(scan.clone(), &RepairParams::default());
    assert_eq!(repaired.scan.positions(), scan.positions());
    let mesh = repaired.scan.mesh();
    let _ = boundary_loops(&mesh, &Adjacency::new(&mesh));
}

/// Whatever small mesh the bytes make: completion ends, with an error or with a scan that begins with the
/// original.
pub fn complete(bytes: &[u8]) {
    let mut bytes = bytes.iter().copied();
    let Some(scan) = small_scan(&mut bytes) else {
        return;
    };
    let choice = bytes.next().unwrap_or_default();
    let repaired = if choice & 1 == 0 {
        repair(scan, &RepairParams::default())
    } else {
        repair(scan, &RepairParams::NONE)
    };
    let params = CompleteParams {
        method: [Method::Coherent, Method::Exhaustive, Method::Paper][usize::from(choice >> 1) % 3],
        extend: choice & 8 != 0,
        rotations: Some(2),
        window: Some(2),
        sites: 64,
        ..CompleteParams::default()
    };
    let before = &repaired.scan;
    let Ok(completion) = run(before, &params, &mut |_| ()) else {
        return;
    };
    let after = completion.scan;
    if let Err(error) = after.check("completed") {
        panic!("a completed scan breaks a rule: {error}");
    }
    assert_eq!(
        after.positions()[..before.vertices.rows],
        before.positions()
    );
    assert!(after.faces.len() >= before.faces.len());
    for (after, before) in after.faces.rows().zip(before.faces.rows()) {
        assert_eq!(after, before);
    }
}

/// A sheet or a ball of some forty vertices with heights, gaps, and wrong faces as the bytes say.
fn small_scan(bytes: &mut impl Iterator<Item = u8>) -> Option<Scan> {
    let kind = bytes.next()?;
    let n = 4 + u32::from(kind >> 4) % 5;
    let mut points = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let (u, v) = (f64::from(i), f64::from(j));
            let height = f64::from(bytes.next().unwrap_or(128)) / 64.0 - 2.0;
            points.push(match kind % 4 {
                0 => [u, v, height * 0.2],
                1 => [u, v, height * 5.0],
                2 => {
                    let (a, b) = (u / f64::from(n - 1) * 2.8 - 1.4, v / f64::from(n) * 6.0);
                    let r = 5.0 + 0.2 * height;
                    [r * a.cos() * b.cos(), r * a.cos() * b.sin(), r * a.sin()]
                }
                _ => [
                    (v * 0.8).cos() * (3.0 + 0.2 * height),
                    (v * 0.8).sin() * 3.0,
                    u,
                ],
            });
        }
    }
    let mut faces = Vec::new();
    for i in 0..n - 1 {
        for j in 0..n - 1 {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(k, l)| (i + k) * n + j + l);
            // Four values in 256 leave a gap, a few make a wrong face.
            match bytes.next().unwrap_or(0) {
                0..=3 => {}
                4 => faces.push([a, a, c]),
                5 => faces.extend([[a, b, c], [a, b, c]]),
                6 => faces.extend([[a, c, b], [a, c, d]]),
                7 => faces.extend([[a, b, c], [a, c, d], [a, c, (a + 3) % (n * n)]]),
                8 => faces.push([a, b, (a * 7 + c) % (n * n)]),
                _ => faces.extend([[a, b, c], [a, c, d]]),
            }
        }
    }
    let mut scan = Scan::default();
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let values = points.iter().map(|p| p[k]).collect();
        scan.vertices.set_channel(axis, Column::F64(values));
    }
    if kind & 8 != 0 {
        for name in ["red", "green", "blue"] {
            let values = points.iter().map(|_| bytes.next().unwrap_or(7)).collect();
            scan.vertices.set_channel(name, Column::U8(values));
        }
    }
    for face in faces {
        scan.faces.push_row(&face);
    }
    Some(scan)
}
