//! The nearest full windows, without comparing all of them.
//!
//! A relief's windows fill few of their dimensions: a handful of principal components carry nearly
//! all of the variance. Rows are turned into the leading components and sorted into a k-d tree over
//! them. A projection never lengthens a distance, so that a search may leave out whatever is too
//! far already by its components, a whole subtree or a row, and still finds the very nearest.
//!
//! # Reference
//! Trees for the search of full neighborhoods: L.-Y. Wei, M. Levoy, *Fast texture synthesis
//! using tree-structured vector quantization*, SIGGRAPH, 479–488, 2000; k-d trees with incremental distances: S. Arya, D. M. Mount, *Algorithms for
//! fast vector quantization*, Data Compression Conference, 381–390, 1993; principal components by
//! orthogonal iteration: G. H. Golub, C. F. Van Loan, *Matrix Computations*, §8.2.

use std::ops::Range;

use nalgebra::DMatrix;
use pulp::Arch;
use rayon::prelude::*;

use super::table::{LANES, Row};

/// Components that are compared between two looks at whether a leaf can still hold a neighbor.
const STAGE: usize = 4;

/// Rows that the principal components are found from.
const SUBSET: usize = 2048;

/// Steps of orthogonal iteration. Any orthonormal basis is right, a better one is faster.
const ITERATIONS: usize = 8;

/// How a [`Tree`] is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TreeParams {
    /// Number of principal components; 16 by default. Results do not depend on it, times do.
    pub components: usize,
}

impl Default for TreeParams {
    fn default() -> Self {
        Self { components: 16 }
    }
}

/// Rows of numbers, arranged for the search of the nearest.
#[derive(Debug, Clone)]
pub struct Tree {
    dimensions: usize,
    projection: Projection,
    /// Inner nodes in preorder. A subtree of n leaves has n − 1 of them, and its left half n / 2
    /// leaves.
    nodes: Vec<Node>,
    /// Components: leaves by components, a row of the block for each.
    blocks: Vec<Row>,
    /// The rows' numbers, leaf after leaf, 16 in each but the last.
    numbers: Vec<u32>,
    /// The rows themselves in that order.
    rows: Vec<f32>,
    /// Largest norm of a row's components.
    reach: f32,
}

/// Where rows are told apart: to the left are those with up to `low` of a component, to the right
/// those from `high` on.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    component: u32,
    low: f32,
    high: f32,
}

impl Tree {
    /// Arranges n rows of `dimensions` values each (`rows`: n by `dimensions`). Where differences are
    /// weighted, the roots of the weights are in the values already.
    ///
    /// The result does not depend on the number of threads.
    ///
    /// # Panics
    /// If `dimensions` or the number of components is 0, `rows` is no whole number of rows or has
    /// 2³² of them or more, or a value is not finite.
    #[must_use]
    pub fn new(rows: &[f32], dimensions: usize, params: &TreeParams) -> Self {
        assert!(
            dimensions > 0 && params.components > 0,
            "nothing to compare"
        );
        assert!(rows.len().is_multiple_of(dimensions), "rows must be whole");
        assert!(rows.iter().all(|v| v.is_finite()), "values must be finite");
        let count = u32::try_from(rows.len() / dimensions).expect("rows are u32");
        // Whole stages, so that no remainder is left.
        let wanted = params.components.min(dimensions).next_multiple_of(STAGE);
        let projection = Projection::principal(rows, dimensions, wanted);
        let components: Vec<f32> = (rows.par_chunks(dimensions))
            .flat_map_iter(|row| projection.apply(row))
            .collect();
        let mut numbers: Vec<u32> = (0..count).collect();
        let leaves = numbers.len().div_ceil(LANES);
        let mut nodes = vec![Node::default(); leaves.saturating_sub(1)];
        split(&components, wanted, &mut numbers, &mut nodes);
        let of = |number: u32| &components[number as usize * wanted..][..wanted];
        let mut blocks = vec![Row([f32::INFINITY; LANES]); leaves * wanted];
        for (slot, number) in numbers.iter().enumerate() {
            let block = &mut blocks[slot / LANES * wanted..][..wanted];
            for (row, value) in block.iter_mut().zip(of(*number)) {
                row.0[slot % LANES] = *value;
            }
        }
        let sorted = (numbers.iter())
            .flat_map(|number| &rows[*number as usize * dimensions..][..dimensions])
            .copied()
            .collect();
        let reach = (numbers.iter()).fold(0f32, |reach, number| reach.max(norm(of(*number))));
        Self {
            dimensions,
            projection,
            nodes,
            blocks,
            numbers,
            rows: sorted,
            reach,
        }
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// The `k` nearest of the rows that `accept` takes, with their squared distances: ascending by
    /// distance, then by number. They are the very nearest, as if all had been compared; fewer than
    /// `k` if fewer are accepted.
    ///
    /// # Panics
    /// If `query` has another number of dimensions than the rows or a value that is not finite.
    #[must_use]
    pub fn nearest(
        &self,
        query: &[f32],
        k: usize,
        accept: impl Fn(u32) -> bool,
    ) -> Vec<(u32, f32)> {
        assert!(query.len() == self.dimensions, "a query is a row");
        assert!(query.iter().all(|v| v.is_finite()), "values must be finite");
        if k == 0 || self.is_empty() {
            return Vec::new();
        }
        let components: Vec<f32> = self.projection.apply(query).collect();
        let mut search = Search {
            tree: self,
            arch: Arch::new(),
            query,
            k,
            accept,
            gaps: vec![0.0; components.len()],
            rounding: f32::EPSILON * (self.reach + norm(&components)),
            components,
            found: Vec::new(),
            limit: f32::INFINITY,
        };
        search.descend(0, 0..self.numbers.len().div_ceil(LANES), 0.0);
        (search.found.into_iter())
            .map(|(distance_sq, number)| (number, distance_sq))
            .collect()
    }
}

/// Squared distance of two rows, summed up in a fixed order.
#[inline(always)]
#[must_use]
pub fn distance_sq(a: &[f32], b: &[f32]) -> f32 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += (a - b) * (a - b);
        }
    }
    for (sum, (a, b)) in sums.iter_mut().zip(a_rest.iter().zip(b_rest)) {
        *sum += (a - b) * (a - b);
    }
    sums.iter().sum()
}

