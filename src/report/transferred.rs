//! The page of the command `transfer`.

use nalgebra::{Point3, Vector3};

use super::number::{count, counted, number};
use super::scanned::byte;
use super::settings::plain;
use super::view::{Channel, MOST_SHOWN, Values, View};
use super::{Block, Column, Page, Section, Table, histograms};
use crate::mesh::TriMesh;
use crate::stats::ColorComparison;
use crate::transfer::{LevelReport, TransferParams, Transferred};

/// What the command `transfer` was given, and what came out.
#[derive(Debug, Clone, Copy)]
pub struct TransferredPage<'a> {
    /// The source's file, as the user knows it.
    pub source: &'a str,
    /// The target's file; the source's if it was spread over itself.
    pub target: &'a str,
    /// What was done to the meshes before; a sentence each, without the end mark.
    pub prepared: &'a [String],
    /// What was asked for.
    pub params: &'a TransferParams,
    /// The mesh that was copied from, of the vertices that sources are numbers of.
    pub mesh: &'a TriMesh,
    /// Its colors (#V), if these were copied.
    pub mesh_colors: Option<&'a [[f64; 3]]>,
    /// What came out.
    pub done: &'a Transferred,
    /// Where its vertices (#V) are at last.
    pub positions: &'a [Point3<f64>],
    /// What heights were multiplied with to move vertices, if they were moved.
    pub scale: Option<f64>,
    /// Red, green and blue of what was copied from and of what came out, if there are colors.
    pub colors: Option<&'a [ColorComparison; 3]>,
}

/// The page of a transfer.
///
/// It tells no times: the same meshes and parameters give the same bytes.
#[must_use]
pub fn transferred(page: &TransferredPage) -> Page {
    let mut sections = Vec::new();
    let views = views(page);
    if !views.is_empty() {
        sections.push(Section {
            heading: "The meshes".to_owned(),
            blocks: (View::sharing(views).into_iter())
                .map(Block::View)
                .collect(),
        });
    }
    sections.extend(page.colors.map(|colors| Section {
        heading: "Against the source".to_owned(),
        blocks: histograms::blocks(colors, ["source", "result"], "vertices"),
    }));
    sections.push(work(page));
    sections.push(parameters(page));
    Page {
        title: format!("{}, with what was on {}", page.target, page.source),
        lead: lead(page),
        sections,
    }
}

/// What came out, and what that amounts to.
fn lead(page: &TransferredPage) -> String {
    let done = page.done;
    let what = match (&done.colors, &done.heights) {
        (Some(_), Some(_)) => "colours and relief of",
        (None, Some(_)) => "relief of",
        _ => "colours of",
    };
    let onto = if page.source == page.target {
        "spread over it".to_owned()
    } else {
        format!("on {}", page.target)
    };
    let mut text = format!(
        "The {what} {} {} {onto}, at {}",
        page.source,
        if what == "relief of" { "is" } else { "are" },
        counted(done.finer.mesh.positions.len(), "vertex", "vertices"),
    );
    if let Some(finest) = done.report.levels.first() {
        text.push_str(&format!(
            "; along {} % of its edges the source continues",
            number(100.0 * finest.coherent_edges)
        ));
    }
    text.push('.');
    if let Some(colors) = page.colors {
        let least = (colors.iter().map(|c| c.correlation)).fold(f64::INFINITY, f64::min);
        text.push_str(&format!(
            " Colours are as frequent as on the source to a correlation of {}.",
            number(least)
        ));
    }
    text
}

/// The result, and the source.
fn views(page: &TransferredPage) -> Vec<View> {
    let done = page.done;
    let after = TriMesh {
        positions: page.positions.to_vec(),
        triangles: done.finer.mesh.triangles.clone(),
    };
    let places = places(page.mesh);
    let shown = |caption: String, mesh: &TriMesh, channels| {
        let none_is_new = vec![false; mesh.positions.len()];
        View::new(&caption, mesh, &none_is_new, channels, MOST_SHOWN)
    };
    let result = shown(
        format!("{}, what came out", page.target),
        &after,
        of_result(done, &places),
    );
    let source = shown(
        format!("{}, the source", page.source),
        page.mesh,
        of_source(page, &places),
    );
    result.into_iter().chain(source).collect()
}

/// Each vertex of a mesh in the color of its place.
fn places(mesh: &TriMesh) -> Vec<[u8; 3]> {
    let (mut low, mut high) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
    for p in &mesh.positions {
        low = low.inf(&p.coords);
        high = high.sup(&p.coords);
    }
    let (middle, reach) = ((low + high) * 0.5, (high - low).max() * 0.5);
    let reach = reach.max(f64::MIN_POSITIVE);
    let color = |p: &Point3<f64>| {
        let place = (p.coords - middle) / reach;
        [place.x, place.y, place.z].map(|x| byte(0.5 + 0.45 * x))
    };
    mesh.positions.iter().map(color).collect()
}

fn channel(key: &'static str, label: &str, note: &str, values: Values) -> Channel {
    Channel {
        key,
        label: label.to_owned(),
        note: note.to_owned(),
        values,
    }
}

fn colors(note: &str, colors: &[[f64; 3]]) -> Channel {
    let bytes = colors.iter().map(|color| color.map(byte)).collect();
    channel("color", "Colour", note, Values::Colors(bytes))
}

