//! Point clouds to surfaces: a scan without faces gets them.
//!
//! 1. Places that occur once or more are kept once; the rest of the story is about them.
//! 2. Stray points are set aside: single ones away from a surface, and small groups.
//! 3. Planes through the nearest neighbors give normals, and sensors, the file's own normals or the
//!    neighbors tell their side ([`bibliography#hoppe-et-al-1992`](crate::bibliography#hoppe-et-al-1992)).
//! 4. Triangles that the points' Delaunay stars in their own tangent planes agree on make a surface of any
//!    form ([`bibliography#gopi-krishnan--silva-2000`](crate::bibliography#gopi-krishnan--silva-2000)).
//! 5. Where a base surface fits that one, and the points lie over it in one layer, they are joined anew in
//!    its chart: one Delaunay triangulation leaves no small gaps.
//!
//! Triangles with an edge longer than the points' local spacing explains are left out: holes are where
//! points leave gaps. No point moves or disappears; stray ones and copies have no triangle.

mod error;
mod params;
mod report;
mod signs;
mod points;
mod outliers;
mod normals;
mod orient;
mod fans;
mod stars;
mod gaps;
mod single_fans;
mod rims;
mod local;
mod chart;
#[cfg(test)]
mod tests;

pub use error::CloudError;
pub use params::{CloudParams, JoinChoice, OutlierParams};
pub use report::{CloudReport, Joined, Orientation};

use nalgebra::{Point3, Vector3};

use crate::base::{FitParams, fit_part};
use crate::mesh::{Csr, TriMesh};
use crate::scan::{Column, Scan, Table};
use points::{Neighbors, Points, Spacing};
use stars::Stars;

/// A cloud with faces.
#[derive(Debug, Clone, PartialEq)]
pub struct Triangulated {
    /// The scan with triangles and, if it had none, unit normals `nx`, `ny`, `nz` (`float`; zero for stray
    /// points). All else is as it was, bit for bit.
    pub scan: Scan,
    /// #V, whether a triangle uses the vertex.
    pub used: Vec<bool>,
    /// What was done.
    pub report: CloudReport,
}

/// More than this share of points that face away from a base surface: not one layer.
const MOST_OVERHANGING: f64 = 0.02;

/// Joins the points of a scan without faces to an oriented manifold.
///
/// Every edge has at most two triangles, which run along it in opposite directions, and the triangles at
/// every vertex are one fan. The result does not depend on the number of threads.
///
/// # Errors
/// If the scan is not sound or has faces, if its points are fewer than three, at one place, on one line or
/// all too far apart, if a parameter is out of range, or if [`JoinChoice::Chart`] asks for a chart and no
/// base surface can be fitted.
///
/// # Reference
/// [`bibliography#gopi-krishnan--silva-2000`](crate::bibliography#gopi-krishnan--silva-2000),
/// [`bibliography#hoppe-et-al-1992`](crate::bibliography#hoppe-et-al-1992) section 3.
pub fn triangulate(scan: &Scan, params: &CloudParams) -> Result<Triangulated, CloudError> {
    params.check()?;
    scan.check("the cloud")?;
    if !scan.faces.is_empty() {
        return Err(CloudError::HasFaces(scan.faces.len()));
    }
    let positions = scan.positions();
    let (all, point_of_row) = Points::new(&positions)?;
    let duplicates = positions.len() - all.len();
    let surface = Surface::new(all, scan, &positions, params)?;
    log::info!(
        "{} triangles of {} points",
        surface.triangles.len(),
        positions.len()
    );

    let Surface {
        points, triangles, ..
    } = &surface;
    let faces: Vec<[u32; 3]> = (triangles.iter())
        .map(|t| stars::lowest_first(t.map(|v| points.rows[v as usize])))
        .collect();
    let mesh = TriMesh {
        positions: points.positions.clone(),
        triangles: triangles.clone(),
    };
    let [holes, rims, pieces] = report::outline(&mesh);
    let used = local::used(&faces, positions.len());
    let joined = used.iter().filter(|used| **used).count();
    let report = CloudReport {
        points: positions.len(),
        duplicates,
        outliers: surface.outliers,
        spacing: surface.spacing * points.unit,
        orientation: surface.orientation,
        joined: surface.joined,
        triangles: faces.len(),
        pieces,
        holes,
        rims,
        left_over: points.len() - joined,
    };
    let normals = surface.normals_of_rows(&point_of_row);
    Ok(Triangulated {
        scan: with_faces(scan, faces, &normals),
        used,
        report,
    })
}

