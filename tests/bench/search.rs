//! Exhaustive search at the size of the paper's Fig. 9: 12 852 samples at 4 rotations, a window of
//! 81 offsets, targets half of whose neighborhoods is known, as they are on a front.
//!
//! Printed besides the times: how fast the machine is at best, and which share of that a search
//! reaches, by the operations it really executes and by those that comparing all would take.
#![expect(clippy::print_stdout, reason = "figures that criterion does not know")]
#![expect(
    clippy::cast_possible_truncation,
    reason = "numbers of candidates and heights are small"
)]

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use relievo::matching::exhaustive::{
    Found, Query, Search, best_matches, best_matches_of_all, nearest,
};
use relievo::matching::table::Table;
use relievo::matching::tree::{Tree, TreeParams};
use relievo::neighborhood::{Descriptor, gaussian_weight, window_sigma};
use relievo::rng::{Rng, Stage};

const SAMPLES: usize = 12_852;
const ROTATIONS: usize = 4;
const RADIUS: i32 = 5;
const QUERIES: usize = 128;
/// Targets of Fig. 9, 7200 of them, and what they may take in all on two cores, in seconds.
const TARGETS: f64 = 7200.0;
/// Operations that compare a value: subtract, square, weigh, add.
const OPERATIONS: f64 = 4.0;

/// Relief as a sum of waves, a set of them for each channel.
struct Field {
    /// Wave vector, phase, amplitude.
    waves: Vec<Vec<[f64; 4]>>,
    /// Offsets of the stencil, centre outwards.
    offsets: Vec<[f64; 2]>,
}

impl Field {
    fn new(channels: usize) -> Self {
        let mut rng = Rng::new(1, Stage::Synth, 0);
        let mut wave = || {
            // From 5 to 40 spacings long, long ones higher.
            let length = 5.0 * 8f64.powf(rng.uniform());
            let angle = std::f64::consts::TAU * rng.uniform();
            let number = std::f64::consts::TAU / length;
            let phase = std::f64::consts::TAU * rng.uniform();
            let [x, y] = [angle.cos(), angle.sin()].map(|part| number * part);
            [x, y, phase, length / 20.0]
        };
        let waves = (0..channels)
            .map(|_| (0..24).map(|_| wave()).collect())
            .collect();
        let range = -RADIUS..=RADIUS;
        let mut offsets: Vec<[i32; 2]> = (range.clone())
            .flat_map(|x| range.clone().map(move |y| [x, y]))
            .filter(|[x, y]| x * x + y * y <= RADIUS * RADIUS)
            .collect();
        offsets.sort_by_key(|[x, y]| x * x + y * y);
        let offsets = offsets.iter().map(|o| o.map(f64::from)).collect();
        Self { waves, offsets }
    }

    fn height(&self, channel: usize, at: [f64; 2]) -> f64 {
        (self.waves[channel].iter())
            .map(|[x, y, phase, height]| height * (x * at[0] + y * at[1] + phase).cos())
            .sum()
    }

    fn weights(&self) -> Vec<f32> {
        let sigma = window_sigma(RADIUS.unsigned_abs() as usize, 1.0);
        (self.offsets.iter())
            .map(|[x, y]| gaussian_weight(x * x + y * y, sigma) as f32)
            .collect()
    }

    /// Heights over the one in the middle at a turned stencil, with noise, where `known`.
    fn describe(
        &self,
        at: [f64; 2],
        angle: f64,
        rng: &mut Rng,
        known: impl Fn([f64; 2]) -> bool,
        into: &mut Descriptor,
    ) {
        let channels = self.waves.len();
        let (sin, cos) = angle.sin_cos();
        for (j, [x, y]) in self.offsets.iter().enumerate() {
            if known([*x, *y]) {
                into.known.set(j);
                let place = [at[0] + cos * x - sin * y, at[1] + sin * x + cos * y];
                for c in 0..channels {
                    let height = self.height(c, place) - self.height(c, at);
                    into.values[j * channels + c] = (height + 0.05 * rng.normal()) as f32;
                }
            }
        }
    }
}

/// A table, and queries from elsewhere in the same field.
struct Setting {
    table: Table,
    queries: Vec<Descriptor>,
    /// Full windows of the same places.
    full: Vec<Descriptor>,
}

