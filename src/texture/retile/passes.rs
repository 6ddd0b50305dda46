//! What makes a mesh even: long edges are split, short ones collapsed, others flipped, and vertices relaxed
//! along the surface (Botsch & Kobbelt, *A remeshing approach to multiresolution modeling*, 2004).

use nalgebra::Vector3;
use rayon::prelude::*;

use super::ground::Spot;
use super::half_edges::NONE;
use super::net::{Net, Site};
use crate::mesh::triangle_normal;

/// A triangle that is changed must keep this cosine between its normals before and after.
const LEAST_COSINE: f64 = 0.1;

/// The part of the way to the middle of its neighbors that a vertex goes at once.
const PACE: f64 = 0.8;

/// Cosine between the normals of two triangles below which the surface is folded at their edge: 100 degrees.
const FOLD: f64 = -0.17;

/// After so many rounds of taking vertices back all are.
const TAKE_BACK_ROUNDS: usize = 8;

impl Net<'_> {
    /// Splits the edges longer than `most`.
    pub(super) fn split_long(&mut self, most: f64) {
        for h in 0..self.edges.len() {
            if self.edges.is_edge(h) && self.length(h) > most {
                self.split(h);
            }
        }
    }

    /// Puts a vertex in the middle of an edge; false if one cannot walk there.
    pub(super) fn split(&mut self, h: u32) -> bool {
        let middle = if self.edges.opposite(h).is_none() {
            self.middle_on_rim(h)
        } else {
            self.middle_inside(h)
        };
        if let Some(site) = middle {
            self.edges.split(h);
            self.push(site);
        }
        middle.is_some()
    }

    fn middle_inside(&self, h: u32) -> Option<Site> {
        let ends = [self.edges.origin(h), self.edges.target(h)];
        let half = 0.5 * (self.point(ends[1]) - self.point(ends[0]));
        let normal = self.normal_at(h) + self.normal_at(self.edges.opposite(h)?);
        let normal = normal.try_normalize(0.0)?;
        let walk = |v: u32, way: Vector3<f64>| {
            let place = &self.sites[v as usize].place;
            self.ground.walk(place, &way, &normal)
        };
        let place = walk(ends[0], half).or_else(|| walk(ends[1], -half))?;
        Some(Site::inside(place))
    }

    /// Collapses edges shorter than `least`, where that makes none longer than `most`.
    pub(super) fn collapse_short(&mut self, least: f64, most: f64) {
        for h in 0..self.edges.len() {
            if self.edges.is_edge(h) && self.length(h) < least {
                self.collapse(h, most);
            }
        }
    }

    /// Collapses an edge towards one of its ends, where that makes none longer than `most` and turns no
    /// triangle over.
    pub(super) fn collapse(&mut self, h: u32, most: f64) -> bool {
        // A boundary edge has one half-edge only; the other way round its ends change places.
        let Some(o) = self.edges.opposite(h) else {
            return self.collapse_on_rim(h, most);
        };
        let may = [h, o].map(|h| self.may_collapse(h, most));
        // What is on a fold stays rather than what is not.
        let way = match may {
            [false, false] => return false,
            [true, true] if self.folds(o) < self.folds(h) => o,
            [true, _] => h,
            [false, true] => o,
        };
        self.edges.collapse(way);
        true
    }

    /// Number of folded edges at the half-edge's origin.
    fn folds(&self, h: u32) -> usize {
        let fan = self.edges.fan(self.edges.origin(h));
        fan.filter(|h| {
            let normals = (self.edges.opposite(*h)).map(|o| [*h, o].map(|h| self.normal_at(h)));
            normals.is_some_and(|[one, other]| is_folded(&one, &other))
        })
        .count()
    }

    /// Collapses a boundary edge into its target; if its origin has to stay, that is moved there.
    fn collapse_on_rim(&mut self, h: u32, most: f64) -> bool {
        let (a, b) = (self.edges.origin(h), self.edges.target(h));
        if self.sites[a as usize].fixed && self.sites[b as usize].fixed {
            return false;
        }
        if !self.sites[a as usize].fixed && self.may_collapse(h, most) {
            self.edges.collapse(h);
            return true;
        }
        if self.sites[b as usize].fixed {
            return false;
        }
        // Which end is left is one for the topology: the target takes the origin's place.
        let corner = self.sites[a as usize];
        let may = self.edges.can_collapse(h)
            && !self.turns_over(b, &self.spots[a as usize], Some(a), most);
        if may {
            self.place(b, corner);
            self.edges.collapse(h);
        }
        may
    }

    fn may_collapse(&self, h: u32, most: f64) -> bool {
        let (a, b) = (self.edges.origin(h), self.edges.target(h));
        // The topology takes longest to look at.
        !self.sites[a as usize].fixed
            && !self.turns_over(a, &self.spots[b as usize], Some(b), most)
            && self.edges.can_collapse(h)
    }

    /// Whether a triangle of vertex `v`, not one with `merged`, turns over if the vertex goes to another
    /// place, or gets an edge longer than `most`.
    pub(super) fn turns_over(&self, v: u32, to: &Spot, merged: Option<u32>, most: f64) -> bool {
        let from = &self.spots[v as usize];
        self.edges.fan(v).any(|h| {
            let ends = [self.edges.target(h), self.edges.apex(h)];
            if ends.iter().any(|end| Some(*end) == merged) {
                return false;
            }
            let [p, q] = ends.map(|end| &self.spots[end as usize]);
            let long = [p, q].map(|end| (end.point - to.point).norm() > most);
            long != [false; 2] || has_turned([from, p, q], [to, p, q])
        })
    }

    /// Flips edges until the circumcircles are empty (Delaunay), as far as the surface lets it.
    pub(super) fn flip(&mut self) {
        let mut flips = 0;
        let mut around = Vec::new();
        for h in 0..self.edges.len() {
            if self.edges.is_edge(h) {
                around.push(h);
            }
            while let Some(h) = around.pop() {
                if self.wants_flip(h) && self.edges.can_flip(h) {
                    let o = self.edges.opposite(h);
                    self.edges.flip(h);
                    flips += 1;
                    // On a surface that is not flat flips need not come to an end.
                    if flips > self.edges.len() {
                        return;
                    }
                    for h in [Some(h), o].into_iter().flatten() {
                        let f = 3 * (h / 3);
                        around.extend([f, f + 1, f + 2]);
                    }
                }
            }
        }
    }

    fn wants_flip(&self, h: u32) -> bool {
        let o = match self.edges.opposite(h) {
            Some(o) if self.edges.origin(h) != NONE => o,
            _ => return false,
        };
        let vertices = [
            self.edges.origin(h),
            self.edges.target(h),
            self.edges.apex(h),
            self.edges.apex(o),
        ];
        let [a, b, c, d] = vertices.map(|v| self.point(v));
        let (cos_c, cos_d) = ((a - c).dot(&(b - c)), (a - d).dot(&(b - d)));
        if cos_c >= 0.0 && cos_d >= 0.0 {
            return false;
        }
        let sin_c = (a - c).cross(&(b - c)).norm();
        let sin_d = (a - d).cross(&(b - d)).norm();
        // sin(c + d) < 0: the angles opposite of the edge are more than half a turn together.
        let excess = cos_c * sin_d + cos_d * sin_c;
        let size = (a - c).norm_squared() * (b - d).norm_squared();
        if excess >= -1e-9 * size {
            return false;
        }
        let [a, b, c, d] = vertices.map(|v| &self.spots[v as usize]);
        let old = normal([a, b, c]) + normal([b, a, d]);
        let faces = !faces_away([a, b, c]) && !faces_away([b, a, d]);
        let turns = |new: [&Spot; 3]| is_turned(&old, &normal(new)) || (faces && faces_away(new));
        !turns([c, a, d]) && !turns([d, b, c])
    }

    /// Moves every vertex towards the middle of its surroundings, along the surface; boundary vertices
    /// along the boundary.
    pub(super) fn relax(&mut self) {
        let old = &*self;
        let (sites, spots): (Vec<Site>, Vec<Spot>) = (0..old.edges.vertex_numbers())
            .into_par_iter()
            .with_min_len(256)
            .map(|v| {
                let here = &old.sites[v as usize];
                let moved = if !old.edges.has_vertex(v) || here.fixed {
                    None
                } else if here.rim.is_some() {
                    old.relaxed_on_rim(v)
                } else {
                    old.relaxed_inside(v)
                };
                match moved {
                    Some(site) => (site, old.ground.spot(&site.place)),
                    None => (*here, old.spots[v as usize]),
                }
            })
            .unzip();
        let sites = std::mem::replace(&mut self.sites, sites);
        let spots = std::mem::replace(&mut self.spots, spots);
        self.take_back(&sites, &spots);
    }

    fn relaxed_inside(&self, v: u32) -> Option<Site> {
        let here = self.point(v);
        let mut normal = Vector3::zeros();
        let (mut sum, mut weights) = (Vector3::zeros(), 0.0);
        let mut folds = Folds::default();
        let last = self.edges.fan(v).last()?;
        let mut before = self.normal_at(last);
        for h in self.edges.fan(v) {
            let [p, q] = [self.edges.target(h), self.edges.apex(h)].map(|v| self.point(v) - here);
            let own = p.cross(&q);
            let area = own.norm();
            folds.add(&before, &own, &p);
            before = own;
            normal += own;
            sum += (p + q) * (area / 3.0);
            weights += area;
        }
        let normal = normal.try_normalize(0.0)?;
        let way = folds.along(&(sum * (PACE / weights)))?;
        let way = way - normal * normal.dot(&way);
        let place = &self.sites[v as usize].place;
        let walk = |share: f64| self.ground.walk(place, &(way * share), &normal);
        let place = walk(1.0).or_else(|| walk(0.3))?;
        Some(Site::inside(place))
    }

    fn relaxed_on_rim(&self, v: u32) -> Option<Site> {
        let (rim, along) = self.sites[v as usize].rim?;
        let next = self.edges.target(self.edges.outgoing(v));
        let last = self.edges.fan(v).last()?;
        let before = self.edges.apex(last);
        let polyline = &self.ground.rims[rim as usize];
        let (_, behind_along) = self.sites[before as usize].rim?;
        let (_, next_along) = self.sites[next as usize].rim?;
        let back = polyline.forward(behind_along, along);
        let on = polyline.forward(along, next_along);
        let here = self.point(v);
        let chords = [before, next].map(|n| (self.point(n) - here).norm());
        let wanted = 0.5 * (chords[1] - chords[0]) * PACE;
        let way = wanted.clamp(-0.4 * back, 0.4 * on);
        Some(self.on_rim(rim, polyline.moved(along, way)))
    }

    /// Puts vertices back to where they were at triangles that have turned over.
    fn take_back(&mut self, sites: &[Site], spots: &[Spot]) {
        for _ in 0..TAKE_BACK_ROUNDS {
            let net = &*self;
            let turned = |t: &&[u32; 3]| {
                let at = |spots: &'_ [Spot]| t.map(|v| spots[v as usize]);
                t[0] != NONE && has_turned(at(spots).each_ref(), at(&net.spots).each_ref())
            };
            let triangles = net.edges.triangles().par_iter().with_min_len(512);
            let turned: Vec<[u32; 3]> = triangles.filter(turned).copied().collect();
            if turned.is_empty() {
                return;
            }
            for v in turned.into_iter().flatten() {
                self.sites[v as usize] = sites[v as usize];
                self.spots[v as usize] = spots[v as usize];
            }
        }
        self.sites.copy_from_slice(sites);
        self.spots.copy_from_slice(spots);
    }
}

