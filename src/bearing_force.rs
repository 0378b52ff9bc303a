//! Force of a shaft on a bearing as a nonlinear function of its motion, with the derivatives, and the displacement at which it
//! carries a static load.

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

/// Largest number of Newton iterations; ten are usual.
const MAX_ITERATIONS: usize = 200;
/// Residual force, relative to the load, below which the iteration has converged.
const FORCE_TOLERANCE: f64 = 1e-13;
/// Smallest fraction of a Newton step. With a smaller one, the residual changes by round-off only.
const MIN_FRACTION: f64 = 1e-10;

/// Force of the shaft on a bearing over the `N` displacements of a [`BalanceSearch`].
pub trait LoadedForce<const N: usize> {
    /// Force, N.
    fn force(&self) -> [f64; N];
    /// Newton step, m, for the `missing` force, N, with the stiffness `added` to the diagonal of the tangent, N/m; none if the
    /// tangent is singular.
    fn step(&self, missing: [f64; N], added: f64) -> Option<[f64; N]>;
}

impl LoadedForce<2> for BearingForce {
    fn force(&self) -> Vector {
        self.force
    }

    fn step(&self, [y, z]: Vector, added: f64) -> Option<Vector> {
        let [[a, b], [c, d]] = self.stiffness;
        let (a, d) = (a + added, d + added);
        let determinant = a * d - b * c;
        Some([(d * y - b * z) / determinant, (a * z - c * y) / determinant])
    }
}

/// A displacement of a bearing, and how well the force there balances a load.
#[derive(Clone, Debug)]
pub struct Balance<F, const N: usize> {
    /// Displacement, m.
    pub displacement: [f64; N],
    /// Force and its derivatives there.
    pub bearing: F,
    /// Norm of the unbalanced force over that of the load.
    pub residual: f64,
}

/// The search for the displacement at which a bearing carries a static load: Newton's method, with shorter steps where a step does
/// not reduce the residual.
pub struct BalanceSearch<'a, F, const N: usize> {
    /// The load, N, not zero.
    pub load: [f64; N],
    /// Force of the bearing at a displacement, m.
    pub force: &'a dyn Fn([f64; N]) -> F,
    /// Stiffness that is added to the diagonal of the tangent at a residual relative to the load, N/m.
    pub added_stiffness: &'a dyn Fn(f64) -> f64,
    /// Whether a step may lead from the first displacement, m, to the second.
    pub is_permitted: &'a dyn Fn([f64; N], [f64; N]) -> bool,
}

/// Norm of a force, N.
fn norm<const N: usize>(force: [f64; N]) -> f64 {
    force.into_iter().fold(0.0, f64::hypot)
}

impl<F: LoadedForce<N>, const N: usize> BalanceSearch<'_, F, N> {
    /// The best displacement found from the displacement `start`, m.
    pub fn from(&self, start: [f64; N]) -> Balance<F, N> {
        let mut best = self.at(start);
        for _ in 0..MAX_ITERATIONS {
            if best.residual <= FORCE_TOLERANCE {
                break;
            }
            // Round-off limits the residual, or no load of this size is carried.
            let step = best.bearing.step(self.missing(&best.bearing), (self.added_stiffness)(best.residual));
            let Some(next) = step.and_then(|step| self.shortened(&best, step)) else {
                break;
            };
            best = next;
        }
        best
    }

    fn at(&self, displacement: [f64; N]) -> Balance<F, N> {
        let bearing = (self.force)(displacement);
        let residual = norm(self.missing(&bearing)) / norm(self.load);
        Balance { displacement, bearing, residual }
    }

    /// Part of the load that the force of the bearing leaves, N.
    fn missing(&self, bearing: &F) -> [f64; N] {
        let force = bearing.force();
        std::array::from_fn(|axis| self.load[axis] - force[axis])
    }

    /// The longest of the halved steps that is permitted and reduces the residual.
    fn shortened(&self, from: &Balance<F, N>, step: [f64; N]) -> Option<Balance<F, N>> {
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
