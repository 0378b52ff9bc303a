//! What the derivatives of harmonic responses and of the static equilibrium need.

use std::sync::Arc;

use nalgebra::{Complex, DMatrix, DVector};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use super::convert::{stack, table};
use super::errors::caught;
use super::frequency::{finite_speeds, harmonic_sources};
use super::handle::PyModel;
use super::state::mesh_geometry;
use crate::analysis::simulate::System;
use crate::analysis::{
    self, AnalysisError, Dense, FrequencyResponses, Harmonic, HarmonicOutputs, HarmonicSource, HarmonicSystem,
    MotionPoint, SparseEntry, TERMS,
};
use crate::modal::{DampedMotions, EquilibriumChange, Highest, NullVectors};
use crate::model::{Model, StructuralDamping};
use crate::scene::SceneError;

/// Rows, columns and entries (places, terms) of B.
pub type Terms<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray2<Complex<f64>>>);

/// Outputs of a harmonic response: factors of the displacements (outputs, n), or "bearing" or "mesh" and its number in the
/// results.
#[derive(FromPyObject)]
pub enum Outputs<'py> {
    Motion(PyReadonlyArray2<'py, Complex<f64>>),
    Force(String, usize),
}

impl Outputs<'_> {
    fn parse(&self, model: &Model) -> Result<HarmonicOutputs, SceneError> {
        match self {
            Self::Motion(rows) => {
                let row = |row: numpy::ndarray::ArrayView1<'_, Complex<f64>>| {
                    let mut inside = DVector::zeros(model.len());
                    let dofs = model.numbering.dofs().iter().zip(row);
                    dofs.for_each(|(dof, value)| inside[dof.index] = value * dof.sign);
                    inside
                };
                Ok(HarmonicOutputs::Motion(rows.as_array().outer_iter().map(row).collect()))
            }
            Self::Force(kind, index) if kind == "bearing" => {
                let nodes = model.scene.bearing_nodes();
                let node = nodes.get(*index).ok_or_else(|| SceneError::new("at", "there is no such bearing"))?;
                Ok(HarmonicOutputs::Bearing(*node))
            }
            Self::Force(_, index) => Ok(HarmonicOutputs::Mesh(*index)),
        }
    }
}

/// A system that a harmonic response has, with what excites and measures it.
struct Given {
    cached: Arc<System>,
    sources: Vec<HarmonicSource>,
    outputs: HarmonicOutputs,
}

impl Given {
    fn new(model: &PyModel, sources: &Bound<'_, PyAny>, outputs: &Outputs<'_>) -> PyResult<Self> {
        let (sources, outputs) = (harmonic_sources(model.model(), sources)?, outputs.parse(model.model())?);
        Ok(Self { cached: Arc::clone(&model.cached), sources, outputs })
    }
}

/// Right and left vectors of an eigenvalue with its slopes.
#[derive(IntoPyObject)]
pub struct Vectors<'py> {
    /// Right vectors (count, n).
    right: Bound<'py, PyArray2<Complex<f64>>>,
    /// Left vectors (count, n).
    left: Bound<'py, PyArray2<Complex<f64>>>,
    /// Products yᵀ ∂S/∂λ x (count, count).
    slopes: Bound<'py, PyArray2<Complex<f64>>>,
    /// Whether further vectors have an equal eigenvalue.
    has_more: bool,
    /// Whether the right vectors satisfy the equations of motion.
    is_accurate: bool,
}

/// Undamped modes for derivatives of modal damping.
#[derive(IntoPyObject)]
pub struct Motions<'py> {
    /// Shapes Φ (m, n), orthonormal in M.
    shapes: Bound<'py, PyArray2<f64>>,
    /// Momenta MΦ (m, n).
    momenta: Bound<'py, PyArray2<f64>>,
    /// Squares of the frequencies (m,), 1/s².
    squares: Bound<'py, PyArray1<f64>>,
    /// Number of modes with damping.
    damped: usize,
}

