//! The gaps that lie on one base surface, filled together.

use nalgebra::Point3;

use crate::base::{BaseSurface, FitReport};
use crate::matching::paper::{Samples, Search};
use crate::matching::{coherent, exemplar::ExemplarParams};
use crate::mesh::{Adjacency, TriMesh, triangle_normal};
use crate::relief::{self, Relief};
use crate::rng::{Rng, Stage};
use crate::sampling::{Fill, Gap, fill, subdivide};

use super::by_paper::ByPaper;
use super::by_stencil::{ByStencil, StencilParams};
use super::growth::{Canvas, Grown, Growth, Matcher};
use super::{Clock, CompleteParams, FilledHole, Input, Method, Progress, SkippedHole, Work};

/// A base surface and the part of the scan that lies on it.
#[derive(Debug)]
pub(super) struct Patch {
    pub(super) base: BaseSurface,
    pub(super) relief: Relief,
    /// By vertex: whether it lies on the base (is relief).
    pub(super) on_base: Vec<bool>,
    /// The triangles that lie on the base: corners there, not folded over.
    lying: Vec<[u32; 3]>,
    /// Those of them that can be copied from.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Whether it is a hole's own base surface.
    own: bool,
}

/// A gap to fill, with the numbers of its loops: one for each rim, then one for each island.
#[derive(Debug, Clone)]
pub(super) struct NumberedGap {
    pub(super) gap: Gap,
    pub(super) rim_ids: Vec<usize>,
    pub(super) island_ids: Vec<usize>,
}

/// A gap that was filled: vertices numbered on from the scan's last.
#[derive(Debug)]
pub(super) struct Added {
    pub(super) points: Vec<Point3<f64>>,
    pub(super) heights: Vec<f64>,
    pub(super) colors: Option<Vec<[f64; 3]>>,
    pub(super) sources: Vec<u32>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) report: FilledHole,
}

/// A gap with its targets and triangles, not yet grown.
struct Planned {
    loops: Vec<usize>,
    fill: Fill,
    /// Its targets' place among all targets of the patch.
    targets: std::ops::Range<usize>,
}

/// What growing is to be done with.
struct Run<'a> {
    input: &'a Input,
    params: &'a CompleteParams,
    /// New triangles, see [`joint_triangles`].
    joint: Vec<[u32; 3]>,
    /// Seed, and number of the patch: what all random numbers follow from.
    seed: [u32; 2],
}

impl Run<'_> {
    fn grow<M: Matcher>(&self, canvas: &mut Canvas, matcher: &mut M, clock: &mut Clock) -> Grown {
        let total = canvas.points.len() - canvas.first_target;
        let mut rng = Rng::new(self.seed[0], Stage::Completion, self.seed[1]);
        let growth = Growth::new(canvas, self.params.window, self.params.error_threshold);
        let grown = growth.run(matcher, &mut rng, |done| {
            (clock.progress)(Progress {
                stage: "growth",
                done,
                total,
            });
        });
        clock.end("growth");
        grown
    }
}

impl Patch {
    /// The part of the scan that lies on the base fitted to it.
    pub(super) fn whole(input: &Input, fit: &FitReport) -> Self {
        let relief = relief::extract(&input.mesh, &fit.base);
        Self::new(input, &fit.base, relief, relief::reach(fit), None)
    }

    /// The part within `region` that is at most `reach` from the given side of a base of its own.
    pub(super) fn own(
        input: &Input,
        base: &BaseSurface,
        side: f64,
        reach: f64,
        region: &[bool],
    ) -> Self {
        let relief = relief::extract_on_side(&input.mesh.positions, base, side);
        Self::new(input, base, relief, reach, Some(region))
    }

    fn new(
        input: &Input,
        base: &BaseSurface,
        relief: Relief,
        reach: f64,
        region: Option<&[bool]>,
    ) -> Self {
        let used = input.mesh.used_vertices();
        let on_base: Vec<bool> = (0..relief.heights.len())
            .map(|v| {
                used[v] && relief.heights[v].abs() <= reach && region.is_none_or(|region| region[v])
            })
            .collect();
        let lying: Vec<[u32; 3]> = (input.mesh.triangles.iter())
            .filter(|t| (t.iter()).all(|v| on_base[*v as usize]))
            .filter(|t| {
                let [a, b, c] = t.map(|v| v as usize);
                let normal = triangle_normal([relief.feet[a], relief.feet[b], relief.feet[c]]);
                normal.dot(&(relief.normals[a] + relief.normals[b] + relief.normals[c])) > 0.0
            })
            .copied()
            .collect();
        Self {
            base: *base,
            relief,
            on_base,
            triangles: (lying.iter())
                .filter(|t| t.iter().all(|v| input.scanned[*v as usize]))
                .copied()
                .collect(),
            lying,
            own: region.is_some(),
        }
    }