fn norm(values: &[f32]) -> f32 {
    norm_sq(values).sqrt()
}

pub(super) fn norm_sq(values: &[f32]) -> f32 {
    values.iter().map(|v| v * v).sum()
}

/// Sorts rows into a subtree: those of a left half before those of its right half.
fn split(components: &[f32], width: usize, numbers: &mut [u32], nodes: &mut [Node]) {
    let Some((node, below)) = nodes.split_first_mut() else {
        return;
    };
    let leaves = below.len() + 2;
    let half = leaves / 2 * LANES;
    let widest = widest(components, width, numbers);
    let at = |number: u32| components[number as usize * width + widest];
    let (left, middle, _) =
        numbers.select_nth_unstable_by(half, |a, b| at(*a).total_cmp(&at(*b)).then(a.cmp(b)));
    *node = Node {
        component: u32::try_from(widest).expect("components are few"),
        low: (left.iter()).fold(f32::NEG_INFINITY, |low, number| low.max(at(*number))),
        high: at(*middle),
    };
    let (left, right) = numbers.split_at_mut(half);
    let (left_nodes, right_nodes) = below.split_at_mut(leaves / 2 - 1);
    rayon::join(
        || split(components, width, left, left_nodes),
        || split(components, width, right, right_nodes),
    );
}

/// The component with the largest variance among some rows.
fn widest(components: &[f32], width: usize, numbers: &[u32]) -> usize {
    let mut sums = vec![[0f64; 2]; width];
    for number in numbers {
        let row = &components[*number as usize * width..][..width];
        for ([sum, squares], value) in sums.iter_mut().zip(row) {
            let value = f64::from(*value);
            *sum += value;
            *squares += value * value;
        }
    }
    let count = numbers.len() as f64;
    let variance = |[sum, squares]: [f64; 2]| squares - sum * sum / count;
    (0..width)
        .max_by(|a, b| variance(sums[*a]).total_cmp(&variance(sums[*b])))
        .expect("there are components")
}

/// Onto an orthonormal basis of fewer dimensions.
#[derive(Debug, Clone)]
pub(super) struct Projection {
    mean: Vec<f64>,
    /// Components by dimensions.
    basis: Vec<f64>,
}

impl Projection {
    /// Onto about the first principal components of some of the rows, by falling variance; zeros
    /// follow if there are fewer dimensions.
    pub(super) fn principal(rows: &[f32], dimensions: usize, components: usize) -> Self {
        let count = rows.len() / dimensions;
        let picked = count.clamp(1, SUBSET);
        let mut data = DMatrix::from_fn(picked, dimensions, |i, j| {
            let row = i * count / picked;
            rows.get(row * dimensions + j)
                .map_or(0.0, |v| f64::from(*v))
        });
        let mean = data.row_mean();
        for mut row in data.row_iter_mut() {
            row -= &mean;
        }
        let rank = components.min(dimensions);
        let start = DMatrix::from_fn(dimensions, rank, |j, c| data[(c * picked / rank, j)]);
        let mut basis = start.qr().q();
        for _ in 0..ITERATIONS {
            basis = data.tr_mul(&(&data * basis)).qr().q();
        }
        let seen = &data * &basis;
        let variances: Vec<f64> = seen.column_iter().map(|c| c.norm_squared()).collect();
        let mut order: Vec<usize> = (0..rank).collect();
        order.sort_by(|a, b| variances[*b].total_cmp(&variances[*a]).then(a.cmp(b)));
        let mut sorted = Vec::with_capacity(components * dimensions);
        for c in order {
            sorted.extend(basis.column(c).iter());
        }
        sorted.resize(components * dimensions, 0.0);
        Self {
            mean: mean.iter().copied().collect(),
            basis: sorted,
        }
    }

