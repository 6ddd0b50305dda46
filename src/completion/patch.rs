//! The gaps that lie on one base surface, filled together.

use nalgebra::{Point3, Vector3};

use crate::base::{BaseSurface, FitReport, Form};
use crate::matching::paper::{Samples, Search};
use crate::mesh::{Adjacency, TriMesh, triangle_normal};
use crate::relief::{self, Relief};
use crate::rng::{Rng, Stage};
use crate::sampling::{Fill, Gap, fill, subdivide};

use super::by_paper::ByPaper;
use super::by_stencil::{ByStencil, NothingToCopy};
use super::growth::{Canvas, Grown, Growth, Matcher};
use super::ready::{Ready, fit_together};
use super::suited::Settings;
use super::{Clock, CompleteParams, FilledHole, Input, Method, Progress, SkippedHole, Work};

/// What to try where nothing matched.
pub(super) const REMEDY: &str = "try a smaller --window or a larger --spacing";

/// A base surface and the part of the scan that lies on it.
#[derive(Debug)]
pub(super) struct Patch {
    pub(super) form: Form,
    pub(super) relief: Relief,
    /// By vertex: whether it lies on the base (is relief).
    pub(super) on_base: Vec<bool>,
    /// The triangles that lie on the base: corners there, not folded over.
    pub(super) lying: Vec<[u32; 3]>,
    /// Those of them that can be copied from.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Whether it lies under some holes and their surroundings only.
    pub(super) own: bool,
}

/// A gap to fill, with the numbers of its loops: one for each rim, then one for each island.
#[derive(Debug, Clone)]
pub(super) struct NumberedGap {
    pub(super) gap: Gap,
    pub(super) rim_ids: Vec<usize>,
    pub(super) island_ids: Vec<usize>,
}

impl NumberedGap {
    /// Takes some loops off the islands.
    pub(super) fn leave_islands(&mut self, taken: &[usize]) {
        let kept: Vec<usize> = (0..self.island_ids.len())
            .filter(|i| !taken.contains(&self.island_ids[*i]))
            .collect();
        self.gap.islands = (kept.iter())
            .map(|i| self.gap.islands[*i].clone())
            .collect();
        self.island_ids = kept.iter().map(|i| self.island_ids[*i]).collect();
    }
}

/// A gap that was filled: vertices numbered on from the scan's last.
#[derive(Debug)]
pub(super) struct Added {
    pub(super) points: Vec<Point3<f64>>,
    pub(super) heights: Vec<f64>,
    pub(super) colors: Option<Vec<[f64; 3]>>,
    pub(super) sources: Vec<u32>,
    pub(super) costs: Vec<f64>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) report: FilledHole,
}

/// A gap with its targets and triangles, not yet grown.
#[derive(Debug)]
pub(super) struct Planned {
    pub(super) loops: Vec<usize>,
    pub(super) fill: Fill,
    /// Corrected normal of each target.
    pub(super) normals: Vec<Vector3<f64>>,
    /// Its targets' place among all targets of the patch.
    pub(super) targets: std::ops::Range<usize>,
}

/// What growing is to be done with.
pub(super) struct Run<'a> {
    pub(super) input: &'a Input,
    pub(super) params: &'a CompleteParams,
    pub(super) settings: Settings,
    /// New triangles, see [`joint_triangles`].
    pub(super) joint: Vec<[u32; 3]>,
    /// Seed, and number of the patch: what all random numbers follow from.
    pub(super) seed: [u32; 2],
}

impl<'a> Run<'a> {
    /// The next of `work`'s patches.
    pub(super) fn new(
        input: &'a Input,
        params: &'a CompleteParams,
        planned: &[Planned],
        work: &mut Work,
    ) -> Self {
        let number = work.patches;
        work.patches += 1;
        Self {
            input,
            params,
            settings: Settings::of_paper(params, input.colors.is_some()),
            joint: joint_triangles(input, planned),
            seed: [params.seed, number],
        }
    }

