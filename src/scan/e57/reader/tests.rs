use ::e57::{E57Writer, Quaternion, Record, RecordName, RecordValue, Transform, Translation};

use super::*;
use crate::scan::ReadOptions;
use crate::scan::testing::{damaged, source, truncated};

fn parsed(bytes: &[u8]) -> Result<Parsed, ScanError> {
    read(&source(bytes, &ReadOptions::default()))
}

fn integer(name: RecordName, min: i64, max: i64) -> Record {
    Record {
        name,
        data_type: RecordDataType::Integer { min, max },
    }
}

/// A grid of two rows and three columns of which one point is missing, turned about z by 90 degrees
/// and moved; and, if asked for, a second scan of two points without all that.
fn file(with_second: bool) -> Vec<u8> {
    file_with(with_second, |xml| xml)
}

/// The same with another XML part.
fn file_with(with_second: bool, change: impl Fn(String) -> String) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = E57Writer::new(&mut bytes, "file").unwrap();
    let prototype = vec![
        Record::CARTESIAN_X_F64,
        Record::CARTESIAN_Y_F64,
        Record::CARTESIAN_Z_F64,
        Record::CARTESIAN_INVALID_STATE,
        Record::COLOR_RED_U8,
        Record::COLOR_GREEN_U8,
        Record::COLOR_BLUE_U8,
        Record::INTENSITY_U16,
        integer(RecordName::RowIndex, 0, 10),
        integer(RecordName::ColumnIndex, 0, 10),
    ];
    let mut cloud = writer.add_pointcloud("first", prototype).unwrap();
    cloud.set_transform(Some(Transform {
        rotation: Quaternion {
            w: 0.5_f64.sqrt(),
            x: 0.0,
            y: 0.0,
            z: 0.5_f64.sqrt(),
        },
        translation: Translation {
            x: 10.0,
            y: 20.0,
            z: 30.0,
        },
    }));
    for k in 0..6_i64 {
        let (row, column) = (k / 3, k % 3);
        let mut values = vec![
            RecordValue::Double(column as f64),
            RecordValue::Double(row as f64),
            RecordValue::Double(-5.0),
        ];
        let state = if k == 4 { 2 } else { 0 };
        for value in [state, 255, k, 0, 1000 * k, row + 4, column + 5] {
            values.push(RecordValue::Integer(value));
        }
        cloud.add_point(values).unwrap();
    }
    cloud.finalize().unwrap();
    if with_second {
        let prototype = vec![
            Record::SPHERICAL_RANGE_F64,
            Record::SPHERICAL_AZIMUTH_F64,
            Record::SPHERICAL_ELEVATION_F64,
        ];
        let mut cloud = writer.add_pointcloud("second", prototype).unwrap();
        for azimuth in [0.0, std::f64::consts::FRAC_PI_2] {
            let values = [2.0, azimuth, std::f64::consts::FRAC_PI_6];
            let values = values.map(RecordValue::Double).to_vec();
            cloud.add_point(values).unwrap();
        }
        cloud.finalize().unwrap();
    }
    writer
        .finalize_customized_xml(|xml| Ok(change(xml)))
        .unwrap();
    drop(writer);
    bytes.into_inner()
}

/// Gives each page the checksum of its bytes (CRC-32C), so that damage is not found by it.
fn sealed(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for page in bytes.chunks_exact_mut(1024) {
        let (data, checksum) = page.split_at_mut(1020);
        let mut crc = u32::MAX;
        for byte in data {
            crc ^= u32::from(*byte);
            for _ in 0..8 {
                crc = (crc >> 1) ^ (0x82f6_3b78 & (crc & 1).wrapping_neg());
            }
        }
        checksum.copy_from_slice(&(!crc).to_be_bytes());
    }
    bytes
}

