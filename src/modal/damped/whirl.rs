//! Classification of modes: forward, backward or planar whirl, torsion, axial, coupled or rigid-body motion.
//!
//! With the mode shape (V, W) of a node, its displacement v + iw is f e^{iωt} + b̄ e^{−iωt}, where |f| = |V + iW|/2 and
//! |b| = |V − iW|/2. Forward whirl has the direction of rotation of the shaft. The squares |f|² and |b|² are summed
//! over all nodes.

use std::fmt;

use nalgebra::{Complex, DVector};

use crate::model::{DofKind, Model};

/// A mode is one of bending, of torsion or of axial motion if the others hold less than this share of its kinetic energy.
const MINOR_ENERGY: f64 = 0.05;
/// An orbit is planar if its forward and backward parts |f|², |b|² differ by less than this share of their sum.
const PLANAR: f64 = 1e-6;

/// Type of motion of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whirl {
    /// Bending; the orbits have the direction of rotation of the shafts.
    Forward,
    /// Bending; the orbits have the opposite direction.
    Backward,
    /// Bending in a plane, bending without oscillation, or bending at speed zero.
    Planar,
    /// Torsion.
    Torsion,
    /// Axial motion.
    Axial,
    /// Rigid-body motion: λ = 0.
    Rigid,
    /// Bending, torsion or axial motion coupled.
    Coupled,
}

impl Whirl {
    /// Names of all types, in the order of the variants.
    pub const NAMES: [&str; Whirl::Coupled as usize + 1] =
        ["forward", "backward", "planar", "torsion", "axial", "rigid", "coupled"];
}

impl fmt::Display for Whirl {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(Self::NAMES[*self as usize])
    }
}

/// Classifies mode shapes of one model at one speed.
pub(in crate::modal) struct Classifier<'m> {
    model: &'m Model,
    /// Speed of the reference shaft, rad/s.
    speed: f64,
    /// Motion that each coordinate of the core describes, n entries.
    kinds: Vec<DofKind>,
}

impl<'m> Classifier<'m> {
    pub fn new(model: &'m Model, speed: f64) -> Self {
        let mut kinds = vec![DofKind::Twist; model.len()];
        for dof in model.numbering.dofs() {
            kinds[dof.index] = dof.kind;
        }
        Self { model, speed, kinds }
    }

    /// Type of motion of the mode with `eigenvalue` λ, rad/s, and `shape` φ, n entries in the order of the core.
    pub fn classify(&self, eigenvalue: Complex<f64>, shape: &DVector<Complex<f64>>) -> Whirl {
        if eigenvalue == Complex::new(0.0, 0.0) {
            return Whirl::Rigid;
        }
        let bending = self.kinetic_energy(shape, DofKind::is_lateral);
        let torsion = self.kinetic_energy(shape, |kind| kind == DofKind::Twist);
        let along =
            if self.model.scene.axial { self.kinetic_energy(shape, |kind| kind == DofKind::Axial) } else { 0.0 };
        let total = bending + torsion + along;
        if (bending + along) / total < MINOR_ENERGY {
            return Whirl::Torsion;
        }
        if (bending + torsion) / total < MINOR_ENERGY {
            return Whirl::Axial;
        }
        if bending / total < 1.0 - MINOR_ENERGY {
            return Whirl::Coupled;
        }
        let (mut forward, mut backward) = (0.0, 0.0);
        for dof in self.model.numbering.nodal_dofs().iter().filter(|dof| dof.kind == DofKind::V) {
            let (v, w) = (shape[dof.index], shape[dof.index + 1]);
            let rotated = w * Complex::i();
            let (positive, negative) = ((v + rotated).norm_sqr(), (v - rotated).norm_sqr());
            let spins_backward = self.model.shafts[dof.node.shaft].ratio * self.speed < 0.0;
            forward += if spins_backward { negative } else { positive };
            backward += if spins_backward { positive } else { negative };
        }
        let planar = (forward - backward).abs() <= PLANAR * (forward + backward);
        if self.speed == 0.0 || eigenvalue.im == 0.0 || planar {
            Whirl::Planar
        } else if forward > backward {
            Whirl::Forward
        } else {
            Whirl::Backward
        }
    }

    /// φᴴMφ over the coordinates of some kinds.
    fn kinetic_energy(&self, shape: &DVector<Complex<f64>>, included: fn(DofKind) -> bool) -> f64 {
        let quadratic_form = |part: fn(&Complex<f64>) -> f64| {
            let vector =
                DVector::from_fn(shape.len(), |i, _| if included(self.kinds[i]) { part(&shape[i]) } else { 0.0 });
            self.model.kinetic_form(vector.as_slice())
        };
        quadratic_form(|value| value.re) + quadratic_form(|value| value.im)
    }
}
