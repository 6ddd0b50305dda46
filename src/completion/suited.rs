//! Parameters that suit the relief: what was not given follows from what is measured.
//!
//! Why these rules and no others is in `BENCHMARKS.md`, "Parameters by themselves".

use crate::rng::Rng;
use crate::sampling::EdgeSpacing;

use super::correlation::{Correlation, Readable, correlation};
use super::{Chosen, CompleteParams};

/// The paper's window and rotations (Breckon & Fisher 2005, §5), and its error threshold (after Efros &
/// Leung 1999).
pub(super) const PAPER_WINDOW: usize = 5;
const PAPER_ROTATIONS: u32 = 4;
const PAPER_THRESHOLD: f64 = 0.3;
/// The paper weighs shape and colour alike.
const PAPER_MU: f64 = 0.5;

/// The window is so many periods of the relief: it sees 8/5 of that.
const WINDOW_A_PERIOD: f64 = 0.8;
/// A window takes time by its square.
const MOST_WINDOW: f64 = 8.0;
/// Relief with a lower texture aspect ratio is ridged.
const RIDGED: f64 = 0.5;
/// A place is tried as it lies, and turned by half.
const ROTATIONS: f64 = 2.0;
/// Neither height nor colour weighs less than this.
const LEAST_MU: f64 = 0.2;

/// Relief that changes from vertex to vertex by at most this share of its height is smooth.
const SMOOTH_RELIEF: f64 = 0.2;

const GIVEN: &str = "given";
const NO_RELIEF: &str = "there is no relief to go by";

/// What growing is done with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Settings {
    pub(super) window: usize,
    pub(super) rotations: u32,
    pub(super) error_threshold: f64,
    /// μ; 0 without colours.
    pub(super) mu: f64,
}

impl Settings {
    /// As given, and as in the paper's experiments where nothing is.
    pub(super) fn of_paper(params: &CompleteParams, has_colors: bool) -> Self {
        let mu = params.mu.unwrap_or(PAPER_MU);
        Self {
            window: params.window.unwrap_or(PAPER_WINDOW),
            rotations: params.rotations.unwrap_or(PAPER_ROTATIONS),
            error_threshold: params.error_threshold.unwrap_or(PAPER_THRESHOLD),
            mu: if has_colors { mu } else { 0.0 },
        }
    }
}

/// How new vertices stand, and why.
pub(super) fn spacing(params: &CompleteParams, edges: &EdgeSpacing) -> Chosen {
    let reason = match params.spacing {
        Some(_) => GIVEN.to_owned(),
        None => format!(
            "10 % of the scan's edges are shorter, so that none of its detail is lost; the median edge is {:.4}",
            edges.median
        ),
    };
    Chosen {
        name: "spacing",
        value: edges.spacing,
        reason,
    }
}

/// Whether copied patches are fitted to each other, on relief that changes by this share of its height from
/// vertex to vertex; and why.
pub(super) fn blending(params: &CompleteParams, roughness: f64) -> (bool, Chosen) {
    let is_smooth = roughness <= SMOOTH_RELIEF;
    let blends = params.blend.unwrap_or(is_smooth);
    let reason = match (params.blend, is_smooth) {
        (Some(_), _) => GIVEN.to_owned(),
        (None, true) => format!(
            "from vertex to vertex the relief changes by {roughness:.2} of its height only: steps between copied patches would show"
        ),
        (None, false) => format!(
            "from vertex to vertex the relief changes by {roughness:.2} of its height: steps between copied patches do not show, and to smooth them would change it"
        ),
    };
    let chosen = Chosen {
        name: "blend",
        value: f64::from(u8::from(blends)),
        reason,
    };
    (blends, chosen)
}

/// What suits the relief, with reasons: what is given stays as it is.
pub(super) fn suited(
    relief: &Readable,
    spacing: f64,
    params: &CompleteParams,
    rng: &mut Rng,
) -> (Settings, Vec<Chosen>) {
    let measured = correlation(relief, rng);
    let measured = measured.as_ref();
    let mut chosen = Vec::new();
    let mut choose = |name, given: Option<f64>, rule: (f64, String)| {
        let (value, reason) = match given {
            Some(given) => (given, GIVEN.to_owned()),
            None => rule,
        };
        chosen.push(Chosen {
            name,
            value,
            reason,
        });
        value
    };
    let given = params.window.map(|window| window as f64);
    let window = choose("window", given, window(measured, relief.step / spacing));
    let given = params.rotations.map(f64::from);
    let rotations = choose("rotations", given, rotations(measured));
    let mu = match relief.colors {
        Some(_) => choose("shape-weight", params.mu, color_weight(measured)),
        None => 0.0,
    };
    let rule = error_threshold(measured, mu);
    let error_threshold = choose("error-threshold", params.error_threshold, rule);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "whole numbers from 1 to 360"
    )]
    let settings = Settings {
        window: window as usize,
        rotations: rotations as u32,
        error_threshold,
        mu,
    };
    (settings, chosen)
}

