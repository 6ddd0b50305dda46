//! A scan to turn in three dimensions, with its channels as colours.

use std::io::{self, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nalgebra::{Point3, Vector3};
use serde::Serialize;

use super::markup::escaped;
use super::number::{count, number};
use super::thinned::{Thinned, thinned};
use crate::mesh::TriMesh;

/// Most vertices that a page shows of its scans: with all channels they take 7 MB, and a phone can turn them.
pub const MOST_SHOWN: usize = 100_000;

/// A scan in three dimensions, as it was before and after completion, and its channels.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    caption: String,
    /// Number of the scan's vertices, and of those that its faces use.
    of: [usize; 2],
    /// Around the middle of the bounding box.
    positions: Vec<Point3<f64>>,
    /// Whether each vertex is of the completed part.
    completed: Vec<bool>,
    /// Those of the original part first.
    faces: Vec<[u32; 3]>,
    original_faces: usize,
    channels: Vec<Channel>,
}

/// Values of all vertices that can be shown as colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// What the page's address calls it, as in `#channel=height`; lower case.
    pub key: &'static str,
    /// Its name on the button.
    pub label: String,
    /// What is to be seen, in a sentence.
    pub note: String,
    /// The values.
    pub values: Values,
}

/// Values of a channel, one a vertex.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// On a scale of colours, in the unit of the channel's note; NaN is grey.
    Scale(Vec<f64>),
    /// Red, green and blue.
    Colors(Vec<[u8; 3]>),
}

/// A view as the page's script reads it. Arrays are base64 of little-endian numbers.
#[derive(Debug, Serialize)]
pub(super) struct Shown<'a> {
    /// `f32`, relative to the middle.
    x: String,
    y: String,
    z: String,
    /// `u32`: first, second and third corner of each face.
    i: String,
    j: String,
    k: String,
    original_faces: usize,
    vertices: usize,
    /// Half the length of the longest side of the bounding box.
    reach: f64,
    eye: [f64; 3],
    up: [f64; 3],
    /// Whether it is much like a plane, whose relief shows in raking light only.
    is_flat: bool,
    channels: Vec<ShownChannel<'a>>,
}

#[derive(Debug, Serialize)]
struct ShownChannel<'a> {
    key: &'a str,
    note: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<Scale>,
    /// `u8`, three a vertex.
    #[serde(skip_serializing_if = "Option::is_none")]
    colors: Option<String>,
}

#[derive(Debug, Serialize)]
struct Scale {
    /// `f32`.
    values: String,
    low: f64,
    high: f64,
    /// The same two as text.
    ends: [String; 2],
}

impl View {
    /// A view of at most `most` vertices of a mesh: positions, `completed` and `channels` have one value a
    /// vertex. `None` if there is no face to show.
    #[must_use]
    pub fn new(
        caption: &str,
        mesh: &TriMesh,
        completed: &[bool],
        channels: Vec<Channel>,
        most: usize,
    ) -> Option<Self> {
        let Thinned {
            vertices,
            faces,
            original_faces,
        } = thinned(&mesh.positions, &mesh.triangles, completed, most);
        let first = vertices.first()?;
        let mut box_ = [mesh.positions[*first as usize].coords; 2];
        for v in &vertices {
            let p = &mesh.positions[*v as usize].coords;
            box_ = [box_[0].inf(p), box_[1].sup(p)];
        }
        let middle = Point3::from((box_[0] + box_[1]) * 0.5);
        let at = |v: &u32| (mesh.positions[*v as usize] - middle).into();
        let used = mesh.used_vertices().iter().filter(|used| **used).count();
        Some(Self {
            caption: caption.to_owned(),
            of: [mesh.positions.len(), used],
            positions: vertices.iter().map(at).collect(),
            completed: picked(completed, &vertices),
            original_faces,
            channels: (channels.into_iter())
                .map(|channel| channel.of(&vertices))
                .collect(),
            faces,
        })
    }