    fn grow<M: Matcher>(&self, canvas: &mut Canvas, matcher: &mut M, clock: &mut Clock) -> Grown {
        let total = canvas.points.len() - canvas.first_target;
        let mut rng = Rng::new(self.seed[0], Stage::Completion, self.seed[1]);
        let growth = Growth::new(canvas, self.settings.window, self.settings.error_threshold);
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
        Self::new(
            input,
            Form::Primitive(fit.base),
            relief,
            relief::reach(fit),
            None,
        )
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
        Self::new(input, Form::Primitive(*base), relief, reach, Some(region))
    }

    /// The part with the given relief that is at most `reach` high, within `region` if there is one.
    pub(super) fn new(
        input: &Input,
        form: Form,
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
            form,
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
        let planned = self.planned(input, gaps, work, clock);
        self.grow(input, planned, params, work, clock);
    }

    /// Fills the gaps with targets; those that cannot be filled go to `work`.
    pub(super) fn planned(
        &self,
        input: &Input,
        gaps: Vec<NumberedGap>,
        work: &mut Work,
        clock: &mut Clock,
    ) -> Vec<Planned> {
        clock.begin("targets");
        let planned = match self.form.primitive() {
            Some(base) => self.plan(base, input, gaps, work),
            None => Vec::new(),
        };
        clock.end("targets");
        planned
    }

    /// Grows relief and colour over gaps that have their targets; results go to `work`.
    pub(super) fn grow(
        &self,
        input: &Input,
        planned: Vec<Planned>,
        params: &CompleteParams,
        work: &mut Work,
        clock: &mut Clock,
    ) {
        let mut canvas = self.canvas(input, &planned);
        let run = Run::new(input, params, &planned, work);
        let grown = if planned.iter().all(|gap| gap.targets.is_empty()) {
            Ok(Grown::new(0))
        } else if let (Method::Paper, Some(base)) = (params.method, self.form.primitive()) {
            Ok(self.grow_by_paper(base, &run, &mut canvas, work, clock))
        } else {
            self.grow_by_stencil(run, &mut canvas, work, clock)
        };
        let grown = grown.map_err(|error| error.to_string());
        self.collect_all(planned, &canvas, grown, REMEDY, work);
    }