    /// The components of a row.
    #[expect(clippy::cast_possible_truncation, reason = "stored as f32")]
    pub(super) fn apply(&self, row: &[f32]) -> impl Iterator<Item = f32> {
        let centred: Vec<f64> = (row.iter().zip(&self.mean))
            .map(|(value, mean)| f64::from(*value) - mean)
            .collect();
        (self.basis.chunks(row.len())).map(move |axis| dot(axis, &centred) as f32)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// A search on its way through a tree.
struct Search<'a, A> {
    tree: &'a Tree,
    arch: Arch,
    query: &'a [f32],
    components: Vec<f32>,
    k: usize,
    accept: A,
    /// How far the query is at least from the rows of a subtree, by component.
    gaps: Vec<f32>,
    /// How much longer a projected difference may be for the rounding of components alone.
    rounding: f32,
    /// Squared distances and numbers, sorted, k at most.
    found: Vec<(f32, u32)>,
    /// Squared distance by components above which a row cannot be among the k nearest.
    limit: f32,
}

impl<A: Fn(u32) -> bool> Search<'_, A> {
    /// Searches a subtree, its nearer half first.
    fn descend(&mut self, node: usize, leaves: Range<usize>, gap_sq: f32) {
        if leaves.len() == 1 {
            self.search_leaf(leaves.start);
            return;
        }
        let Node {
            component,
            low,
            high,
        } = self.tree.nodes[node];
        let half = leaves.len() / 2;
        let left = (node + 1, leaves.start..leaves.start + half);
        let right = (node + half, leaves.start + half..leaves.end);
        let at = self.components[component as usize];
        let (near, far, gap) = if at - low < high - at {
            (left, right, high - at)
        } else {
            (right, left, at - low)
        };
        self.descend(near.0, near.1, gap_sq);
        let old = self.gaps[component as usize];
        let gap = gap.max(old);
        let gap_sq = gap_sq + (gap * gap - old * old);
        if gap_sq <= self.limit {
            self.gaps[component as usize] = gap;
            self.descend(far.0, far.1, gap_sq);
            self.gaps[component as usize] = old;
        }
    }

    /// Compares the rows of a leaf, as far as needed.
    fn search_leaf(&mut self, leaf: usize) {
        let tree = self.tree;
        let width = self.components.len();
        let block = &tree.blocks[leaf * width..][..width];
        let (components, limit) = (&self.components, self.limit);
        let sums = self.arch.dispatch(
            #[inline(always)]
            || projected(components, block, limit),
        );
        let Some(sums) = sums else { return };
        let first = leaf * LANES;
        let numbers = &tree.numbers[first..tree.numbers.len().min(first + LANES)];
        for (lane, number) in numbers.iter().enumerate() {
            if sums.0[lane] <= self.limit && (self.accept)(*number) {
                let row = &tree.rows[(first + lane) * tree.dimensions..][..tree.dimensions];
                let query = self.query;
                let distance_sq = self.arch.dispatch(
                    #[inline(always)]
                    || distance_sq(query, row),
                );
                self.offer(distance_sq, *number);
            }
        }
    }

    fn offer(&mut self, distance_sq: f32, number: u32) {
        let found = (distance_sq, number);
        let place = (self.found)
            .partition_point(|(d, n)| d.total_cmp(&distance_sq).then(n.cmp(&number)).is_lt());
        if place == self.k {
            return;
        }
        self.found.truncate(self.k - 1);
        self.found.insert(place, found);
        if let Some((farthest, _)) = self.found.get(self.k - 1) {
            // Sums of d terms are off by less than d units of their last digit, and gaps by one for
            // each level of the tree.
            let terms = self.query.len() + self.components.len() + 64;
            let slack = 1.0 + f32::EPSILON * terms as f32;
            let length = farthest.sqrt() * slack + self.rounding;
            self.limit = length * length * slack;
        }
    }
}