    /// Views that share what one page may show: each has its part of [`MOST_SHOWN`] vertices at most.
    #[must_use]
    pub fn sharing(views: Vec<Self>) -> Vec<Self> {
        let most = MOST_SHOWN / views.len().max(1);
        views.into_iter().map(|view| view.at_most(most)).collect()
    }

    /// The same view with fewer vertices, if it has more than `most`.
    fn at_most(self, most: usize) -> Self {
        if self.positions.len() <= most {
            return self;
        }
        let Thinned {
            vertices,
            faces,
            original_faces,
        } = thinned(&self.positions, &self.faces, &self.completed, most);
        Self {
            positions: picked(&self.positions, &vertices),
            completed: picked(&self.completed, &vertices),
            faces,
            original_faces,
            channels: (self.channels.into_iter())
                .map(|channel| channel.of(&vertices))
                .collect(),
            ..self
        }
    }

    /// How much of the scan is shown, in words.
    fn extract(&self) -> String {
        let [all, used] = self.of;
        let (vertices, faces) = (count(self.positions.len()), count(self.faces.len()));
        if self.positions.len() < used {
            format!(
                "Shown are {vertices} of {} vertices, evenly chosen, and {faces} faces between them; the figures on this page are of all.",
                count(all)
            )
        } else {
            format!("All {vertices} vertices and {faces} triangles are shown.")
        }
    }

    /// Whether there is a before that differs from the after.
    fn has_parts(&self) -> bool {
        (1..self.faces.len()).contains(&self.original_faces)
    }

    pub(super) fn write(&self, out: &mut impl Write, index: usize) -> io::Result<()> {
        let caption = escaped(&self.caption);
        writeln!(
            out,
            "<figure class=\"view\" data-view=\"{index}\"><figcaption>{caption}</figcaption>\n<div class=\"switches\">"
        )?;
        if self.has_parts() {
            let states = [("before", "Before"), ("after", "After")];
            write_buttons(out, "State of the scan", "state", &states)?;
        }
        let mut shown = vec![("shape", "Shape")];
        shown.extend(self.channels.iter().map(|c| (c.key, c.label.as_str())));
        if self.has_parts() {
            shown.push(("completed", "Completed part"));
        }
        write_buttons(out, "What is shown", "channel", &shown)?;
        writeln!(
            out,
            "</div>\n<div class=\"scene\" role=\"img\" aria-label=\"{caption}\"></div><canvas class=\"still\"></canvas>\n<div class=\"legend\" aria-live=\"polite\"></div>\n<p class=\"note\">Drag, or press the arrow keys, to turn; pinch or scroll to zoom. {}</p>\n</figure>",
            escaped(&self.extract())
        )
    }

    pub(super) fn shown(&self) -> Shown<'_> {
        let axis = |axis: usize| floats(self.positions.iter().map(|p| p[axis]));
        let corner = |c: usize| base64(self.faces.iter().flat_map(|face| face[c].to_le_bytes()));
        let high =
            (self.positions.iter()).fold(Vector3::zeros(), |high, p| high.sup(&p.coords.abs()));
        let reach = high.max();
        let radius = (self.positions.iter())
            .map(|p| p.coords.norm())
            .fold(0.0, f64::max);
        let (eye, up) = self.camera(radius / reach);
        Shown {
            x: axis(0),
            y: axis(1),
            z: axis(2),
            i: corner(0),
            j: corner(1),
            k: corner(2),
            original_faces: self.original_faces,
            vertices: self.positions.len(),
            reach,
            eye: eye.into(),
            up: up.into(),
            is_flat: self.is_flat(),
            channels: self.channels.iter().map(Channel::shown).collect(),
        }
    }

    /// Where to look from, in units of the longest side, and what is up. `size` is the radius over half
    /// of that.
    fn camera(&self, size: f64) -> (Vector3<f64>, Vector3<f64>) {
        /// A ball fills 85 % of the height of a picture that shows 22.5° to each side, as plotly does.
        const DISTANCE: f64 = 1.5;
        let (original, completed) = self.faces.split_at(self.original_faces);
        let [original, completed] = [original, completed].map(|faces| self.facing(faces));
        let front = facing_front(original, completed);
        let up = if front.z.abs() > 0.8 {
            Vector3::y()
        } else {
            Vector3::z()
        };
        // A little from above and from the side, where relief is seen better.
        let side = up.cross(&front).normalize();
        let above = front.cross(&side);
        let eye = (front + 0.25 * side + 0.35 * above).normalize();
        (eye * DISTANCE * (1.0 + 0.35 * (size - 1.0).max(0.0)), up)
    }

    /// Whether most of it looks to one side.
    fn is_flat(&self) -> bool {
        /// A quarter of a cylinder's wall has 0.9.
        const FLAT: f64 = 0.9;
        let (sum, area) = self.facing(&self.faces);
        sum.norm() > FLAT * area
    }

    /// Sum of the faces' normals by area, and of their areas.
    fn facing(&self, faces: &[[u32; 3]]) -> (Vector3<f64>, f64) {
        let mut sums = (Vector3::zeros(), 0.0);
        for face in faces {
            let [a, b, c] = face.map(|v| self.positions[v as usize]);
            let normal = (b - a).cross(&(c - a));
            sums.0 += normal;
            sums.1 += normal.norm();
        }
        sums
    }
}

