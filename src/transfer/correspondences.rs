//! Places of two surfaces that belong together, as a person gives them.
//!
//! A file holds either `{"pairs": [{"source": 12, "target": 40}, …]}` or the bare list `[[12, 40], …]`. A place is the
//! number of a vertex, from 0, or a point `[x, y, z]`, which stands for the vertex nearest to it. Where an object
//! names the places, `target` may be a list of them: one place of the source for many of the target.

mod error;

pub use error::{CorrespondenceError, Side};

use nalgebra::Point3;
use serde_json::Value;

use crate::mesh::{PointTree, TriMesh, bounding_diagonal};

/// Most pairs of a file: every one asks for distances from it over the whole surface.
const MOST_PAIRS: usize = 1000;

/// Pairs of places, as they stand in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Correspondences {
    pairs: Vec<Places>,
}

/// A vertex of the source and all vertices of the target that belong to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pair {
    /// Vertex of the source.
    pub source: u32,
    /// Vertices of the target, at least one, each once, in the order in which they were given.
    pub targets: Vec<u32>,
}

/// A pair as it was given.
#[derive(Debug, Clone, PartialEq)]
struct Places {
    source: Place,
    targets: Vec<Place>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    Vertex(u64),
    Point(Point3<f64>),
}

impl Correspondences {
    /// The pairs of a file.
    ///
    /// # Errors
    /// The first of [`CorrespondenceError`] that shows without the meshes.
    pub fn from_json(text: &str) -> Result<Self, CorrespondenceError> {
        let value: Value =
            serde_json::from_str(text).map_err(|error| CorrespondenceError::NotJson {
                line: error.line(),
                column: error.column(),
                reason: without_position(&error.to_string()),
            })?;
        let list = match &value {
            Value::Array(list) => list,
            Value::Object(object) => (object.get("pairs").and_then(Value::as_array))
                .ok_or(CorrespondenceError::NoList)?,
            _ => return Err(CorrespondenceError::NoList),
        };
        match list.len() {
            0 => return Err(CorrespondenceError::Empty),
            count if count > MOST_PAIRS => return Err(CorrespondenceError::TooMany { count }),
            _ => {}
        }
        let pairs = list
            .iter()
            .zip(1..)
            .map(|(value, pair)| places(value, pair));
        Ok(Self {
            pairs: pairs.collect::<Result<_, _>>()?,
        })
    }

    /// The vertices that the pairs mean on two meshes: one [`Pair`] for each vertex of the source, in the order in which
    /// they come first.
    ///
    /// # Errors
    /// The first place that is not on its surface, or the first two pairs that give a vertex of the target to two of
    /// the source.
    ///
    /// # Panics
    /// If a position is not finite, or a mesh has 2³² vertices or more.
    pub fn resolve(
        &self,
        source: &TriMesh,
        target: &TriMesh,
    ) -> Result<Vec<Pair>, CorrespondenceError> {
        let on_source = Surface::new(source, Side::Source)?;
        let on_target = Surface::new(target, Side::Target)?;
        let mut resolved: Vec<Pair> = Vec::new();
        // By target vertex met so far: the number of its pair, and its source.
        let mut owners: Vec<Option<(usize, u32)>> = vec![None; target.positions.len()];
        for (places, pair) in self.pairs.iter().zip(1..) {
            let source = on_source.vertex(places.source, pair)?;
            for place in &places.targets {
                let vertex = on_target.vertex(*place, pair)?;
                let owner = &mut owners[vertex as usize];
                match *owner {
                    Some((_, of)) if of == source => continue,
                    Some((first, first_source)) => {
                        return Err(CorrespondenceError::Contradiction {
                            first,
                            second: pair,
                            vertex,
                            first_source,
                            second_source: source,
                        });
                    }
                    None => *owner = Some((pair, source)),
                }
                match resolved.iter_mut().find(|known| known.source == source) {
                    Some(known) => known.targets.push(vertex),
                    None => resolved.push(Pair {
                        source,
                        targets: vec![vertex],
                    }),
                }
            }
        }
        Ok(resolved)
    }
}

/// The parser's words without their position, which is told before them.
fn without_position(message: &str) -> String {
    let end = message.rfind(" at line ").unwrap_or(message.len());
    message[..end].to_owned()
}

