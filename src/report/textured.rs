//! The page of the command `texture`.

use nalgebra::Vector3;

use super::number::{count, counted, number};
use super::settings::plain;
use super::view::{Channel, MOST_SHOWN, Values, View};
use super::{Block, Column, Page, Section, Table, histograms};
use crate::mesh::TriMesh;
use crate::stats::ColorComparison;
use crate::texture::{Density, LevelReport, Method, Orientation, Sample, TextureParams, Textured};

/// What the command `texture` was given, and what came out.
#[derive(Debug, Clone, Copy)]
pub struct TexturedPage<'a> {
    /// The mesh's file, as the user knows it.
    pub input: &'a str,
    /// The sample's file.
    pub exemplar: &'a str,
    /// What was done to the mesh and the sample before; a sentence each, without the end mark.
    pub prepared: &'a [String],
    /// What was asked for.
    pub params: &'a TextureParams,
    /// The mesh as it was.
    pub mesh: &'a TriMesh,
    /// The sample.
    pub sample: &'a Sample,
    /// What came out.
    pub textured: &'a Textured,
    /// What heights were multiplied with to move vertices, if they were moved.
    pub scale: Option<f64>,
    /// Red, green and blue of the sample and of the textured mesh, if there are colors.
    pub colors: Option<&'a [ColorComparison; 3]>,
}

/// The page of a texture.
///
/// It tells no times: the same mesh, sample and parameters give the same bytes.
#[must_use]
pub fn textured(done: &TexturedPage) -> Page {
    let mut sections = Vec::new();
    let views = views(done);
    if !views.is_empty() {
        sections.push(Section {
            heading: "The mesh".to_owned(),
            blocks: (View::sharing(views).into_iter())
                .map(Block::View)
                .collect(),
        });
    }
    sections.extend(against_sample(done));
    sections.push(work(done));
    sections.push(directions(done));
    sections.push(parameters(done));
    Page {
        title: format!("{}, textured", done.input),
        lead: lead(done),
        sections,
    }
}

/// What came out, and what that amounts to.
fn lead(done: &TexturedPage) -> String {
    let textured = done.textured;
    let what = match (&textured.colors, &textured.heights) {
        (Some(_), Some(_)) => "colours and relief",
        (None, Some(_)) => "relief",
        _ => "colours",
    };
    let mut text = format!(
        "The {what} of {} are all over {}, on {}",
        done.exemplar,
        done.input,
        counted(textured.mesh.positions.len(), "vertex", "vertices"),
    );
    if what == "relief" {
        text = text.replacen(" are ", " is ", 1);
    }
    if let Some(level) = textured.report.levels.first() {
        text.push_str(&format!(
            "; along {} % of its edges the sample continues",
            number(100.0 * level.coherent_edges)
        ));
    }
    text.push('.');
    if let Some(colors) = done.colors {
        let least = (colors.iter().map(|c| c.correlation)).fold(f64::INFINITY, f64::min);
        text.push_str(&format!(
            " Colours are as frequent as on the sample to a correlation of {}.",
            number(least)
        ));
    }
    text
}

/// After, and before.
fn views(done: &TexturedPage) -> Vec<View> {
    let after = TriMesh {
        positions: done.textured.displaced(done.scale.unwrap_or(0.0)).positions,
        triangles: done.textured.mesh.triangles.clone(),
    };
    let shown = |caption: String, mesh: &TriMesh, channels| {
        let none_is_new = vec![false; mesh.positions.len()];
        View::new(&caption, mesh, &none_is_new, channels, MOST_SHOWN)
    };
    let after = shown(format!("{}, textured", done.input), &after, channels(done));
    let before = shown(format!("{}, as it was", done.input), done.mesh, Vec::new());
    after.into_iter().chain(before).collect()
}

