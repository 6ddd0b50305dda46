//! Tests of the room as a whole: files in, files out.

use std::path::Path;

use proptest::prelude::*;

use super::*;
use crate::mesh;

const ASCII: &str = "ply\nformat ascii 1.0\ncomment made by hand\nobj_info a 1\n\
    element camera 1\nproperty double focal\n\
    element vertex 4\nproperty float x\nproperty double y\nproperty int z\nproperty char c\n\
    property uchar red\nproperty short s\nproperty ushort u\nproperty uint n\n\
    property list uchar short tags\n\
    element face 2\nproperty uchar kind\nproperty list uchar int vertex_indices\n\
    property list uint float uv\n\
    element marks 2\nproperty list ushort uint m\nend_header\n\
    0.5\n\
    0 0 0 -128 255 -32768 65535 4294967295 0\n1.5 0.1 -7 1 2 3 4 5 2 -1 1\n\
    1 1 0 0 0 0 0 0 1 9\n-0 1e-300 0 127 1 32767 0 0 0\n\
    3 3 0 1 2 2 0.5 -inf\n200 4 0 1 2 3 0\n\
    0\n2 7 8\n";

fn ply(bytes: &[u8]) -> Result<Scan, ScanError> {
    read_from(bytes, Format::Ply, "a.ply", &ReadOptions::default())
}

fn written(scan: &Scan, ascii: bool) -> Vec<u8> {
    let mut out = Vec::new();
    let options = WriteOptions { ascii };
    write_to(scan, &mut out, Format::Ply, &options, "out.ply").unwrap();
    out
}

/// The same scan in big endian, which relievo reads but does not write.
fn big_endian(scan: &Scan) -> Vec<u8> {
    let little = written(scan, false);
    let split = little
        .windows(11)
        .position(|w| w == b"end_header\n")
        .unwrap()
        + 11;
    let header = String::from_utf8(little[..split].to_vec()).unwrap();
    let mut out = header.replace("little", "big").into_bytes();
    let mut column = |c: &Column, row: usize| match c {
        Column::I8(v) => out.extend(v[row].to_be_bytes()),
        Column::U8(v) => out.extend(v[row].to_be_bytes()),
        Column::I16(v) => out.extend(v[row].to_be_bytes()),
        Column::U16(v) => out.extend(v[row].to_be_bytes()),
        Column::I32(v) => out.extend(v[row].to_be_bytes()),
        Column::U32(v) => out.extend(v[row].to_be_bytes()),
        Column::F32(v) => out.extend(v[row].to_be_bytes()),
        Column::F64(v) => out.extend(v[row].to_be_bytes()),
        Column::List(_) => unreachable!(),
    };
    let mut values = |table: &Table, row: usize| {
        for channel in &table.channels {
            if let Column::List(lists) = &channel.values {
                column(
                    &Column::U8(vec![u8::try_from(lists[row].len()).unwrap()]),
                    0,
                );
                (0..lists[row].len()).for_each(|i| column(&lists[row], i));
            } else {
                column(&channel.values, row);
            }
        }
    };
    (0..scan.vertices.rows).for_each(|row| values(&scan.vertices, row));
    for (row, face) in scan.faces.rows().enumerate() {
        let mut list = Table::default();
        list.set_channel("", Column::List(vec![Column::U32(face.to_vec())]));
        values(&list, 0);
        values(&scan.face_channels, row);
    }
    for (_, table) in &scan.other_elements {
        (0..table.rows).for_each(|row| values(table, row));
    }
    out
}

/// All values as text, floats by their bits: NaN is not equal to itself.
fn bits(scan: &Scan) -> String {
    let table = |table: &Table| -> String {
        let channels = table.channels.iter();
        let text = channels.map(|c| format!("{} {}\n", c.name, bits_of(&c.values)));
        format!("{} {}", table.rows, text.collect::<String>())
    };
    let others = scan.other_elements.iter();
    format!(
        "{}{:?}{}{}{:?}{:?}",
        table(&scan.vertices),
        scan.faces,
        table(&scan.face_channels),
        others
            .map(|(n, t)| format!("{n} {}", table(t)))
            .collect::<String>(),
        scan.comments,
        scan.obj_info
    )
}

fn bits_of(column: &Column) -> String {
    match column {
        Column::F32(v) => format!("{:x?}", v.iter().map(|v| v.to_bits()).collect::<Vec<_>>()),
        Column::F64(v) => format!("{:x?}", v.iter().map(|v| v.to_bits()).collect::<Vec<_>>()),
        Column::List(lists) => lists.iter().map(bits_of).collect(),
        other => format!("{other:?}"),
    }
}

