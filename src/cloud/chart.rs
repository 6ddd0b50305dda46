//! The Delaunay triangulation in the conformal chart of a base surface.

use spade::{DelaunayTriangulation, HasPosition, Triangulation};

use super::CloudError;
use super::local::finished;
use super::points::index;
use super::stars::{Stars, lowest_first};
use crate::base::{BaseSurface, Chart};

/// A point in the chart.
#[derive(Debug, Clone, Copy)]
struct Charted {
    position: spade::Point2<f64>,
    point: u32,
}

impl HasPosition for Charted {
    type Scalar = f64;
    fn position(&self) -> spade::Point2<f64> {
        self.position
    }
}

/// Normals that lean farther than this from the base's, as a cosine, are of an overhang or of a second
/// layer.
const UPRIGHT: f64 = 0.2;

/// How the cloud lies over a base surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lie {
    /// 1 if the normals point out of the base, −1 if into it.
    pub(super) side: f64,
    /// Share of the points that do not face this side.
    pub(super) overhanging: f64,
}

pub(super) fn lie(stars: &Stars, base: &BaseSurface) -> Lie {
    let cosines: Vec<f64> = (stars.points.positions.iter().zip(stars.normals))
        .map(|(p, n)| base.foot(p).normal.dot(n))
        .collect();
    let side = if cosines.iter().sum::<f64>() < 0.0 {
        -1.0
    } else {
        1.0
    };
    let overhanging = cosines.iter().filter(|c| *c * side < UPRIGHT).count();
    Lie {
        side,
        overhanging: overhanging as f64 / cosines.len() as f64,
    }
}

/// Triangles of the plane Delaunay triangulation of the points' feet in the chart of `base`, without
/// those that an edge in space is too long for.
pub(super) fn triangulate(
    stars: &Stars,
    base: &BaseSurface,
    side: f64,
) -> Result<Vec<[u32; 3]>, CloudError> {
    let positions = &stars.points.positions;
    // On a sphere, the pole from which the chart is seen is one of the points. It belongs to the
    // triangles at the hull of the others; so a whole sphere closes, and elsewhere these are too long.
    let eye = matches!(base, BaseSurface::Sphere(_)).then_some(positions.len() - 1);
    let middle = match (base, eye) {
        (BaseSurface::Sphere(sphere), Some(eye)) => {
            sphere.center - (positions[eye] - sphere.center)
        }
        _ => positions[0],
    };
    let chart = Chart::new(base, side, &middle);
    let charted = (0..eye.unwrap_or(positions.len())).map(|i| {
        let at = chart.to_plane(&base.foot(&positions[i]).point);
        let snapped = |x: f64| {
            if x.abs() < spade::MIN_ALLOWED_VALUE {
                0.0
            } else {
                x
            }
        };
        Charted {
            position: spade::Point2::new(snapped(at.x), snapped(at.y)),
            point: index(i),
        }
    });
    let delaunay = DelaunayTriangulation::<Charted>::bulk_load_stable(charted.collect())
        .map_err(|_| CloudError::ChartRange)?;
    let mut triangles: Vec<[u32; 3]> = (delaunay.inner_faces())
        .map(|face| face.vertices().map(|v| v.data().point))
        .collect();
    if let Some(eye) = eye {
        // The hull runs around clockwise, so that the eye, far outside, is on its left.
        triangles.extend(delaunay.convex_hull().map(|edge| {
            let [from, to] = edge.vertices().map(|v| v.data().point);
            [from, to, index(eye)]
        }));
    }
    let short = |&[a, b, c]: &[u32; 3]| {
        [[a, b], [b, c], [c, a]]
            .iter()
            .all(|[v, w]| stars.points.distance(*v, *w) <= stars.longest_edge(*v, *w))
    };
    triangles.retain(short);
    for triangle in &mut triangles {
        *triangle = lowest_first(*triangle);
    }
    Ok(finished(triangles, stars.points))
}
