//! True pieces score at most 1; every planted fault is caught.

use std::f64::consts::TAU;

use nalgebra::Point3;

use crate::mesh::TriMesh;
use crate::rng::{Rng, Stage};

use super::{Calibration, Field, FieldInput, Judgement, Measure};

/// Squares along a side of the test surface, with edges of (about) 1.
const SIDE: u32 = 90;
/// Area of the pieces: 4 % of it.
const AREA: f64 = 320.0;
const PIECES: usize = 128;

/// A sheet of squares with their corners shaken.
fn sheet() -> TriMesh {
    let mut rng = Rng::new(11, Stage::Likeness, 9);
    let side = SIDE + 1;
    let positions = (0..side * side)
        .map(|v| {
            let mut shaken = |i: u32| f64::from(i) + 0.4 * (rng.uniform() - 0.5);
            Point3::new(shaken(v % side), shaken(v / side), 0.0)
        })
        .collect();
    let triangles = (0..SIDE * SIDE)
        .flat_map(|cell| {
            let a = cell / SIDE * side + cell % SIDE;
            let (b, c, d) = (a + 1, a + side, a + side + 1);
            if (cell / SIDE + cell).is_multiple_of(2) {
                [[a, b, d], [a, d, c]]
            } else {
                [[a, b, c], [b, d, c]]
            }
        })
        .collect();
    TriMesh {
        positions,
        triangles,
    }
}

/// A sum of plane waves: amplitude, wave vector, phase.
#[derive(Clone)]
struct Waves(Vec<[f64; 4]>);

impl Waves {
    /// Random, with wavelengths from 6 to 18 edges along x, and those times `stretch` along y.
    fn random(stretch: f64, seed: u32) -> Self {
        let mut rng = Rng::new(seed, Stage::Likeness, 7);
        Self(
            (0..150)
                .map(|_| {
                    let k = TAU / (6.0 + 12.0 * rng.uniform());
                    let angle = TAU * rng.uniform();
                    let wave = [k * angle.cos(), k * angle.sin() / stretch];
                    [0.1, wave[0], wave[1], TAU * rng.uniform()]
                })
                .collect(),
        )
    }

    /// Bumps on a lattice, 14 edges apart: 24 harmonics in phase.
    fn bumps() -> Self {
        let k = TAU / 14.0;
        let harmonics = (0..=3).flat_map(|i| (-3..=3).map(move |j| (i, j)));
        Self(
            harmonics
                .filter(|(i, j)| *i > 0 || *j > 0)
                .map(|(i, j)| {
                    let amplitude = (-0.15 * f64::from(i * i + j * j)).exp();
                    [amplitude, k * f64::from(i), k * f64::from(j), 0.0]
                })
                .collect(),
        )
    }

    /// The same spectrum with random phases.
    fn with_random_phases(&self, seed: u32) -> Self {
        let mut rng = Rng::new(seed, Stage::Likeness, 8);
        let mut waves = self.clone();
        for wave in &mut waves.0 {
            wave[3] = TAU * rng.uniform();
        }
        waves
    }

    fn at(&self, x: f64, y: f64) -> f64 {
        (self.0.iter())
            .map(|[a, kx, ky, phase]| a * (kx * x + ky * y + phase).cos())
            .sum()
    }

    fn on(&self, mesh: &TriMesh) -> Vec<f64> {
        mesh.positions.iter().map(|p| self.at(p.x, p.y)).collect()
    }
}

/// A surface, calibrated, and the piece on which faults are planted.
struct Bench {
    mesh: TriMesh,
    heights: Vec<f64>,
    piece: Vec<u32>,
    known: Vec<bool>,
    calibration: Calibration,
}

impl Bench {
    fn new(relief: &Waves) -> Self {
        let mesh = sheet();
        let heights = relief.on(&mesh);
        let field = Self::field(&mesh, &heights);
        let middle = (SIDE / 2) * (SIDE + 1) + SIDE / 2;
        let piece = field.discs.around(middle, AREA).unwrap();
        let mut known = vec![true; heights.len()];
        for v in &piece {
            known[*v as usize] = false;
        }
        let pieces = field.pieces(&known, AREA, PIECES, 0);
        assert_eq!(pieces.len(), PIECES);
        Self {
            calibration: Calibration::new(&field, &known, &pieces, &mut |_| {}),
            mesh,
            heights,
            piece,
            known,
        }
    }

    fn field(mesh: &TriMesh, heights: &[f64]) -> Field {
        Field::new(FieldInput {
            feet: mesh,
            heights,
            colors: None,
            step: 1.0,
        })
    }

    /// Judges true pieces that had no part in the calibration.
    fn true_pieces(&self, count: usize) -> Vec<Judgement> {
        let field = Self::field(&self.mesh, &self.heights);
        (field.pieces(&self.known, AREA, count, 99).iter())
            .map(|piece| self.calibration.judge(&field.figures(piece, &self.known)))
            .collect()
    }

    /// Judges the piece with new heights, made from vertex and point.
    fn judge(&self, height: impl Fn(usize, &Point3<f64>) -> f64) -> Judgement {
        let mut heights = self.heights.clone();
        for v in &self.piece {
            heights[*v as usize] = height(*v as usize, &self.mesh.positions[*v as usize]);
        }
        let field = Self::field(&self.mesh, &heights);
        (self.calibration).judge(&field.figures(&self.piece, &self.known))
    }
}

/// Overall score, then the measures with theirs.
fn told(judgement: &Judgement) -> String {
    let measures: Vec<String> = (judgement.measures.iter())
        .map(|m| format!("{} {:.2}", m.measure.name(), m.score.score))
        .collect();
    format!("{:.2}: {}", judgement.overall.score, measures.join(", "))
}

