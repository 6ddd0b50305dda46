//! Triangles on the image, and where pixels are in them.

use super::REACH;

/// A place in a triangle from the edge farther than this share of its height is inside; nearer ones may be
/// in the next triangle as well by rounding.
const INSIDE: f64 = 1e-9;

/// A point and a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// Barycentric coordinates of the triangle's nearest point, at least 0, sum 1.
    pub(super) weights: [f64; 3],
    /// Square of the distance to it, in pixels; 0 in the triangle.
    pub(super) distance_sq: f64,
}

impl Place {
    /// Whether the point is in the triangle or on its border.
    pub(super) fn is_covered(&self) -> bool {
        self.distance_sq <= 0.0
    }

    /// Whether the point is in the triangle, not on its border.
    pub(super) fn is_inside(&self) -> bool {
        self.is_covered() && self.weights.iter().all(|w| *w > INSIDE)
    }
}

/// A triangle on the image, in pixels: x to the right, y down.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flat {
    corners: [[f64; 2]; 3],
    /// 1, or −1 if it is seen mirrored.
    turn: f64,
}

impl Flat {
    /// `None` if it has no area.
    pub(super) fn new(corners: [[f64; 2]; 3]) -> Option<Self> {
        let area = side(corners[2], corners[0], corners[1]);
        (area.is_finite() && area != 0.0).then(|| Self {
            corners,
            turn: area.signum(),
        })
    }

    /// First and last row that it may color.
    pub(super) fn rows(&self) -> [i64; 2] {
        let [low, high] = ends(self.corners.iter().map(|c| c[1]));
        pixels(low, high)
    }

    /// First and last column that it may color in the row of that height.
    pub(super) fn columns(&self, y: f64) -> Option<[i64; 2]> {
        let strip = [y - REACH, y + REACH];
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        let mut widen = |x: f64| (low, high) = (low.min(x), high.max(x));
        for k in 0..3 {
            let (from, to) = (self.corners[k], self.corners[(k + 1) % 3]);
            if strip[0] <= from[1] && from[1] <= strip[1] {
                widen(from[0]);
            }
            for border in strip {
                let share = (border - from[1]) / (to[1] - from[1]);
                if (0.0..=1.0).contains(&share) {
                    widen(from[0] + share * (to[0] - from[0]));
                }
            }
        }
        (low <= high).then(|| pixels(low, high))
    }

    /// Where a point is.
    pub(super) fn place(&self, point: [f64; 2]) -> Place {
        let [a, b, c] = self.corners;
        let sides = [(b, c), (c, a), (a, b)].map(|(p, q)| self.turn * side(point, p, q));
        let sum: f64 = sides.iter().sum();
        if sides.iter().all(|s| *s >= 0.0) && sum > 0.0 {
            return Place {
                weights: sides.map(|s| s / sum),
                distance_sq: 0.0,
            };
        }
        let on_edges = [0, 1, 2].map(|k| self.on_edge(point, k));
        let nearest = |best: Place, other: Place| {
            let is_nearer = other.distance_sq < best.distance_sq;
            if is_nearer { other } else { best }
        };
        on_edges[1..]
            .iter()
            .fold(on_edges[0], |best, other| nearest(best, *other))
    }

    /// The nearest point on the edge from corner `k` to the next one.
    fn on_edge(&self, [x, y]: [f64; 2], k: usize) -> Place {
        let next = (k + 1) % 3;
        let ([ax, ay], [bx, by]) = (self.corners[k], self.corners[next]);
        let (dx, dy) = (bx - ax, by - ay);
        let length_sq = dx * dx + dy * dy;
        let along = ((x - ax) * dx + (y - ay) * dy) / length_sq;
        // Corners at the same place: any of both.
        let share = if along.is_finite() {
            along.clamp(0.0, 1.0)
        } else {
            0.0
        };
        let mut weights = [0.0; 3];
        weights[k] = 1.0 - share;
        weights[next] = share;
        let (away_x, away_y) = (x - ax - share * dx, y - ay - share * dy);
        Place {
            weights,
            // Never in the triangle, even if rounding puts it onto the edge.
            distance_sq: (away_x * away_x + away_y * away_y).max(f64::MIN_POSITIVE),
        }
    }
}

/// Twice the area of the triangle of three points, positive where `p` is right of the way from `a` to `b` as y
/// goes down. From b to a it is exactly the opposite, so that no point is outside both triangles at an edge.
fn side(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let area =
        |[ax, ay]: [f64; 2], [bx, by]: [f64; 2]| (bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax);
    let in_order = a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).is_le();
    if in_order { area(a, b) } else { -area(b, a) }
}

fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    })
}

/// The pixels whose centers are between two places or within reach.
#[expect(
    clippy::cast_possible_truncation,
    reason = "within a few images, which have 2^32 pixels a side at most"
)]
fn pixels(low: f64, high: f64) -> [i64; 2] {
    let first = (low - REACH - 0.5).floor() as i64;
    let last = (high + REACH - 0.5).ceil() as i64;
    [first, last]
}
