//! How far apart target vertices stand.

use serde::Serialize;

use crate::mesh::{TriMesh, edge_lengths};

/// One edge in this many is shorter than the robust Nyquist spacing. The exact minimum of a real
/// scan is an outlier (slivers of 1e-6 would ask for a million times the vertices).
const NYQUIST_ONE_IN: usize = 10;

/// How the spacing of target vertices is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SpacingRule {
    /// The shortest edges of the scan, robustly (10 % quantile): a spacing Δ carries all
    /// frequencies up to 1/(2Δ), so no detail that the scan could hold is lost.
    #[default]
    Nyquist,
    /// The scan's median edge.
    Scan,
    /// A length in the scan's unit.
    Length(f64),
}

/// Edge lengths of a scan and the spacing that follows from them, all in the scan's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EdgeSpacing {
    /// Spacing of the target vertices.
    pub spacing: f64,
    /// Shortest edge (the paper's own bound).
    pub shortest: f64,
    /// Edge length that 10 % of the edges stay below.
    pub nyquist: f64,
    /// Median edge length.
    pub median: f64,
}

/// Measures the edges of `mesh` and applies `rule`; `None` if no edge has a length.
#[must_use]
pub fn edge_spacing(mesh: &TriMesh, rule: SpacingRule) -> Option<EdgeSpacing> {
    let mut lengths = edge_lengths(mesh);
    lengths.retain(|length| *length > 0.0);
    let (tenth, half) = (lengths.len() / NYQUIST_ONE_IN, lengths.len() / 2);
    let shortest = lengths.iter().copied().min_by(f64::total_cmp)?;
    let mut quantile = |index| *lengths.select_nth_unstable_by(index, f64::total_cmp).1;
    let (nyquist, median) = (quantile(tenth), quantile(half));
    let spacing = match rule {
        SpacingRule::Nyquist => nyquist,
        SpacingRule::Scan => median,
        SpacingRule::Length(length) => length,
    };
    Some(EdgeSpacing {
        spacing,
        shortest,
        nyquist,
        median,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn one_sliver_does_not_set_the_spacing() {
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for i in 0..40u32 {
            let x = 3.0 * f64::from(i);
            positions.extend([
                Point3::new(x, 0.0, 0.0),
                Point3::new(x + 1.0, 0.0, 0.0),
                Point3::new(x, 1.0, 0.0),
            ]);
            triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        positions[1] = Point3::new(1e-6, 0.0, 0.0);
        let mesh = TriMesh {
            positions,
            triangles,
        };
        let spacing = |rule| edge_spacing(&mesh, rule).unwrap();
        assert!(spacing(SpacingRule::Nyquist).shortest < 1e-5);
        assert!((spacing(SpacingRule::Nyquist).spacing - 1.0).abs() < 1e-12);
        assert!((spacing(SpacingRule::Length(0.3)).spacing - 0.3).abs() < 1e-12);
        assert_eq!(edge_spacing(&TriMesh::default(), SpacingRule::Scan), None);
    }
}
