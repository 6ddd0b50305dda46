//! The smallest rectangle around points of the plane.

use nalgebra::{Point2, Vector2};

/// The rectangle of least area around points of the plane, as corner and edge vectors: one of its
/// sides lies along an edge of the convex hull (Freeman & Shapira 1975).
pub(super) fn bounding_rectangle(points: &[Point2<f64>]) -> (Point2<f64>, [Vector2<f64>; 2]) {
    let hull = convex_hull(points);
    let mut best = (f64::INFINITY, Point2::origin(), Default::default());
    for i in 0..hull.len() {
        let Some(x) = (hull[(i + 1) % hull.len()] - hull[i]).try_normalize(0.0) else {
            continue;
        };
        let y = Vector2::new(-x.y, x.x);
        let extent = |axis: &Vector2<f64>| {
            let along = hull.iter().map(|p| p.coords.dot(axis));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| {
                (low.min(t), high.max(t))
            })
        };
        let ((x0, x1), (y0, y1)) = (extent(&x), extent(&y));
        let area = (x1 - x0) * (y1 - y0);
        if area < best.0 {
            let corner = Point2::from(x * x0 + y * y0);
            best = (area, corner, [x * (x1 - x0), y * (y1 - y0)]);
        }
    }
    (best.1, best.2)
}

/// Counterclockwise convex hull (Andrew's monotone chain).
fn convex_hull(points: &[Point2<f64>]) -> Vec<Point2<f64>> {
    let mut sorted = points.to_vec();
    sorted.sort_unstable_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    let chain = |points: &mut dyn Iterator<Item = &Point2<f64>>| {
        let mut chain: Vec<Point2<f64>> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp(&(p - a)) <= 0.0
            {
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut sorted.iter());
    hull.extend(chain(&mut sorted.iter().rev()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Rotation2;

    #[test]
    fn a_turned_rectangle_is_found() {
        let turn = Rotation2::new(0.3);
        let points: Vec<Point2<f64>> = (0..200)
            .map(|i| {
                let t = f64::from(i);
                turn * Point2::new(2.0 * (1.7 * t).sin(), 0.5 * (2.3 * t).cos())
            })
            .chain(
                [[2.0, 0.5], [-2.0, 0.5], [2.0, -0.5], [-2.0, -0.5]]
                    .map(|p| turn * Point2::from(p)),
            )
            .collect();
        let (corner, [a, b]) = bounding_rectangle(&points);
        let mut sides = [a.norm(), b.norm()];
        sides.sort_by(f64::total_cmp);
        assert_relative_eq!(sides[0], 1.0, epsilon = 1e-9);
        assert_relative_eq!(sides[1], 4.0, epsilon = 1e-9);
        assert_relative_eq!(corner + (a + b) / 2.0, Point2::origin(), epsilon = 1e-9);
    }

    #[test]
    fn points_on_a_line_and_no_points_have_a_flat_one() {
        let line: Vec<Point2<f64>> = (0..5).map(|i| Point2::new(f64::from(i), 0.0)).collect();
        let (_, [a, b]) = bounding_rectangle(&line);
        assert_relative_eq!(a.norm() * b.norm(), 0.0);
        assert_eq!(bounding_rectangle(&[]).0, Point2::origin());
    }
}