impl Setting {
    fn new(channels: usize) -> Self {
        let field = Field::new(channels);
        let side = (SAMPLES as f64).sqrt();
        let mut rng = Rng::new(2, Stage::Synth, 0);
        let mut site = |x: f64| [x + side * rng.uniform(), side * rng.uniform()];
        let sites: Vec<[f64; 2]> = (0..SAMPLES).map(|_| site(0.0)).collect();
        let targets: Vec<[f64; 2]> = (0..QUERIES).map(|_| site(2.0 * side)).collect();
        let weights = field.weights();
        let table = Table::build(SAMPLES * ROTATIONS, channels, &weights, |i, descriptor| {
            let turn = (i % ROTATIONS) as f64 / ROTATIONS as f64;
            let mut noise = Rng::new(3, Stage::Synth, i as u32);
            let angle = std::f64::consts::TAU * turn;
            field.describe(
                sites[i / ROTATIONS],
                angle,
                &mut noise,
                |_| true,
                descriptor,
            );
        });
        let queries = (targets.iter())
            .map(|target| {
                let angle = std::f64::consts::TAU * rng.uniform();
                let (sin, cos) = (std::f64::consts::TAU * rng.uniform()).sin_cos();
                let edge = 2.0 * rng.uniform() - 1.0;
                let known = |[x, y]: [f64; 2]| cos * x + sin * y > edge;
                let mut query = Descriptor::new(table.offsets(), channels);
                field.describe(*target, angle, &mut rng, known, &mut query);
                query
            })
            .collect();
        let full = (targets.iter())
            .map(|target| {
                let mut full = Descriptor::new(table.offsets(), channels);
                field.describe(*target, 1.0, &mut rng, |_| true, &mut full);
                full
            })
            .collect();
        Self {
            table,
            queries,
            full,
        }
    }

    fn search_all(&self, search: &Search, likely: &[Vec<u32>]) -> Vec<Vec<Found>> {
        (self.queries.par_iter().zip(likely))
            .map(|(query, likely)| best_matches(&self.table, query, search, likely))
            .collect()
    }

    fn queries<'a>(&'a self, likely: &'a [Vec<u32>]) -> Vec<Query<'a>> {
        (self.queries.iter().zip(likely))
            .map(|(descriptor, likely)| Query { descriptor, likely })
            .collect()
    }

    /// Half of the queries at a time.
    fn search_batches(&self, search: &Search, likely: &[Vec<u32>]) -> Vec<Vec<Found>> {
        (self.queries(likely).par_chunks(QUERIES / 2))
            .flat_map_iter(|batch| best_matches_of_all(&self.table, batch, search))
            .collect()
    }

    /// Values that a search compares if it knows its final budget from the start and looks at
    /// its blocks of 16 after every 6 values: about what it does.
    fn compared(&self, query: &Descriptor, budget: f32) -> usize {
        let (channels, weights) = (self.table.channels(), self.table.weights());
        let rows: Vec<usize> = (query.known.iter())
            .flat_map(|j| j * channels..(j + 1) * channels)
            .collect();
        let total: f32 = query.known.iter().map(|j| weights[j]).sum();
        let candidates: Vec<u32> = (0..self.table.len() as u32).collect();
        (candidates.par_chunks(16))
            .map(|block| {
                let block: Vec<Descriptor> =
                    block.iter().map(|i| self.table.descriptor(*i)).collect();
                let mut sums = vec![0.0; block.len()];
                let mut compared = 0;
                for stage in rows.chunks(6) {
                    for (sum, candidate) in sums.iter_mut().zip(&block) {
                        for row in stage {
                            let difference = query.values[*row] - candidate.values[*row];
                            *sum += weights[row / channels] * difference * difference;
                        }
                    }
                    compared += stage.len() * block.len();
                    if sums.iter().all(|sum| *sum > budget * total) {
                        break;
                    }
                }
                compared
            })
            .sum()
    }
}

/// Seconds of the fastest of some runs.
fn fastest(runs: usize, mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..runs).map(time).fold(f64::INFINITY, f64::min)
}

/// Chains of multiplications and additions that wait for nothing but themselves.
struct Chains {
    fused: bool,
}

impl Chains {
    const COUNT: usize = 12;
    const STEPS: usize = 10_000;
}

impl WithSimd for Chains {
    /// Operations, and a sum that depends on all of them.
    type Output = (usize, f32);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let factor = simd.splat_f32s(black_box(0.999));
        let summand = simd.splat_f32s(black_box(0.001));
        let mut chains = [simd.splat_f32s(1.0); Self::COUNT];
        for _ in 0..Self::STEPS {
            for chain in &mut chains {
                *chain = match self.fused {
                    true => simd.mul_add_f32s(*chain, factor, summand),
                    false => simd.add_f32s(simd.mul_f32s(*chain, factor), summand),
                };
            }
        }
        let sum = (chains.into_iter()).map(|chain| simd.reduce_sum_f32s(chain));
        (2 * Self::STEPS * Self::COUNT * S::F32_LANES, sum.sum())
    }
}

/// Peak of one core, in operations per second: apart, and fused.
fn peak() -> [f64; 2] {
    [false, true].map(|fused| {
        let mut operations = 0;
        let seconds = fastest(500, || {
            operations = black_box(Arch::new().dispatch(Chains { fused })).0;
        });
        operations as f64 / seconds
    })
}

