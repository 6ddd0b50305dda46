//! What a comparison amounts to, in words.

use serde::Serialize;

use crate::likeness::{Judgement, Measure, Summary, worst_figures};

use super::rows::change_percent;
use super::{Comparison, Natural, StatsError};

/// Differences that are named, at most.
const NAMED: usize = 6;

/// What is said of so much of a part is said of the part.
const MOST_OF_IT: f64 = 0.9;

/// What a comparison amounts to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// Whether the second part is within the natural variation of the first; `None` if that cannot be told.
    pub within: Option<bool>,
    /// In words: a sentence or two.
    pub text: String,
    /// Differences beyond natural variation, the largest first.
    pub beyond: Vec<Difference>,
}

/// A figure in which a part differs from the other by more than pieces of the latter do.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// Name of the figure, as in `Sdq` or `L* variogram`.
    pub name: String,
    /// The measure that it belongs to.
    pub measure: Measure,
    /// Median over all pieces of how many times more than natural it is.
    pub score: f64,
    /// Change in percent of the original's, for figures that are numbers of a part.
    pub change_percent: Option<f64>,
}

/// Says in words what exceeds natural variation. `names` are those of the parts, as in "the original" and
/// "the completed part".
#[must_use]
pub fn verdict(
    comparison: &Comparison,
    natural: &Result<Natural, StatsError>,
    names: [&str; 2],
) -> Verdict {
    let [first, second] = names;
    let copied = copied(comparison);
    let natural = match natural {
        Ok(natural) => natural,
        Err(reason) => {
            return Verdict {
                within: None,
                text: format!(
                    "Whether the differences are natural cannot be told: {reason}.{copied}"
                ),
                beyond: Vec::new(),
            };
        }
    };
    let overall = natural.scores.overall;
    let beyond = beyond(comparison, natural);
    let within = overall.median <= 1.0;
    let looked_at = looked_at(natural);
    let sentence = match (within, beyond.is_empty(), overall.outside) {
        (true, true, 0) => format!(
            "Nothing tells {second} from {first}: no difference exceeds what pieces of {first} differ by themselves{looked_at}."
        ),
        (true, true, outside) => format!(
            "Most of {second} is within the natural variation of {first}; {outside} of {} pieces differ more, the worst {:.2} times as much as is natural{looked_at}.",
            overall.pieces, overall.worst
        ),
        (true, false, _) => format!(
            "As a whole {second} is within the natural variation of {first}{looked_at}; beyond it: {}.",
            told(&beyond)
        ),
        (false, true, outside) => format!(
            "{} differs from {first} by more than pieces of {first} differ by themselves{looked_at}, but {outside} of {} pieces each in another way: {}.",
            capitalized(second),
            overall.pieces,
            outside_in_words(natural)
        ),
        (false, false, _) => format!(
            "{} differs from {first} by more than pieces of {first} differ by themselves{looked_at}: {}.",
            capitalized(second),
            told(&beyond)
        ),
    };
    Verdict {
        within: Some(within),
        text: format!("{sentence}{copied}"),
        beyond,
    }
}

/// How much the verdict is about.
fn looked_at(natural: &Natural) -> String {
    let pieces = match natural.pieces.len() {
        1 => "one piece".to_owned(),
        count => format!("{count} pieces"),
    };
    if natural.share < MOST_OF_IT {
        let percent = 100.0 * natural.share;
        format!(" ({pieces} looked at, {percent:.0} % of it)")
    } else {
        format!(" ({pieces} looked at)")
    }
}

/// The worst figures of the measures that are outside in some piece.
fn outside_in_words(natural: &Natural) -> String {
    let judgements: Vec<&Judgement> = natural.pieces.iter().map(|p| &p.judgement).collect();
    let worst = (natural.scores.measures.iter())
        .filter(|m| m.scores.outside > 0)
        .flat_map(|m| worst_figures(&judgements, m.measure).into_iter().take(1))
        .map(|(name, score)| format!("{name} (up to {score:.1} times)"));
    worst.collect::<Vec<_>>().join(", ")
}

/// The largest differences, and how many more there are.
fn told(beyond: &[Difference]) -> String {
    let named: Vec<String> = beyond.iter().take(NAMED).map(in_words).collect();
    let more = match beyond.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    named.join(", ") + &more
}

fn copied(comparison: &Comparison) -> &'static str {
    match &comparison.copies {
        Some(copies) if copies.is_paste => " Most of it is one verbatim copy.",
        Some(copies) if copies.is_garbage => " Much of it is copied from one vertex.",
        _ => "",
    }
}

fn in_words(difference: &Difference) -> String {
    let times = format!("{:.1} times", difference.score);
    match difference.change_percent {
        Some(change) => format!("{} ({change:+.0} %, {times})", difference.name),
        None => format!("{} ({times})", difference.name),
    }
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        // Names of files stay as they are.
        Some(first) if text.starts_with("the ") => first.to_uppercase().chain(letters).collect(),
        _ => text.to_owned(),
    }
}

/// The figures that exceed natural variation, of the measures that do.
fn beyond(comparison: &Comparison, natural: &Natural) -> Vec<Difference> {
    let judgements: Vec<&Judgement> = natural.pieces.iter().map(|p| &p.judgement).collect();
    let mut beyond = Vec::new();
    let outside = (natural.scores.measures.iter()).filter(|m| m.scores.median > 1.0);
    for measure in outside {
        let mut figures = differences(comparison, &judgements, measure.measure);
        figures.sort_by(|a, b| b.score.total_cmp(&a.score));
        // A measure is calibrated as the largest of its figures: at least that one is meant.
        let count = figures.iter().filter(|f| f.score > 1.0).count().max(1);
        beyond.extend(figures.into_iter().take(count));
    }
    beyond.sort_by(|a, b| b.score.total_cmp(&a.score));
    beyond
}

