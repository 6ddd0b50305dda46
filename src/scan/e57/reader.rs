//! E57 files to scans.

use std::io::Cursor;
use std::ops::Range;

use ::e57::{E57Reader, PointCloud, RecordDataType};
use nalgebra::Point3;

use super::layout::Layout;
use crate::scan::channel::Scalar;
use crate::scan::range_grid::Grid;
use crate::scan::source::{Parsed, Source};
use crate::scan::text::table_of_doubles;
use crate::scan::{Column, Scan, ScanError, Sensor};

/// Most properties that a point can have: the standard knows about twenty, and the values of
/// properties that never change take memory without being in the file.
const MOST_PROPERTIES: usize = 64;

/// Most cells of a grid for each of its points; emptier ones come from damaged indices.
const MOST_CELLS_PER_POINT: usize = 16;

/// Reads an E57 file: all its scans, placed by their poses. Points of a file with more than one scan
/// get a channel `scan` with its index from 0.
pub(in crate::scan) fn read(source: &Source) -> Result<Parsed, ScanError> {
    let fail = |reason: String| ScanError::Malformed {
        name: source.name.to_owned(),
        reason,
    };
    let broken = |error: ::e57::Error| {
        log::debug!("{}: {error}", source.name);
        fail("it is damaged or cut off".to_owned())
    };
    check_length_of_xml(source.bytes).map_err(fail)?;
    let mut file = E57Reader::new(Cursor::new(source.bytes)).map_err(broken)?;
    let clouds = file.pointclouds();
    check_sizes(&clouds, source.bytes.len()).map_err(fail)?;
    let mut builder = Builder::default();
    for cloud in &clouds {
        let mut points = CloudPoints::new(cloud, builder.positions.len());
        for values in file.pointcloud_raw(cloud).map_err(broken)? {
            builder.point(&values.map_err(broken)?, &mut points);
        }
        builder.end_of_cloud(&points, source.name);
    }
    builder.finish(source.name)
}

/// The crate takes memory for the XML part as its length says.
fn check_length_of_xml(bytes: &[u8]) -> Result<(), String> {
    /// E2807, table 2: after signature, version, length of the file and place of the XML part.
    const PLACE: Range<usize> = 32..40;
    let field = bytes.get(PLACE).and_then(|b| b.try_into().ok());
    let length = field.map(u64::from_le_bytes);
    match length.and_then(|l| usize::try_from(l).ok()) {
        Some(length) if length <= bytes.len() => Ok(()),
        _ => Err("it is damaged or cut off (its XML part is longer than the file)".to_owned()),
    }
}

/// Compares what the header claims with the size of the file: each property takes its bits for each
/// point.
fn check_sizes(clouds: &[PointCloud], file_size: usize) -> Result<(), String> {
    let mut bits: u128 = 0;
    for cloud in clouds.iter().filter(|c| c.records > 0) {
        if cloud.prototype.len() > MOST_PROPERTIES {
            return Err(format!(
                "its points have more than the {MOST_PROPERTIES} properties that relievo reads"
            ));
        }
        let of_point: u32 = cloud.prototype.iter().map(|r| bits_of(&r.data_type)).sum();
        if of_point == 0 {
            // Points that are all the same would take no space, and be as many as the file likes.
            return Err("all its points are the same".to_owned());
        }
        bits = bits.saturating_add(u128::from(cloud.records) * u128::from(of_point));
    }
    if bits > file_size as u128 * 8 {
        return Err(
            "it is damaged or cut off (it promises more points than it can hold)".to_owned(),
        );
    }
    Ok(())
}

/// Bits of a value in the file; E2807, clause 9.
fn bits_of(data_type: &RecordDataType) -> u32 {
    match data_type {
        RecordDataType::Single { .. } => 32,
        RecordDataType::Double { .. } => 64,
        RecordDataType::ScaledInteger { min, max, .. } | RecordDataType::Integer { min, max } => {
            u64::BITS - max.abs_diff(*min).leading_zeros()
        }
    }
}

/// One scan of the file while it is read.
struct CloudPoints {
    layout: Layout,
    /// Range of the colours, if the file tells it.
    color_range: Option<[f64; 2]>,
    /// Where the scanner stood, if there is a pose.
    scanner: Option<Point3<f64>>,
    start: usize,
    records: usize,
    /// Row and column of each vertex.
    cells: Vec<[i64; 2]>,
}

impl CloudPoints {
    fn new(cloud: &PointCloud, start: usize) -> Self {
        let layout = Layout::of(cloud);
        let pose = cloud.transform.as_ref().map(|t| &t.translation);
        let scanner = pose.map(|t| Point3::new(t.x, t.y, t.z));
        Self {
            color_range: layout.color_range(cloud),
            layout,
            scanner: scanner.filter(|s| s.iter().all(|v| v.is_finite())),
            start,
            records: 0,
            cells: Vec::new(),
        }
    }
}

#[derive(Default)]
struct Builder {
    positions: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    intensities: Vec<f64>,
    /// Parts of full intensity, once their scan is complete.
    colors: Vec<[f64; 3]>,
    /// Whether the colours have more than 8 bits.
    is_deep: bool,
    scans: Vec<Range<usize>>,
    sensors: Vec<Sensor>,
    grids: Vec<Grid>,
    records: usize,
}

