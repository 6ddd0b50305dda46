//! Plots of lines and bars.

use serde::Serialize;

/// A plot of one or more series over common axes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plot {
    /// What it shows, in a few words.
    pub caption: String,
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// What is drawn, in this order.
    pub series: Vec<Series>,
}

/// An axis.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Whether its scale is logarithmic; values of 0 or less are left out then.
    pub log: bool,
}

/// Points of one kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Whose values it has, which gives its colour.
    pub part: Part,
    /// How it is drawn.
    pub marks: Marks,
    /// Places to the right: of points, or of the middles of bars.
    pub x: Vec<f64>,
    /// As many heights; NaN for a gap.
    pub y: Vec<f64>,
}

/// Whose values a series has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// What the scanner saw.
    Original,
    /// What completion added.
    Completed,
    /// Neither, or both: limits, for example.
    Neither,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Marks {
    /// A line through the points.
    Line,
    /// A broken line through the points.
    Dashes,
    /// A line through the points, with a mark at each.
    Points,
    /// Bars next to each other, as in a histogram; those of several series are drawn over each other.
    Bars,
}

impl Axis {
    /// An axis with a linear scale.
    #[must_use]
    pub fn linear(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            log: false,
        }
    }

    /// An axis with a logarithmic scale.
    #[must_use]
    pub fn logarithmic(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            log: true,
        }
    }
}
