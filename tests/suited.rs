//! Parameters that follow from the scan unless they are given.

mod common;

use common::{holed, values};
use relievo::completion::{Chosen, CompleteParams, Completion, Method, complete};
use relievo::sampling::SpacingRule;
use relievo::scan::Scan;
use relievo::synth::Kind;

fn completed(scan: &Scan, params: &CompleteParams) -> Completion {
    complete(scan, params, &mut |_| {}).expect("it can be completed")
}

/// What was chosen, by the name of the option.
#[track_caller]
fn of<'a>(completion: &'a Completion, name: &str) -> &'a Chosen {
    let chosen = &completion.report.chosen;
    let mut found = chosen.iter().filter(|chosen| chosen.name == name);
    let first = found.next().expect("it is told");
    assert!(found.next().is_none(), "{name} is told twice");
    first
}

/// As given: bit for bit what growing results in.
fn result(completion: &Completion) -> (Vec<[f64; 3]>, Vec<f64>) {
    let positions = completion.scan.positions();
    let positions = positions.iter().map(|p| [p.x, p.y, p.z]).collect();
    (positions, values(&completion.scan, "source"))
}

#[test]
fn what_is_given_is_kept_and_told_as_given() {
    let params = CompleteParams {
        window: Some(3),
        rotations: Some(6),
        error_threshold: Some(0.25),
        mu: Some(0.7),
        spacing: Some(SpacingRule::Scan),
        blend: Some(true),
        ..CompleteParams::default()
    };
    let completion = completed(&holed(Kind::Bricks), &params);
    let told: Vec<(&str, f64)> = (completion.report.chosen.iter())
        .map(|chosen| {
            assert_eq!(chosen.reason, "given");
            (chosen.name, chosen.value)
        })
        .collect();
    let expected = [
        ("spacing", completion.report.spacing.median),
        ("window", 3.0),
        ("rotations", 6.0),
        ("shape-weight", 0.7),
        ("error-threshold", 0.25),
        ("blend", 1.0),
    ];
    assert_eq!(told, expected);
}

#[test]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "small whole numbers"
)]
fn giving_what_was_chosen_changes_nothing_but_the_reason() {
    let scan = holed(Kind::Bark);
    let chosen = completed(&scan, &CompleteParams::default());
    let again = CompleteParams {
        window: Some(of(&chosen, "window").value as usize),
        rotations: Some(of(&chosen, "rotations").value as u32),
        error_threshold: Some(of(&chosen, "error-threshold").value),
        mu: Some(of(&chosen, "shape-weight").value),
        spacing: Some(SpacingRule::Length(of(&chosen, "spacing").value)),
        ..CompleteParams::default()
    };
    let given = completed(&scan, &again);
    assert_eq!(result(&chosen), result(&given));
    assert_ne!(chosen.report.chosen, given.report.chosen);
    let other = CompleteParams {
        mu: Some(0.0),
        ..again
    };
    assert_ne!(result(&chosen), result(&completed(&scan, &other)));
}

#[test]
fn reasons_say_what_was_measured() {
    let bark = completed(&holed(Kind::Bark), &CompleteParams::default());
    assert!(of(&bark, "rotations").reason.contains("ridged"));
    assert!(
        of(&bark, "shape-weight")
            .reason
            .contains("correlated by 0.")
    );
    let ball = completed(&holed(Kind::GolfBall), &CompleteParams::default());
    let rotations = &of(&ball, "rotations").reason;
    assert!(rotations.contains("alike in all directions"), "{rotations}");
    let names: Vec<&str> = ball.report.chosen.iter().map(|c| c.name).collect();
    // No weight of colours where there are none.
    assert_eq!(
        names,
        ["spacing", "window", "rotations", "error-threshold", "blend"]
    );
}

#[test]
fn the_papers_method_has_the_papers_parameters_and_chooses_nothing() {
    let scan = holed(Kind::Bricks);
    let paper = CompleteParams {
        method: Method::Paper,
        ..CompleteParams::default()
    };
    let spelled_out = CompleteParams {
        window: Some(5),
        rotations: Some(4),
        error_threshold: Some(0.3),
        mu: Some(0.5),
        spacing: Some(SpacingRule::Nyquist),
        ..paper.clone()
    };
    let completion = completed(&scan, &paper);
    assert_eq!(completion.report.chosen, []);
    assert_eq!(result(&completion), result(&completed(&scan, &spelled_out)));
}

#[test]
fn the_choice_does_not_depend_on_the_number_of_threads() {
    let scan = holed(Kind::Noise);
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let run = || completed(&scan, &CompleteParams::default());
        let completion = pool.expect("threads").install(run);
        (result(&completion), completion.report.chosen)
    });
    assert_eq!(one, three);
}
