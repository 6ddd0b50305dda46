//! A scan's channels as views show them.

use nalgebra::{Point3, Vector3};

use super::view::{Channel, MOST_SHOWN, Values, View};
use crate::completion::{COMPLETED, COST, HEIGHT, SOURCE};
use crate::scan::Scan;

impl View {
    /// A view of a scan: the part that `complete` added marked by the vertex property `completed`; colours;
    /// `height`, `cost` and `source`, as far as it has them; and `more` channels, of one value a vertex. `None` if
    /// it has no faces.
    #[must_use]
    pub fn of_scan(caption: &str, scan: &Scan, more: Vec<Channel>) -> Option<Self> {
        let mesh = scan.mesh();
        let completed: Vec<bool> = match values(scan, COMPLETED) {
            Some(marks) => marks.iter().map(|mark| *mark > 0.5).collect(),
            None => vec![false; mesh.positions.len()],
        };
        let mut channels = channels(scan, &mesh.positions, &completed);
        channels.extend(more);
        Self::new(caption, &mesh, &completed, channels, MOST_SHOWN)
    }
}

impl Channel {
    /// Two parts (#V) of a scan by their names: the first blue, the second orange, grey what is of neither.
    #[must_use]
    pub fn of_parts(parts: [&[bool]; 2], names: [&str; 2]) -> Self {
        let [first, second] = parts;
        let color = |(first, second): (&bool, &bool)| match (first, second) {
            (true, _) => [0x4f, 0x8f, 0xdb],
            (_, true) => [0xe8, 0x86, 0x2a],
            _ => [0x9a, 0xa0, 0xa8],
        };
        Self {
            key: "parts",
            label: "Parts".to_owned(),
            note: format!("Blue: {}. Orange: {}.", names[0], names[1]),
            values: Values::Colors(first.iter().zip(second).map(color).collect()),
        }
    }
}

fn channels(scan: &Scan, positions: &[Point3<f64>], completed: &[bool]) -> Vec<Channel> {
    let mut channels = Vec::new();
    if let Some(colors) = scan.colors() {
        channels.push(Channel {
            key: "color",
            label: "Colour".to_owned(),
            note: "The colours of the scan.".to_owned(),
            values: Values::Colors(colors.iter().map(|c| c.map(byte)).collect()),
        });
    }
    let has_values = |values: &Vec<f64>| values.iter().any(|value| value.is_finite());
    if let Some(heights) = values(scan, HEIGHT).filter(has_values) {
        channels.push(Channel {
            key: "height",
            label: "Height".to_owned(),
            note:
                "Height over the base surface, in the scan\u{2019}s unit; grey where there is none."
                    .to_owned(),
            values: Values::Scale(heights),
        });
    }
    if let Some(costs) = values(scan, COST).filter(has_values) {
        channels.push(Channel {
            key: "cost",
            label: "Match cost".to_owned(),
            note: "What the match of each completed vertex cost: 0 fits exactly, 1 is the worst possible; grey for what the scanner saw."
                .to_owned(),
            values: Values::Scale(costs),
        });
    }
    if let Some(sources) = values(scan, SOURCE)
        && completed.contains(&true)
    {
        channels.push(Channel {
            key: "source",
            label: "Source".to_owned(),
            note: "Each completed vertex has the colour of the place that it was copied from; what the scanner saw is pale in the colour of its own place."
                .to_owned(),
            values: Values::Colors(source_colors(positions, completed, &sources)),
        });
    }
    channels
}

/// Completed vertices in the colour of their sources' places, original ones pale in that of their own.
fn source_colors(positions: &[Point3<f64>], completed: &[bool], sources: &[f64]) -> Vec<[u8; 3]> {
    let (mut low, mut high) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
    for (p, _) in (positions.iter().zip(completed)).filter(|(_, completed)| !**completed) {
        low = low.inf(&p.coords);
        high = high.sup(&p.coords);
    }
    let (middle, reach) = ((low + high) * 0.5, (high - low).max() * 0.5);
    let place = |v: usize| {
        let place = (positions[v].coords - middle) / reach;
        [place.x, place.y, place.z].map(|x| 0.5 + 0.45 * x)
    };
    let pale = |color: [f64; 3]| color.map(|c| 0.3 * c + 0.7 * 0.87);
    let color = |v: usize| {
        let color = match completed[v] {
            true => row(sources[v], positions.len()).map_or([0.5; 3], place),
            false => pale(place(v)),
        };
        color.map(byte)
    };
    (0..positions.len()).map(color).collect()
}

/// The row that a number names, if there is one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked before"
)]
fn row(number: f64, rows: usize) -> Option<usize> {
    (number >= 0.0 && number < rows as f64).then_some(number as usize)
}

/// The values of a vertex property of numbers.
fn values(scan: &Scan, name: &str) -> Option<Vec<f64>> {
    let column = scan.vertices.column(name)?;
    (0..scan.vertices.rows)
        .map(|row| column.get_f64(row))
        .collect()
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturating"
)]
pub(super) fn byte(share: f64) -> u8 {
    (255.0 * share).round() as u8
}