/// Prints what a search takes and reaches on one core.
fn report(setting: &Setting, search: &Search, likely: &[Vec<u32>], peak: f64) {
    let mut compared = 0;
    let mut seconds = 0.0;
    let mut nominal = 0;
    for (query, likely) in setting.queries.iter().zip(likely).take(16) {
        let best = nearest(&setting.table, query, 1)[0].cost;
        compared += setting.compared(query, best * (1.0 + search.tolerance));
        nominal += query.known.count() * setting.table.channels() * setting.table.len();
        seconds += fastest(50, || {
            black_box(best_matches(&setting.table, query, search, likely));
        });
    }
    let rate = |values: usize| OPERATIONS * values as f64 / seconds;
    println!(
        "one core: {:.1} us a query, {:.0} M pairs/s, {:.1} of {:.1} values compared; \
         executed {:.1} GFLOP/s ({:.0} % of peak), nominal {:.1} GFLOP/s ({:.0} %)",
        seconds / 16.0 * 1e6,
        16.0 * setting.table.len() as f64 / seconds / 1e6,
        compared as f64 / (16 * setting.table.len()) as f64,
        nominal as f64 / (16 * setting.table.len()) as f64,
        rate(compared) / 1e9,
        100.0 * rate(compared) / peak,
        rate(nominal) / 1e9,
        100.0 * rate(nominal) / peak,
    );
    let queries = setting.queries(likely);
    let batch = fastest(10, || {
        let queries = &queries[..QUERIES / 2];
        black_box(best_matches_of_all(&setting.table, queries, search));
    });
    let each = batch / (QUERIES / 2) as f64;
    println!(
        "one core, {} at once: {:.1} us a query",
        QUERIES / 2,
        each * 1e6
    );
    let threads = rayon::current_num_threads();
    let alone = fastest(10, || {
        black_box(setting.search_all(search, likely));
    });
    let batches = fastest(10, || {
        black_box(setting.search_batches(search, likely));
    });
    for (name, seconds) in [("one by one", alone), ("in two batches", batches)] {
        let each = seconds / QUERIES as f64;
        println!(
            "{threads} threads, {name}: {:.1} us a query, {:.2} s for {TARGETS} targets",
            each * 1e6,
            each * TARGETS,
        );
    }
}

/// Prints what the search for full windows takes.
fn report_tree(setting: &Setting) {
    let roots: Vec<f32> = setting.table.weights().iter().map(|w| w.sqrt()).collect();
    let weighted = |descriptor: &Descriptor| -> Vec<f32> {
        let pairs = descriptor.values.iter().zip(&roots);
        pairs.map(|(value, root)| value * root).collect()
    };
    let rows: Vec<f32> = (0..setting.table.len())
        .flat_map(|i| weighted(&setting.table.descriptor(i as u32)))
        .collect();
    let queries: Vec<Vec<f32>> = setting.full.iter().map(weighted).collect();
    for components in [8, 12, 16, 24] {
        let params = TreeParams { components };
        let mut tree = Tree::new(&rows, roots.len(), &params);
        let build = fastest(3, || tree = Tree::new(&rows, roots.len(), &params));
        for k in [1, 8] {
            let seconds: f64 = (queries.iter())
                .map(|query| fastest(20, || drop(black_box(tree.nearest(query, k, |_| true)))))
                .sum();
            println!(
                "tree over {components} components: built in {build:.2} s; {k} nearest in {:.1} us",
                seconds / queries.len() as f64 * 1e6
            );
        }
    }
}

fn searches(criterion: &mut Criterion) {
    let [apart, fused] = peak();
    println!(
        "peak of one core: {:.1} GFLOP/s apart, {:.1} fused",
        apart / 1e9,
        fused / 1e9
    );
    for channels in [1, 4] {
        let setting = Setting::new(channels);
        let search = Search {
            tolerance: 0.1,
            ..Search::default()
        };
        let none = vec![Vec::new(); QUERIES];
        // What a neighbor's match would be: good, not best.
        let likely: Vec<Vec<u32>> = (setting.queries.par_iter())
            .map(|query| vec![nearest(&setting.table, query, 10)[9].candidate])
            .collect();
        let mut group = criterion.benchmark_group(format!("81 offsets, {channels} channels"));
        group.sample_size(20);
        group.throughput(Throughput::Elements((QUERIES * setting.table.len()) as u64));
        for (name, likely) in [("nothing known", &none), ("one likely", &likely)] {
            println!("\n{channels} channels, {name}");
            report(&setting, &search, likely, apart);
            group.bench_function(format!("{QUERIES} searches, {name}"), |bencher| {
                bencher.iter(|| setting.search_all(&search, likely));
            });
            group.bench_function(format!("{QUERIES} in batches, {name}"), |bencher| {
                bencher.iter(|| setting.search_batches(&search, likely));
            });
        }
        group.finish();
        if channels == 1 {
            report_tree(&setting);
        }
    }
}

criterion_group!(benches, searches);
criterion_main!(benches);
