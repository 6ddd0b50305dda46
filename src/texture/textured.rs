//! The textured mesh, and its texture on the mesh that it was made from.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::mesh::{SurfaceLookup, TriMesh, vertex_normals};
use crate::relief;
use crate::scan::{Column, Scan, Table};

use super::TextureReport;

/// Names of the vertex properties that tell where the texture's first axis points.
pub const DIRECTION: [&str; 3] = ["tx", "ty", "tz"];

/// A mesh with texture all over it.
#[derive(Debug, Clone)]
pub struct Textured {
    /// The mesh, of evenly spread vertices.
    pub mesh: TriMesh,
    /// #V intensities from 0 to 1; `None` if the sample has no colors.
    pub colors: Option<Vec<[f64; 3]>>,
    /// #V heights over the mesh, in its unit: the sample's, scaled as its texels are; `None` if the sample has none.
    pub heights: Option<Vec<f64>>,
    /// #V: the pixel of the sample, row by row from the top, or the vertex, that each was copied from.
    pub sources: Vec<u32>,
    /// #V: mean squared difference of the neighborhoods' values; NaN where there was nothing to compare.
    pub costs: Vec<f32>,
    /// #V unit tangents: the texture's first axis.
    pub directions: Vec<Vector3<f64>>,
    /// What was done.
    pub report: TextureReport,
}

impl Textured {
    /// Heights from the colors, for samples that are images: their luminance (Rec. 709), less its mean. Nothing
    /// changes where there are heights.
    ///
    /// # Reference
    /// ITU-R BT.709-6, 3.2.
    pub fn heights_from_colors(&mut self) {
        if self.heights.is_some() {
            return;
        }
        let Some(colors) = &self.colors else { return };
        let luminance: Vec<f64> = colors.iter().map(luminance).collect();
        let mean = luminance.iter().sum::<f64>() / luminance.len().max(1) as f64;
        self.heights = Some(luminance.into_iter().map(|l| l - mean).collect());
    }

    /// The mesh with its vertices moved along the normals by `scale` times their heights.
    #[must_use]
    pub fn displaced(&self, scale: f64) -> TriMesh {
        let Some(heights) = &self.heights else {
            return self.mesh.clone();
        };
        let normals = vertex_normals(&self.mesh);
        TriMesh {
            positions: relief::displaced(&self.mesh.positions, &normals, heights, scale),
            triangles: self.mesh.triangles.clone(),
        }
    }

    /// A scan with all that is known of each vertex: positions (displaced by `scale` times the heights if given), `red`,
    /// `green`, `blue`, `height`, `source`, `cost`, and the direction [`DIRECTION`].
    #[must_use]
    pub fn scan(&self, scale: Option<f64>) -> Scan {
        let mut vertices = Table {
            channels: Vec::new(),
            rows: self.mesh.positions.len(),
        };
        for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
            let values = self.mesh.positions.iter().map(|p| p[k]).collect();
            vertices.set_channel(name, Column::F64(values));
        }
        let mut scan = Scan {
            vertices,
            ..Scan::default()
        };
        for triangle in &self.mesh.triangles {
            scan.faces.push_row(triangle);
        }
        if let Some(colors) = &self.colors {
            scan.vertices.set_colors(colors);
        }
        if let Some(heights) = &self.heights {
            let normals = vertex_normals(&self.mesh);
            relief::put_on(&mut scan, &normals, heights.clone(), scale);
        }
        let vertices = &mut scan.vertices;
        vertices.set_channel("source", Column::U32(self.sources.clone()));
        vertices.set_channel("cost", Column::F32(self.costs.clone()));
        #[expect(clippy::cast_possible_truncation, reason = "directions are single")]
        for (k, name) in DIRECTION.into_iter().enumerate() {
            let values = self.directions.iter().map(|d| d[k] as f32).collect();
            vertices.set_channel(name, Column::F32(values));
        }
        scan
    }

    /// The texture to be looked up at other points of the same surface.
    #[must_use]
    pub fn lookup(&self) -> Lookup<'_> {
        Lookup {
            textured: self,
            surface: SurfaceLookup::new(&self.mesh),
        }
    }
}

/// Texture at any point of a surface.
#[derive(Debug)]
pub struct Lookup<'a> {
    textured: &'a Textured,
    surface: SurfaceLookup,
}

impl Lookup<'_> {
    /// The color there, between those of the vertices around; `None` if the sample has none.
    #[must_use]
    pub fn color(&self, point: &Point3<f64>, normal: Option<&Vector3<f64>>) -> Option<[f64; 3]> {
        let colors = self.textured.colors.as_ref()?;
        Some(self.surface.place(point, normal)?.of_vertices(colors))
    }

    /// The height there.
    #[must_use]
    pub fn height(&self, point: &Point3<f64>, normal: Option<&Vector3<f64>>) -> Option<f64> {
        let heights = self.textured.heights.as_ref()?;
        let place = self.surface.place(point, normal)?;
        let [height] = place.mixed(place.corners.map(|v| [heights[v as usize]]));
        Some(height)
    }

    /// The scan itself with the texture's colors at its vertices (`red`, `green`, `blue`), and their heights (`height`);
    /// moved along its normals by `scale` times these if that is given, bit by bit where it was if not. All else
    /// stays.
    #[must_use]
    pub fn on_scan(&self, scan: &Scan, scale: Option<f64>) -> Scan {
        let mesh = scan.mesh();
        let normals = vertex_normals(&mesh);
        let at = |v: usize| {
            (
                &mesh.positions[v],
                Some(&normals[v]).filter(|n| n.norm() > 0.5),
            )
        };
        let mut scan = scan.clone();
        let rows = 0..mesh.positions.len();
        let colors: Option<Vec<[f64; 3]>> = (rows.clone().into_par_iter())
            .map(|v| self.color(at(v).0, at(v).1))
            .collect();
        if let Some(colors) = colors {
            scan.vertices.set_colors(&colors);
        }
        let heights: Option<Vec<f64>> = rows
            .into_par_iter()
            .map(|v| self.height(at(v).0, at(v).1))
            .collect();
        if let Some(heights) = heights {
            relief::put_on(&mut scan, &normals, heights, scale);
        }
        scan
    }
}

/// Luminance of a color, 0 to 1.
fn luminance([r, g, b]: &[f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}
