//! Figures as lines of a table.

use crate::likeness::{FigureScore, Summary};

use super::areal::{ParameterUnit, Row};
use super::{Comparison, Natural, ReliefPart};

/// A figure of both parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparisonRow {
    /// Its name.
    pub name: &'static str,
    /// What it is, in a few words; empty where the name says it.
    pub meaning: &'static str,
    /// What it is counted in.
    pub unit: ParameterUnit,
    /// Of the original part; `None` where it is not defined.
    pub original: Option<f64>,
    /// Of the completed part.
    pub completed: Option<f64>,
    /// By how many percent the completed part's is above the original's, where that makes sense.
    pub change_percent: Option<f64>,
    /// How many times more than natural the figure differs, the median over all judged pieces. It is read
    /// around the vertices at the median edge (see [`crate::likeness`]), while the values are those of the
    /// parts as wholes.
    pub score: Option<f64>,
}

impl ReliefPart {
    /// All figures as lines of a table.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        let row = |name, value, unit| Row {
            name,
            value: Some(value),
            unit,
            meaning: "",
        };
        let mut rows = vec![
            row("base area", self.area, ParameterUnit::Area),
            row("mean integral", self.mean_integral, ParameterUnit::Height),
            row("mean height", self.mean_height, ParameterUnit::Height),
        ];
        rows.extend(self.areal.rows());
        rows
    }
}

impl Comparison {
    /// All figures of both parts as lines of a table, with their scores if they were taken.
    #[must_use]
    pub fn rows(&self, natural: Option<&Natural>) -> Vec<ComparisonRow> {
        (self.original.rows().into_iter())
            .zip(self.completed.rows())
            .map(|(old, new)| ComparisonRow {
                name: old.name,
                meaning: old.meaning,
                unit: old.unit,
                original: old.value,
                completed: new.value,
                change_percent: change_percent(&old, &new),
                score: natural.and_then(|natural| score(natural, old.name)),
            })
            .collect()
    }
}

/// A change in percent says something of what is above zero and has no sign.
pub(super) fn change_percent(old: &Row, new: &Row) -> Option<f64> {
    let of_wholes = ["base area", "mean height", "Ssk"].contains(&old.name);
    let of_shares = matches!(old.unit, ParameterUnit::Percent | ParameterUnit::Degrees);
    let (before, after) = old.value.zip(new.value)?;
    (!of_wholes && !of_shares && before > 0.0).then(|| 100.0 * (after / before - 1.0))
}

/// Median over all pieces of a figure's score.
fn score(natural: &Natural, name: &str) -> Option<f64> {
    let scores = natural.pieces.iter().filter_map(|piece| {
        let of_name = |f: &&FigureScore| f.figure.name == name;
        let figure = piece.judgement.figures.iter().find(of_name)?;
        Some(figure.score?.score)
    });
    Some(Summary::of(scores.collect())?.median)
}
