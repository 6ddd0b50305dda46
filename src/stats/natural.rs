//! How far two parts are apart, in units of what pieces of the first differ by themselves.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::likeness::{Calibration, Discs, Field, FieldInput, Figure, Judgement, Scores};
use crate::mesh::{Adjacency, spatial_order};
use crate::rng::{Rng, Stage};

use super::{Measured, Progress, StatsError};

/// A piece takes at most this share of the original's area: what it is compared with must be more than
/// itself.
const LARGEST_SHARE: f64 = 0.125;
/// … or a half, a quarter, … of it where holes leave no room for such pieces, so often at most.
const HALVINGS: i32 = 5;
/// Smaller pieces than this share of the largest allowed are looked at together.
const SMALL_SHARE: f64 = 1.0 / 16.0;
/// Pieces that a larger part is cut into, at most.
const DISCS: usize = 6;
/// Pieces that are judged, at most: the largest ones.
const MOST_PIECES: usize = 12;
/// Fewer vertices say nothing.
const LEAST_VERTICES: usize = 30;
/// With fewer true pieces a 95 % quantile means nothing.
const LEAST_TRUE_PIECES: usize = 20;

/// How natural variation is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NaturalParams {
    /// Number of true pieces that figures are calibrated with, from 60 to 10 000. Default 128.
    pub pieces: usize,
    /// Seed of their places. Default 0.
    pub seed: u32,
}

impl Default for NaturalParams {
    fn default() -> Self {
        Self {
            pieces: 128,
            seed: 0,
        }
    }
}

impl NaturalParams {
    /// Whether every parameter is in its range.
    ///
    /// # Errors
    /// [`StatsError::Pieces`] if not.
    pub fn check(&self) -> Result<(), StatsError> {
        if (60..=10_000).contains(&self.pieces) {
            Ok(())
        } else {
            Err(StatsError::Pieces(self.pieces))
        }
    }
}

/// Pieces of the completed part, judged by what pieces of the original differ by themselves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Natural {
    /// Number of true pieces of each size that figures were calibrated with.
    pub calibration_pieces: usize,
    /// Share of the completed part's area that they stand for: a part that is cut into pieces is all looked
    /// at, what is too small to be judged is not.
    pub share: f64,
    /// The pieces that were judged, the largest first.
    pub pieces: Vec<JudgedPiece>,
    /// How much heights differ by distance.
    pub variogram: Variogram,
    /// All of them together: each measure, and all measures.
    #[serde(flatten)]
    pub scores: Scores,
}

/// Half the mean squared difference of two heights, one of the part and one of either part, by their distance:
/// in a hole that is smaller than the distance the other one lies around it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variogram {
    /// In the scan's unit.
    pub distances: Vec<f64>,
    /// Of the original part, in square units.
    pub original: Vec<f64>,
    /// Of the completed part, in square units.
    pub completed: Vec<f64>,
}

/// A piece of the completed part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedPiece {
    /// Number of its vertices.
    pub vertices: usize,
    /// Area of the base surface under it, in square units.
    pub area: f64,
    /// Its figures and their scores.
    pub judgement: Judgement,
}

/// A piece to judge, and the larger one that it was cut out of: seams are those of the latter.
struct Piece {
    vertices: Vec<u32>,
    area: f64,
    cut_out_of: Option<usize>,
    /// Area that it stands for.
    represents: f64,
}

/// Figures of components that are looked at in pieces, by their number.
type Wholes = BTreeMap<usize, Vec<Figure>>;