fn places(value: &Value, pair: usize) -> Result<Places, CorrespondenceError> {
    let (source, target) = match value {
        Value::Array(two) => match two.as_slice() {
            [source, target] => (Some(source), Some(target)),
            _ => (None, None),
        },
        Value::Object(object) => (object.get("source"), object.get("target")),
        _ => (None, None),
    };
    let (Some(source), Some(target)) = (source, target) else {
        return Err(CorrespondenceError::NoPair { pair });
    };
    let is_point = |list: &[Value]| list.len() == 3 && list.iter().all(Value::is_number);
    let targets = match target {
        // Three numbers are a point, as everywhere, not three vertices.
        Value::Array(list) if value.is_object() && !is_point(list) && !list.is_empty() => (list
            .iter())
        .map(|target| place(target, pair, Side::Target))
        .collect::<Result<_, _>>()?,
        _ => vec![place(target, pair, Side::Target)?],
    };
    Ok(Places {
        source: place(source, pair, Side::Source)?,
        targets,
    })
}

fn place(value: &Value, pair: usize, side: Side) -> Result<Place, CorrespondenceError> {
    let found = match value {
        Value::Number(number) => number.as_u64().map(Place::Vertex),
        Value::Array(list) => match list.iter().map(Value::as_f64).collect::<Option<Vec<_>>>() {
            Some(point) => match point[..] {
                [x, y, z] => Some(Place::Point(Point3::new(x, y, z))),
                _ => None,
            },
            None => None,
        },
        _ => None,
    };
    found.ok_or_else(|| CorrespondenceError::NoPlace {
        pair,
        side,
        text: beginning(&value.to_string()),
    })
}