/// All figures of a measure with their median scores.
fn differences(
    comparison: &Comparison,
    judgements: &[&Judgement],
    measure: Measure,
) -> Vec<Difference> {
    let Some(first) = judgements.first() else {
        return Vec::new();
    };
    (first.figures.iter().enumerate())
        .filter(|(_, f)| f.figure.measure == measure)
        .filter_map(|(i, f)| {
            let scores = judgements.iter().filter_map(|j| j.figures.get(i)?.score);
            let median = Summary::of(scores.map(|score| score.score).collect())?.median;
            Some(Difference {
                change_percent: change(comparison, &f.figure.name),
                name: f.figure.name.clone(),
                measure,
                score: median,
            })
        })
        .collect()
}

/// By how many percent a number of the second part is above that of the first.
fn change(comparison: &Comparison, name: &str) -> Option<f64> {
    let rows = comparison.original.rows().into_iter();
    let (old, new) = (rows.zip(comparison.completed.rows())).find(|(old, _)| old.name == name)?;
    change_percent(&old, &new)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likeness::{Figure, FigureScore, MeasureScore, Score, Scores};
    use crate::stats::{JudgedPiece, Variogram};

    /// A piece with a score for each measure, each of one figure.
    fn piece(scores: &[(Measure, f64)], overall: f64) -> JudgedPiece {
        let score = |score| Score { score, p: 0.5 };
        JudgedPiece {
            vertices: 100,
            area: 1.0,
            judgement: Judgement {
                overall: score(overall),
                measures: (scores.iter())
                    .map(|(measure, value)| MeasureScore {
                        measure: *measure,
                        score: score(*value),
                    })
                    .collect(),
                figures: (scores.iter())
                    .map(|(measure, value)| FigureScore {
                        figure: Figure {
                            measure: *measure,
                            name: measure.name().to_owned(),
                            value: Some(*value),
                        },
                        score: Some(score(*value)),
                    })
                    .collect(),
            },
        }
    }

    fn natural(pieces: Vec<JudgedPiece>, share: f64) -> Natural {
        let judgements: Vec<&Judgement> = pieces.iter().map(|p| &p.judgement).collect();
        Natural {
            calibration_pieces: 60,
            share,
            variogram: Variogram {
                distances: Vec::new(),
                original: Vec::new(),
                completed: Vec::new(),
            },
            scores: Scores::of(&judgements),
            pieces,
        }
    }

    fn said(natural: Natural) -> Verdict {
        let scan = crate::synth::scan(&crate::synth::SynthParams {
            vertices: 1000,
            ..Default::default()
        });
        let scan = scan.expect("the parameters are in range").scan;
        let measured = crate::stats::Measured::new(&scan, &Default::default()).unwrap();
        let positions = scan.positions();
        let middle = positions.iter().map(|p| p.x).sum::<f64>() / positions.len() as f64;
        let left: Vec<bool> = positions.iter().map(|p| p.x < middle).collect();
        let right: Vec<bool> = left.iter().map(|is| !is).collect();
        let comparison = crate::stats::compare_parts(&measured, &left, &right);
        let names = ["the original", "the completed part"];
        verdict(&comparison.unwrap(), &Ok(natural), names)
    }

    #[test]
    fn the_sentence_fits_the_scores() {
        use Measure::{Areal, Seam, Variogram};
        let natural_piece = || piece(&[(Areal, 0.5), (Seam, 0.4)], 0.6);
        let nothing = said(natural(vec![natural_piece()], 1.0));
        assert!(
            nothing
                .text
                .starts_with("Nothing tells the completed part from the original")
        );
        assert_eq!(nothing.within, Some(true));

        let some = said(natural(
            vec![
                natural_piece(),
                natural_piece(),
                piece(&[(Areal, 3.0)], 2.5),
            ],
            0.5,
        ));
        assert_eq!(some.within, Some(true));
        for words in ["1 of 3 pieces differ more", "2.50 times", "50 % of it"] {
            assert!(some.text.contains(words), "{}", some.text);
        }

        let each_its_own = said(natural(
            vec![
                piece(&[(Areal, 2.0), (Seam, 0.5), (Variogram, 0.5)], 2.0),
                piece(&[(Areal, 0.5), (Seam, 2.0), (Variogram, 0.5)], 2.0),
                piece(&[(Areal, 0.5), (Seam, 0.5), (Variogram, 2.0)], 2.0),
            ],
            1.0,
        ));
        assert_eq!(each_its_own.within, Some(false));
        assert!(each_its_own.beyond.is_empty());
        for words in [
            "each in another way",
            "areal (up to 2.0 times)",
            "seam (up to",
        ] {
            assert!(each_its_own.text.contains(words), "{}", each_its_own.text);
        }

        let plain = said(natural(vec![piece(&[(Areal, 1.8), (Seam, 0.2)], 1.5)], 1.0));
        assert_eq!(plain.beyond.len(), 1);
        assert!(
            plain.text.ends_with(": areal (1.8 times)."),
            "{}",
            plain.text
        );
    }
}
