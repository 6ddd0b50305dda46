//! What several pieces' judgements amount to.

use serde::Serialize;

use super::{FigureScore, Judgement, Measure};

/// A score over several pieces.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Median.
    pub median: f64,
    /// Largest.
    pub worst: f64,
    /// Number of pieces with a score above 1: outside of the surface's natural variation.
    pub outside: usize,
    /// Number of pieces that have the score.
    pub pieces: usize,
}

/// A measure over several pieces.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeasureSummary {
    /// The measure.
    pub measure: Measure,
    /// Its scores.
    #[serde(flatten)]
    pub scores: Summary,
}

/// Several pieces together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// The largest of the measures of each piece, calibrated like a measure of its own.
    pub overall: Summary,
    /// Each measure over all pieces.
    pub measures: Vec<MeasureSummary>,
}

impl Scores {
    /// Of some pieces.
    #[must_use]
    pub fn of(judgements: &[&Judgement]) -> Self {
        let measure = |measure: &Measure| {
            let scores = judgements.iter().filter_map(|j| j.of(*measure));
            let scores = Summary::of(scores.map(|s| s.score).collect())?;
            Some(MeasureSummary {
                measure: *measure,
                scores,
            })
        };
        let overall = judgements.iter().map(|j| j.overall.score).collect();
        Self {
            overall: Summary::of(overall).unwrap_or_default(),
            measures: Measure::ALL.iter().filter_map(measure).collect(),
        }
    }
}

/// Figures of a measure that are outside in some piece, with the worst score of each, worst first.
#[must_use]
pub fn worst_figures(judgements: &[&Judgement], measure: Measure) -> Vec<(String, f64)> {
    let mut worst: Vec<(String, f64)> = Vec::new();
    let outside = |f: &&FigureScore| f.score.is_some_and(|score| score.score > 1.0);
    for found in (judgements.iter())
        .flat_map(|j| &j.figures)
        .filter(|f| f.figure.measure == measure)
        .filter(outside)
    {
        let score = found.score.map_or(0.0, |score| score.score);
        let known = (worst.iter_mut()).find(|(name, _)| *name == found.figure.name);
        match known {
            Some((_, known)) => *known = known.max(score),
            None => worst.push((found.figure.name.clone(), score)),
        }
    }
    worst.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    worst
}

impl Summary {
    /// Of some scores; `None` of none.
    #[must_use]
    pub fn of(mut scores: Vec<f64>) -> Option<Self> {
        scores.sort_by(f64::total_cmp);
        let (low, high) = (
            scores.get(scores.len().checked_sub(1)? / 2)?,
            scores.get(scores.len() / 2)?,
        );
        Some(Self {
            median: 0.5 * (low + high),
            worst: *scores.last()?,
            outside: scores.iter().filter(|score| **score > 1.0).count(),
            pieces: scores.len(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_in_the_middle() {
        let of = |scores: &[f64]| Summary::of(scores.to_vec()).unwrap();
        let three = of(&[3.0, 0.5, 1.5]);
        assert_eq!((three.outside, three.pieces), (2, 3));
        assert!((three.median - 1.5).abs() < 1e-12 && (three.worst - 3.0).abs() < 1e-12);
        assert!((of(&[1.0, 2.0]).median - 1.5).abs() < 1e-12);
        assert_eq!(Summary::of(Vec::new()), None);
    }
}