/// The side that scans with one side only look to. For others the one that the completed part looks to; or if
/// the original looks the other way, one from which both are seen.
fn facing_front(original: (Vector3<f64>, f64), completed: (Vector3<f64>, f64)) -> Vector3<f64> {
    /// Faces whose normals add up to this share of their areas have one side: half a ball has 0.5.
    const ONE_SIDED: f64 = 0.4;
    let share = |(sum, area): (Vector3<f64>, f64)| if area > 0.0 { sum / area } else { sum };
    let whole = share((original.0 + completed.0, original.1 + completed.1));
    if whole.norm() > ONE_SIDED {
        return whole.normalize();
    }
    let [original, completed] = [original, completed].map(share);
    let toward = completed.try_normalize(1e-3).unwrap_or_else(Vector3::y);
    if original.norm() < 0.2 || original.normalize().dot(&toward) > -0.5 {
        return toward;
    }
    let side = toward.cross(&least_axis(&toward)).normalize();
    (side + 0.3 * toward).normalize()
}

/// The coordinate axis that a direction is farthest from.
fn least_axis(direction: &Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[direction.iamin()] = 1.0;
    axis
}

impl Channel {
    /// The values of some vertices.
    fn of(self, vertices: &[u32]) -> Self {
        Self {
            values: match self.values {
                Values::Scale(values) => Values::Scale(picked(&values, vertices)),
                Values::Colors(colors) => Values::Colors(picked(&colors, vertices)),
            },
            ..self
        }
    }

    fn shown(&self) -> ShownChannel<'_> {
        let (scale, colors) = match &self.values {
            Values::Scale(values) => (Some(Scale::of(values)), None),
            Values::Colors(colors) => (None, Some(base64(colors.iter().flatten().copied()))),
        };
        ShownChannel {
            key: self.key,
            note: &self.note,
            scale,
            colors,
        }
    }
}

impl Scale {
    /// A scale that few values exceed: single ones would take all of it.
    fn of(values: &[f64]) -> Self {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let hundredth = sorted.len() / 100;
        let low = sorted.get(hundredth).copied().unwrap_or(0.0);
        let high = sorted.iter().rev().nth(hundredth).copied().unwrap_or(1.0);
        let high = if high > low { high } else { low + 1.0 };
        Self {
            values: floats(values.iter().copied()),
            low,
            high,
            ends: [number(low), number(high)],
        }
    }
}

fn picked<T: Copy>(values: &[T], rows: &[u32]) -> Vec<T> {
    rows.iter().map(|row| values[*row as usize]).collect()
}