fn channels(done: &TexturedPage) -> Vec<Channel> {
    let textured = done.textured;
    let channel = |key, label: &str, note: &str, values| Channel {
        key,
        label: label.to_owned(),
        note: note.to_owned(),
        values,
    };
    let bytes = |color: &[f64; 3]| color.map(super::scanned::byte);
    let colors = textured.colors.as_ref().map(|colors| {
        let values = Values::Colors(colors.iter().map(bytes).collect());
        channel("color", "Colour", "The colours of the texture.", values)
    });
    let heights = textured.heights.as_ref().map(|heights| {
        let note = "Height of the texture over the mesh before it was moved; in the sample\u{2019}s unit if that is a scan.";
        channel("height", "Height", note, Values::Scale(heights.clone()))
    });
    let costs = textured.costs.iter().map(|cost| f64::from(*cost)).collect();
    let cost = channel(
        "cost",
        "Match cost",
        "Mean squared difference between the neighborhood of each vertex and that of the place that it was copied from; grey where nothing was compared.",
        Values::Scale(costs),
    );
    let places = done.sample.places();
    let place = |source: &u32| {
        places
            .get(*source as usize)
            .map_or([0.5; 3], |p| p.map(|x| 0.5 + 0.45 * x))
    };
    let source = channel(
        "source",
        "Source",
        "Each vertex has the colour of the place that it was copied from: red rises to the right of the sample, green to its top; where the colour changes slowly, the sample continues.",
        Values::Colors(textured.sources.iter().map(|s| bytes(&place(s))).collect()),
    );
    let directions = channel(
        "direction",
        "Direction",
        "Where the texture\u{2019}s first axis points: red, green and blue for x, y and z.",
        Values::Colors(textured.directions.iter().map(direction_color).collect()),
    );
    (colors.into_iter().chain(heights))
        .chain([cost, source, directions])
        .collect()
}

fn direction_color(direction: &Vector3<f64>) -> [u8; 3] {
    [direction.x, direction.y, direction.z].map(|x| super::scanned::byte(0.5 + 0.5 * x))
}

/// Histograms of the sample and of the mesh.
fn against_sample(done: &TexturedPage) -> Option<Section> {
    Some(Section {
        heading: "Against the sample".to_owned(),
        blocks: histograms::blocks(
            done.colors?,
            ["sample", "textured mesh"],
            "pixels or vertices",
        ),
    })
}

/// What was done before, and on each level.
fn work(done: &TexturedPage) -> Section {
    let before = (done.prepared.iter()).map(|sentence| Block::Text(format!("Before: {sentence}.")));
    let mut blocks: Vec<Block> = before.collect();
    blocks.push(Block::Text(
        "Neighborhoods of the mesh are compared with those of the sample level by level, the coarsest first; each vertex copies the place of the sample whose neighborhood is most alike.".to_owned(),
    ));
    blocks.push(Block::Table(levels(&done.textured.report.levels)));
    if let Some(heights) = &done.textured.heights {
        blocks.push(Block::Text(relief(heights, done.scale)));
    }
    Section {
        heading: "What was done".to_owned(),
        blocks,
    }
}

fn levels(levels: &[LevelReport]) -> Table {
    let row = |(index, level): (usize, &LevelReport)| {
        let side = |texels: usize| format!("{texels} by {texels}");
        vec![
            (index + 1).to_string(),
            count(level.vertices),
            number(level.texel),
            number(100.0 * level.edge_variation),
            count(level.sites),
            side(level.window),
            match level.coarse_window {
                0 => "none".to_owned(),
                texels => side(texels),
            },
            number(level.mean_cost),
            number(100.0 * level.coherent_edges),
        ]
    };
    Table {
        caption: "Levels, the finest first: length of a texel in the scan\u{2019}s unit, places to copy from, sides of neighborhoods in texels; edges are coherent where the sample continues along them".to_owned(),
        columns: vec![
            Column::words("level"),
            Column::numbers("vertices"),
            Column::numbers("texel"),
            Column::numbers("edges vary by, %"),
            Column::numbers("places"),
            Column::words("neighborhood"),
            Column::words("coarser level"),
            Column::numbers("mean cost"),
            Column::numbers("coherent edges, %"),
        ],
        rows: levels.iter().enumerate().map(row).collect(),
    }
}