/// Of `count` judgements, at most as many are outside of the natural variation as chance allows: 5 % on
/// average, a quarter with a probability below 2 %.
#[track_caller]
fn assert_mostly_natural(judgements: &[Judgement], outside: impl Fn(&Judgement) -> bool) {
    let count = judgements.iter().filter(|j| outside(j)).count();
    let all: Vec<String> = judgements.iter().map(told).collect();
    assert!(4 * count <= judgements.len(), "{}", all.join("\n"));
}

#[track_caller]
fn assert_caught(judgement: &Judgement, by: &[Measure]) {
    assert!(judgement.overall.score > 1.0, "{}", told(judgement));
    for measure in by {
        let score = judgement.of(*measure).unwrap();
        assert!(score.score > 1.0 && score.p < 0.05, "{}", told(judgement));
    }
}

#[test]
fn on_stochastic_relief_true_pieces_pass_and_faults_are_caught() {
    let relief = Waves::random(1.0, 1);
    let bench = Bench::new(&relief);
    assert_mostly_natural(&bench.true_pieces(16), |j| j.overall.score > 1.0);
    // Other pieces of the same surface, not blended in.
    let pasted: Vec<Judgement> = (1..=8)
        .map(|i| bench.judge(|_, p| relief.at(p.x + 500.0 * f64::from(i), p.y - 300.0)))
        .collect();
    for paste in &pasted {
        assert_caught(paste, &[Measure::Seam]);
    }
    for measure in Measure::ALL.into_iter().filter(|m| *m != Measure::Seam) {
        assert_mostly_natural(&pasted, |j| j.of(measure).is_some_and(|s| s.score > 1.0));
    }
    let smooth = [
        Measure::Laplacian,
        Measure::Variogram,
        Measure::Areal,
        Measure::Classifier,
    ];
    assert_caught(&bench.judge(|_, _| 0.0), &smooth);
    let faded = bench.judge(|v, _| 0.7 * bench.heights[v]);
    assert_caught(&faded, &[Measure::Variogram, Measure::Areal]);
    let mut shuffled = bench.piece.clone();
    let mut rng = Rng::new(3, Stage::Likeness, 3);
    for i in (1..shuffled.len()).rev() {
        shuffled.swap(i, rng.index(i + 1));
    }
    let noise = bench.judge(|v, _| {
        let at = bench.piece.iter().position(|u| *u as usize == v).unwrap();
        bench.heights[shuffled[at] as usize]
    });
    assert_caught(&noise, &smooth);
}

#[test]
fn ridges_that_run_the_wrong_way_are_caught() {
    let relief = Waves::random(4.0, 2);
    let bench = Bench::new(&relief);
    let middle = f64::from(SIDE) / 2.0;
    let turned = bench.judge(|_, p| relief.at(p.y - middle + 777.0, middle - p.x));
    assert_caught(&turned, &[Measure::Variogram]);
}

#[test]
fn a_field_of_the_same_spectrum_is_caught() {
    let relief = Waves::bumps();
    let bench = Bench::new(&relief);
    assert_mostly_natural(&bench.true_pieces(16), |j| j.overall.score > 1.0);
    let scrambled = relief.with_random_phases(5);
    let judgement = bench.judge(|_, p| scrambled.at(p.x, p.y));
    assert_caught(&judgement, &[Measure::Laplacian]);
}

#[test]
fn a_true_piece_with_denser_vertices_passes() {
    let relief = Waves::random(1.0, 4);
    let bench = Bench::new(&relief);
    // A vertex more in every triangle of the piece: three times as many in all.
    let mut mesh = bench.mesh.clone();
    let (mut piece, mut known) = (bench.piece.clone(), bench.known.clone());
    let triangles = std::mem::take(&mut mesh.triangles);
    for [a, b, c] in triangles {
        if known[a as usize] && known[b as usize] && known[c as usize] {
            mesh.triangles.push([a, b, c]);
            continue;
        }
        let sum = [a, b, c].map(|v| mesh.positions[v as usize].coords);
        let new = u32::try_from(mesh.positions.len()).unwrap();
        mesh.positions
            .push(Point3::from((sum[0] + sum[1] + sum[2]) / 3.0));
        mesh.triangles
            .extend([[a, b, new], [b, c, new], [c, a, new]]);
        piece.push(new);
        known.push(false);
    }
    assert!(piece.len() > 5 * bench.piece.len() / 2);
    let field = Bench::field(&mesh, &relief.on(&mesh));
    let dense = bench.calibration.judge(&field.figures(&piece, &known));
    let plain = bench.judge(|v, _| bench.heights[v]);
    for (dense, plain) in dense.measures.iter().zip(&plain.measures) {
        let (dense, plain) = (dense.score.score, plain.score.score);
        assert!(
            dense <= f64::max(1.0, 1.1 * plain),
            "{dense} against {plain}"
        );
    }
}

#[test]
fn figures_do_not_depend_on_threads_or_place() {
    let relief = Waves::random(1.0, 6);
    let mesh = sheet();
    let heights = relief.on(&mesh);
    let figures = |threads: usize, mesh: &TriMesh| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let field = Bench::field(mesh, &heights);
            let known = vec![true; heights.len()];
            let pieces = field.pieces(&known, AREA, 3, 1);
            (pieces.clone(), field.figures(&pieces[0], &known))
        })
    };
    let one = figures(1, &mesh);
    assert_eq!(one, figures(3, &mesh));
    let mut moved = mesh.clone();
    for p in &mut moved.positions {
        p.x += 4096.0;
    }
    let far = figures(1, &moved);
    for (a, b) in one.1.iter().zip(&far.1) {
        let (a, b) = (a.value.unwrap(), b.value.unwrap());
        assert!((a - b).abs() < 0.02 * (a + 0.05), "{a} {b}");
    }
}
