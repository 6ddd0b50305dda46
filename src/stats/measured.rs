//! Heights over a base surface, ready to be compared.

use nalgebra::{Point3, Vector3};

use crate::base::{self, BaseChoice, BaseSurface, FitParams, Form, FreeForm, Role, smooth_form};
use crate::completion::{COMPLETED, noted_relief, remembered_base, remembered_free_form};
use crate::mesh::{TriMesh, median_edge};
use crate::relief::{self, Relief};
use crate::scan::Scan;

use super::StatsError;

/// How heights are taken.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeasureParams {
    /// The base surface. Default: the one that completion noted in the scan, else the kind that fits best,
    /// else free form.
    pub fit: FitParams,
    /// Wavelength that tells form from relief where the base is free form, in the scan's unit. Default
    /// `None`: chosen from the relief.
    pub form_wavelength: Option<f64>,
    /// Nesting index of the S-filter: shorter waves are taken off the heights, in the scan's unit. Default:
    /// no filter.
    pub s_filter: Option<f64>,
    /// Nesting index of the L-filter: longer waves are taken off the heights, in the scan's unit. Default: no
    /// filter.
    pub l_filter: Option<f64>,
}

/// A surface with heights over its base.
#[derive(Debug, Clone)]
pub struct Measured {
    /// Around its centroid.
    pub(super) mesh: TriMesh,
    pub(super) relief: Relief,
    /// #V: whether the vertex has relief, and does not belong to another surface.
    pub(super) on_base: Vec<bool>,
    pub(super) colors: Option<Vec<[f64; 3]>>,
    /// The base surface, in the scan's own coordinates.
    pub(super) base: Form,
}

impl Measured {
    /// Takes the heights of a scan. What an earlier completion invented has no say in the base surface.
    ///
    /// # Errors
    /// [`StatsError`] if no base surface fits, a parameter is out of its range, or there are no faces.
    pub fn new(scan: &Scan, params: &MeasureParams) -> Result<Self, StatsError> {
        params.check()?;
        let (mesh, origin) = scan.mesh().centered();
        if mesh.triangles.is_empty() {
            return Err(StatsError::NoFaces);
        }
        let noted = noted_base(scan, params).zip(noted_relief(scan, &mesh, &origin));
        let (base, (relief, reach)) = match noted {
            Some(noted) => noted,
            None => taken(&mesh, &origin, &completed_vertices(scan), params)?,
        };
        let on_base = (relief.heights.iter())
            .map(|height| height.abs() <= reach)
            .collect();
        let mut measured = Self {
            mesh,
            relief,
            on_base,
            colors: scan.colors(),
            base,
        };
        measured.filter(params)?;
        Ok(measured)
    }

    /// Both surfaces side by side as one, which hang together nowhere; heights of the second are over its own
    /// base. The vertices of the first come first.
    #[must_use]
    pub fn beside(mut self, other: Self) -> Self {
        let offset = u32::try_from(self.mesh.positions.len()).unwrap_or(u32::MAX);
        self.mesh.positions.extend(other.mesh.positions);
        let moved = |t: [u32; 3]| t.map(|v| v.saturating_add(offset));
        (self.mesh.triangles).extend(other.mesh.triangles.into_iter().map(moved));
        self.relief.feet.extend(other.relief.feet);
        self.relief.normals.extend(other.relief.normals);
        self.relief.heights.extend(other.relief.heights);
        self.on_base.extend(other.on_base);
        self.colors = self.colors.zip(other.colors).map(|(mut own, others)| {
            own.extend(others);
            own
        });
        self
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.mesh.positions.len()
    }

    /// What the heights are over.
    #[must_use]
    pub fn base(&self) -> Form {
        self.base
    }

    /// The feet of all vertices and the triangles between them.
    pub(super) fn feet(&self) -> TriMesh {
        TriMesh {
            positions: self.relief.feet.clone(),
            triangles: self.mesh.triangles.clone(),
        }
    }

    /// The vertices of a part (#V) that have relief.
    pub(super) fn marks(&self, part: &[bool]) -> Vec<bool> {
        (part.iter().zip(&self.on_base))
            .map(|(is, on_base)| *is && *on_base)
            .collect()
    }

    /// The median length of the edges of some vertices, in the scan's unit.
    pub(super) fn median_edge(&self, of: &[bool]) -> Option<f64> {
        let is_part = |t: &&[u32; 3]| t.iter().all(|v| of[*v as usize]);
        let part = TriMesh {
            positions: self.mesh.positions.clone(),
            triangles: (self.mesh.triangles.iter())
                .filter(is_part)
                .copied()
                .collect(),
        };
        median_edge(&part)
    }

