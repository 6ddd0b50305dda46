//! Pictures of scans: shaded, anti-aliased, drawn on the processor, without a display.
//!
//! ```text
//! scan ─ paint ──────┐ what each vertex is coloured with, and a legend
//!   └ view ─ camera ─┤ from where; where vertices are on the picture
//!                    ├ rasterize ─ shade   which triangle is nearest at each of 3 × 3 samples of a pixel; its light
//!                    ├ detail, cavity      relief made readable; shade in what lies deep
//!                    └ legend ─ text       color bar, numbers, names
//! ```
//!
//! A picture depends on the scan and the parameters only: not on the number of threads, not on chance. This
//! room computes no figures; what it shows it reads.

mod camera;
mod canvas;
mod cavity;
mod color_map;
mod detail;
mod error;
mod legend;
mod paint;
mod params;
mod png;
mod rasterize;
mod shade;
mod text;
mod ticks;
mod view;

pub use canvas::Raster;
pub use error::PictureError;
pub use params::{
    Background, ChannelChoice, LARGEST_SIDE, LARGEST_ZOOM, LookAt, MOST_PIXELS, Projection,
    RenderParams, SMALLEST_SIDE, Up, View,
};
pub use png::{check_built, write_png};

use nalgebra::Point3;
use rayon::prelude::*;
use serde::Serialize;

use crate::completion::COMPLETED;
use crate::mesh::{TriMesh, vertex_normals};
use crate::scan::Scan;

use camera::{Area, Camera};
use paint::Painted;
use shade::Shader;

/// Share of the picture that the completed part takes with [`LookAt::Completed`]; what is around it shows
/// whether it passes as original.
const COMPLETED_SHARE: f64 = 0.6;

/// A picture, and what it shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// The pixels.
    pub raster: Raster,
    /// What they show.
    pub report: RenderReport,
}

/// What a picture shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RenderReport {
    /// Name of the channel: `color`, `shape`, `height`, `completed`, `cost`, `source`, or another vertex property.
    pub channel: String,
    /// Values at the ends of the color bar, if there is one.
    pub range: Option<[f64; 2]>,
    /// Direction from the scan to the camera, in the scan's axes.
    pub toward: [f64; 3],
    /// Direction that is up on the picture.
    pub up: [f64; 3],
    /// Number of triangles that were drawn, hidden ones too.
    pub triangles: usize,
    /// Whether a legend was left out because the picture is too small for it.
    pub legend_left_out: bool,
}

/// Draws a scan.
///
/// Vertices that are not finite are left out with their triangles. Lights are fixed to the camera. What is
/// seen from behind (the inside of a shell through a hole) is dull and reddish.
///
/// # Errors
/// [`PictureError`]: parameters out of range, a scan without faces or without the channel.
///
/// # Panics
/// If the scan is not one that passes [`Scan::check`]: no coordinates, faces with vertices that do not exist.
///
/// # Example
/// ```
/// use relievo::picture::{RenderParams, render};
/// use relievo::synth::{SynthParams, scan};
///
/// let ball = scan(&SynthParams::default())?.scan;
/// let params = RenderParams { width: 80, height: 60, ..RenderParams::default() };
/// let picture = render(&ball, &params)?;
/// assert_eq!(picture.raster.pixels.len(), 80 * 60);
/// assert_eq!(picture.raster.pixel(0, 0), Some([255; 4]));
/// assert_ne!(picture.raster.pixel(40, 30), Some([255; 4]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn render(scan: &Scan, params: &RenderParams) -> Result<Picture, PictureError> {
    params.check()?;
    let mut mesh = scan.mesh();
    let finite: Vec<bool> = (mesh.positions.iter())
        .map(|p| p.iter().all(|x| x.is_finite()))
        .collect();
    (mesh.triangles).retain(|t| t.iter().all(|v| finite[*v as usize]));
    if mesh.triangles.is_empty() {
        return Err(PictureError::NoFaces);
    }
    let completed = paint::completed(scan);
    let painted = paint::paint(scan, &mesh, params)?;
    bring_to_unit_size(&mut mesh)?;
    let (width, height) = (params.width, params.height);
    let wanted = painted.legend.as_ref().filter(|_| params.legend);
    let legend = wanted.and_then(|legend| legend::Column::place(legend, width, height));
    let taken = legend.as_ref().map_or(0, |column| column.width);
    let area = Area {
        left: 0.0,
        top: 0.0,
        width: f64::from(width - taken),
        height: f64::from(height),
    };
    let camera = aimed(scan, &mesh, completed.as_deref(), params, &area)?;
    if params.before {
        let marks = completed.ok_or_else(|| no_marks(scan))?;
        (mesh.triangles).retain(|t| !t.iter().any(|v| marks[*v as usize]));
    }
    let canvas = drawn(&mesh, &finite, &camera, &painted, params);
    let mut raster = canvas.over(params.background);
    if let Some(legend) = &legend {
        legend.draw(&mut raster, params.background);
    }
    Ok(Picture {
        raster,
        report: RenderReport {
            toward: camera.frame().toward.into(),
            up: camera.frame().up.into(),
            triangles: mesh.triangles.len(),
            legend_left_out: wanted.is_some() && legend.is_none(),
            channel: painted.channel,
            range: painted.range,
        },
    })
}

