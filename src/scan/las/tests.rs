use super::super::testing::{damaged, source, truncated};
use super::*;
use crate::scan::ReadOptions;

fn scan(bytes: &[u8]) -> Result<Scan, ScanError> {
    read(&source(bytes, &ReadOptions::default()))
}

/// The points (k, 2k, -k) steps with values that tell them apart, of the given format.
fn points(format: u8) -> Vec<Vec<u8>> {
    let color_at = match format {
        2 => Some(20),
        3 => Some(28),
        7 => Some(30),
        _ => None,
    };
    (0..40_u8)
        .map(|k| {
            let mut point = vec![0; LENGTHS[usize::from(format)]];
            let step = i32::from(k);
            for (axis, value) in [step, 2 * step, -step].into_iter().enumerate() {
                point[4 * axis..4 * axis + 4].copy_from_slice(&value.to_le_bytes());
            }
            point[12] = k;
            point[13] = 1;
            if format >= FIRST_EXTENDED {
                point[14] = 0x32;
                point[16] = 200;
                point[18..20].copy_from_slice(&(-500_i16).to_le_bytes());
                point[22..30].copy_from_slice(&0.5_f64.to_le_bytes());
            } else {
                point[14] = 0b0001_1010;
                point[15] = 0b1110_0110;
                point[16] = 0xfd;
            }
            if let Some(at) = color_at {
                point[at..at + 6].copy_from_slice(&[k, 0, 255, 0, 7, 0]);
            }
            point
        })
        .collect()
}

/// A file of version 1.4 with one record of variable length.
fn file(format: u8, record: &[u8], count: usize, payload: &[u8]) -> Vec<u8> {
    let mut file = vec![0; 375];
    file[..4].copy_from_slice(b"LASF");
    file[24..26].copy_from_slice(&[1, 4]);
    file[94..96].copy_from_slice(&375_u16.to_le_bytes());
    let start = u32::try_from(375 + 54 + record.len()).unwrap();
    file[96..100].copy_from_slice(&start.to_le_bytes());
    file[100] = 1;
    file[104] = format;
    let length = LENGTHS[usize::from(format & 0x3f)];
    file[105..107].copy_from_slice(&u16::try_from(length).unwrap().to_le_bytes());
    let count = u32::try_from(count).unwrap();
    file[107..111].copy_from_slice(&count.to_le_bytes());
    for axis in 0..3 {
        file[131 + 8 * axis..][..8].copy_from_slice(&0.5_f64.to_le_bytes());
        file[155 + 8 * axis..][..8].copy_from_slice(&1000.0_f64.to_le_bytes());
    }
    let mut head = [0; 54];
    head[2..16].copy_from_slice(b"laszip encoded");
    head[18..20].copy_from_slice(&22204_u16.to_le_bytes());
    head[20..22].copy_from_slice(&u16::try_from(record.len()).unwrap().to_le_bytes());
    file.extend(head);
    file.extend(record);
    file.extend(payload);
    file
}

fn plain(format: u8) -> Vec<u8> {
    let points = points(format);
    file(format, b"?", points.len(), &points.concat())
}

#[cfg(feature = "las")]
fn packed(format: u8) -> Vec<u8> {
    use ::laz::{LasZipCompressor, LazItemRecordBuilder, LazVlrBuilder};
    let items = LazItemRecordBuilder::default_for_point_format_id(format, 0).unwrap();
    let vlr = LazVlrBuilder::new(items).with_fixed_chunk_size(16).build();
    let mut record = Vec::new();
    vlr.write_to(&mut record).unwrap();
    let points = points(format);
    // The place of the table of chunks is counted from the start of the file.
    let head = file(format | 0x80, &record, points.len(), &[]);
    let mut out = std::io::Cursor::new(head);
    out.set_position(out.get_ref().len() as u64);
    let mut compressor = LasZipCompressor::new(&mut out, vlr).unwrap();
    compressor.compress_many(&points.concat()).unwrap();
    compressor.done().unwrap();
    drop(compressor);
    out.into_inner()
}

