//! Force of a shaft on a bearing as a nonlinear function of its motion, with the derivatives, and the displacement at which it
//! carries a static load.

use nalgebra::{DMatrix, DVector};

/// A vector over (y, z).
pub type Vector = [f64; 2];
/// A 2×2 matrix over (y, z), by rows.
pub type Matrix = [[f64; 2]; 2];

/// Force, stiffness and damping of a bearing over `N` scalars of the displacements, by default those along (y, z).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BearingForce<const N: usize = 2> {
    /// Force of the shaft on the bearing, N.
    pub force: [f64; N],
    /// Stiffness ∂F/∂u, N/m.
    pub stiffness: [[f64; N]; N],
    /// Damping ∂F/∂u̇, N s/m.
    pub damping: [[f64; N]; N],
}

impl<const N: usize> Default for BearingForce<N> {
    fn default() -> Self {
        Self { force: [0.0; N], stiffness: [[0.0; N]; N], damping: [[0.0; N]; N] }
    }
}

/// The reason why a bearing carries no static load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Uncarried {
    /// The journal touches the bearing.
    Touching,
    /// The search leaves this part of the load unbalanced.
    Unbalanced(f64),
}

/// Largest number of Newton iterations, and of iterations for the wet nodes of a film; six to ten are usual.
pub(crate) const MAX_ITERATIONS: usize = 200;
/// Residual force, relative to the load or to the scale of the film, below which the iteration has converged.
pub(crate) const FORCE_TOLERANCE: f64 = 1e-13;
/// Largest unbalanced force, relative to the load, of an equilibrium: of a bearing, and of each shaft of a system.
pub(crate) const MAX_RESIDUAL: f64 = 1e-6;
/// Smallest fraction of a Newton step. With a smaller one, the residual changes by round-off only.
const MIN_FRACTION: f64 = 1e-10;

/// A displacement of a bearing, and how well the force there balances a load.
#[derive(Clone, Copy, Debug)]
pub struct Balance<const N: usize> {
    /// Displacement, m.
    pub displacement: [f64; N],
    /// Force and its derivatives there.
    pub bearing: BearingForce<N>,
    /// Norm of the unbalanced force over that of the load.
    pub residual: f64,
}

/// The search for the displacement at which a bearing carries a static load: Newton's method, with shorter steps where a step does
/// not reduce the residual.
pub struct BalanceSearch<'a, const N: usize> {
    /// The load, N, not zero.
    pub load: [f64; N],
    /// Force of the bearing at a displacement, m.
    pub force: &'a dyn Fn([f64; N]) -> BearingForce<N>,
    /// Stiffness that is added to the diagonal of the tangent at a residual relative to the load, N/m.
    pub added_stiffness: &'a dyn Fn(f64) -> f64,
    /// Whether a step may lead from the first displacement, m, to the second.
    pub is_permitted: &'a dyn Fn([f64; N], [f64; N]) -> bool,
}

/// Norm of a force, N.
fn norm<const N: usize>(force: [f64; N]) -> f64 {
    force.into_iter().fold(0.0, f64::hypot)
}

impl<const N: usize> BalanceSearch<'_, N> {
    /// The best displacement found from the displacement `start`, m.
    pub fn from(&self, start: [f64; N]) -> Balance<N> {
        let mut best = self.at(start);
        for _ in 0..MAX_ITERATIONS {
            if best.residual <= FORCE_TOLERANCE {
                break;
            }
            // Round-off limits the residual, or no load of this size is carried.
            let Some(next) = self.step(&best).and_then(|step| self.shortened(&best, step)) else {
                break;
            };
            best = next;
        }
        best
    }

    fn at(&self, displacement: [f64; N]) -> Balance<N> {
        let bearing = (self.force)(displacement);
        let residual = norm(self.missing(&bearing)) / norm(self.load);
        Balance { displacement, bearing, residual }
    }

    /// Part of the load that the force of the bearing leaves, N.
    fn missing(&self, bearing: &BearingForce<N>) -> [f64; N] {
        std::array::from_fn(|axis| self.load[axis] - bearing.force[axis])
    }

    /// Newton's step; none if the tangent is singular.
    fn step(&self, from: &Balance<N>) -> Option<[f64; N]> {
        let added = (self.added_stiffness)(from.residual) * DMatrix::<f64>::identity(N, N);
        let tangent = DMatrix::from_fn(N, N, |row, column| from.bearing.stiffness[row][column]) + added;
        let step = tangent.lu().solve(&DVector::from_column_slice(&self.missing(&from.bearing)))?;
        Some(std::array::from_fn(|axis| step[axis]))
    }

    /// The longest of the halved steps that is permitted and reduces the residual.
    fn shortened(&self, from: &Balance<N>, step: [f64; N]) -> Option<Balance<N>> {
        let mut fraction = 1.0;
        while fraction >= MIN_FRACTION {
            let next = std::array::from_fn(|axis| from.displacement[axis] + fraction * step[axis]);
            if (self.is_permitted)(from.displacement, next) {
                let found = self.at(next);
                if found.residual < from.residual {
                    return Some(found);
                }
            }
            fraction /= 2.0;
        }
        None
    }
}