#[test]
fn points_are_placed_with_colors_intensities_and_grid() {
    let Parsed { scan, grids } = parsed(&file(false)).unwrap();
    let names: Vec<&str> = scan.vertices.channels.iter().map(|c| &*c.name).collect();
    assert_eq!(names, ["x", "y", "z", "red", "green", "blue", "intensity"]);
    // The point (2, 1, -5) turned and moved.
    let last = scan.positions()[4];
    assert!(
        (last - Point3::new(9.0, 22.0, 25.0)).norm() < 1e-12,
        "{last}"
    );
    let column = |name| scan.vertices.column(name).unwrap();
    assert_eq!(*column("red"), Column::U8(vec![255; 5]));
    assert_eq!(*column("green"), Column::U8(vec![0, 1, 2, 3, 5]));
    assert_eq!(
        *column("intensity"),
        Column::F64(vec![0.0, 1000.0, 2000.0, 3000.0, 5000.0])
    );
    let cells = [Some(0), Some(1), Some(2), Some(3), None, Some(4)];
    assert_eq!((grids[0].columns, &grids[0].cells[..]), (3, &cells[..]));
    assert_eq!(grids[0].sensor, Some(Point3::new(10.0, 20.0, 30.0)));
    assert_eq!(scan.sensors[0].position, Point3::new(10.0, 20.0, 30.0));
}

#[test]
fn several_scans_come_together_and_keep_what_all_have() {
    let Parsed { scan, grids } = parsed(&file(true)).unwrap();
    let names: Vec<&str> = scan.vertices.channels.iter().map(|c| &*c.name).collect();
    assert_eq!(names, ["x", "y", "z", "scan"]);
    assert_eq!(
        scan.vertices.column("scan"),
        Some(&Column::U16(vec![0, 0, 0, 0, 0, 1, 1]))
    );
    let positions = scan.positions();
    let range = 3.0_f64.sqrt();
    assert!((positions[5] - Point3::new(range, 0.0, 1.0)).norm() < 1e-12);
    assert!((positions[6] - Point3::new(0.0, range, 1.0)).norm() < 1e-12);
    assert_eq!((grids.len(), scan.sensors.len()), (1, 1));
}

#[test]
fn claims_that_the_file_cannot_hold_are_refused() {
    let row_index = "<rowIndex type=\"Integer\" minimum=\"0\" maximum=\"10\">";
    for (from, to, part) in [
        (
            "recordCount=\"6\"",
            "recordCount=\"99999999999999\"",
            "promises more points",
        ),
        (
            "recordCount=\"6\"",
            "recordCount=\"7\"",
            "it is damaged or cut off",
        ),
        (
            "maximum=\"255\"",
            "maximum=\"-1\"",
            "it is damaged or cut off",
        ),
        (
            row_index,
            &format!("{}{row_index}", "<other type=\"Float\"/>".repeat(60)),
            "more than the 64 properties",
        ),
        (
            " type=\"Float\"",
            " type=\"Integer\" minimum=\"1\" maximum=\"1\"",
            "all its points are the same",
        ),
    ] {
        let changed = file_with(false, |xml| {
            assert!(xml.contains(from), "{xml}");
            match part {
                "all its points are the same" => ["X", "Y", "Z"]
                    .iter()
                    .fold(xml, |xml, axis| {
                        let tag = format!("<cartesian{axis}");
                        xml.replace(&format!("{tag}{from}"), &format!("{tag}{to}"))
                    })
                    .replace("maximum=\"255\"", "maximum=\"0\"")
                    .replace("maximum=\"65535\"", "maximum=\"0\"")
                    .replace("maximum=\"10\"", "maximum=\"0\"")
                    .replace("maximum=\"2\"", "maximum=\"0\""),
                _ => xml.replacen(from, to, 1),
            }
        });
        let error = parsed(&changed).unwrap_err().to_string();
        assert!(error.contains(part), "{to}: {error}");
    }
    let file = file(false);
    let mut long_xml = file.clone();
    long_xml[32..40].copy_from_slice(&50_000_000_u64.to_le_bytes());
    let error = parsed(&long_xml).unwrap_err().to_string();
    assert!(error.contains("XML part is longer"), "{error}");
}

#[test]
fn whatever_the_bytes_there_is_a_scan_or_an_error() {
    let file = file(true);
    truncated(&file, parsed);
    damaged(&file, parsed);
    damaged(&file, |bytes| parsed(&sealed(bytes)));
}