/// Squared distances of a leaf's rows by their components; `None` if all are above the limit.
#[inline(always)]
fn projected(components: &[f32], block: &[Row], limit: f32) -> Option<Row> {
    let mut sums = Row::ZERO;
    let stages = components.as_chunks::<STAGE>().0.iter();
    for (values, rows) in stages.zip(block.as_chunks::<STAGE>().0) {
        for (value, row) in values.iter().zip(rows) {
            for (sum, other) in sums.0.iter_mut().zip(row.0) {
                *sum += (value - other) * (value - other);
            }
        }
        if !sums.0.iter().fold(false, |any, sum| any | (*sum <= limit)) {
            return None;
        }
    }
    Some(sums)
}

#[cfg(test)]
#[expect(clippy::cast_possible_truncation, reason = "test data is small")]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::rng::{Rng, Stage};

    /// Rows of three waves of random phase and strength, as windows of a relief are, and noise.
    fn waves(count: usize, dimensions: usize, noise: f64, seed: u32) -> Vec<f32> {
        let mut rng = Rng::new(seed, Stage::Synth, 0);
        let mut rows = Vec::with_capacity(count * dimensions);
        for _ in 0..count {
            let waves = [1.0, 2.0, 3.0].map(|f| (f, rng.normal(), rng.uniform()));
            for j in 0..dimensions {
                let x = j as f64 / dimensions as f64;
                let wave = |(f, height, phase)| {
                    let turns: f64 = f * x + phase;
                    height * (std::f64::consts::TAU * turns).cos()
                };
                let value: f64 = waves.into_iter().map(wave).sum();
                rows.push((value + noise * rng.normal()) as f32);
            }
        }
        rows
    }

    fn brute_force(
        rows: &[f32],
        query: &[f32],
        k: usize,
        accept: impl Fn(u32) -> bool,
    ) -> Vec<(u32, f32)> {
        let mut all: Vec<(u32, f32)> = (0..)
            .zip(rows.chunks(query.len()))
            .filter(|(i, _)| accept(*i))
            .map(|(i, row)| (i, distance_sq(query, row)))
            .collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        all.truncate(k);
        all
    }

    proptest! {
        #[test]
        fn nearest_are_those_of_brute_force(
            seed in any::<u32>(),
            (count, dimensions) in (0..300usize, 1..40usize),
            noise in prop_oneof![Just(0.0), Just(0.05), Just(3.0)],
            scale in prop_oneof![Just(1e-9f32), Just(1.0), Just(1e9)],
            (components, k, modulus) in (1..24usize, 0..12usize, 1..4u32),
        ) {
            let scaled = |rows: Vec<f32>| rows.into_iter().map(|v| v * scale).collect::<Vec<_>>();
            let rows = scaled(waves(count, dimensions, noise, seed));
            let tree = Tree::new(&rows, dimensions, &TreeParams { components });
            let accept = |i: u32| i.is_multiple_of(modulus);
            let queries = scaled(waves(3, dimensions, noise, seed ^ 1));
            // Also some of the rows themselves.
            for query in queries.chunks(dimensions).chain(rows.chunks(dimensions).take(3)) {
                let found = tree.nearest(query, k, accept);
                prop_assert_eq!(found, brute_force(&rows, query, k, accept));
            }
        }

        #[test]
        fn equal_rows_come_by_number(
            seed in any::<u32>(),
            count in 1..200usize,
            k in 1..40usize,
        ) {
            let mut rng = Rng::new(seed, Stage::Synth, 0);
            let rows: Vec<f32> = (0..3 * count).map(|_| rng.index(2) as f32).collect();
            let tree = Tree::new(&rows, 3, &TreeParams::default());
            let found = tree.nearest(&[0.0, 1.0, 1.0], k, |_| true);
            prop_assert_eq!(found, brute_force(&rows, &[0.0, 1.0, 1.0], k, |_| true));
        }
    }

    #[test]
    fn rows_far_from_the_origin_are_told_apart() {
        let mut rows = waves(2000, 20, 0.01, 4);
        for value in &mut rows {
            *value += 1e4;
        }
        let tree = Tree::new(&rows, 20, &TreeParams::default());
        for query in rows.chunks(20).step_by(97) {
            let found = tree.nearest(query, 5, |_| true);
            assert_eq!(found, brute_force(&rows, query, 5, |_| true));
        }
    }

    #[test]
    fn any_number_of_threads_builds_the_same() {
        let rows = waves(20_000, 30, 0.1, 2);
        let build = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let tree = pool.install(|| Tree::new(&rows, 30, &TreeParams::default()));
            (tree.numbers, tree.blocks)
        };
        let expected = build(1);
        assert!(build(2) == expected && build(8) == expected);
    }
}
