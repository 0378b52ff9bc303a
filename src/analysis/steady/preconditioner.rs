//! Approximate inverse of z − P(z) from the linear motion alone: (I − e^{AT})⁻¹, which is diagonal in modes.
//!
//! A rigid-body motion with the rate λ = 0 is no unknown: its position is kept, and its velocity follows from the
//! condition that the position returns after a period.

use nalgebra::{DMatrix, DVector};

use crate::analysis::AnalysisError;
use crate::modal::{ModalStateSpace, ModePair, StateMatrix};

/// Decay of a rigid-body motion within a period below which it is round-off.
pub const NO_DECAY: f64 = 1e-9;
/// Singular values of I − e^{AT} below this fraction of the largest belong to rigid-body motions.
const SINGULAR_FRACTION: f64 = 1e-8;

/// (I − e^{AT})⁻¹.
pub struct Preconditioner {
    form: Form,
    /// Entries of z that are no unknowns: positions of rigid-body motions.
    pub positions: Vec<usize>,
    /// Entries of z that are velocities of rigid-body motions without decay.
    pub velocities: Vec<usize>,
}

enum Form {
    /// 2 × 2 blocks, one for each slot.
    Blocks(Vec<[[f64; 2]; 2]>),
    /// The pseudo-inverse.
    Dense(DMatrix<f64>),
}

impl Preconditioner {
    /// Creates the preconditioner (I − e^{AT})⁻¹ for the period T = `period`, s.
    ///
    /// # Errors
    /// [`AnalysisError`] if a decomposition fails.
    pub fn new(linear: &ModalStateSpace, period: f64) -> Result<Self, AnalysisError> {
        let (mut positions, mut velocities) = (Vec::new(), Vec::new());
        let pairs = match &linear.matrix {
            StateMatrix::Pairs(pairs) => pairs,
            StateMatrix::Dense(matrix) => {
                let size = matrix.nrows();
                let defect = DMatrix::identity(size, size) - (matrix * period).exp();
                let tolerance = SINGULAR_FRACTION * defect.norm();
                let inverse = defect.pseudo_inverse(tolerance);
                let inverse = inverse.map_err(|message| AnalysisError::Convergence(message.to_owned()))?;
                return Ok(Self { form: Form::Dense(inverse), positions, velocities });
            }
        };
        let mut blocks = Vec::with_capacity(pairs.len());
        for (slot, pair) in pairs.iter().enumerate() {
            blocks.push(inverse_block(pair, period));
            if let ModePair::RigidBodyPair(rate) = pair {
                positions.push(slot);
                if (rate * period).abs() < NO_DECAY {
                    velocities.push(linear.slots + slot);
                }
            }
        }
        Ok(Self { form: Form::Blocks(blocks), positions, velocities })
    }

    /// The correction (I − e^{AT})⁻¹ r of a state z for the defect r = P(z) − z.
    pub fn correct(&self, defect: &[f64]) -> Vec<f64> {
        match &self.form {
            Form::Dense(inverse) => (inverse * DVector::from_column_slice(defect)).as_slice().to_vec(),
            Form::Blocks(blocks) => {
                let (x, y) = defect.split_at(blocks.len());
                let product = |row: usize| {
                    let entries = blocks.iter().zip(x.iter().zip(y));
                    entries.map(move |(block, (x, y))| block[row][0] * x + block[row][1] * y)
                };
                product(0).chain(product(1)).collect()
            }
        }
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
        ModePair::RigidBodyPair(rate) if (rate * period).abs() < NO_DECAY => [[0.0, 0.0], [-period.recip(), 0.0]],
        ModePair::RigidBodyPair(rate) => [[0.0, 0.0], [0.0, inverse(*rate)]],
    }
}
