//! Scores in units of natural variation, for people.

use std::fmt::Write;

use crate::likeness::{Judgement, MeasureSummary, Summary, worst_figures};

/// Figures named of each measure that is outside.
const NAMED: usize = 4;

/// A row for each measure, and one for all together.
pub(super) fn table(text: &mut String, measures: &[MeasureSummary], overall: &Summary) {
    let _ = writeln!(
        text,
        "{:<24} {:>9} {:>9} {:>11}",
        "score (1 = natural)", "median", "worst", "outside"
    );
    let mut row = |name: &str, scores: &Summary| {
        let outside = format!("{} of {}", scores.outside, scores.pieces);
        let _ = writeln!(
            text,
            "{name:<24} {:>9.2} {:>9.2} {outside:>11}",
            scores.median, scores.worst
        );
    };
    for measure in measures {
        row(measure.measure.name(), &measure.scores);
    }
    row("all together", overall);
}

/// The measures that are outside in some piece, with their worst figures; empty for none.
pub(super) fn outside(measures: &[MeasureSummary], judgements: &[&Judgement]) -> String {
    let told: Vec<String> = (measures.iter())
        .filter(|m| m.scores.outside > 0)
        .map(|m| {
            let figures: Vec<String> = (worst_figures(judgements, m.measure).iter())
                .take(NAMED)
                .map(|(name, score)| format!("{name} {score:.1}"))
                .collect();
            format!("{} ({})", m.measure.name(), figures.join(", "))
        })
        .collect();
    told.join("; ")
}
