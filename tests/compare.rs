//! Two scans, and two parts of one, against each other.

mod common;

use common::place::Place;
use common::{moved, to_scan};
use relievo::base::{BaseChoice, BaseKind, FitParams, Form};
use relievo::scan::{Column, Scan};
use relievo::stats::{
    Comparison, MeasureParams, Measured, Natural, NaturalParams, StatsError, compare_parts,
    figures, natural_variation, verdict,
};
use relievo::synth::{Kind, Part, SynthParams};

/// A whole synthetic scan.
fn surface(kind: Kind, vertices: usize, seed: u32) -> Scan {
    let params = SynthParams {
        kind,
        vertices,
        part: Part::default(),
        seed,
        ..SynthParams::default()
    };
    relievo::synth::scan(&params)
        .expect("the parameters are in range")
        .scan
}

fn over(kind: BaseKind) -> MeasureParams {
    MeasureParams {
        fit: FitParams {
            base: BaseChoice::Kind(kind),
            ..FitParams::default()
        },
        ..MeasureParams::default()
    }
}

/// A square sheet of n by n vertices, 1 apart, with a height over each.
fn sheet(n: u32, height: impl Fn(f64, f64) -> f64) -> Scan {
    let mut mesh = relievo::mesh::TriMesh::default();
    for v in 0..n * n {
        let (x, y) = (f64::from(v % n), f64::from(v / n));
        mesh.positions
            .push(nalgebra::Point3::new(x, y, height(x, y)));
        if v % n + 1 < n && v / n + 1 < n {
            mesh.triangles
                .extend([[v, v + 1, v + n + 1], [v, v + n + 1, v + n]]);
        }
    }
    to_scan(&mesh)
}

/// The scan with its coordinates along z times a factor.
fn flattened(scan: &Scan, factor: f64) -> Scan {
    let mut scan = scan.clone();
    let heights = scan.positions().iter().map(|p| factor * p.z).collect();
    scan.vertices.set_channel("z", Column::F64(heights));
    scan
}

/// Compares two scans over planes.
fn compared(a: &Scan, b: &Scan) -> (Comparison, Result<Natural, StatsError>) {
    let params = over(BaseKind::Plane);
    let first = Measured::new(a, &params).expect("a plane fits");
    let second = Measured::new(b, &params).expect("a plane fits");
    let (count, others) = (first.vertices(), second.vertices());
    let both = first.beside(second);
    let of_first: Vec<bool> = (0..count + others).map(|v| v < count).collect();
    let of_second: Vec<bool> = of_first.iter().map(|is| !is).collect();
    let comparison =
        compare_parts(&both, &of_first, &of_second).expect("both parts lie on their planes");
    let params = NaturalParams {
        pieces: 60,
        ..NaturalParams::default()
    };
    let natural = natural_variation(&both, &of_first, &of_second, &params, &mut |_| {});
    (comparison, natural)
}

#[test]
fn a_wave_has_the_parameters_of_its_formula() {
    let (amplitude, wavelength) = (0.2, 16.0);
    let scan = sheet(97, |x, _| {
        // Even about the middle, so that the fitted plane lies level.
        amplitude * (std::f64::consts::TAU * (x - 48.0) / wavelength).cos()
    });
    let measured = Measured::new(&scan, &over(BaseKind::Plane)).unwrap();
    let part = figures(&measured, &vec![true; measured.vertices()]).unwrap();
    let close = |value: f64, expected: f64, within: f64| {
        assert!(
            (value / expected - 1.0).abs() < within,
            "{value} {expected}"
        );
    };
    // Linear between vertices: 16 to a wave take off up to 1.3 %.
    close(part.areal.sq, amplitude / 2.0f64.sqrt(), 0.02);
    close(part.areal.sa, 2.0 * amplitude / std::f64::consts::PI, 0.02);
    close(part.areal.sku.unwrap(), 1.5, 0.03);
    assert!(part.areal.ssk.unwrap().abs() < 0.02);
    let slope = std::f64::consts::TAU * amplitude / wavelength / 2.0f64.sqrt();
    close(part.areal.sdq.unwrap(), slope, 0.02);
    close(part.areal.sdr.unwrap(), 100.0 * slope * slope / 2.0, 0.03);
    // cos(2πτ/λ) falls to 0.2 at λ·arccos(0.2)/2π.
    let sal = wavelength * 0.2f64.acos() / std::f64::consts::TAU;
    close(part.areal.sal.unwrap(), sal, 0.03);
    assert_eq!(part.areal.str, None, "along its ridges it never falls");
}