#[test]
fn every_type_and_element_is_kept() {
    let scan = ply(ASCII.as_bytes()).unwrap();
    let names: Vec<&str> = scan
        .vertices
        .channels
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    assert_eq!(names, ["x", "y", "z", "c", "red", "s", "u", "n", "tags"]);
    let column = |name| scan.vertices.column(name).unwrap();
    assert_eq!(*column("x"), Column::F32(vec![0.0, 1.5, 1.0, -0.0]));
    assert_eq!(*column("y"), Column::F64(vec![0.0, 0.1, 1.0, 1e-300]));
    assert_eq!(*column("z"), Column::I32(vec![0, -7, 0, 0]));
    assert_eq!(*column("c"), Column::I8(vec![-128, 1, 0, 127]));
    assert_eq!(*column("s"), Column::I16(vec![-32768, 3, 0, 32767]));
    assert_eq!(*column("u"), Column::U16(vec![65535, 4, 0, 0]));
    assert_eq!(*column("n"), Column::U32(vec![u32::MAX, 5, 0, 0]));
    let lists: [&[i16]; 4] = [&[], &[-1, 1], &[9], &[]];
    assert_eq!(
        *column("tags"),
        Column::List(lists.map(|l| Column::I16(l.to_vec())).to_vec())
    );
    assert_eq!(scan.faces.row(1), [0, 1, 2, 3]);
    assert_eq!(
        scan.face_channels.column("kind"),
        Some(&Column::U8(vec![3, 200]))
    );
    assert_eq!(scan.face_channels.rows, 2);
    assert_eq!(scan.other_elements[0].0, "camera");
    assert_eq!(scan.other_elements[1].1.rows, 2);
    assert_eq!(scan.comments, ["made by hand"]);
    assert_eq!(scan.obj_info, ["a 1"]);
    assert_eq!(scan.positions()[1], Point3::new(1.5, 0.1, -7.0));
    assert_eq!(scan.triangles().len(), 3);
}

#[test]
fn the_three_encodings_agree() {
    let scan = ply(ASCII.as_bytes()).unwrap();
    for bytes in [
        written(&scan, true),
        written(&scan, false),
        big_endian(&scan),
    ] {
        assert_eq!(bits(&ply(&bytes).unwrap()), bits(&scan));
    }
}

#[test]
fn line_ends_and_blank_lines_do_not_matter() {
    let scan = ply(ASCII.as_bytes()).unwrap();
    for text in [
        ASCII.replace('\n', "\r\n"),
        ASCII.replace('\n', "\r"),
        ASCII
            .replace('\n', "\n\n  \n")
            .replacen("\n\n  \n", "\n", 1),
        ASCII.trim_end().to_owned(),
        ASCII.replace("vertex_indices", "vertex_index"),
        format!("{ASCII}\nmore that nobody asked for"),
    ] {
        assert_eq!(ply(text.as_bytes()).unwrap(), scan);
    }
}

#[test]
fn a_file_cut_anywhere_is_an_error_and_never_a_panic() {
    let scan = ply(ASCII.as_bytes()).unwrap();
    for bytes in [written(&scan, false), big_endian(&scan)] {
        for n in 0..bytes.len() {
            assert!(ply(&bytes[..n]).is_err(), "{n}");
        }
    }
    // In text, a number that is cut is still a number: only the last may be.
    for n in 0..ASCII.len() - 2 {
        assert!(ply(&ASCII.as_bytes()[..n]).is_err(), "{n}");
    }
    for (text, format) in [
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", Format::Off),
        (
            "v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 0 1 0 1 0 0\nf 1//1 -2/1 3/2/1\n",
            Format::Obj,
        ),
    ] {
        for n in 0..text.len() {
            let _ = read_from(&text.as_bytes()[..n], format, "a", &ReadOptions::default());
        }
    }
}

#[test]
fn a_cut_file_says_what_is_missing() {
    let scan = ply(ASCII.as_bytes()).unwrap();
    let mut bytes = written(&scan, false);
    bytes.truncate(bytes.len() - 20);
    let error = ply(&bytes).unwrap_err().to_string();
    assert!(
        error.contains("2 rows of `face`, but only 1 are there"),
        "{error}"
    );
    let error = ply(ASCII.split("1 1 0 0").next().unwrap().as_bytes())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("4 rows of `vertex`, but only 2 are there"),
        "{error}"
    );
}

