//! What a tile is given: its targets, what surrounds them, and something to copy from.

use std::ops::ControlFlow;

use super::super::growth::Canvas;
use super::division::surrounded;
use super::nearest_first::nearest_first;

/// The vertices of a tile, each ascending.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Region {
    pub(super) scanned: Vec<u32>,
    /// Targets of other tiles.
    pub(super) others: Vec<u32>,
    pub(super) own: Vec<u32>,
}

/// What a region is chosen from.
pub(super) struct Choice<'a> {
    pub(super) canvas: &'a Canvas,
    /// By vertex: whether it may be copied from.
    pub(super) samples: &'a [bool],
    /// In the scan's unit, along edges.
    pub(super) overlap: f64,
    /// How far a window reaches, and the length of an edge.
    pub(super) reach: f64,
    pub(super) edge: f64,
    /// Most vertices.
    pub(super) most: usize,
}

/// Vertices taken so far.
struct Taken {
    is_taken: Vec<bool>,
    count: usize,
}

impl Taken {
    fn take(&mut self, v: u32) {
        if !std::mem::replace(&mut self.is_taken[v as usize], true) {
            self.count += 1;
        }
    }

    /// Takes all of some vertices, if there are not more than `most` then.
    fn take_all(&mut self, vertices: &[u32], most: usize) -> bool {
        let is_new = |v: &&u32| !self.is_taken[**v as usize];
        let fits = self.count + vertices.iter().filter(is_new).count() <= most;
        if fits {
            vertices.iter().for_each(|v| self.take(*v));
        }
        fits
    }
}

impl Choice<'_> {
    /// The region of some targets; everything, if that is not too much. Beyond the overlap only what can be
    /// copied from. Half of the room for that is for what is around where the targets beside were copied from (`source`,
    /// corners for those that are known), so that they can be continued; the rest for what is nearest.
    pub(super) fn region(&self, own: &[u32], source: impl Fn(u32) -> Option<[u32; 3]>) -> Region {
        let count = self.canvas.points.len();
        let mut taken = Taken {
            is_taken: vec![false; count],
            count: 0,
        };
        if count <= self.most {
            taken.is_taken.fill(true);
            return self.sorted(own, &taken);
        }
        let near = surrounded(self.canvas, own, self.overlap);
        near.iter().for_each(|v| taken.take(*v));
        let half = taken.count + self.most.saturating_sub(taken.count) / 2;
        let beside = self.beside(own);
        let sources = (near.iter().filter(|v| beside[**v as usize])).filter_map(|v| source(*v));
        let continued = self.take_discs(sources, half, &mut taken);
        self.take_samples(&continued, half, &mut taken);
        self.take_samples(own, self.most, &mut taken);
        self.take_loose_samples(own, &mut taken);
        self.sorted(own, &taken)
    }

    /// By vertex: whether it is a neighbor of some targets, and none of them. No other sources are ever continued.
    fn beside(&self, own: &[u32]) -> Vec<bool> {
        let mut is_beside = vec![false; self.canvas.points.len()];
        for v in own {
            for n in self.canvas.adjacency.neighbors.row(*v as usize) {
                is_beside[*n as usize] = true;
            }
        }
        own.iter().for_each(|v| is_beside[*v as usize] = false);
        is_beside
    }

    /// Takes the samples around one source after the other, as long as there are not more than `most`; gives
    /// the corners of these sources. A source without a whole window around it cannot be continued.
    fn take_discs(
        &self,
        sources: impl Iterator<Item = [u32; 3]>,
        most: usize,
        taken: &mut Taken,
    ) -> Vec<u32> {
        /// What is smooth at a vertex follows from two rings around it.
        const RINGS: f64 = 2.0;
        let canvas = self.canvas;
        let mut is_inside = vec![false; canvas.points.len()];
        let mut continued = Vec::new();
        for corners in sources {
            if corners.iter().any(|v| is_inside[*v as usize]) {
                continue;
            }
            let (neighbors, feet) = (&canvas.adjacency.neighbors, &canvas.relief.feet);
            let (mut disc, mut inside) = (Vec::new(), Vec::new());
            nearest_first(neighbors, feet, &corners, |v, distance| {
                if distance > self.reach + RINGS * self.edge {
                    return ControlFlow::Break(());
                }
                // Sources so near to each other see nearly the same.
                if distance <= RINGS * self.edge {
                    inside.push(v);
                }
                if self.samples[v as usize] {
                    disc.push(v);
                }
                ControlFlow::Continue(())
            });
            if !taken.take_all(&disc, most) {
                // Better a part of one than nothing.
                if continued.is_empty() {
                    continued.extend(corners);
                }
                break;
            }
            inside.iter().for_each(|v| is_inside[*v as usize] = true);
            continued.extend(corners);
        }
        continued
    }

    /// Takes the samples nearest to some vertices, until there are `most`.
    fn take_samples(&self, start: &[u32], most: usize, taken: &mut Taken) {
        let canvas = self.canvas;
        nearest_first(
            &canvas.adjacency.neighbors,
            &canvas.relief.feet,
            start,
            |v, _| {
                if taken.count >= most {
                    return ControlFlow::Break(());
                }
                if self.samples[v as usize] {
                    taken.take(v);
                }
                ControlFlow::Continue(())
            },
        );
    }

    /// Takes the nearest samples to which no edges lead: those of other pieces of surface.
    fn take_loose_samples(&self, own: &[u32], taken: &mut Taken) {
        if taken.count >= self.most {
            return;
        }
        let feet = &self.canvas.relief.feet;
        let middle = own[own.len() / 2] as usize;
        let mut left: Vec<(f64, u32)> = (0u32..)
            .zip(self.samples)
            .filter(|(v, is_sample)| **is_sample && !taken.is_taken[*v as usize])
            .map(|(v, _)| ((feet[v as usize] - feet[middle]).norm_squared(), v))
            .collect();
        left.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, v) in left.into_iter().take(self.most - taken.count) {
            taken.take(v);
        }
    }

    fn sorted(&self, own: &[u32], taken: &Taken) -> Region {
        let mut region = Region {
            own: own.to_vec(),
            ..Region::default()
        };
        for (v, _) in (0u32..).zip(&taken.is_taken).filter(|(_, is)| **is) {
            if (v as usize) < self.canvas.first_target {
                region.scanned.push(v);
            } else if own.binary_search(&v).is_err() {
                region.others.push(v);
            }
        }
        region
    }
}

