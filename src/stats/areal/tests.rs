//! Parameters of maps whose values are known from formulas.

use approx::assert_relative_eq;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use super::*;
use crate::rng::{Rng, Stage};
use crate::scan::HeightMap;

const AMPLITUDE: f64 = 0.3;
const LENGTH: f64 = 20.0;

/// A map of 240 by 160 heights at steps of 1 and 0.5, from a function of x and y upwards.
fn map(of: impl Fn(f64, f64) -> f64) -> HeightMap {
    HeightMap::from_fn([240, 160], [1.0, 0.5], |column, row| {
        of(column as f64, -0.5 * row as f64)
    })
}

fn sine(place: f64) -> f64 {
    AMPLITUDE * (TAU * (place + 0.25) / LENGTH).sin()
}

fn parameters(map: &HeightMap) -> ArealParameters {
    ArealParameters::of_map(map, SlopeRule::default()).unwrap()
}

#[test]
fn a_wave_in_one_direction_has_the_values_of_the_formulas() {
    let across = map(|x, _| sine(x));
    let found = parameters(&across);
    assert_relative_eq!(found.sq, AMPLITUDE * FRAC_1_SQRT_2, max_relative = 1e-12);
    assert_relative_eq!(found.sa, AMPLITUDE * 2.0 / PI, max_relative = 1e-2);
    assert_relative_eq!(found.sku.unwrap(), 1.5, max_relative = 1e-12);
    let slope = AMPLITUDE * TAU / LENGTH;
    // The map ends a step before a whole number of waves; differences over a step see the slope lowered by sin(π/n) / (π/n).
    let seen = (PI / LENGTH).sin() / (PI / LENGTH);
    let sdq = found.sdq.unwrap();
    assert_relative_eq!(sdq, slope * seen * FRAC_1_SQRT_2, max_relative = 5e-3);
    let stencil = ArealParameters::of_map(&across, SlopeRule::Stencil).unwrap();
    assert_relative_eq!(
        stencil.sdq.unwrap(),
        slope * FRAC_1_SQRT_2,
        max_relative = 1e-2
    );
    // Mean of √(1 + p²) − 1 with p = s cos t, to fourth order.
    let s = slope * seen;
    let sdr = 100.0 * (s.powi(2) / 4.0 - 3.0 * s.powi(4) / 64.0);
    assert_relative_eq!(found.sdr.unwrap(), sdr, max_relative = 1e-2);
    // To within what a lag leaves out of 12 whole waves, and below out of 4.
    let sal = LENGTH * 0.2_f64.acos() / TAU;
    assert_relative_eq!(found.sal.unwrap(), sal, max_relative = 1e-2);
    assert_eq!(found.str, None);
    let apart = (found.std.unwrap() + 90.0).rem_euclid(180.0) - 90.0;
    assert!(apart.abs() < 0.2, "{:?}", found.std);
    let down = parameters(&map(|_, y| sine(y)));
    assert_relative_eq!(down.sal.unwrap(), sal, max_relative = 4e-2);
    assert!((down.std.unwrap() - 90.0).abs() < 0.2, "{:?}", down.std);
}

#[test]
fn directions_are_counterclockwise_with_the_first_row_on_top() {
    for degrees in [25.0_f64, 60.0, 140.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let found = parameters(&map(|x, y| sine(x * cos + y * sin)));
        assert!(
            (found.std.unwrap() - degrees).abs() < 0.5,
            "{degrees}: {:?}",
            found.std
        );
    }
}

#[test]
fn crossed_waves_decorrelate_first_along_the_diagonals() {
    let found = parameters(&map(|x, y| sine(x) + sine(y)));
    assert_relative_eq!(found.sq, AMPLITUDE, max_relative = 1e-12);
    // (cos u + cos v) / 2 is 0.2 at u = v = acos 0.2, and at cos u = −0.6, v = 0.
    let diagonal = 2.0_f64.sqrt() * 0.2_f64.acos();
    let straight = (-0.6_f64).acos();
    // A map of a few waves tells it to within some percent.
    let sal = diagonal * LENGTH / TAU;
    assert_relative_eq!(found.sal.unwrap(), sal, max_relative = 3e-2);
    assert_relative_eq!(found.str.unwrap(), diagonal / straight, max_relative = 3e-2);
}

#[test]
fn a_tilted_plane_is_all_slope_and_without_it_flat() {
    let tilted = map(|x, y| 40.0 + 0.1 * x - 0.3 * y);
    let found = parameters(&tilted);
    assert_relative_eq!(found.sdq.unwrap(), 0.1_f64.sqrt(), max_relative = 1e-12);
    assert_relative_eq!(
        found.sdr.unwrap(),
        100.0 * (1.1_f64.sqrt() - 1.0),
        max_relative = 1e-12
    );
    let flat = scale_limited_surface(&tilted, &SurfaceParams::default()).unwrap();
    let found = parameters(&flat);
    for row in found.rows() {
        let expected = match row.name {
            "Ssk" | "Sku" | "Sal" | "Str" | "Std" => None,
            "Smr2" => Some(100.0),
            _ => Some(0.0),
        };
        assert_eq!(row.value.is_some(), expected.is_some(), "{}", row.name);
        let apart = row.value.unwrap_or(0.0) - expected.unwrap_or(0.0);
        assert!(apart.abs() < 1e-12, "{}: {:?}", row.name, row.value);
    }
}

