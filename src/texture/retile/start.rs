//! The input as a mesh to be changed: simplicial, and fine enough that its vertices can walk.

use super::OnTriangle;
use super::ground::Ground;
use super::half_edges::{HalfEdges, next, previous};
use super::net::{Net, Site};

/// Longer edges are split first, in rounds down to this share of those of the round before.
const ROUND: f64 = 0.7;

/// Splitting long edges of needles may take this many times the vertices asked for (or those of the input), not
/// more.
const MOST_VERTICES: usize = 4;

/// The input while nothing but splits has been done to it, so that every triangle is part of one of the
/// input's: which one, and the shares of its corners there.
#[derive(Debug)]
pub(super) struct Start<'a> {
    net: Net<'a>,
    homes: Vec<(u32, [[f64; 3]; 3])>,
}

impl<'a> Start<'a> {
    /// Of the triangles joined and the rim that each vertex is on.
    pub(super) fn new(ground: &'a Ground, edges: HalfEdges, on: &[Option<(u32, f64)>]) -> Self {
        let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let homes = (0u32..).zip(edges.triangles()).map(|(f, _)| (f, corners));
        let homes = homes.collect();
        let sites: Vec<Site> = (0..edges.vertex_numbers())
            .map(|v| {
                let h = edges.outgoing(v);
                let place = OnTriangle {
                    triangle: h / 3,
                    weights: corners[h as usize % 3],
                };
                Site {
                    place,
                    rim: on[v as usize],
                    fixed: false,
                }
            })
            .collect();
        let net = Net {
            ground,
            edges,
            spots: sites.iter().map(|s| ground.spot(&s.place)).collect(),
            sites,
        };
        let mut start = Self { net, homes };
        start.part_doubles();
        start
    }

    /// Splits what is longer than `most`, until about `vertices` are there.
    pub(super) fn refined(mut self, most: f64, vertices: usize) -> Net<'a> {
        let limit = MOST_VERTICES * vertices.max(self.net.edges.vertices()) + 64;
        let mut round = (self.net.each_edge())
            .map(|h| self.net.length(h))
            .fold(0.0, f64::max);
        while round > most {
            round = (round * ROUND).max(most);
            let mut h = 0;
            while h < self.net.edges.len() {
                if self.net.edges.is_edge(h) && self.net.length(h) > round {
                    if self.net.edges.vertices() >= limit {
                        return self.net;
                    }
                    self.split(h);
                }
                h += 1;
            }
        }
        self.net
    }

    /// Splits edges where two join the same vertices: both sides of a lone pair of triangles back to
    /// back, and edges of the boundary.
    fn part_doubles(&mut self) {
        for f in 0..self.net.edges.len() / 3 {
            let across = [3 * f, 3 * f + 1].map(|h| self.net.edges.opposite(h));
            if let [Some(one), Some(other)] = across
                && one / 3 == other / 3
            {
                self.split_triangle(3 * f);
            }
        }
        let ends = |h: u32| {
            let (a, b) = (self.net.edges.origin(h), self.net.edges.target(h));
            (a.min(b), a.max(b))
        };
        let mut edges: Vec<((u32, u32), u32)> =
            self.net.each_edge().map(|h| (ends(h), h)).collect();
        edges.sort_unstable();
        let doubles: Vec<u32> = (edges.chunk_by(|a, b| a.0 == b.0))
            .filter(|same| same.len() > 1)
            .flat_map(|same| same.iter().map(|(_, h)| *h))
            .collect();
        for h in doubles {
            self.split(h);
        }
    }

    fn split(&mut self, h: u32) {
        let (f, k) = (h as usize / 3, h as usize % 3);
        let opposite = self.net.edges.opposite(h);
        let halves = self.halves(h);
        let site = if opposite.is_none() {
            self.net.middle_on_rim(h)
        } else {
            None
        };
        let site = site.unwrap_or_else(|| {
            let triangle = self.homes[f].0;
            let weights = halves;
            Site::inside(OnTriangle { triangle, weights })
        });
        // The new triangles are [origin, new, apex] and [new, origin, apex].
        let (home, weights) = self.homes[f];
        self.homes
            .push((home, [weights[k], halves, weights[(k + 2) % 3]]));
        self.homes[f].1[k] = halves;
        if let Some(o) = opposite {
            let (g, l) = (o as usize / 3, o as usize % 3);
            let halves = self.halves(o);
            let (home, weights) = self.homes[g];
            let [origin, apex] = [weights[(l + 1) % 3], weights[(l + 2) % 3]];
            self.homes.push((home, [halves, origin, apex]));
            self.homes[g].1[(l + 1) % 3] = halves;
        }
        self.net.edges.split(h);
        self.net.push(site);
    }

    fn split_triangle(&mut self, h: u32) {
        let f = h as usize / 3;
        let (home, weights) = self.homes[f];
        let [a, b, c] = [h, next(h), previous(h)].map(|h| weights[h as usize % 3]);
        let center = [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0);
        let site = Site::inside(OnTriangle {
            triangle: home,
            weights: center,
        });
        self.homes[f].1[(h as usize + 2) % 3] = center;
        self.homes
            .extend([(home, [b, c, center]), (home, [c, a, center])]);
        self.net.edges.split_triangle(h);
        self.net.push(site);
    }

    /// The shares of a triangle's corners half-way along a half-edge of it.
    fn halves(&self, h: u32) -> [f64; 3] {
        let weights = &self.homes[h as usize / 3].1;
        let [a, b] = [h, next(h)].map(|h| weights[h as usize % 3]);
        [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]))
    }
}
