//! The gaps that lie on one base surface, filled together.

use nalgebra::Point3;

use crate::base::{BaseSurface, FitReport};
use crate::matching::paper::{Match, Samples, Search};
use crate::mesh::{Adjacency, TriMesh, triangle_normal};
use crate::relief::{self, Relief};
use crate::rng::{Rng, Stage};
use crate::sampling::{Fill, Gap, fill, subdivide};

use super::growth::{Canvas, Grown, Growth, GrowthParams};
use super::{Clock, CompleteParams, FilledHole, Input, Progress, SkippedHole, Work};

/// A base surface and the part of the scan that lies on it.
#[derive(Debug)]
pub(super) struct Patch {
    pub(super) base: BaseSurface,
    pub(super) relief: Relief,
    /// By vertex: whether it lies on the base (is relief).
    pub(super) on_base: Vec<bool>,
    /// The triangles that can be copied from: corners on the base, not folded over.
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
        let triangles = (input.mesh.triangles.iter())
            .filter(|t| (t.iter()).all(|v| on_base[*v as usize] && input.scanned[*v as usize]))
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
            triangles,
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
        let total = planned.last().map_or(0, |last| last.targets.end);
        let mut canvas = self.canvas(input, &planned);
        let mut rng = Rng::new(params.seed, Stage::Completion, work.patches);
        work.patches += 1;
        let grown = if total == 0 {
            Grown {
                matches: Vec::new(),
                sources: Vec::new(),
            }
        } else {
            let samples = self.samples(&input.mesh, &self.relief, input.colors.as_deref());
            clock.end("samples");
            if !self.own {
                work.samples = samples.len();
            }
            let growth = Growth::new(&mut canvas, &self.base, growth_params(input, params));
            let joint = params.bootstrap.then(|| joint_triangles(input, &planned));
            let grown = growth.run(
                samples,
                &mut rng,
                |canvas| joint.as_ref().map(|joint| self.renewed(canvas, joint)),
                |done| {
                    (clock.progress)(Progress {
                        stage: "growth",
                        done,
                        total,
                    });
                },
            );
            clock.end("growth");
            grown
        };
        for gap in planned {
            self.collect(gap, &canvas, &grown, work);
        }
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
        let matches: Vec<Option<Match>> = grown.matches[gap.targets.clone()].to_vec();
        let unmatched = matches.iter().filter(|found| found.is_none()).count();
        if unmatched > 0 {
            work.skipped.push(SkippedHole {
                loops: gap.loops,
                reason: format!(
                    "{unmatched} of its {} new vertices found no match: nowhere does the scan show a surrounding like theirs; try a smaller --window or a larger --spacing",
                    matches.len()
                ),
            });
            return;
        }
        let costs = matches.iter().flatten().map(|found| found.cost);
        let vertices =
            canvas.first_target + gap.targets.start..canvas.first_target + gap.targets.end;
        work.added.push(Added {
            points: canvas.points[vertices.clone()].to_vec(),
            heights: canvas.relief.heights[vertices.clone()].to_vec(),
            colors: (canvas.colors.as_ref()).map(|colors| colors[vertices].to_vec()),
            sources: grown.sources[gap.targets].to_vec(),
            report: FilledHole {
                loops: gap.loops,
                vertices: matches.len(),
                faces: gap.fill.triangles.len(),
                mean_cost: costs.clone().sum::<f64>() / matches.len().max(1) as f64,
                worst_cost: costs.fold(0.0, f64::max),
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

fn growth_params(input: &Input, params: &CompleteParams) -> GrowthParams {
    GrowthParams {
        window: params.window,
        spacing: input.spacing.spacing,
        error_threshold: params.error_threshold,
        search: Search {
            rotations: params.rotations,
            mu: match input.colors {
                Some(_) => params.mu.unwrap_or(0.5),
                None => 0.0,
            },
            tolerance: params.tolerance,
        },
    }
}