#[test]
fn a_sawtooth_has_evenly_distributed_heights() {
    let found = parameters(&map(|x, _| x % 24.0));
    // Heights 0 to 23 in equal numbers: variance (n² − 1) / 12.
    assert_relative_eq!(found.sq, (575.0_f64 / 12.0).sqrt(), max_relative = 1e-12);
    assert_relative_eq!(found.ssk.unwrap(), 0.0, epsilon = 1e-12);
    assert_relative_eq!(found.sku.unwrap(), 1.8, max_relative = 5e-3);
    assert_relative_eq!(found.sz, 23.0, max_relative = 1e-12);
    // The equivalent line falls by one tooth, to within one of its 24 heights.
    assert_relative_eq!(found.sk, 24.0, epsilon = 1.0);
}

#[test]
fn smoothed_noise_is_normal_isotropic_and_as_long_as_its_filter() {
    let mut rng = Rng::new(7, Stage::Synth, 0);
    let noise = HeightMap::from_fn([256, 256], [1.0, 1.0], |_, _| rng.normal());
    let cutoff = 12.0;
    let found = parameters(&long_waves(&noise, cutoff));
    assert_relative_eq!(found.ssk.unwrap(), 0.0, epsilon = 0.1);
    assert_relative_eq!(found.sku.unwrap(), 3.0, epsilon = 0.2);
    assert_relative_eq!(found.sk / found.sq, 2.574, max_relative = 0.03);
    assert_relative_eq!(found.spk / found.sq, 0.945, max_relative = 0.1);
    assert_relative_eq!(found.vvc / found.sq, 1.217, max_relative = 0.03);
    // The autocorrelation is exp(−π r² / 2 (α λ)²).
    let alpha = (2.0_f64.ln() / PI).sqrt();
    let sal = alpha * cutoff * (2.0 * 5.0_f64.ln() / PI).sqrt();
    assert_relative_eq!(found.sal.unwrap(), sal, max_relative = 0.06);
    assert!(found.str.unwrap() > 0.8, "{:?}", found.str);
}

#[test]
fn missing_heights_leave_the_parameters_of_the_rest() {
    let mut rng = Rng::new(3, Stage::Synth, 0);
    let whole = map(|x, y| sine(x) + 0.5 * sine(0.7 * y - 0.4 * x));
    let mut holed = whole.clone();
    for height in &mut holed.heights {
        if rng.uniform() < 0.2 {
            *height = f64::NAN;
        }
    }
    let (whole, holed) = (parameters(&whole), parameters(&holed));
    for (whole, holed) in whole.rows().into_iter().zip(holed.rows()) {
        assert_eq!(
            whole.value.is_some(),
            holed.value.is_some(),
            "{}",
            whole.name
        );
        if let (Some(whole_value), Some(holed_value)) = (whole.value, holed.value) {
            let apart = match whole.name {
                "Smr1" | "Smr2" => (holed_value - whole_value) / 100.0,
                "Ssk" => holed_value - whole_value,
                "Std" => ((holed_value - whole_value + 90.0).rem_euclid(180.0) - 90.0) / 180.0,
                _ => holed_value / whole_value - 1.0,
            };
            assert!(
                apart.abs() < 0.03,
                "{}: {whole_value}, {holed_value}",
                whole.name
            );
        }
    }
}

#[test]
fn filters_take_away_what_is_too_short_and_too_long() {
    let surface = map(|x, y| 0.01 * x - y + sine(x) + 10.0 * sine(x / 10.0) + sine(4.0 * y));
    let params = SurfaceParams {
        s_filter: Some(10.0),
        l_filter: Some(60.0),
        ..SurfaceParams::default()
    };
    let found = parameters(&scale_limited_surface(&surface, &params).unwrap());
    // Of the wave of 20, the S-filter lets 2^(−1/4) pass, and the L-filter 1 − 2^(−9) of that.
    let expected = AMPLITUDE * FRAC_1_SQRT_2 * 0.5_f64.powf(0.25) * (1.0 - 0.5_f64.powi(9));
    // Near the rims the long wave is not quite taken away.
    assert_relative_eq!(found.sq, expected, max_relative = 0.3);
    assert!(
        (found.std.unwrap() + 90.0).rem_euclid(180.0) - 90.0 < 2.0,
        "{:?}",
        found.std
    );
}

#[test]
fn maps_and_filters_that_do_not_suit_each_other_are_refused() {
    let refused = |map: &HeightMap, s_filter, l_filter| {
        let params = SurfaceParams {
            s_filter,
            l_filter,
            ..SurfaceParams::default()
        };
        scale_limited_surface(map, &params).unwrap_err().to_string()
    };
    let whole = map(|x, y| x * y);
    assert!(refused(&whole, Some(100.0), None).contains("longer than the map"));
    assert!(refused(&whole, None, Some(-1.0)).contains("not a positive length"));
    assert!(refused(&whole, Some(9.0), Some(8.0)).contains("nothing would be left"));
    let small = HeightMap::from_fn([2, 50], [1.0, 1.0], |_, row| row as f64);
    assert!(refused(&small, None, None).contains("at least 3 by 3"));
    let unknown = HeightMap::from_fn([5, 5], [1.0, 1.0], |_, _| f64::NAN);
    assert!(refused(&unknown, None, None).contains("0 known heights"));
    assert_eq!(
        ArealParameters::of_map(&unknown, SlopeRule::default()),
        None
    );
}
