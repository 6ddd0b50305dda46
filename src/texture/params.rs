//! What is asked for.

use nalgebra::{Point3, Vector3};
use serde::Serialize;

use super::TextureError;

/// More vertices than this are refused before anything is allocated: neighborhoods take about 1.5 kB a vertex.
pub const MOST_VERTICES: usize = 4_000_000;

/// The paper's sphere has as many vertices.
const VERTICES: usize = 24_576;

/// If the sample's own texels leave fewer vertices than this, its unit is hardly the mesh's.
const LEAST_OF_OWN: usize = 100;

/// More levels than this halve any texture away.
const MOST_LEVELS: usize = 12;

/// Beyond this, turns cannot be told from none.
const MOST_SYMMETRY: u32 = 16;

/// How a mesh is textured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TextureParams {
    /// How densely vertices are spread, and with them the texture's scale.
    pub density: Density,
    /// Where the texture's first axis points.
    pub orientation: Orientation,
    /// The texture looks the same after a turn by 2π over this: 1 by default, 2 for what has lines but no arrows,
    /// 4 for grids. Directions are compared, and relaxed, up to such turns.
    pub symmetry: u32,
    /// How the texture grows.
    pub method: Method,
    /// How the nearest neighborhood is found.
    pub search: Search,
    /// Number of resolutions. Default `None`: four by the paper's method; by the other as many as leave the
    /// sample's coarsest level, and the mesh's, large enough.
    pub levels: Option<usize>,
    /// Seed of all random choices.
    pub seed: u32,
}

impl Default for TextureParams {
    fn default() -> Self {
        Self {
            density: Density::Auto,
            orientation: Orientation::Relax,
            symmetry: 1,
            method: Method::Coherent,
            search: Search::Tree,
            levels: None,
            seed: 0,
        }
    }
}

/// How densely vertices are spread: a texel of the sample takes the area of one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Density {
    /// As many vertices as the mesh has, and at least 24 576; for a sample that is a scan, texels of its own size.
    Auto,
    /// This many vertices.
    Vertices(usize),
    /// This length of a texel, in the scan's unit: the side of a square of a vertex's area.
    Texel(f64),
}

/// Where the texture's first axis points.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Orientation {
    /// Anywhere, at each vertex anew: for textures without any direction.
    Random,
    /// As much along this direction as the surface allows.
    Along(Vector3<f64>),
    /// At the vertices nearest to these points as given, in between smoothly.
    Given(#[serde(serialize_with = "count")] Vec<(Point3<f64>, Vector3<f64>)>),
    /// Anywhere, but as parallel to the neighbors' as the surface allows.
    Relax,
}

/// How many there are: a file of directions may have millions.
fn count<S: serde::Serializer>(
    list: &[(Point3<f64>, Vector3<f64>)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    list.len().serialize(serializer)
}

/// How a texture grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// What continues the neighbors' sources, or looks like that, is compared, and each level is corrected
    /// several times.
    ///
    /// # Reference
    /// [Ashikhmin 2001](crate::bibliography#ashikhmin-2001); [Tong et al. 2002](crate::bibliography#tong-et-al-2002);
    /// [Lefebvre & Hoppe 2005](crate::bibliography#lefebvre--hoppe-2005).
    Coherent,
    /// As in the paper: on each level two passes over all neighborhoods of the sample.
    ///
    /// # Reference
    /// [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001), Table 1.
    WeiLevoy,
}

/// How the nearest neighborhood is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Search {
    /// All are compared.
    Exhaustive,
    /// By a tree over a few principal components, and a comparison of the nearest there: what is found may be a
    /// little farther.
    Tree,
}

impl Orientation {
    /// The same for a mesh that was moved so that `origin` is in 0.
    pub(super) fn around(&self, origin: &Vector3<f64>) -> Self {
        match self {
            Self::Given(list) => Self::Given(list.iter().map(|(p, d)| (p - origin, *d)).collect()),
            other => other.clone(),
        }
    }
}

impl TextureParams {
    /// Whether every parameter is in its range.
    ///
    /// # Errors
    /// [`TextureError`] for the first that is not.
    pub fn check(&self) -> Result<(), TextureError> {
        match self.density {
            Density::Vertices(asked) if !(4..=MOST_VERTICES).contains(&asked) => {
                return Err(TextureError::Vertices { asked });
            }
            Density::Texel(asked) if !(asked > 0.0 && asked.is_finite()) => {
                return Err(TextureError::Texel(asked));
            }
            _ => {}
        }
        if !(1..=MOST_SYMMETRY).contains(&self.symmetry) {
            return Err(TextureError::Symmetry {
                asked: self.symmetry,
                most: MOST_SYMMETRY,
            });
        }
        if let Some(asked) = self.levels.filter(|n| !(1..=MOST_LEVELS).contains(n)) {
            return Err(TextureError::Levels {
                asked,
                most: MOST_LEVELS,
            });
        }
        let is_direction = |d: &Vector3<f64>| d.iter().all(|x| x.is_finite()) && d.norm() > 0.0;
        match &self.orientation {
            Orientation::Along(direction) if !is_direction(direction) => {
                Err(TextureError::Direction)
            }
            Orientation::Given(list) if !list.iter().any(|(_, d)| is_direction(d)) => {
                Err(TextureError::NoDirections)
            }
            _ => Ok(()),
        }
    }