#[test]
fn counts_of_the_header_are_not_trusted() {
    for count in ["4000000000", "18446744073709551615"] {
        for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
            for properties in ["property float x", "property list uint double x"] {
                let text = format!(
                    "ply\nformat {encoding} 1.0\nelement vertex {count}\n{properties}\nend_header\n1 \n"
                );
                let error = ply(text.as_bytes()).unwrap_err();
                assert!(matches!(error, ScanError::Truncated { .. }), "{error}");
            }
            let text = format!("ply\nformat {encoding} 1.0\nelement vertex {count}\nend_header\n");
            let error = ply(text.as_bytes()).unwrap_err();
            assert!(
                matches!(error, ScanError::MissingCoordinate { .. }),
                "{error}"
            );
        }
    }
    for count in ["-1", "18446744073709551616", "1e3", "x"] {
        let text = format!("ply\nformat ascii 1.0\nelement vertex {count}\nend_header\n");
        let error = ply(text.as_bytes()).unwrap_err();
        assert!(
            matches!(error, ScanError::Header { line: 3, .. }),
            "{error}"
        );
    }
    // A list that claims to be longer than the file.
    let text = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n\
                property list uint double x\nend_header\n\u{7f}\u{7f}\u{7f}\u{7f}abc";
    let error = ply(text.as_bytes()).unwrap_err();
    assert!(
        matches!(error, ScanError::Truncated { found: 0, .. }),
        "{error}"
    );
}

#[test]
fn rows_that_break_the_rules_are_named() {
    let vertices = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                    property uchar z\n";
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    let file = |faces: &str, body: &str| format!("{vertices}{faces}end_header\n{body}\n");
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    for (text, part) in [
        (
            file("", "0 0 0\n0 0\n0 0 0"),
            "row 1 (from 0) of `vertex`: it has too few values",
        ),
        (file("", "0 0 0\n0 x 0\n0 0 0"), "`x` is not a value"),
        (file("", "0 0 0\n0 0 256\n0 0 0"), "`256` is not a value"),
        (
            file("", "0 0 0\n0 nan 0\n0 0 0"),
            "coordinate y of vertex 1",
        ),
        (
            file("", "0 0 0\n0 0 0\n-inf 0 0"),
            "coordinate x of vertex 2",
        ),
        (
            file(faces, &format!("{points}3 0 1 3")),
            "face 0 (from 0) refers to vertex 3",
        ),
        (
            file(faces, &format!("{points}3 0 -1 2")),
            "-1 is not an index",
        ),
        (file(faces, &format!("{points}2 0 1")), "only 2 vertices"),
        (
            file("element face 1\nproperty uchar a\n", &format!("{points}3")),
            "no list `vertex_indices`",
        ),
        (
            file(
                "element face 1\nproperty int vertex_indices\n",
                &format!("{points}0"),
            ),
            "no list `vertex_indices`",
        ),
        (
            vertices.replace('3', "0") + "end_header\n",
            "holds no vertices",
        ),
        (
            "ply\nformat ascii 1.0\nend_header\n".to_owned(),
            "holds no vertices",
        ),
        (
            vertices.replace("float y", "list uchar float y") + "end_header\n0 0 0\n0 0 0\n0 0 0\n",
            "no number `y`",
        ),
    ] {
        let error = ply(text.as_bytes()).unwrap_err().to_string();
        assert!(
            error.starts_with("a.ply") && error.contains(part),
            "{part}: {error}"
        );
    }
}

#[test]
fn nan_payloads_survive_in_other_channels() {
    let mut scan = ply(ASCII.as_bytes()).unwrap();
    let odd = [0x7fc0_dead, 0xff80_0001, 0x7f80_0000, 1].map(f32::from_bits);
    scan.vertices.set_channel("odd", Column::F32(odd.to_vec()));
    for bytes in [written(&scan, false), big_endian(&scan)] {
        assert_eq!(bits(&ply(&bytes).unwrap()), bits(&scan));
    }
    let text = ply(&written(&scan, true)).unwrap();
    let values = text.vertices.column("odd").unwrap();
    assert!(values.get_f64(0).unwrap().is_nan());
    assert_eq!(values.get_f64(2), Some(f64::INFINITY));
    assert_eq!(values.get_f64(3), Some(f64::from(odd[3])));
}

#[test]
fn long_lists_change_the_type_of_their_count() {
    let mut scan = ply(ASCII.as_bytes()).unwrap();
    let polygon: Vec<u32> = (0..300).map(|i| i % 4).collect();
    scan.faces.push_row(&polygon);
    scan.face_channels = Table::default();
    scan.other_elements[1].1 = Table::default();
    let marks = vec![Column::U8(vec![7; 70_000]), Column::U8(vec![])];
    scan.other_elements[1]
        .1
        .set_channel("m", Column::List(marks));
    for ascii in [true, false] {
        assert_eq!(ply(&written(&scan, ascii)).unwrap(), scan);
    }
}