#[cfg(test)]
mod tests {
    use super::super::division::tests::sheet;
    use super::*;
    use nalgebra::Point3;

    fn choice<'a>(canvas: &'a Canvas, samples: &'a [bool]) -> Choice<'a> {
        Choice {
            canvas,
            samples,
            overlap: 6.0,
            reach: 3.0,
            edge: 1.0,
            most: 900,
        }
    }

    /// Scattered over the scan, in whatever order the targets come.
    fn scattered(canvas: &Canvas, v: u32) -> Option<[u32; 3]> {
        let v = (v as usize).checked_sub(canvas.first_target)?;
        let is_scanned = |t: &&[u32; 3]| t.iter().all(|v| canvas.known[*v as usize]);
        let scanned: Vec<&[u32; 3]> = canvas.triangles.iter().filter(is_scanned).collect();
        Some(*scanned[(v * 7919 + 13) % scanned.len()])
    }

    #[test]
    fn however_scattered_the_others_sources_are_there_is_surface_to_copy_from() {
        let canvas = sheet(20);
        let samples = canvas.known.clone();
        let choice = choice(&canvas, &samples);
        // Four by four in the middle of the hole.
        let is_own = |v: &u32| {
            let p = canvas.points[*v as usize];
            [p.x, p.y].iter().all(|x| (18.0..22.0).contains(x))
        };
        let targets = canvas.first_target..canvas.points.len();
        let own: Vec<u32> = (0u32..).take(targets.end).filter(is_own).collect();
        assert!(own.len() == 16 && targets.contains(&(own[0] as usize)));
        let region = choice.region(&own, |v| scattered(&canvas, v));
        let count = region.scanned.len() + region.others.len() + region.own.len();
        assert_eq!(count, 900);
        let near = surrounded(&canvas, &own, 6.0);
        let is_free = |v: &&u32| !near.contains(v);
        let free: Vec<u32> = region.scanned.iter().filter(is_free).copied().collect();
        assert!(free.len() > 500, "{}", free.len());
        let has_ring = |v: &&u32| {
            let ring = canvas.adjacency.neighbors.row(**v as usize);
            let mut samples = ring.iter().filter(|n| samples[**n as usize]);
            samples.all(|n| region.scanned.binary_search(n).is_ok())
        };
        let whole = free.iter().filter(has_ring).count();
        assert!(2 * whole >= free.len(), "{whole} of {}", free.len());
        // What is continued is there with a window around it: the first source beside the targets.
        let beside = choice.beside(&own);
        let first = near.iter().find(|v| beside[**v as usize]);
        let [corner, ..] = scattered(&canvas, *first.unwrap()).unwrap();
        let middle = canvas.points[corner as usize];
        let mut around = canvas.points[..canvas.first_target].iter().zip(0u32..);
        assert!(around.all(|(p, v)| {
            (p - middle).norm() > 3.0 || region.scanned.binary_search(&v).is_ok()
        }));
    }

    #[test]
    fn sources_of_targets_farther_away_take_no_room() {
        let canvas = sheet(20);
        let samples = canvas.known.clone();
        let choice = choice(&canvas, &samples);
        let is_middle = |v: &u32| canvas.points[*v as usize] == Point3::new(20.0, 20.0, 0.0);
        let count = canvas.points.len();
        let own: Vec<u32> = (0u32..).take(count).filter(is_middle).collect();
        let beside = choice.beside(&own);
        let all = choice.region(&own, |v| scattered(&canvas, v));
        let next = choice.region(&own, |v| {
            scattered(&canvas, v).filter(|_| beside[v as usize])
        });
        assert_eq!(all, next);
        assert_ne!(all, choice.region(&own, |_| None));
    }
}