    /// Share of a loop's vertices that lie on the base.
    pub(super) fn share_on_base(&self, vertices: &[u32]) -> f64 {
        let on = vertices.iter().filter(|v| self.on_base[**v as usize]);
        on.count() as f64 / vertices.len().max(1) as f64
    }

    /// Fills the gaps and grows relief and colour over them; results go to `work`.
    pub(super) fn complete(
        &self,
        input: &Input,
        gaps: Vec<NumberedGap>,
        params: &CompleteParams,
        work: &mut Work,
        clock: &mut Clock,
    ) {
        let planned = self.plan(input, gaps, work);
        clock.end("targets");
        let mut canvas = self.canvas(input, &planned);
        let run = Run {
            input,
            params,
            joint: joint_triangles(input, &planned),
            seed: [params.seed, work.patches],
        };
        work.patches += 1;
        let grown = if planned.iter().all(|gap| gap.targets.is_empty()) {
            Ok(Grown::new(0))
        } else if params.method == Method::Paper {
            Ok(self.grow_by_paper(&run, &mut canvas, work, clock))
        } else {
            self.grow_by_stencil(&run, &mut canvas, work, clock)
        };
        match grown {
            Ok(grown) => {
                for gap in planned {
                    self.collect(gap, &canvas, &grown, work);
                }
            }
            Err(reason) => work
                .skipped
                .extend(planned.into_iter().map(|gap| SkippedHole {
                    loops: gap.loops,
                    reason: reason.clone(),
                })),
        }
    }

    fn grow_by_paper(
        &self,
        run: &Run,
        canvas: &mut Canvas,
        work: &mut Work,
        clock: &mut Clock,
    ) -> Grown {
        let Run { input, params, .. } = *run;
        let samples = self.samples(&input.mesh, &self.relief, input.colors.as_deref());
        if !self.own {
            work.samples = samples.len();
        }
        let renew = |canvas: &Canvas| self.renewed(canvas, &run.joint);
        let renew: Option<&dyn Fn(&Canvas) -> Samples> = match params.bootstrap {
            true => Some(&renew),
            false => None,
        };
        let (search, spacing) = (paper_search(input, params), input.spacing.spacing);
        let base = &self.base;
        let mut matcher = ByPaper::new(canvas, base, samples, renew, search, spacing, run.seed);
        clock.end("samples");
        run.grow(canvas, &mut matcher, clock)
    }

    /// # Errors
    /// In words, why there is nothing to copy from.
    fn grow_by_stencil(
        &self,
        run: &Run,
        canvas: &mut Canvas,
        work: &mut Work,
        clock: &mut Clock,
    ) -> Result<Grown, String> {
        let samples = self.sample_vertices(canvas.points.len());
        if !self.own {
            work.samples = samples.iter().filter(|is| **is).count();
        }
        let triangles = [&self.lying[..], &run.joint].concat();
        let params = stencil_params(run.input, run.params, run.seed);
        let mut matcher = ByStencil::new(canvas, &self.base, triangles, &samples, params)?;
        clock.end("samples");
        let grown = run.grow(canvas, &mut matcher, clock);
        work.searched.add(&matcher.searched());
        Ok(grown)
    }

    /// By vertex of the canvas: whether it may be copied from.
    fn sample_vertices(&self, count: usize) -> Vec<bool> {
        let mut is_sample = vec![false; count];
        for v in self.triangles.iter().flatten() {
            is_sample[*v as usize] = true;
        }
        is_sample
    }

    fn plan(&self, input: &Input, gaps: Vec<NumberedGap>, work: &mut Work) -> Vec<Planned> {
        let mut planned: Vec<Planned> = Vec::new();
        for numbered in gaps {
            let NumberedGap {
                gap,
                rim_ids: mut loops,
                island_ids,
            } = numbered;
            let spacing = input.spacing.spacing;
            match fill(&self.base, &self.relief, &input.adjacency, &gap, spacing) {
                Ok(fill) if fill.triangles.is_empty() => work.skipped.push(SkippedHole {
                    loops,
                    reason:
                        "nothing is missing there: the scan reaches to the end of the base surface"
                            .to_owned(),
                }),
                Ok(fill) => {
                    let start = planned.last().map_or(0, |last| last.targets.end);
                    loops.extend(fill.islands.iter().map(|i| island_ids[*i]));
                    planned.push(Planned {
                        loops,
                        targets: start..start + fill.targets.len(),
                        fill,
                    });
                }
                Err(error) => work.skipped.push(SkippedHole {
                    loops,
                    reason: error.to_string(),
                }),
            }
        }
        planned
    }

    fn samples(&self, mesh: &TriMesh, relief: &Relief, colors: Option<&[[f64; 3]]>) -> Samples {
        let surface = TriMesh {
            positions: mesh.positions.clone(),
            triangles: self.triangles.clone(),
        };
        Samples::new(&self.base, &subdivide(&surface, &self.base, relief, colors))
    }