    /// Number of vertices for a mesh of `vertices` vertices and this area, with texels of the sample's own size if it
    /// has one.
    pub(super) fn vertices(
        &self,
        vertices: usize,
        area: f64,
        sample_texel: Option<f64>,
    ) -> Result<usize, TextureError> {
        let of_texel = |texel: f64| {
            let asked = (area / (texel * texel)).round();
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates far beyond what is allowed"
            )]
            let asked = asked as usize;
            if (4..=MOST_VERTICES).contains(&asked) {
                Ok(asked)
            } else {
                Err(TextureError::VerticesOfTexel { texel, asked })
            }
        };
        match (self.density, sample_texel) {
            (Density::Vertices(asked), _) => Ok(asked),
            (Density::Texel(texel), _) => of_texel(texel),
            (Density::Auto, Some(texel)) => match of_texel(texel) {
                Ok(asked) if asked >= LEAST_OF_OWN => Ok(asked),
                Ok(asked) | Err(TextureError::VerticesOfTexel { asked, .. }) => {
                    Err(TextureError::VerticesOfOwnTexel { texel, asked })
                }
                Err(error) => Err(error),
            },
            (Density::Auto, None) => Ok(vertices.clamp(VERTICES, MOST_VERTICES)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(change: impl FnOnce(&mut TextureParams)) -> Result<(), TextureError> {
        let mut params = TextureParams::default();
        change(&mut params);
        params.check()
    }

    #[test]
    fn defaults_and_limits_are_in_range() {
        assert!(checked(|_| {}).is_ok());
        for vertices in [4, MOST_VERTICES] {
            assert!(checked(|p| p.density = Density::Vertices(vertices)).is_ok());
        }
        for symmetry in [1, MOST_SYMMETRY] {
            assert!(checked(|p| p.symmetry = symmetry).is_ok());
        }
        for levels in [1, MOST_LEVELS] {
            assert!(checked(|p| p.levels = Some(levels)).is_ok());
        }
        assert!(checked(|p| p.density = Density::Texel(1e-300)).is_ok());
    }

    #[test]
    fn what_is_out_of_range_is_named() {
        for vertices in [0, 3, MOST_VERTICES + 1, usize::MAX] {
            let error = checked(|p| p.density = Density::Vertices(vertices)).unwrap_err();
            assert!(matches!(error, TextureError::Vertices { asked } if asked == vertices));
        }
        for texel in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = checked(|p| p.density = Density::Texel(texel)).unwrap_err();
            assert!(matches!(error, TextureError::Texel(_)), "{error}");
        }
        for symmetry in [0, MOST_SYMMETRY + 1, u32::MAX] {
            let error = checked(|p| p.symmetry = symmetry).unwrap_err();
            assert!(matches!(error, TextureError::Symmetry { .. }), "{error}");
        }
        for levels in [0, MOST_LEVELS + 1, usize::MAX] {
            let error = checked(|p| p.levels = Some(levels)).unwrap_err();
            assert!(matches!(error, TextureError::Levels { .. }), "{error}");
        }
        for bad in [Vector3::zeros(), Vector3::new(f64::NAN, 1.0, 0.0)] {
            let error = checked(|p| p.orientation = Orientation::Along(bad)).unwrap_err();
            assert!(matches!(error, TextureError::Direction), "{error}");
            let list = vec![(Point3::origin(), bad)];
            let error = checked(|p| p.orientation = Orientation::Given(list)).unwrap_err();
            assert!(matches!(error, TextureError::NoDirections), "{error}");
        }
        let none = checked(|p| p.orientation = Orientation::Given(Vec::new())).unwrap_err();
        assert!(matches!(none, TextureError::NoDirections), "{none}");
    }

    #[test]
    fn the_density_follows_from_texel_area_and_sample() {
        let of = |density, vertices, area, sample_texel| {
            let params = TextureParams {
                density,
                ..TextureParams::default()
            };
            params.vertices(vertices, area, sample_texel).ok()
        };
        assert_eq!(of(Density::Vertices(77), 5, 1.0, Some(0.1)), Some(77));
        assert_eq!(of(Density::Texel(0.5), 5, 100.0, None), Some(400));
        assert_eq!(of(Density::Auto, 5, 100.0, Some(0.5)), Some(400));
        assert_eq!(of(Density::Auto, 5, 100.0, None), Some(VERTICES));
        assert_eq!(of(Density::Auto, 30_000, 100.0, None), Some(30_000));
        assert_eq!(
            of(Density::Auto, usize::MAX, 100.0, None),
            Some(MOST_VERTICES)
        );
        assert_eq!(of(Density::Texel(1e-9), 5, 100.0, None), None);
        assert_eq!(of(Density::Texel(1e-300), 5, 100.0, None), None);
        assert_eq!(of(Density::Texel(90.0), 5, 100.0, None), None);
    }
}
