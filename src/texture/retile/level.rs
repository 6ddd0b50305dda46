//! One level of a mesh pyramid: a mesh is brought to a number of vertices.

use super::net::Net;

/// Edges longer than this share of the wanted length are split, and shorter than the other collapsed (Botsch &
/// Kobbelt 2004, §4).
const SPLIT: f64 = 4.0 / 3.0;
const COLLAPSE: f64 = 4.0 / 5.0;

/// Rounds of splits, collapses, flips and relaxation.
const ROUNDS: usize = 4;

/// Times that vertices too many or too few are taken out or put in, with relaxation after each.
const EXACT_ROUNDS: usize = 12;

/// Relaxations after the number of vertices has been reached.
const LAST_RELAXATIONS: usize = 4;

/// Length of the edges of `vertices` equilateral triangles' corners that have an area together.
pub(super) fn wanted_length(area: f64, vertices: usize) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "vertices are below 2^32")]
    let vertices = vertices.max(4) as f64;
    (2.0 * area / (3.0f64.sqrt() * vertices)).sqrt()
}

impl Net<'_> {
    /// Brings the mesh to `vertices` vertices, as near as its topology lets it, spread evenly.
    pub(super) fn bring_to(&mut self, vertices: usize) {
        let mut length = wanted_length(self.ground.area(), vertices);
        self.keep_corners(0.5 * length);
        if length > 0.0 && length.is_finite() {
            self.thin_out(length);
            self.reorder();
            for _ in 0..ROUNDS {
                self.split_long(SPLIT * length);
                self.collapse_short(COLLAPSE * length, SPLIT * length);
                self.compact();
                self.flip();
                self.relax();
                self.flip();
                self.relax();
                #[expect(clippy::cast_precision_loss, reason = "vertices are below 2^32")]
                let excess = self.edges.vertices() as f64 / vertices.max(4) as f64;
                length *= excess.sqrt().clamp(0.8, 1.25);
            }
        }
        for _ in 0..EXACT_ROUNDS {
            if !self.make_exact(vertices) {
                break;
            }
            self.compact();
            for _ in 0..2 {
                self.flip();
                self.relax();
            }
        }
        for _ in 0..LAST_RELAXATIONS {
            self.flip();
            self.relax();
        }
        self.flip();
    }

    /// Collapses in steps up to the wanted length, so that triangles do not become needles on the way.
    fn thin_out(&mut self, length: f64) {
        for _ in 0..32 {
            let step = 1.5 * self.mean_length();
            if step >= COLLAPSE * length {
                break;
            }
            let before = self.edges.vertices();
            self.collapse_short(step, SPLIT * length);
            self.compact();
            self.flip();
            if self.edges.vertices() * 20 > before * 19 {
                break;
            }
        }
    }

    /// Splits the longest edges or collapses the shortest, each vertex's once, until the number of vertices is
    /// right or none is left. False if nothing could be done or had to be.
    fn make_exact(&mut self, vertices: usize) -> bool {
        let before = self.edges.vertices();
        if before == vertices {
            return false;
        }
        let grow = before < vertices;
        let mut by_length: Vec<(f64, u32)> =
            self.each_edge().map(|h| (self.length(h), h)).collect();
        by_length.sort_unstable_by(|a, b| {
            let order = if grow {
                b.0.total_cmp(&a.0)
            } else {
                a.0.total_cmp(&b.0)
            };
            order.then(a.1.cmp(&b.1))
        });
        let mut touched = vec![false; self.sites.len()];
        for (_, h) in by_length {
            if self.edges.vertices() == vertices {
                break;
            }
            if !self.edges.is_edge(h) {
                continue;
            }
            let ends = [
                self.edges.origin(h),
                self.edges.target(h),
                self.edges.apex(h),
            ];
            if ends
                .iter()
                .any(|v| touched.get(*v as usize).is_none_or(|t| *t))
            {
                continue;
            }
            let around: Vec<u32> = ends.iter().flat_map(|v| self.edges.neighbors(*v)).collect();
            let done = if grow {
                self.split(h)
            } else {
                self.collapse(h, f64::INFINITY)
            };
            if done {
                for v in around {
                    touched[v as usize] = true;
                }
            }
        }
        self.edges.vertices() != before
    }

    /// Moves the boundary vertices nearest to the rims' corners there, to stay; the others may move again.
    fn keep_corners(&mut self, reach: f64) {
        for site in &mut self.sites {
            site.fixed = false;
        }
        let mut on: Vec<Vec<(f64, u32)>> = vec![Vec::new(); self.ground.rims.len()];
        for (v, site) in (0u32..).zip(&self.sites) {
            if let Some((rim, along)) = site.rim {
                on[rim as usize].push((along, v));
            }
        }
        let ground = self.ground;
        for (number, (rim, mut on)) in (0u32..).zip(ground.rims.iter().zip(on)) {
            on.sort_by(|a, b| a.0.total_cmp(&b.0));
            for corner in rim.corners(reach) {
                let behind = on.partition_point(|(along, _)| *along < corner);
                let (at, after) = (behind % on.len(), (behind + on.len() - 1) % on.len());
                let gap = |i: usize| {
                    let gap = (on[i].0 - corner).abs();
                    gap.min(rim.length() - gap)
                };
                let nearest = on[if gap(at) <= gap(after) { at } else { after }].1;
                let mut site = self.on_rim(number, corner);
                site.fixed = true;
                let held = self.sites[nearest as usize].fixed;
                if !held
                    && !self.turns_over(
                        nearest,
                        &self.ground.spot(&site.place),
                        None,
                        f64::INFINITY,
                    )
                {
                    self.place(nearest, site);
                }
            }
        }
    }
}