fn check_points(scan: &Scan, format: u8) {
    let positions = scan.positions();
    assert_eq!(positions.len(), 40);
    assert_eq!(positions[3], [1001.5, 1003.0, 998.5].into());
    let column = |name| scan.vertices.column(name).unwrap();
    assert_eq!(column("intensity").get_f64(39), Some(256.0 + 39.0));
    assert_eq!(*column("return_number"), Column::U8(vec![2; 40]));
    assert_eq!(*column("number_of_returns"), Column::U8(vec![3; 40]));
    let (class, angle) = if format >= FIRST_EXTENDED {
        assert_eq!(*column("gps_time"), Column::F64(vec![0.5; 40]));
        (200, -3.0)
    } else {
        (6, -3.0)
    };
    assert_eq!(*column("classification"), Column::U8(vec![class; 40]));
    let found = column("scan_angle").get_f64(0).unwrap();
    assert!((found - angle).abs() < 1e-6, "{found}");
    if matches!(format, 2 | 3 | 7) {
        assert_eq!(*column("red"), Column::U8((0..40).collect()));
        assert_eq!(*column("blue"), Column::U8(vec![7; 40]));
    }
    assert_eq!(scan.vertices.column("user_data"), None);
}

#[test]
fn points_have_their_properties() {
    for format in [0, 2, 3, 6, 7] {
        check_points(&scan(&plain(format)).unwrap(), format);
    }
}

#[test]
fn colors_of_16_bits_stay() {
    let mut points = points(2);
    points[0][21] = 1;
    let scan = scan(&file(2, b"", 40, &points.concat())).unwrap();
    let red = scan.vertices.column("red").unwrap();
    assert_eq!(red.get_f64(0), Some(256.0));
    assert!(matches!(red, Column::U16(_)));
}

#[test]
fn counts_are_not_believed() {
    let error = |file: &[u8]| scan(file).unwrap_err().to_string();
    let mut long = plain(0);
    long[107..111].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(
        error(&long).contains("only 40 are there"),
        "{}",
        error(&long)
    );
    // The count of version 1.4.
    long[107..111].copy_from_slice(&[0; 4]);
    long[247..255].copy_from_slice(&u64::MAX.to_le_bytes());
    assert!(
        error(&long).contains("only 40 are there"),
        "{}",
        error(&long)
    );
    let mut short = plain(0);
    short[105] = 19;
    assert!(error(&short).contains("19 bytes"), "{}", error(&short));
    let mut scale = plain(0);
    scale[131..139].copy_from_slice(&f64::NAN.to_le_bytes());
    assert!(error(&scale).contains("not finite"), "{}", error(&scale));
}

#[cfg(feature = "las")]
#[test]
fn compressed_points_come_back() {
    for format in [0, 2, 3, 6, 7] {
        check_points(&scan(&packed(format)).unwrap(), format);
    }
    let mut many = packed(7);
    many[107..111].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = scan(&many).unwrap_err().to_string();
    assert!(error.contains("more points than it can hold"), "{error}");
    many[107..111].copy_from_slice(&200_u32.to_le_bytes());
    let error = scan(&many).unwrap_err().to_string();
    assert!(error.contains("damaged or cut off"), "{error}");
}

#[test]
fn whatever_the_bytes_there_is_a_scan_or_an_error() {
    let read = |bytes: &[u8]| scan(bytes).map(Into::into);
    for format in [3, 7] {
        truncated(&plain(format), read);
        damaged(&plain(format), read);
    }
}

/// What panics in the decoder prints that it does, which tests do not show.
#[cfg(feature = "las")]
#[test]
fn whatever_the_compressed_bytes_there_is_a_scan_or_an_error() {
    let read = |bytes: &[u8]| scan(bytes).map(Into::into);
    for format in [3, 7] {
        truncated(&packed(format), read);
        damaged(&packed(format), read);
    }
}

