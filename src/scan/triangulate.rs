//! Polygons to triangles.

use nalgebra::{Point3, Vector3};

use crate::mesh::triangle_normal;

/// Polygons of more corners are split as a fan: ear clipping takes up to cubic time, and scanners do
/// not deliver such faces.
const MAX_EAR_CLIPPING: usize = 500;

/// Splits one polygon into `polygon.len() - 2` triangles of the same orientation; nothing for fewer
/// than three corners.
///
/// Quads split along the shorter diagonal, unless only the other one leaves both triangles on the
/// same side (a quad with a dent). Larger polygons lose their first ear again and again, as seen
/// along their mean (Newell) normal; where no ear is left (crossing edges, no area) the rest is a fan.
pub(super) fn triangulate(
    polygon: &[u32],
    position: impl Fn(u32) -> Point3<f64>,
    out: &mut Vec<[u32; 3]>,
) {
    match *polygon {
        [] | [_] | [_, _] => {}
        [a, b, c] => out.push([a, b, c]),
        [a, b, c, d] => out.extend(quad([a, b, c, d], position)),
        _ if polygon.len() > MAX_EAR_CLIPPING => fan(polygon, out),
        _ => clip_ears(polygon, position, out),
    }
}

fn quad([a, b, c, d]: [u32; 4], position: impl Fn(u32) -> Point3<f64>) -> [[u32; 3]; 2] {
    let splits = [[[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]];
    let [flat_ac, flat_bd] = splits.map(|[first, second]| {
        let [first, second] = [first, second].map(|t| triangle_normal(t.map(&position)));
        first.dot(&second) > 0.0
    });
    let length_sq = |p, q| (position(p) - position(q)).norm_squared();
    let use_ac = if flat_ac == flat_bd {
        length_sq(a, c) <= length_sq(b, d)
    } else {
        flat_ac
    };
    splits[usize::from(!use_ac)]
}

fn fan(polygon: &[u32], out: &mut Vec<[u32; 3]>) {
    if let [apex, rest @ ..] = polygon {
        out.extend(rest.windows(2).map(|edge| [*apex, edge[0], edge[1]]));
    }
}

fn clip_ears(polygon: &[u32], position: impl Fn(u32) -> Point3<f64>, out: &mut Vec<[u32; 3]>) {
    let mut left = polygon.to_vec();
    let origin = position(polygon[0]);
    let normal: Vector3<f64> = (0..left.len())
        .map(|i| {
            let next = left[(i + 1) % left.len()];
            (position(left[i]) - origin).cross(&(position(next) - origin))
        })
        .sum();
    let side = |a: u32, b: u32, c: u32| triangle_normal([a, b, c].map(&position)).dot(&normal);
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&i| {
            let [a, b, c] = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
            side(a, b, c) > 0.0
                && !left.iter().any(|&p| {
                    ![a, b, c].contains(&p)
                        && side(a, b, p) >= 0.0
                        && side(b, c, p) >= 0.0
                        && side(c, a, p) >= 0.0
                })
        });
        let Some(i) = ear else { break };
        out.push([left[(i + n - 1) % n], left[i], left[(i + 1) % n]]);
        left.remove(i);
    }
    fan(&left, out);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::triangle_area;

    fn split(corners: &[[f64; 2]]) -> (Vec<[u32; 3]>, f64) {
        let position = |v: u32| Point3::new(corners[v as usize][0], corners[v as usize][1], 0.0);
        let polygon: Vec<u32> = (0..u32::try_from(corners.len()).unwrap()).collect();
        let mut out = Vec::new();
        triangulate(&polygon, position, &mut out);
        let area = out.iter().map(|t| triangle_area(t.map(position))).sum();
        (out, area)
    }

    #[test]
    fn quads_split_along_the_shorter_diagonal() {
        let (triangles, _) = split(&[[0.0, 0.0], [1.0, 0.0], [3.0, 1.0], [0.0, 1.0]]);
        assert_eq!(triangles, [[0, 1, 3], [1, 2, 3]]);
        let (triangles, _) = split(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn a_dented_quad_splits_at_its_dent() {
        // The dent is corner 1; the shorter diagonal 0–2 would leave the quad.
        let (triangles, area) = split(&[[0.0, 0.0], [1.0, 1.0], [2.0, 0.0], [1.0, 9.0]]);
        assert_eq!(triangles, [[0, 1, 3], [1, 2, 3]]);
        assert!((area - 8.0).abs() < 1e-12, "{area}");
    }

    #[test]
    fn a_star_is_covered_exactly_once() {
        let corners: Vec<[f64; 2]> = (0..10)
            .map(|i| {
                let radius = if i % 2 == 0 { 2.0 } else { 0.7 };
                let angle = f64::from(i) * std::f64::consts::PI / 5.0;
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        let shoelace: f64 = (0..10)
            .map(|i| {
                let [p, q] = [corners[i], corners[(i + 1) % 10]];
                0.5 * (p[0] * q[1] - p[1] * q[0])
            })
            .sum();
        let (triangles, area) = split(&corners);
        assert_eq!(triangles.len(), 8);
        assert!((area - shoelace).abs() < 1e-12);
    }

    #[test]
    fn degenerate_polygons_still_give_all_triangles() {
        assert_eq!(split(&[[0.0, 0.0]; 7]).0.len(), 5);
        assert_eq!(split(&[[0.0, 0.0]; 2]).0.len(), 0);
        assert_eq!(split(&[[1.0, 0.0]; 1000]).0.len(), 998);
    }
}
