//! How much true pieces of one surface differ, and what that makes of a figure.

use rayon::prelude::*;
use serde::Serialize;

use super::{Field, Figure, Measure};

/// The share of true pieces that score at most 1.
const QUANTILE: f64 = 0.95;
/// Pieces that are looked at between two words of progress.
const AT_ONCE: usize = 16;
/// Where all true pieces agree exactly (synthetic relief), so much of a difference counts as none.
const LEAST_QUANTILE: f64 = 1e-9;

/// The figures of true pieces.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// By figure: name, and its values over all true pieces that have it, ascending.
    figures: Vec<Null>,
    /// By [`Measure`] of [`Measure::ALL`]: the largest score of its figures, by piece.
    measures: Vec<Null>,
    /// The largest score of the measures, by piece.
    overall: Null,
    pieces: usize,
}

/// What a figure is on true pieces.
#[derive(Debug, Clone, Default)]
struct Null {
    /// Ascending.
    values: Vec<f64>,
    quantile: f64,
}

/// A value in units of the 95 % quantile of true pieces.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Score {
    /// The value over the quantile: at most 1 is within the surface's natural variation.
    pub score: f64,
    /// Share of true pieces (and this one) with at least this value: the rank as a p-value.
    pub p: f64,
}

/// A figure and its score.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FigureScore {
    /// The figure.
    #[serde(flatten)]
    pub figure: Figure,
    /// `None` where the piece or the true pieces do not have the figure.
    #[serde(flatten)]
    pub score: Option<Score>,
}

/// A measure and its score: the largest of its figures, calibrated like a figure of its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeasureScore {
    /// The measure.
    pub measure: Measure,
    /// Its score.
    #[serde(flatten)]
    pub score: Score,
}

/// What a piece's figures amount to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    /// The largest of the measures, calibrated like a figure of its own: at most 1 for 95 % of true pieces.
    pub overall: Score,
    /// Those that could be taken.
    pub measures: Vec<MeasureScore>,
    /// All figures.
    pub figures: Vec<FigureScore>,
}

impl Calibration {
    /// Takes the figures of true pieces, each against the known part without it; `progress` hears how many
    /// are done.
    #[must_use]
    pub fn new(
        field: &Field,
        known: &[bool],
        pieces: &[Vec<u32>],
        progress: &mut dyn FnMut(usize),
    ) -> Self {
        let mut table: Vec<Vec<Figure>> = Vec::with_capacity(pieces.len());
        for some in pieces.chunks(AT_ONCE) {
            table.par_extend(some.par_iter().map(|piece| field.figures(piece, known)));
            progress(table.len());
        }
        let count = table.first().map_or(0, Vec::len);
        let figures: Vec<Null> = (0..count)
            .map(|i| Null::new(table.iter().filter_map(|row| row[i].value)))
            .collect();
        let scores: Vec<Vec<Option<f64>>> = (table.iter())
            .map(|row| largest_by_measure(row, &figures))
            .collect();
        let measures: Vec<Null> = (0..Measure::ALL.len())
            .map(|m| Null::new(scores.iter().filter_map(|row| row[m])))
            .collect();
        let overall = Null::new(scores.iter().filter_map(|row| largest(row, &measures)));
        Self {
            figures,
            measures,
            overall,
            pieces: pieces.len(),
        }
    }

    /// Number of true pieces.
    #[must_use]
    pub fn pieces(&self) -> usize {
        self.pieces
    }

    /// Scores the figures of a piece (of the same field, or of one that was read in the same way).
    #[must_use]
    pub fn judge(&self, figures: &[Figure]) -> Judgement {
        let by_measure = largest_by_measure(figures, &self.figures);
        let overall = largest(&by_measure, &self.measures).unwrap_or(0.0);
        Judgement {
            overall: self
                .overall
                .score(overall)
                .unwrap_or(Score { score: 0.0, p: 1.0 }),
            measures: (Measure::ALL.into_iter().zip(&by_measure))
                .zip(&self.measures)
                .filter_map(|((measure, value), null)| {
                    let score = null.score((*value)?)?;
                    Some(MeasureScore { measure, score })
                })
                .collect(),
            figures: (figures.iter().zip(&self.figures))
                .map(|(figure, null)| FigureScore {
                    score: figure.value.and_then(|value| null.score(value)),
                    figure: figure.clone(),
                })
                .collect(),
        }
    }
}

impl Judgement {
    /// The score of a measure.
    #[must_use]
    pub fn of(&self, measure: Measure) -> Option<Score> {
        let found = self.measures.iter().find(|m| m.measure == measure);
        found.map(|m| m.score)
    }
}

impl Null {
    fn new(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        let quantile = quantile(&values, QUANTILE)
            .unwrap_or(0.0)
            .max(LEAST_QUANTILE);
        Self { values, quantile }
    }

    fn score(&self, value: f64) -> Option<Score> {
        if self.values.is_empty() {
            return None;
        }
        let below = self.values.partition_point(|v| *v < value);
        let at_least = self.values.len() - below;
        Some(Score {
            score: value / self.quantile,
            p: (at_least + 1) as f64 / (self.values.len() + 1) as f64,
        })
    }
}

/// By measure the largest score of its figures.
fn largest_by_measure(figures: &[Figure], nulls: &[Null]) -> Vec<Option<f64>> {
    (Measure::ALL.iter())
        .map(|measure| {
            (figures.iter().zip(nulls))
                .filter(|(figure, _)| figure.measure == *measure)
                .filter_map(|(figure, null)| Some(null.score(figure.value?)?.score))
                .reduce(f64::max)
        })
        .collect()
}

fn largest(by_measure: &[Option<f64>], nulls: &[Null]) -> Option<f64> {
    (by_measure.iter().zip(nulls))
        .filter_map(|(value, null)| Some(null.score((*value)?)?.score))
        .reduce(f64::max)
}

/// Quantile of ascending values, linear between them; `None` of none.
fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let at = share * last as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and the last index"
    )]
    let below = at.floor() as usize;
    let above = (below + 1).min(last);
    Some(values[below] + (at - below as f64) * (values[above] - values[below]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn ranks_are_p_values() {
        let null = Null::new((1..=99).map(f64::from));
        assert_relative_eq!(null.quantile, 94.1 + 0.0, epsilon = 1e-9);
        assert_relative_eq!(null.score(1000.0).unwrap().p, 0.01);
        assert_relative_eq!(null.score(0.0).unwrap().p, 1.0);
        assert_relative_eq!(null.score(95.0).unwrap().p, 0.06);
        assert!(null.score(95.0).unwrap().score > 1.0);
        assert!(null.score(94.0).unwrap().score < 1.0);
    }

    #[test]
    fn without_true_pieces_there_is_no_score() {
        assert_eq!(Null::new(std::iter::empty()).score(1.0), None);
    }
}