fn base64(bytes: impl Iterator<Item = u8>) -> String {
    STANDARD.encode(bytes.collect::<Vec<u8>>())
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "pictures need no more than single precision"
)]
fn floats(values: impl Iterator<Item = f64>) -> String {
    base64(values.flat_map(|value| (value as f32).to_le_bytes()))
}

fn write_buttons(
    out: &mut impl Write,
    label: &str,
    what: &str,
    buttons: &[(&str, &str)],
) -> io::Result<()> {
    writeln!(out, "<div role=\"group\" aria-label=\"{label}\">")?;
    for (key, text) in buttons {
        let (key, text) = (escaped(key), escaped(text));
        writeln!(
            out,
            "<button type=\"button\" data-{what}=\"{key}\" aria-pressed=\"false\">{text}</button>"
        )?;
    }
    writeln!(out, "</div>")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A view of a wall of `side` by `side` points with `channels` channels, its right half completed.
    fn wall(side: u32) -> View {
        let at = |v: u32| Point3::new(f64::from(v % side), f64::from(v / side), 0.0);
        let positions: Vec<_> = (0..side * side).map(at).collect();
        let completed: Vec<bool> = positions
            .iter()
            .map(|p| p.x >= f64::from(side / 2))
            .collect();
        let squares = (0..side * (side - 1)).filter(|v| v % side + 1 < side);
        let triangles =
            squares.flat_map(|v| [[v, v + 1, v + side], [v + 1, v + side + 1, v + side]]);
        let channel = |key, values| Channel {
            key,
            label: key.to_owned(),
            note: String::new(),
            values,
        };
        let heights: Vec<f64> = positions.iter().map(|p| p.x).collect();
        let channels = vec![
            channel("color", Values::Colors(vec![[90, 60, 30]; heights.len()])),
            channel("height", Values::Scale(heights.clone())),
            channel("cost", Values::Scale(heights.clone())),
            channel("source", Values::Colors(vec![[1, 2, 3]; heights.len()])),
        ];
        let mesh = TriMesh {
            triangles: triangles.collect(),
            positions,
        };
        View::new("wall", &mesh, &completed, channels, MOST_SHOWN).expect("it has faces")
    }

    #[test]
    fn views_of_one_page_share_what_it_shows() {
        let alone = View::sharing(vec![wall(400)]);
        assert!((MOST_SHOWN / 2..=MOST_SHOWN).contains(&alone[0].positions.len()));
        let both = View::sharing(vec![wall(400), wall(100)]);
        let [large, small] = &both[..] else {
            panic!("two stay two");
        };
        let shown = large.positions.len();
        assert!(
            (MOST_SHOWN / 4..=MOST_SHOWN / 2).contains(&shown),
            "{shown}"
        );
        assert!(
            large.extract().starts_with(&format!(
                "Shown are {} of {} vertices",
                count(shown),
                count(160_000)
            )),
            "{}",
            large.extract()
        );
        assert_eq!(large.completed.len(), shown);
        assert!(large.has_parts());
        // Values stay with their vertices.
        let Values::Scale(heights) = &large.channels[1].values else {
            panic!("heights are on a scale");
        };
        let shift = heights[0] - large.positions[0].x;
        assert!(heights.len() == shown);
        for (height, p) in heights.iter().zip(&large.positions) {
            assert!((height - p.x - shift).abs() < 1e-9);
        }
        assert_eq!(*small, wall(100));
        assert!(small.extract().starts_with("All "), "{}", small.extract());
    }

    #[test]
    #[cfg(feature = "report")]
    fn a_page_of_two_large_scans_stays_below_15_megabytes() {
        use crate::report::{Block, Page, Section};
        let views = View::sharing(vec![wall(500), wall(500)]);
        let page = Page {
            sections: vec![Section {
                heading: String::new(),
                blocks: views.into_iter().map(Block::View).collect(),
            }],
            ..Page::default()
        };
        let mut out = Vec::new();
        page.write(&mut out).expect("memory takes it");
        assert!(out.len() < 15_000_000, "{}", out.len());
    }
}
