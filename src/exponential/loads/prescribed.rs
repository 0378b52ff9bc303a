//! Loads that do not depend on the motion: a constant load without equilibrium, and bow and unbalance at resonance.

use nalgebra::DVector;

use super::rotating_source::is_resonant;
use crate::connection::{Interface, Row};
use crate::modal::ModalStateSpace;
use crate::model::{Dof, DofKind};
use crate::motion::{EquationOfMotion, RotatingLoad};

/// A residual load below this fraction of the loads at the reference is round-off.
const BALANCE_TOLERANCE: f64 = 1e-11;

/// A load that does not depend on the motion.
#[derive(Clone, Copy, Debug)]
pub(in crate::exponential) enum Prescribed {
    /// The value 1; its column holds the load.
    Constant,
    /// cos ϑ of a source.
    Cosine(usize),
    /// sin ϑ of a source.
    Sine(usize),
}

impl Prescribed {
    /// The value of the load at the elapsed time, s.
    pub fn value(self, sources: &[RotatingLoad], elapsed: f64) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Cosine(source) => sources[source].phasor(elapsed, None).re,
            Self::Sine(source) => sources[source].phasor(elapsed, None).im,
        }
    }
}

/// Loads that do not depend on the motion, with their columns b: the unbalanced constant load, and the excitation of
/// every shaft that has no synchronous motion.
pub(in crate::exponential) fn prescribed_loads(
    motion: &EquationOfMotion,
    linear: &ModalStateSpace,
    interfaces: &[Interface],
    entries: &[Row],
    reference: &DVector<f64>,
) -> (Vec<Prescribed>, Vec<Vec<f64>>) {
    let (mut prescribed, mut columns) = (Vec::new(), Vec::new());
    let constant = constant_load(motion, interfaces, entries, reference);
    if !constant.is_empty() {
        prescribed.push(Prescribed::Constant);
        columns.push(linear.column(&constant));
    }
    let sources = motion.sources().iter().enumerate();
    for (index, source) in sources.filter(|(_, source)| is_resonant(linear, source.spin)) {
        prescribed.extend([Prescribed::Cosine(index), Prescribed::Sine(index)]);
        columns.extend(source.columns().iter().map(|column| linear.column(column)));
    }
    (prescribed, columns)
}

/// Constant load that the forces at the reference do not balance, as entries (index, value); empty if they balance it.
fn constant_load(
    motion: &EquationOfMotion,
    interfaces: &[Interface],
    entries: &[Row],
    reference: &DVector<f64>,
) -> Row {
    let model = motion.model();
    let load = motion.constant_load();
    let mut residual = load.clone();
    let mut scale = load.map(f64::abs);
    let mut add = |index: usize, value: f64| {
        residual[index] += value;
        scale[index] += value.abs();
    };
    for (row, value) in model.static_force(reference).iter().enumerate() {
        add(row, -value);
    }
    let reference_force = interfaces.iter().flat_map(Interface::reference_force);
    for (entry, reference_force) in entries.iter().zip(reference_force) {
        for (index, factor) in entry {
            add(*index, factor * reference_force);
        }
    }
    // Forces and moments have different units. Each is compared with the largest of its kind.
    let kind = |dof: &Dof| match dof.kind {
        DofKind::Twist => 0,
        DofKind::V | DofKind::W | DofKind::B | DofKind::Gamma => 1,
        DofKind::Axial => 2,
        DofKind::Mode => 3,
    };
    let dofs = model.numbering.dofs();
    let mut sizes = [0.0_f64; 4];
    dofs.iter().for_each(|dof| sizes[kind(dof)] = sizes[kind(dof)].max(scale[dof.index]));
    let acts = dofs.iter().any(|dof| residual[dof.index].abs() > BALANCE_TOLERANCE * sizes[kind(dof)]);
    if acts { residual.iter().copied().enumerate().filter(|(_, value)| *value != 0.0).collect() } else { Vec::new() }
}
