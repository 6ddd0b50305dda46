//! Polar coordinates around the vertices of a surface.

use std::f32::consts::{PI, TAU};

use super::{Place, Surface};

/// Directions around the vertices of a surface, as angles: the angles of the triangles around a vertex inside of the
/// surface are scaled so that they add up to 2π, those on its rim stay as they are. The angle 0 is along some edge.
///
/// # Reference
/// [Zelinka & Garland 2004](crate::bibliography#zelinka--garland-2004), §3: geodesic fans from such directions.
#[derive(Debug, Clone)]
pub struct Charts {
    /// By vertex: where its wedges start in `wedges`; one more than vertices.
    starts: Vec<u32>,
    wedges: Vec<Wedge>,
    /// By vertex: what the angles of its triangles are multiplied by.
    scales: Vec<f32>,
    /// By vertex: whether the surface goes all around it.
    is_inside: Vec<bool>,
}

/// A triangle at a vertex, counterclockwise after the one before.
#[derive(Debug, Clone, Copy)]
struct Wedge {
    triangle: u32,
    corner: u8,
    /// Angles of its two edges at the vertex.
    from: f32,
    to: f32,
    /// The vertices there.
    ends: [u32; 2],
    lengths: [f32; 2],
}

/// A vertex next to another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Next {
    /// The other vertex.
    pub vertex: u32,
    /// Angle of the edge to it.
    pub angle: f32,
    /// Length of the edge.
    pub length: f32,
    /// What has to be added to an angle at the vertex to get that of the same direction at the other.
    pub transport: f32,
}

impl Charts {
    /// Around all vertices of a surface.
    #[must_use]
    pub fn new(surface: &Surface) -> Self {
        let vertices = surface.positions().len();
        let mut charts = Self {
            starts: Vec::with_capacity(vertices + 1),
            wedges: Vec::with_capacity(6 * vertices),
            scales: Vec::with_capacity(vertices),
            is_inside: Vec::with_capacity(vertices),
        };
        charts.starts.push(0);
        for v in (0u32..).take(vertices) {
            charts.push(surface, v);
        }
        charts
    }

    fn push(&mut self, surface: &Surface, v: u32) {
        let first = self.wedges.len();
        let (start, is_inside) = surface
            .first_wedge(v)
            .map_or((None, false), |(start, inside)| (Some(start), inside));
        let mut angle = 0.0;
        let mut next = start;
        while let Some((triangle, corner)) = next {
            let corners = surface.corners(triangle);
            let (one, other) = ((corner + 1) % 3, (corner + 2) % 3);
            let (opening, lengths) = surface.opening(triangle, corner);
            self.wedges.push(Wedge {
                triangle,
                corner: u8::try_from(corner).expect("one of three"),
                from: angle,
                to: angle + opening,
                ends: [corners[one], corners[other]],
                lengths,
            });
            angle += opening;
            next = surface
                .counterclockwise(triangle, corner)
                .filter(|next| Some(*next) != start);
        }
        // A rim that turns by more than a whole turn must not meet itself.
        let scale = if is_inside || angle > TAU {
            TAU / angle.max(f32::MIN_POSITIVE)
        } else {
            1.0
        };
        for wedge in &mut self.wedges[first..] {
            wedge.from *= scale;
            wedge.to *= scale;
        }
        self.scales.push(scale);
        self.is_inside.push(is_inside);
        self.starts
            .push(u32::try_from(self.wedges.len()).expect("three wedges a triangle"));
    }

    fn wedges(&self, v: u32) -> &[Wedge] {
        let v = v as usize;
        &self.wedges[self.starts[v] as usize..self.starts[v + 1] as usize]
    }

    /// Vertex `v`, with the frame's first axis along the direction of an angle; `None` if the surface does not go on
    /// that way.
    #[must_use]
    #[inline]
    pub fn place(&self, surface: &Surface, v: u32, angle: f32) -> Option<Place> {
        let angle = angle.rem_euclid(TAU);
        let wedges = self.wedges(v);
        let at = wedges.partition_point(|wedge| wedge.from <= angle);
        let wedge = wedges.get(at.saturating_sub(1))?;
        if angle > wedge.to && !self.is_inside[v as usize] {
            return None;
        }
        let inside = (angle - wedge.from) / self.scales[v as usize];
        Some(surface.at_corner(wedge.triangle, usize::from(wedge.corner), inside))
    }

    /// The angle at a corner of the place's triangle of the direction of the place's axis, as if it began there.
    ///
    /// Corners of which the triangle is no wedge (where more than two triangles meet) give 0.
    #[must_use]
    #[inline]
    pub fn angle(&self, surface: &Surface, place: &Place, corner: usize) -> f32 {
        let v = surface.corners(place.triangle)[corner];
        let wedge = (self.wedges(v).iter()).find(|w| w.triangle == place.triangle);
        let inside = surface.angle_at(place, corner);
        wedge.map_or(0.0, |w| w.from + self.scales[v as usize] * inside)
    }

    /// The vertices next to a vertex, counterclockwise.
    pub fn next(&self, v: u32) -> impl Iterator<Item = Next> {
        let wedges = self.wedges(v);
        let last = wedges.last().filter(|_| !self.is_inside[v as usize]);
        let firsts = wedges.iter().map(|w| (w.ends[0], w.from, w.lengths[0]));
        let all = firsts.chain(last.map(|w| (w.ends[1], w.to, w.lengths[1])));
        all.map(move |(vertex, angle, length)| Next {
            vertex,
            angle,
            length,
            transport: self
                .angle_to(vertex, v)
                .map_or(0.0, |back| back + PI - angle),
        })
    }

    /// Angle at `v` of its edge to `w`.
    fn angle_to(&self, v: u32, w: u32) -> Option<f32> {
        let wedges = self.wedges(v);
        let first = wedges.iter().find(|wedge| wedge.ends[0] == w);
        let second = || wedges.iter().find(|wedge| wedge.ends[1] == w);
        first
            .map(|wedge| wedge.from)
            .or_else(|| second().map(|wedge| wedge.to))
    }
}

#[cfg(test)]
mod tests;