fn of_result(done: &Transferred, places: &[[u8; 3]]) -> Vec<Channel> {
    let mut channels = Vec::new();
    channels.extend((done.colors.as_ref()).map(|c| colors("The colours that were copied.", c)));
    channels.extend(done.heights.as_ref().map(|heights| {
        let note = "Height of the copied relief over the target, in its unit.";
        channel("height", "Height", note, Values::Scale(heights.clone()))
    }));
    let grey = [0x9a, 0xa0, 0xa8];
    let place = |source: &u32| places.get(*source as usize).copied().unwrap_or(grey);
    channels.push(channel(
        "source",
        "Source",
        "Each vertex has the colour of the place of the source that it was matched with, as the view of the source shows them.",
        Values::Colors(done.sources.iter().map(place).collect()),
    ));
    let costs = done.costs.iter().map(|cost| f64::from(*cost)).collect();
    channels.push(channel(
        "cost",
        "Match cost",
        "How unlike the surroundings of each vertex and of its source are: 0 fits exactly, 1 is what has nothing in common.",
        Values::Scale(costs),
    ));
    let degrees = (done.rotations.iter()).map(|angle| f64::from(*angle).to_degrees());
    channels.push(channel(
        "rotation",
        "Rotation",
        "By how many degrees what is upright on the target is turned on the source, counterclockwise.",
        Values::Scale(degrees.collect()),
    ));
    channels
}

fn of_source(page: &TransferredPage, places: &[[u8; 3]]) -> Vec<Channel> {
    let of_colors = page
        .mesh_colors
        .map(|c| colors("The colours of the source.", c));
    let own = channel(
        "source",
        "Source",
        "Each vertex has the colour of its own place.",
        Values::Colors(places.to_vec()),
    );
    of_colors.into_iter().chain([own]).collect()
}

/// What was done before, and on each level.
fn work(page: &TransferredPage) -> Section {
    let before = (page.prepared.iter()).map(|sentence| Block::Text(format!("Before: {sentence}.")));
    let mut blocks: Vec<Block> = before.collect();
    blocks.push(Block::Text(
        "Level by level, the coarsest first, each vertex of the target is matched with the place of the source whose shape and surroundings are most alike; then it takes what the matches around it say.".to_owned(),
    ));
    blocks.push(Block::Table(levels(&page.done.report.levels)));
    if let Some(audit) = page.done.report.levels.first().and_then(|l| l.audit) {
        blocks.push(Block::Text(format!(
            "{} cost {} on average; the best that there are cost {}.",
            counted(audit.vertices, "match", "matches"),
            number(audit.mean_cost),
            number(audit.least_cost)
        )));
    }
    if let (Some(heights), Some(scale)) = (&page.done.heights, page.scale) {
        let square: f64 = heights.iter().map(|h| h * h).sum();
        blocks.push(Block::Text(format!(
            "The relief\u{2019}s root mean square is {}; vertices are moved along their normals by {} of it.",
            number((square / heights.len().max(1) as f64).sqrt()),
            number(scale)
        )));
    }
    Section {
        heading: "What was done".to_owned(),
        blocks,
    }
}

fn levels(levels: &[LevelReport]) -> Table {
    let row = |(index, level): (usize, &LevelReport)| {
        vec![
            (index + 1).to_string(),
            count(level.vertices),
            count(level.source_vertices),
            number(100.0 * f64::from(level.value_weight)),
            number(level.mean_cost),
            number(100.0 * level.coherent_edges),
        ]
    };
    Table {
        caption: "Levels, the finest first: colours or relief count so much in the comparison, shape the rest; edges are coherent where the source continues along them".to_owned(),
        columns: vec![
            Column::words("level"),
            Column::numbers("vertices"),
            Column::numbers("source vertices"),
            Column::numbers("weight, %"),
            Column::numbers("mean cost"),
            Column::numbers("coherent edges, %"),
        ],
        rows: levels.iter().enumerate().map(row).collect(),
    }
}

fn parameters(page: &TransferredPage) -> Section {
    let params = page.params;
    let up = |of: usize| {
        let direction = params.up[of].map(|up| {
            let parts: Vec<String> = up.iter().map(|x| number(*x)).collect();
            parts.join(", ")
        });
        direction.unwrap_or_else(|| "none".to_owned())
    };
    let vertices = match params.vertices {
        Some(asked) => count(asked),
        None => "as many as the target or the source has".to_owned(),
    };
    let rows = [
        ("vertices", vertices),
        ("scale", number(params.scale)),
        ("shape", plain(&params.shape)),
        ("up", up(1)),
        ("source-up", up(0)),
        ("shape-weight", number(params.shape_weight)),
        ("coherence", number(params.coherence)),
        ("overuse", number(params.overuse)),
        ("rotations", plain(&params.rotations)),
        ("rounds", params.rounds.to_string()),
        ("final", plain(&params.last)),
        (
            "displace",
            page.scale.map_or_else(|| "no".to_owned(), number),
        ),
        ("seed", params.seed.to_string()),
    ];
    Section {
        heading: "Parameters".to_owned(),
        blocks: vec![Block::Table(Table {
            caption: "Parameters".to_owned(),
            columns: vec![Column::words("parameter"), Column::words("value")],
            rows: (rows.into_iter())
                .map(|(name, value)| vec![name.to_owned(), value])
                .collect(),
        })],
    }
}
