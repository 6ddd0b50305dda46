//! Histograms of colors that were copied.

use super::number::number;
use super::{Axis, Block, Marks, Part, Plot, Series};
use crate::stats::{ColorComparison, Histogram};

/// A plot for each channel, or one where all are grey: `names` are those of what was copied from and of what came out, and
/// shares are `of` these.
pub(super) fn blocks(colors: &[ColorComparison; 3], names: [&str; 2], of: &str) -> Vec<Block> {
    let is_grey = (colors[1..].iter())
        .all(|c| c.original == colors[0].original && c.completed == colors[0].completed);
    let shown = &colors[..if is_grey { 1 } else { 3 }];
    let plot = |color: &ColorComparison| {
        let name = if is_grey { "grey" } else { color.channel };
        Block::Plot(Plot {
            caption: format!(
                "Histogram of {name} (correlation {})",
                number(color.correlation)
            ),
            x: Axis::linear(&format!("{name}, 0 to 1")),
            y: Axis::linear(&format!("share of {of}")),
            series: vec![
                bars(names[0], Part::Original, &color.original),
                bars(names[1], Part::Completed, &color.completed),
            ],
        })
    };
    shown.iter().map(plot).collect()
}

fn bars(name: &str, part: Part, histogram: &Histogram) -> Series {
    let bins = histogram.shares.len();
    Series {
        name: name.to_owned(),
        part,
        marks: Marks::Bars,
        x: (0..bins)
            .map(|bin| (bin as f64 + 0.5) / bins as f64)
            .collect(),
        y: histogram.shares.clone(),
    }
}