/// Judges the second part (#V) of a surface by the first.
///
/// Connected pieces of the second part that are larger than an eighth of the first (or than what its holes leave
/// room for) are looked at in round pieces of that size, so that they are compared with pieces of the first of
/// their own size.
///
/// # Errors
/// [`StatsError::NoRoom`] if a part is too small for it, [`StatsError::Pieces`] if a parameter is out of its
/// range.
pub fn natural_variation(
    measured: &Measured,
    first: &[bool],
    second: &[bool],
    params: &NaturalParams,
    progress: &mut dyn FnMut(Progress),
) -> Result<Natural, StatsError> {
    params.check()?;
    let mut at = |stage, done, total| progress(Progress { stage, done, total });
    at("reading neighborhoods", 0, 1);
    let (known, other) = (measured.marks(first), measured.marks(second));
    let field = field_of(measured, &known, &other).ok_or(StatsError::NoRoom)?;
    let limit = largest_piece(&field, &known, params.seed).ok_or(StatsError::NoRoom)?;
    let components = components(measured, &other);
    let pieces = pieces(&field, &components, limit, params.seed);
    let largest = pieces.first().ok_or(StatsError::NoRoom)?.area;
    let mut classes: Vec<u32> = pieces.iter().map(|p| size_class(p.area, largest)).collect();
    classes.sort_unstable();
    classes.dedup();
    let wholes: Wholes = (pieces.iter())
        .filter_map(|piece| piece.cut_out_of)
        .collect::<BTreeSet<usize>>()
        .into_iter()
        .map(|whole| (whole, field.figures(&components[whole], &known)))
        .collect();
    let total = classes.len() * params.pieces;
    let (mut judged, mut calibration_pieces) = (Vec::new(), usize::MAX);
    let mut represented = 0.0;
    for (number, class) in classes.iter().enumerate() {
        let of_class = || (pieces.iter()).filter(|p| size_class(p.area, largest) == *class);
        let count = of_class().count() as f64;
        let area = of_class().map(|p| p.area).sum::<f64>() / count;
        let true_pieces = field.pieces(&known, area, params.pieces, params.seed);
        if true_pieces.len() < LEAST_TRUE_PIECES {
            continue;
        }
        let calibration = Calibration::new(&field, &known, &true_pieces, &mut |done| {
            at("true pieces", number * params.pieces + done, total);
        });
        calibration_pieces = calibration_pieces.min(calibration.pieces());
        for piece in of_class() {
            represented += piece.represents;
            judged.push(JudgedPiece {
                vertices: piece.vertices.len(),
                area: piece.area,
                judgement: calibration.judge(&figures(&field, piece, &wholes, &known)),
            });
        }
    }
    if judged.is_empty() {
        return Err(StatsError::NoRoom);
    }
    let judgements: Vec<&Judgement> = judged.iter().map(|piece| &piece.judgement).collect();
    Ok(Natural {
        calibration_pieces,
        share: (represented / field.area(&listed(&other))).min(1.0),
        variogram: variogram(&field, &known, &other),
        scores: Scores::of(&judgements),
        pieces: judged,
    })
}

/// The largest area of a piece that the known part has room for.
fn largest_piece(field: &Field, known: &[bool], seed: u32) -> Option<f64> {
    let area = LARGEST_SHARE * field.area(&listed(known));
    (0..=HALVINGS)
        .map(|halvings| area * 0.5f64.powi(halvings))
        .find(|area| field.pieces(known, *area, LEAST_TRUE_PIECES, seed).len() >= LEAST_TRUE_PIECES)
}

/// What every vertex of either part sees around it; distances in median edges of the coarser part.
fn field_of(measured: &Measured, known: &[bool], other: &[bool]) -> Option<Field> {
    let step = f64::max(measured.median_edge(known)?, measured.median_edge(other)?);
    let heights: Vec<f64> = (measured.relief.heights.iter().zip(known.iter().zip(other)))
        .map(|(height, (a, b))| if *a || *b { *height } else { f64::NAN })
        .collect();
    Some(Field::new(FieldInput {
        feet: &measured.feet(),
        heights: &heights,
        colors: measured.colors.as_deref(),
        step,
    }))
}

/// Figures of a piece; those of the seam are of the whole that it was cut out of.
fn figures(field: &Field, piece: &Piece, wholes: &Wholes, known: &[bool]) -> Vec<Figure> {
    let mut figures = field.figures(&piece.vertices, known);
    let whole = piece.cut_out_of.and_then(|whole| wholes.get(&whole));
    for (figure, of_whole) in figures.iter_mut().zip(whole.into_iter().flatten()) {
        if figure.name.contains("seam") {
            *figure = of_whole.clone();
        }
    }
    figures
}