#[test]
fn repeated_vertices_stay_in_faces_but_not_in_the_mesh() {
    let mut scan = ply(ASCII.as_bytes()).unwrap();
    scan.face_channels = Table::default();
    scan.faces.push_row(&[0, 0, 1]);
    assert_eq!(scan.triangles().len(), 4);
    assert_eq!(scan.mesh().triangles.len(), 3);
}

#[test]
fn paths_choose_the_format_and_bad_ones_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut scan = Scan::default();
    for (axis, values) in [
        ("x", [0.0, 1.0, 0.0]),
        ("y", [0.0, 0.0, 1.0]),
        ("z", [0.5; 3]),
    ] {
        scan.vertices
            .set_channel(axis, Column::F64(values.to_vec()));
    }
    scan.faces.push_row(&[0, 1, 2]);
    let options = WriteOptions::default();
    for name in ["a.ply", "a.PLY", "a.obj", "a.STL"] {
        write(&scan, &path(name), &options).unwrap();
        let back = read(&path(name), &ReadOptions::default()).unwrap();
        assert_eq!(back.mesh(), scan.mesh(), "{name}");
    }
    std::fs::copy(path("a.ply"), path("ply_without_extension")).unwrap();
    assert_eq!(
        read(&path("ply_without_extension"), &ReadOptions::default()).unwrap(),
        scan
    );
    std::fs::write(path("columns"), "0 0 0\n1 0 2\n").unwrap();
    let columns = read(&path("columns"), &ReadOptions::default()).unwrap();
    assert_eq!(columns.vertices.rows, 2);
    std::fs::write(path("a.docx"), "Dear Sir\n").unwrap();
    let error = read(&path("a.docx"), &ReadOptions::default()).unwrap_err();
    assert!(matches!(error, ScanError::UnknownFormat { .. }), "{error}");
    let error = read(&path("none.ply"), &ReadOptions::default()).unwrap_err();
    assert!(matches!(error, ScanError::NotFound { .. }), "{error}");
    let error = read(folder.path(), &ReadOptions::default()).unwrap_err();
    assert!(matches!(error, ScanError::IsFolder { .. }), "{error}");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("/dev/zero", path("endless.ply")).unwrap();
        let error = read(&path("endless.ply"), &ReadOptions::default()).unwrap_err();
        assert!(matches!(error, ScanError::IsDevice { .. }), "{error}");
        std::fs::remove_file(path("endless.ply")).unwrap();
    }
    let before = std::fs::read_dir(folder.path()).unwrap().count();
    for (name, part) in [
        ("b.xyz", "cannot write this format"),
        ("b.xyz", ".ply"),
        ("no/b.ply", "no folder"),
    ] {
        let error = write(&scan, &path(name), &options).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), before);
}

#[test]
fn the_same_scan_gives_the_same_bytes() {
    let scan = ply(ASCII.as_bytes()).unwrap();
    for ascii in [true, false] {
        assert_eq!(written(&scan, ascii), written(&scan, ascii));
    }
}

/// A real file, or `None` with a word on standard output.
fn real(file: &str) -> Option<Scan> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/data")
        .join(file);
    if !path.exists() {
        println!("skipped: there is no ../shared/data/{file}");
        return None;
    }
    Some(read(&path, &ReadOptions::default()).unwrap())
}

#[test]
fn real_range_grids_have_about_as_many_triangles_as_others_make() {
    for (file, vertices, faces) in [
        ("scans/bun000.ply", 40256, 78574.0),
        ("scans/limestone_V21_grid.ply", 61230, 120_333.0),
        ("scans/pumpA_grid.ply", 155_201, 286_534.0),
    ] {
        let Some(scan) = real(file) else { continue };
        assert_eq!(scan.vertices.rows, vertices);
        let ratio = scan.faces.len() as f64 / faces;
        println!(
            "{file}: {} triangles, {:+.2} %",
            scan.faces.len(),
            100.0 * (ratio - 1.0)
        );
        assert!((ratio - 1.0).abs() < 0.01, "{file}: {}", scan.faces.len());
        assert_eq!(mesh::check(&scan.mesh()), Ok(()), "{file}");
        assert_eq!(bits(&ply(&written(&scan, false)).unwrap()), bits(&scan));
    }
}