    /// Takes short waves (S) and long ones (L) off the heights, by the areal spline filter of
    /// [`smooth_form`], whose transmission at the nesting index is a half. It needs no values beyond the rim,
    /// and follows any base surface.
    ///
    /// # Reference
    /// ISO 25178-2:2021, 3.1.5 and 3.1.6 (S-filter, L-filter); ISO 16610-62 (areal spline filter).
    fn filter(&mut self, params: &MeasureParams) -> Result<(), StatsError> {
        let low_passed = |heights: &[f64], wavelength| -> Result<Vec<f64>, StatsError> {
            let heights = TriMesh {
                positions: heights.iter().map(|h| Point3::new(0.0, 0.0, *h)).collect(),
                triangles: (self.mesh.triangles.iter())
                    .filter(|t| t.iter().all(|v| self.on_base[*v as usize]))
                    .copied()
                    .collect(),
            };
            let roles = vec![Role::Measured; heights.positions.len()];
            let smooth = smooth_form(&heights, &self.relief.feet, &roles, wavelength)?;
            Ok(smooth.iter().map(|p| p.z).collect())
        };
        if let Some(wavelength) = params.s_filter {
            self.relief.heights = low_passed(&self.relief.heights, wavelength)?;
        }
        if let Some(wavelength) = params.l_filter {
            let long = low_passed(&self.relief.heights, wavelength)?;
            for (height, long) in self.relief.heights.iter_mut().zip(long) {
                *height -= long;
            }
        }
        Ok(())
    }
}

impl MeasureParams {
    /// Whether every parameter is in its range.
    ///
    /// # Errors
    /// [`StatsError`] for the first that is not.
    pub fn check(&self) -> Result<(), StatsError> {
        let lengths = [
            ("--form-wavelength", self.form_wavelength),
            ("--s-filter", self.s_filter),
            ("--l-filter", self.l_filter),
        ];
        for (name, length) in lengths {
            if let Some(value) = length.filter(|length| !(*length > 0.0 && length.is_finite())) {
                return Err(StatsError::Length { name, value });
            }
        }
        match (self.s_filter, self.l_filter) {
            (Some(s), Some(l)) if s >= l => Err(StatsError::NothingBetween { s, l }),
            _ => Ok(()),
        }
    }
}

/// For each vertex whether a completion invented it.
#[must_use]
pub fn completed_vertices(scan: &Scan) -> Vec<bool> {
    let marks = scan.vertices.channel(COMPLETED);
    let is_completed = |row| Some(marks?.values.get_f64(row)? > 0.5);
    (0..scan.vertices.rows)
        .map(|row| is_completed(row).unwrap_or(false))
        .collect()
}

/// What the scan's comments say that heights are over, unless something else is asked for.
fn noted_base(scan: &Scan, params: &MeasureParams) -> Option<Form> {
    let primitive = remembered_base(scan).map(|known| Form::Primitive(known.surface));
    let noted = primitive.or_else(|| remembered_free_form(scan).map(|f| Form::Free(f.form)))?;
    let asked_for = match (params.fit.base, &noted) {
        (BaseChoice::Auto, _) => true,
        (BaseChoice::Kind(kind), Form::Primitive(surface)) => surface.kind() == kind,
        (BaseChoice::FreeForm, Form::Free(form)) => {
            (params.form_wavelength).is_none_or(|w| (w - form.wavelength).abs() <= 0.0)
        }
        _ => false,
    };
    asked_for.then_some(noted)
}

/// Fits a base surface to what was scanned; free form where none fits. The base in the scan's own
/// coordinates, the relief, and how high it is.
fn taken(
    mesh: &TriMesh,
    origin: &Vector3<f64>,
    completed: &[bool],
    params: &MeasureParams,
) -> Result<(Form, (Relief, f64)), StatsError> {
    if params.fit.base != BaseChoice::FreeForm {
        let scanned: Vec<[u32; 3]> = (mesh.triangles.iter())
            .filter(|t| !t.iter().any(|v| completed[*v as usize]))
            .copied()
            .collect();
        let fit = base::fit_part(&mesh.positions, &scanned, &params.fit)?;
        if fit.fits() {
            let surface: BaseSurface = fit.base;
            let form = Form::Primitive(surface.translated(*origin));
            return Ok((form, (relief::extract(mesh, &surface), relief::reach(&fit))));
        }
        if let BaseChoice::Kind(kind) = params.fit.base {
            return Err(StatsError::BaseDoesNotFit(kind));
        }
    }
    on_free_form(mesh, completed, params)
}

fn on_free_form(
    mesh: &TriMesh,
    completed: &[bool],
    params: &MeasureParams,
) -> Result<(Form, (Relief, f64)), StatsError> {
    if mesh.triangles.is_empty() {
        return Err(StatsError::NoFaces);
    }
    let (relief, wavelength) = relief::on_free_form(mesh, params.form_wavelength, completed)?;
    let reach = relief::reach_of(&relief.heights);
    Ok((Form::Free(FreeForm { wavelength }), (relief, reach)))
}
