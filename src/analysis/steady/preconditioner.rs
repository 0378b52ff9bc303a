//! Approximate inverse of z − P(z) from the linear motion alone: (I − e^{AT})⁻¹, which is diagonal in modes.
//!
//! A rigid-body motion with the rate λ = 0 is no unknown: its position is kept, and its velocity follows from the
//! condition that the position returns after a period.

use crate::modal::{ModalStateSpace, ModePair};
use crate::numerics::EQUALITY_TOLERANCE;

/// (I − e^{AT})⁻¹.
pub struct Preconditioner {
    /// 2 × 2 blocks, one for each slot.
    blocks: Vec<[[f64; 2]; 2]>,
    /// Entries of z that are no unknowns: positions of rigid-body motions.
    pub positions: Vec<usize>,
    /// Entries of z that are velocities of rigid-body motions without decay.
    pub velocities: Vec<usize>,
}

impl Preconditioner {
    /// Creates the preconditioner (I − e^{AT})⁻¹ for the period T = `period`, s.
    pub fn new(linear: &ModalStateSpace, period: f64) -> Self {
        let (mut positions, mut velocities) = (Vec::new(), Vec::new());
        let pairs = linear.pairs();
        let mut blocks = Vec::with_capacity(pairs.len());
        for (slot, pair) in pairs.iter().enumerate() {
            blocks.push(inverse_block(pair, period));
            if let ModePair::RigidBodyPair(rate) = pair {
                positions.push(slot);
                // A smaller decay within a period is round-off.
                if (rate * period).abs() < EQUALITY_TOLERANCE {
                    velocities.push(linear.slots + slot);
                }
            }
        }
        Self { blocks, positions, velocities }
    }

    /// The correction (I − e^{AT})⁻¹ r of a state z for the defect r = P(z) − z.
    pub fn correct(&self, defect: &[f64]) -> Vec<f64> {
        let (x, y) = defect.split_at(self.blocks.len());
        let product = |row: usize| {
            let entries = self.blocks.iter().zip(x.iter().zip(y));
            entries.map(move |(block, (x, y))| block[row][0] * x + block[row][1] * y)
        };
        product(0).chain(product(1)).collect()
    }

    /// Entries of z that no multiplier belongs to: rigid-body motions without decay.
    pub fn is_rigid(&self, entry: usize) -> bool {
        self.positions.contains(&entry) || self.velocities.contains(&entry)
    }
}

/// (I − e^{Bt})⁻¹ of the block B of a pair. The remainder of a motion without decay is zero.
fn inverse_block(pair: &ModePair, period: f64) -> [[f64; 2]; 2] {
    let inverse = |rate: f64| {
        let part = -(rate * period).exp_m1();
        if part == 0.0 { 0.0 } else { part.recip() }
    };
    match pair {
        ModePair::Oscillation(value) => {
            let (decay, (sin, cos)) = ((value.re * period).exp(), (value.im * period).sin_cos());
            // I − e^{Bt} = [[a, −b], [b, a]].
            let (a, b) = (1.0 - decay * cos, decay * sin);
            let determinant = a * a + b * b;
            if determinant == 0.0 {
                return [[0.0; 2]; 2];
            }
            [[a / determinant, b / determinant], [-b / determinant, a / determinant]]
        }
        ModePair::Real([first, second]) => [[inverse(*first), 0.0], [0.0, inverse(*second)]],
        // The position after a period changes by the velocity times the period.
        ModePair::RigidBodyPair(rate) if (rate * period).abs() < EQUALITY_TOLERANCE => {
            [[0.0, 0.0], [-period.recip(), 0.0]]
        }
        ModePair::RigidBodyPair(rate) => [[0.0, 0.0], [0.0, inverse(*rate)]],
    }
}