/// Of both parts, at the distances that both have.
fn variogram(field: &Field, known: &[bool], other: &[bool]) -> Variogram {
    let mut both = Variogram {
        distances: Vec::new(),
        original: Vec::new(),
        completed: Vec::new(),
    };
    let completed = field.variogram(&listed(other));
    for (distance, original) in field.variogram(&listed(known)) {
        let same = |(d, _): &&(f64, f64)| (d - distance).abs() <= 0.0;
        if let Some((_, completed)) = completed.iter().find(same) {
            both.distances.push(distance);
            both.original.push(original);
            both.completed.push(*completed);
        }
    }
    both
}

/// Sizes within a factor of two of each other are one class.
fn size_class(area: f64, largest: f64) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most the largest, so not negative; saturating"
    )]
    let class = (largest / area).log2().round().max(0.0) as u32;
    class
}

/// The connected parts of some vertices, the largest first.
fn components(measured: &Measured, part: &[bool]) -> Vec<Vec<u32>> {
    let adjacency = Adjacency::new(&measured.mesh);
    let mut left = part.to_vec();
    let mut components: Vec<Vec<u32>> = Vec::new();
    for start in listed(part) {
        if !std::mem::replace(&mut left[start as usize], false) {
            continue;
        }
        let (mut component, mut next) = (vec![start], 0);
        while next < component.len() {
            for n in adjacency.neighbors.row(component[next] as usize) {
                if std::mem::replace(&mut left[*n as usize], false) {
                    component.push(*n);
                }
            }
            next += 1;
        }
        component.sort_unstable();
        components.push(component);
    }
    components.sort_by(|a, b| b.len().cmp(&a.len()).then(a.cmp(b)));
    components
}

/// What is judged, the largest first: no piece is (much) larger than `limit`.
fn pieces(field: &Field, components: &[Vec<u32>], limit: f64, seed: u32) -> Vec<Piece> {
    let (mut pieces, mut small) = (Vec::new(), Vec::new());
    let mut rng = Rng::new(seed, Stage::Likeness, 1);
    for (index, component) in components.iter().enumerate() {
        let area = field.area(component);
        if area < SMALL_SHARE * limit || component.len() < LEAST_VERTICES {
            small.extend(component);
        } else if area <= limit {
            pieces.push(Piece::whole(field, component.clone()));
        } else {
            pieces.extend(cut(field, index, component, limit, &mut rng));
        }
    }
    // Small ones together, as many as make a piece.
    pieces.extend(in_order(field, &small, limit));
    pieces.retain(|piece| piece.area > 0.0 && piece.vertices.len() >= LEAST_VERTICES);
    pieces.sort_by(|a, b| {
        let by_area = b.area.total_cmp(&a.area);
        by_area.then_with(|| a.vertices.cmp(&b.vertices))
    });
    pieces.truncate(MOST_PIECES);
    pieces
}

/// Round pieces of a component; where it is too narrow for them, pieces in the order of a walk through it.
fn cut(field: &Field, index: usize, component: &[u32], limit: f64, rng: &mut Rng) -> Vec<Piece> {
    let area = field.area(component);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, saturating"
    )]
    let count = ((area / limit).ceil() as usize).clamp(2, DISCS);
    let discs = Discs::new(field.feet(), &field.marked(component), field.step());
    let discs = discs.random(limit, count, rng);
    if discs.is_empty() {
        let order = spatial_order(&field.feet().positions, component.to_vec());
        return in_order(field, &order, limit);
    }
    let each = area / discs.len() as f64;
    (discs.into_iter())
        .map(|vertices| Piece {
            area: field.area(&vertices),
            vertices,
            cut_out_of: Some(index),
            represents: each,
        })
        .collect()
}

/// Pieces of just about the limit's area, of vertices as they come.
fn in_order(field: &Field, vertices: &[u32], limit: f64) -> Vec<Piece> {
    let (mut pieces, mut piece, mut covered) = (Vec::new(), Vec::new(), 0.0);
    for v in vertices {
        piece.push(*v);
        covered += field.area(&[*v]);
        if covered >= limit {
            pieces.push(Piece::whole(field, std::mem::take(&mut piece)));
            covered = 0.0;
        }
    }
    pieces.push(Piece::whole(field, piece));
    pieces
}