/// yᵀB(λ, Ω)x, shape (points, outputs, sources), of adjoint solutions y, shape (points, outputs, n), and phasors x, shape (points,
/// sources, n), at rates λ of the motions e^{λt} and speeds Ω, rad/s. `entries` are rows, columns and terms of the sparse matrix B, and
/// `integrations` how often each source is integrated over time.
#[pyfunction]
pub fn motion_forms<'py>(
    py: Python<'py>,
    rates: PyReadonlyArray1<'py, Complex<f64>>,
    speeds: PyReadonlyArray1<'py, f64>,
    entries: (PyReadonlyArray1<'py, i64>, PyReadonlyArray1<'py, i64>, PyReadonlyArray2<'py, Complex<f64>>),
    adjoint: PyReadonlyArray3<'py, Complex<f64>>,
    phasors: PyReadonlyArray3<'py, Complex<f64>>,
    integrations: Vec<i32>,
) -> PyResult<Bound<'py, PyArray3<Complex<f64>>>> {
    let (outputs, sources, size) = (adjoint.shape()[1], phasors.shape()[1], adjoint.shape()[2]);
    let (rows, columns, values) = &entries;
    let places = rows.as_array().to_vec().into_iter().zip(columns.as_array().to_vec());
    let entries: Vec<SparseEntry> = places
        .zip(values.as_slice()?.chunks_exact(TERMS))
        .map(|((row, column), values)| (row as usize, column as usize, std::array::from_fn(|term| values[term])).into())
        .collect();
    let (rates, speeds) = (rates.as_array(), speeds.as_array());
    let count = rates.len();
    let points = adjoint.as_slice()?.chunks_exact((outputs * size).max(1));
    let points = points.zip(phasors.as_slice()?.chunks_exact((sources * size).max(1)));
    let mut forms = Vec::with_capacity(count * outputs * sources);
    for ((rate, speed), (adjoint, phasors)) in rates.iter().zip(&speeds).zip(points) {
        let (rate, speed) = (*rate, *speed);
        let integrals: Vec<_> = integrations.iter().map(|times| rate.powi(-times)).collect();
        forms.extend(MotionPoint { rate, speed, phasors, adjoint, integrals: &integrals }.forms(size, &entries));
    }
    stack(py, forms, count, outputs, sources)
}

