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

use super::sources::{Harmonic, HarmonicForces, HarmonicSource};
use crate::modal::CachedModel;
use crate::model::{Model, StructuralDamping};
use crate::scene::Node;

/// The matrices B_j.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Term {
    Constant,
    Structural,
    Rate,
    Gyroscopic,
    Inertia,
}

/// Number of matrices B_j.
pub const TERMS: usize = Term::Inertia as usize + 1;

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

/// A model with its sources and outputs, which depend on it.
pub struct HarmonicSystem<'a> {
    /// The model at the speed of the analysis.
    pub cached: &'a CachedModel,
    /// The sources.
    pub sources: &'a [HarmonicSource],
    /// The outputs.
    pub outputs: &'a HarmonicOutputs,
}

impl HarmonicSystem<'_> {
    /// Columns of the sources, with s₀, and rows of the outputs over the frequency, as [`over_frequency`].
    fn bordering(&self, speed: f64, scale: f64) -> Vec<Vec<(usize, [Complex64; TERMS])>> {
        let model = &self.cached.model;
        let of_source = |source: &HarmonicSource| {
            over_frequency(speed, scale, |at| {
                let integral = Complex64::new(0.0, at.frequency).powu(source.integrations());
                let force = source.force(model, at).unwrap_or_else(|| DVector::zeros(model.len()));
                let mut values = force.as_slice().to_vec();
                values.extend(self.outputs.offsets(model, at, source));
                values.iter().map(|value| value * integral).collect()
            })
        };
        let rows = |at: Harmonic| self.outputs.rows(model, at).iter().flat_map(|row| row.iter().copied()).collect();
        self.sources.iter().map(of_source).chain([over_frequency(speed, scale, rows)]).collect()
    }
}

/// The entries of B at a speed of the reference shaft, with the structural damping of shafts if it is given, less those of `base`,
/// a system with the same coordinates. Columns of sources and rows of outputs follow the n coordinates, which have the order and the
/// signs that users see. `scale` is the largest frequency in question, rad/s. The columns of a velocity or an acceleration of the
/// ground are those of the displacement. Modal damping is no part of them.
pub fn harmonic_terms(
    system: &HarmonicSystem<'_>,
    base: Option<&HarmonicSystem<'_>>,
    speed: f64,
    structural: Option<StructuralDamping>,
    scale: f64,
) -> Vec<Entry> {
    let model = &system.cached.model;
    let size = model.len();
    let mut places = vec![(0, 1.0); size];
    for (place, dof) in model.numbering.dofs().iter().enumerate() {
        places[dof.index] = (place, dof.sign);
    }
    let mut entries: Vec<Entry> = Vec::new();
    let mut add = |row: usize, column: usize, term: Term, value: Complex64| {
        let ((row, left), (column, right)) = (places[row], places[column]);
        entries.push((row, column, at_term(term, value * (left * right))));
    };
    let changes = model.matrix_changes(base.map(|base| (&base.cached.model, speed)), speed);
    let terms = [Term::Constant, Term::Structural, Term::Rate, Term::Gyroscopic, Term::Inertia];
    for (term, changes) in terms.into_iter().zip(changes) {
        let factor = if term == Term::Inertia { 1.0 } else { -1.0 };
        changes.into_iter().for_each(|(row, column, value)| add(row, column, term, Complex64::from(factor * value)));
    }
    for (system, factor) in [(Some(system), -1.0), (base, 1.0)] {
        let Some(system) = system else { continue };
        let lossy = structural.map(|damping| system.cached.model.structural_of_shafts(damping));
        for (row, column, value) in lossy.into_iter().flatten() {
            add(row, column, Term::Constant, value * factor);
        }
    }
    for (system, factor) in [(Some(system), 1.0), (base, -1.0)] {
        let Some(system) = system else { continue };
        for (index, values) in system.bordering(speed, scale).into_iter().enumerate() {
            for (place, values) in values {
                let is_source = index < system.sources.len();
                let (row, column) = if is_source { (place, size + index) } else { (size + place / size, place % size) };
                let moved = |index: usize| if index < size { places[index] } else { (index, 1.0) };
                let ((row, left), (column, right)) = (moved(row), moved(column));
                entries.push((row, column, values.map(|value| value * (factor * left * right))));
            }
        }
    }
    let mut found = summed(entries);
    if base.is_some() {
        found.retain(|(_, _, values)| *values != [Complex64::ZERO; TERMS]);
    }
    found
}

/// A value in one of the B_j.
fn at_term(term: Term, value: Complex64) -> [Complex64; TERMS] {
    std::array::from_fn(|own| if own == term as usize { value } else { Complex64::ZERO })
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
        values[Term::Constant as usize] = even[0] - inertia;
        values[Term::Structural as usize] = (odd[0] - rate) / Complex64::I;
        values[Term::Rate as usize] = rate / Complex64::new(0.0, scale);
        values[Term::Inertia as usize] = inertia / (scale * scale);
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

/// Entry of B without the B_j in which it is zero.
pub struct SparseEntry {
    row: usize,
    column: usize,
    /// Number of the B_j, and the entry.
    terms: Vec<(usize, Complex64)>,
}

impl From<Entry> for SparseEntry {
    fn from((row, column, values): Entry) -> Self {
        let terms = values.into_iter().enumerate().filter(|(_, value)| *value != Complex64::ZERO).collect();
        Self { row, column, terms }
    }
}

/// One motion e^{λt} with its adjoint solutions: a harmonic one, λ = iω, or a mode.
pub struct MotionPoint<'a> {
    /// λ, rad/s.
    pub rate: Complex64,
    /// Speed of the reference shaft, rad/s.
    pub speed: f64,
    /// Phasors x of each source, one after another.
    pub phasors: &'a [Complex64],
    /// Adjoint solutions y of each output, one after another.
    pub adjoint: &'a [Complex64],
    /// Factor 1/λⁿ of each source with n integrations.
    pub integrals: &'a [Complex64],
}

impl MotionPoint<'_> {
    /// The forms (yᵀ, eᵀ) B (x, e) for n coordinates, with the sources of an output next to each other.
    pub fn forms(&self, size: usize, entries: &[SparseEntry]) -> Vec<Complex64> {
        let Self { rate, speed, .. } = *self;
        let sign = if rate.im == 0.0 { 0.0 } else { rate.im.signum() };
        let weights = [Complex64::ONE, Complex64::new(0.0, sign), rate, rate * speed, -rate * rate];
        let (sources, outputs) = (self.phasors.len() / size, self.adjoint.len() / size);
        let mut forms = vec![Complex64::ZERO; sources * outputs];
        for SparseEntry { row, column, terms } in entries {
            let value: Complex64 = terms.iter().map(|(term, value)| value * weights[*term]).sum();
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
