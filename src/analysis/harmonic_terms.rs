//! The equations of a harmonic response and its outputs over the frequency, for derivatives with respect to parameters.
//!
//! S x = f and the outputs s = R x + s₀ are one matrix
//!
//! ```text
//! B = [ −S  f  ]      B(ω, Ω) = B₀ + i sgn(ω) B₁ + iω B₂ + iωΩ B₃ + ω² B₄
//!     [  R  s₀ ]
//! ```
//!
//! with constant matrices B_j at one state of the bearings, and of the signs of the frequency relative to shafts with a loss factor,
//! whose structural damping is a part of B₀. With y of Sᵀ y = Rᵀ, the derivative of an output with respect to a
//! parameter p is (yᵀ, eᵀ) dB/dp (x, e), where the unit vectors e select an output and a source (adjoint method; M. B. Giles and
//! N. A. Pierce, Flow, Turbulence and Combustion 65, 2000).

use nalgebra::DVector;
use num_complex::Complex64;

use super::AnalysisError;
use super::sources::{Harmonic, HarmonicForces, HarmonicSource};
use crate::modal::CachedModel;
use crate::model::{Model, StructuralDamping};
use crate::scene::Node;

/// Number of matrices B_j.
pub const TERMS: usize = 5;
const CONSTANT: usize = 0;
const STRUCTURAL: usize = 1;
const RATE: usize = 2;
const GYROSCOPIC: usize = 3;
const INERTIA: usize = 4;

/// Entry of B: row, column, and the entry of each B_j.
pub type Entry = (usize, usize, [Complex64; TERMS]);

/// Outputs of a harmonic response.
#[derive(Clone, Debug)]
pub enum HarmonicOutputs {
    /// Sums of displacements, with n factors each in the order of the core.
    Motion(Vec<DVector<Complex64>>),
    /// Force over (y, z) of the shaft on its bearings at a node.
    Bearing(Node),
    /// Force of a mesh.
    Mesh(usize),
}

impl HarmonicOutputs {
    /// Rows of R, n entries each.
    pub(super) fn rows(&self, model: &Model, at: Harmonic) -> Vec<DVector<Complex64>> {
        let forces = HarmonicForces { model, at, source: None, phasors: &[] };
        let dense = |row: Vec<(usize, Complex64)>| {
            let mut dense = DVector::zeros(model.len());
            row.into_iter().for_each(|(index, value)| dense[index] += value);
            dense
        };
        match self {
            Self::Motion(rows) => rows.clone(),
            Self::Bearing(node) => forces.bearing_rows(*node).map(dense).to_vec(),
            Self::Mesh(mesh) => vec![dense(forces.mesh_row(*mesh))],
        }
    }

    /// s₀ of a source.
    fn offsets(&self, model: &Model, at: Harmonic, source: &HarmonicSource) -> Vec<Complex64> {
        let phasors = vec![Complex64::ZERO; model.len()];
        let forces = HarmonicForces { model, at, source: Some(source), phasors: &phasors };
        match self {
            Self::Motion(rows) => vec![Complex64::ZERO; rows.len()],
            Self::Bearing(node) => forces.bearing(*node).to_vec(),
            Self::Mesh(mesh) => forces.meshes().skip(*mesh).take(1).collect(),
        }
    }
}

/// The entries of B at a speed of the reference shaft and, for the loss factors of shafts, a frequency. Columns of sources and rows of outputs follow the n coordinates, which
/// have the order and the signs that users see. `scale` is the largest frequency in question, rad/s. The columns of a velocity or
/// an acceleration of the ground are those of the displacement.
///
/// # Errors
/// [`AnalysisError`] if a bearing has no coefficients at the speed, or modal damping has no modes.
pub fn harmonic_terms(
    cached: &CachedModel,
    Harmonic { frequency, speed }: Harmonic,
    scale: f64,
    sources: &[HarmonicSource],
    outputs: &HarmonicOutputs,
) -> Result<Vec<Entry>, AnalysisError> {
    let cached = &*cached.at_speed(speed)?;
    let model = &cached.model;
    let size = model.len();
    let mut places = vec![(0, 1.0); size];
    for (place, dof) in model.numbering.dofs().iter().enumerate() {
        places[dof.index] = (place, dof.sign);
    }
    let mut entries: Vec<Entry> = Vec::new();
    let mut add_matrix = |matrix: crate::linalg::Sparse, term: usize, factor: f64| {
        matrix.for_each(|row, column, value| {
            let ((row, left), (column, right)) = (places[row], places[column]);
            entries.push((row, column, at_term(term, Complex64::from(factor * left * right * value))));
        });
    };
    add_matrix(model.sparse_stiffness(speed), CONSTANT, -1.0);
    add_matrix(model.sparse_structural(speed), STRUCTURAL, -1.0);
    add_matrix(model.sparse_damping(speed), RATE, -1.0);
    add_matrix(model.sparse_gyroscopic(), GYROSCOPIC, -1.0);
    add_matrix(model.sparse_mass(), INERTIA, 1.0);
    for (row, column, value) in model.structural_of_shafts(StructuralDamping { frequency, speed }) {
        let ((row, left), (column, right)) = (places[row], places[column]);
        entries.push((row, column, at_term(CONSTANT, -value * left * right)));
    }
    if let Some(modal) = cached.modal_damping_matrix(speed)? {
        for (column, values) in modal.column_iter().enumerate() {
            for (row, value) in values.iter().enumerate() {
                let ((row, left), (column, right)) = (places[row], places[column]);
                entries.push((row, column, at_term(RATE, Complex64::from(-left * right * value))));
            }
        }
    }
    for (index, source) in sources.iter().enumerate() {
        let force = |at: Harmonic| {
            let integral = Complex64::new(0.0, at.frequency).powu(source.integrations());
            let mut values = source.force(model, at);
            values.extend(outputs.offsets(model, at, source));
            values.iter().map(|value| value * integral).collect()
        };
        for (row, values) in over_frequency(speed, scale, force) {
            let (row, sign) = if row < size { places[row] } else { (row, 1.0) };
            entries.push((row, size + index, values.map(|value| value * sign)));
        }
    }
    let rows = |at: Harmonic| outputs.rows(model, at).iter().flat_map(|row| row.iter().copied()).collect();
    for (place, values) in over_frequency(speed, scale, rows) {
        let (column, sign) = places[place % size];
        entries.push((size + place / size, column, values.map(|value| value * sign)));
    }
    Ok(summed(entries))
}