#[pymethods]
impl PyModel {
    /// Entries of the equations and outputs of a harmonic response at a rate (real and imaginary part) and a speed, with a largest
    /// frequency, rad/s: rows, columns and the entries of each matrix; less those of `base`, another model with its outputs.
    #[pyo3(signature = (at, scale, sources, outputs, base=None))]
    fn harmonic_terms<'py>(
        &self,
        py: Python<'py>,
        at: (f64, f64, f64),
        scale: f64,
        sources: &Bound<'py, PyAny>,
        outputs: Outputs<'py>,
        base: Option<(Bound<'py, Self>, Outputs<'py>)>,
    ) -> PyResult<Terms<'py>> {
        let (rate, speed) = (Complex::new(at.0, at.1), at.2);
        let given = Given::new(self, sources, &outputs)?;
        let base = base.map(|(base, outputs)| Given::new(base.get(), sources, &outputs)).transpose()?;
        Dense::Bands.require(self.model())?;
        let terms = || -> Result<_, AnalysisError> {
            let at_speed = given.cached.at_speed(speed)?;
            let base_at_speed = base.as_ref().map(|base| base.cached.at_speed(speed)).transpose()?;
            let system = HarmonicSystem { cached: &at_speed, sources: &given.sources, outputs: &given.outputs };
            let base = base.as_ref().zip(base_at_speed.as_ref());
            let base = base.map(|(Given { sources, outputs, .. }, cached)| HarmonicSystem { cached, sources, outputs });
            // A motion that decays without oscillation has no structural damping.
            let oscillates = rate.im != 0.0 || rate.re == 0.0;
            let structural = oscillates.then_some(StructuralDamping { frequency: rate.im, speed });
            Ok(analysis::harmonic_terms(&system, base.as_ref(), speed, structural, scale))
        };
        let found = py.detach(|| caught(terms))??;
        let integers = |values: Vec<i64>| values.into_pyarray(py);
        let rows = integers(found.iter().map(|(row, _, _)| *row as i64).collect());
        let columns = integers(found.iter().map(|(_, column, _)| *column as i64).collect());
        let values = found.iter().flat_map(|(_, _, values)| *values).collect();
        Ok((rows, columns, table(py, values, found.len(), TERMS)?))
    }

    /// `count` right and left vectors of an eigenvalue (real and imaginary part) at a speed, with the modal damping for a highest
    /// frequency, all rad/s.
    fn null_vectors<'py>(
        &self,
        py: Python<'py>,
        eigenvalue: (f64, f64),
        speed: f64,
        count: usize,
        highest: f64,
    ) -> PyResult<Vectors<'py>> {
        let eigenvalue = Complex::new(eigenvalue.0, eigenvalue.1);
        let found = self.run(py, Dense::Bands, move |cached, _| -> Result<_, AnalysisError> {
            Ok(NullVectors::new(&*cached.at_speed(speed)?, eigenvalue, speed, count, highest)?)
        })?;
        let numbering = &self.model().numbering;
        let shapes = |vectors: &[DVector<Complex<f64>>]| {
            let values = vectors.iter().flat_map(|vector| numbering.to_user_order(vector.as_slice())).collect();
            table(py, values, vectors.len(), numbering.len())
        };
        let slopes = found.slopes.transpose().as_slice().to_vec();
        Ok(Vectors {
            right: shapes(&found.right)?,
            left: shapes(&found.left)?,
            slopes: table(py, slopes, found.left.len(), found.right.len())?,
            has_more: found.has_more,
            is_accurate: found.residual.is_accurate(),
        })
    }

    /// The undamped modes at a speed whose damping counts up to a highest frequency, both rad/s.
    fn damped_motions<'py>(&self, py: Python<'py>, speed: f64, highest: f64) -> PyResult<Motions<'py>> {
        let found = self.run(py, Dense::Bands, move |cached, _| -> Result<_, AnalysisError> {
            let cached = cached.at_speed(speed)?;
            Ok(cached.damped_modes(speed, Highest::Frequency(highest))?.motions(&cached.model, speed)?)
        })?;
        let numbering = &self.model().numbering;
        let rows = |columns: &DMatrix<f64>| {
            let values = columns.column_iter().flat_map(|column| numbering.to_user_order(column.as_slice())).collect();
            table(py, values, columns.ncols(), numbering.len())
        };
        let (shapes, momenta) = (rows(&found.shapes)?, rows(&found.momenta)?);
        Ok(Motions { shapes, momenta, squares: found.squares.into_pyarray(py), damped: found.damped })
    }

    /// Rates 2ζω, 1/s, of the modal damping of this system for modes with these ω², 1/s².
    fn damping_rates<'py>(&self, py: Python<'py>, squares: PyReadonlyArray1<'_, f64>) -> Bound<'py, PyArray1<f64>> {
        let squares = squares.as_array().to_vec();
        DampedMotions::rates(&self.model().scene.modal_damping, &squares).into_pyarray(py)
    }

    /// Adjoint solutions (pairs, outputs, n) at pairs of a frequency and a speed.
    fn harmonic_adjoint<'py>(
        &self,
        py: Python<'py>,
        frequencies: PyReadonlyArray1<'py, f64>,
        speeds: PyReadonlyArray1<'py, f64>,
        outputs: Outputs<'py>,
    ) -> PyResult<Bound<'py, PyArray3<Complex<f64>>>> {
        let (frequencies, speeds) = (frequencies.as_array().to_vec(), finite_speeds(&speeds)?);
        let assembled = self.model();
        let outputs = outputs.parse(assembled)?;
        let memory = analysis::memory_of_responses(assembled);
        let (rows, size) = (frequencies.len(), assembled.len());
        let found = self.run(py, memory, move |cached, interrupt| {
            let responses = FrequencyResponses::new(cached, "frequencies", frequencies.iter().copied());
            let mut found = Vec::new();
            for (index, (frequency, speed)) in frequencies.iter().zip(&speeds).enumerate() {
                interrupt.check()?;
                let at = Harmonic { frequency: *frequency, speed: *speed };
                for solution in responses.adjoint(index, at, &outputs)? {
                    found.extend(cached.model.numbering.to_user_order(solution.phasors.as_slice()));
                }
            }
            Ok::<_, AnalysisError>(found)
        })?;
        let count = found.len() / (rows * size).max(1);
        stack(py, found, rows, count, size)
    }

    /// Changes of the equilibrium `state` under small forces, (forces, n).
    fn static_changes<'py>(
        &self,
        py: Python<'py>,
        geometry: &str,
        speed: f64,
        state: PyReadonlyArray1<'py, f64>,
        forces: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let geometry = mesh_geometry(geometry)?;
        let numbering = &self.model().numbering;
        let inside = |values: &[f64]| DVector::from_vec(numbering.in_core_order(values));
        let state = inside(state.as_slice()?);
        let size = state.len();
        let forces: Vec<_> = forces.as_slice()?.chunks_exact(size.max(1)).map(inside).collect();
        let at_speed = self.cached.at(speed, 0.0)?;
        let change = EquilibriumChange::new(&at_speed.model, geometry, speed.into(), state);
        let found = change.and_then(|change| change.under(&forces)).map_err(AnalysisError::from)?;
        let values = found.iter().flat_map(|change| numbering.to_user_order(change.as_slice())).collect();
        table(py, values, found.len(), size)
    }
}