/// The edges from a vertex at which the surface is folded back, as around the rim of a thin sheet. There the
/// middle of the neighbors is inwards from everywhere, and vertices that went to it would let the sheet
/// shrink.
#[derive(Debug, Default)]
struct Folds {
    count: usize,
    /// Unit vectors along the first two.
    along: [Vector3<f64>; 2],
}

impl Folds {
    /// An edge along `edge`, and the normals of its two triangles.
    fn add(&mut self, one: &Vector3<f64>, other: &Vector3<f64>, edge: &Vector3<f64>) {
        if is_folded(one, other) {
            if let Some(along) = self.along.get_mut(self.count) {
                *along = edge.try_normalize(0.0).unwrap_or_default();
            }
            self.count += 1;
        }
    }

    /// What of a way goes along the fold, if one runs through the vertex; `None` at the tip of several.
    fn along(&self, way: &Vector3<f64>) -> Option<Vector3<f64>> {
        match self.count {
            0 | 1 => Some(*way),
            2 => {
                let line = (self.along[0] - self.along[1]).try_normalize(0.0)?;
                Some(line * line.dot(way))
            }
            _ => None,
        }
    }
}

fn is_folded(one: &Vector3<f64>, other: &Vector3<f64>) -> bool {
    one.dot(other) < FOLD * one.norm() * other.norm()
}

fn normal(corners: [&Spot; 3]) -> Vector3<f64> {
    triangle_normal(corners.map(|corner| corner.point))
}

/// Whether a triangle faces away from the input at its corners.
fn faces_away(corners: [&Spot; 3]) -> bool {
    let around = corners[0].normal + corners[1].normal + corners[2].normal;
    normal(corners).dot(&around) <= 0.0
}

/// Whether a triangle has turned over, against what it was or against the input.
fn has_turned(old: [&Spot; 3], new: [&Spot; 3]) -> bool {
    is_turned(&normal(old), &normal(new)) || (faces_away(new) && !faces_away(old))
}

/// Whether a triangle, by its normals before and after, has turned over or lost its area; one without area
/// can turn into any.
fn is_turned(old: &Vector3<f64>, new: &Vector3<f64>) -> bool {
    let cosine = old.dot(new);
    let least = LEAST_COSINE * LEAST_COSINE * old.norm_squared() * new.norm_squared();
    old.norm_squared() > 0.0 && (cosine <= 0.0 || cosine * cosine <= least)
}