#[test]
fn figures_do_not_depend_on_where_the_scan_lies() {
    let scan = sheet(60, |x, y| 0.3 * (0.7 * x).sin() * (0.4 * y).cos());
    let far = moved(&scan, [5e6, -3e5, 1e4]);
    let of = |scan: &Scan| {
        let measured = Measured::new(scan, &over(BaseKind::Plane)).unwrap();
        figures(&measured, &vec![true; measured.vertices()]).unwrap()
    };
    let (near, far) = (of(&scan), of(&far));
    for (a, b) in near.areal.rows().into_iter().zip(far.areal.rows()) {
        match (a.value, b.value) {
            (Some(a), Some(b)) => assert!((a - b).abs() <= 1e-5 * (1e-3 + a.abs())),
            (a, b) => assert_eq!(a, b),
        }
    }
}

#[test]
fn filters_take_off_waves_by_half_at_their_length() {
    let wave = |x: f64, length: f64| (std::f64::consts::TAU * x / length).sin();
    let scan = sheet(100, |x, _| wave(x, 10.0) + wave(x, 40.0));
    let sq = |s_filter, l_filter| {
        let params = MeasureParams {
            s_filter,
            l_filter,
            ..over(BaseKind::Plane)
        };
        let measured = Measured::new(&scan, &params).unwrap();
        // Away from the rims.
        let inner: Vec<bool> = scan
            .positions()
            .iter()
            .map(|p| (20.0..80.0).contains(&p.x) && (20.0..80.0).contains(&p.y))
            .collect();
        figures(&measured, &inner).unwrap().rms_roughness
    };
    let one = 0.5f64.sqrt();
    assert!(
        (sq(Some(20.0), None) / one - 1.0).abs() < 0.1,
        "the long wave is left"
    );
    assert!(
        (sq(None, Some(20.0)) / one - 1.0).abs() < 0.1,
        "the short wave is left"
    );
    let halved = sq(None, Some(10.0));
    assert!((halved / (0.5 * one) - 1.0).abs() < 0.1, "{halved}");
    let refused = |s_filter, l_filter| {
        let params = MeasureParams {
            s_filter,
            l_filter,
            ..over(BaseKind::Plane)
        };
        Measured::new(&scan, &params).unwrap_err()
    };
    assert!(matches!(
        refused(Some(-1.0), None),
        StatsError::Length { .. }
    ));
    assert!(matches!(
        refused(Some(30.0), Some(10.0)),
        StatsError::NothingBetween { .. }
    ));
}

#[test]
fn another_piece_of_the_same_surface_is_natural_and_a_flatter_one_is_not() {
    let a = surface(Kind::Noise, 4000, 1);
    let b = surface(Kind::Noise, 4000, 2);
    let (comparison, natural) = compared(&a, &b);
    let said = verdict(&comparison, &natural, ["the first", "the second"]);
    assert_eq!(said.within, Some(true), "{}", said.text);

    let (comparison, natural) = compared(&a, &flattened(&b, 0.6));
    let said = verdict(&comparison, &natural, ["the first", "the second"]);
    assert_eq!(said.within, Some(false), "{}", said.text);
    let named = |name: &str| said.beyond.iter().find(|d| d.name == name);
    let change = named("Sdq").unwrap().change_percent.unwrap();
    assert!((change + 40.0).abs() < 12.0, "{change} %");
    assert!(said.text.starts_with("The second differs"), "{}", said.text);
}

#[test]
fn natural_variation_is_the_same_for_any_number_of_threads() {
    let (a, b) = (surface(Kind::Noise, 2500, 3), surface(Kind::Noise, 2500, 4));
    let in_pool = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| compared(&a, &b))
    };
    assert_eq!(in_pool(1), in_pool(3));
}

