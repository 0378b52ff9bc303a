//! Classification of modes: forward, backward or planar whirl, torsion, coupled or rigid-body motion.
//!
//! With the mode shape (V, W) of a node, its displacement v + iw is f e^{iωt} + b̄ e^{−iωt}, where |f| = |V + iW|/2 and
//! |b| = |V − iW|/2. Forward whirl has the direction of rotation of the shaft. The squares |f|² and |b|² are summed
//! over all nodes.

use std::fmt;

use nalgebra::{Complex, DVector};

use crate::model::{DofKind, Model};

/// A mode is torsional if bending holds less than this share of its kinetic energy, and a bending mode if torsion does.
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
    /// Rigid-body motion: λ = 0.
    Rigid,
    /// Bending and torsion coupled.
    Coupled,
}

impl fmt::Display for Whirl {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Forward => "forward",
            Self::Backward => "backward",
            Self::Planar => "planar",
            Self::Torsion => "torsion",
            Self::Rigid => "rigid",
            Self::Coupled => "coupled",
        })
    }
}

/// Classifies mode shapes of one model at one speed.
pub(super) struct Classifier<'m> {
    model: &'m Model,
    /// Speed of the reference shaft, rad/s.
    speed: f64,
    /// Whether each coordinate of the core belongs to bending, n entries.
    lateral: Vec<bool>,
}

impl<'m> Classifier<'m> {
    pub fn new(model: &'m Model, speed: f64) -> Self {
        let mut lateral = vec![false; model.len()];
        for dof in model.numbering.dofs() {
            lateral[dof.index] = dof.kind.is_lateral();
        }
        Self { model, speed, lateral }
    }

    /// Type of motion of the mode with `eigenvalue` λ, rad/s, and `shape` φ, n entries in the order of the core.
    pub fn classify(&self, eigenvalue: Complex<f64>, shape: &DVector<Complex<f64>>) -> Whirl {
        if eigenvalue == Complex::new(0.0, 0.0) {
            return Whirl::Rigid;
        }
        let bending = self.kinetic_energy(shape, true);
        let share = bending / (bending + self.kinetic_energy(shape, false));
        if share < MINOR_ENERGY {
            return Whirl::Torsion;
        }
        if share < 1.0 - MINOR_ENERGY {
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

    /// φᴴMφ over the coordinates of bending (`lateral`) or of torsion.
    fn kinetic_energy(&self, shape: &DVector<Complex<f64>>, lateral: bool) -> f64 {
        let quadratic_form = |part: fn(&Complex<f64>) -> f64| {
            let vector =
                DVector::from_fn(shape.len(), |i, _| if self.lateral[i] == lateral { part(&shape[i]) } else { 0.0 });
            self.model.kinetic_form(vector.as_slice())
        };
        quadratic_form(|value| value.re) + quadratic_form(|value| value.im)
    }
}
