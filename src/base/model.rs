//! A surface as a function of its parameters, and the least-squares problem over its heights.

use std::cell::OnceCell;

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::{DMatrix, DVector, Dyn, Owned, Point3};
use rayon::prelude::*;

use super::samples::Samples;
use super::{BaseSurface, StopReason};
use super::{cone::ConeModel, cylinder::CylinderModel, plane::PlaneModel, sphere::SphereModel};

/// A surface near a start, by parameters that have no constraints between them.
pub(super) trait Model: Sync {
    /// Present parameters.
    fn params(&self) -> &[f64];
    /// Changes them.
    fn set_params(&mut self, params: &[f64]);
    /// Signed orthogonal height of a point.
    fn height(&self, p: &Point3<f64>) -> f64;
    /// Derivatives of the height by the parameters, into a slice of their number.
    fn gradient(&self, p: &Point3<f64>, gradient: &mut [f64]);
    /// The surface that the parameters describe.
    fn surface(&self) -> BaseSurface;
}

/// The model of the surface's kind, with parameters that describe `start`.
pub(super) fn model(start: &BaseSurface) -> Box<dyn Model> {
    match start {
        BaseSurface::Plane(plane) => Box::new(PlaneModel::new(plane)),
        BaseSurface::Sphere(sphere) => Box::new(SphereModel::new(sphere)),
        BaseSurface::Cylinder(cylinder) => Box::new(CylinderModel::new(cylinder)),
        BaseSurface::Cone(cone) => Box::new(ConeModel::new(cone)),
    }
}

/// Most rows that are kept as they are.
const MOST_ROWS: usize = 20_000;

/// Rows that are folded at once where there are more; with their residuals they fit into the cache.
const BLOCK: usize = 1024;

/// Σ w h², as residuals √w h.
struct Problem<'a> {
    model: &'a mut dyn Model,
    samples: &'a Samples,
    /// Samples of positive weight, and the roots of their weights.
    rows: Vec<(usize, f64)>,
    /// See [`Problem::folded`].
    folded: OnceCell<DMatrix<f64>>,
}

impl<'a> Problem<'a> {
    fn new(model: &'a mut dyn Model, samples: &'a Samples, rows: Vec<(usize, f64)>) -> Self {
        Self {
            model,
            samples,
            rows,
            folded: OnceCell::new(),
        }
    }

    /// Of many rows, the Jacobian at the present parameters and the residuals as its last column,
    /// blocks of rows replaced by the triangular factors of their QR decompositions (Demmel, Grigori,
    /// Hoemmen & Langou 2012): the linearised sum of squares is the same.
    fn folded(&self) -> Option<&DMatrix<f64>> {
        let (model, samples) = (&*self.model, self.samples);
        let fold = |rows: &[(usize, f64)]| {
            let mut block = jacobian(model, samples, rows);
            let last = block.ncols();
            block = block.insert_column(last, 0.0);
            block.set_column(last, &residuals(model, samples, rows));
            block.qr().unpack_r()
        };
        (self.rows.len() > MOST_ROWS).then(|| {
            self.folded
                .get_or_init(|| stacked(self.rows.par_chunks(BLOCK).map(fold).collect()))
        })
    }
}

/// The blocks' rows under each other.
fn stacked(blocks: Vec<DMatrix<f64>>) -> DMatrix<f64> {
    let height = blocks.iter().map(DMatrix::nrows).sum();
    let mut all = DMatrix::zeros(height, blocks.first().map_or(0, DMatrix::ncols));
    let mut start = 0;
    for block in blocks {
        all.rows_mut(start, block.nrows()).copy_from(&block);
        start += block.nrows();
    }
    all
}

fn residuals(model: &dyn Model, samples: &Samples, rows: &[(usize, f64)]) -> DVector<f64> {
    let heights = rows
        .iter()
        .map(|&(i, root)| root * model.height(&samples.points[i]));
    DVector::from_iterator(rows.len(), heights)
}

fn jacobian(model: &dyn Model, samples: &Samples, rows: &[(usize, f64)]) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(rows.len(), model.params().len());
    let mut gradient = vec![0.0; model.params().len()];
    for (row, &(i, root)) in rows.iter().enumerate() {
        model.gradient(&samples.points[i], &mut gradient);
        for (column, g) in gradient.iter().enumerate() {
            jacobian[(row, column)] = root * g;
        }
    }
    jacobian
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ParameterStorage = Owned<f64, Dyn>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.model.set_params(x.as_slice());
        self.folded.take();
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_column_slice(self.model.params())
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(match self.folded() {
            Some(folded) => folded.column(folded.ncols() - 1).into_owned(),
            None => residuals(&*self.model, self.samples, &self.rows),
        })
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(match self.folded() {
            Some(folded) => folded.columns(0, folded.ncols() - 1).into_owned(),
            None => jacobian(&*self.model, self.samples, &self.rows),
        })
    }
}

