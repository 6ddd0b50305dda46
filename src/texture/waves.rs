//! Vertices one after the other, in parallel.

use crate::neighborhood::Spots;

/// Vertices in waves: within a wave none reads what another one of it writes.
#[derive(Debug)]
pub(super) struct Waves {
    /// Vertices, wave after wave.
    vertices: Vec<u32>,
    /// Where each wave ends.
    ends: Vec<usize>,
}

impl Waves {
    /// Of visiting the vertices in `order`, where vertex v reads those that its spots lie between. Each vertex reads
    /// what it would have read had they been visited one by one: neighbors are in the same order as there.
    pub(super) fn new(spots: &Spots, order: &[u32]) -> Self {
        let count = spots.len();
        // The wave of a vertex that was visited; before that, the first wave that it may be in.
        let mut wave = vec![0u32; count];
        let mut is_visited = vec![false; count];
        let mut reads = Vec::new();
        for v in order {
            let v = *v as usize;
            reads.clear();
            reads.extend(spots.vertices(v));
            let mut own = wave[v];
            for u in &reads {
                if is_visited[*u as usize] {
                    own = own.max(wave[*u as usize] + 1);
                }
            }
            wave[v] = own;
            is_visited[v] = true;
            for u in &reads {
                let later = &mut wave[*u as usize];
                if !is_visited[*u as usize] {
                    *later = (*later).max(own + 1);
                }
            }
        }
        let waves = order
            .iter()
            .map(|v| wave[*v as usize] as usize + 1)
            .max()
            .unwrap_or(0);
        let mut ends = vec![0; waves];
        for v in order {
            ends[wave[*v as usize] as usize] += 1;
        }
        let mut starts = Vec::with_capacity(waves);
        let mut sum = 0;
        for end in &mut ends {
            starts.push(sum);
            sum += *end;
            *end = sum;
        }
        let mut vertices = vec![0; order.len()];
        for v in order {
            let next = &mut starts[wave[*v as usize] as usize];
            vertices[*next] = *v;
            *next += 1;
        }
        Self { vertices, ends }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut from = 0;
        self.ends.iter().map(move |end| {
            let wave = &self.vertices[from..*end];
            from = *end;
            wave
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::neighborhood::{Stencil, Surface};
    use crate::rng::{Rng, Stage};
    use crate::texture::paint::shuffle;
    use crate::texture::tests::{plane, slab};

    /// What a vertex becomes of what it reads; another order gives other values.
    fn updated(values: &[f64], spots: &Spots, v: u32) -> f64 {
        let mut value = 0.1 * f64::from(v);
        for u in spots.vertices(v as usize) {
            value = (0.7 * value + 1.3 * values[u as usize]).sin();
        }
        value
    }

    #[test]
    fn waves_give_what_visits_one_by_one_give() {
        for (mesh, spacing) in [(plane(14), 0.06), (slab(1), 0.7)] {
            let surface = Surface::new(mesh);
            let count = u32::try_from(surface.positions().len()).unwrap();
            let places: Vec<_> = (0..count)
                .map(|v| surface.at_vertex(v, &Vector3::new(0.9, 0.5, 0.3)))
                .collect();
            let spots = Spots::walked(&surface, &Stencil::square(1, spacing), &places);
            let mut order: Vec<u32> = (0..count).collect();
            shuffle(&mut order, &mut Rng::new(8, Stage::Texture, 0));
            let start: Vec<f64> = (0..count).map(|v| f64::from(v).cos()).collect();

            let mut one_by_one = start.clone();
            for v in &order {
                one_by_one[*v as usize] = updated(&one_by_one, &spots, *v);
            }
            let mut by_waves = start.clone();
            let waves = Waves::new(&spots, &order);
            for wave in waves.iter() {
                let found: Vec<f64> = wave
                    .iter()
                    .map(|v| updated(&by_waves, &spots, *v))
                    .collect();
                for (v, value) in wave.iter().zip(found) {
                    by_waves[*v as usize] = value;
                }
            }
            let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&by_waves), bits(&one_by_one));
            // All at once would not.
            let at_once: Vec<f64> = (0..count).map(|v| updated(&start, &spots, v)).collect();
            assert_ne!(bits(&at_once), bits(&one_by_one));

            let mut visited: Vec<u32> = waves.iter().flatten().copied().collect();
            visited.sort_unstable();
            assert!(visited.into_iter().eq(0..count), "each vertex once");
            assert!(waves.iter().count() < order.len() / 2, "waves hold several");
        }
    }

    #[test]
    fn no_vertices_make_no_waves() {
        let surface = Surface::new(plane(2));
        let spots = Spots::walked(&surface, &Stencil::square(1, 0.1), &[]);
        assert_eq!(Waves::new(&spots, &[]).iter().count(), 0);
    }
}
