//! Force of a shaft on a bearing as a nonlinear function of its motion, with the derivatives.

/// A vector over (y, z).
pub type Vector = [f64; 2];
/// A 2×2 matrix over (y, z), by rows.
pub type Matrix = [[f64; 2]; 2];

/// Force, stiffness and damping of a bearing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BearingForce {
    /// Force of the shaft on the bearing over (y, z), N.
    pub force: Vector,
    /// Stiffness ∂F/∂u, N/m.
    pub stiffness: Matrix,
    /// Damping ∂F/∂u̇, N s/m.
    pub damping: Matrix,
}

/// The reason why a bearing carries no static load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Uncarried {
    /// The journal touches the bearing.
    Touching,
    /// The search leaves this part of the load unbalanced.
    Unbalanced(f64),
}
