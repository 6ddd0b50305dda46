//! What growing by neighborhoods on a stencil begins with, and what follows it.

use nalgebra::Vector3;

use crate::base::{BaseSurface, Form};
use crate::matching::{coherent, exemplar::ExemplarParams};
use crate::mesh::TriMesh;
use crate::neighborhood::{Frame, Surface, local_frames, smooth_frames};
use crate::rng::{Rng, Stage};

use super::blend::blend;
use super::by_stencil::StencilParams;
use super::correlation::Readable;
use super::ground::{Ground, Originals};
use super::growth::Canvas;
use super::patch::{Patch, Run};
use super::scale::Scale;
use super::smooth_part::roughness;
use super::suited::{blending, suited};
use super::{Clock, CompleteParams, Method, Work};

/// All that growing by neighborhoods on a stencil begins with.
pub(super) struct Ready {
    pub(super) ground: Ground,
    pub(super) scale: Scale,
    /// By vertex of the canvas: whether it may be copied from.
    pub(super) samples: Vec<bool>,
    pub(super) stencil: StencilParams,
}

impl Patch {
    /// Chooses what suits the relief, for `run` and what follows; begins the stage of the samples.
    pub(super) fn ready(
        &self,
        run: &mut Run,
        canvas: &Canvas,
        work: &mut Work,
        clock: &mut Clock,
    ) -> Ready {
        clock.begin("parameters");
        let samples = self.sample_vertices(canvas.points.len());
        if !self.own || self.form.primitive().is_none() {
            let count = samples.iter().filter(|is| **is).count();
            work.samples = work.samples.max(count);
        }
        let surface = Surface::new(TriMesh {
            positions: canvas.relief.feet.clone(),
            triangles: [&self.lying[..], &run.joint].concat(),
        });
        let frames = self.frames(canvas);
        let relief = Readable {
            surface: &surface,
            frames: &frames,
            heights: &canvas.relief.heights,
            colors: canvas.colors.as_deref(),
            samples: &samples,
            step: run.input.spacing.median,
        };
        let [seed, patch] = run.seed;
        let mut rng = Rng::new(seed, Stage::Suiting, patch);
        let (settings, chosen) = suited(&relief, run.input.spacing.spacing, run.params, &mut rng);
        run.settings = settings;
        work.chosen.extend(chosen);
        clock.end("parameters");
        clock.begin("samples");
        let scale = Scale::new(canvas, &samples, settings.mu);
        let originals = Originals {
            copied: &samples,
            measured: &samples,
        };
        let first = canvas.first_target;
        Ready {
            ground: Ground::new(canvas, surface, frames, scale, originals, first),
            scale,
            samples,
            stencil: stencil_params(run),
        }
    }

    /// By vertex of the canvas: whether it may be copied from.
    fn sample_vertices(&self, count: usize) -> Vec<bool> {
        let mut is_sample = vec![false; count];
        for v in self.triangles.iter().flatten() {
            is_sample[*v as usize] = true;
        }
        is_sample
    }

    /// Frames that follow the surface: those of the base surface's own axes, or where these leave a sphere
    /// or free form, a field as smooth as can be.
    fn frames(&self, canvas: &Canvas) -> Vec<Frame> {
        match self.form {
            Form::Primitive(
                base @ (BaseSurface::Plane(_) | BaseSurface::Cylinder(_) | BaseSurface::Cone(_)),
            ) => local_frames(&base, &canvas.relief.normals),
            _ => {
                let normals = &canvas.relief.normals;
                let direction = tangent_direction(&normals[canvas.first_target..]);
                smooth_frames(&canvas.adjacency, normals, &direction)
            }
        }
    }
}

/// Fits copied patches to each other and to the scan, if that suits the relief.
pub(super) fn fit_together(
    canvas: &mut Canvas,
    samples: &[bool],
    ground: &Ground,
    params: &CompleteParams,
    work: &mut Work,
    clock: &mut Clock,
) {
    let (blends, chosen) = blending(params, roughness(canvas, samples));
    work.chosen.push(chosen);
    if blends {
        clock.begin("blend");
        blend(canvas, |canvas, v, n| ground.continued_height(canvas, v, n));
        clock.end("blend");
    }
}

/// Of some directions the one that is most nearly tangent wherever a normal is: where it is normal to the surface
/// a field that follows it must turn, and that should not be in a gap.
fn tangent_direction(normals: &[Vector3<f64>]) -> Vector3<f64> {
    let tries = (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| (x, y, z))));
    let directions = tries
        .filter(|way| *way > (0, 0, 0))
        .map(|(x, y, z)| Vector3::new(f64::from(x), f64::from(y), f64::from(z)).normalize());
    let worst = |direction: &Vector3<f64>| {
        (normals.iter())
            .map(|normal| normal.dot(direction).abs())
            .fold(0.0, f64::max)
    };
    (directions.map(|direction| (worst(&direction), direction)))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or_else(Vector3::x, |(_, direction)| direction)
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "costs on a stencil are single"
)]
fn stencil_params(run: &Run) -> StencilParams {
    /// Most similar candidates of every site that coherent search looks at.
    const SIMILAR: usize = 3;
    /// Sites that random search starts from, and random places at each radius around them.
    const STARTS: usize = 6;
    const TRIES: u32 = 3;
    let Run {
        input,
        params,
        settings,
        seed,
        ..
    } = *run;
    let coherent = params.method == Method::Coherent;
    StencilParams {
        window: settings.window,
        spacing: input.spacing.spacing,
        exemplar: ExemplarParams {
            rotations: settings.rotations,
            most_sites: if coherent { params.sites } else { usize::MAX },
            // Renewed tables stand beside those that they replace.
            memory: params.memory / if params.bootstrap { 2 } else { 1 },
            similar: if coherent { SIMILAR } else { 0 },
        },
        coherent,
        search: coherent::Search {
            coherence: params.coherence as f32,
            tolerance: params.tolerance as f32,
            starts: STARTS,
            tries: TRIES,
        },
        audit: params.audit,
        bootstrap: params.bootstrap,
        seed,
    }
}