    /// Puts what became of the gaps to `work`; `remedy` is what to try where nothing matched.
    pub(super) fn collect_all(
        &self,
        planned: Vec<Planned>,
        canvas: &Canvas,
        grown: Result<Grown, String>,
        remedy: &str,
        work: &mut Work,
    ) {
        match grown {
            Ok(grown) => {
                for gap in planned {
                    self.collect(gap, canvas, &grown, remedy, work);
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
        base: &BaseSurface,
        run: &Run,
        canvas: &mut Canvas,
        work: &mut Work,
        clock: &mut Clock,
    ) -> Grown {
        let Run {
            input,
            params,
            settings,
            ..
        } = *run;
        clock.begin("samples");
        let samples = self.samples(base, &input.mesh, &self.relief, input.colors.as_deref());
        if !self.own {
            work.samples = samples.len();
        }
        let renew = |canvas: &Canvas| self.renewed(base, canvas, &run.joint);
        let renew: Option<&dyn Fn(&Canvas) -> Samples> = match params.bootstrap {
            true => Some(&renew),
            false => None,
        };
        let (search, spacing) = (paper_search(params, settings), input.spacing.spacing);
        let mut matcher = ByPaper::new(canvas, base, samples, renew, search, spacing, run.seed);
        clock.end("samples");
        run.grow(canvas, &mut matcher, clock)
    }

    /// # Errors
    /// [`NothingToCopy`].
    fn grow_by_stencil(
        &self,
        mut run: Run,
        canvas: &mut Canvas,
        work: &mut Work,
        clock: &mut Clock,
    ) -> Result<Grown, NothingToCopy> {
        let Ready {
            ground,
            samples,
            stencil,
            ..
        } = self.ready(&mut run, canvas, work, clock);
        let mut matcher = ByStencil::new(ground, stencil)?;
        clock.end("samples");
        let grown = run.grow(canvas, &mut matcher, clock);
        work.searched.add(&matcher.searched());
        fit_together(canvas, &samples, matcher.ground(), run.params, work, clock);
        Ok(grown)
    }

    fn plan(
        &self,
        base: &BaseSurface,
        input: &Input,
        gaps: Vec<NumberedGap>,
        work: &mut Work,
    ) -> Vec<Planned> {
        let mut planned: Vec<Planned> = Vec::new();
        for numbered in gaps {
            let NumberedGap {
                gap,
                rim_ids: mut loops,
                island_ids,
            } = numbered;
            let spacing = input.spacing.spacing;
            match fill(base, &self.relief, &input.adjacency, &gap, spacing) {
                Err(error) if error.is_of_the_chart() => work.off_chart.push((
                    NumberedGap {
                        gap,
                        rim_ids: loops,
                        island_ids,
                    },
                    error.to_string(),
                )),
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
                        normals: (fill.targets.iter())
                            .map(|foot| base.foot(foot).normal * self.relief.side)
                            .collect(),
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

    fn samples(
        &self,
        base: &BaseSurface,
        mesh: &TriMesh,
        relief: &Relief,
        colors: Option<&[[f64; 3]]>,
    ) -> Samples {
        let surface = TriMesh {
            positions: mesh.positions.clone(),
            triangles: self.triangles.clone(),
        };
        Samples::new(base, &subdivide(&surface, base, relief, colors))
    }

    /// Samples of all that is known by now.
    fn renewed(&self, base: &BaseSurface, canvas: &Canvas, joint: &[[u32; 3]]) -> Samples {
        let new = (joint.iter()).filter(|t| t.iter().all(|v| canvas.known[*v as usize]));
        let surface = TriMesh {
            positions: canvas.points.clone(),
            triangles: self.triangles.iter().chain(new).copied().collect(),
        };
        let colors = canvas.colors.as_deref();
        Samples::new(base, &subdivide(&surface, base, &canvas.relief, colors))
    }

    /// Scan and targets as one surface.
    pub(super) fn canvas(&self, input: &Input, planned: &[Planned]) -> Canvas {
        let first_target = input.mesh.positions.len();
        let mut relief = self.relief.clone();
        let mut known = self.on_base.clone();
        for gap in planned {
            relief.feet.extend(&gap.fill.targets);
            relief.normals.extend(&gap.normals);
        }
        relief.heights.resize(relief.feet.len(), 0.0);
        known.resize(relief.feet.len(), false);
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
            triangles: mesh.triangles,
            colors: input.colors.clone().map(|mut colors| {
                colors.resize(relief.feet.len(), [0.0; 3]);
                colors
            }),
            relief,
            known,
            first_target,
        }
    }

    fn collect(&self, gap: Planned, canvas: &Canvas, grown: &Grown, remedy: &str, work: &mut Work) {
        let costs = &grown.costs[gap.targets.clone()];
        let unmatched = costs.iter().filter(|cost| cost.is_none()).count();
        if unmatched > 0 {
            work.skipped.push(SkippedHole {
                loops: gap.loops,
                reason: format!(
                    "{unmatched} of its {} new vertices found no match: nowhere does the scan show a surrounding like theirs; {remedy}",
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
            costs: matched.clone().collect(),
            report: FilledHole {
                loops: gap.loops,
                vertices: costs.len(),
                faces: gap.fill.triangles.len(),
                mean_cost: matched.clone().sum::<f64>() / costs.len().max(1) as f64,
                worst_cost: matched.fold(0.0, f64::max),
                own_base: self.own.then_some(self.form),
            },
            triangles: gap.fill.triangles,
        });
    }
}

/// The fills' triangles with the targets of all gaps numbered in a row.
pub(super) fn joint_triangles(input: &Input, planned: &[Planned]) -> Vec<[u32; 3]> {
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

fn paper_search(params: &CompleteParams, settings: Settings) -> Search {
    Search {
        rotations: settings.rotations,
        mu: settings.mu,
        tolerance: params.tolerance,
    }
}
