//! What is on the source.

use crate::mesh::{Bisected, TriMesh, bisected, vertex_normals};
use crate::relief;
use crate::repair::Repaired;
use crate::scan::{ColorMap, Scan};
use crate::transfer::MOST_VERTICES;
use anyhow::{Context, anyhow};
use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::super::Common;
use super::super::messages::Bar;
use super::super::outcome::Failure;
use super::Arguments;
use super::output::between;

/// Of colors between its vertices, a source shows at least as many as it would have with so many vertices.
const ENOUGH: usize = 65_536;

/// The source with what is copied of it.
pub(super) struct FromSource {
    /// As it is in its file.
    pub(super) mesh: TriMesh,
    /// What was done to it, in sentences.
    pub(super) prepared: Vec<String>,
    /// With more vertices on its edges, where there are colors between.
    finer: Option<Bisected>,
    /// By vertex of the finer mesh.
    pub(super) colors: Option<Vec<[f64; 3]>>,
    /// By vertex of the finer mesh; not before [`measure`](Self::measure).
    pub(super) heights: Option<Vec<f64>>,
}

impl FromSource {
    /// Reads the source, or takes the target for it, and its colors.
    pub(super) fn read(
        arguments: &Arguments,
        target: &Repaired,
        common: &Common,
        known: &mut Map<String, Value>,
    ) -> Result<Self, Failure> {
        let input = arguments.source_input();
        let (scan, told) = if arguments.mask.is_some() {
            (target.scan.clone(), Vec::new())
        } else {
            let mut about = Map::new();
            let (surface, told) = (arguments.prepare).told_surface(&input, common, &mut about)?;
            known.insert("source_prepared".into(), Value::Object(about));
            (surface.scan, told)
        };
        let mut source = Self {
            mesh: scan.mesh(),
            prepared: (told.iter())
                .map(|what| format!("{}: {what}", input.name()))
                .collect(),
            finer: None,
            colors: None,
            heights: None,
        };
        if arguments.has_colors() {
            let bar = Bar::doing(common, "colors");
            match input.color_map()? {
                Some(map) => {
                    source.look_up(&map, arguments.work_on(target.scan.vertices.rows));
                    known.insert(
                        "source_made_finer".into(),
                        json!(source.fine_mesh().positions.len()),
                    );
                }
                None => source.colors = Some(colors_of(&scan).with_context(|| input.name())?),
            }
            drop(bar);
        }
        Ok(source)
    }

    /// Colors of a texture image, of as many vertices at least.
    fn look_up(&mut self, map: &ColorMap, vertices: usize) {
        let finer = bisected(&self.mesh, vertices);
        let normals = vertex_normals(&finer.mesh);
        let points = finer.mesh.positions.par_iter().zip(&normals);
        let colors = points.map(|(point, normal)| {
            let normal = Some(normal).filter(|normal| normal.norm() > 0.5);
            map.color(point, normal).unwrap_or_default()
        });
        self.colors = Some(colors.collect());
        self.finer = Some(finer);
    }

    /// Takes the relief off, if it is asked for.
    pub(super) fn measure(
        &mut self,
        arguments: &Arguments,
        common: &Common,
        known: &mut Map<String, Value>,
    ) -> Result<(), Failure> {
        if !arguments.has_relief() {
            return Ok(());
        }
        let bar = Bar::doing(common, "relief");
        let found = relief::on_free_form(&self.mesh, arguments.form_wavelength, &[]);
        drop(bar);
        let (relief, wavelength) = found.with_context(|| arguments.source_input().name())?;
        known.insert("form_wavelength".into(), json!(wavelength));
        let heights: Vec<[f64; 1]> = relief.heights.iter().map(|h| [*h]).collect();
        let heights = match &self.finer {
            Some(finer) => finer.interpolate(&heights),
            None => heights,
        };
        self.heights = Some(heights.into_iter().flatten().collect());
        Ok(())
    }

    /// The mesh that the values belong to.
    pub(super) fn fine_mesh(&self) -> &TriMesh {
        self.finer.as_ref().map_or(&self.mesh, |finer| &finer.mesh)
    }

    /// How it was made finer.
    pub(super) fn finer(&self) -> Option<&Bisected> {
        self.finer.as_ref()
    }

    /// What holds for both ends of an edge holds for what was put on it.
    pub(super) fn between(&self, own: &[bool]) -> Vec<bool> {
        match &self.finer {
            Some(finer) => between(finer, own),
            None => own.to_vec(),
        }
    }

    /// The vertex in the file for one of the finer mesh: itself, or an end of the edge that it was put on.
    pub(super) fn in_file(&self, vertex: u32) -> u32 {
        let originals = self.mesh.positions.len();
        let mut vertex = vertex;
        while let (Some(new), Some(finer)) = ((vertex as usize).checked_sub(originals), &self.finer)
        {
            vertex = finer.parents[new][0];
        }
        vertex
    }
}

impl Arguments {
    /// As many vertices of the source are needed for what the target is worked on with.
    fn work_on(&self, target: usize) -> usize {
        let of_target = target.max(self.vertices.unwrap_or(ENOUGH));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates far beyond what is allowed"
        )]
        let of_source = (of_target as f64 * self.scale * self.scale) as usize;
        of_source.min(MOST_VERTICES)
    }
}

fn colors_of(scan: &Scan) -> anyhow::Result<Vec<[f64; 3]>> {
    scan.colors().ok_or_else(|| {
        anyhow!("it has no colors to copy: give a source with colors of its vertices or a texture image, or copy its relief with --channel height")
    })
}