/// At most 40 characters.
fn beginning(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// The vertices of a mesh that a face uses.
struct Surface {
    side: Side,
    used: Vec<bool>,
    /// The vertices in the tree, in its order.
    vertices: Vec<u32>,
    tree: PointTree,
    size: f64,
}

impl Surface {
    fn new(mesh: &TriMesh, side: Side) -> Result<Self, CorrespondenceError> {
        let used = mesh.used_vertices();
        let vertices: Vec<u32> = (0u32..)
            .zip(&used)
            .filter(|(_, u)| **u)
            .map(|(v, _)| v)
            .collect();
        if vertices.is_empty() {
            return Err(CorrespondenceError::NoSurface { side });
        }
        let points: Vec<Point3<f64>> = vertices
            .iter()
            .map(|v| mesh.positions[*v as usize])
            .collect();
        Ok(Self {
            side,
            used,
            vertices,
            tree: PointTree::new(&points),
            size: bounding_diagonal(&points),
        })
    }

    fn vertex(&self, place: Place, pair: usize) -> Result<u32, CorrespondenceError> {
        let side = self.side;
        match place {
            Place::Vertex(vertex) => {
                let index = usize::try_from(vertex)
                    .ok()
                    .filter(|v| *v < self.used.len());
                match (index, u32::try_from(vertex)) {
                    (Some(index), Ok(found)) if self.used[index] => Ok(found),
                    (Some(_), Ok(_)) => Err(CorrespondenceError::Loose { pair, side, vertex }),
                    _ => Err(CorrespondenceError::NoVertex {
                        pair,
                        side,
                        vertex,
                        last: self.used.len() - 1,
                    }),
                }
            }
            Place::Point(point) => {
                let nearest = self.tree.nearest(&point);
                let distance = nearest.distance_sq.sqrt();
                if distance > self.size {
                    return Err(CorrespondenceError::FarAway {
                        pair,
                        side,
                        distance,
                        size: self.size,
                    });
                }
                Ok(self.vertices[nearest.index])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six vertices along a strip, and one that no face uses.
    fn strip() -> TriMesh {
        TriMesh {
            positions: (0..7)
                .map(|i| Point3::new(f64::from(i / 2), f64::from(i % 2), 0.0))
                .collect(),
            triangles: vec![[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]],
        }
    }

    fn resolved(text: &str) -> Result<Vec<Pair>, CorrespondenceError> {
        Correspondences::from_json(text)?.resolve(&strip(), &strip())
    }

    fn pair(source: u32, targets: &[u32]) -> Pair {
        Pair {
            source,
            targets: targets.to_vec(),
        }
    }

    #[test]
    fn both_forms_vertices_and_points_are_understood() {
        let expected = Ok(vec![pair(4, &[1]), pair(0, &[5])]);
        assert_eq!(
            resolved("[[4, 1], [[0.1, 0.2, 0], [2, 1.4, -0.1]]]"),
            expected
        );
        let named = r#"{"pairs": [{"source": 4, "target": 1}, {"source": [0.1, 0, 0], "target": 5}], "by": "me"}"#;
        assert_eq!(resolved(named), expected);
    }

    #[test]
    fn one_place_of_the_source_may_have_many_of_the_target() {
        let expected = Ok(vec![pair(2, &[0, 3, 5]), pair(1, &[4])]);
        let listed = r#"{"pairs": [{"source": 2, "target": [[0, 0, 0], 3]}, {"source": 1, "target": 4},
            {"source": 2, "target": [5, 3]}]}"#;
        assert_eq!(resolved(listed), expected);
        assert_eq!(
            resolved("[[2, 0], [2, 3], [1, 4], [2, 5], [2, 3]]"),
            expected
        );
    }

    #[test]
    fn three_numbers_are_a_point_and_not_three_vertices() {
        let point = r#"{"pairs": [{"source": 2, "target": [2, 1, 0]}]}"#;
        assert_eq!(resolved(point), Ok(vec![pair(2, &[5])]));
    }

    #[test]
    fn each_error_names_its_pair_and_a_remedy() {
        let cases = [
            (
                "[[1, 2],\n [3 4]]",
                "the correspondences are not JSON: line 2, column 5: expected `,` or `]`; correct the file there",
            ),
            ("[[1, 1e999]]", "not JSON: line 1"),
            ("{}", "hold no list of pairs; write [[12, 40], …]"),
            ("7", "hold no list of pairs"),
            ("[]", "are empty; give at least one pair"),
            (
                "[[1, 2], [1, 2, 3]]",
                "correspondence 2 is no pair; write [12, 40]",
            ),
            (r#"[{"source": 3}]"#, "correspondence 1 is no pair"),
            (
                "[[1, -2]]",
                "correspondence 1: its target is `-2`, which is neither a vertex",
            ),
            ("[[1, [0, null, 1]]]", "its target is `[0,null,1]`"),
            ("[[1.5, 2]]", "its source is `1.5`"),
            (
                r#"{"pairs": [{"source": 1, "target": []}]}"#,
                "its target is `[]`",
            ),
            (
                "[[1, 2], [1, 7]]",
                "correspondence 2: the target has no vertex 7, only 0 to 6",
            ),
            (
                "[[18446744073709551615, 2]]",
                "the source has no vertex 18446744073709551615",
            ),
            (
                "[[6, 2]]",
                "no face uses vertex 6 of the source; choose one on the surface",
            ),
            (
                "[[1, [2, 9, 0]]]",
                "correspondence 1: its point on the target is 8 away from it, but the target is only 2.2",
            ),
            ("[[1, [1e300, 0, 0]]]", "is inf away"),
            (
                "[[1, 2], [5, 3], [0, 2]]",
                "correspondences 1 and 3 contradict each other: both have vertex 2 of the target, one with vertex 1 of the source, the other with vertex 0; remove",
            ),
        ];
        for (text, expected) in cases {
            let message = resolved(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{text}: {message}");
        }
        let many = format!("[{}[1, 2]]", "[1, 2],".repeat(1000));
        let message = resolved(&many).unwrap_err().to_string();
        assert!(
            message.contains("1001 correspondences; choose at most 1000"),
            "{message}"
        );
    }

    #[test]
    fn a_mesh_without_faces_has_no_places() {
        let mut bare = strip();
        bare.triangles.clear();
        let pairs = Correspondences::from_json("[[1, 2]]").unwrap();
        let error = pairs.resolve(&strip(), &bare).unwrap_err();
        assert_eq!(error, CorrespondenceError::NoSurface { side: Side::Target });
        let empty = pairs.resolve(&TriMesh::default(), &bare).unwrap_err();
        assert_eq!(empty, CorrespondenceError::NoSurface { side: Side::Source });
    }
}