/// A value in one of the B_j.
fn at_term(term: usize, value: Complex64) -> [Complex64; TERMS] {
    std::array::from_fn(|own| if own == term { value } else { Complex64::ZERO })
}

/// Constant, structural, damping and inertia parts of values over the frequency, from two frequencies of either sign; places
/// with values that are zero are left out.
fn over_frequency(
    speed: f64,
    scale: f64,
    evaluate: impl Fn(Harmonic) -> Vec<Complex64>,
) -> Vec<(usize, [Complex64; TERMS])> {
    let at = |factor: f64| evaluate(Harmonic { frequency: factor * scale, speed });
    let (once, twice, back, back_twice) = (at(1.0), at(2.0), at(-1.0), at(-2.0));
    let mut found = Vec::new();
    for place in 0..once.len() {
        let even = [(once[place] + back[place]) * 0.5, (twice[place] + back_twice[place]) * 0.5];
        let odd = [(once[place] - back[place]) * 0.5, (twice[place] - back_twice[place]) * 0.5];
        if even == [Complex64::ZERO; 2] && odd == [Complex64::ZERO; 2] {
            continue;
        }
        let inertia = (even[1] - even[0]) / 3.0;
        let rate = odd[1] - odd[0];
        let mut values = [Complex64::ZERO; TERMS];
        values[CONSTANT] = even[0] - inertia;
        values[STRUCTURAL] = (odd[0] - rate) / Complex64::I;
        values[RATE] = rate / Complex64::new(0.0, scale);
        values[INERTIA] = inertia / (scale * scale);
        found.push((place, values));
    }
    found
}

/// The sums of entries of one place, in order.
fn summed(mut entries: Vec<Entry>) -> Vec<Entry> {
    entries.sort_by_key(|(row, column, _)| (*row, *column));
    let mut sums: Vec<Entry> = Vec::with_capacity(entries.len());
    for (row, column, values) in entries {
        match sums.last_mut() {
            Some(last) if (last.0, last.1) == (row, column) => {
                last.2.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            }
            _ => sums.push((row, column, values)),
        }
    }
    sums
}

/// One harmonic motion with its adjoint solutions.
pub struct HarmonicPoint<'a> {
    /// Frequency and speed.
    pub at: Harmonic,
    /// Phasors x of each source, one after another.
    pub phasors: &'a [Complex64],
    /// Adjoint solutions y of each output, one after another.
    pub adjoint: &'a [Complex64],
    /// Factor 1/(iω)ⁿ of each source with n integrations.
    pub integrals: &'a [Complex64],
}

impl HarmonicPoint<'_> {
    /// The forms (yᵀ, eᵀ) B (x, e) for n coordinates, with the sources of an output next to each other.
    pub fn forms(&self, size: usize, entries: &[Entry]) -> Vec<Complex64> {
        let Harmonic { frequency, speed } = self.at;
        let sign = if frequency == 0.0 { 0.0 } else { frequency.signum() };
        let rate = Complex64::new(0.0, frequency);
        let weights =
            [Complex64::ONE, Complex64::new(0.0, sign), rate, rate * speed, Complex64::from(frequency * frequency)];
        let (sources, outputs) = (self.phasors.len() / size, self.adjoint.len() / size);
        let mut forms = vec![Complex64::ZERO; sources * outputs];
        for (row, column, values) in entries {
            let value: Complex64 = values.iter().zip(&weights).map(|(value, weight)| value * weight).sum();
            let (first_output, last_output) = if *row < size { (0, outputs) } else { (row - size, row - size + 1) };
            let (first_source, last_source) =
                if *column < size { (0, sources) } else { (column - size, column - size + 1) };
            for output in first_output..last_output {
                let left = if *row < size { self.adjoint[output * size + row] } else { Complex64::ONE };
                for source in first_source..last_source {
                    let right =
                        if *column < size { self.phasors[source * size + column] } else { self.integrals[source] };
                    forms[output * sources + source] += left * value * right;
                }
            }
        }
        forms
    }
}
