//! Classification of modes: forward, backward, mixed or planar whirl, torsion, axial, coupled or rigid-body motion.
//!
//! With the mode shape (V, W) of a node, its displacement v + iw is f e^{iωt} + b̄ e^{−iωt}, where |f| = |V + iW|/2 and
//! |b| = |V − iW|/2. Forward whirl has the direction of rotation of the shaft. A mode is forward or backward if all of its orbits are,
//! apart from small ones, and mixed otherwise.

use std::fmt;

use nalgebra::{Complex, DVector};

use crate::model::{Dof, DofKind, Model};

/// Share that does not decide: a mode is one of bending, of torsion or of axial motion if the others hold less of its kinetic energy,
/// and an orbit with a smaller share of |f|² − |b|² in |f|² + |b|² is as good as a line.
const MINOR_SHARE: f64 = 0.05;
/// An orbit is planar if its forward and backward parts |f|², |b|² differ by less than this share of their sum.
const PLANAR: f64 = 1e-6;
/// Orbits whose semi-major axis is below this part of the largest one do not decide about the direction.
const SMALL_ORBIT: f64 = 0.1;

/// Type of motion of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whirl {
    /// Bending; the orbits have the direction of rotation of the shafts.
    Forward,
    /// Bending; the orbits have the opposite direction.
    Backward,
    /// Bending; the orbits have the direction of rotation at one part of the shafts, the opposite one at another.
    Mixed,
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
        ["forward", "backward", "mixed", "planar", "torsion", "axial", "rigid", "coupled"];
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
        if (bending + along) / total < MINOR_SHARE {
            return Whirl::Torsion;
        }
        if (bending + torsion) / total < MINOR_SHARE {
            return Whirl::Axial;
        }
        if bending / total < 1.0 - MINOR_SHARE {
            return Whirl::Coupled;
        }
        let orbit = |dof: &Dof| {
            let (v, w) = (shape[dof.index], shape[dof.index + 1]);
            let rotated = w * Complex::i();
            let parts = [(v + rotated).norm_sqr(), (v - rotated).norm_sqr()];
            let spins_backward = self.model.shafts[dof.node.shaft].ratio * self.speed < 0.0;
            if spins_backward { [parts[1], parts[0]] } else { parts }
        };
        let nodes = self.model.numbering.nodal_dofs();
        let orbits: Vec<[f64; 2]> = nodes.iter().filter(|dof| dof.kind == DofKind::V).map(orbit).collect();
        let sum = |part: usize| orbits.iter().map(|orbit| orbit[part]).sum::<f64>();
        let (forward, backward) = (sum(0), sum(1));
        let is_planar = (forward - backward).abs() <= PLANAR * (forward + backward);
        if self.speed == 0.0 || eigenvalue.im == 0.0 || is_planar {
            return Whirl::Planar;
        }
        let axis = |[forward, backward]: [f64; 2]| forward.sqrt() + backward.sqrt();
        let largest = orbits.iter().map(|orbit| axis(*orbit)).fold(0.0, f64::max);
        let deciding = orbits.iter().filter(|orbit| axis(**orbit) > SMALL_ORBIT * largest);
        let sense = |[forward, backward]: &[f64; 2]| (forward - backward) / (forward + backward);
        let has = |sign: f64| deciding.clone().any(|orbit| sign * sense(orbit) > MINOR_SHARE);
        match (has(1.0), has(-1.0)) {
            (true, true) => Whirl::Mixed,
            _ if forward > backward => Whirl::Forward,
            _ => Whirl::Backward,
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