    /// Samples of all that is known by now.
    fn renewed(&self, canvas: &Canvas, joint: &[[u32; 3]]) -> Samples {
        let new = (joint.iter()).filter(|t| t.iter().all(|v| canvas.known[*v as usize]));
        let surface = TriMesh {
            positions: canvas.points.clone(),
            triangles: self.triangles.iter().chain(new).copied().collect(),
        };
        let colors = canvas.colors.as_deref();
        Samples::new(
            &self.base,
            &subdivide(&surface, &self.base, &canvas.relief, colors),
        )
    }

    /// Scan and targets as one surface.
    fn canvas(&self, input: &Input, planned: &[Planned]) -> Canvas {
        let first_target = input.mesh.positions.len();
        let mut relief = self.relief.clone();
        let mut known = self.on_base.clone();
        for foot in planned.iter().flat_map(|gap| &gap.fill.targets) {
            relief.feet.push(*foot);
            let normal = self.base.foot(foot).normal * relief.side;
            relief.normals.push(normal);
            relief.heights.push(0.0);
            known.push(false);
        }
        let mut points = input.mesh.positions.clone();
        points.extend_from_slice(&relief.feet[first_target..]);
        let mut triangles = input.mesh.triangles.clone();
        triangles.extend(joint_triangles(input, planned));
        let mesh = TriMesh {
            positions: points,
            triangles,
        };
        Canvas {
            adjacency: Adjacency::new(&mesh),
            points: mesh.positions,
            colors: input.colors.clone().map(|mut colors| {
                colors.resize(relief.feet.len(), [0.0; 3]);
                colors
            }),
            relief,
            known,
            first_target,
        }
    }

    fn collect(&self, gap: Planned, canvas: &Canvas, grown: &Grown, work: &mut Work) {
        let costs = &grown.costs[gap.targets.clone()];
        let unmatched = costs.iter().filter(|cost| cost.is_none()).count();
        if unmatched > 0 {
            work.skipped.push(SkippedHole {
                loops: gap.loops,
                reason: format!(
                    "{unmatched} of its {} new vertices found no match: nowhere does the scan show a surrounding like theirs; try a smaller --window or a larger --spacing",
                    costs.len()
                ),
            });
            return;
        }
        let matched = costs.iter().flatten().copied();
        let vertices =
            canvas.first_target + gap.targets.start..canvas.first_target + gap.targets.end;
        work.added.push(Added {
            points: canvas.points[vertices.clone()].to_vec(),
            heights: canvas.relief.heights[vertices.clone()].to_vec(),
            colors: (canvas.colors.as_ref()).map(|colors| colors[vertices].to_vec()),
            sources: grown.sources[gap.targets].to_vec(),
            report: FilledHole {
                loops: gap.loops,
                vertices: costs.len(),
                faces: gap.fill.triangles.len(),
                mean_cost: matched.clone().sum::<f64>() / costs.len().max(1) as f64,
                worst_cost: matched.fold(0.0, f64::max),
                own_base: self.own.then_some(self.base),
            },
            triangles: gap.fill.triangles,
        });
    }
}

/// The fills' triangles with the targets of all gaps numbered in a row.
fn joint_triangles(input: &Input, planned: &[Planned]) -> Vec<[u32; 3]> {
    let first_target = input.mesh.positions.len();
    (planned.iter())
        .flat_map(|gap| {
            let offset = super::index(gap.targets.start);
            (gap.fill.triangles.iter()).map(move |t| {
                t.map(|v| {
                    if (v as usize) < first_target {
                        v
                    } else {
                        v + offset
                    }
                })
            })
        })
        .collect()
}

fn paper_search(input: &Input, params: &CompleteParams) -> Search {
    Search {
        rotations: params.rotations,
        mu: color_share(input, params),
        tolerance: params.tolerance,
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "costs on a stencil are single"
)]
fn stencil_params(input: &Input, params: &CompleteParams, seed: [u32; 2]) -> StencilParams {
    /// Most similar candidates of every site that coherent search looks at.
    const SIMILAR: usize = 3;
    /// Sites that random search starts from, and random places at each radius around them.
    const STARTS: usize = 6;
    const TRIES: u32 = 3;
    let coherent = params.method == Method::Coherent;
    StencilParams {
        window: params.window,
        spacing: input.spacing.spacing,
        mu: color_share(input, params),
        exemplar: ExemplarParams {
            rotations: params.rotations,
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

/// μ, as asked for or by default: half, where there are colours.
fn color_share(input: &Input, params: &CompleteParams) -> f64 {
    match input.colors {
        Some(_) => params.mu.unwrap_or(0.5),
        None => 0.0,
    }
}