#[test]
fn real_files_have_the_counts_that_others_find() {
    for (file, vertices, faces) in [
        ("scans/lato000.ply", 44461, 86766),
        ("scans/otira_gravel_xyz.ply", 100_769, 0),
        ("holes/tower_holes.obj", 49291, 97374),
        ("holes/bottle_hole.obj", 22478, 44679),
        ("holes/mech-holes-shark.off", 5246, 10192),
        ("holes/bun_zipper.ply", 35947, 69451),
        ("holes/many_small_holes.ply", 2004, 3524),
        ("relief/scallop_shell_rgb.ply", 7575, 14852),
        ("transfer/horse.ply", 48485, 96966),
        ("transfer/zebra.obj", 20157, 40310),
        ("transfer/camel.off", 9770, 19536),
    ] {
        let Some(scan) = real(file) else { continue };
        assert_eq!(
            (scan.vertices.rows, scan.faces.len()),
            (vertices, faces),
            "{file}"
        );
        for ascii in [true, false] {
            assert_eq!(
                bits(&ply(&written(&scan, ascii)).unwrap()),
                bits(&scan),
                "{file}"
            );
        }
    }
}

prop_compose! {
    fn any_scan()(rows in 1..6usize)(
        x in prop::collection::vec(-1e30f64..1e30, rows),
        y in prop::collection::vec(-1e30f32..1e30, rows),
        z in prop::collection::vec(any::<i32>(), rows),
        a in prop::collection::vec(any::<u32>(), rows),
        b in prop::collection::vec(any::<u64>(), rows),
        lists in prop::collection::vec(prop::collection::vec(any::<u16>(), 0..4), rows),
        faces in prop::collection::vec(prop::collection::vec(0..u32::try_from(rows).unwrap(), 3..6), 0..4),
        flags in prop::collection::vec(any::<i8>(), 4),
        comment in "[ -~]{0,20}",
    ) -> Scan {
        let mut scan = Scan { comments: vec![comment.trim_end().to_owned()], ..Scan::default() };
        let vertices = &mut scan.vertices;
        vertices.set_channel("x", Column::F64(x));
        vertices.set_channel("f", Column::F32(a.iter().copied().map(f32::from_bits).collect()));
        vertices.set_channel("y", Column::F32(y));
        vertices.set_channel("d", Column::F64(b.iter().copied().map(f64::from_bits).collect()));
        vertices.set_channel("z", Column::I32(z));
        vertices.set_channel("u", Column::U32(a));
        vertices.set_channel("l", Column::List(lists.into_iter().map(Column::U16).collect()));
        for face in &faces {
            scan.faces.push_row(face);
        }
        if !faces.is_empty() {
            scan.face_channels.set_channel("flag", Column::I8(flags[..faces.len()].to_vec()));
        }
        let mut table = Table::default();
        table.set_channel("n", Column::U8(vec![1, 2]));
        scan.other_elements.push(("more".to_owned(), table));
        scan
    }
}

/// NaN has one spelling in text.
fn plain_nans(mut scan: Scan) -> Scan {
    for channel in &mut scan.vertices.channels {
        match &mut channel.values {
            Column::F32(v) => v
                .iter_mut()
                .filter(|v| v.is_nan())
                .for_each(|v| *v = f32::NAN),
            Column::F64(v) => v
                .iter_mut()
                .filter(|v| v.is_nan())
                .for_each(|v| *v = f64::NAN),
            _ => {}
        }
    }
    scan
}

proptest! {
    #[test]
    fn binary_comes_back_bit_by_bit_and_text_value_by_value(scan in any_scan()) {
        prop_assert_eq!(bits(&ply(&written(&scan, false)).unwrap()), bits(&scan));
        prop_assert_eq!(bits(&ply(&big_endian(&scan)).unwrap()), bits(&scan));
        let text = ply(&written(&scan, true)).unwrap();
        prop_assert_eq!(bits(&plain_nans(text)), bits(&plain_nans(scan)));
    }

    #[test]
    fn a_changed_byte_never_panics(at in 0..ASCII.len(), byte in any::<u8>(), binary in any::<bool>()) {
        let mut bytes = ASCII.as_bytes().to_vec();
        if binary {
            bytes = written(&ply(&bytes).unwrap(), false);
        }
        let at = at % bytes.len();
        bytes[at] = byte;
        for format in [Format::Ply, Format::Obj, Format::Off, Format::Stl] {
            if let Ok(scan) = read_from(bytes.as_slice(), format, "a", &ReadOptions::default()) {
                prop_assert!(scan.check("a").is_ok());
                let _ = scan.mesh();
            }
        }
    }
}
