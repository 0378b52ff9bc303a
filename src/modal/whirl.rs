//! What kind of motion a mode is.

use std::fmt;

use nalgebra::{Complex, DMatrix, DVector};

use super::damped::kinetic;
use crate::model::{DofKind, Model};

/// The kind of motion of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whirl {
    /// Bending that circles with the spin of the shafts.
    Forward,
    /// Bending that circles against it.
    Backward,
    /// Bending in a plane, or no spin to compare with.
    Planar,
    /// Twist.
    Torsion,
    /// A motion without stiffness.
    Rigid,
    /// Bending and twist together.
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

/// A mode with less than this part of its kinetic energy in bending (in twist) is one of twist (of bending).
const MINOR: f64 = 0.05;
/// Orbits whose forward and backward parts differ by less than this part are lines.
const PLANAR: f64 = 1e-6;

/// Names a mode by where its kinetic energy is and which way its orbits turn.
///
/// The displacement v + iw of a point is f e^{iωt} + b̄ e^{−iωt} with |f| = |V + iW|/2 and |b| = |V − iW|/2; forward
/// is the sense of the shaft's own spin. The translational orbits of all nodes are summed.
pub(super) fn classify(
    model: &Model,
    speed: f64,
    eigenvalue: Complex<f64>,
    shape: &DVector<Complex<f64>>,
    mass: &DMatrix<f64>,
    lateral: &[bool],
) -> Whirl {
    if eigenvalue == Complex::new(0.0, 0.0) {
        return Whirl::Rigid;
    }
    let bending = kinetic(model, mass, shape, lateral);
    let twist: Vec<bool> = lateral.iter().map(|lateral| !lateral).collect();
    let share = bending / (bending + kinetic(model, mass, shape, &twist));
    if share < MINOR {
        return Whirl::Torsion;
    }
    if share < 1.0 - MINOR {
        return Whirl::Coupled;
    }
    let (mut forward, mut backward) = (0.0, 0.0);
    for dof in model.numbering.dofs().iter().filter(|dof| dof.kind == DofKind::V) {
        let (v, w) = (shape[dof.index], shape[dof.index + 1]);
        let turned = w * Complex::i();
        let (with, against) = ((v + turned).norm_sqr(), (v - turned).norm_sqr());
        let spins_backward = model.shafts[dof.node.shaft].ratio * speed < 0.0;
        forward += if spins_backward { against } else { with };
        backward += if spins_backward { with } else { against };
    }
    if speed == 0.0 || eigenvalue.im == 0.0 || (forward - backward).abs() <= PLANAR * (forward + backward) {
        Whirl::Planar
    } else if forward > backward {
        Whirl::Forward
    } else {
        Whirl::Backward
    }
}