/// The kept points and what joins them.
struct Surface {
    points: Points,
    /// For each point before the stray ones were set aside, its index now.
    kept: Option<Vec<u32>>,
    normals: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
    outliers: usize,
    spacing: f64,
    orientation: Orientation,
    joined: Joined,
}

impl Surface {
    fn new(
        points: Points,
        scan: &Scan,
        positions: &[Point3<f64>],
        params: &CloudParams,
    ) -> Result<Self, CloudError> {
        let (mut points, mut kept) = (points, None);
        let mut neighbors = Neighbors::new(&points, params.neighbors);
        let mut spacing = Spacing::new(&points, &neighbors);
        let before = points.len();
        if let Some(limits) = &params.outliers {
            let stray = outliers::stray(&points, &neighbors, &spacing, params.gap, limits);
            let left = stray.iter().filter(|stray| !**stray).count();
            if left < 3 {
                return Err(CloudError::NothingJoined);
            }
            if left < before {
                let (new, new_neighbors, new_index) = neighbors.without(&points, &stray);
                spacing = Spacing::new(&new, &new_neighbors);
                (points, neighbors, kept) = (new, new_neighbors, Some(new_index));
            }
        }
        let (mut normals, rough) = normals::planes(&points, &neighbors);
        let orientation =
            orient::orient(&mut normals, &rough, &points, &neighbors, scan, positions);
        let stars = Stars {
            points: &points,
            neighbors: &neighbors,
            normals: &normals,
            spacing: &spacing,
            gap: params.gap,
        };
        let (triangles, joined) = join(&stars, params)?;
        Ok(Self {
            outliers: before - points.len(),
            spacing: spacing.median,
            points,
            kept,
            normals,
            triangles,
            orientation,
            joined,
        })
    }

    /// #V unit normals, zero for stray points.
    fn normals_of_rows(&self, point_of_row: &[u32]) -> Vec<Vector3<f64>> {
        let kept = |point: u32| match &self.kept {
            Some(new_index) => new_index[point as usize],
            None => point,
        };
        (point_of_row.iter())
            .map(|point| self.normals.get(kept(*point) as usize))
            .map(|normal| normal.copied().unwrap_or_else(Vector3::zeros))
            .collect()
    }
}

/// The triangles, by local stars or in a chart.
fn join(stars: &Stars, params: &CloudParams) -> Result<(Vec<[u32; 3]>, Joined), CloudError> {
    let local = local::triangulate(stars);
    if local.is_empty() {
        return Err(CloudError::NothingJoined);
    }
    if params.join == JoinChoice::Local {
        return Ok((local, Joined::Local));
    }
    let fit_params = FitParams {
        seed: params.seed,
        ..FitParams::default()
    };
    let always = params.join == JoinChoice::Chart;
    let fit = match fit_part(&stars.points.positions, &local, &fit_params) {
        Ok(fit) => fit,
        Err(error) if always => return Err(CloudError::NoChart(error)),
        Err(_) => return Ok((local, Joined::Local)),
    };
    let lie = chart::lie(stars, &fit.base);
    let is_relief = fit.fits() && lie.overhanging <= MOST_OVERHANGING;
    if !always && !is_relief {
        return Ok((local, Joined::Local));
    }
    match chart::triangulate(stars, &fit.base, lie.side) {
        Ok(triangles) => Ok((triangles, Joined::Chart(fit.base.kind()))),
        Err(error) if always => Err(error),
        Err(_) => Ok((local, Joined::Local)),
    }
}

fn with_faces(scan: &Scan, mut triangles: Vec<[u32; 3]>, normals: &[Vector3<f64>]) -> Scan {
    // In an order that follows the rows, not the way they were found in.
    triangles.sort_unstable();
    let mut scan = scan.clone();
    scan.faces = Csr::default();
    for triangle in &triangles {
        scan.faces.push_row(triangle);
    }
    scan.face_channels = Table::default();
    let names = ["nx", "ny", "nz"];
    if names
        .iter()
        .all(|name| scan.vertices.column(name).is_none())
    {
        for (axis, name) in names.into_iter().enumerate() {
            #[expect(clippy::cast_possible_truncation, reason = "rounded on purpose")]
            let values = normals.iter().map(|n| n[axis] as f32).collect();
            scan.vertices.set_channel(name, Column::F32(values));
        }
    }
    scan
}
