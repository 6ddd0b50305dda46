//! Small gaps between triangles that the stars did not agree on.

use super::fans::{Fans, Sector};
use super::local::circumradius;
use super::points::index;
use super::stars::Stars;

/// Gaps with more edges stay open.
const MOST_EDGES: usize = 8;

/// Closes gaps of a few edges by clipping their ears, the one of the smallest circle first, where the
/// new edges are no longer than the gap allows.
pub(super) fn close(fans: &mut Fans, stars: &Stars) {
    for gap in gaps(fans, stars.points.len()) {
        clip(fans, stars, gap);
    }
}

/// All loops of at most [`MOST_EDGES`] edges around empty sectors, the gap on the left.
fn gaps(fans: &Fans, points: usize) -> Vec<Vec<u32>> {
    let mut starts = Vec::with_capacity(points + 1);
    let mut sectors: Vec<(Sector, bool)> = Vec::new();
    for v in 0..points {
        starts.push(sectors.len());
        sectors.extend(fans.sectors(index(v)).into_iter().map(|s| (s, false)));
    }
    starts.push(sectors.len());
    let mut found = Vec::new();
    for v in 0..points {
        for at in starts[v]..starts[v + 1] {
            let (mut at, mut here) = (at, v);
            let mut walk = Vec::new();
            while !sectors[at].1 {
                sectors[at].1 = true;
                walk.push(index(here));
                let next = sectors[at].0.next as usize;
                let comes_from_here = |(s, _): &(Sector, bool)| s.previous == index(here);
                let range = starts[next]..starts[next + 1];
                match sectors[range].iter().position(comes_from_here) {
                    Some(place) => (at, here) = (starts[next] + place, next),
                    None => break,
                }
            }
            // A walk that ran into an earlier one is no loop of its own.
            if (3..=MOST_EDGES).contains(&walk.len()) && here == v {
                found.push(walk);
            }
        }
    }
    found
}

fn clip(fans: &mut Fans, stars: &Stars, mut gap: Vec<u32>) {
    while gap.len() >= 3 {
        let n = gap.len();
        let ear = |i: usize| [gap[(i + n - 1) % n], gap[i], gap[(i + 1) % n]];
        let short =
            |[a, _, c]: [u32; 3]| n == 3 || stars.points.distance(a, c) <= stars.longest_edge(a, c);
        let different = |[a, b, c]: [u32; 3]| a != b && b != c && c != a;
        let mut ears: Vec<(f64, usize)> = (0..n)
            .filter(|i| different(ear(*i)) && short(ear(*i)))
            .map(|i| (circumradius(stars.points, ear(i)), i))
            .collect();
        ears.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some(&(_, i)) = ears.iter().find(|(_, i)| fans.add(ear(*i))) else {
            return;
        };
        if n == 3 {
            return;
        }
        gap.remove(i);
    }
}