/// How high the relief is, and whether it moves vertices.
fn relief(heights: &[f64], scale: Option<f64>) -> String {
    let all = heights.len().max(1) as f64;
    let mean = heights.iter().sum::<f64>() / all;
    let variance = heights.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / all;
    let moved = match scale {
        Some(scale) => format!(
            "vertices are moved along their normals by {} of it",
            number(scale)
        ),
        None => "it moves no vertices".to_owned(),
    };
    format!(
        "The relief\u{2019}s root mean square about its mean is {}; {moved}.",
        number(variance.sqrt())
    )
}

fn directions(done: &TexturedPage) -> Section {
    let found = &done.textured.report.orientation;
    let turned = number(100.0 * found.error);
    let mut text = match &done.params.orientation {
        Orientation::Random => {
            "The texture\u{2019}s first axis points anywhere, at each vertex anew".to_owned()
        }
        _ => format!(
            "The directions of the texture\u{2019}s first axis were relaxed in {}",
            counted(found.rounds, "round", "rounds")
        ),
    };
    text.push_str(&format!(
        "; neighbors disagree by {turned} % (mean of sin\u{b2} of half the angle between them, times the symmetry)."
    ));
    if !matches!(done.params.orientation, Orientation::Random) {
        let turns: f64 = found.singularities.iter().map(|s| s.turns).sum();
        text.push_str(&match found.singularities.len() {
            0 => " They turn around no point.".to_owned(),
            points => format!(
                " They turn around {}, by {} in all: on a closed surface as many as its Euler characteristic.",
                counted(points, "point", "points"),
                match number(turns) {
                    one if (turns.abs() - 1.0).abs() < 1e-9 => format!("{one} turn"),
                    turns => format!("{turns} turns"),
                }
            ),
        });
    }
    Section {
        heading: "Directions".to_owned(),
        blocks: vec![Block::Text(text)],
    }
}

/// Parameters, and why they are what they are.
fn parameters(done: &TexturedPage) -> Section {
    let (params, report) = (done.params, &done.textured.report);
    let given = || "given".to_owned();
    let vertices = match params.density {
        Density::Vertices(_) => given(),
        Density::Texel(texel) => format!("texels of {} are given", number(texel)),
        Density::Auto if done.sample.is_surface() => {
            "texels are as large as the sample\u{2019}s own".to_owned()
        }
        Density::Auto => "as many as the mesh has, and at least 24\u{202f}576".to_owned(),
    };
    let levels = match (params.levels, params.method) {
        (Some(asked), _) if asked == report.levels.len() => given(),
        (Some(asked), _) => format!("{asked} are given, and no more fit into sample and mesh"),
        (None, Method::Coherent) => {
            "as many as leave the sample 8 texels wide, and fit into it and the mesh".to_owned()
        }
        (None, Method::WeiLevoy) => "4 as in the paper, or as many as fit".to_owned(),
    };
    let orientation = match &params.orientation {
        Orientation::Given(list) => format!("from {}", counted(list.len(), "point", "points")),
        other => plain(other),
    };
    let others = [
        ("orientation", orientation),
        ("symmetry", params.symmetry.to_string()),
        ("method", plain(&params.method)),
        (
            "displace",
            done.scale.map_or_else(|| "no".to_owned(), number),
        ),
        ("seed", params.seed.to_string()),
    ];
    let row = |(name, value): (&str, String)| vec![name.to_owned(), value];
    let mut rows: Vec<_> = others.into_iter().map(row).collect();
    if params.method == Method::WeiLevoy {
        rows.insert(3, row(("search", plain(&params.search))));
    }
    let whole = |name: &str, value: usize, why: String| vec![name.to_owned(), count(value), why];
    Section {
        heading: "Parameters".to_owned(),
        blocks: vec![
            Block::Table(Table {
                caption: "Parameters that follow from mesh and sample unless they are given"
                    .to_owned(),
                columns: vec![
                    Column::words("parameter"),
                    Column::numbers("value"),
                    Column::words("why"),
                ],
                rows: vec![
                    whole("vertices", done.textured.mesh.positions.len(), vertices),
                    whole("levels", report.levels.len(), levels),
                ],
            }),
            Block::Table(Table {
                caption: "All others".to_owned(),
                columns: vec![Column::words("parameter"), Column::words("value")],
                rows,
            }),
        ],
    }
}