/// Minimises Σ w h² from the model's present parameters, with the tolerance `tol` on parameters
/// and sum and at most about `steps` steps. Returns the evaluations and why they ended; the model
/// holds the best parameters.
pub(super) fn least_squares(
    model: &mut dyn Model,
    samples: &Samples,
    weights: &[f64],
    tol: f64,
    steps: usize,
) -> (usize, StopReason) {
    let rows: Vec<_> = (weights.iter().enumerate())
        .filter(|(_, w)| **w > 0.0)
        .map(|(i, w)| (i, w.sqrt()))
        .collect();
    let count = model.params().len();
    if rows.len() < count {
        return (0, StopReason::Numerical);
    }
    let before = model.params().to_vec();
    // The crate counts evaluations in units of parameters + 1.
    let patience = steps.div_ceil(count + 1).max(1);
    let problem = Problem::new(model, samples, rows);
    let (problem, report) = LevenbergMarquardt::new()
        .with_ftol(tol)
        .with_xtol(tol)
        .with_gtol(4.0 * f64::EPSILON)
        .with_patience(patience)
        .minimize(problem);
    let reason = match report.termination {
        TerminationReason::LostPatience => StopReason::IterationLimit,
        TerminationReason::Numerical(_)
        | TerminationReason::User(_)
        | TerminationReason::NoParameters
        | TerminationReason::NoResiduals
        | TerminationReason::WrongDimensions(_) => StopReason::Numerical,
        // "No improvement possible" means that rounding is the limit.
        TerminationReason::ResidualsZero
        | TerminationReason::Orthogonal
        | TerminationReason::Converged { .. }
        | TerminationReason::NoImprovementPossible(_) => StopReason::Converged,
    };
    if !problem.model.params().iter().all(|x| x.is_finite()) {
        problem.model.set_params(&before);
    }
    (report.number_of_evaluations, reason)
}

#[cfg(test)]
mod tests {
    use super::super::{Cone, Cylinder, Plane, Sphere};
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::{Unit, Vector3};

    fn starts() -> [BaseSurface; 4] {
        let axis = Unit::new_normalize(Vector3::new(0.3, -0.8, 0.4));
        let point = Point3::new(0.2, -0.1, 0.4);
        [
            BaseSurface::Plane(Plane {
                point,
                normal: axis,
            }),
            BaseSurface::Sphere(Sphere {
                center: point,
                radius: 0.8,
            }),
            BaseSurface::Cylinder(Cylinder {
                point,
                axis,
                radius: 0.7,
            }),
            BaseSurface::Cone(Cone {
                apex: point - axis.scale(1.5),
                axis,
                half_angle: 0.5,
            }),
        ]
    }

    fn points() -> Vec<Point3<f64>> {
        (0..20)
            .map(f64::from)
            .map(|i| Point3::new((1.7 * i).sin(), (2.3 * i + 0.4).sin(), (0.9 * i).cos()))
            .collect()
    }

    #[test]
    fn a_model_starts_at_its_surface() {
        for start in starts() {
            let model = model(&start);
            for p in points() {
                let height = start.foot(&p).height;
                assert_relative_eq!(model.height(&p), height, epsilon = 1e-13);
                let back = model.surface().foot(&p).height;
                assert_relative_eq!(back, height, epsilon = 1e-13);
            }
        }
    }

    #[test]
    fn gradients_match_numerical_differentiation() {
        for start in starts() {
            let mut model = model(&start);
            // Away from the start, where the frame is no longer aligned.
            let x: Vec<f64> = (model.params().iter().enumerate())
                .map(|(i, x)| x + 0.05 * (i as f64 + 1.0))
                .collect();
            let mut gradient = vec![0.0; x.len()];
            for p in points() {
                model.set_params(&x);
                model.gradient(&p, &mut gradient);
                for i in 0..x.len() {
                    let step = 1e-5;
                    let mut at = |d: f64| {
                        let mut y = x.clone();
                        y[i] += d;
                        model.set_params(&y);
                        model.height(&p)
                    };
                    // Fourth order, error about 1e-12.
                    let slope = (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step)))
                        / (12.0 * step);
                    assert_relative_eq!(gradient[i], slope, epsilon = 1e-9, max_relative = 1e-9);
                }
            }
        }
    }

    #[test]
    fn jacobians_match_the_crate_s_own_differentiation() {
        let samples = Samples {
            points: points(),
            normals: vec![Vector3::zeros(); 20],
            weights: vec![1.0; 20],
        };
        for start in starts() {
            let mut model = model(&start);
            let rows = (0..20).map(|i| (i, 1.0 + 0.1 * i as f64)).collect();
            let mut problem = Problem::new(model.as_mut(), &samples, rows);
            let analytic = problem.jacobian().unwrap();
            let numeric = levenberg_marquardt::differentiate_numerically(&mut problem).unwrap();
            assert_relative_eq!(analytic, numeric, epsilon = 1e-6);
        }
    }
}
