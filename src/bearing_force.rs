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

/// A displacement of a bearing, and how well the force there balances a load.
#[derive(Clone, Copy, Debug)]
pub struct Balance {
    /// Displacement over (y, z), m.
    pub displacement: Vector,
    /// Force and its derivatives there.
    pub bearing: BearingForce,
    /// Norm of the unbalanced force over that of the load.
    pub residual: f64,
}

/// The search for the displacement at which a bearing carries a static load: Newton's method, with shorter steps where a step does
/// not reduce the residual.
pub struct BalanceSearch<'a> {
    /// The load over (y, z), N, not zero.
    pub load: Vector,
    /// Force of the bearing at a displacement, m.
    pub force: &'a dyn Fn(Vector) -> BearingForce,
    /// Stiffness that is added to the diagonal of the tangent at a residual relative to the load, N/m.
    pub added_stiffness: &'a dyn Fn(f64) -> f64,
    /// Whether a step may lead from the first displacement, m, to the second.
    pub is_permitted: &'a dyn Fn(Vector, Vector) -> bool,
}

impl BalanceSearch<'_> {
    /// The best displacement found from the displacement `start`, m.
    pub fn from(&self, start: Vector) -> Balance {
        let mut best = self.at(start);
        for _ in 0..MAX_ITERATIONS {
            if best.residual <= FORCE_TOLERANCE {
                break;
            }
            // Round-off limits the residual, or no load of this size is carried.
            let Some(next) = self.shortened(&best, self.step(&best)) else {
                break;
            };
            best = next;
        }
        best
    }

    fn at(&self, displacement: Vector) -> Balance {
        let bearing = (self.force)(displacement);
        let missing = self.missing(&bearing);
        let residual = missing[0].hypot(missing[1]) / self.load[0].hypot(self.load[1]);
        Balance { displacement, bearing, residual }
    }

    /// Part of the load that the force of the bearing leaves, N.
    fn missing(&self, bearing: &BearingForce) -> Vector {
        [self.load[0] - bearing.force[0], self.load[1] - bearing.force[1]]
    }

    /// Newton step from a displacement, m.
    fn step(&self, from: &Balance) -> Vector {
        let [y, z] = self.missing(&from.bearing);
        let added = (self.added_stiffness)(from.residual);
        let [[a, b], [c, d]] = from.bearing.stiffness;
        let (a, d) = (a + added, d + added);
        let determinant = a * d - b * c;
        [(d * y - b * z) / determinant, (a * z - c * y) / determinant]
    }

    /// The longest of the halved steps that is permitted and reduces the residual.
    fn shortened(&self, from: &Balance, step: Vector) -> Option<Balance> {
        let mut fraction = 1.0;
        while fraction >= MIN_FRACTION {
            let next = [0, 1].map(|axis| from.displacement[axis] + fraction * step[axis]);
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