impl Piece {
    fn whole(field: &Field, mut vertices: Vec<u32>) -> Self {
        vertices.sort_unstable();
        let area = field.area(&vertices);
        Self {
            vertices,
            area,
            cut_out_of: None,
            represents: area,
        }
    }
}

/// The numbers of marked vertices.
fn listed(marks: &[bool]) -> Vec<u32> {
    let numbered = (0u32..).zip(marks);
    numbered.filter(|(_, is)| **is).map(|(v, _)| v).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;
    use nalgebra::Point3;

    const SIDE: u32 = 90;

    /// A level sheet with heights that change from vertex to vertex.
    fn field() -> Field {
        let mut feet = TriMesh::default();
        for v in 0..SIDE * SIDE {
            let (x, y) = (f64::from(v % SIDE), f64::from(v / SIDE));
            feet.positions.push(Point3::new(x, y, 0.0));
            if v % SIDE + 1 < SIDE && v / SIDE + 1 < SIDE {
                feet.triangles
                    .extend([[v, v + 1, v + SIDE + 1], [v, v + SIDE + 1, v + SIDE]]);
            }
        }
        let heights: Vec<f64> = (feet.positions.iter())
            .map(|p| (0.7 * p.x).sin() + (0.9 * p.y + 0.02 * p.x * p.y).cos())
            .collect();
        Field::new(FieldInput {
            feet: &feet,
            heights: &heights,
            colors: None,
            step: 1.0,
        })
    }

    fn rectangle(left: u32, top: u32, width: u32, height: u32) -> Vec<u32> {
        (top..top + height)
            .flat_map(|y| (left..left + width).map(move |x| y * SIDE + x))
            .collect()
    }

    #[test]
    fn no_piece_is_larger_than_the_limit_and_nothing_is_lost() {
        let field = field();
        let limit = 200.0;
        // Small squares, one that is as it should be, a large one, and a strip too narrow for discs.
        let mut components: Vec<Vec<u32>> =
            (0..12).map(|i| rectangle(5 + 6 * i, 5, 3, 3)).collect();
        components.push(rectangle(5, 20, 12, 12));
        components.push(rectangle(30, 20, 32, 32));
        components.push(rectangle(5, 70, 80, 4));
        let pieces = pieces(&field, &components, limit, 1);
        let all: f64 = components.iter().map(|c| field.area(c)).sum();
        let represented: f64 = pieces.iter().map(|p| p.represents).sum();
        assert!(
            (represented / all - 1.0).abs() < 1e-9,
            "{represented} {all}"
        );
        for piece in &pieces {
            assert!(piece.area < 1.1 * limit, "{}", piece.area);
            assert!(piece.vertices.is_sorted() && piece.vertices.len() >= LEAST_VERTICES);
        }
        let cut: Vec<usize> = pieces.iter().filter_map(|p| p.cut_out_of).collect();
        assert!(cut.len() >= 2 && cut.iter().all(|c| *c == 13), "{cut:?}");
    }

    #[test]
    fn pieces_are_as_large_as_the_holes_leave_room_for() {
        let field = field();
        let all = vec![true; (SIDE * SIDE) as usize];
        let area = field.area(&listed(&all));
        assert!((largest_piece(&field, &all, 1).unwrap() / area - 0.125).abs() < 1e-9);
        let with_holes: Vec<bool> = (0..SIDE * SIDE)
            .map(|v| !(v % SIDE).is_multiple_of(18) || !(v / SIDE).is_multiple_of(18))
            .collect();
        let largest = largest_piece(&field, &with_holes, 1).unwrap();
        assert!(
            (0.01..0.07).contains(&(largest / area)),
            "{}",
            largest / area
        );
        assert_eq!(largest_piece(&field, &vec![false; all.len()], 1), None);
    }

    #[test]
    fn too_few_and_too_many_pieces_are_refused() {
        for (pieces, is_good) in [
            (0, false),
            (59, false),
            (60, true),
            (10_000, true),
            (usize::MAX, false),
        ] {
            let params = NaturalParams { pieces, seed: 0 };
            assert_eq!(params.check().is_ok(), is_good, "{pieces}");
        }
    }
}
