//! What `relievo transfer` writes: the target with what was copied.

use crate::mesh::{Bisected, SurfaceLookup, TriMesh, seam_normals, surface_area};
use crate::relief;
use crate::repair::Repaired;
use crate::scan::{Column, Image, Scan};
use crate::transfer::Transferred;
use anyhow::Context;
use nalgebra::Point3;
use serde_json::{Map, Value, json};

use super::super::mesh_output::{Destination, MeshOutput, restored, warn_of_loss};
use super::super::outcome::Failure;
use super::Arguments;
use super::given::Painted;
use super::source::FromSource;

/// What is copied onto.
pub(super) struct Onto<'a> {
    arguments: &'a Arguments,
    surface: &'a Repaired,
    /// The mesh that is worked on: with a mask the source's, which may have been made finer.
    pub(super) mesh: TriMesh,
}

/// A scan of as many vertices as are written, and the mesh that they are on.
struct Shown<'a> {
    scan: Scan,
    mesh: TriMesh,
    /// How vertices were put on the edges of the mesh that was worked on; `None` if they were not, or are not shown.
    finer: Option<&'a Bisected>,
}

impl<'a> Onto<'a> {
    pub(super) fn new(
        arguments: &'a Arguments,
        surface: &'a Repaired,
        source: &FromSource,
    ) -> Self {
        let mesh = match arguments.mask {
            Some(_) => source.fine_mesh().clone(),
            None => surface.scan.mesh(),
        };
        Self {
            arguments,
            surface,
            mesh,
        }
    }

    /// Writes the target; gives where the vertices that were worked on are at last, as far as all are written.
    pub(super) fn write(
        &self,
        (to, output): (&Destination, MeshOutput),
        source: &FromSource,
        done: &Transferred,
        painted: Option<&Painted>,
        known: &mut Map<String, Value>,
    ) -> Result<Vec<Point3<f64>>, Failure> {
        let name = self.arguments.target_input().name();
        let own = self.surface.scan.vertices.rows;
        let all = done.finer.mesh.positions.len();
        let has_relief = done.heights.is_some();
        let is_finer =
            all > own && !self.arguments.keep_mesh && (has_relief || !output.has_image());
        let mut shown = if is_finer {
            self.finer(source, done)
        } else {
            Shown {
                scan: restored(self.surface),
                mesh: self.surface.scan.mesh(),
                finer: None,
            }
        };
        let mut image = None;
        if let (true, Some(colors)) = (output.has_image(), &done.colors) {
            let drawn = texture_image(to, &shown.scan, &done.finer.mesh, colors, known);
            image = Some(drawn.with_context(|| name.clone())?);
        } else if self.arguments.keep_mesh && done.colors.is_some() {
            warn_of_loss(&name, own, all);
        }
        self.put(&mut shown, source, done, painted);
        known.insert(
            "mesh".into(),
            json!({ "vertices": shown.scan.vertices.rows, "made_finer": is_finer }),
        );
        let scan = output.write(shown.scan, image.as_ref(), &to.options())?;
        if scan.vertices.rows == all {
            Ok(scan.positions())
        } else {
            Ok(done.finer.mesh.positions.clone())
        }
    }

    /// The target with all vertices that were put on its edges.
    fn finer<'d>(&self, source: &FromSource, done: &'d Transferred) -> Shown<'d> {
        let mut scan = self.surface.scan.clone();
        let mut uv = restored(self.surface).texture_coordinates();
        if (uv.as_ref()).is_some_and(|uv| uv.len() != scan.mesh().triangles.len()) {
            log::warn!(
                "{}: its texture coordinates are lost where joined seams left triangles without area: give --keep-mesh, or --no-repair=weld",
                self.arguments.target_input().name()
            );
            uv = None;
        }
        if let Some(first) = source.finer().filter(|_| self.arguments.mask.is_some()) {
            scan = scan.refined(first, uv.as_deref());
            uv = uv.and_then(|_| scan.texture_coordinates());
        }
        Shown {
            scan: scan.refined(&done.finer, uv.as_deref()),
            mesh: done.finer.mesh.clone(),
            finer: Some(&done.finer),
        }
    }

    /// Puts on the scan what its vertices got.
    fn put(
        &self,
        shown: &mut Shown,
        source: &FromSource,
        done: &Transferred,
        painted: Option<&Painted>,
    ) {
        let rows = shown.scan.vertices.rows;
        let painted = painted.map(|painted| match shown.finer {
            Some(finer) => between(finer, &painted.fine),
            None => painted.own.clone(),
        });
        if let Some(colors) = &done.colors {
            let mut colors = colors[..rows].to_vec();
            if let (Some(painted), Some(before)) = (&painted, &source.colors) {
                // Exactly what was there, which the work has rounded.
                for (color, (before, _)) in (colors.iter_mut())
                    .zip(before.iter().zip(painted))
                    .filter(|(_, (_, painted))| **painted)
                {
                    *color = *before;
                }
            }
            shown.scan.vertices.replace_colors(&colors);
        }
        if let Some(heights) = &done.heights {
            self.put_relief(shown, source, heights[..rows].to_vec(), painted.as_deref());
        }
        let table = &mut shown.scan.vertices;
        let sources = done.sources[..rows].iter().map(|v| source.in_file(*v));
        table.set_channel("source", Column::U32(sources.collect()));
        table.set_channel("rotation", Column::F32(done.rotations[..rows].to_vec()));
        table.set_channel("cost", Column::F32(done.costs[..rows].to_vec()));
    }

    /// Adds relief; with a mask it takes the place of the relief that is there, and what is painted stays.
    fn put_relief(
        &self,
        shown: &mut Shown,
        source: &FromSource,
        mut heights: Vec<f64>,
        painted: Option<&[bool]>,
    ) {
        let normals = seam_normals(&shown.mesh);
        let scale = self.arguments.displacement();
        let (Some(painted), Some(own)) = (painted, &source.heights) else {
            return relief::put_on(&mut shown.scan, &normals, heights, scale);
        };
        let own: Vec<[f64; 1]> = own.iter().map(|h| [*h]).collect();
        let own = match shown.finer {
            Some(finer) => finer.interpolate(&own),
            None => own,
        };
        for (height, ([own], painted)) in heights.iter_mut().zip(own.iter().zip(painted)) {
            if *painted {
                *height = *own;
            }
        }
        let rises = heights.iter().zip(&own).map(|(new, [own])| new - own);
        relief::put_on(&mut shown.scan, &normals, rises.collect(), scale);
        let heights = Column::F64(heights);
        shown.scan.vertices.set_channel("height", heights);
    }
}

/// What holds for both ends of an edge holds for what was put on it.
pub(super) fn between(finer: &Bisected, own: &[bool]) -> Vec<bool> {
    let mut all = own.to_vec();
    for [a, b] in &finer.parents {
        all.push(all[*a as usize] && all[*b as usize]);
    }
    all
}

/// The colors of a mesh in an image for the texture coordinates of the target.
fn texture_image(
    to: &Destination,
    scan: &Scan,
    mesh: &TriMesh,
    colors: &[[f64; 3]],
    known: &mut Map<String, Value>,
) -> anyhow::Result<Image> {
    let used = mesh
        .used_vertices()
        .into_iter()
        .filter(|used| *used)
        .count();
    let texel = (surface_area(mesh) / used.max(1) as f64).sqrt();
    let lookup = SurfaceLookup::new(mesh);
    let color = |point: &_, normal: Option<&_>| {
        let place = lookup.place(point, normal);
        place.map_or([0.0; 3], |place| place.of_vertices(colors))
    };
    to.image(scan, texel, color, known)
}