/// Wide enough to see where periodic relief begins anew; a wider window than the paper's finds fewer
/// places like what it sees, which is worse on relief without a period.
fn window(measured: Option<&Correlation>, spacings_a_step: f64) -> (f64, String) {
    let least = PAPER_WINDOW as f64;
    let Some(measured) = measured else {
        return (least, NO_RELIEF.to_owned());
    };
    let length = measured.length * spacings_a_step;
    match measured.period {
        Some(period) => {
            let period = period * spacings_a_step;
            let window = (WINDOW_A_PERIOD * period).ceil().clamp(least, MOST_WINDOW);
            let reason = format!(
                "the relief repeats every {period:.1} spacings; the window sees {:.1} to each side",
                1.6 * window
            );
            (window, reason)
        }
        None => (
            least,
            format!(
                "the relief repeats nowhere within 32 edges and hangs together over {length:.1} spacings: as in the paper's experiments"
            ),
        ),
    }
}

/// Half a turn leaves the direction of ridges as it is. Relief that looks alike in all directions could be
/// turned by any angle, but the more there is to choose from the smoother are the matches, and it fades.
fn rotations(measured: Option<&Correlation>) -> (f64, String) {
    let Some(Correlation { aspect, .. }) = measured else {
        return (1.0, NO_RELIEF.to_owned());
    };
    let reason = if *aspect < RIDGED {
        format!(
            "the relief is ridged, it hangs together {:.1} times as far along as across: half turns keep that direction",
            1.0 / aspect
        )
    } else {
        format!(
            "the relief looks much alike in all directions (texture aspect ratio {aspect:.2}): half turns are variety enough, more of them find smoother matches"
        )
    };
    (ROTATIONS, reason)
}

/// So that height and colour have an equal say: the one that varies more would else decide alone.
fn color_weight(measured: Option<&Correlation>) -> (f64, String) {
    let Some(measured) = measured else {
        return (1.0, "there is no relief to go by, only colour".to_owned());
    };
    let height = measured.height_variance;
    let color = measured.color_variance.unwrap_or(0.0);
    let mu = (height / (height + color)).clamp(LEAST_MU, 1.0 - LEAST_MU);
    let correlation = match measured.height_lightness {
        Some(coefficient) => format!("; height and lightness are correlated by {coefficient:.2}"),
        None => String::new(),
    };
    let reason = format!(
        "so that height (variance {height:.3} of its squared range) and colour ({color:.3}) have an equal say{correlation}"
    );
    (mu, reason)
}

/// What unrelated places differ by: what costs as much is no match.
fn error_threshold(measured: Option<&Correlation>, mu: f64) -> (f64, String) {
    let Some(measured) = measured else {
        return (PAPER_THRESHOLD, NO_RELIEF.to_owned());
    };
    let color = measured.color_variance.unwrap_or(0.0);
    let unrelated = 2.0 * ((1.0 - mu) * measured.height_variance + mu * color);
    let reason = format!(
        "unrelated places cost {unrelated:.3} on average, and what costs as much is no match"
    );
    (unrelated.min(PAPER_THRESHOLD), reason)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const RANDOM: Correlation = Correlation {
        length: 3.0,
        aspect: 0.9,
        period: None,
        height_variance: 0.02,
        color_variance: Some(0.06),
        height_lightness: Some(0.5),
    };

    #[test]
    fn the_window_sees_a_period_within_bounds() {
        let of = |period| {
            let relief = Correlation { period, ..RANDOM };
            window(Some(&relief), 1.2).0
        };
        assert_relative_eq!(of(None), 5.0);
        assert_relative_eq!(of(Some(3.0)), 5.0);
        assert_relative_eq!(of(Some(7.0)), 7.0);
        assert_relative_eq!(of(Some(30.0)), MOST_WINDOW);
        assert_relative_eq!(window(None, 1.2).0, 5.0);
    }

    #[test]
    fn ridged_relief_is_aligned_and_flat_relief_never_turned() {
        let ridged = Correlation {
            aspect: 0.2,
            ..RANDOM
        };
        let (count, reason) = rotations(Some(&ridged));
        // As it lies, and turned by half: no other rotation keeps the direction.
        assert_relative_eq!(count, 2.0);
        assert!(reason.contains("5.0 times"), "{reason}");
        assert!(rotations(Some(&RANDOM)).1.contains("0.90"));
        assert_relative_eq!(rotations(None).0, 1.0);
    }

    #[test]
    fn what_varies_less_gets_more_weight() {
        let (mu, reason) = color_weight(Some(&RANDOM));
        assert_relative_eq!(mu, 0.25, epsilon = 1e-12);
        assert!(reason.contains("0.50"), "{reason}");
        let gray = Correlation {
            color_variance: Some(0.0),
            height_lightness: None,
            ..RANDOM
        };
        assert_relative_eq!(color_weight(Some(&gray)).0, 1.0 - LEAST_MU);
        assert_relative_eq!(color_weight(None).0, 1.0);
    }

    #[test]
    fn the_threshold_is_the_cost_of_chance() {
        assert_relative_eq!(error_threshold(Some(&RANDOM), 0.0).0, 0.04, epsilon = 1e-12);
        assert_relative_eq!(error_threshold(Some(&RANDOM), 0.5).0, 0.08, epsilon = 1e-12);
        assert_relative_eq!(error_threshold(None, 0.5).0, PAPER_THRESHOLD);
    }
}