/// A torus with bumps.
fn torus() -> Scan {
    let (around, across) = (96u32, 32u32);
    let mut mesh = relievo::mesh::TriMesh::default();
    for v in 0..around * across {
        let turn = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let (u, w) = (turn(v / across, around), turn(v % across, across));
        let minor = 1.0 + 0.03 * (16.0 * u).sin() * (5.0 * w).cos();
        let ring = 3.0 + minor * w.cos();
        (mesh.positions).push(nalgebra::Point3::new(
            ring * u.cos(),
            ring * u.sin(),
            minor * w.sin(),
        ));
        let at = |i: u32, j: u32| i % around * across + j % across;
        let (i, j) = (v / across, v % across);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    to_scan(&mesh)
}

#[test]
fn a_scan_no_base_fits_is_measured_over_free_form() {
    let measured = Measured::new(&torus(), &MeasureParams::default()).unwrap();
    assert!(
        matches!(measured.base(), Form::Free(_)),
        "{:?}",
        measured.base()
    );
    let part = figures(&measured, &vec![true; measured.vertices()]).unwrap();
    // Bumps of amplitude 0.03 in two directions: Sq a half of it, less what the form has of them.
    assert!((0.006..0.018).contains(&part.areal.sq), "{}", part.areal.sq);
}

#[test]
fn compare_tells_the_figures_of_two_scans_and_of_two_parts() {
    let mut scan = surface(Kind::Noise, 3000, 1);
    let middle = scan.positions().iter().map(|p| p.x).sum::<f64>() / scan.vertices.rows as f64;
    let half = scan
        .positions()
        .iter()
        .map(|p| u8::from(p.x > middle))
        .collect();
    scan.vertices.set_channel("half", Column::U8(half));
    let place = Place::with("a.ply", &scan);
    place.put("b.ply", &flattened(&scan, 0.5));
    let run = place.done("compare a.ply b.ply --pieces 60 --json c.json --csv c.csv");
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(
        text.contains("b.ply differs from a.ply by more than"),
        "{text}"
    );
    let json = place.json("c.json");
    let ratio =
        json["b"]["areal"]["Sq"].as_f64().unwrap() / json["a"]["areal"]["Sq"].as_f64().unwrap();
    assert!((ratio - 0.5).abs() < 0.02, "{ratio}");
    assert_eq!(json["verdict"]["within"], false);
    let csv = String::from_utf8(place.bytes("c.csv")).unwrap();
    let sq = csv.lines().find(|line| line.starts_with("Sq,")).unwrap();
    let cells: Vec<&str> = sq.split(',').collect();
    assert_eq!(cells.len(), csv.lines().next().unwrap().split(',').count());
    let change: f64 = cells[4].parse().unwrap();
    assert!((change + 50.0).abs() < 2.0, "{sq}");

    place.done("compare a.ply --part half --pieces 60 --json halves.json");
    let halves = place.json("halves.json");
    let areas = ["a", "b"].map(|part| halves[part]["area"].as_f64().unwrap());
    assert!((areas[0] / areas[1] - 1.0).abs() < 0.3, "{areas:?}");
    assert_eq!(
        halves["verdict"]["within"], true,
        "{}",
        halves["verdict"]["text"]
    );
}

#[test]
fn what_cannot_be_compared_is_told_in_one_sentence() {
    let place = Place::with("a.ply", &surface(Kind::Noise, 600, 1));
    place.refused(2, "compare a.ply", &["second scan", "--part"]);
    place.refused(2, "compare a.ply --part no_such", &["a.ply", "no_such"]);
    place.refused(
        2,
        "compare a.ply a.ply --csv a.ply",
        &["a.ply", "overwrite"],
    );
    place.refused(1, "compare a.ply missing.ply", &["missing.ply"]);
    place.refused(2, "compare a.ply a.ply --pieces 5", &["--pieces", "60"]);
    let run = place.run("stats a.ply --csv - --json -");
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(
        run.stderr.contains("--json - and --csv -"),
        "{}",
        run.stderr
    );
    place.refused(
        2,
        "stats a.ply --whole --s-filter 3 --l-filter 2",
        &["--s-filter", "shorter"],
    );
    place.done("stats a.ply --whole");
    let run = place.done("compare a.ply a.ply --pieces 0 --csv -");
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(text.starts_with("name,unit,a,b,"), "{text}");
    let same = text.lines().find(|line| line.starts_with("Sa,")).unwrap();
    assert!(same.contains(",0,"), "{same}");
}