impl Builder {
    fn point(&mut self, values: &[::e57::RecordValue], cloud: &mut CloudPoints) {
        cloud.records += 1;
        let layout = &cloud.layout;
        let Some(position) = layout.position(values) else {
            return;
        };
        self.positions.push(position.into());
        self.normals.extend(layout.normal(values));
        self.intensities.extend(layout.intensity(values));
        self.colors.extend(layout.color(values));
        cloud.cells.extend(layout.cell(values));
    }

    fn end_of_cloud(&mut self, cloud: &CloudPoints, name: &str) {
        let vertices = cloud.start..self.positions.len();
        self.records += cloud.records;
        self.scale_colors(cloud);
        let grid = grid(cloud, vertices.clone(), name);
        // A scanner at the origin of the common system can also be one of which nothing is known.
        let scanner = cloud
            .scanner
            .filter(|s| grid.is_some() || *s != Point3::origin());
        self.grids.extend(grid);
        self.sensors.extend(scanner.map(|position| Sensor {
            vertices: vertices.clone(),
            position,
        }));
        self.scans.push(vertices);
    }

    /// Turns the colours of the scan, the last ones, to parts of full intensity.
    fn scale_colors(&mut self, cloud: &CloudPoints) {
        let vertices = self.positions.len() - cloud.start;
        let first = self.colors.len().saturating_sub(vertices);
        let has_colors = cloud.layout.has_color();
        let colors = self.colors.get_mut(first..).filter(|_| has_colors);
        let Some(colors) = colors else { return };
        let [low, high] = cloud.color_range.unwrap_or_else(|| {
            let largest = colors.iter().flatten().copied().fold(0.0, f64::max);
            let full = [1.0, 255.0].into_iter().find(|full| largest <= *full);
            [0.0, full.unwrap_or(f64::from(u16::MAX))]
        });
        self.is_deep |= high - low > 255.0 && !colors.is_empty();
        for value in colors.iter_mut().flatten() {
            *value = (*value - low) / (high - low);
        }
    }

    fn finish(self, name: &str) -> Result<Parsed, ScanError> {
        let vertices = self.positions.len();
        if vertices < self.records && self.grids.is_empty() {
            log::warn!(
                "{name}: {} of {} points left out, where the scanner saw nothing",
                self.records - vertices,
                self.records
            );
        }
        let mut table = table_of_doubles(["x", "y", "z"], &self.positions);
        if u32::try_from(vertices).is_err() {
            return Err(ScanError::TooLarge {
                name: name.to_owned(),
                what: "vertices",
            });
        }
        let is_whole = |length: usize, what: &str| {
            if length != vertices && length > 0 {
                log::warn!("{name}: {what} dropped, since not all its scans have them");
            }
            length == vertices
        };
        if is_whole(self.normals.len(), "normals") {
            let normals = table_of_doubles(["nx", "ny", "nz"], &self.normals);
            table.channels.extend(normals.channels);
        }
        if is_whole(self.colors.len(), "colours") {
            let full = if self.is_deep { u16::MAX.into() } else { 255.0 };
            for (k, color) in ["red", "green", "blue"].into_iter().enumerate() {
                let values = self.colors.iter().map(|c| c[k] * full);
                let column = if self.is_deep {
                    Column::U16(values.map(Scalar::rounded).collect())
                } else {
                    Column::U8(values.map(Scalar::rounded).collect())
                };
                table.set_channel(color, column);
            }
        }
        if is_whole(self.intensities.len(), "intensities") {
            table.set_channel("intensity", Column::F64(self.intensities));
        }
        let mut parsed = Parsed {
            scan: Scan {
                vertices: table,
                sensors: self.sensors,
                ..Scan::default()
            },
            grids: self.grids,
        };
        parsed.tell_scans_apart(&self.scans);
        Ok(parsed)
    }
}

/// The grid that rows and columns of a scan's points make, if they do.
fn grid(cloud: &CloudPoints, vertices: Range<usize>, name: &str) -> Option<Grid> {
    if cloud.cells.len() != vertices.len() {
        return None;
    }
    let range = |k: usize| {
        let values = cloud.cells.iter().map(|cell| cell[k]);
        let (low, high) = (values.clone().min()?, values.max()?);
        let length = usize::try_from(high.abs_diff(low)).ok()?.checked_add(1)?;
        (length > 1).then_some((low, length))
    };
    let ((first_row, rows), (first_column, columns)) = (range(0)?, range(1)?);
    let size = rows.checked_mul(columns);
    let most = cloud.records.saturating_mul(MOST_CELLS_PER_POINT);
    let Some(size) = size.filter(|size| *size <= most) else {
        log::warn!(
            "{name}: a grid of {columns} columns by {rows} rows is too empty to be one; not used"
        );
        return None;
    };
    let mut cells = vec![None; size];
    for ([row, column], vertex) in cloud.cells.iter().zip(vertices) {
        let offset = |value: i64, first: i64| usize::try_from(value.abs_diff(first)).ok();
        let place = offset(*row, first_row)
            .zip(offset(*column, first_column))
            .and_then(|(r, c)| cells.get_mut(r * columns + c));
        // The first of several returns is nearest to the scanner.
        if let Some(cell @ None) = place {
            *cell = u32::try_from(vertex).ok();
        }
    }
    Some(Grid {
        columns,
        cells,
        sensor: cloud.scanner,
    })
}

#[cfg(test)]
mod tests;