/// One property of the record of extra bytes.
fn description(kind: u8, options: u8, name: &str, scale: f64, offset: f64) -> Vec<u8> {
    let mut text = vec![0; 192];
    text[2..4].copy_from_slice(&[kind, options]);
    text[4..4 + name.len()].copy_from_slice(name.as_bytes());
    text[112..120].copy_from_slice(&scale.to_le_bytes());
    text[136..144].copy_from_slice(&offset.to_le_bytes());
    text
}

/// Two points of format 0 with properties of every kind behind them.
fn with_extra_bytes() -> Vec<u8> {
    let record = [
        description(3, 0, "Echo width", 9.0, 9.0),
        description(6, 0, "intensity", 0.0, 0.0),
        description(0, 2, "bytes", 0.0, 0.0),
        description(4, 0b1_1000, "height", 0.01, 5.0),
        description(9, 0b1000, "twice", 2.0, 7.0),
        description(8, 0, "id", 0.0, 0.0),
        description(21, 0, "place", 0.0, 0.0),
        description(10, 0, "x", 0.0, 0.0),
    ];
    let row = |k: i8| {
        let mut point = vec![0; 20];
        point[12] = 7;
        point.extend((i16::from(k) + 300).to_le_bytes());
        point.extend((i32::from(k) * 100_000).to_le_bytes());
        point.extend([1, 2]);
        point.extend((i16::from(k) * 10).to_le_bytes());
        point.extend((f32::from(k) + 0.5).to_le_bytes());
        point.extend(i64::from(k).to_le_bytes());
        point.extend([3, 4, 5]);
        point.extend((f64::from(k) / 3.0).to_le_bytes());
        point.push(9);
        point
    };
    let payload = [row(-1), row(2)].concat();
    let mut file = file(0, &record.concat(), 2, &payload);
    file[105] = u8::try_from(payload.len() / 2).unwrap();
    file[377..391].copy_from_slice(b"LASF_Spec\0\0\0\0\0");
    file[393..395].copy_from_slice(&4_u16.to_le_bytes());
    file
}

#[test]
fn properties_beyond_the_standard_are_channels() {
    let scan = scan(&with_extra_bytes()).unwrap();
    let names: Vec<&str> = scan
        .vertices
        .channels
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    assert_eq!(
        names,
        [
            "x",
            "y",
            "z",
            "intensity",
            "Echo_width",
            "intensity_6",
            "height",
            "twice",
            "id",
            "place_0",
            "place_1",
            "place_2",
            "x_13",
        ]
    );
    let column = |name| scan.vertices.column(name).unwrap();
    assert_eq!(*column("intensity"), Column::U16(vec![7; 2]));
    assert_eq!(*column("Echo_width"), Column::U16(vec![299, 302]));
    assert_eq!(*column("intensity_6"), Column::I32(vec![-100_000, 200_000]));
    assert_eq!(*column("height"), Column::F64(vec![-0.1 + 5.0, 0.2 + 5.0]));
    assert_eq!(*column("twice"), Column::F64(vec![-1.0, 5.0]));
    assert_eq!(*column("id"), Column::F64(vec![-1.0, 2.0]));
    assert_eq!(*column("place_2"), Column::U8(vec![5; 2]));
    assert_eq!(*column("x_13"), Column::F64(vec![-1.0 / 3.0, 2.0 / 3.0]));
}

#[test]
fn damaged_records_of_extra_bytes_give_scans_or_errors() {
    let read = |bytes: &[u8]| scan(bytes).map(Into::into);
    truncated(&with_extra_bytes(), read);
    damaged(&with_extra_bytes(), read);
    // Without the record the points are still there.
    let mut nameless = with_extra_bytes();
    nameless[377] = b'?';
    assert_eq!(scan(&nameless).unwrap().vertices.channels.len(), 4);
    // Three doubles leave no room for `twice`, and a property that exceeds the points ends the list.
    let mut long = with_extra_bytes();
    long[429 + 2] = 30;
    assert_eq!(scan(&long).unwrap().vertices.channels.len(), 4 + 3 + 2);
    long[429 + 2] = 31;
    // There is no such type.
    assert_eq!(scan(&long).unwrap().vertices.channels.len(), 4);
}
