//! What a triangulation of a cloud is asked for.

use serde::{Deserialize, Serialize};

use super::CloudError;

/// How the points are joined.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JoinChoice {
    /// In the chart of the fitted base surface if it describes the cloud's form and the cloud lies over
    /// it in one layer; by local stars otherwise.
    ///
    /// Measured on the points of scans with faces, in boundary loops (scan, chart, stars): golf ball 0, 0,
    /// 0; column 2, 2, 2; scallop shell 1, 1, 1; pitted limestone 94, 92, 203, since stars do not agree on
    /// the walls of the pits; but a rabbit, which no base describes, 5, 833, 5, and a tower 38, 325, 120.
    #[default]
    Auto,
    /// In the chart of the fitted base surface, however well it fits.
    Chart,
    /// By local stars.
    Local,
}

/// Which points are taken for stray ones.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OutlierParams {
    /// Mean distance to the nearest neighbors beyond which a point may be stray, in robust standard
    /// deviations above the cloud's median. Default 6: of normal distances, one in a billion.
    pub deviations: f64,
    /// The same distance as a multiple of its neighbors' own, so that a sparse area is no stray one.
    /// Default 3.
    pub isolation: f64,
    /// Groups with fewer points than this, farther than the gap from all others, are stray. Default 10.
    pub least_group: usize,
}

impl Default for OutlierParams {
    fn default() -> Self {
        Self {
            deviations: 6.0,
            isolation: 3.0,
            least_group: 10,
        }
    }
}

/// Parameters of [`super::triangulate`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CloudParams {
    /// Number of nearest neighbors whose plane gives a point's normal. Default 16: two rings of a
    /// square grid but for its corners.
    pub neighbors: usize,
    /// Longest edge of a triangle, as a multiple of the local spacing (see [`super::CloudReport::spacing`]
    /// for the cloud's): wider gaps stay open. The local spacing is the distance to the sixth neighbor, the
    /// median of those around a point, and of an edge's ends the larger.
    ///
    /// Default 4. Of 2.5, 4, 6 and 9, measured on a figure, a photogrammetric rock and a gravel bed, 2.5 tears
    /// three holes more into the figure and a quarter more pieces off the gravel; those above change the number
    /// of triangles by less than 0.1 %, because local stars look no farther than 64 neighbors, about 5 spacings.
    pub gap: f64,
    /// Which points are stray; `None` keeps all.
    pub outliers: Option<OutlierParams>,
    /// How the points are joined. Default: chosen by the form.
    pub join: JoinChoice,
    /// Seed of the base surface's fit. Default 0.
    pub seed: u32,
}

impl Default for CloudParams {
    fn default() -> Self {
        Self {
            neighbors: 16,
            gap: 4.0,
            outliers: Some(OutlierParams::default()),
            join: JoinChoice::Auto,
            seed: 0,
        }
    }
}

/// Least and largest number of neighbors: a star needs a ring of them, and a plane of more is none.
const NEIGHBORS: std::ops::RangeInclusive<usize> = 8..=200;

impl CloudParams {
    /// Whether every parameter is in its range.
    ///
    /// # Errors
    /// The [`CloudError`] of the first that is not.
    pub fn check(&self) -> Result<(), CloudError> {
        if !NEIGHBORS.contains(&self.neighbors) {
            return Err(CloudError::Neighbors {
                asked: self.neighbors,
                least: *NEIGHBORS.start(),
                most: *NEIGHBORS.end(),
            });
        }
        if !(self.gap.is_finite() && self.gap >= 1.0) {
            return Err(CloudError::Gap(self.gap));
        }
        let sound = |o: &OutlierParams| o.deviations >= 0.0 && o.isolation >= 1.0;
        match self.outliers {
            Some(outliers) if !sound(&outliers) => Err(CloudError::Outliers),
            _ => Ok(()),
        }
    }
}