fn no_marks(scan: &Scan) -> PictureError {
    paint::missing(scan, format!("vertex property \"{COMPLETED}\""))
}

/// Moves what is drawn around the origin and scales it to a size of 1: neither large offsets (national grids)
/// nor tiny units cost precision.
fn bring_to_unit_size(mesh: &mut TriMesh) -> Result<(), PictureError> {
    let used = mesh.used_vertices();
    let shown = (mesh.positions.iter().zip(&used)).filter(|(_, used)| **used);
    let [low, high] = view::bounds(shown.map(|(p, _)| p)).ok_or(PictureError::NoFaces)?;
    let extent = high - low;
    let size = extent.amax();
    let size = if size > 0.0 { size } else { 1.0 };
    let middle = low + 0.5 * extent;
    for p in &mut mesh.positions {
        *p = Point3::from((*p - middle) / size);
    }
    Ok(())
}

/// The camera: it sees all triangles' vertices, or those that were completed, or an enlarged part.
fn aimed(
    scan: &Scan,
    mesh: &TriMesh,
    completed: Option<&[bool]>,
    params: &RenderParams,
    area: &Area,
) -> Result<Camera, PictureError> {
    let used = mesh.used_vertices();
    let shown = |keep: &dyn Fn(usize) -> bool| -> Vec<Point3<f64>> {
        let rows = (0..mesh.positions.len()).filter(|v| used[*v] && keep(*v));
        rows.map(|v| mesh.positions[v]).collect()
    };
    let points = shown(&|_| true);
    let [low, high] = view::bounds(points.iter()).ok_or(PictureError::NoFaces)?;
    let frame = view::frame(mesh, completed, &(high - low), params.view, params.up);
    let mut camera = Camera::fitted(frame, &points, params.projection, area);
    if params.look_at == LookAt::Completed {
        let marks = completed.ok_or_else(|| no_marks(scan))?;
        let points = shown(&|v| marks[v]);
        if points.is_empty() {
            return Err(PictureError::NothingCompleted);
        }
        camera = camera.looking_at(&points, COMPLETED_SHARE, area);
    }
    let middle = [0.5 * area.width, 0.5 * area.height];
    Ok(camera.enlarged(params.zoom, middle, area))
}

/// The scan without background and legend.
fn drawn(
    mesh: &TriMesh,
    finite: &[bool],
    camera: &Camera,
    painted: &Painted,
    params: &RenderParams,
) -> canvas::Canvas {
    let nowhere = camera::Seen {
        x: 0.0,
        y: 0.0,
        depth: 0.0,
    };
    let seen: Vec<camera::Seen> = (mesh.positions.par_iter().zip(finite))
        .map(|(p, finite)| if *finite { camera.seen(p) } else { nowhere })
        .collect();
    let normals = vertex_normals(mesh);
    let shader = Shader::new(&mesh.triangles, &normals, &seen, camera, &painted.paint);
    let size = [params.width, params.height].map(|side| side as usize);
    let shade = |hit: &rasterize::Hit| shader.shade(hit);
    let mut canvas = rasterize::draw(&seen, &mesh.triangles, size, params.wireframe, shade);
    detail::strengthen(&mut canvas, &shader.key(), shader.detail());
    cavity::darken(&mut canvas, camera);
    canvas
}

#[cfg(test)]
mod tests;
